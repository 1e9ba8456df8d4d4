/* shader_judge.c: inputs for the functions of norma.glsl, norma.hlsl and norma.wgsl, and whether
 * what they gave for them is what the core gives.
 *
 *   shader_judge make COUNT FILE      writes COUNT records of INPUTS vec4
 *   shader_judge judge IN OUT NAME    reads them and COUNT records of OUTPUTS vec4; speaks TAP
 *
 * A function is judged by the arguments that it had: the normal by the normal matrix that the
 * shader computed, the tangent by its normal. Allowed is 1e-6, and where a sum cancels, so that
 * rounding its terms to floats says less, TERMS of those terms. */
#include <math.h>
#include <norma/norma.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { INPUTS = 12, OUTPUTS = 14 };

typedef struct record {
    float model[3][4]; /* columns; the fourth of the first two: weights of a skin */
    float normal[4], tangent[4];
    float texel[4]; /* the fourth: scale */
    float second[3][4];
    float along_x[4], along_y[4]; /* the first's x and y: octahedral too; its fourth: front */
    uint32_t code[4];
} record;

typedef struct result {
    float matrix[3][4]; /* the fourth of the first: the mirror's sign */
    float normal[4], tangent[4], instance[4], skin[4];
    float octahedral[3][4], packed[4];
    float perturbed[4], flat[4], read[4];
} result;

_Static_assert(sizeof(record) == INPUTS * 16 && sizeof(result) == OUTPUTS * 16, "vec4s in a row");

/* ---- inputs */

static uint64_t state = 1;

static uint32_t next(void) { /* Steele, Lea, Flood 2014 */
    uint64_t z = state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (uint32_t)(z >> 32);
}

static double between(double low, double high) {
    return low + (high - low) * next() / 4294967296.0;
}
static int whole(int most) { return (int)(next() % (2u * (unsigned)most + 1)) - most; }

static void random_unit(double *v, int count) {
    double square;
    do {
        square = 0;
        for (int i = 0; i < count; ++i) v[i] = between(-1, 1), square += v[i] * v[i];
    } while (square > 1 || square < 1e-4);
    for (int i = 0; i < count; ++i) v[i] /= sqrt(square);
}

static void random_rotation(double m[9]) {
    double q[4];
    random_unit(q, 4);
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double r[9] = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w),
        2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 2 * (x * z + y * w),
        2 * (y * z - x * w), 1 - 2 * (x * x + y * y)};
    memcpy(m, r, sizeof r);
}

/* A rotation, stretches along the axes, and a rotation before them where it is asked for. */
static void random_affine(double m[9], const double stretch[3], int sheared) {
    double left[9], right[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    random_rotation(left);
    if (sheared) random_rotation(right);
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) {
            m[3 * c + r] = 0;
            for (int k = 0; k < 3; ++k)
                m[3 * c + r] += left[3 * k + r] * stretch[k] * right[3 * c + k];
        }
}

static void whole_numbers(double m[9], int rank) {
    for (int i = 0; i < 9; ++i) m[i] = whole(8);
    for (int r = 0; r < 3; ++r) {
        if (rank == 1) m[3 + r] = -3 * m[r];
        m[6 + r] = 2 * m[r] - m[3 + r];
    }
}

enum kind {
    UNIFORM,
    STRETCHED,
    SHEARED,
    MIRRORED,
    ANY,
    FLATTENED,
    RANK_2,
    RANK_1,
    HUGE_OR_TINY,
    AXES_FAR_APART,
    NOT_FINITE,
    NO_NORMAL,
    KINDS
};

static void make_model(enum kind kind, double m[9]) {
    double s[3];
    const double all = exp2(between(-6, 6));
    for (int i = 0; i < 3; ++i) s[i] = kind == UNIFORM ? all : exp2(between(-5, 5));
    if (kind == MIRRORED) s[0] = -s[0];
    random_affine(m, s, kind != STRETCHED && kind != AXES_FAR_APART);
    if (kind == ANY)
        for (int i = 0; i < 9; ++i) m[i] = between(-1, 1);
    if (kind == FLATTENED) memset(m + 3 * (next() % 3), 0, 3 * sizeof *m);
    if (kind == RANK_2 || kind == RANK_1) whole_numbers(m, kind == RANK_2 ? 2 : 1);
    if (kind == HUGE_OR_TINY) {
        const double power = exp2(whole(1) * 100);
        for (int i = 0; i < 9; ++i) m[i] *= power;
    }
    if (kind == AXES_FAR_APART)
        for (int i = 0; i < 9; ++i) m[i] *= exp2(i / 3 * 20 - 20);
    if (kind == NOT_FINITE) m[next() % 9] = next() % 2 ? (double)NAN : (double)INFINITY;
}

