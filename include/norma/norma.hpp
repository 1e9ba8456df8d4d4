// norma.hpp: norma.h for C++17. It adds no computation of its own: each function here is one call
// of the C function of the same name, whose comment in norma.h says what it computes, its cost and
// its source.
//
// - Inputs are views: std::vector, std::array, C arrays, std::span and the like, of numbers or of
//   vectors (std::array<float, 3>, glm::vec3, Eigen::Vector3d, a struct with x, y and z). What they
//   show has to outlive the call, or for a Mesh the Mesh.
// - Outputs are owned: std::vector. Calls with a parameter `out` write into the caller's memory.
// - Errors are thrown: norma::Error says which argument is wrong, and which element of it.
//   A progress callback that throws ends the call and is passed on.
// - Angles are in radians, matrices column-major; a default-constructed Options means the defaults.
#ifndef NORMA_HPP
#define NORMA_HPP
#include <norma/norma.h>

#include <array>
#include <cstdint>
#include <exception>
#include <functional>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace norma {

using Vec3 = std::array<float, 3>;
using Vec4 = std::array<float, 4>;
using Matrix3 = std::array<float, 9>;

using Report = norma_report;
using OrientReport = norma_orient_report;
using MatrixInfo = norma_matrix_info;
using CompareSample = norma_compare_sample;
using Comparison = norma_comparison;

enum class Weight {
    angle = NORMA_WEIGHT_ANGLE,
    area = NORMA_WEIGHT_AREA,
    uniform = NORMA_WEIGHT_UNIFORM,
    max = NORMA_WEIGHT_MAX,
    angle_area = NORMA_WEIGHT_ANGLE_AREA,
    visible = NORMA_WEIGHT_VISIBLE,
    angle_lengths = NORMA_WEIGHT_ANGLE_LENGTHS
};
enum class Weld {
    exact = NORMA_WELD_EXACT,
    none = NORMA_WELD_NONE,
    distance = NORMA_WELD_DISTANCE
};
enum class NonManifold { hard = NORMA_NON_MANIFOLD_HARD, smooth = NORMA_NON_MANIFOLD_SMOOTH };
enum class Fallback {
    zero = NORMA_FALLBACK_ZERO,
    nearest = NORMA_FALLBACK_NEAREST,
    given = NORMA_FALLBACK_GIVEN
};
enum class Isa {
    best = NORMA_ISA_BEST,
    portable = NORMA_ISA_PORTABLE,
    sse2 = NORMA_ISA_SSE2,
    avx2 = NORMA_ISA_AVX2,
    avx512 = NORMA_ISA_AVX512,
    neon = NORMA_ISA_NEON,
    simd128 = NORMA_ISA_SIMD128
};
enum class Reason : std::uint8_t {
    none = NORMA_REASON_NONE,
    degenerate = NORMA_REASON_DEGENERATE,
    non_finite = NORMA_REASON_NON_FINITE,
    unreferenced = NORMA_REASON_UNREFERENCED,
    cancelled = NORMA_REASON_CANCELLED
};
enum class Element { vertex = NORMA_PER_VERTEX, corner = NORMA_PER_CORNER };
enum class Winding { kept = NORMA_WINDING_KEPT, reversed = NORMA_WINDING_REVERSED };
enum class OrientOpen { kept = NORMA_ORIENT_OPEN_KEPT, by_rays = NORMA_ORIENT_OPEN_BY_RAYS };
enum class TangentMode { steady = NORMA_TANGENTS_STEADY, mikk = NORMA_TANGENTS_MIKK };
enum class Encoding {
    oct8 = NORMA_ENCODING_OCT8,
    oct12 = NORMA_ENCODING_OCT12,
    oct16 = NORMA_ENCODING_OCT16,
    snorm10 = NORMA_ENCODING_10_10_10_2
};
enum class Blend { linear = NORMA_BLEND_LINEAR, dual_quaternion = NORMA_BLEND_DUAL_QUATERNION };

// Why a call failed. result() may be NORMA_CANCELLED.
class Error : public std::runtime_error {
  public:
    Error(const char *function, const norma_fault &fault)
        : std::runtime_error(sentence(function, fault)), fault_(fault) {}
    norma_result result() const noexcept { return fault_.result; }
    // "mesh->corners", "options->weight", ...; NULL: not known
    const char *argument() const noexcept { return fault_.argument; }
    // The element of that argument; SIZE_MAX: no single one.
    std::size_t index() const noexcept { return fault_.index; }

