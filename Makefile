# A thin cover over CMake and scripts/. `make help` lists the targets.
BUILD ?= build
PREFIX ?= /usr/local
CMAKE_FLAGS ?=
V ?= 0
export BUILD PREFIX CMAKE_FLAGS V DESTDIR

.PHONY: all help deps demo engines farms figures fuzz judges marks firefox dist mpi web test test-all coverage bench asan tsan format lint analyse portable deb install single python python-fuzz blender clean
.DEFAULT_GOAL := all

# If packages cannot be installed (another system, neither root nor sudo), the script names them, and the build does without those that are optional.
all:
	@scripts/install-deps.sh build || true
	@scripts/build.sh

help:
	@echo "make           installs what building needs, then builds the tool, $(BUILD)/bin/norma, and the libraries in $(BUILD)/lib; V=1 shows every command"
	@echo "make demo      builds, computes the normals of a mesh, explains a matrix and draws a picture"
	@echo "make install   builds and installs into PREFIX ($(PREFIX)), below DESTDIR if that is set"
	@echo "make web       builds the npm package, $(BUILD)/web/npm, and the page, $(BUILD)/web/norma.html, which norma view writes; later builds keep them up to date"
	@echo "make python    builds the Python wheel, $(BUILD)/python/*.whl, installs it into a bare environment and tests it there"
	@echo "make blender   builds the Blender add-on, $(BUILD)/blender/*.zip, installs Blender if it is missing, and tests the add-on in it without a window"
	@echo "make python-fuzz   calls the Python package with random arguments under the address sanitizer for MINUTES (15)"
	@echo "make single    writes the core as two files to copy: $(BUILD)/single/norma.c and norma.h"
	@echo "make dist      builds what a release consists of into $(BUILD)/dist: source, tools for Linux, npm package, wheel, Blender add-on, single file, checksums"
	@echo "make deb       builds Debian packages into $(BUILD)/deb and checks them with lintian"
	@echo
	@echo "make test      installs what is missing, then runs what each change must pass (two compilers, sanitizers, README; five to seven minutes on two idle cores)"
	@echo "make test-all  also the rest: page, npm package, Python, MPI, data set, faults, install, fuzzing (some 35 minutes together); what make test has run is not run again"
	@echo "make asan      runs the tests with the address and undefined-behaviour sanitizers only (clang)"
	@echo "make tsan      runs the tests that use threads with the thread sanitizer only (clang)"
	@echo "make fuzz      runs every fuzz target for MINUTES (15) of processor time (clang)"
	@echo "make judges    fixes every file of the data set by each rule and has the results judged by admesh, the glTF validator and a reader of our own"
	@echo "make marks     presses every error and warning of the data set's large files in the page, and counts what is marked in the picture (some minutes)"
	@echo "make firefox   installs Firefox and Xvfb if they are missing, and runs the page's tests in it (several minutes)"
	@echo "make engines   installs engines that read glTF (npm and Debian, a gigabyte), draws the acid scene with each and writes docs/engines.md; ENGINES=... for some"
	@echo "make farms     installs GNU parallel, Snakemake, Dask and Slurm, and runs the recipes of examples/farm on local clusters (a minute)"
	@echo "make mpi       installs Open MPI and MPICH, builds libnorma-mpi and norma-mpi with each, and tests them on 1 to 16 ranks"
	@echo "make coverage  shows which lines and branches of core and io the tests run (gcov)"
	@echo "make portable  checks that results have the same bits with other compilers, as WebAssembly, on 64-bit ARM (qemu) and Windows (Wine)"
	@echo "make bench     measures Norma against memcpy and other libraries, which it installs (more than a gigabyte); ten minutes"
	@echo
	@echo "make format    formats all C and C++ files with clang-format; scripts/format.sh --check changes nothing"
	@echo "make lint      runs clang-tidy, shellcheck and mandoc -T lint, if they are installed"
	@echo "make analyse   runs clang-tidy with .clang-tidy and gcc -fanalyzer; known false alarms are listed in scripts/analysed.txt"
	@echo "make figures   draws the figures of the guide and the README again, into docs/figures"
	@echo "make deps      installs what is missing (Debian and npm packages) and does nothing else"
	@echo "make clean     removes $(BUILD)"

