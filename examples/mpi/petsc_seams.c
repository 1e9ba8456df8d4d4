/* petsc_seams.c: normals of a surface that PETSc's DMPlex has distributed, as a solver has it. A
 * rank that sums the normals of its own cells gets wrong ones along the seams, so a load along them
 * (pressure, flux, contact) is wrong there too; norma_mpi_vertex_normals gets those of the whole
 * surface, with the same bits for any number of ranks. The surface is a torus, whose normals are
 * known. (PETSc 3.18; Balay et al., PETSc/TAO Users Manual.)
 *
 *   mpirun -n 4 petsc_seams */
#include <norma/mpi.h>
#include <petscdmplex.h>
#include <petscsf.h>
#include <string.h>

enum { AROUND = 240, ACROSS = 80, VERTICES = AROUND * ACROSS, CELLS = 2 * VERTICES };

/* ---- the surface, whole on the first rank; then dealt out */

static void place(PetscInt vertex, double point[3], double normal[3]) {
    const double u = 2 * PETSC_PI * (vertex % AROUND) / AROUND,
                 v = 2 * PETSC_PI * (vertex / AROUND) / ACROSS;
    normal[0] = cos(v) * cos(u), normal[1] = cos(v) * sin(u), normal[2] = sin(v);
    point[0] = (3 + cos(v)) * cos(u), point[1] = (3 + cos(v)) * sin(u), point[2] = sin(v);
}

static PetscErrorCode make_torus(PetscMPIInt rank, DM *dm) {
    static PetscInt corners[3 * CELLS];
    static PetscReal points[3 * VERTICES];
    double normal[3];
    PetscFunctionBeginUser;
    for (PetscInt v = 0; v < VERTICES; ++v) place(v, points + 3 * v, normal);
    for (PetscInt c = 0; c < CELLS; ++c) {
        const PetscInt x = c / 2 % AROUND, y = c / 2 / AROUND, x1 = (x + 1) % AROUND,
                       y1 = (y + 1) % ACROSS;
        corners[3 * c] = y * AROUND + x;
        corners[3 * c + 1] = c % 2 ? y1 * AROUND + x1 : y * AROUND + x1;
        corners[3 * c + 2] = c % 2 ? y1 * AROUND + x : y1 * AROUND + x1;
    }
    PetscCall(DMPlexCreateFromCellListPetsc(PETSC_COMM_WORLD, 2, rank ? 0 : CELLS,
        rank ? 0 : VERTICES, 3, PETSC_FALSE, corners, 3, points, dm));
    PetscFunctionReturn(0);
}

/* numbers: of each point of the distributed mesh, the number that it had before: cells from 0 on,
 * then vertices. The caller frees them. */