  private:
    static std::string sentence(const char *function, const norma_fault &fault) {
        std::string text = std::string(function) + ": ";
        if (fault.argument) text += fault.argument;
        if (fault.argument && fault.index != SIZE_MAX)
            text += "[" + std::to_string(fault.index) + "]";
        if (fault.argument && fault.expected)
            text += " should be " + std::string(fault.expected) + ": ";
        else if (fault.argument)
            text += ": ";
        return text + norma_result_text(fault.result);
    }
    norma_fault fault_;
};

// An array of somebody else's, as std::span in C++20.
template <class T> class Span {
  public:
    Span() = default;
    Span(T *data, std::size_t size) : data_(data), size_(size) {}
    template <class Array,
        class = std::enable_if_t<std::is_convertible_v<
            std::remove_pointer_t<decltype(std::data(std::declval<Array &>()))> (*)[], T (*)[]>>>
    Span(Array &&array) : data_(std::data(array)), size_(std::size(array)) {}
    T *data() const noexcept { return data_; }
    std::size_t size() const noexcept { return size_; }
    bool empty() const noexcept { return size_ == 0; }
    T *begin() const noexcept { return data_; }
    T *end() const noexcept { return data_ + size_; }
    T &operator[](std::size_t index) const { return data_[index]; }

  private:
    T *data_ = nullptr;
    std::size_t size_ = 0;
};

// What follows up to Vectors serves the classes and functions below, not their callers.
namespace detail {

[[noreturn]] inline void fail(
    const char *function, norma_result result, const char *argument, const char *expected) {
    throw Error(function, norma_fault{result, argument, SIZE_MAX, expected});
}

inline void require(bool holds, const char *function, const char *argument, const char *expected) {
    if (!holds) fail(function, NORMA_ERROR_ARGUMENT, argument, expected);
}

inline void check(const char *function, norma_result result) {
    if (result != NORMA_OK) fail(function, result, nullptr, nullptr);
}

template <class Number> constexpr norma_format format_of() {
    using N = std::remove_cv_t<Number>;
    if constexpr (std::is_same_v<N, float>) {
        return NORMA_FORMAT_FLOAT;
    } else if constexpr (std::is_same_v<N, double>) {
        return NORMA_FORMAT_DOUBLE;
    } else {
        static_assert(std::is_integral_v<N> && sizeof(N) <= 2,
            "components are float, double, or integers of 8 or 16 bits");
        if constexpr (sizeof(N) == 1)
            return std::is_signed_v<N> ? NORMA_FORMAT_INT8 : NORMA_FORMAT_UINT8;
        else
            return std::is_signed_v<N> ? NORMA_FORMAT_INT16 : NORMA_FORMAT_UINT16;
    }
}

// The type of a vector's components: that of v[0], else that of v.x.
template <class V, class = void> struct Component {
    using type = std::remove_reference_t<decltype(std::declval<const V &>().x)>;
};
template <class V> struct Component<V, std::void_t<decltype(std::declval<const V &>()[0])>> {
    using type = std::remove_reference_t<decltype(std::declval<const V &>()[0])>;
};

// An array of numbers, or of vectors of `size` numbers at least, as the C structs describe it.
struct Layout {
    const void *data;
    std::size_t count, stride;
    norma_format format;
};
template <std::size_t size, class Array>
Layout layout_of(const Array &array, const char *argument) {
    using V = std::remove_cv_t<std::remove_pointer_t<decltype(std::data(array))>>;
    if constexpr (std::is_arithmetic_v<V>) {
        require(std::size(array) % size == 0, "norma::Vectors", argument,
            size == 3 ? "three numbers for each vector" : "two numbers for each vector");
        return {std::data(array), std::size(array) / size, size * sizeof(V), format_of<V>()};
    } else {
        using Number = typename Component<V>::type;
        static_assert(sizeof(V) >= size * sizeof(Number), "vectors have too few components");
        return {std::data(array), std::size(array), sizeof(V), format_of<Number>()};
    }
}

// The floats of all vectors.
template <std::size_t size> Span<float> floats(std::vector<std::array<float, size>> &vectors) {
    if (vectors.empty()) return {};
    return {vectors.data()->data(), vectors.size() * size};
}

} // namespace detail

