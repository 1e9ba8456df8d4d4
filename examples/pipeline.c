/* pipeline.c: one vertex and its normal on their way from the object to the viewport, with the
 * light computed in world and in view space. The guide shows these numbers. */
#include <math.h>
#include <norma/norma.h>
#include <stdio.h>

static void print_vector(const char *name, const double *v, int size) {
    printf("%-10s", name);
    for (int i = 0; i < size; ++i) printf(" %8.4f", v[i] == 0 ? 0.0 : v[i]);
    printf("\n");
}

/* out = M p, both with four components, M column-major. */
static void apply(const float m[16], const double p[4], double out[4]) {
    for (int row = 0; row < 4; ++row) {
        out[row] = 0;
        for (int k = 0; k < 4; ++k) out[row] += (double)m[4 * k + row] * p[k];
    }
}

static double facing(const float normal[3], const double light[4]) {
    return normal[0] * light[0] + normal[1] * light[1] + normal[2] * light[2];
}

static void print_normal(const char *name, const float n[3]) {
    const double wide[3] = {(double)n[0], (double)n[1], (double)n[2]};
    print_vector(name, wide, 3);
}

int main(void) {
    /* Stretched twice along x and moved; the eye at (0, 0, 8), turned by 30 degrees about y. */
    const float c = 0.8660254F, s = 0.5F;
    const float model[16] = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1};
    const float view[16] = {c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 0, 0, 0, -8, 1};
    /* 90 degrees of view, near plane 1, far plane 10: OpenGL's perspective. */
    const float clip[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -11.0F / 9, -1, 0, 0, -20.0F / 9, 0};
    const double point[4] = {0.6, 0.8, 0, 1}, sun[4] = {0.6, 0.8, 0, 0};

    double world[4], eye[4], clipped[4], device[3], pixel[2], sun_in_view[4];
    apply(model, point, world);
    apply(view, world, eye);
    apply(clip, eye, clipped);
    for (int i = 0; i < 3; ++i) device[i] = clipped[i] / clipped[3];
    pixel[0] = (device[0] + 1) / 2 * 640;
    pixel[1] = (device[1] + 1) / 2 * 480;
    print_vector("object", point, 3);
    print_vector("world", world, 3);
    print_vector("view", eye, 3);
    print_vector("clip", clipped, 4);
    print_vector("device", device, 3);
    print_vector("viewport", pixel, 2);

    const float normal[3] = {0.6F, 0.8F, 0};
    const norma_vec3_view in = {.data = normal, .count = 1};
    float to_world[9], to_view[9], in_world[3], in_view[3];
    if (norma_normal_matrix(model, NORMA_WINDING_REVERSED, to_world, NULL) != NORMA_OK ||
        norma_normal_matrix_model_view(model, view, NORMA_WINDING_REVERSED, to_view, NULL) ||
        norma_transform_normals(to_world, in, in_world, 0, 1) != NORMA_OK ||
        norma_transform_normals(to_view, in, in_view, 0, 1) != NORMA_OK)
        return 1;
    printf("\n");
    print_normal("normal", normal);
    print_normal("in world", in_world);
    print_normal("in view", in_view);
    apply(view, sun, sun_in_view);
    printf("light on it: %.4f in world space, %.4f in view space\n", facing(in_world, sun),
        facing(in_view, sun_in_view));
    return 0;
}
