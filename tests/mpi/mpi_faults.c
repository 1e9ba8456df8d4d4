/* mpi_faults.c: one rank is at fault; all must return the same result, and nothing may hang.
 * Prints a line of TAP for each fault.
 *
 *   mpirun -n RANKS mpi_faults */
#include <norma/mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 40, VERTICES = SIDE * SIDE, CELLS = (SIDE - 1) * (SIDE - 1) };

typedef struct fixture {
    int rank, ranks, number, failed;
    norma_mesh mesh;
    uint64_t vertex_ids[VERTICES], face_ids[2 * CELLS];
    float points[3 * VERTICES], normals[3 * VERTICES];
    uint32_t corners[6 * CELLS];
    size_t faces;
} fixture;

/* A bent grid; each rank has every rank-th face and all vertices. */
static void fill(fixture *f) {
    for (uint32_t v = 0; v < VERTICES; ++v) {
        const float x = (float)(v % SIDE), y = (float)(v / SIDE);
        const float point[3] = {x, y, 0.01F * x * y};
        memcpy(f->points + 3 * v, point, sizeof point);
        f->vertex_ids[v] = v;
    }
    f->faces = 0;
    for (uint32_t i = 0; i < 2 * CELLS; ++i) {
        const uint32_t cell = i / 2, a = cell / (SIDE - 1) * SIDE + cell % (SIDE - 1);
        const uint32_t corners[2][3] = {{a, a + 1, a + SIDE}, {a + 1, a + SIDE + 1, a + SIDE}};
        if ((int)(i % (uint32_t)f->ranks) != f->rank) continue;
        memcpy(f->corners + 3 * f->faces, corners[i % 2], sizeof corners[0]);
        f->face_ids[f->faces++] = i;
    }
    f->mesh = (norma_mesh){.corners = f->corners, .corner_count = 3 * f->faces};
    f->mesh.positions.data = f->points;
    f->mesh.positions.count = VERTICES;
}

static int at_fault(const fixture *f) { return f->rank == f->ranks - 1; }

static void say(fixture *f, const char *name, norma_result got, norma_result expected) {
    int least = (int)got, most = (int)got;
    MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    const int fine = least == most && least == (int)expected;
    f->failed |= !fine;
    ++f->number;
    if (f->rank) return;
    printf("%sok %d - %s\n", fine ? "" : "not ", f->number, name);
    if (!fine) printf("# results from %d to %d, expected %d\n", least, most, (int)expected);
}

static norma_result run(fixture *f, const norma_options *options) {
    return norma_mpi_vertex_normals(
        MPI_COMM_WORLD, &f->mesh, f->vertex_ids, f->face_ids, options, f->normals, VERTICES, NULL);
}

/* ---- options and arguments */

static void disagree(fixture *f) {
    norma_options o = {.struct_size = sizeof o};
    if (at_fault(f)) o.weight = NORMA_WEIGHT_AREA;
    say(f, "one rank has another weight", run(f, &o), NORMA_ERROR_ARGUMENT);
    o = (norma_options){.struct_size = sizeof o};
    if (at_fault(f)) o.weld = NORMA_WELD_NONE;
    say(f, "one rank welds otherwise", run(f, &o), NORMA_ERROR_ARGUMENT);
    o = (norma_options){.struct_size = sizeof o, .weld = NORMA_WELD_DISTANCE, .weld_distance = 1};
    if (at_fault(f)) o.weld_distance = 1.0000001;
    say(f, "one rank has another distance", run(f, &o), NORMA_ERROR_ARGUMENT);
    o = (norma_options){.struct_size = sizeof o};
    if (at_fault(f)) o.fallback = NORMA_FALLBACK_NEAREST;
    say(f, "one rank has another fallback", run(f, &o), NORMA_ERROR_ARGUMENT);
    o = (norma_options){.struct_size = sizeof o};
    if (at_fault(f)) o.weight = (norma_weight)99;
    say(f, "one rank has a weight that does not exist", run(f, &o), NORMA_ERROR_ARGUMENT);
    o = (norma_options){.struct_size = sizeof o};
    if (at_fault(f)) o.threads = 2;
    say(f, "ranks may differ in threads", run(f, &o), NORMA_OK);
}