// Vectors of three components in the caller's memory: positions or normals.
class Vectors {
  public:
    Vectors() = default;
    template <class Array, class = decltype(std::data(std::declval<const Array &>()))>
    Vectors(const Array &array) {
        const detail::Layout layout = detail::layout_of<3>(array, "vectors");
        view_ = {layout.data, layout.count, layout.stride, layout.format};
    }
    // Members of a larger struct: stride is its size in bytes.
    template <class Number>
    Vectors(const Number *first, std::size_t count, std::size_t stride = 0)
        : view_{first, count, stride, detail::format_of<Number>()} {}
    const norma_vec3_view &c() const noexcept { return view_; }
    std::size_t size() const noexcept { return view_.count; }

  private:
    norma_vec3_view view_{};
};

// Normals of three components or texture coordinates of two, one for each position or each corner.
template <std::size_t components> class Attribute {
  public:
    template <class Array, class = decltype(std::data(std::declval<const Array &>()))>
    Attribute(const Array &array, Element of = Element::vertex) : attribute_{} {
        const detail::Layout layout = detail::layout_of<components>(array, "attribute");
        attribute_.data = layout.data;
        attribute_.count = layout.count;
        attribute_.stride = layout.stride;
        attribute_.format = layout.format;
        attribute_.of = static_cast<norma_element>(of);
    }
    // With an index of their own: the value of each corner.
    template <class Array>
    Attribute(const Array &array, Span<const std::uint32_t> corners) : Attribute(array) {
        attribute_.corners = corners.data();
        corner_count_ = corners.size();
    }
    const norma_attribute &c() const noexcept { return attribute_; }
    // Throws if the attribute has an index for fewer corners than there are.
    void require_corners(const char *function, std::size_t count) const {
        detail::require(!attribute_.corners || corner_count_ >= count, function,
            components == 3 ? "normals->corners" : "texcoords->corners", "one for each corner");
    }

  private:
    norma_attribute attribute_;
    std::size_t corner_count_ = 0;
};
using Normals = Attribute<3>;
using Texcoords = Attribute<2>;

// A mesh in the caller's memory: positions, and the faces' corners.
class Mesh {
  public:
    // Every three positions are a triangle.
    explicit Mesh(Vectors positions) : mesh_{} {
        mesh_.positions = positions.c();
        mesh_.corner_count = positions.size();
    }
    // corners: unsigned integers of 8, 16 or 32 bits (or int), or arrays of these, such as
    // std::array<std::uint32_t, 3>. Triangles, unless faces are given too.
    template <class Array> Mesh(Vectors positions, const Array &corners) : mesh_{} {
        using V = std::remove_cv_t<std::remove_pointer_t<decltype(std::data(corners))>>;
        mesh_.positions = positions.c();
        mesh_.corners = std::data(corners);
        if constexpr (std::is_integral_v<V>)
            set_corners<V>(std::size(corners), 1);
        else
            set_corners<std::remove_cv_t<typename detail::Component<V>::type>>(
                std::size(corners), sizeof(V) / sizeof(typename detail::Component<V>::type));
    }
    // starts: one more than there are faces; face f has the corners from starts[f] up to but not
    // including starts[f + 1].
    Mesh &faces(Span<const std::uint32_t> starts) {
        detail::require(!starts.empty(), "norma::Mesh", "face_starts", "one more than faces");
        mesh_.face_starts = starts.data();
        mesh_.face_count = starts.size() - 1;
        return *this;
    }
    // A bit mask for each face.
    Mesh &smoothing_groups(Span<const std::uint32_t> masks) {
        detail::require(masks.size() == face_count(), "norma::Mesh", "smoothing_groups",
            "one for each face (give the faces first)");
        mesh_.smoothing_groups = masks.data();
        return *this;
    }
    // A byte for each corner: nonzero if the edge from it to the next is hard.
    Mesh &hard_edges(Span<const std::uint8_t> marks) {
        detail::require(
            marks.size() == corner_count(), "norma::Mesh", "hard_edges", "one for each corner");
        mesh_.hard_edges = marks.data();
        return *this;
    }
    const norma_mesh &c() const noexcept { return mesh_; }
    std::size_t vertex_count() const noexcept { return mesh_.positions.count; }
    std::size_t corner_count() const noexcept { return mesh_.corner_count; }
    std::size_t face_count() const noexcept {
        return mesh_.face_starts ? mesh_.face_count : mesh_.corner_count / 3;
    }

  private:
    template <class Index> void set_corners(std::size_t count, std::size_t each) {
        static_assert(std::is_integral_v<Index> && sizeof(Index) <= 4 &&
                          (std::is_unsigned_v<Index> || sizeof(Index) == 4),
            "corners are unsigned integers of 8, 16 or 32 bits, or int");
        mesh_.corner_size = sizeof(Index);
        mesh_.corner_count = count * each;
    }
    norma_mesh mesh_;
};

