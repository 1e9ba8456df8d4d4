/* mpi_bits.c: random meshes in random parts. Every rank makes the whole mesh, computes its normals
 * alone by norma_vertex_normals, takes its part, and compares what norma_mpi_vertex_normals gives
 * for it: normals, reasons and report, bit for bit.
 *
 *   mpirun -n RANKS mpi_bits FIRST-SEED COUNT [FACES [KIND]]
 *
 * KIND: any (anything, drawn anew for each mesh), or one of what KINDS names. */
#include <math.h>
#include <norma/mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const uint64_t FAR = UINT64_C(1) << 40;

typedef struct whole_mesh {
    size_t vertices, faces, corners;
    double *points;
    uint32_t *corner, *starts; /* starts: NULL for triangles */
    int doubles;
} whole_mesh;

typedef struct part_mesh {
    norma_mesh mesh;
    void *points;
    uint32_t *corner, *starts, *local; /* local: of each vertex its place here, UINT32_MAX: none */
    uint64_t *vertex_ids, *face_ids;
    uint32_t *global;
    size_t vertices, faces;
} part_mesh;

enum { SHAPE_GRID, SHAPE_SEAMS, SHAPE_SOUP, SHAPE_LEAVES, SHAPE_CONE, SHAPES };
enum { BY_SLICE, BY_CHANCE, BY_TURNS, ALL_LAST, HALF_EMPTY, WAYS };

typedef struct mesh_kind {
    const char *name;
    int shape, way; /* SHAPES, WAYS: drawn for each mesh */
    int isolated;   /* as many vertices of no face as others */
} mesh_kind;

static const mesh_kind KINDS[] = {{"any", SHAPES, WAYS, 0}, {"random", SHAPES, BY_CHANCE, 0},
    {"slices", SHAPES, BY_SLICE, 0}, {"isolated", SHAPES, BY_CHANCE, 1},
    {"one-rank", SHAPES, ALL_LAST, 0}, {"half-empty", SHAPES, HALF_EMPTY, 0},
    {"seams", SHAPE_SEAMS, BY_CHANCE, 0}, {"soup", SHAPE_SOUP, BY_TURNS, 0}};

static const mesh_kind *kind_of(const char *name) {
    for (size_t i = 0; i < sizeof KINDS / sizeof *KINDS; ++i)
        if (strcmp(name, KINDS[i].name) == 0) return &KINDS[i];
    return NULL;
}

static uint64_t state;
static uint32_t pick(uint32_t below) { /* splitmix64 */
    uint64_t z = (state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return (uint32_t)(((z ^ (z >> 31)) >> 32) * below >> 32);
}
static double wobble(void) { return (double)pick(1U << 30) / (1 << 30) - 0.5; }

static void *room(size_t count, size_t size) {
    void *block = calloc(count + 1, size);
    if (!block) MPI_Abort(MPI_COMM_WORLD, 3);
    return block;
}

/* ---- the whole mesh */

static void place_vertex(double *p, int shape, size_t v, size_t side) {
    const double x = (double)(v % side), y = (double)(v / side);
    if (shape == SHAPE_SOUP) {
        for (int k = 0; k < 3; ++k) p[k] = (double)pick(4) - 1;
        if (pick(3) == 0) p[pick(3)] *= -1; /* -0 here and there */
        return;
    }
    p[0] = x + 0.3 * wobble();
    p[1] = y + 0.3 * wobble();
    p[2] = shape == SHAPE_LEAVES ? 0 : 0.7 * wobble();
}

static uint32_t corner_of(int shape, size_t face, size_t k, size_t side, size_t vertices) {
    static const size_t dx[2][3] = {{0, 1, 0}, {1, 1, 0}}, dy[2][3] = {{0, 0, 1}, {0, 1, 1}};
    const size_t cell = face / 2, cells = (side - 1) * (side - 1);
    const size_t x = cell % cells % (side - 1), y = cell % cells / (side - 1);
    if (shape == SHAPE_SOUP || cell >= cells) return pick((uint32_t)vertices);
    if (shape == SHAPE_CONE && k == 0) return 0;
    return (uint32_t)((y + dy[face % 2][k]) * side + x + dx[face % 2][k]);
}

static void fill_faces(whole_mesh *m, int shape, size_t side, int polygons) {
    m->corner = room(8 * m->faces, sizeof *m->corner);
    m->starts = polygons ? room(m->faces + 1, sizeof *m->starts) : NULL;
    for (size_t f = 0; f < m->faces; ++f) {
        const size_t count = polygons && pick(3) == 0 ? pick(8) : 3;
        const uint32_t odd = pick(64);
        for (size_t k = 0; k < count; ++k)
            m->corner[m->corners + k] =
                k < 3 ? corner_of(shape, f, k, side, m->vertices) : pick((uint32_t)m->vertices);
        if (shape == SHAPE_LEAVES && f % 2 && count == 3 && m->corners >= 3) {
            const uint32_t *before = &m->corner[m->corners - 3]; /* this one is its other side */
            for (size_t k = 0; k < 3; ++k) m->corner[m->corners + k] = before[2 - k];
        }
        if (odd == 0 && count >= 2) m->corner[m->corners + 1] = m->corner[m->corners];
        m->corners += count;
        if (polygons) m->starts[f + 1] = (uint32_t)m->corners;
    }
}

static void spoil(whole_mesh *m) {
    const double bad[] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < m->vertices / 200; ++i)
        m->points[3 * (size_t)pick((uint32_t)m->vertices) + pick(3)] = bad[pick(3)];
    if (m->doubles && pick(2))
        for (size_t i = 0; i < 3 * m->vertices; ++i) m->points[i] *= pick(2) ? 0x1p300 : 0x1p299;
    for (size_t i = 0; i < 3 * m->vertices && !m->doubles; ++i)
        m->points[i] = (double)(float)m->points[i];
}

