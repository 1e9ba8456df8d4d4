// Norma itself, in the same form as the others.
#include "rival.hpp"

using namespace rival;

static void vertices(const Mesh &mesh, const norma_mesh &view, norma_weight weight, norma_weld weld,
    uint32_t threads, double copy) {
    std::vector<float> normals(mesh.positions.size());
    norma_options options = {};
    options.weight = weight;
    options.weld = weld;
    options.threads = threads;
    const double seconds = least(
        5, [] {},
        [&] {
            norma_vertex_normals(&view, &options, normals.data(), mesh.vertex_count(), nullptr);
        });
    const double off =
        largest_angle(reference(mesh, weight == NORMA_WEIGHT_AREA ? Weight::area : Weight::angle),
            [&](size_t v, int k) { return double(normals[3 * v + size_t(k)]); });
    const std::string call =
        std::string(weld == NORMA_WELD_NONE ? "vertex normals, by index"
                                            : "vertex normals, equal positions share") +
        (threads > 1 ? ", 2 threads" : "");
    print("Norma", call.c_str(), weight == NORMA_WEIGHT_AREA ? "area" : "angle", mesh.shape,
        mesh.triangle_count(), seconds, copy, off);
}

// What is known of the mesh beforehand left out of the time: a plan, for meshes that move.
static void planned(
    const Mesh &mesh, const norma_mesh &view, norma_weight weight, uint32_t threads, double copy) {
    std::vector<float> normals(mesh.positions.size());
    norma_options options = {};
    options.weight = weight;
    options.threads = threads;
    norma_plan *plan = nullptr;
    if (norma_plan_create(&view, NORMA_PER_VERTEX, 1.0471976f, &options, &plan)) return;
    const double seconds = least(
        9, [] {},
        [&] {
            norma_plan_update(plan, view.positions, nullptr, 0, &options, normals.data(),
                mesh.vertex_count(), nullptr);
        });
    norma_plan_destroy(plan);
    const double off =
        largest_angle(reference(mesh, weight == NORMA_WEIGHT_AREA ? Weight::area : Weight::angle),
            [&](size_t v, int k) { return double(normals[3 * v + size_t(k)]); });
    print("Norma",
        threads > 1 ? "a plan updated, all moved, 2 threads" : "a plan updated, all moved",
        weight == NORMA_WEIGHT_AREA ? "area" : "angle", mesh.shape, mesh.triangle_count(), seconds,
        copy, off);
}

int main(int count, char **arguments) {
    for (bool shuffled : {false, true}) {
        const Mesh mesh = make(asked_triangles(count, arguments, 2000000), shuffled);
        const double copy = copy_seconds(12 * mesh.triangle_count());
        norma_mesh view = {};
        view.positions = {mesh.positions.data(), mesh.vertex_count(), 0, NORMA_FORMAT_FLOAT};
        view.corners = mesh.triangles.data();
        view.corner_count = mesh.triangles.size();
        for (uint32_t threads = 1; threads <= bench_threads(); ++threads) {
            vertices(mesh, view, NORMA_WEIGHT_AREA, NORMA_WELD_NONE, threads, copy);
            vertices(mesh, view, NORMA_WEIGHT_ANGLE, NORMA_WELD_NONE, threads, copy);
            vertices(mesh, view, NORMA_WEIGHT_ANGLE, NORMA_WELD_EXACT, threads, copy);
            planned(mesh, view, NORMA_WEIGHT_AREA, threads, copy);
            planned(mesh, view, NORMA_WEIGHT_ANGLE, threads, copy);
            std::vector<float> normals(3 * mesh.triangles.size());
            norma_options options = {};
            options.threads = threads;
            const double seconds = least(
                5, [] {},
                [&] {
                    norma_corner_normals(&view, 1.0471976f, &options, normals.data(),
                        mesh.triangles.size(), nullptr);
                });
            print("Norma",
                threads > 1 ? "corner normals, crease 60, 2 threads" : "corner normals, crease 60",
                "angle", mesh.shape, mesh.triangle_count(), seconds, copy, -1);
        }
    }
    return 0;
}
