/* solver_seams.c: a surface whose faces lie on several ranks, as a solver's mesh does. Summing the
 * normals of its own faces, each rank gets wrong ones along the seams; norma_mpi_vertex_normals
 * gets those of the whole surface. The surface is a torus, whose normals are known.
 *
 *   mpirun -n 4 solver_seams */
#include <math.h>
#include <norma/mpi.h>
#include <stdio.h>
#include <stdlib.h>

enum { AROUND = 240, ACROSS = 80, VERTICES = AROUND * ACROSS, FACES = 2 * VERTICES };
static const double PI = 3.14159265358979323846;

typedef struct part {
    size_t vertices, faces;
    float points[3 * VERTICES], exact[3 * VERTICES];
    uint64_t vertex_ids[VERTICES], face_ids[FACES];
    uint32_t corners[3 * FACES], local[VERTICES];
} part;

static void place(uint32_t vertex, float *point, float *normal) {
    const double u = 2 * PI * (vertex % AROUND) / AROUND, v = 2 * PI * (vertex / AROUND) / ACROSS;
    const double n[3] = {cos(v) * cos(u), cos(v) * sin(u), sin(v)};
    for (int k = 0; k < 3; ++k) normal[k] = (float)n[k];
    point[0] = (float)((3 + cos(v)) * cos(u));
    point[1] = (float)((3 + cos(v)) * sin(u));
    point[2] = (float)sin(v);
}

static uint32_t take(part *p, uint32_t vertex) {
    if (p->local[vertex] == UINT32_MAX) {
        place(vertex, p->points + 3 * p->vertices, p->exact + 3 * p->vertices);
        p->vertex_ids[p->vertices] = vertex;
        p->local[vertex] = (uint32_t)p->vertices++;
    }
    return p->local[vertex];
}

/* Cells are dealt out in blocks of 7 by 5, as a partitioner of graphs might. */
static int owner(uint32_t x, uint32_t y, int ranks) {
    return (int)((x / 7 * 31 + y / 5 * 17) % (uint32_t)ranks);
}

static void fill(part *p, int rank, int ranks) {
    for (size_t v = 0; v < VERTICES; ++v) p->local[v] = UINT32_MAX;
    for (uint32_t face = 0; face < FACES; ++face) {
        const uint32_t x = face / 2 % AROUND, y = face / 2 / AROUND, x1 = (x + 1) % AROUND,
                       y1 = (y + 1) % ACROSS;
        const uint32_t corners[2][3] = {{y * AROUND + x, y * AROUND + x1, y1 * AROUND + x1},
            {y * AROUND + x, y1 * AROUND + x1, y1 * AROUND + x}};
        if (owner(x, y, ranks) != rank) continue;
        for (int k = 0; k < 3; ++k)
            p->corners[3 * p->faces + (size_t)k] = take(p, corners[face % 2][k]);
        p->face_ids[p->faces++] = face;
    }
}

static double angle(const float *a, const float *b) { /* in degrees */
    const double x = (double)a[1] * b[2] - (double)a[2] * b[1],
                 y = (double)a[2] * b[0] - (double)a[0] * b[2],
                 z = (double)a[0] * b[1] - (double)a[1] * b[0];
    return asin(fmin(1, sqrt(x * x + y * y + z * z))) * 180 / PI;
}

static void report(const part *p, const float *normals, const char *how, int rank) {
    double worst = 0, wrong[2] = {0, (double)p->vertices};
    for (size_t v = 0; v < p->vertices; ++v) {
        const double error = angle(normals + 3 * v, p->exact + 3 * v);
        worst = fmax(worst, error);
        wrong[0] += error > 0.1;
    }
    MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    MPI_Allreduce(MPI_IN_PLACE, wrong, 2, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    if (!rank)
        printf("%-28s %5.1f %% of the vertices wrong by more than 0.1 degrees, worst %.2f\n", how,
            100 * wrong[0] / wrong[1], worst);
}

int main(int argc, char **argv) {
    int rank, ranks;
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    part *p = calloc(1, sizeof *p);
    float *normals = malloc(VERTICES * 3 * sizeof *normals);
    if (!p || !normals) MPI_Abort(MPI_COMM_WORLD, 1);
    fill(p, rank, ranks);

    norma_mesh mesh = {.corners = p->corners, .corner_count = 3 * p->faces};
    mesh.positions.data = p->points;
    mesh.positions.count = p->vertices;
    norma_result result = norma_vertex_normals(&mesh, NULL, normals, p->vertices, NULL);
    if (result == NORMA_OK) report(p, normals, "each rank by itself:", rank);
    result = norma_mpi_vertex_normals(
        MPI_COMM_WORLD, &mesh, p->vertex_ids, p->face_ids, NULL, normals, p->vertices, NULL);
    if (result == NORMA_OK) report(p, normals, "norma_mpi_vertex_normals:", rank);
    if (!rank && result != NORMA_OK) fprintf(stderr, "%s\n", norma_result_text(result));
    free(p);
    free(normals);
    MPI_Finalize();
    return result != NORMA_OK;
}
