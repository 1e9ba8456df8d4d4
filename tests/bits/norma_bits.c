/* norma_bits.c: one hash of each mesh and part of the library, the same on every machine, with
 * every compiler, for any number of threads and any instruction set.
 *
 *   norma_bits [--ways all|some|one] [--made] [--files LIST]
 *
 * --made: the meshes of made.c; --files: those that LIST names, one a line, from the working
 * folder, as files and as arrays. A line for each hash goes to standard output: it is what
 * expected-made.txt and the like hold. Every part is computed in each way and must give one hash:
 * all: 1, 2, 3, 8 and 64 threads with each instruction set, and a caller's jobs; some (the
 * default): each number and each set once, and jobs; one: three threads. Exit status 1 where ways
 * differ, 2 for what cannot be run. */
#include "bits.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_WAYS = 40, LONGEST_NAME = 1000 };

typedef struct run {
    bits_way ways[MOST_WAYS];
    size_t way_count, thread_ways; /* the first of them: all numbers of threads, for what no
                                      instruction set is chosen for */
    size_t hashes, differences;
    char names[MOST_WAYS][48];
} run;

static void backwards(void *user, size_t count, norma_task *task, void *context) {
    (void)user;
    for (size_t i = count; i > 0; --i) task(context, i - 1);
}

static int has(norma_isa isa) {
    const norma_mesh nothing = {.corner_count = 0};
    const norma_options options = {.struct_size = sizeof options, .isa = isa};
    return !norma_face_normals(&nothing, &options, NULL, 0, NULL);
}

static void add_way(run *r, uint32_t threads, norma_isa isa, norma_parallel_for *jobs) {
    static const char *const sets[] = {
        "best", "portable", "SSE2", "AVX2", "AVX-512", "NEON", "SIMD128"};
    bits_way *way = &r->ways[r->way_count];
    snprintf(r->names[r->way_count], sizeof r->names[0], "%s %u, %s",
        jobs ? "jobs backwards" : "threads", (unsigned)threads, sets[isa]);
    *way = (bits_way){threads, isa, jobs, r->names[r->way_count]};
    ++r->way_count;
}

static void choose_ways(run *r, const char *which) {
    static const uint32_t threads[] = {1, 2, 3, 8, 64};
    const int all = !strcmp(which, "all"), one = !strcmp(which, "one");
    for (int i = 0; i < 5; ++i)
        if (!one || threads[i] == 3) add_way(r, threads[i], NORMA_ISA_BEST, NULL);
    r->thread_ways = r->way_count;
    for (int isa = NORMA_ISA_PORTABLE; !one && isa <= NORMA_ISA_SIMD128; ++isa)
        for (int i = 0; has((norma_isa)isa) && i < (all ? 5 : 1); ++i)
            add_way(r, all ? threads[i] : isa % 2 ? 1 : 3, (norma_isa)isa, NULL);
    if (!one) add_way(r, 1, NORMA_ISA_BEST, backwards);
}

static void put(run *r, const char *name, const char *part, const uint64_t *hashes, size_t count) {
    printf("%08lx%08lx  %s %s\n", (unsigned long)(hashes[0] >> 32),
        (unsigned long)(hashes[0] & 0xFFFFFFFFu), name, part);
    ++r->hashes;
    for (size_t i = 1; i < count; ++i)
        if (hashes[i] != hashes[0]) {
            fprintf(stderr, "differs: %s %s: %s and %s\n", name, part, r->ways[0].name,
                r->ways[i].name);
            ++r->differences;
        }
}

typedef struct part {
    const char *name;
    bits_of_mesh *hash;
} part;

static const part PARTS[] = {{"faces", bits_faces}, {"vertices", bits_vertices},
    {"corners", bits_corners}, {"split", bits_split}, {"plans", bits_plans},
    {"morphs", bits_morphs}, {"orient", bits_orient}};
enum { PART_COUNT = sizeof PARTS / sizeof *PARTS };

static void one_part(run *r, const bits_mesh *mesh, const part *p, size_t ways) {
    uint64_t hashes[MOST_WAYS];
    for (size_t i = 0; i < ways; ++i) {
        bits_hash hash = bits_begin();
        p->hash(mesh, &r->ways[i], &hash);
        hashes[i] = hash.state;
    }
    put(r, mesh->name, p->name, hashes, ways);
}