static void columns(const double m[9], float out[3][4]) {
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) out[c][r] = (float)m[3 * c + r];
}

static void make_record(size_t number, record *r) {
    const enum kind kind = (enum kind)(number % KINDS);
    const double little[3] = {between(0.5, 2), between(0.5, 2), between(-2, -0.5)};
    double m[9], v[4];
    memset(r, 0, sizeof *r);
    make_model(kind, m);
    columns(m, r->model);
    random_affine(m, little, 1);
    columns(m, r->second);
    r->model[0][3] = kind == UNIFORM || kind == SHEARED ? (float)between(0, 1) : 1.0f;
    r->model[1][3] = r->model[0][3] < 1.0f ? 1.0f - r->model[0][3] : 0.0f;
    random_unit(v, 3);
    for (int i = 0; i < 3; ++i) r->normal[i] = kind == NO_NORMAL ? 0.0f : (float)v[i];
    random_unit(v, 3);
    const int along = number % 37 == 0;
    for (int i = 0; i < 3; ++i) r->tangent[i] = along ? -2.0f * r->normal[i] : (float)v[i];
    r->tangent[3] = next() % 2 ? 1.0f : -1.0f;
    for (int i = 0; i < 3; ++i) r->texel[i] = (float)(next() % 256) / 255.0f;
    r->texel[3] = (float)between(0, 2);
    for (int i = 0; i < 3; ++i) {
        r->along_x[i] = (float)between(-1, 1);
        r->along_y[i] = (float)between(-1, 1);
    }
    r->along_x[3] = next() % 2 ? 1.0f : 0.0f;
    r->code[0] = next();
}

/* ---- judging */

#define ALLOWED 1e-6
#define TERMS   3e-7

typedef struct verdict {
    const char *function;
    size_t count, wrong, first;
    double worst; /* of what is allowed */
} verdict;

static double length3(const double *v) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

static double distance(const float *a, const float *b) {
    const double d[3] = {(double)a[0] - b[0], (double)a[1] - b[1], (double)a[2] - b[2]};
    return length3(d);
}

/* left: what cancelling left of the terms, 1 where nothing did. */
static void judge(verdict *v, size_t number, double error, double left) {
    const double share = error / fmax(ALLOWED, left > 0 ? TERMS / left : 2);
    ++v->count;
    if (share > v->worst) v->worst = share;
    if (share <= 1) return;
    if (!v->wrong++) v->first = number;
}

static void model_of(const float columns_of[3][4], float model[16]) {
    memset(model, 0, 16 * sizeof *model);
    for (int c = 0; c < 3; ++c) memcpy(model + 4 * c, columns_of[c], 3 * sizeof *model);
    model[15] = 1;
}

static int is_finite(const float model[16]) {
    for (int i = 0; i < 16; ++i)
        if (!isfinite(model[i])) return 0;
    return 1;
}

static norma_vec3_view one_vector(const float *v) {
    return (norma_vec3_view){.data = v, .count = 1};
}

/* m v and how much of its terms is left. */
static double left_of(const double m[9], const float *v) {
    double sum[3], terms[3];
    for (int r = 0; r < 3; ++r) {
        sum[r] = terms[r] = 0;
        for (int c = 0; c < 3; ++c) {
            sum[r] += m[3 * c + r] * (double)v[c];
            terms[r] += fabs(m[3 * c + r] * (double)v[c]);
        }
    }
    return length3(terms) > 0 ? length3(sum) / length3(terms) : 0;
}

static void cofactors(const double m[9], double out[9], double *determinant, double *left) {
    double terms = 0, sum = 0;
    for (int c = 0; c < 3; ++c) {
        const double *a = m + 3 * ((c + 1) % 3), *b = m + 3 * ((c + 2) % 3);
        for (int r = 0; r < 3; ++r) {
            const int i = (r + 1) % 3, k = (r + 2) % 3;
            out[3 * c + r] = a[i] * b[k] - a[k] * b[i];
            sum = fmax(sum, fabs(out[3 * c + r]));
            terms = fmax(terms, fabs(a[i] * b[k]) + fabs(a[k] * b[i]));
        }
    }
    *determinant = m[0] * out[0] + m[1] * out[1] + m[2] * out[2];
    *left = terms > 0 ? sum / terms : 0;
}