struct Options {
    Weight weight = Weight::angle;
    Weld weld = Weld::exact;
    double weld_distance = 0;
    NonManifold non_manifold = NonManifold::hard;
    Fallback fallback = Fallback::zero;
    Vec3 fallback_normal{};
    std::size_t stride = 0;    // bytes between vectors that are written to `out`; 0: packed
    Span<Reason> reasons = {}; // written: why each element has no normal of its own
    std::uint32_t threads = 1; // NORMA_ALL_THREADS: as many as the machine runs at once
    Isa isa = Isa::best;
    norma_allocator allocator{};
    // Runs task(i) once for each i below count, on any threads; empty: threads of the library.
    std::function<void(std::size_t count, const std::function<void(std::size_t)> &task)>
        parallel_for;
    std::function<bool(double fraction)> progress; // returns false to cancel
    norma_edges *edges = nullptr;                  // written by the calls that use creases
};

namespace detail {

// Options as the C call reads them, and what a callback threw while it ran.
class Call {
  public:
    // values: how many vectors are written, `stride` bytes apart.
    Call(const char *function, const Options &options, std::size_t values, std::size_t stride = 0)
        : function_(function), options_(options), c_{} {
        require(options.reasons.empty() || options.reasons.size() >= values, function,
            "options.reasons", "one for each vector that is written");
        c_.struct_size = sizeof c_;
        c_.weight = static_cast<norma_weight>(options.weight);
        c_.weld = static_cast<norma_weld>(options.weld);
        c_.weld_distance = options.weld_distance;
        c_.non_manifold = static_cast<norma_non_manifold>(options.non_manifold);
        c_.fallback = static_cast<norma_fallback>(options.fallback);
        for (std::size_t i = 0; i < 3; ++i) c_.fallback_normal[i] = options.fallback_normal[i];
        c_.normal_stride = stride;
        // An enum of one byte each, as the C call writes them.
        c_.reasons = reinterpret_cast<std::uint8_t *>(options.reasons.data());
        c_.threads = options.threads;
        c_.isa = static_cast<norma_isa>(options.isa);
        c_.allocator = options.allocator;
        c_.edges = options.edges;
        if (options.parallel_for) {
            c_.parallel_for = run_parallel;
            c_.parallel_for_user = this;
        }
        if (options.progress) {
            c_.progress = tell_progress;
            c_.progress_user = this;
        }
    }
    Call(const Call &) = delete;
    Call &operator=(const Call &) = delete;

    norma_options *c() noexcept { return &c_; }
    // How many vectors of so many floats fit into the memory.
    std::size_t capacity(Span<float> out, std::size_t floats) const noexcept {
        const std::size_t bytes = out.size() * sizeof(float), each = floats * sizeof(float);
        if (bytes < each) return 0;
        return 1 + (bytes - each) / (c_.normal_stride ? c_.normal_stride : each);
    }

    // Throws what a callback threw, or an Error that says which argument of the mesh is wrong.
    void end(norma_result result, const norma_mesh &mesh, const float *crease = nullptr) const {
        if (thrown_) std::rethrow_exception(thrown_);
        if (result == NORMA_OK) return;
        norma_fault fault{};
        norma_find_fault(&mesh, crease, &c_, &fault);
        if (fault.result != result) fault = {result, nullptr, SIZE_MAX, nullptr};
        throw Error(function_, fault);
    }
    void end(norma_result result) const {
        if (thrown_) std::rethrow_exception(thrown_);
        check(function_, result);
    }

  private:
    static int tell_progress(void *user, double fraction) noexcept {
        Call *call = static_cast<Call *>(user);
        try {
            return !call->options_.progress(fraction);
        } catch (...) {
            call->thrown_ = std::current_exception();
            return 1;
        }
    }
    // An exception of parallel_for ends the program: half of the work would be missing.
    static void run_parallel(
        void *user, std::size_t count, norma_task *task, void *context) noexcept {
        static_cast<Call *>(user)->options_.parallel_for(
            count, [task, context](std::size_t index) { task(context, index); });
    }

