/* main.c: norma-mpi compute: normals of one large file, by all ranks together. */
#define _XOPEN_SOURCE 700
#include "mpi/file/shared_file.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

static const char HELP[] =
    "mpirun -n RANKS norma-mpi compute IN -o OUT: computes normals and writes them into a copy of "
    "IN\n"
    "\n"
    "Each rank reads and writes a slice of the file; the output is byte for byte that of norma "
    "compute.\n"
    "IN is a binary PLY (a normal for each vertex) or a binary STL (facet normals), on a file\n"
    "system that all ranks see.\n"
    "\n"
    "  -o OUT                the output; a failure leaves an existing file as it was\n"
    "  --weight angle|area|uniform|max|angle-area|visible|angle-lengths\n"
    "                        how faces are averaged (angle)\n"
    "  --weld exact|none|DISTANCE\n"
    "                        which vertices share a normal: those at equal positions (exact), "
    "none, or those\n"
    "                        within DISTANCE (all positions then go through one rank)\n"
    "  --smooth              one normal for each position (what it always does)\n"
    "  --json                prints a summary as JSON\n"
    "  --quiet               prints no summary\n"
    "  --help, --version\n"
    "\n"
    "Exit status, on every rank: 0 fine, 2 wrong usage, 3 the file could not be read or written.\n";

typedef struct settings {
    mpi_job job;
    int json, quiet;
    const char *wrong; /* what is wrong with the command line */
    const char *word;
} settings;

/* ---- the command line */

static int tool_refuse(settings *s, const char *word, const char *wrong) {
    s->word = word;
    s->wrong = wrong;
    return 0;
}

static int tool_set_weight(settings *s, const char *word) {
    for (int w = 0; norma_weight_name((norma_weight)w); ++w) {
        if (strcmp(word, norma_weight_name((norma_weight)w)) != 0) continue;
        s->job.options.weight = (norma_weight)w;
        return 1;
    }
    return tool_refuse(s, word,
        "no such weight; expected angle, area, uniform, max, angle-area, visible "
        "or angle-lengths");
}

static int tool_set_weld(settings *s, const char *word) {
    norma_options *o = &s->job.options;
    char *end;
    o->weld = strcmp(word, "none") == 0    ? NORMA_WELD_NONE
              : strcmp(word, "exact") == 0 ? NORMA_WELD_EXACT
                                           : NORMA_WELD_DISTANCE;
    if (o->weld != NORMA_WELD_DISTANCE) return 1;
    o->weld_distance = strtod(word, &end);
    if (end != word && !*end && isfinite(o->weld_distance) && o->weld_distance >= 0) return 1;
    return tool_refuse(s, word, "expected exact, none or a distance from 0 up in the file's unit");
}

static int takes_value(const char *name) {
    return strcmp(name, "--weight") == 0 || strcmp(name, "--weld") == 0 || strcmp(name, "-o") == 0;
}

/* An option with a value; 0: refused. */
static int set_value(settings *s, const char *name, const char *value) {
    if (!value) return tool_refuse(s, name, "needs a value");
    if (strcmp(name, "--weight") == 0) return tool_set_weight(s, value);
    if (strcmp(name, "--weld") == 0) return tool_set_weld(s, value);
    s->job.output = value;
    return 1;
}

static int set_flag(settings *s, const char *word) {
    if (strcmp(word, "--json") == 0)
        s->json = 1;
    else if (strcmp(word, "--quiet") == 0)
        s->quiet = 1;
    else if (strcmp(word, "--smooth") != 0)
        return tool_refuse(s, word, "no such option (see norma-mpi --help)");
    return 1;
}

/* The source is never replaced, nor what is no file. */
static int tool_check_output(settings *s) {
    struct stat in, out;
    const char *from = strrchr(s->job.input, '.'), *to = strrchr(s->job.output, '.');
    if (!from || !to || strcasecmp(from, to) != 0)
        return tool_refuse(
            s, s->job.output, "the output has the input's format; give it the same ending");
    if (lstat(s->job.output, &out) != 0) return 1;
    if (stat(s->job.input, &in) == 0 && in.st_dev == out.st_dev && in.st_ino == out.st_ino)
        return tool_refuse(s, s->job.output, "this is the input; norma-mpi writes another file");
    return S_ISREG(out.st_mode) ||
           tool_refuse(s, s->job.output, "this exists and is not a regular file");
}

static int read_arguments(settings *s, int argc, char **argv) {
    for (int i = 2; i < argc; ++i) {
        if (takes_value(argv[i])) {
            if (!set_value(s, argv[i], i + 1 < argc ? argv[i + 1] : NULL)) return 0;
            ++i;
        } else if (argv[i][0] == '-') {
            if (!set_flag(s, argv[i])) return 0;
        } else if (s->job.input) {
            return tool_refuse(s, argv[i], "one input is enough");
        } else {
            s->job.input = argv[i];
        }
    }
    if (argc < 2 || strcmp(argv[1], "compute") != 0)
        return tool_refuse(
            s, argc < 2 ? "norma-mpi" : argv[1], "expected: norma-mpi compute IN -o OUT");
    if (!s->job.input || !s->job.output)
        return tool_refuse(s, "compute", "expected an input, and -o with an output");
    return tool_check_output(s);
}

/* ---- the summary */

static void tool_print_text(const char *text) { /* as JSON */
    putchar('"');
    for (const unsigned char *at = (const unsigned char *)text; *at; ++at) {
        if (*at == '"' || *at == '\\')
            printf("\\%c", *at);
        else if (*at < 0x20)
            printf("\\u%04x", *at);
        else
            putchar(*at);
    }
    putchar('"');
}

