/* core.c: every call of norma.h that takes a mesh, with every weight and weld, creases, groups,
 * marked edges, plans, morph targets. */
#include "bits.h"
#include <stdlib.h>
#include <string.h>

static size_t face_count(const norma_mesh *mesh) {
    return mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
}

/* Steps that weld some: a thousandth of the first triangle's longest side along an axis, from the
 * mesh itself. */
static double weld_distance(const norma_mesh *mesh) {
    double largest = 0;
    if (mesh->positions.count < 2 || mesh->positions.format > NORMA_FORMAT_DOUBLE) return 1;
    const size_t size = mesh->positions.format == NORMA_FORMAT_DOUBLE ? 8 : 4,
                 stride = mesh->positions.stride ? mesh->positions.stride : 3 * size;
    for (size_t x = 0; x < 3; ++x) {
        double at[2];
        for (size_t i = 0; i < 2; ++i) {
            const unsigned char *from =
                (const unsigned char *)mesh->positions.data + i * stride + x * size;
            float single;
            memcpy(&single, from, 4);
            at[i] = single;
            if (size == 8) memcpy(&at[i], from, 8);
        }
        const double difference = at[0] < at[1] ? at[1] - at[0] : at[0] - at[1];
        if (difference > largest && difference < 1e30) largest = difference;
    }
    return largest / 4;
}

typedef struct answer {
    size_t count, stride;
    float *normals; /* stride / 4 of each, filled with a pattern between them */
    uint8_t *reasons;
    norma_report report;
    norma_edges edges;
} answer;

static answer room_for(size_t count, size_t stride) {
    return (answer){.count = count,
        .stride = stride,
        .normals = bits_room(count, stride),
        .reasons = bits_room(count, 1)};
}

static void take(answer *a, norma_result result, bits_hash *hash) {
    bits_add(hash, (uint64_t)(int64_t)result);
    if (!result) {
        bits_bytes(hash, a->normals, a->count * a->stride);
        bits_bytes(hash, a->reasons, a->count);
        bits_report(hash, &a->report);
        bits_edges(hash, &a->edges);
    }
    free(a->normals);
    free(a->reasons);
}

static norma_options into(answer *a, norma_options options) {
    options.normal_stride = a->stride;
    options.reasons = a->reasons;
    options.edges = &a->edges;
    return options;
}

static void faces(const bits_mesh *m, norma_options options, bits_hash *hash) {
    answer a = room_for(face_count(&m->mesh), 12);
    options = into(&a, options);
    take(&a, norma_face_normals(&m->mesh, &options, a.normals, a.count, &a.report), hash);
}

static void vertices(const bits_mesh *m, norma_options options, size_t stride, bits_hash *hash) {
    answer a = room_for(m->mesh.positions.count, stride);
    options = into(&a, options);
    take(&a, norma_vertex_normals(&m->mesh, &options, a.normals, a.count, &a.report), hash);
}

static void corners(const bits_mesh *m, float crease, norma_options options, bits_hash *hash) {
    answer a = room_for(m->mesh.corner_count, 12);
    options = into(&a, options);
    take(&a, norma_corner_normals(&m->mesh, crease, &options, a.normals, a.count, &a.report), hash);
}

void bits_faces(const bits_mesh *m, const bits_way *way, bits_hash *hash) {
    norma_options options = bits_options(way);
    options.weld_distance = weld_distance(&m->mesh);
    for (int weld = NORMA_WELD_EXACT; weld <= NORMA_WELD_DISTANCE; ++weld) {
        options.weld = (norma_weld)weld;
        options.fallback = weld == NORMA_WELD_NONE ? NORMA_FALLBACK_NEAREST : NORMA_FALLBACK_ZERO;
        faces(m, options, hash);
    }
}

void bits_vertices(const bits_mesh *m, const bits_way *way, bits_hash *hash) {
    for (int weight = NORMA_WEIGHT_ANGLE; weight <= NORMA_WEIGHT_ANGLE_LENGTHS; ++weight)
        for (int weld = NORMA_WELD_EXACT; weld <= NORMA_WELD_DISTANCE; ++weld) {
            if (m->large && weight + weld > NORMA_WEIGHT_AREA && weld != NORMA_WELD_NONE) continue;
            norma_options options = bits_options(way);
            options.weight = (norma_weight)weight;
            options.weld = (norma_weld)weld;
            options.weld_distance = weld_distance(&m->mesh);
            options.fallback = (norma_fallback)((weight + weld) % 3);
            options.fallback_normal[1] = 1;
            vertices(m, options, weld == NORMA_WELD_NONE ? 20 : 12, hash);
        }
}