    const char *function_;
    const Options &options_;
    norma_options c_;
    std::exception_ptr thrown_;
};

inline void face_normals(
    const Mesh &mesh, Span<float> out, std::size_t stride, const Options &options, Report *report) {
    Call call("norma_face_normals", options, mesh.face_count(), stride);
    call.end(norma_face_normals(&mesh.c(), call.c(), out.data(), call.capacity(out, 3), report),
        mesh.c());
}
inline void vertex_normals(
    const Mesh &mesh, Span<float> out, std::size_t stride, const Options &options, Report *report) {
    Call call("norma_vertex_normals", options, mesh.vertex_count(), stride);
    call.end(norma_vertex_normals(&mesh.c(), call.c(), out.data(), call.capacity(out, 3), report),
        mesh.c());
}
inline void corner_normals(const Mesh &mesh, float crease, Span<float> out, std::size_t stride,
    const Options &options, Report *report) {
    Call call("norma_corner_normals", options, mesh.corner_count(), stride);
    call.end(norma_corner_normals(
                 &mesh.c(), crease, call.c(), out.data(), call.capacity(out, 3), report),
        mesh.c(), &crease);
}

} // namespace detail

// ---- normals of meshes: of each face, vertex or corner. The forms with `out` write vectors of
// three floats, options.stride bytes apart (0: 12).

inline std::vector<Vec3> face_normals(
    const Mesh &mesh, const Options &options = {}, Report *report = nullptr) {
    std::vector<Vec3> normals(mesh.face_count());
    detail::face_normals(mesh, detail::floats(normals), 0, options, report);
    return normals;
}
inline void face_normals(
    const Mesh &mesh, Span<float> out, const Options &options = {}, Report *report = nullptr) {
    detail::face_normals(mesh, out, options.stride, options, report);
}

inline std::vector<Vec3> vertex_normals(
    const Mesh &mesh, const Options &options = {}, Report *report = nullptr) {
    std::vector<Vec3> normals(mesh.vertex_count());
    detail::vertex_normals(mesh, detail::floats(normals), 0, options, report);
    return normals;
}
inline void vertex_normals(
    const Mesh &mesh, Span<float> out, const Options &options = {}, Report *report = nullptr) {
    detail::vertex_normals(mesh, out, options.stride, options, report);
}

inline std::vector<Vec3> corner_normals(const Mesh &mesh, float crease_angle_rad,
    const Options &options = {}, Report *report = nullptr) {
    std::vector<Vec3> normals(mesh.corner_count());
    detail::corner_normals(mesh, crease_angle_rad, detail::floats(normals), 0, options, report);
    return normals;
}
inline void corner_normals(const Mesh &mesh, float crease_angle_rad, Span<float> out,
    const Options &options = {}, Report *report = nullptr) {
    detail::corner_normals(mesh, crease_angle_rad, out, options.stride, options, report);
}

// The normals of corner_normals as an indexed mesh.
struct Split {
    std::vector<std::uint32_t> corners;         // the new vertex of each corner
    std::vector<std::uint32_t> source_vertices; // the old vertex of each new vertex
    std::vector<Vec3> normals;                  // of each new vertex
};
inline Split split(const Mesh &mesh, float crease_angle_rad, const Options &options = {},
    Report *report = nullptr) {
    const std::size_t corners = mesh.corner_count(); // no more vertices than corners
    Split made{std::vector<std::uint32_t>(corners), std::vector<std::uint32_t>(corners),
        std::vector<Vec3>(corners)};
    norma_split_output output{made.corners.data(), corners, made.source_vertices.data(),
        detail::floats(made.normals).data(), corners, 0};
    detail::Call call("norma_split", options, corners);
    call.end(norma_split_mesh(&mesh.c(), crease_angle_rad, call.c(), &output, report), mesh.c(),
        &crease_angle_rad);
    made.source_vertices.resize(output.vertex_count);
    made.normals.resize(output.vertex_count);
    return made;
}

inline Vec3 interpolate_normal(
    const Vec3 &a, const Vec3 &b, const Vec3 &c, const Vec3 &barycentric) {
    Vec3 normal{};
    detail::check("norma_interpolate_normal",
        norma_interpolate_normal(a.data(), b.data(), c.data(), barycentric.data(), normal.data()));
    return normal;
}

// ---- meshes that move

