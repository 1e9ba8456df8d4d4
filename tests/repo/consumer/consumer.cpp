// consumer.cpp: a program in C++17 that uses the installed library, core and documents.
#include <norma/document.h>
#include <norma/norma.h>

#include <cmath>
#include <iostream>
#include <vector>

int main() {
    const std::vector<float> positions{0, 0, 0, 1, 0, 0, 0, 1, 0};
    norma_mesh mesh{};
    mesh.positions.data = positions.data();
    mesh.positions.count = positions.size() / 3;
    mesh.corner_count = 3;
    std::vector<float> normals(9);
    if (norma_vertex_normals(&mesh, nullptr, normals.data(), 3, nullptr)) return 1;
    if (std::abs(normals[2] - 1.0F) > 0.0F) return 2;
    if (norma_file_format_of_path("a/b.GLB") != NORMA_FILE_GLB) return 3;
    std::cout << "norma " << norma_version() << " from C++\n";
    return 0;
}
