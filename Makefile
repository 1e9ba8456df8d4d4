# A thin cover over CMake with Ninja. `make help` lists the targets.
BUILD ?= build
PREFIX ?= /usr/local
CMAKE_FLAGS ?=

.PHONY: all help deps demo figures fuzz web test coverage bench asan tsan format lint analyse portable install single clean
.DEFAULT_GOAL := all

# Where packages cannot be installed (another system, neither root nor sudo) the script says which, and CMake tells whether they are there all the same.
all:
	@scripts/install-deps.sh build || true
	@scripts/install-deps.sh web || true
	@command -v cmake >/dev/null && command -v ninja >/dev/null || { echo "cmake and ninja are needed"; exit 1; }
	@mkdir -p $(BUILD)
	@cmake -S . -B $(BUILD) -G Ninja -DCMAKE_BUILD_TYPE=Release -DNORMA_TESTS=OFF -DNORMA_WEB=AUTO $(CMAKE_FLAGS) >$(BUILD)/configure.log || { cat $(BUILD)/configure.log; exit 1; }
	@cmake --build $(BUILD)

help:
	@echo "make          installs what building needs, then the optimised tool, $(BUILD)/bin/norma, and the libraries, $(BUILD)/lib/"
	@echo "make demo     installs what is missing, builds, computes the normals of a real mesh, draws a picture"
	@echo "make test     installs what is missing, then the whole test suite (two compilers, sanitizers, install, examples, README)"
	@echo "make asan     the tests under the address and undefined-behaviour sanitizers only (clang)"
	@echo "make tsan     the tests that use threads under the thread sanitizer only (clang)"
	@echo "make coverage which lines and branches of core and io the tests run (gcov)"
	@echo "make fuzz     MINUTES=15: every fuzz target for so many minutes of processor time each, on the cores there are (clang)"
	@echo "make bench    Norma beside memcpy and beside other libraries, which it installs (more than a gigabyte); about ten minutes"
	@echo "make web      the npm package, $(BUILD)/web/npm, and the page, $(BUILD)/web/norma.html"
	@echo "make figures  draws the figures of the guide and of the README into docs/figures again"
	@echo "make single   $(BUILD)/single/norma.c and norma.h: the core as two files to copy"
	@echo "make format   clang-format over src/check, src/cli and src/render"
	@echo "make lint     clang-tidy, shellcheck and mandoc -T lint, whichever are installed"
	@echo "make analyse  clang-tidy with .clang-tidy and gcc -fanalyzer; what is no fault stands in scripts/analysed.txt"
	@echo "make portable the same bits from gcc and clang at every level, WebAssembly, 64-bit ARM (qemu) and Windows (Wine); installs them"
	@echo "make install  into PREFIX ($(PREFIX)); DESTDIR is heeded"
	@echo "make deps     installs what is missing, nothing else (Debian's packages and npm's)"
	@echo "make clean    removes $(BUILD)"

deps:
	@scripts/install-deps.sh

demo:
	@$(MAKE) --no-print-directory all
	@BUILD=$(BUILD) scripts/demo.sh

test: deps
	@tests/run.sh

asan: deps
	@tests/run.sh asan

tsan: deps
	@tests/run.sh tsan

coverage:
	@scripts/coverage.sh

bench:
	@scripts/bench.sh

# The page and the npm package are part of a plain make, wherever what they need is there; this says so where it is not.
web:
	@scripts/install-deps.sh web
	@$(MAKE) --no-print-directory all CMAKE_FLAGS="$(CMAKE_FLAGS) -DNORMA_WEB=ON"
	@echo "$(BUILD)/web/norma.html, $(BUILD)/web/npm"

MINUTES ?= 15
fuzz: deps
	@scripts/fuzz.sh run $(MINUTES)

figures: all
	@NORMA_BIN=$(BUILD)/bin/norma scripts/figures.sh

single:
	@scripts/single.sh $(BUILD)/single

format:
	@scripts/format.sh

lint:
	@scripts/lint.sh

analyse:
	@scripts/install-deps.sh analyse
	@scripts/analyse.sh

portable:
	@scripts/install-deps.sh portable
	@scripts/portable.sh

install: all
	@cmake --install $(BUILD) --prefix $(PREFIX)

clean:
	rm -rf $(BUILD)