class Plan {
  public:
    Plan(const Mesh &mesh, Element of, float crease_angle_rad, const Options &options = {})
        : count_(of == Element::vertex ? mesh.vertex_count() : mesh.corner_count()) {
        detail::Call call("norma_plan_create", options, 0);
        norma_plan *plan = nullptr;
        call.end(norma_plan_create(
                     &mesh.c(), static_cast<norma_element>(of), crease_angle_rad, call.c(), &plan),
            mesh.c(), &crease_angle_rad);
        plan_.reset(plan);
    }
    // All normals.
    std::vector<Vec3> update(
        const Vectors &positions, const Options &options = {}, Report *report = nullptr) const {
        std::vector<Vec3> normals(count_);
        write(positions, nullptr, 0, detail::floats(normals), 0, options, report);
        return normals;
    }
    void update(const Vectors &positions, Span<float> out, const Options &options = {},
        Report *report = nullptr) const {
        write(positions, nullptr, 0, out, options.stride, options, report);
    }
    // Those that the moved vertices affect; the others in `out` stay as they are.
    void update(const Vectors &positions, Span<const std::uint32_t> moved, Span<float> out,
        const Options &options = {}, Report *report = nullptr) const {
        static const std::uint32_t none = 0; // NULL would mean that all have moved
        write(positions, moved.empty() ? &none : moved.data(), moved.size(), out, options.stride,
            options, report);
    }
    std::size_t bytes() const noexcept { return norma_plan_bytes(plan_.get()); }
    const norma_plan *c() const noexcept { return plan_.get(); }

  private:
    void write(const Vectors &positions, const std::uint32_t *moved, std::size_t moved_count,
        Span<float> out, std::size_t stride, const Options &options, Report *report) const {
        detail::Call call("norma_plan_update", options, count_, stride);
        call.end(norma_plan_update(plan_.get(), positions.c(), moved, moved_count, call.c(),
            out.data(), call.capacity(out, 3), report));
    }
    struct Destroy {
        void operator()(norma_plan *plan) const noexcept { norma_plan_destroy(plan); }
    };
    std::unique_ptr<norma_plan, Destroy> plan_;
    std::size_t count_;
};

// ---- matrices: sixteen floats, column-major: a C array, std::array, glm::mat4, ...

class Model {
  public:
    template <class Matrix> Model(const Matrix &matrix) : data_(first(matrix)) {}
    explicit Model(const float *data) : data_(data) {}
    const float *data() const noexcept { return data_; }

  private:
    template <class Matrix> static const float *first(const Matrix &matrix) {
        using Column = std::remove_reference_t<decltype(matrix[0])>;
        static_assert(sizeof(Matrix) == 16 * sizeof(float), "a model has sixteen floats");
        if constexpr (std::is_arithmetic_v<Column>) {
            static_assert(std::is_same_v<std::remove_cv_t<Column>, float>, "of floats");
            return &matrix[0];
        } else {
            static_assert(std::is_same_v<std::decay_t<decltype(matrix[0][0])>, float>, "of floats");
            return &matrix[0][0];
        }
    }
    const float *data_;
};

inline Matrix3 normal_matrix(
    const Model &model, Winding winding = Winding::reversed, MatrixInfo *info = nullptr) {
    Matrix3 matrix{};
    detail::check(
        "norma_normal_matrix", norma_normal_matrix(model.data(),
                                   static_cast<norma_winding>(winding), matrix.data(), info));
    return matrix;
}
// That of view * model, without forming the product.
inline Matrix3 normal_matrix(const Model &model, const Model &view,
    Winding winding = Winding::reversed, MatrixInfo *info = nullptr) {
    Matrix3 matrix{};
    detail::check("norma_normal_matrix_model_view",
        norma_normal_matrix_model_view(
            model.data(), view.data(), static_cast<norma_winding>(winding), matrix.data(), info));
    return matrix;
}
// models: sixteen floats each.
inline std::vector<Matrix3> normal_matrices(
    Span<const float> models, Winding winding = Winding::reversed) {
    detail::require(
        models.size() % 16 == 0, "norma_normal_matrices", "models", "sixteen floats each");
    std::vector<Matrix3> matrices(models.size() / 16);
    detail::check("norma_normal_matrices",
        norma_normal_matrices(models.data(), matrices.size(), static_cast<norma_winding>(winding),
            matrices.empty() ? nullptr : matrices.data()->data(), matrices.size()));
    return matrices;
}
inline MatrixInfo matrix_info(const Model &model) {
    MatrixInfo info{};
    normal_matrix(model, Winding::reversed, &info);
    return info;
}

