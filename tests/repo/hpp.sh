#!/bin/bash
# norma.hpp: compiles without warnings as C++17 and C++20 with both compilers, gives what the C calls give (norma_hpp.cpp, under sanitizers), refuses at compile time what cannot
# be meant, and its example prints what is expected.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1

warnings="-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wold-style-cast -Werror"
library="$tree/lib/libnorma-core.a -lm -pthread"
for compiler in g++ clang++; do
    # shellcheck disable=SC2086  # lists of words
    check "$compiler, C++17, under sanitizers" $compiler -std=c++17 -g1 -fsanitize=address,undefined -Iinclude $warnings tests/repo/norma_hpp.cpp -o "$scratch/$compiler" $library
    check "$compiler: it gives what C gives" "$scratch/$compiler"
    # shellcheck disable=SC2086
    check "$compiler, C++20" $compiler -std=c++20 -fsyntax-only -Iinclude $warnings tests/repo/norma_hpp.cpp
    # shellcheck disable=SC2086
    check "$compiler: the example" $compiler -std=c++17 -Iinclude $warnings examples/cpp_mesh.cpp -o "$scratch/example" $library
    check "$compiler: the example prints what is expected" cmp <("$scratch/example") tests/repo/examples/cpp_mesh.txt
done

# refused NAME STATEMENT TEXT: the statement does not compile, and the compiler says why.
refused() {
    printf '#include <norma/norma.hpp>\nint main() { %s }\n' "$2" >"$scratch/refused.cpp"
    check "does not compile: $1" bash -c '! g++ -std=c++17 -fsyntax-only -Iinclude "$0" 2>"$0.told" && grep -qF "$1" "$0.told"' "$scratch/refused.cpp" "$3"
}
refused "corners of 64 bits" 'std::vector<float> p; std::vector<std::uint64_t> c; norma::Mesh(p, c);' "corners are unsigned integers of 8, 16 or 32 bits"
refused "positions of two numbers" 'std::vector<std::array<float, 2>> p; norma::Mesh{p};' "vectors have too few components"
refused "positions of 32-bit integers" 'std::vector<int> p; norma::Mesh{p};' "components are float, double, or integers of 8 or 16 bits"
refused "a model of nine floats" 'float m[9] = {}; norma::normal_matrix(m);' "a model has sixteen floats"
refused "a model of doubles" 'std::array<double, 8> m{}; norma::normal_matrix(m);' "of floats"
finish