deps:
	@scripts/install-deps.sh

demo:
	@scripts/install-deps.sh web || true
	@$(MAKE) --no-print-directory all CMAKE_FLAGS="$(CMAKE_FLAGS) -DNORMA_WEB=AUTO -DNORMA_EXAMPLES=ON"
	@scripts/demo.sh

# What could not be installed is reported, and the tests that need it are skipped or fail with a reason.
test:
	@scripts/install-deps.sh test || true
	@tests/run.sh

test-all:
	@scripts/install-deps.sh || true
	@tests/run.sh all

asan:
	@scripts/install-deps.sh test || true
	@tests/run.sh clang fuzz clang-long

tsan:
	@scripts/install-deps.sh test || true
	@tests/run.sh tsan tsan-long

coverage:
	@scripts/coverage.sh

bench:
	@scripts/bench.sh

web:
	@scripts/install-deps.sh web
	@$(MAKE) --no-print-directory all CMAKE_FLAGS="$(CMAKE_FLAGS) -DNORMA_WEB=ON"
	@echo "$(BUILD)/web/norma.html, $(BUILD)/web/npm"

MINUTES ?= 15
fuzz: deps
	@scripts/fuzz.sh run $(MINUTES)

ENGINES ?=
engines: all
	@scripts/install-deps.sh engines
	@NORMA_BIN=$(abspath $(BUILD))/bin/norma tests/engines/run.sh $(ENGINES)

farms: all
	@scripts/install-deps.sh farms
	@NORMA_TREE=$(abspath $(BUILD)) NORMA_BIN=$(abspath $(BUILD))/bin/norma tests/cli/farm.sh

figures: all
	@NORMA_BIN=$(BUILD)/bin/norma scripts/figures.sh

python:
	@scripts/install-deps.sh python
	@tests/python/wheel.sh
	@ls build/python/*.whl

blender: all
	@scripts/install-deps.sh blender
	@NORMA_TREE=$(abspath $(BUILD)) NORMA_BIN=$(abspath $(BUILD))/bin/norma tests/blender/blender.sh
	@ls build/blender/*.zip

# The extension and the library with gcc's address sanitizer, in an interpreter that preloads it.
python-fuzz:
	@scripts/install-deps.sh python
	@scripts/python.sh sanitize
	@rm -rf build/python-asan/venv && /usr/bin/python3 -m venv --system-site-packages build/python-asan/venv
	@build/python-asan/venv/bin/pip install --quiet --no-index --no-deps build/python-asan/*.whl
	@LD_PRELOAD=$$(gcc -print-file-name=libasan.so) ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1 PYTHONMALLOC=malloc build/python-asan/venv/bin/python -W ignore tests/python/fuzz_arguments.py $$((60 * $(MINUTES)))

single:
	@scripts/single.sh $(BUILD)/single

format:
	@scripts/format.sh

lint:
	@scripts/lint.sh

judges:
	@scripts/install-deps.sh || true
	@$(MAKE) --no-print-directory all
	@NORMA_TREE=$(abspath $(BUILD)) tests/cli/judges.sh --all

marks: web
	@NORMA_TREE=$(abspath $(BUILD)) tests/web/marks.sh --all

firefox: web
	@scripts/install-deps.sh firefox
	@NORMA_TREE=$(abspath $(BUILD)) tests/web/page.sh --firefox

mpi:
	@scripts/install-deps.sh mpi
	@NORMA_MPI_LONG=1 tests/mpi/mpi.sh

analyse:
	@scripts/install-deps.sh analyse
	@scripts/analyse.sh

portable:
	@scripts/install-deps.sh portable
	@scripts/portable.sh

deb:
	@scripts/install-deps.sh deb
	@scripts/deb.sh

dist:
	@scripts/install-deps.sh build
	@scripts/install-deps.sh web
	@scripts/install-deps.sh python
	@scripts/dist.sh

install: all
	@scripts/install.sh

clean:
	rm -rf $(BUILD)
