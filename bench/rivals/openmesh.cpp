// OpenMesh: face normals, then their plain average at each vertex.
#include "rival.hpp"
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

using namespace rival;

int main(int count, char **arguments) {
    for (bool shuffled : {false, true}) {
        const Mesh mesh = make(asked_triangles(count, arguments, 2000000), shuffled);
        const double copy = copy_seconds(12 * mesh.triangle_count());
        OpenMesh::TriMesh_ArrayKernelT<> their;
        std::vector<OpenMesh::VertexHandle> handles;
        for (size_t v = 0; v < mesh.vertex_count(); ++v)
            handles.push_back(their.add_vertex(
                {mesh.positions[3 * v], mesh.positions[3 * v + 1], mesh.positions[3 * v + 2]}));
        for (size_t t = 0; t < mesh.triangles.size(); t += 3)
            their.add_face(handles[mesh.triangles[t]], handles[mesh.triangles[t + 1]],
                handles[mesh.triangles[t + 2]]);
        their.request_face_normals();
        their.request_vertex_normals();
        const double seconds = least(
            5, [] {}, [&] { their.update_normals(); });
        const double off = largest_angle(reference(mesh, Weight::uniform),
            [&](size_t v, int k) { return double(their.normal(handles[v])[size_t(k)]); });
        print("OpenMesh", "update_normals", "uniform", mesh.shape, mesh.triangle_count(), seconds,
            copy, off);
    }
    return 0;
}
