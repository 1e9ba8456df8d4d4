// Normal matrices of a million models, and ten million normals through one: Norma, glm, cglm,
// Eigen. A million vertices of a skin, each moved by four of 64 joints: Norma, glm.
#include "rival.hpp"
#include <Eigen/Dense>
#include <cglm/cglm.h>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

using namespace rival;

static const size_t MODELS = 1000000, NORMALS = 10000000, SKINNED = 1000000, JOINTS = 64;

static std::vector<float> make_models() {
    std::vector<float> models(16 * MODELS);
    uint32_t state = 1;
    for (float &number : models) {
        state = state * 1664525u + 1013904223u;
        number = float(state >> 8) / 8388608.0f - 1;
    }
    return models;
}

static void many_matrices() {
    const std::vector<float> models = make_models();
    std::vector<float> out(9 * MODELS);
    const double copy = copy_seconds(50 * MODELS);
    auto tell = [&](const char *library, const char *call, const std::function<void()> &work) {
        print(library, call, "-", "-", MODELS,
            least(
                7, [] {}, work),
            copy, -1);
    };
    tell("Norma", "normal matrices", [&] {
        norma_normal_matrices(models.data(), MODELS, NORMA_WINDING_REVERSED, out.data(), MODELS);
    });
    tell("glm", "inverseTranspose(mat3)", [&] {
        for (size_t i = 0; i < MODELS; ++i) {
            const glm::mat3 m = glm::inverseTranspose(glm::mat3(glm::make_mat4(&models[16 * i])));
            std::memcpy(&out[9 * i], glm::value_ptr(m), 36);
        }
    });
    tell("cglm", "mat3_inv, transpose", [&] {
        for (size_t i = 0; i < MODELS; ++i) {
            CGLM_ALIGN_MAT mat4 model;
            CGLM_ALIGN_MAT mat3 m;
            std::memcpy(model, &models[16 * i], 64);
            glm_mat4_pick3(model, m);
            glm_mat3_inv(m, m);
            glm_mat3_transpose(m);
            std::memcpy(&out[9 * i], m, 36);
        }
    });
    tell("Eigen", "inverse().transpose()", [&] {
        for (size_t i = 0; i < MODELS; ++i)
            Eigen::Map<Eigen::Matrix3f>{&out[9 * i]} =
                Eigen::Map<const Eigen::Matrix4f>{&models[16 * i]}
                    .topLeftCorner<3, 3>()
                    .inverse()
                    .transpose();
    });
}

static void many_normals() {
    const float matrix[9] = {0.5f, 0.1f, 0, -0.2f, 1.5f, 0.3f, 0, 0.25f, 2};
    std::vector<float> in(3 * NORMALS), out(3 * NORMALS);
    for (size_t i = 0; i < NORMALS; ++i) {
        const double z = std::cos(double(i) * 0.3), r = std::sqrt(1 - z * z), a = double(i) * 0.7;
        in[3 * i] = float(r * std::cos(a)), in[3 * i + 1] = float(r * std::sin(a)),
               in[3 * i + 2] = float(z);
    }
    const double copy = copy_seconds(12 * NORMALS);
    auto tell = [&](const char *library, const char *call, const std::function<void()> &work) {
        print(library, call, "-", "-", NORMALS,
            least(
                5, [] {}, work),
            copy, -1);
    };
    tell("Norma", "transform normals", [&] {
        norma_transform_normals(
            matrix, {in.data(), NORMALS, 0, NORMA_FORMAT_FLOAT}, out.data(), 0, NORMALS);
    });
    const glm::mat3 glm_matrix = glm::make_mat3(matrix);
    tell("glm", "normalize(mat3 * vec3)", [&] {
        for (size_t i = 0; i < NORMALS; ++i) {
            const glm::vec3 n = glm::normalize(glm_matrix * glm::make_vec3(&in[3 * i]));
            std::memcpy(&out[3 * i], glm::value_ptr(n), 12);
        }
    });
    CGLM_ALIGN_MAT mat3 cglm_matrix;
    std::memcpy(cglm_matrix, matrix, 36);
    tell("cglm", "mat3_mulv, normalize", [&] {
        for (size_t i = 0; i < NORMALS; ++i) {
            glm_mat3_mulv(cglm_matrix, &in[3 * i], &out[3 * i]);
            glm_vec3_normalize(&out[3 * i]);
        }
    });
    const Eigen::Matrix3f eigen_matrix = Eigen::Map<const Eigen::Matrix3f>(matrix);
    tell("Eigen", "(M * n).normalized()", [&] {
        for (size_t i = 0; i < NORMALS; ++i)
            Eigen::Map<Eigen::Vector3f>{&out[3 * i]} =
                (eigen_matrix * Eigen::Map<const Eigen::Vector3f>{&in[3 * i]}).normalized();
    });
}

