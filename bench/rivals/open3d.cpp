// Open3D: vertex normals of a TriangleMesh (doubles).
#include "rival.hpp"
#include <open3d/geometry/TriangleMesh.h>

using namespace rival;

int main(int count, char **arguments) {
    for (bool shuffled : {false, true}) {
        const Mesh mesh = make(asked_triangles(count, arguments, 2000000), shuffled);
        const double copy = copy_seconds(12 * mesh.triangle_count());
        open3d::geometry::TriangleMesh their;
        for (size_t v = 0; v < mesh.vertex_count(); ++v)
            their.vertices_.emplace_back(
                mesh.positions[3 * v], mesh.positions[3 * v + 1], mesh.positions[3 * v + 2]);
        for (size_t t = 0; t < mesh.triangles.size(); t += 3)
            their.triangles_.emplace_back(
                int(mesh.triangles[t]), int(mesh.triangles[t + 1]), int(mesh.triangles[t + 2]));
        const double seconds = least(
            5,
            [&] {
                their.vertex_normals_.clear();
                their.triangle_normals_.clear();
            },
            [&] { their.ComputeVertexNormals(); });
        const double off = largest_angle(reference(mesh, Weight::area),
            [&](size_t v, int k) { return their.vertex_normals_[v][k]; });
        print("Open3D", "ComputeVertexNormals", "area", mesh.shape, mesh.triangle_count(), seconds,
            copy, off);
    }
    return 0;
}