static const float CREASES[] = {1.0471976f, -1, 0, .35f, 3.1415927f};

void bits_corners(const bits_mesh *m, const bits_way *way, bits_hash *hash) {
    bits_mesh plain = *m;
    plain.mesh.hard_edges = NULL;
    plain.mesh.smoothing_groups = NULL;
    for (int weight = NORMA_WEIGHT_ANGLE;
         weight <= (m->large ? NORMA_WEIGHT_AREA : NORMA_WEIGHT_ANGLE_LENGTHS); ++weight) {
        norma_options options = bits_options(way);
        options.weight = (norma_weight)weight;
        options.weld_distance = weld_distance(&m->mesh);
        options.fallback = weight % 2 ? NORMA_FALLBACK_NEAREST : NORMA_FALLBACK_ZERO;
        corners(m, CREASES[0], options, hash);
        if (m->large || weight % 3) continue;
        for (size_t i = 1; i < sizeof CREASES / sizeof *CREASES; ++i)
            corners(i % 2 ? &plain : m, CREASES[i], options, hash);
        options.non_manifold = NORMA_NON_MANIFOLD_SMOOTH;
        corners(m, CREASES[0], options, hash);
        for (int weld = NORMA_WELD_NONE; weld <= NORMA_WELD_DISTANCE; ++weld) {
            options.weld = (norma_weld)weld;
            corners(m, CREASES[0], options, hash);
        }
    }
}

void bits_split(const bits_mesh *m, const bits_way *way, bits_hash *hash) {
    const size_t count = m->mesh.corner_count;
    for (int fallback = NORMA_FALLBACK_ZERO; fallback <= NORMA_FALLBACK_NEAREST; ++fallback) {
        answer a = room_for(count, 12);
        uint32_t *at = bits_room(count, 4), *sources = bits_room(count, 4);
        size_t made = 0;
        norma_options options = into(&a, bits_options(way));
        options.fallback = (norma_fallback)fallback;
        const norma_result result = norma_split(
            &m->mesh, CREASES[0], &options, at, count, sources, a.normals, count, &made, &a.report);
        bits_size(hash, made);
        if (!result) {
            bits_bytes(hash, at, 4 * count);
            bits_bytes(hash, sources, 4 * made);
        }
        take(&a, result, hash);
        free(at);
        free(sources);
    }
}

/* ---- meshes that move */

/* The same positions, some of them elsewhere: by a rounding-free part of themselves, or where they
 * were. */
static double *moved_positions(
    const norma_mesh *mesh, uint64_t seed, uint32_t *moved, size_t *moved_count) {
    const norma_vec3_view *view = &mesh->positions;
    static const size_t sizes[] = {4, 8, 1, 1, 2, 2};
    const size_t size = sizes[view->format], stride = view->stride ? view->stride : 3 * size;
    double *positions = bits_room(3 * view->count, sizeof *positions);
    *moved_count = 0;
    for (size_t i = 0; i < view->count; ++i) {
        const int moves = bits_random(&seed) % 8 == 0;
        const double by = 1 + (double)(bits_random(&seed) % 64) / 512;
        for (size_t x = 0; x < 3; ++x) {
            const unsigned char *from = (const unsigned char *)view->data + i * stride + x * size;
            float single = 0;
            double value = 0;
            int8_t i8;
            uint8_t u8;
            int16_t i16;
            uint16_t u16;
            switch (view->format) {
            case NORMA_FORMAT_FLOAT:
                memcpy(&single, from, 4);
                value = single;
                break;
            case NORMA_FORMAT_DOUBLE:
                memcpy(&value, from, 8);
                break;
            case NORMA_FORMAT_INT8:
                memcpy(&i8, from, 1);
                value = i8;
                break;
            case NORMA_FORMAT_UINT8:
                memcpy(&u8, from, 1);
                value = u8;
                break;
            case NORMA_FORMAT_INT16:
                memcpy(&i16, from, 2);
                value = i16;
                break;
            case NORMA_FORMAT_UINT16:
                memcpy(&u16, from, 2);
                value = u16;
                break;
            }
            positions[3 * i + x] = moves ? value * by : value;
        }
        if (moves) moved[(*moved_count)++] = (uint32_t)i;
    }
    return positions;
}

static void update(const norma_plan *plan, norma_vec3_view positions, const uint32_t *moved,
    size_t moved_count, norma_options options, size_t count, bits_hash *hash) {
    answer a = room_for(count, 12);
    options = into(&a, options);
    options.edges = NULL;
    take(&a,
        norma_plan_update(
            plan, positions, moved, moved_count, &options, a.normals, count, &a.report),
        hash);
}