inline std::vector<Vec3> transform_normals(const Matrix3 &normal_matrix, const Vectors &normals) {
    std::vector<Vec3> out(normals.size());
    detail::check(
        "norma_transform_normals", norma_transform_normals(normal_matrix.data(), normals.c(),
                                       detail::floats(out).data(), 0, out.size()));
    return out;
}
inline std::vector<Vec3> transform_positions(
    const std::array<double, 16> &model, const Vectors &positions) {
    std::vector<Vec3> out(positions.size());
    detail::check(
        "norma_transform_positions", norma_transform_positions(model.data(), positions.c(),
                                         detail::floats(out).data(), 0, out.size()));
    return out;
}
// normals: the transformed ones.
inline std::vector<Vec4> transform_tangents(
    const Model &model, Span<const Vec4> tangents, const Vectors &normals) {
    detail::require(normals.size() >= tangents.size(), "norma_transform_tangents", "normals",
        "one for each tangent");
    std::vector<Vec4> out(tangents.size());
    detail::check("norma_transform_tangents",
        norma_transform_tangents(model.data(), tangents.empty() ? nullptr : tangents[0].data(), 0,
            normals.c(), out.size(), detail::floats(out).data(), 0, out.size()));
    return out;
}

// ---- orientation, comparison

// 1 for each face whose winding should be reversed.
inline std::vector<std::uint8_t> orient(const Mesh &mesh, OrientOpen open = OrientOpen::kept,
    const Options &options = {}, OrientReport *report = nullptr) {
    std::vector<std::uint8_t> reverse(mesh.face_count());
    detail::Call call("norma_orient", options, 0);
    call.end(norma_orient(&mesh.c(), static_cast<norma_orient_open>(open), call.c(), reverse.data(),
                 reverse.size(), report),
        mesh.c());
    return reverse;
}

// A mesh and the normals of its corners, which may have an index of their own (UINT32_MAX: none).
struct Surface {
    Mesh mesh;
    Vectors normals;
    Span<const std::uint32_t> corner_normals = {};
    norma_surface c(const char *argument) const {
        detail::require(corner_normals.empty() || corner_normals.size() >= mesh.corner_count(),
            "norma_compare", argument, "an index for each corner");
        return {mesh.c(), normals.c(), corner_normals.data()};
    }
};
// One sample for each corner of other.
inline std::vector<CompareSample> compare(const Surface &base, const Surface &other,
    const Options &options = {}, bool *same_faces = nullptr) {
    const norma_surface b = base.c("base.corner_normals"), o = other.c("other.corner_normals");
    std::vector<CompareSample> samples(other.mesh.corner_count());
    int same = 0;
    detail::Call call("norma_compare", options, 0);
    call.end(norma_compare(&b, &o, call.c(), samples.data(), samples.size(), &same));
    if (same_faces) *same_faces = same != 0;
    return samples;
}
inline Comparison compare_summary(
    Span<const CompareSample> samples, double max_angle_rad, const Options &options = {}) {
    Comparison comparison{};
    detail::Call call("norma_compare_summary", options, 0);
    call.end(norma_compare_summary(
        samples.data(), samples.size(), max_angle_rad, call.c(), &comparison));
    return comparison;
}

// ---- unit vectors in few bits

inline double encoding_error_rad(Encoding encoding) {
    return norma_encoding_error_rad(static_cast<norma_encoding>(encoding));
}
inline std::vector<std::uint32_t> encode_normals(
    const Vectors &normals, Encoding encoding, Report *report = nullptr) {
    std::vector<std::uint32_t> codes(normals.size());
    detail::check("norma_encode_normals",
        norma_encode_normals(normals.c(), static_cast<norma_encoding>(encoding), codes.data(), 0,
            codes.size(), report));
    return codes;
}
inline std::vector<Vec3> decode_normals(Span<const std::uint32_t> codes, Encoding encoding) {
    std::vector<Vec3> normals(codes.size());
    detail::check("norma_decode_normals",
        norma_decode_normals(codes.data(), 0, codes.size(), static_cast<norma_encoding>(encoding),
            detail::floats(normals).data(), 0));
    return normals;
}

// ---- tangents

// x, y, z and sign for each corner. options.stride of the form with `out`: 0 means 16.
inline std::vector<Vec4> corner_tangents(const Mesh &mesh, const Normals &normals,
    const Texcoords &texcoords, TangentMode mode, const Options &options = {},
    Report *report = nullptr) {
    normals.require_corners("norma_corner_tangents", mesh.corner_count());
    texcoords.require_corners("norma_corner_tangents", mesh.corner_count());
    std::vector<Vec4> tangents(mesh.corner_count());
    detail::Call call("norma_corner_tangents", options, tangents.size());
    call.end(norma_corner_tangents(&mesh.c(), &normals.c(), &texcoords.c(),
                 static_cast<norma_tangent_mode>(mode), call.c(), detail::floats(tangents).data(),
                 tangents.size(), report),
        mesh.c());
    return tangents;
}

