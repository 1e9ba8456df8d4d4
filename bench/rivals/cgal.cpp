// CGAL: vertex normals of a surface mesh in double precision, each the centre of the smallest cone
// round the faces' (Aubry, Loehner 2008).
#include "rival.hpp"
#include <CGAL/Polygon_mesh_processing/compute_normal.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>

using namespace rival;
using Kernel = CGAL::Simple_cartesian<double>;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

int main(int count, char **arguments) {
    const Mesh mesh =
        make(std::min<size_t>(asked_triangles(count, arguments, 2000000), 200000), false);
    const double copy = copy_seconds(12 * mesh.triangle_count(), 99);
    Surface their;
    std::vector<Surface::Vertex_index> handles;
    for (size_t v = 0; v < mesh.vertex_count(); ++v)
        handles.push_back(their.add_vertex(Kernel::Point_3(
            mesh.positions[3 * v], mesh.positions[3 * v + 1], mesh.positions[3 * v + 2])));
    for (size_t t = 0; t < mesh.triangles.size(); t += 3)
        their.add_face(handles[mesh.triangles[t]], handles[mesh.triangles[t + 1]],
            handles[mesh.triangles[t + 2]]);
    auto normals = their
                       .add_property_map<Surface::Vertex_index, Kernel::Vector_3>(
                           "v:normal", CGAL::NULL_VECTOR)
                       .first;
    const double seconds = least(
        3, [] {}, [&] { CGAL::Polygon_mesh_processing::compute_vertex_normals(their, normals); });
    print("CGAL", "compute_vertex_normals", "most visible", mesh.shape, mesh.triangle_count(),
        seconds, copy, -1);
    return 0;
}