enum {
    MATRIX,
    MIRROR,
    NORMAL,
    TANGENT,
    INSTANCE,
    SKIN,
    OCT8,
    OCT12,
    OCT16,
    PACKED,
    PERTURB,
    FLAT,
    OCTAHEDRAL,
    FUNCTIONS
};

static void judge_matrix(verdict *v, size_t number, const float model[16], const result *given) {
    float core[9], most = 0, most_given = 0;
    double error = 0, m[9], cofactor[9], determinant, left;
    norma_normal_matrix(model, NORMA_WINDING_REVERSED, core, NULL);
    for (int i = 0; i < 9; ++i) {
        most = fmaxf(most, fabsf(core[i]));
        most_given = fmaxf(most_given, fabsf(given->matrix[i / 3][i % 3]));
    }
    for (int i = 0; i < 9; ++i) {
        const float g = given->matrix[i / 3][i % 3];
        const double a = most > 0 ? (double)core[i] / (double)most : 0,
                     b = most_given > 0 ? (double)g / (double)most_given : 0;
        error = isfinite(g) ? fmax(error, fabs(a - b)) : 2;
    }
    judge(&v[MATRIX], number, error, 1);
    if (!is_finite(model)) return;
    for (int i = 0; i < 9; ++i) m[i] = (double)model[i / 3 * 4 + i % 3];
    cofactors(m, cofactor, &determinant, &left);
    judge(&v[MIRROR], number, given->matrix[0][3] == (determinant < 0 ? -1.0f : 1.0f) ? 0 : 1, 1);
}

static void judge_normal(verdict *v, size_t number, const record *r, const result *given) {
    float matrix[9], core[3];
    for (int i = 0; i < 9; ++i) matrix[i] = given->matrix[i / 3][i % 3];
    norma_transform_normals(matrix, one_vector(r->normal), core, 0, 1);
    judge(&v[NORMAL], number, distance(core, given->normal), 1);
}

static void judge_tangent(
    verdict *v, size_t number, const record *r, const float model[16], const result *given) {
    float core[4];
    double m[9], t[3] = {0}, along = 0, across;
    for (int i = 0; i < 9; ++i) m[i] = (double)model[i / 3 * 4 + i % 3];
    for (int i = 0; i < 9; ++i) t[i % 3] += m[i] * (double)r->tangent[i / 3];
    const double size = length3(t);
    for (int i = 0; i < 3; ++i) along += t[i] / size * (double)given->normal[i];
    across = sqrt(fmax(0, 1 - along * along));
    norma_transform_tangents(model, r->tangent, 0, one_vector(given->normal), 1, core, 0, 1);
    const double error = distance(core, given->tangent),
                 off = fabs((double)given->tangent[0] * (double)given->normal[0] +
                            (double)given->tangent[1] * (double)given->normal[1] +
                            (double)given->tangent[2] * (double)given->normal[2]);
    /* About 2^-20 is left: whether it still is a direction, rounding decides. */
    const int open = !(across > 4e-6) && across > 1e-7;
    judge(&v[TANGENT], number, core[3] == given->tangent[3] ? fmax(open ? 0 : error, off) : 2,
        size > 0 && across > 4e-6 ? across * left_of(m, r->tangent) : 1);
}

static void judge_instance(
    verdict *v, size_t number, const record *r, const float model[16], const result *given) {
    float second[16], matrix[9], core[3];
    double cv[9], cm[9], a[9], b[9], d, left_a, left_b;
    model_of(r->second, second);
    norma_normal_matrix_model_view(second, model, NORMA_WINDING_REVERSED, matrix, NULL);
    norma_transform_normals(matrix, one_vector(r->normal), core, 0, 1);
    for (int i = 0; i < 9; ++i) {
        a[i] = (double)model[i / 3 * 4 + i % 3];
        b[i] = (double)second[i / 3 * 4 + i % 3];
    }
    cofactors(a, cv, &d, &left_a);
    cofactors(b, cm, &d, &left_b);
    double first[3] = {0}, sum[3] = {0}, terms[3] = {0};
    for (int i = 0; i < 9; ++i) first[i % 3] += cm[i] * (double)r->normal[i / 3];
    for (int i = 0; i < 9; ++i) {
        sum[i % 3] += cv[i] * first[i / 3];
        terms[i % 3] += fabs(cv[i]) * length3(first);
    }
    judge(&v[INSTANCE], number, distance(core, given->instance),
        length3(terms) > 0 ? length3(sum) / length3(terms) : 1);
}