static void make_whole(whole_mesh *m, size_t most_faces, const mesh_kind *kind) {
    const int drawn = (int)pick(SHAPES), shape = kind->shape == SHAPES ? drawn : kind->shape;
    const size_t side = 2 + pick((uint32_t)(sqrt((double)most_faces / 2) + 1)),
                 cells = (side - 1) * (side - 1);
    *m = (whole_mesh){.vertices = side * side, .doubles = pick(4) == 0};
    m->faces = 2 * cells + pick(6);
    m->vertices += pick(5); /* of no face, or of the last ones */
    if (kind->isolated) m->vertices *= 2;
    m->points = room(3 * m->vertices, sizeof *m->points);
    for (size_t v = 0; v < m->vertices; ++v) place_vertex(m->points + 3 * v, shape, v, side);
    for (size_t v = 1; v < m->vertices && shape == SHAPE_SEAMS; ++v)
        if (pick(3) == 0)
            memcpy(m->points + 3 * v, m->points + 3 * (size_t)pick((uint32_t)v),
                3 * sizeof *m->points);
    if (pick(2)) /* large votes that all but cancel, so that the order of sums shows in floats */
        for (size_t i = 0; i < 3 * m->vertices; ++i) m->points[i] *= (double)(1U << pick(26));
    fill_faces(m, shape, side, pick(3) == 0);
    if (pick(2))
        spoil(m);
    else
        for (size_t i = 0; i < 3 * m->vertices && !m->doubles; ++i)
            m->points[i] = (double)(float)m->points[i];
}

static void free_whole(whole_mesh *m) {
    free(m->points);
    free(m->corner);
    free(m->starts);
}

static void *pack_points(const whole_mesh *m, const uint32_t *which, size_t count) {
    float *floats = room(3 * count, m->doubles ? sizeof(double) : sizeof(float));
    double *doubles = (double *)(void *)floats;
    for (size_t i = 0; i < 3 * count; ++i) {
        const double value = m->points[3 * (which ? which[i / 3] : i / 3) + i % 3];
        if (m->doubles)
            doubles[i] = value;
        else
            floats[i] = (float)value;
    }
    return floats;
}

static norma_mesh view_of(const whole_mesh *m, const void *points, size_t vertices,
    const uint32_t *corner, size_t corners, const uint32_t *starts, size_t faces) {
    norma_mesh mesh = {.corners = corner, .corner_count = corners};
    mesh.positions.data = points;
    mesh.positions.count = vertices;
    mesh.positions.format = m->doubles ? NORMA_FORMAT_DOUBLE : NORMA_FORMAT_FLOAT;
    mesh.face_starts = starts;
    mesh.face_count = starts ? faces : 0;
    return mesh;
}

/* ---- parts: all ranks draw the same */

