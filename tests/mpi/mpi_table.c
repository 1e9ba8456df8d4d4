/* mpi_table.c: what norma_mpi_vertex_normals costs: bytes that leave a rank, votes among them,
 * scratch memory, time. Each is that of the worst rank. Bytes are counted where they are handed to
 * MPI, by a function that takes the place of MPI_Alltoallv. Ends with 1 where a contribution
 * crosses the wire twice, or scratch memory is beyond 40 bytes for each triangle of a rank.
 *
 * Prints a row of a table; all but the seconds for each triangle of a rank.
 *
 *   mpirun -n RANKS mpi_table slices|random [TRIANGLES] */
#include <norma/mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { VOTE = 36, NUMBERED_VOTE = 44 };

static uint64_t sent, votes;
static long now, most; /* bytes that are allocated */

int MPI_Alltoallv(const void *from, const int *counts, const int *starts, MPI_Datatype type,
    void *to, const int *to_counts, const int *to_starts, MPI_Datatype to_type, MPI_Comm comm) {
    int ranks, rank, size;
    MPI_Comm_size(comm, &ranks);
    MPI_Comm_rank(comm, &rank);
    MPI_Type_size(type, &size);
    for (int r = 0; r < ranks; ++r) {
        if (r == rank) continue;
        sent += (uint64_t)counts[r] * (uint64_t)size;
        if (size == VOTE || size == NUMBERED_VOTE) votes += (uint64_t)counts[r];
    }
    return PMPI_Alltoallv(from, counts, starts, type, to, to_counts, to_starts, to_type, comm);
}

static void *allocate(void *user, size_t size, size_t alignment) {
    (void)user;
    now += (long)size;
    if (now > most) most = now;
    return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void release(void *user, void *block, size_t size) {
    (void)user;
    now -= (long)size;
    free(block);
}

static uint64_t mix(uint64_t z) {
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

typedef struct grid {
    uint64_t side, faces, *vertex_ids, *face_ids;
    uint32_t *corners, *local;
    float *points;
    size_t here, count;
} grid;

static uint32_t take(grid *g, uint64_t vertex) {
    if (g->local[vertex] == UINT32_MAX) {
        float *p = g->points + 3 * g->count;
        p[0] = (float)(vertex % g->side);
        p[1] = (float)(vertex / g->side);
        p[2] = (float)(mix(vertex) >> 40) * 0x1p-24F;
        g->vertex_ids[g->count] = vertex;
        g->local[vertex] = (uint32_t)g->count++;
    }
    return g->local[vertex];
}

static int owner(const grid *g, uint64_t face, int ranks, int random) {
    return (int)(random ? mix(face) % (uint64_t)ranks : face * (uint64_t)ranks / g->faces);
}

static void *room(size_t count, size_t size) {
    void *block = malloc((count + 1) * size);
    if (!block) MPI_Abort(MPI_COMM_WORLD, 3);
    return block;
}

static void fill(grid *g, uint64_t faces, int rank, int ranks, int random) {
    for (g->side = 2; 2 * (g->side - 1) * (g->side - 1) < faces;) ++g->side;
    const uint64_t side = g->side, vertices = side * side;
    g->faces = 2 * (side - 1) * (side - 1);
    for (uint64_t f = 0; f < g->faces; ++f) g->here += owner(g, f, ranks, random) == rank;
    const size_t most_named = 3 * g->here < vertices ? 3 * g->here : (size_t)vertices;
    g->local = room((size_t)vertices, sizeof *g->local);
    memset(g->local, 0xff, (size_t)vertices * sizeof *g->local);
    g->corners = room(3 * g->here, sizeof *g->corners);
    g->face_ids = room(g->here, sizeof *g->face_ids);
    g->points = room(most_named, 3 * sizeof *g->points);
    g->vertex_ids = room(most_named, sizeof *g->vertex_ids);
    size_t at = 0;
    for (uint64_t f = 0; f < g->faces; ++f) {
        const uint64_t cell = f / 2, a = cell / (side - 1) * side + cell % (side - 1);
        const uint64_t corner[2][3] = {{a, a + 1, a + side}, {a + 1, a + side + 1, a + side}};
        if (owner(g, f, ranks, random) != rank) continue;
        g->face_ids[at / 3] = f;
        for (int k = 0; k < 3; ++k) g->corners[at++] = take(g, corner[f % 2][k]);
    }
}

int main(int argc, char **argv) {
    int rank, ranks;
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    const int random = argc > 1 && strcmp(argv[1], "random") == 0;
    grid g = {0};
    fill(&g, argc > 2 ? strtoull(argv[2], NULL, 10) : 1000000, rank, ranks, random);
    norma_mesh mesh = {.corners = g.corners, .corner_count = 3 * g.here};
    mesh.positions.data = g.points;
    mesh.positions.count = g.count;
    norma_options o = {.struct_size = sizeof o, .allocator = {allocate, release, NULL}};
    float *normals = room(g.count, 3 * sizeof *normals);
    MPI_Barrier(MPI_COMM_WORLD);
    const double begin = MPI_Wtime();
    const norma_result result = norma_mpi_vertex_normals(MPI_COMM_WORLD, &mesh, g.vertex_ids,
        random ? g.face_ids : NULL, &o, normals, g.count, NULL);
    double worst[5] = {
        MPI_Wtime() - begin, (double)sent, (double)most, (double)votes, (double)g.count};
    MPI_Allreduce(MPI_IN_PLACE, worst, 5, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    const double share = (double)g.faces / ranks;
    if (!rank)
        printf("| %s, %d ranks | %.2f | %.1f | %.2f | %.1f | %.2f |\n",
            random ? "random" : "slices", ranks, worst[4] / share, worst[1] / share,
            worst[3] / share, worst[2] / share, worst[0]);
    MPI_Finalize();
    return result || worst[2] > 40 * share || worst[3] > 3.3 * share;
}