static void judge_skin(
    verdict *v, size_t number, const record *r, const float model[16], const result *given) {
    float matrices[32], core[3], weights[2] = {r->model[0][3], r->model[1][3]};
    const uint16_t joints[2] = {0, 1};
    double blended[9], cofactor[9], d, left, size = 0, sum[3] = {0};
    memcpy(matrices, model, 16 * sizeof *model);
    model_of(r->second, matrices + 16);
    const norma_skin skin = {.matrices = matrices,
        .joint_count = 2,
        .joints = joints,
        .weights = weights,
        .influences = 2,
        .vertex_count = 1};
    if (norma_skin_normals(&skin, one_vector(r->normal), NULL, core, 1, NULL)) exit(1);
    for (int i = 0; i < 9; ++i) {
        const int at = i / 3 * 4 + i % 3;
        blended[i] =
            (double)weights[0] * (double)model[at] + (double)weights[1] * (double)matrices[16 + at];
        size = fmax(size, (double)weights[0] * fabs((double)model[at]) +
                              (double)weights[1] * fabs((double)matrices[16 + at]));
    }
    cofactors(blended, cofactor, &d, &left);
    for (int i = 0; i < 9; ++i) sum[i % 3] += cofactor[i] * (double)r->normal[i / 3];
    /* The matrix is rounded when it is blended; that of one joint alone is not, but its normal
     * matrix is. */
    judge(&v[SKIN], number, distance(core, given->skin),
        weights[1] > 0 ? length3(sum) / (2 * size * size) : left_of(cofactor, r->normal));
}

static void judge_codes(verdict *v, size_t number, const record *r, const result *given) {
    static const norma_encoding encodings[] = {
        NORMA_ENCODING_OCT8, NORMA_ENCODING_OCT12, NORMA_ENCODING_OCT16, NORMA_ENCODING_10_10_10_2};
    for (int i = 0; i < 4; ++i) {
        float core[3];
        norma_decode_normals(r->code, 0, 1, encodings[i], core, 0);
        judge(
            &v[OCT8 + i], number, distance(core, i < 3 ? given->octahedral[i] : given->packed), 1);
    }
}

static void unit_of(const double v[3], float out[3]) {
    const double size = length3(v);
    for (int i = 0; i < 3; ++i) out[i] = size > 0 ? (float)(v[i] / size) : 0.0f;
}

static void cross(const float *a, const float *b, double out[3]) {
    for (int i = 0; i < 3; ++i) {
        const int k = (i + 1) % 3, l = (i + 2) % 3;
        out[i] = (double)a[k] * (double)b[l] - (double)a[l] * (double)b[k];
    }
}

/* What the core has no function for is judged by its definition, in doubles. */
static void judge_pixels(verdict *v, size_t number, const record *r, const result *given) {
    double across[3], sum[3], terms[3], bent[3], x = (double)r->along_x[0],
                                                 y = (double)r->along_x[1];
    float unit[3];
    cross(r->normal, r->tangent, across);
    for (int i = 0; i < 3; ++i)
        bent[i] = (2 * (double)r->texel[i] - 1) * (i < 2 ? (double)r->texel[3] : 1);
    for (int i = 0; i < 3; ++i) {
        const double part[3] = {bent[0] * (double)r->tangent[i],
            bent[1] * (double)r->tangent[3] * across[i], bent[2] * (double)r->normal[i]};
        sum[i] = part[0] + part[1] + part[2];
        terms[i] = fabs(part[0]) + fabs(part[1]) + fabs(part[2]);
    }
    unit_of(sum, unit);
    /* Texels are rounded when 1 is taken from them: that is of 1, not of what is left. */
    judge(&v[PERTURB], number, distance(unit, given->perturbed),
        length3(sum) / fmax(length3(terms), 2 * fmax(1, (double)r->texel[3])));
    cross(r->along_x, r->along_y, sum);
    unit_of(sum, unit);
    judge(&v[FLAT], number, distance(unit, given->flat), length3(sum) / 3);
    const double z = 1 - fabs(x) - fabs(y);
    const double folded[3] = {z < 0 ? (1 - fabs(y)) * (x < 0 ? -1 : 1) : x,
        z < 0 ? (1 - fabs(x)) * (y < 0 ? -1 : 1) : y, z};
    unit_of(folded, unit);
    for (int i = 0; i < 3; ++i) unit[i] = r->along_x[3] > 0 ? unit[i] : -unit[i];
    judge(&v[OCTAHEDRAL], number, distance(unit, given->read), 1);
}

