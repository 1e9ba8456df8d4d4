// Normal matrices of a million models, and ten million normals through one: Norma, glm, cglm,
// Eigen.
#include "rival.hpp"
#include <Eigen/Dense>
#include <cglm/cglm.h>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/type_ptr.hpp>

using namespace rival;

static const size_t MODELS = 1000000, NORMALS = 10000000;

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

int main() {
    many_matrices();
    many_normals();
    return 0;
}