static void plan(const bits_mesh *m, const bits_way *way, norma_element of, float crease,
    norma_weight weight, bits_hash *hash) {
    norma_plan *made = NULL;
    norma_edges edges = {0};
    norma_options options = bits_options(way);
    options.edges = &edges;
    const norma_result result = norma_plan_create(&m->mesh, of, crease, &options, &made);
    bits_add(hash, (uint64_t)(int64_t)result);
    if (result) return;
    const size_t count = of == NORMA_PER_VERTEX ? m->mesh.positions.count : m->mesh.corner_count;
    size_t moved_count;
    uint32_t *moved = bits_room(m->mesh.positions.count, sizeof *moved);
    double *positions = moved_positions(&m->mesh, 21, moved, &moved_count);
    const norma_vec3_view view = {positions, m->mesh.positions.count, 0, NORMA_FORMAT_DOUBLE};
    bits_edges(hash, &edges);
    options.weight = weight;
    update(made, m->mesh.positions, NULL, 0, options, count, hash);
    update(made, view, NULL, 0, options, count, hash);
    update(made, view, moved, moved_count, options, count,
        hash); /* what is not written keeps the pattern */
    update(made, view, moved, moved_count / 50, options, count, hash);
    norma_plan_destroy(made);
    free(positions);
    free(moved);
}

void bits_plans(const bits_mesh *m, const bits_way *way, bits_hash *hash) {
    plan(m, way, NORMA_PER_VERTEX, 3.1415927f, NORMA_WEIGHT_ANGLE, hash);
    plan(m, way, NORMA_PER_CORNER, CREASES[0], NORMA_WEIGHT_ANGLE, hash);
    if (m->large) return;
    plan(m, way, NORMA_PER_VERTEX, CREASES[0], NORMA_WEIGHT_AREA, hash);
    for (int weight = NORMA_WEIGHT_UNIFORM; weight <= NORMA_WEIGHT_ANGLE_LENGTHS; ++weight)
        plan(m, way, weight % 2 ? NORMA_PER_VERTEX : NORMA_PER_CORNER, CREASES[3],
            (norma_weight)weight, hash);
}

void bits_morphs(const bits_mesh *m, const bits_way *way, bits_hash *hash) {
    const size_t count = m->mesh.positions.count;
    size_t moved_count, starts[3] = {0};
    uint32_t *moved = bits_room(count, sizeof *moved), *at = bits_room(2 * count, sizeof *at);
    double *first = moved_positions(&m->mesh, 34, moved, &moved_count),
           *second = moved_positions(&m->mesh, 55, moved, &moved_count);
    float *deltas = bits_room(6 * count, sizeof *deltas);
    const norma_vec3_view targets[2] = {
        {first, count, 0, NORMA_FORMAT_DOUBLE}, {second, count, 0, NORMA_FORMAT_DOUBLE}};
    const norma_options options = bits_options(way);
    const norma_result result = norma_morph_normals(
        &m->mesh, NULL, targets, 2, 1e-3f, &options, starts, at, deltas, 2 * count);
    bits_add(hash, (uint64_t)(int64_t)result);
    if (!result) {
        for (int t = 0; t < 3; ++t) bits_size(hash, starts[t]);
        bits_bytes(hash, at, 4 * starts[2]);
        bits_floats(hash, deltas, 3 * starts[2]);
    }
    free(moved);
    free(at);
    free(first);
    free(second);
    free(deltas);
}

enum { MOST_FOR_RAYS = 1500 }; /* corners: 256 rays for each open part, through all others */

void bits_orient(const bits_mesh *m, const bits_way *way, bits_hash *hash) {
    const size_t count = face_count(&m->mesh);
    for (int open = NORMA_ORIENT_OPEN_KEPT;
         open <= (m->mesh.corner_count > MOST_FOR_RAYS ? NORMA_ORIENT_OPEN_KEPT
                                                       : NORMA_ORIENT_OPEN_BY_RAYS);
         ++open) {
        uint8_t *reverse = bits_room(count, 1);
        norma_orient_report report = {0};
        const norma_options options = bits_options(way);
        const norma_result result =
            norma_orient(&m->mesh, (norma_orient_open)open, &options, reverse, count, &report);
        bits_add(hash, (uint64_t)(int64_t)result);
        if (!result) {
            const size_t counts[] = {report.parts, report.closed, report.open, report.one_sided,
                report.inward, report.nested, report.by_rays, report.undecided,
                report.reversed_faces, report.winding_conflicts, report.non_manifold_edges};
            bits_bytes(hash, reverse, count);
            for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) bits_size(hash, counts[i]);
            bits_double(hash, report.least_confidence);
        }
        free(reverse);
    }
}