static void judge_record(verdict *v, size_t number, const record *r, const result *given) {
    float model[16];
    const float none[3] = {0};
    model_of(r->model, model);
    judge_matrix(v, number, model, given);
    judge_normal(v, number, r, given);
    if (is_finite(model)) {
        judge_tangent(v, number, r, model, given);
        judge_instance(v, number, r, model, given);
        judge_skin(v, number, r, model, given);
    } else {
        judge(&v[INSTANCE], number, distance(none, given->instance), 1);
        judge(&v[SKIN], number, distance(none, given->skin), 1);
    }
    judge_codes(v, number, r, given);
    judge_pixels(v, number, r, given);
}

/* ---- files */

static int make(size_t count, const char *path) {
    FILE *file = fopen(path, "wb");
    if (!file) return 1;
    for (size_t i = 0; i < count; ++i) {
        record r;
        make_record(i, &r);
        if (fwrite(&r, sizeof r, 1, file) != 1) return 1;
    }
    return fclose(file) != 0;
}

static int judge_files(const char *in_path, const char *out_path, const char *name) {
    verdict v[FUNCTIONS] = {[MATRIX] = {"norma_normal_matrix"},
        [MIRROR] = {"norma_mirror_sign"},
        [NORMAL] = {"norma_transform_normal"},
        [TANGENT] = {"norma_transform_tangent"},
        [INSTANCE] = {"norma_instance_normal"},
        [SKIN] = {"norma_skin_normal"},
        [OCT8] = {"norma_decode_octahedral_8"},
        [OCT12] = {"norma_decode_octahedral_12"},
        [OCT16] = {"norma_decode_octahedral_16"},
        [PACKED] = {"norma_decode_10_10_10_2"},
        [PERTURB] = {"norma_perturb"},
        [FLAT] = {"norma_flat_normal"},
        [OCTAHEDRAL] = {"norma_decode_octahedral, norma_facing_normal"}};
    FILE *in = fopen(in_path, "rb"), *out = fopen(out_path, "rb");
    record r;
    result given;
    size_t count = 0;
    int failed = 0;
    if (!in || !out) return 1;
    for (; fread(&r, sizeof r, 1, in) == 1 && fread(&given, sizeof given, 1, out) == 1; ++count)
        judge_record(v, count, &r, &given);
    const int all = count && fread(&r, 1, 1, in) == 0 && fread(&given, 1, 1, out) == 0;
    printf("1..%d\n%sok 1 - %s: a result for each of %zu inputs\n", FUNCTIONS + 1,
        all ? "" : "not ", name, count);
    for (int i = 0; i < FUNCTIONS; ++i) {
        const int fine = v[i].count && !v[i].wrong;
        failed |= !fine;
        printf("%sok %d - %s: %s: as the core, worst %.2g of what is allowed\n", fine ? "" : "not ",
            i + 2, name, v[i].function, v[i].worst);
        if (!fine)
            printf("# %zu of %zu, first %zu (kind %zu)\n", v[i].wrong, v[i].count, v[i].first,
                v[i].first % KINDS);
    }
    fclose(in);
    fclose(out);
    return failed || !all;
}

int main(int argc, char **argv) {
    if (argc == 4 && strcmp(argv[1], "make") == 0) return make(strtoul(argv[2], NULL, 10), argv[3]);
    if (argc == 5 && strcmp(argv[1], "judge") == 0) return judge_files(argv[2], argv[3], argv[4]);
    fprintf(stderr, "make COUNT FILE or judge IN OUT NAME expected\n");
    return 2;
}
