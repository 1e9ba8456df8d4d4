// The header norma.hpp: normals, an indexed mesh and tangents of a cube out of C++ containers, and
// what an error says.
#include <norma/norma.hpp>

#include <cstdio>

namespace {

struct Vertex {
    float x, y, z, u, v;
};

constexpr float crease = 0.5f; // radians

} // namespace

int main() {
    const std::vector<std::array<double, 3>> positions = {
        {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    const std::vector<std::uint16_t> corners = {
        0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 2, 3, 7, 6, 0, 4, 7, 3, 1, 2, 6, 5};
    const std::vector<std::uint32_t> faces = {0, 4, 8, 12, 16, 20, 24};
    const norma::Mesh cube = norma::Mesh(positions, corners).faces(faces);

    norma::Options options;
    options.weight = norma::Weight::area;
    options.threads = NORMA_ALL_THREADS;
    const norma::Vec3 n = norma::vertex_normals(cube, options)[6];
    std::printf("vertex 6: %.6f %.6f %.6f\n", double(n[0]), double(n[1]), double(n[2]));

    const norma::Split split = norma::split(cube, crease);
    std::printf("%zu vertices, %zu after creases of %g rad\n", positions.size(),
        split.normals.size(), double(crease));

    const Vertex square[] = {{0, 0, 0, 0, 0}, {1, 0, 0, 1, 0}, {1, 1, 0, 1, 1}, {0, 1, 0, 0, 1}};
    const std::vector<std::array<float, 2>> texcoords = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 1, 2}, {0, 2, 3}};
    const norma::Texcoords uv(texcoords);
    const norma::Built built =
        norma::build(norma::Mesh(square, triangles), &uv, crease, norma::TangentMode::mikk);
    for (std::size_t i = 0; i < built.normals.size(); ++i)
        std::printf("normal %g %g %g, tangent %g %g %g %g\n", double(built.normals[i][0]),
            double(built.normals[i][1]), double(built.normals[i][2]), double(built.tangents[i][0]),
            double(built.tangents[i][1]), double(built.tangents[i][2]),
            double(built.tangents[i][3]));

    const float stretched[16] = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const norma::Matrix3 normal_matrix = norma::normal_matrix(stretched);
    std::printf("normal matrix: diagonal %g %g %g\n", double(normal_matrix[0]),
        double(normal_matrix[4]), double(normal_matrix[8]));

    try {
        norma::vertex_normals(norma::Mesh(positions, std::vector<std::uint32_t>{0, 1, 8}));
    } catch (const norma::Error &error) {
        std::printf("%s\n", error.what());
    }
    return 0;
}