static int owner_of(int way, size_t face, size_t faces, int ranks) {
    switch (way) {
    case BY_SLICE:
        return (int)(face * (size_t)ranks / faces);
    case BY_TURNS:
        return (int)(face % (size_t)ranks);
    case ALL_LAST:
        return ranks - 1;
    case HALF_EMPTY:
        return (int)(pick((uint32_t)(ranks + 1) / 2) * 2) % ranks;
    default:
        return (int)pick((uint32_t)ranks);
    }
}

static void add_vertex(part_mesh *p, uint32_t v) {
    if (p->local[v] != UINT32_MAX && pick(40)) return; /* now and then twice */
    p->global[p->vertices] = v;
    p->local[v] = (uint32_t)p->vertices++;
}

static void shuffle(uint32_t *numbers, size_t count) {
    for (size_t i = count; i > 1; --i) {
        const size_t k = pick((uint32_t)i);
        const uint32_t kept = numbers[i - 1];
        numbers[i - 1] = numbers[k];
        numbers[k] = kept;
    }
}

static size_t begin_of(const whole_mesh *m, size_t f) { return m->starts ? m->starts[f] : 3 * f; }

static void make_part(
    const whole_mesh *m, const mesh_kind *kind, int rank, int ranks, part_mesh *p) {
    const int drawn = (int)pick(WAYS), way = kind->way == WAYS ? drawn : kind->way;
    const uint64_t seed = state;
    const int ids = way != BY_SLICE || pick(2);
    uint32_t *mine = room(m->faces, sizeof *mine);
    *p = (part_mesh){0};
    p->local = room(m->vertices, sizeof *p->local);
    memset(p->local, 0xff, m->vertices * sizeof *p->local);
    p->global = room(m->corners + 2 * m->vertices + 8, sizeof *p->global);
    for (size_t f = 0; f < m->faces; ++f)
        if (owner_of(way, f, m->faces, ranks) == rank) mine[p->faces++] = (uint32_t)f;
    for (size_t v = 0; v < m->vertices; ++v) { /* each on one rank or two, whoever names it */
        const int one = (int)pick((uint32_t)ranks), two = (int)pick((uint32_t)ranks);
        const int twice = pick(3) == 0;
        if (one == rank || (twice && two == rank)) {
            p->global[p->vertices] = (uint32_t)v;
            p->local[v] = (uint32_t)p->vertices++;
        }
    }
    state = seed ^ ((uint64_t)rank * 77 + 1);
    if (ids && pick(2)) shuffle(mine, p->faces);
    p->corner = room(m->corners, sizeof *p->corner);
    p->starts = m->starts ? room(p->faces + 1, sizeof *p->starts) : NULL;
    p->face_ids = ids ? room(p->faces, sizeof *p->face_ids) : NULL;
    size_t corners = 0;
    for (size_t i = 0; i < p->faces; ++i) {
        for (size_t c = begin_of(m, mine[i]); c < begin_of(m, mine[i] + 1); ++c) {
            add_vertex(p, m->corner[c]);
            p->corner[corners++] = p->local[m->corner[c]];
        }
        if (p->starts) p->starts[i + 1] = (uint32_t)corners;
        if (ids) p->face_ids[i] = FAR + 3 * (uint64_t)mine[i];
    }
    p->vertex_ids = room(p->vertices, sizeof *p->vertex_ids);
    for (size_t i = 0; i < p->vertices; ++i) p->vertex_ids[i] = FAR + 7 * (uint64_t)p->global[i];
    p->points = pack_points(m, p->global, p->vertices);
    p->mesh = view_of(m, p->points, p->vertices, p->corner, corners, p->starts, p->faces);
    free(mine);
}

static void free_part(part_mesh *p) {
    free(p->points);
    free(p->corner);
    free(p->starts);
    free(p->local);
    free(p->vertex_ids);
    free(p->face_ids);
    free(p->global);
}

/* ---- comparing */

static norma_options draw_options(void) {
    norma_options o = {.struct_size = sizeof o};
    o.weight = (norma_weight)pick(7);
    o.weld = (norma_weld)pick(3);
    o.weld_distance = 0.4 * (double)pick(4);
    o.fallback = (norma_fallback)pick(3);
    o.fallback_normal[1] = -2;
    return o;
}

static int same_count(norma_count whole, norma_count parts, uint64_t factor, uint64_t base) {
    if (whole.count != parts.count) return 0;
    return whole.count ? whole.first * factor + base == parts.first : parts.first == SIZE_MAX;
}