static void wrong_arguments(fixture *f) {
    const uint64_t *faces = at_fault(f) ? NULL : f->face_ids,
                   *vertices = at_fault(f) ? NULL : f->vertex_ids;
    const size_t room = at_fault(f) ? VERTICES - 1 : VERTICES;
    say(f, "one rank gives no face_ids",
        norma_mpi_vertex_normals(
            MPI_COMM_WORLD, &f->mesh, f->vertex_ids, faces, NULL, f->normals, VERTICES, NULL),
        NORMA_ERROR_ARGUMENT);
    say(f, "one rank gives no vertex_ids",
        norma_mpi_vertex_normals(
            MPI_COMM_WORLD, &f->mesh, vertices, f->face_ids, NULL, f->normals, VERTICES, NULL),
        NORMA_ERROR_ARGUMENT);
    say(f, "one rank has too little room",
        norma_mpi_vertex_normals(
            MPI_COMM_WORLD, &f->mesh, f->vertex_ids, f->face_ids, NULL, f->normals, room, NULL),
        NORMA_ERROR_CAPACITY);
    say(f, "one rank gives no mesh",
        norma_mpi_vertex_normals(MPI_COMM_WORLD, at_fault(f) ? NULL : &f->mesh, f->vertex_ids,
            f->face_ids, NULL, f->normals, VERTICES, NULL),
        NORMA_ERROR_ARGUMENT);
    if (at_fault(f)) f->corners[5] = VERTICES;
    say(f, "one rank names a position that does not exist", run(f, NULL), NORMA_ERROR_INDEX);
    fill(f);
    if (at_fault(f)) --f->mesh.corner_count;
    say(f, "one rank's corners are no multiple of three", run(f, NULL), NORMA_ERROR_ARGUMENT);
    fill(f);
    if (at_fault(f)) f->mesh.corner_count = 0;
    say(f, "a rank without faces may leave face_ids out",
        norma_mpi_vertex_normals(
            MPI_COMM_WORLD, &f->mesh, f->vertex_ids, faces, NULL, f->normals, VERTICES, NULL),
        f->ranks > 1 ? NORMA_OK : NORMA_OK);
    fill(f);
}

static int cancel(void *user, double fraction) {
    const fixture *f = user;
    return at_fault(f) && fraction > 0.05;
}

/* ---- memory */

typedef struct memory {
    long left;   /* allocations until one fails; negative: never */
    long blocks; /* that are not released */
} memory;

static void *allocate(void *user, size_t size, size_t alignment) {
    memory *m = user;
    if (m->left == 0) return NULL;
    if (m->left > 0) --m->left;
    void *block = aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
    m->blocks += block != NULL;
    return block;
}

static void release(void *user, void *block, size_t size) {
    (void)size;
    --((memory *)user)->blocks;
    free(block);
}

/* Every allocation of one rank fails once. */
static void fail_memory(fixture *f, norma_options o, const char *name) {
    int wrong = 0, over = 0;
    long n = 0;
    for (; !wrong && !over; ++n) {
        memory m = {.left = at_fault(f) ? n : -1};
        o.allocator = (norma_allocator){allocate, release, &m};
        int results[2] = {(int)run(f, &o), 0};
        results[1] = -results[0];
        int most[2], blocks = m.blocks != 0;
        MPI_Allreduce(results, most, 2, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
        MPI_Allreduce(MPI_IN_PLACE, &blocks, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
        over = !most[0] && !most[1];
        wrong = most[0] != -most[1] || blocks || (!over && most[0] != NORMA_ERROR_MEMORY);
    }
    if (!f->rank) printf("# %s: %ld allocations failed one after another\n", name, n - 1);
    say(f, name, wrong || n < 10 ? NORMA_ERROR_MEMORY : NORMA_OK, NORMA_OK);
}

int main(int argc, char **argv) {
    static fixture f;
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &f.rank);
    MPI_Comm_size(MPI_COMM_WORLD, &f.ranks);
    fill(&f);
    if (f.ranks > 1) disagree(&f);
    if (f.ranks > 1) wrong_arguments(&f);
    norma_options o = {.struct_size = sizeof o, .progress = cancel, .progress_user = &f};
    say(&f, "one rank cancels", run(&f, &o), NORMA_CANCELLED);
    o = (norma_options){.struct_size = sizeof o, .fallback = NORMA_FALLBACK_NEAREST};
    for (int i = 0; i < 3; ++i) f.points[3 * 7 + i] = f.points[3 * 9 + i] = 1e38F * 1e38F;
    fail_memory(&f, o, "memory fails on one rank");
    o.weld = NORMA_WELD_DISTANCE;
    o.weld_distance = 0.1;
    fail_memory(&f, o, "memory fails on one rank, by distance");
    o.weight = NORMA_WEIGHT_VISIBLE;
    o.weld = NORMA_WELD_NONE;
    fail_memory(&f, o, "memory fails on one rank, most visible");
    if (!f.rank) printf("1..%d\n", f.number);
    MPI_Finalize();
    return f.failed;
}
