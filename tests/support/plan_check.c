/* plan_check.c: see plan_check.h. */
#include "plan_check.h"
#include "oracle/shapes.h"

uint32_t plan_random(uint64_t *seed, uint32_t below) { return shape_random(seed) % below; }

/* Few places for many vertices, so that equal positions, twins and faces of no area are common. */
static void lattice(mesh_file *mesh, uint64_t *seed) {
    const uint32_t positions = 4 + plan_random(seed, 12), faces = 1 + plan_random(seed, 16),
                   side = 2 + plan_random(seed, 2), polygons = plan_random(seed, 2);
    for (uint32_t i = 0; i < positions; ++i) {
        double p[3];
        for (int x = 0; x < 3; ++x)
            p[x] = (double)plan_random(seed, side) - (double)plan_random(seed, 2);
        if (!plan_random(seed, 60)) p[plan_random(seed, 3)] = (double)NAN;
        mesh_file_add_position(mesh, p[0], p[1], p[2]);
    }
    for (uint32_t f = 0; f < faces; ++f) {
        uint32_t corners[8];
        const uint32_t count =
            polygons ? (!plan_random(seed, 20) ? plan_random(seed, 3) : 3 + plan_random(seed, 3))
                     : 3;
        for (uint32_t i = 0; i < count; ++i) corners[i] = plan_random(seed, positions);
        mesh_file_add_face(mesh, corners, count);
    }
}

static void twin(mesh_file *mesh, size_t face) {
    uint32_t corners[16];
    const size_t count = mesh->starts[face + 1] - mesh->starts[face];
    for (size_t i = 0; i < count; ++i) corners[i] = mesh->corners[mesh->starts[face + 1] - 1 - i];
    mesh_file_add_face(mesh, corners, count);
}

/* Known shapes with seams; some vertices onto others, some faces doubled as leaves are; or every
 * corner a vertex of its own. */
static void damaged(mesh_file *mesh, uint64_t *seed) {
    mesh_file whole = {0};
    const int quads = !plan_random(seed, 3);
    switch (plan_random(seed, 4)) {
    case 0:
        shape_uv_sphere(&whole, 5, 4, 1, quads);
        break;
    case 1:
        shape_pole_sphere(&whole, 5, 3, quads);
        break;
    case 2:
        shape_wavy_grid(&whole, 4, quads);
        break;
    default:
        shape_box(&whole, 3, 2, 1, quads);
        break;
    }
    shape_round_to_float(&whole);
    const size_t faces = whole.face_count;
    for (size_t f = 0; f < faces; ++f)
        if (!plan_random(seed, 10)) twin(&whole, f);
    for (size_t v = 0; v < whole.position_count; ++v)
        if (!plan_random(seed, 12))
            memcpy(whole.positions[v],
                whole.positions[plan_random(seed, (uint32_t)whole.position_count)],
                sizeof *whole.positions);
    if (plan_random(seed, 3)) {
        *mesh = whole;
    } else {
        shape_soup(mesh, &whole);
        mesh_file_free(&whole);
    }
    for (uint32_t unreferenced = plan_random(seed, 3); unreferenced > 0; --unreferenced)
        mesh_file_add_position(mesh, 1, (double)unreferenced, 0);
}

static void random_options(plan_case *c, uint64_t *seed) {
    static const float creases[] = {0, 0.3f, 0.8f, 1.6f, 3.1415927f};
    c->options.weight = (norma_weight)plan_random(seed, 7);
    c->options.weld = (norma_weld)plan_random(seed, 3);
    c->options.weld_distance = 0.25;
    c->options.non_manifold = (norma_non_manifold)plan_random(seed, 2);
    c->crease_rad = creases[plan_random(seed, COUNT_OF(creases))];
    c->of = (norma_element)plan_random(seed, 2);
    if (!plan_random(seed, 3)) c->view.hard_edges = c->hard;
    if (!plan_random(seed, 3)) c->view.smoothing_groups = c->groups;
    for (size_t i = 0; i < c->mesh.corner_count; ++i) c->hard[i] = !plan_random(seed, 5);
    for (size_t i = 0; i < c->mesh.face_count; ++i) c->groups[i] = 1 + plan_random(seed, 3);
}

void plan_case_make(plan_case *c, uint64_t seed) {
    uint64_t state = seed * 7919 + 1;
    memset(c, 0, sizeof *c);
    if (plan_random(&state, 2))
        lattice(&c->mesh, &state);
    else
        damaged(&c->mesh, &state);
    c->floats = test_calloc(3 * c->mesh.position_count + 1, sizeof *c->floats);
    c->hard = test_calloc(c->mesh.corner_count + 1, 1);
    c->groups = test_calloc(c->mesh.face_count + 1, sizeof *c->groups);
    c->view = mesh_file_view_float(&c->mesh, c->floats);
    random_options(c, &state);
    if (plan_random(&state, 2)) {
        c->view.face_starts = mesh_file_view_polygons(&c->mesh).face_starts;
        c->view.face_count = c->mesh.face_count;
    }
    c->elements = c->of == NORMA_PER_VERTEX ? c->mesh.position_count : c->mesh.corner_count;
    snprintf(c->name, sizeof c->name, "seed %llu, weight %d, weld %d, crease %g, %s",
        (unsigned long long)seed, (int)c->options.weight, (int)c->options.weld,
        (double)c->crease_rad, c->of ? "per corner" : "per vertex");
}

void plan_case_free(plan_case *c) {
    mesh_file_free(&c->mesh);
    test_free(c->floats);
    test_free(c->hard);
    test_free(c->groups);
}

static void new_place(const plan_case *c, uint64_t *seed, float place[3]) {
    const uint32_t kind = plan_random(seed, 6),
                   other = plan_random(seed, (uint32_t)c->mesh.position_count);
    for (int x = 0; x < 3; ++x) {
        if (kind < 2)
            place[x] = c->floats[3 * other + (uint32_t)x]; /* onto another: slivers close */
        else if (kind < 5)
            place[x] += 0.5f * (float)shape_random_unit(seed); /* a step: they open */
        else
            place[x] = plan_random(seed, 2) ? (float)NAN : (float)plan_random(seed, 3);
    }
}

static int same_place(const double a[3], const double b[3]) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

size_t plan_case_move(plan_case *c, uint64_t *seed, int together, uint32_t *moved, size_t room) {
    const size_t positions = c->mesh.position_count;
    const uint32_t wanted = plan_random(seed, 4) ? 1 + plan_random(seed, 3)
                                                 : 1 + plan_random(seed, (uint32_t)positions);
    size_t count = 0;
    for (uint32_t i = 0; i < wanted; ++i) {
        const uint32_t v = plan_random(seed, (uint32_t)positions);
        float old[3], place[3];
        memcpy(old, c->floats + 3 * v, sizeof old);
        memcpy(place, old, sizeof place);
        new_place(c, seed, place);
        for (uint32_t u = 0; u < positions; ++u) {
            if (u != v && !(together && same_place(c->mesh.positions[u], c->mesh.positions[v])))
                continue;
            memcpy(c->floats + 3 * u, place, sizeof place);
            for (uint32_t times = 1 + !plan_random(seed, 4); times > 0 && count < room; --times)
                moved[count++] = u;
        }
    }
    return count;
}