// A graphics card's mesh.
struct Built {
    std::vector<std::uint32_t> corners;         // the new vertex of each corner
    std::vector<std::uint32_t> source_corners;  // the first corner of each new vertex
    std::vector<std::uint32_t> source_vertices; // the position of each new vertex
    std::vector<Vec3> normals;                  // of each new vertex
    std::vector<Vec4> tangents;                 // of each new vertex; empty without texcoords
};
// texcoords: NULL for no tangents.
inline Built build(const Mesh &mesh, const Texcoords *texcoords, float crease_angle_rad,
    TangentMode mode, const Options &options = {}, Report *report = nullptr) {
    if (texcoords) texcoords->require_corners("norma_build", mesh.corner_count());
    const std::size_t corners = mesh.corner_count(); // no more vertices than corners
    Built made{std::vector<std::uint32_t>(corners), std::vector<std::uint32_t>(corners),
        std::vector<std::uint32_t>(corners), std::vector<Vec3>(corners),
        std::vector<Vec4>(texcoords ? corners : 0)};
    norma_built built{{made.corners.data(), sizeof(std::uint32_t), corners,
                          made.source_corners.data(), corners, 0},
        made.source_vertices.data(), detail::floats(made.normals).data(), 0,
        detail::floats(made.tangents).data(), 0};
    detail::Call call("norma_build", options, corners);
    call.end(norma_build(&mesh.c(), texcoords ? &texcoords->c() : nullptr, crease_angle_rad,
                 static_cast<norma_tangent_mode>(mode), call.c(), &built, report),
        mesh.c(), &crease_angle_rad);
    const std::size_t count = built.indexed.vertex_count;
    made.source_corners.resize(count);
    made.source_vertices.resize(count);
    made.normals.resize(count);
    if (texcoords) made.tangents.resize(count);
    return made;
}

// ---- skins

// Which joints move each vertex, and how much: `influences` joints and weights for each vertex.
class Skin {
  public:
    template <class Joint>
    Skin(Span<const float> matrices, Span<const Joint> joints, Span<const float> weights,
        std::size_t influences, Blend blend = Blend::linear)
        : skin_{matrices.data(), matrices.size() / 16, joints.data(), sizeof(Joint), weights.data(),
              influences, influences ? joints.size() / influences : 0,
              static_cast<norma_blend>(blend)} {
        static_assert(std::is_unsigned_v<Joint> && sizeof(Joint) <= 4,
            "joints are unsigned integers of 8, 16 or 32 bits");
        detail::require(
            matrices.size() % 16 == 0, "norma::Skin", "matrices", "sixteen floats each");
        detail::require(influences > 0 && joints.size() % influences == 0, "norma::Skin", "joints",
            "as many for each vertex as influences says");
        detail::require(
            joints.size() == weights.size(), "norma::Skin", "weights", "as many as joints");
    }
    std::vector<Vec3> positions(const Vectors &in, const Options &options = {}) const {
        std::vector<Vec3> out(skin_.vertex_count);
        detail::Call call("norma_skin_positions", options, out.size());
        end(call,
            norma_skin_positions(&skin_, in.c(), call.c(), detail::floats(out).data(), out.size()));
        return out;
    }
    std::vector<Vec3> normals(
        const Vectors &in, const Options &options = {}, Report *report = nullptr) const {
        std::vector<Vec3> out(skin_.vertex_count);
        detail::Call call("norma_skin_normals", options, out.size());
        end(call, norma_skin_normals(
                      &skin_, in.c(), call.c(), detail::floats(out).data(), out.size(), report));
        return out;
    }
    std::vector<Vec4> tangents(
        Span<const Vec4> in, const Vectors &skinned_normals, const Options &options = {}) const {
        detail::require(in.size() == skin_.vertex_count, "norma_skin_tangents", "in",
            "one tangent for each vertex");
        std::vector<Vec4> out(skin_.vertex_count);
        detail::Call call("norma_skin_tangents", options, out.size());
        end(call, norma_skin_tangents(&skin_, in.empty() ? nullptr : in[0].data(),
                      skinned_normals.c(), call.c(), detail::floats(out).data(), out.size()));
        return out;
    }
    const norma_skin &c() const noexcept { return skin_; }

  private:
    void end(detail::Call &call, norma_result result) const {
        norma_fault fault{};
        if (result != NORMA_OK && norma_find_skin_fault(&skin_, call.c(), &fault) == result)
            throw Error("norma::Skin", fault);
        call.end(result);
    }
    norma_skin skin_;
};

} // namespace norma
#endif