static void made(run *r) {
    static const part check = {"check", bits_check}, tangents = {"tangents", bits_tangents};
    for (size_t i = 0; i < bits_made_count(); ++i) {
        bits_mesh mesh;
        bits_hash hash = bits_begin();
        bits_make(i, &mesh);
        for (size_t p = 0; p < PART_COUNT; ++p) one_part(r, &mesh, &PARTS[p], r->way_count);
        one_part(r, &mesh, &tangents, r->way_count);
        one_part(r, &mesh, &check, r->thread_ways);
        bits_matrices(&mesh, &hash);
        put(r, mesh.name, "matrices", &hash.state, 1);
        hash = bits_begin();
        bits_streams(&mesh, &hash);
        put(r, mesh.name, "streams", &hash.state, 1);
        bits_unmake(&mesh);
    }
}

/* ---- files */

/* All meshes of a file make one hash a part. */
typedef struct gathered {
    const run *r;
    bits_hash parts[PART_COUNT][MOST_WAYS], streams;
} gathered;

static void gather(void *user, const bits_mesh *mesh) {
    gathered *g = user;
    for (size_t p = 0; p < PART_COUNT; ++p)
        for (size_t i = 0; i < g->r->way_count; ++i)
            PARTS[p].hash(mesh, &g->r->ways[i], &g->parts[p][i]);
    bits_streams(mesh, &g->streams);
}

static void arrays_of_file(run *r, const char *path, const void *bytes, size_t size) {
    gathered *g = bits_room(1, sizeof *g);
    uint64_t hashes[MOST_WAYS];
    g->r = r;
    g->streams = bits_begin();
    for (size_t p = 0; p < PART_COUNT; ++p)
        for (size_t i = 0; i < MOST_WAYS; ++i) g->parts[p][i] = bits_begin();
    bits_meshes_of_file(path, bytes, size, gather, g);
    for (size_t i = 0; i < r->way_count; ++i) {
        bits_hash all = g->streams;
        for (size_t p = 0; p < PART_COUNT; ++p) bits_add(&all, g->parts[p][i].state);
        hashes[i] = all.state;
    }
    put(r, path, "arrays", hashes, r->way_count);
    free(g);
}

static void *read_whole(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    size_t room = 1 << 16, got;
    unsigned char *bytes = bits_room(room, 1);
    *size = 0;
    while (file && (got = fread(bytes + *size, 1, room - *size, file)) > 0) {
        *size += got;
        if (*size == room) {
            unsigned char *larger = bits_room(room *= 2, 1);
            memcpy(larger, bytes, *size);
            free(bytes);
            bytes = larger;
        }
    }
    if (file && !ferror(file) && fclose(file) == 0) return bytes;
    fprintf(stderr, "%s cannot be read\n", path);
    exit(2);
}

static void file(run *r, const char *path) {
    uint64_t hashes[MOST_WAYS];
    size_t size;
    void *bytes = read_whole(path, &size);
    for (size_t i = 0; i < r->thread_ways; ++i) {
        bits_hash hash = bits_begin();
        bits_file(path, bytes, size, &r->ways[i], &hash);
        hashes[i] = hash.state;
    }
    put(r, path, "file", hashes, r->thread_ways);
    arrays_of_file(r, path, bytes, size);
    free(bytes);
}

static void files(run *r, const char *list) {
    size_t size, at = 0;
    char *names = read_whole(list, &size), path[LONGEST_NAME];
    while (at < size) {
        size_t length = 0;
        for (; at < size && names[at] != '\n'; ++at)
            if (names[at] != '\r' && length + 1 < sizeof path) path[length++] = names[at];
        path[length] = '\0';
        ++at;
        if (length) file(r, path);
    }
    free(names);
}

int main(int count, char **words) {
    static run r;
    const char *which = "some", *list = NULL;
    int with_made = 0, wrong = count < 2;
    for (int i = 1; i < count && !wrong; ++i) {
        if (!strcmp(words[i], "--made"))
            with_made = 1;
        else if (i + 1 < count && !strcmp(words[i], "--ways"))
            which = words[++i];
        else if (i + 1 < count && !strcmp(words[i], "--files"))
            list = words[++i];
        else
            wrong = 1;
    }
    if (wrong || (strcmp(which, "all") && strcmp(which, "some") && strcmp(which, "one"))) {
        fprintf(stderr, "usage: norma_bits [--ways all|some|one] [--made] [--files LIST]\n");
        return 2;
    }
    choose_ways(&r, which);
    if (with_made) made(&r);
    if (list) files(&r, list);
    fprintf(stderr, "%zu hashes, each in up to %zu ways:", r.hashes, r.way_count);
    for (size_t i = 0; i < r.way_count; ++i) fprintf(stderr, "%s %s", i ? ";" : "", r.ways[i].name);
    fprintf(stderr, "\n");
    return r.differences || !r.hashes || fflush(stdout) ? 1 : 0;
}