static PetscErrorCode distribute(DM *dm, PetscInt **numbers) {
    PetscSF sf = NULL;
    DM parts = NULL;
    PetscInt begin, end, *before;
    PetscFunctionBeginUser;
    PetscCall(DMPlexGetChart(*dm, &begin, &end));
    PetscCall(PetscMalloc1(end, &before));
    for (PetscInt p = begin; p < end; ++p) before[p] = p;
    PetscCall(DMPlexDistribute(*dm, 0, &sf, &parts));
    if (!parts) { /* one rank */
        *numbers = before;
        PetscFunctionReturn(0);
    }
    PetscCall(DMDestroy(dm));
    *dm = parts;
    PetscCall(DMPlexGetChart(parts, &begin, &end));
    PetscCall(PetscMalloc1(end, numbers));
    PetscCall(PetscSFBcastBegin(sf, MPIU_INT, before, *numbers, MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(sf, MPIU_INT, before, *numbers, MPI_REPLACE));
    PetscCall(PetscSFDestroy(&sf));
    PetscCall(PetscFree(before));
    PetscFunctionReturn(0);
}

/* ---- this rank's part as Norma takes it */

typedef struct part {
    norma_mesh mesh;
    uint64_t vertex_ids[VERTICES], face_ids[CELLS];
    uint32_t corners[3 * CELLS];
    double points[3 * VERTICES];
    float normals[3 * VERTICES];
} part;

static PetscErrorCode read_part(DM dm, const PetscInt *numbers, part *p) {
    PetscInt cells[2], vertices[2], all;
    PetscSection section;
    Vec points;
    const PetscScalar *values;
    PetscFunctionBeginUser;
    PetscCall(DMPlexGetHeightStratum(dm, 0, &cells[0], &cells[1]));
    PetscCall(DMPlexGetDepthStratum(dm, 0, &vertices[0], &vertices[1]));
    PetscCall(DMGetCoordinateSection(dm, &section));
    PetscCall(DMGetCoordinatesLocal(dm, &points));
    PetscCall(VecGetArrayRead(points, &values));
    for (PetscInt v = vertices[0]; v < vertices[1]; ++v) {
        PetscInt offset;
        PetscCall(PetscSectionGetOffset(section, v, &offset));
        for (PetscInt k = 0; k < 3; ++k)
            p->points[3 * (v - vertices[0]) + k] = PetscRealPart(values[offset + k]);
    }
    PetscCall(VecRestoreArrayRead(points, &values));
    for (PetscInt c = cells[0]; c < cells[1]; ++c) {
        const PetscInt *cone;
        PetscCall(DMPlexGetCone(dm, c, &cone));
        for (PetscInt k = 0; k < 3; ++k)
            p->corners[3 * (c - cells[0]) + k] = (uint32_t)(cone[k] - vertices[0]);
        p->face_ids[c - cells[0]] = (uint64_t)numbers[c];
    }
    for (PetscInt v = vertices[0]; v < vertices[1]; ++v)
        p->vertex_ids[v - vertices[0]] = (uint64_t)(numbers[v] - CELLS);
    all = vertices[1] - vertices[0];
    p->mesh.corners = p->corners;
    p->mesh.corner_count = 3 * (size_t)(cells[1] - cells[0]);
    p->mesh.positions.data = p->points;
    p->mesh.positions.count = (size_t)all;
    p->mesh.positions.format = NORMA_FORMAT_DOUBLE;
    PetscFunctionReturn(0);
}

/* ---- how far they are off */

/* Positive, so that the largest of all ranks' is that of a rank that has the vertex. */
static uint64_t hash_normal(uint64_t vertex, const float normal[3]) {
    uint64_t hash = vertex + 1;
    for (int k = 0; k < 3; ++k) {
        uint32_t bits;
        memcpy(&bits, normal + k, sizeof bits);
        hash = (hash ^ bits) * UINT64_C(0x9e3779b97f4a7c15);
        hash ^= hash >> 29;
    }
    return hash >> 1;
}

static PetscErrorCode report(const part *p, const char *how) {
    static uint64_t hashes[VERTICES];
    double worst = 0, wrong[2] = {0, (double)p->mesh.positions.count};
    uint64_t bits = 0;
    PetscFunctionBeginUser;
    memset(hashes, 0, sizeof hashes);
    for (size_t v = 0; v < p->mesh.positions.count; ++v) {
        double point[3], exact[3], cosine = 0, sine = 0;
        const float *n = p->normals + 3 * v;
        place((PetscInt)p->vertex_ids[v], point, exact);
        for (int k = 0; k < 3; ++k) cosine += (double)n[k] * exact[k];
        for (int k = 0; k < 3; ++k) sine += pow((double)n[k] - cosine * exact[k], 2);
        const double error = atan2(sqrt(sine), cosine) * 180 / PETSC_PI;
        worst = PetscMax(worst, error);
        wrong[0] += error > 0.1;
        hashes[p->vertex_ids[v]] = hash_normal(p->vertex_ids[v], n);
    }
    PetscCallMPI(
        MPI_Allreduce(MPI_IN_PLACE, hashes, VERTICES, MPI_INT64_T, MPI_MAX, PETSC_COMM_WORLD));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, wrong, 2, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD));
    for (size_t v = 0; v < VERTICES; ++v) bits = bits * 31 + hashes[v];
    PetscCall(PetscPrintf(PETSC_COMM_WORLD,
        "%-26s %5.1f %% of the vertices wrong by more than 0.1 degrees, worst %.2f; bits "
        "%016llx\n",
        how, 100 * wrong[0] / wrong[1], worst, (unsigned long long)bits));
    PetscFunctionReturn(0);
}

int main(int argc, char **argv) {
    static part p;
    PetscMPIInt rank;
    PetscInt *numbers = NULL;
    DM dm = NULL;
    PetscFunctionBeginUser;
    PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
    PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
    PetscCall(make_torus(rank, &dm));
    PetscCall(distribute(&dm, &numbers));
    PetscCall(read_part(dm, numbers, &p));

    const size_t room = p.mesh.positions.count;
    norma_result result = norma_vertex_normals(&p.mesh, NULL, p.normals, room, NULL);
    if (result == NORMA_OK) PetscCall(report(&p, "each rank by itself:"));
    result = norma_mpi_vertex_normals(
        PETSC_COMM_WORLD, &p.mesh, p.vertex_ids, p.face_ids, NULL, p.normals, room, NULL);
    if (result == NORMA_OK) PetscCall(report(&p, "norma_mpi_vertex_normals:"));
    if (result != NORMA_OK)
        PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%s\n", norma_result_text(result)));
    PetscCall(PetscFree(numbers));
    PetscCall(DMDestroy(&dm));
    PetscCall(PetscFinalize());
    return result != NORMA_OK;
}
