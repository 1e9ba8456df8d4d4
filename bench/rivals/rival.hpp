// rival.hpp: what every program of this folder shares: the same meshes as Norma's own benchmark,
// least times, a reference in double precision, one line of a table for each call.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <string>
#include <sys/resource.h>
#include <vector>
extern "C" {
#include "../made_meshes.h"
#include "../timing.h"
}

namespace rival {

enum class Weight { area, angle, uniform, none };

struct Mesh {
    std::vector<float> positions;
    std::vector<uint32_t> triangles;
    std::string shape;
    size_t triangle_count() const { return triangles.size() / 3; }
    size_t vertex_count() const { return positions.size() / 3; }
};

inline Mesh make(size_t triangles, bool shuffled) {
    made_mesh made = made_grid(triangles);
    if (shuffled) made_shuffle(&made);
    Mesh mesh;
    mesh.positions.assign(&made.positions[0][0], &made.positions[0][0] + 3 * made.position_count);
    mesh.triangles.assign(made.corners, made.corners + made.corner_count);
    mesh.shape = shuffled ? "shuffled" : "rows";
    made_free(&made);
    return mesh;
}

// Seconds: the least of so many runs, or of those that half a second holds; prepare is not timed.
inline double least(
    int runs, const std::function<void()> &prepare, const std::function<void()> &work) {
    std::vector<double> times;
    double spent = 0;
    for (int run = 0; run < runs || (spent < .5 && run < 200); ++run) {
        prepare();
        const double begun = bench_now();
        work();
        times.push_back(bench_now() - begun);
        spent += times.back();
    }
    return *std::min_element(times.begin(), times.end());
}

// Normals by a weight, vertices shared by index, in double precision throughout: what errors are
// measured against.
inline std::vector<double> reference(const Mesh &mesh, Weight weight) {
    std::vector<double> sums(mesh.positions.size(), 0.0);
    for (size_t t = 0; t < mesh.triangles.size(); t += 3) {
        double p[3][3], e[3][3], n[3];
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k)
                p[i][k] = mesh.positions[3 * size_t(mesh.triangles[t + size_t(i)]) + size_t(k)];
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) e[i][k] = p[(i + 1) % 3][k] - p[i][k];
        for (int k = 0; k < 3; ++k)
            n[k] = e[0][(k + 1) % 3] * -e[2][(k + 2) % 3] - e[0][(k + 2) % 3] * -e[2][(k + 1) % 3];
        const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        if (!(length > 0)) continue;
        for (int i = 0; i < 3; ++i) {
            const double *a = e[i], *b = e[(i + 2) % 3]; // b runs towards the corner
            double c[3], dot = 0;
            for (int k = 0; k < 3; ++k) {
                c[k] = a[(k + 1) % 3] * -b[(k + 2) % 3] - a[(k + 2) % 3] * -b[(k + 1) % 3];
                dot -= a[k] * b[k];
            }
            const double angle =
                std::atan2(std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]), dot);
            const double w = weight == Weight::area    ? 1
                             : weight == Weight::angle ? angle / length
                                                       : 1 / length;
            for (int k = 0; k < 3; ++k)
                sums[3 * size_t(mesh.triangles[t + size_t(i)]) + size_t(k)] += w * n[k];
        }
    }
    return sums;
}

// Degrees; normal(vertex, axis) is what the library made.
inline double largest_angle(
    const std::vector<double> &reference, const std::function<double(size_t, int)> &normal) {
    double largest = 0;
    for (size_t v = 0; v < reference.size() / 3; ++v) {
        const double *r = &reference[3 * v], n[3] = {normal(v, 0), normal(v, 1), normal(v, 2)};
        const double x = r[1] * n[2] - r[2] * n[1], y = r[2] * n[0] - r[0] * n[2],
                     z = r[0] * n[1] - r[1] * n[0];
        largest = std::max(largest,
            std::atan2(std::sqrt(x * x + y * y + z * z), r[0] * n[0] + r[1] * n[1] + r[2] * n[2]));
    }
    return largest * 57.29577951308232;
}

// Seconds of copying so many bytes, warm.
inline double copy_seconds(size_t bytes, int runs = 9) {
    std::vector<char> from(bytes, 1), to(bytes, 2);
    return least(
        runs, [] {},
        [&] {
            std::memcpy(to.data(), from.data(), bytes);
            asm volatile("" : : "r"(to.data()) : "memory");
        });
}

inline double peak_megabytes() {
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return double(usage.ru_maxrss) / 1024;
}

// One line: library, call, weight, shape, elements, ns each, multiples of the least traffic (12
// bytes copied a triangle; else what is given), degrees off, peak MB.
inline void print(const char *library, const char *call, const char *weight,
    const std::string &shape, size_t count, double seconds, double copy, double degrees) {
    std::printf("%s\t%s\t%s\t%s\t%zu\t%.2f\t%.2f\t", library, call, weight, shape.c_str(), count,
        1e9 * seconds / double(count), seconds / copy);
    if (degrees < 0)
        std::printf("-");
    else
        std::printf("%.3g", degrees);
    std::printf("\t%.0f\n", peak_megabytes());
    std::fflush(stdout);
}

inline size_t asked_triangles(int count, char **arguments, size_t otherwise) {
    return count > 1 ? std::strtoull(arguments[1], nullptr, 10) : otherwise;
}

} // namespace rival
