// Assimp: GenSmoothNormals as a step after reading (equal positions share, faces weigh by area).
#include "rival.hpp"
#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

using namespace rival;

static std::string write_ply(const Mesh &mesh) {
    const std::string path = std::string(std::getenv("TMPDIR") ? std::getenv("TMPDIR") : "/tmp") +
                             "/norma-bench-assimp.ply";
    FILE *file = std::fopen(path.c_str(), "wb");
    if (!file) std::exit(3);
    std::fprintf(file,
        "ply\nformat binary_little_endian 1.0\nelement vertex %zu\nproperty float x\nproperty "
        "float y\nproperty float z\nelement face %zu\n"
        "property list uchar int vertex_indices\nend_header\n",
        mesh.vertex_count(), mesh.triangle_count());
    std::fwrite(mesh.positions.data(), 12, mesh.vertex_count(), file);
    for (size_t t = 0; t < mesh.triangles.size(); t += 3) {
        std::fputc(3, file);
        std::fwrite(&mesh.triangles[t], 4, 3, file);
    }
    std::fclose(file);
    return path;
}

int main(int count, char **arguments) {
    const Mesh mesh =
        make(std::min<size_t>(asked_triangles(count, arguments, 2000000), 500000), false);
    const double copy = copy_seconds(12 * mesh.triangle_count(), 29);
    const std::string path = write_ply(mesh);
    Assimp::Importer importer;
    const double seconds = least(
        3, [&] { importer.ReadFile(path, 0); },
        [&] { importer.ApplyPostProcessing(aiProcess_GenSmoothNormals); });
    print(
        "Assimp", "GenSmoothNormals", "area", mesh.shape, mesh.triangle_count(), seconds, copy, -1);
    std::remove(path.c_str());
    return 0;
}