// Joints turn and stretch, so that the normal matrix of a blend is not the blend itself.
static std::vector<glm::mat4> make_joints() {
    std::vector<glm::mat4> joints(JOINTS);
    for (size_t j = 0; j < JOINTS; ++j) {
        const float a = float(j);
        const glm::vec3 axis(std::cos(a), std::sin(a), .5f);
        joints[j] = glm::rotate(glm::translate(glm::mat4(1), axis), .02f * a, glm::normalize(axis));
        joints[j] = glm::scale(joints[j], glm::vec3(1, 1 + .01f * a, 1.5f));
    }
    return joints;
}

static void skinned_vertices() {
    const std::vector<glm::mat4> matrices = make_joints();
    std::vector<uint16_t> joints(4 * SKINNED);
    std::vector<float> weights(4 * SKINNED), in(3 * SKINNED), out(3 * SKINNED);
    uint32_t state = 1;
    const auto random = [&state] { return (state = state * 1664525u + 1013904223u) >> 8; };
    for (size_t i = 0; i < SKINNED; ++i) {
        const glm::vec3 v(float(random()) - 8e6f, float(random()) - 8e6f, float(random()) - 8e6f);
        std::memcpy(&in[3 * i], glm::value_ptr(glm::normalize(v)), 12);
        const glm::vec4 w(random(), random(), random(), random());
        std::memcpy(&weights[4 * i], glm::value_ptr(w / (w.x + w.y + w.z + w.w)), 16);
        for (size_t k = 0; k < 4; ++k) joints[4 * i + k] = uint16_t(random() % JOINTS);
    }
    norma_skin skin = {};
    skin.matrices = glm::value_ptr(matrices[0]), skin.joint_count = JOINTS;
    skin.joints = joints.data(), skin.weights = weights.data();
    skin.influences = 4, skin.vertex_count = SKINNED;
    norma_options one_thread = {};
    one_thread.struct_size = sizeof one_thread, one_thread.threads = 1;
    const norma_vec3_view view = {in.data(), SKINNED, 0, NORMA_FORMAT_FLOAT};
    const double copy = copy_seconds(24 * SKINNED); // 12 + 8 + 16 bytes are read, 12 written
    auto tell = [&](const char *library, const char *call, const std::function<void()> &work) {
        print(library, call, "-", "-", SKINNED,
            least(
                15, [] {}, work),
            copy, -1);
    };
    const auto blend = [&](size_t i) {
        const uint16_t *j = &joints[4 * i];
        const float *w = &weights[4 * i];
        return w[0] * matrices[j[0]] + w[1] * matrices[j[1]] + w[2] * matrices[j[2]] +
               w[3] * matrices[j[3]];
    };
    tell("Norma", "skinned positions",
        [&] { norma_skin_positions(&skin, view, &one_thread, out.data(), SKINNED); });
    tell("glm", "blended mat4 * vec4", [&] {
        for (size_t i = 0; i < SKINNED; ++i) {
            const glm::vec3 p = blend(i) * glm::vec4(glm::make_vec3(&in[3 * i]), 1);
            std::memcpy(&out[3 * i], glm::value_ptr(p), 12);
        }
    });
    tell("Norma", "skinned normals",
        [&] { norma_skin_normals(&skin, view, &one_thread, out.data(), SKINNED, nullptr); });
    tell("glm", "normalize(inverseTranspose(mat3(blend)) * vec3)", [&] {
        for (size_t i = 0; i < SKINNED; ++i) {
            const glm::vec3 n = glm::normalize(
                glm::inverseTranspose(glm::mat3(blend(i))) * glm::make_vec3(&in[3 * i]));
            std::memcpy(&out[3 * i], glm::value_ptr(n), 12);
        }
    });
    std::vector<float> tangents(4 * SKINNED), turned(4 * SKINNED);
    for (size_t i = 0; i < SKINNED; ++i) {
        const glm::vec3 t = glm::normalize(glm::cross(glm::make_vec3(&in[3 * i]), {.1f, .2f, .3f}));
        std::memcpy(&tangents[4 * i], glm::value_ptr(t), 12), tangents[4 * i + 3] = 1;
    }
    tell("Norma", "skinned tangents", [&] {
        norma_skin_tangents(&skin, tangents.data(), {out.data(), SKINNED, 0, NORMA_FORMAT_FLOAT},
            &one_thread, turned.data(), SKINNED);
    });
    tell("glm", "mat3(blend) * vec3, made perpendicular", [&] {
        for (size_t i = 0; i < SKINNED; ++i) {
            const glm::vec3 n = glm::make_vec3(&out[3 * i]);
            const glm::mat3 b(blend(i));
            glm::vec3 t = b * glm::make_vec3(&tangents[4 * i]);
            t = glm::normalize(t - glm::dot(n, t) * n);
            const glm::vec4 all(
                t, glm::determinant(b) < 0 ? -tangents[4 * i + 3] : tangents[4 * i + 3]);
            std::memcpy(&turned[4 * i], glm::value_ptr(all), 16);
        }
    });
}

int main() {
    many_matrices();
    many_normals();
    skinned_vertices();
    return 0;
}