static int same_report(const norma_report *whole, const norma_report *parts, int ids) {
    return same_count(
               whole->degenerate_faces, parts->degenerate_faces, ids ? 3 : 1, ids ? FAR : 0) &&
           same_count(whole->non_finite, parts->non_finite, 7, FAR) &&
           same_count(whole->unreferenced, parts->unreferenced, 7, FAR) &&
           same_count(whole->cancelled, parts->cancelled, 7, FAR) &&
           parts->non_manifold_edges.first == SIZE_MAX;
}

static void show(const char *what, unsigned long seed, int rank, const norma_options *o, size_t v,
    const float *a, const float *b) {
    printf("seed %lu rank %d: %s (weight %d weld %d fallback %d) vertex %zu: %a %a %a, alone %a %a "
           "%a\n",
        seed, rank, what, (int)o->weight, (int)o->weld, (int)o->fallback, v, (double)a[0],
        (double)a[1], (double)a[2], (double)b[0], (double)b[1], (double)b[2]);
}

static int compare(
    const whole_mesh *m, const part_mesh *p, unsigned long seed, int rank, norma_options *o) {
    float *alone = room(3 * m->vertices, sizeof *alone), *got = room(4 * p->vertices, sizeof *got);
    uint8_t *reasons = room(m->vertices, 1), *got_reasons = room(p->vertices, 1);
    norma_report whole = {{0, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 0}}, parts = whole;
    void *points = pack_points(m, NULL, m->vertices);
    const norma_mesh mesh =
        view_of(m, points, m->vertices, m->corner, m->corners, m->starts, m->faces);
    int wrong = 0;
    o->reasons = reasons;
    const norma_result first = norma_vertex_normals(&mesh, o, alone, m->vertices, &whole);
    o->reasons = got_reasons;
    o->normal_stride = 16;
    const norma_result second = norma_mpi_vertex_normals(
        MPI_COMM_WORLD, &p->mesh, p->vertex_ids, p->face_ids, o, got, p->vertices, &parts);
    if (first || second) {
        printf("seed %lu rank %d: results %d alone, %d in parts\n", seed, rank, first, second);
        wrong = 1;
    }
    for (size_t i = 0; i < p->vertices && !wrong; ++i) {
        const float *a = got + 4 * i, *b = alone + 3 * (size_t)p->global[i];
        wrong = memcmp(a, b, 3 * sizeof *a) != 0 || got_reasons[i] != reasons[p->global[i]];
        if (wrong) show("differs", seed, rank, o, p->global[i], a, b);
    }
    if (!wrong && !same_report(&whole, &parts, p->face_ids != NULL)) {
        printf("seed %lu rank %d: reports differ: degenerate %zu %zu, non-finite %zu %zu, "
               "unreferenced %zu %zu, cancelled %zu %zu\n",
            seed, rank, whole.degenerate_faces.count, parts.degenerate_faces.count,
            whole.non_finite.count, parts.non_finite.count, whole.unreferenced.count,
            parts.unreferenced.count, whole.cancelled.count, parts.cancelled.count);
        wrong = 1;
    }
    free(alone);
    free(got);
    free(reasons);
    free(got_reasons);
    free(points);
    return wrong;
}

int main(int argc, char **argv) {
    int rank, ranks, wrong = 0, all = 0;
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    const unsigned long first = argc > 1 ? strtoul(argv[1], NULL, 10) : 1,
                        count = argc > 2 ? strtoul(argv[2], NULL, 10) : 20;
    const size_t faces = argc > 3 ? strtoul(argv[3], NULL, 10) : 400;
    const mesh_kind *kind = kind_of(argc > 4 ? argv[4] : "any");
    if (!kind) MPI_Abort(MPI_COMM_WORLD, 2);
    for (unsigned long seed = first; seed < first + count && !all; ++seed) {
        whole_mesh m;
        part_mesh p;
        state = seed * 1000003;
        make_whole(&m, faces, kind);
        norma_options o = draw_options();
        make_part(&m, kind, rank, ranks, &p);
        wrong = compare(&m, &p, seed, rank, &o);
        MPI_Allreduce(&wrong, &all, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
        free_part(&p);
        free_whole(&m);
    }
    if (!rank && !all) printf("%lu meshes: the same bits on %d ranks\n", count, ranks);
    MPI_Finalize();
    return all;
}
