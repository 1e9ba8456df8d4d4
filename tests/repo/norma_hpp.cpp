// norma.hpp gives what the C calls give, whatever the containers, writes where it is told to, and
// throws what callbacks throw and what norma_find_fault says. Exits with the number of failures.
#include <norma/norma.hpp>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <thread>

namespace {

int failures = 0;

void expect(bool holds, const char *what, int line) {
    if (holds) return;
    std::printf("line %d: %s\n", line, what);
    ++failures;
}
#define EXPECT(condition) expect(condition, #condition, __LINE__)

// Types as other libraries have them.
struct Point {
    float x, y, z, padding;
};
class Indexed { // as glm::dvec3, Eigen::Vector3d
  public:
    double operator[](int i) const { return values[i]; }
    double values[3];
};
struct Matrix { // as glm::mat4
    const norma::Vec4 &operator[](int i) const { return columns[i]; }
    norma::Vec4 columns[4];
};

// A pyramid of four triangles on a quad, at unround places; one face is degenerate.
const std::vector<float> numbers = {
    0.1f, 0, 0, 1.3f, 0.2f, 0, 1.1f, 1, -0.1f, 0, 0.9f, 0.05f, 0.6f, 0.4f, 1.2f};
const std::vector<std::uint32_t> corners = {
    3, 2, 1, 0, 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 0, 0, 1};
const std::vector<std::uint32_t> starts = {0, 4, 7, 10, 13, 16, 19};
constexpr float crease = 0.7f;

norma_mesh pyramid() {
    norma_mesh mesh{};
    mesh.positions.data = numbers.data();
    mesh.positions.count = 5;
    mesh.corners = corners.data();
    mesh.corner_count = corners.size();
    mesh.face_starts = starts.data();
    mesh.face_count = starts.size() - 1;
    return mesh;
}

bool same(const std::vector<norma::Vec3> &made, const std::vector<float> &right) {
    return made.size() * 3 == right.size() &&
           std::memcmp(made.data(), right.data(), right.size() * sizeof(float)) == 0;
}

void computes_what_c_computes() {
    const norma_mesh c = pyramid();
    const norma::Mesh mesh = norma::Mesh(numbers, corners).faces(starts);
    std::vector<float> right(6 * 3);
    EXPECT(!norma_face_normals(&c, nullptr, right.data(), 6, nullptr));
    norma_report report{};
    EXPECT(same(norma::face_normals(mesh, {}, &report), right));
    EXPECT(report.degenerate_faces.count == 1 && report.degenerate_faces.first == 5);

    norma_options c_options{};
    c_options.weight = NORMA_WEIGHT_MAX;
    norma::Options options;
    options.weight = norma::Weight::max;
    right.resize(5 * 3);
    EXPECT(!norma_vertex_normals(&c, &c_options, right.data(), 5, nullptr));
    EXPECT(same(norma::vertex_normals(mesh, options), right));

    right.resize(19 * 3);
    EXPECT(!norma_corner_normals(&c, crease, &c_options, right.data(), 19, nullptr));
    std::vector<norma::Reason> reasons(19);
    options.reasons = reasons;
    EXPECT(same(norma::corner_normals(mesh, crease, options), right));
    EXPECT(reasons[16] == norma::Reason::unreferenced || reasons[16] == norma::Reason::none);
    options.reasons = {};
    const norma::Split split = norma::split(mesh, crease, options);
    bool equal = true;
    for (std::size_t i = 0; i < 19; ++i) {
        equal = equal && split.source_vertices[split.corners[i]] == corners[i];
        equal =
            equal && std::memcmp(split.normals[split.corners[i]].data(), &right[3 * i], 12) == 0;
    }
    EXPECT(equal);
}

void takes_any_container() {
    const std::vector<norma::Vec3> right =
        norma::vertex_normals(norma::Mesh(numbers, corners).faces(starts));
    std::vector<Point> points;
    std::vector<Indexed> doubles;
    std::vector<std::array<float, 3>> arrays;
    float matrix[5][3];
    for (std::size_t i = 0; i < 5; ++i) {
        const float *p = &numbers[3 * i];
        points.push_back({p[0], p[1], p[2], 0});
        doubles.push_back(Indexed{{double(p[0]), double(p[1]), double(p[2])}});
        arrays.push_back({p[0], p[1], p[2]});
        std::memcpy(matrix[i], p, sizeof matrix[i]);
    }
    EXPECT(norma::vertex_normals(norma::Mesh(points, corners).faces(starts)) == right);
    EXPECT(norma::vertex_normals(norma::Mesh(doubles, corners).faces(starts)) == right);
    EXPECT(norma::vertex_normals(norma::Mesh(arrays, corners).faces(starts)) == right);
    EXPECT(norma::vertex_normals(norma::Mesh(matrix, corners).faces(starts)) == right);
    const norma::Vectors member(&points[0].x, points.size(), sizeof(Point));
    EXPECT(norma::vertex_normals(norma::Mesh(member, corners).faces(starts)) == right);
    std::vector<std::uint8_t> bytes(corners.begin(), corners.end());
    std::vector<int> ints(corners.begin(), corners.end());
    EXPECT(norma::vertex_normals(norma::Mesh(numbers, bytes).faces(starts)) == right);
    EXPECT(norma::vertex_normals(norma::Mesh(numbers, ints).faces(starts)) == right);
    const std::vector<std::array<std::uint16_t, 3>> triangles = {{0, 1, 4}, {1, 2, 4}};
    const norma::Mesh of_triangles(numbers, triangles);
    EXPECT(of_triangles.corner_count() == 6 && of_triangles.face_count() == 2);
    EXPECT(norma::vertex_normals(norma::Mesh(std::vector<float>{})).empty());
}

void writes_where_it_is_told() {
    const norma::Mesh mesh = norma::Mesh(numbers, corners).faces(starts);
    const std::vector<norma::Vec3> right = norma::vertex_normals(mesh);
    std::vector<float> out(5 * 8, -7);
    norma::Options options;
    options.stride = 8 * sizeof(float);
    norma::vertex_normals(mesh, out, options);
    bool equal = true;
    for (std::size_t i = 0; i < 5; ++i) {
        equal = equal && std::memcmp(&out[8 * i], right[i].data(), 12) == 0;
        for (std::size_t j = 3; j < 8; ++j) equal = equal && !(out[8 * i + j] > -7);
    }
    EXPECT(equal);
    // 4 strides and 3 floats are just enough; a float less is not.
    norma::vertex_normals(mesh, norma::Span<float>(out.data(), 35), options);
    try {
        norma::vertex_normals(mesh, norma::Span<float>(out.data(), 34), options);
        expect(false, "memory that is too small is refused", __LINE__);
    } catch (const norma::Error &error) {
        EXPECT(error.result() == NORMA_ERROR_CAPACITY);
    }
}

template <class Call>
void fails(norma_result result, const char *argument, std::size_t index, Call call, int line) {
    try {
        call();
        expect(false, "it throws", line);
    } catch (const norma::Error &error) {
        expect(error.result() == result, "the result", line);
        expect(error.argument() && std::strcmp(error.argument(), argument) == 0, argument, line);
        expect(error.index() == index, "the index", line);
        expect(std::strstr(error.what(), argument) != nullptr, error.what(), line);
    }
}

void says_what_is_wrong() {
    std::vector<std::uint32_t> beyond = corners;
    beyond[7] = 5;
    fails(
        NORMA_ERROR_INDEX, "mesh->corners", 7,
        [&] { norma::vertex_normals(norma::Mesh(numbers, beyond).faces(starts)); }, __LINE__);
    fails(
        NORMA_ERROR_ARGUMENT, "crease_angle_rad", SIZE_MAX,
        [] { norma::corner_normals(norma::Mesh(numbers, corners).faces(starts), 9); }, __LINE__);
    fails(
        NORMA_ERROR_ARGUMENT, "options.reasons", SIZE_MAX,
        [] {
            norma::Reason few[4];
            norma::Options options;
            options.reasons = few;
            norma::vertex_normals(norma::Mesh(numbers, corners).faces(starts), options);
        },
        __LINE__);
    fails(
        NORMA_ERROR_ARGUMENT, "vectors", SIZE_MAX, [] { norma::Mesh(std::vector<float>(7)); },
        __LINE__);
    fails(
        NORMA_ERROR_ARGUMENT, "hard_edges", SIZE_MAX,
        [] { norma::Mesh(numbers, corners).hard_edges(std::vector<std::uint8_t>(3)); }, __LINE__);
}

void passes_callbacks_through() {
    std::vector<float> grid; // large enough to tell of progress
    for (int i = 0; i < 270000; ++i) grid.push_back(static_cast<float>(i % 971) * 0.25f);
    const norma::Mesh mesh(grid);
    const std::vector<norma::Vec3> right = norma::corner_normals(mesh, crease);
    norma::Options options;
    options.progress = [](double) { return false; };
    try {
        norma::corner_normals(mesh, crease, options);
        expect(false, "progress cancels", __LINE__);
    } catch (const norma::Error &error) {
        EXPECT(error.result() == NORMA_CANCELLED);
    }
    options.progress = [](double) -> bool { throw 42; };
    try {
        norma::corner_normals(mesh, crease, options);
        expect(false, "what progress throws is thrown", __LINE__);
    } catch (int thrown) {
        EXPECT(thrown == 42);
    }
    options.progress = nullptr;
    std::size_t tasks = 0;
    options.parallel_for = [&](std::size_t count, const std::function<void(std::size_t)> &task) {
        tasks += count;
        std::vector<std::thread> threads;
        for (std::size_t t = 0; t < 2; ++t)
            threads.emplace_back([&, t] {
                for (std::size_t i = t; i < count; i += 2) task(i);
            });
        for (std::thread &thread : threads) thread.join();
    };
    EXPECT(norma::corner_normals(mesh, crease, options) == right);
    EXPECT(tasks > 1);
}

void plans_update_partly() {
    std::vector<float> moving = numbers;
    const norma::Mesh mesh = norma::Mesh(moving, corners).faces(starts);
    norma::Plan first(mesh, norma::Element::corner, crease);
    const norma::Plan plan = std::move(first);
    std::vector<float> partial(19 * 3);
    plan.update(moving, partial);
    EXPECT(same(norma::corner_normals(mesh, crease), partial));
    moving[14] += 0.25f;
    const std::vector<float> before = partial;
    plan.update(moving, norma::Span<const std::uint32_t>(), partial);
    EXPECT(partial == before); // no vertex has moved
    const std::uint32_t moved[] = {4};
    plan.update(moving, moved, partial);
    EXPECT(same(plan.update(moving), partial));
    EXPECT(partial != before && plan.bytes() > 0 && first.bytes() == 0);
}

void matrices_and_skins() {
    const float c = 0.6f, s = 0.8f; // a turn about z
    const Matrix turned{{{c, s, 0, 0}, {-s, c, 0, 0}, {0, 0, 1, 0}, {5, 6, 7, 1}}};
    const float stretched[4][4] = {{2, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    const std::array<float, 16> mirrored = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    EXPECT((norma::normal_matrix(turned) == norma::Matrix3{c, s, 0, -s, c, 0, 0, 0, 1}));
    EXPECT((norma::normal_matrix(stretched) == norma::Matrix3{1, 0, 0, 0, 2, 0, 0, 0, 2}));
    EXPECT((norma::normal_matrix(mirrored) == norma::Matrix3{-1, 0, 0, 0, 1, 0, 0, 0, 1}));
    EXPECT((norma::normal_matrix(mirrored, norma::Winding::kept) ==
            norma::Matrix3{1, 0, 0, 0, -1, 0, 0, 0, -1}));
    EXPECT((norma::normal_matrix(stretched, turned) ==
            norma::Matrix3{c, s, 0, -2 * s, 2 * c, 0, 0, 0, 2}));
    EXPECT(norma::matrix_info(mirrored).mirrored && !norma::matrix_info(turned).mirrored);
    EXPECT(norma::normal_matrices(mirrored)[0] == norma::normal_matrix(mirrored));

    const std::vector<norma::Vec3> x = {{1, 0, 0}};
    const std::vector<norma::Vec3> n = norma::transform_normals(norma::normal_matrix(turned), x);
    EXPECT(std::abs(n[0][0] - c) < 1e-6f && std::abs(n[0][1] - s) < 1e-6f);
    const std::uint16_t joints[] = {0};
    const float weights[] = {1};
    const norma::Skin skin(norma::Span<const float>(&turned.columns[0][0], 16),
        norma::Span<const std::uint16_t>(joints), weights, 1);
    EXPECT(std::abs(skin.normals(x)[0][1] - s) < 1e-6f);
    EXPECT(std::abs(skin.positions(x)[0][0] - (5 + c)) < 1e-6f);
    const norma::Vec4 along[] = {{0, 1, 0, 1}};
    EXPECT(std::abs(skin.tangents(along, skin.normals(x))[0][0] + s) < 1e-6f);
    EXPECT(std::abs(norma::transform_tangents(turned, along, n)[0][0] + s) < 1e-6f);
}

void the_rest() {
    const std::vector<float> uv = {0, 0, 1, 0, 1, 1, 0, 1, 0.5f, 0.5f};
    const std::vector<std::uint32_t> sides = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
    const norma::Mesh mesh(numbers, sides);
    const std::vector<norma::Vec3> normals = norma::vertex_normals(mesh);
    const norma::Texcoords texcoords(uv);
    const std::vector<norma::Vec4> tangents =
        norma::corner_tangents(mesh, normals, texcoords, norma::TangentMode::mikk);
    norma_mesh c = mesh.c();
    std::vector<norma::Vec4> right(12);
    const norma_attribute n{normals.data(), 5, 12, NORMA_FORMAT_FLOAT, NORMA_PER_VERTEX, nullptr};
    const norma_attribute t{uv.data(), 5, 8, NORMA_FORMAT_FLOAT, NORMA_PER_VERTEX, nullptr};
    EXPECT(!norma_corner_tangents(
        &c, &n, &t, NORMA_TANGENTS_MIKK, nullptr, right[0].data(), 12, nullptr));
    EXPECT(tangents == right);
    const norma::Built built = norma::build(mesh, &texcoords, 3, norma::TangentMode::mikk);
    EXPECT(built.normals.size() == built.tangents.size() && built.corners.size() == 12);
    for (std::size_t i = 0; i < 12; ++i) {
        EXPECT(built.source_vertices[built.corners[i]] == sides[i]);
        EXPECT(built.tangents[built.corners[i]] == right[i]);
    }
    EXPECT(norma::build(mesh, nullptr, 3, norma::TangentMode::mikk).tangents.empty());

    std::vector<std::uint32_t> inside_out = {0, 1, 2, 0, 2, 3};
    inside_out.insert(inside_out.end(), {0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0});
    EXPECT(norma::orient(norma::Mesh(numbers, inside_out)) == std::vector<std::uint8_t>(6, 1));

    const norma::Surface surface{mesh, normals};
    bool same_faces = false;
    const auto samples = norma::compare(surface, surface, {}, &same_faces);
    const norma::Comparison comparison = norma::compare_summary(samples, 0.01);
    EXPECT(same_faces && comparison.corners == 12 && !(comparison.max_rad > 0));

    const std::vector<norma::Vec3> decoded = norma::decode_normals(
        norma::encode_normals(normals, norma::Encoding::oct16), norma::Encoding::oct16);
    for (std::size_t i = 0; i < 5; ++i) {
        double dot = 0;
        for (std::size_t j = 0; j < 3; ++j) dot += double(decoded[i][j]) * double(normals[i][j]);
        EXPECT(dot > std::cos(norma::encoding_error_rad(norma::Encoding::oct16)) - 1e-6);
    }
    const norma::Vec3 middle =
        norma::interpolate_normal({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0});
    EXPECT(std::abs(middle[0] - std::sqrt(0.5f)) < 1e-6f && !(middle[2] > 0));
}

} // namespace

int main() {
    computes_what_c_computes();
    takes_any_container();
    writes_where_it_is_told();
    says_what_is_wrong();
    passes_callbacks_through();
    plans_update_partly();
    matrices_and_skins();
    the_rest();
    return failures;
}