static const char *const CARGOS[MPI_CARGOS] = {
    "positions", "homes", "votes", "normals", "cells", "other"};

static void print_json(const mpi_job *job, uint64_t memory) {
    const norma_report *r = &job->report;
    const unsigned long long vertices = job->vertices;
    printf("{\"input\": ");
    tool_print_text(job->input);
    printf(", \"output\": ");
    tool_print_text(job->output);
    printf(", \"faces\": %llu, \"vertices\": {\"before\": %llu, \"after\": %llu}",
        (unsigned long long)job->faces, vertices, vertices);
    printf(", \"weight\": \"%s\", \"crease_deg\": null, \"hard_edges\": null",
        norma_weight_name(job->options.weight));
    printf(", \"report\": {\"degenerate_faces\": %zu, \"cancelled\": %zu, \"unreferenced\": %zu, "
           "\"non_finite\": %zu, \"non_manifold_edges\": null, \"winding_conflicts\": null}",
        r->degenerate_faces.count, r->cancelled.count, r->unreferenced.count, r->non_finite.count);
    printf(", \"ranks\": %d, \"most_memory_of_a_rank\": %llu", job->call.ranks,
        (unsigned long long)memory);
    for (int i = 0; i < MPI_CARGOS; ++i)
        printf("%s\"%s\": %llu", i ? ", " : ", \"sent\": {", CARGOS[i],
            (unsigned long long)job->call.sent[i]);
    printf("}}\n");
}

/* memory: that of the rank that needed most. */
static void print_summary(const settings *s, uint64_t memory) {
    const mpi_job *job = &s->job;
    const norma_report *r = &job->report;
    const size_t without = r->cancelled.count + r->unreferenced.count + r->non_finite.count;
    if (s->json) {
        print_json(job, memory);
        return;
    }
    if (s->quiet) return;
    printf("%s: normals of %llu faces and %llu vertices, by %d ranks\n", job->output,
        (unsigned long long)job->faces, (unsigned long long)job->vertices, job->call.ranks);
    if (r->degenerate_faces.count)
        printf("  %zu degenerate faces (almost no area) were ignored\n", r->degenerate_faces.count);
    if (without) printf("  %zu normals are those of the nearest neighbour\n", without);
}

/* ---- all */

static int has_extension(const char *path, const char *extension) {
    const size_t length = strlen(path), tail = strlen(extension);
    if (length < tail) return 0;
    for (size_t i = 0; i < tail; ++i)
        if ((path[length - tail + i] | 0x20) != extension[i] && extension[i] != '.') return 0;
    return 1;
}

/* What one rank was told must be what the others were. */
static int same_job(mpi_job *job) {
    char theirs[2][1024] = {{0}};
    snprintf(theirs[0], sizeof theirs[0], "%s", job->input);
    snprintf(theirs[1], sizeof theirs[1], "%s", job->output);
    MPI_Bcast(theirs, (int)sizeof theirs, MPI_CHAR, 0, job->call.comm);
    return strncmp(theirs[0], job->input, sizeof theirs[0] - 1) == 0 &&
           strncmp(theirs[1], job->output, sizeof theirs[1] - 1) == 0;
}

static int tool_run(mpi_job *job) {
    const int stl = has_extension(job->input, ".stl"), ply = has_extension(job->input, ".ply");
    int failed = same_job(job)
                     ? 0
                     : norma_mpi_fail(job, "%s: rank %d was given other paths than the first",
                           job->input, job->call.rank);
    if (norma_mpi_failed(job, failed)) return 1;
    if (!stl && !ply) return norma_mpi_fail(job, "%s: is neither .ply nor .stl", job->input);
    job->in = job->out = MPI_FILE_NULL;
    failed = norma_mpi_open_input(job);
    if (!failed) failed = stl ? norma_mpi_compute_stl(job) : norma_mpi_compute_ply(job);
    if (job->in != MPI_FILE_NULL) MPI_File_close(&job->in);
    return failed;
}

/* The gravest of all ranks: who misunderstood the command line must not leave the others waiting.
 */
static int tool_run_all(settings *s, int understood) {
    mpi_job *job = &s->job;
    if (norma_mpi_open_job(job, MPI_COMM_WORLD)) return 3;
    if (!understood) norma_mpi_fail(job, "norma-mpi: \"%s\": %s", s->word, s->wrong);
    int status = norma_mpi_failed(job, !understood) ? 2 : 0;
    if (!status) status = tool_run(job) ? 3 : 0;
    if (status && !job->call.rank) fprintf(stderr, "%s\n", job->message);
    if (!status) {
        const uint64_t most = norma_mpi_largest(&job->call, job->most_memory);
        norma_mpi_reduce(&job->call, job->call.sent, MPI_CARGOS, MPI_UINT64_T, MPI_SUM);
        if (!job->call.rank) print_summary(s, most);
    }
    norma_mpi_end(&job->call);
    return status;
}

static int asks_for(int argc, char **argv, const char *word) {
    for (int i = 1; i < argc; ++i)
        if (strcmp(argv[i], word) == 0) return 1;
    return 0;
}

int main(int argc, char **argv) {
    settings s = {.job = {.options = {.struct_size = sizeof(norma_options),
                              .fallback = NORMA_FALLBACK_NEAREST}}};
    int rank, status = 0;
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    const int help = asks_for(argc, argv, "--help"), version = asks_for(argc, argv, "--version");
    if (help || version) {
        if (!rank && help) fputs(HELP, stdout);
        if (!rank && !help) printf("norma-mpi %s\n", norma_version());
    } else {
        status = tool_run_all(&s, read_arguments(&s, argc, argv));
    }
    MPI_Finalize();
    return status;
}
