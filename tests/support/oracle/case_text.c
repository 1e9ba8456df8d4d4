/* case_text.c: a case as text, and made smaller. See made_case.h.
 *
 *     case FORMAT GAP CORNER_SIZE SOUP POLYGONS NORMAL_GAP BACKWARDS SALT
 *     options WEIGHT WELD DISTANCE NON_MANIFOLD FALLBACK X Y Z THREADS ISA CREASE
 *     v X Y Z
 *     f CORNER[!] ... [: GROUP]       !: the edge from here on is hard */
#include "oracle/made_case.h"
#include <inttypes.h>
#include <stddef.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

void made_case_print(const made_case *c, FILE *file) {
    const norma_options *o = &c->options;
    fprintf(file, "case %d %zu %zu %d %d %zu %d %" PRIu64 "\n", (int)c->format, c->position_gap,
        c->corner_size, c->soup, c->polygons, c->normal_gap, c->backwards, c->salt);
    fprintf(file, "options %d %d %a %d %d %a %a %a %u %d %a\n", (int)o->weight, (int)o->weld,
        o->weld_distance, (int)o->non_manifold, (int)o->fallback, (double)o->fallback_normal[0],
        (double)o->fallback_normal[1], (double)o->fallback_normal[2], (unsigned)o->threads,
        (int)o->isa, (double)c->crease);
    for (size_t v = 0; v < c->position_count; ++v)
        fprintf(file, "v %a %a %a\n", c->positions[v][0], c->positions[v][1], c->positions[v][2]);
    for (size_t f = 0; f < c->face_count; ++f) {
        fputc('f', file);
        for (uint32_t i = c->starts[f]; i < c->starts[f + 1]; ++i)
            fprintf(file, " %u%s", (unsigned)c->corners[i], c->has_hard && c->hard[i] ? "!" : "");
        if (c->has_groups) fprintf(file, " : %u", (unsigned)c->groups[f]);
        fputc('\n', file);
    }
}

static int read_head(made_case *c, FILE *file) {
    norma_options *o = &c->options;
    int format, weight, weld, non_manifold, fallback, isa;
    double given[3], crease;
    unsigned threads;
    memset(c, 0, sizeof *c);
    if (fscanf(file, "case %d %zu %zu %d %d %zu %d %" SCNu64 " ", &format, &c->position_gap,
            &c->corner_size, &c->soup, &c->polygons, &c->normal_gap, &c->backwards, &c->salt) != 8)
        return 0;
    if (fscanf(file, "options %d %d %la %d %d %la %la %la %u %d %la ", &weight, &weld,
            &o->weld_distance, &non_manifold, &fallback, given, given + 1, given + 2, &threads,
            &isa, &crease) != 11)
        return 0;
    c->format = (norma_format)format;
    *o = (norma_options){.struct_size = sizeof *o,
        .weight = (norma_weight)weight,
        .weld = (norma_weld)weld,
        .weld_distance = o->weld_distance,
        .non_manifold = (norma_non_manifold)non_manifold,
        .fallback = (norma_fallback)fallback,
        .fallback_normal = {(float)given[0], (float)given[1], (float)given[2]},
        .threads = threads,
        .isa = (norma_isa)isa};
    c->crease = (float)crease;
    return 1;
}

static int read_face(made_case *c, char *line) {
    char *at = line;
    for (;;) {
        char *end;
        while (*at == ' ') ++at;
        if (*at == '\n' || *at == '\0' || *at == ':') break;
        const unsigned long corner = strtoul(at, &end, 10);
        if (end == at || c->corner_count == CASE_CORNERS) return 0;
        at = end;
        if (*at == '!') c->has_hard = c->hard[c->corner_count] = 1, ++at;
        c->corners[c->corner_count++] = (uint32_t)corner;
    }
    if (*at == ':') {
        c->has_groups = 1;
        c->groups[c->face_count] = (uint32_t)strtoul(at + 1, NULL, 10);
    }
    c->starts[++c->face_count] = (uint32_t)c->corner_count;
    if (c->corner_count != 3 * c->face_count) c->polygons = 1;
    return 1;
}

/* What is handed over as integers has to be some; floats are rounded then. */
static int is_number_of(double x, norma_format format) {
    static const double least[] = {-INFINITY, -INFINITY, -128, 0, -32768, 0},
                        most[] = {INFINITY, INFINITY, 127, 255, 32767, 65535};
    return format <= NORMA_FORMAT_DOUBLE || (x >= least[format] && x <= most[format]);
}

/* Whether it is a case at all, rather than arguments that a call refuses: a fuzzer writes anything.
 */
static int is_sound(const made_case *c) {
    const norma_options *o = &c->options;
    const size_t size = c->corner_size;
    const double given = (double)o->fallback_normal[0] + (double)o->fallback_normal[1] +
                         (double)o->fallback_normal[2];
    for (size_t i = 0; i < c->corner_count; ++i)
        if (c->corners[i] >= c->position_count || (size == 1 && c->corners[i] > 255)) return 0;
    if ((unsigned)c->format > NORMA_FORMAT_UINT16) return 0;
    for (size_t v = 0; v < c->position_count; ++v)
        for (int k = 0; k < 3; ++k)
            if (!is_number_of(c->positions[v][k], c->format)) return 0;
    return c->position_gap < 64 && c->normal_gap < 64 && (size < 3 || size == 4) &&
           (unsigned)o->weight <= NORMA_WEIGHT_ANGLE_LENGTHS &&
           (unsigned)o->weld <= NORMA_WELD_DISTANCE && o->weld_distance >= 0 &&
           (unsigned)o->non_manifold <= NORMA_NON_MANIFOLD_SMOOTH &&
           (unsigned)o->fallback <= NORMA_FALLBACK_GIVEN && given - given == 0 &&
           (unsigned)o->isa <= NORMA_ISA_SIMD128 && o->threads < 64 && c->crease <= 3.1425F;
}

int made_case_read(made_case *c, FILE *file) {
    static char line[16 * CASE_CORNERS];
    if (!read_head(c, file)) return 0;
    while (fgets(line, sizeof line, file)) {
        if (line[0] == 'v') {
            double *p = c->positions[c->position_count++];
            if (c->position_count == CASE_POSITIONS ||
                sscanf(line + 1, "%la %la %la", p, p + 1, p + 2) != 3)
                return 0;
        } else if (c->face_count == CASE_FACES || line[0] != 'f' || !read_face(c, line + 1))
            return 0;
    }
    return is_sound(c);
}

int made_case_load(made_case *c, const char *path) {
    FILE *file = fopen(path, "r");
    const int there = file && made_case_read(c, file);
    if (file) fclose(file);
    if (!there) printf("# %s is no case\n", path);
    return there;
}

/* ---- smaller */

static void drop_corner(made_case *c, size_t corner) {
    size_t face = 0;
    while (c->starts[face + 1] <= corner) ++face;
    memmove(c->corners + corner, c->corners + corner + 1,
        (c->corner_count - corner - 1) * sizeof *c->corners);
    memmove(c->hard + corner, c->hard + corner + 1, c->corner_count - corner - 1);
    --c->corner_count;
    for (size_t f = face + 1; f <= c->face_count; ++f) --c->starts[f];
    c->polygons = 1;
}

static void drop_face(made_case *c, size_t face) {
    const int polygons = c->polygons;
    while (c->starts[face + 1] > c->starts[face]) drop_corner(c, c->starts[face]);
    memmove(c->starts + face, c->starts + face + 1, (c->face_count - face) * sizeof *c->starts);
    memmove(c->groups + face, c->groups + face + 1, (c->face_count - face - 1) * sizeof *c->groups);
    --c->face_count;
    c->polygons = polygons;
}

static void drop_position(made_case *c, size_t position) {
    for (size_t i = 0; i < c->corner_count; ++i)
        if (c->corners[i] == position) return;
    memmove(c->positions + position, c->positions + position + 1,
        (c->position_count - position - 1) * sizeof *c->positions);
    --c->position_count;
    for (size_t i = 0; i < c->corner_count; ++i) c->corners[i] -= c->corners[i] > position;
}

/* What is simpler where it is zero. */
#define FIELD(name)                                                                                \
    { offsetof(made_case, name), sizeof((made_case *)NULL)->name }
static const struct field {
    size_t at, size;
} fields[] = {FIELD(position_gap), FIELD(normal_gap), FIELD(corner_size), FIELD(soup),
    FIELD(has_groups), FIELD(has_hard), FIELD(backwards), FIELD(options.isa), FIELD(options.weight),
    FIELD(options.weld), FIELD(options.non_manifold), FIELD(options.fallback)};
enum {
    FIELDS = sizeof fields / sizeof *fields,
    THREADS = FIELDS,
    FORMAT,
    CREASE,
    NUMBERS,
    SIMPLER
};

static void simplify(made_case *c, int what) {
    if (what < FIELDS) memset((char *)c + fields[what].at, 0, fields[what].size);
    if (what == THREADS) c->options.threads = 1;
    if (what == FORMAT) c->format = NORMA_FORMAT_DOUBLE;
    if (what == CREASE) c->crease = 3.14159274F;
    for (size_t v = 0; v < c->position_count && what == NUMBERS; ++v)
        for (int k = 0; k < 3; ++k)
            if (c->positions[v][k] == c->positions[v][k])
                c->positions[v][k] = (double)(float)c->positions[v][k];
}

enum { DROP_FACE, DROP_CORNER, DROP_POSITION, SIMPLIFY, CHANGES };

static size_t count_of(const made_case *c, int change) {
    return change == DROP_FACE       ? c->face_count
           : change == DROP_CORNER   ? (c->soup ? 0 : c->corner_count)
           : change == DROP_POSITION ? (c->soup ? 0 : c->position_count)
                                     : SIMPLER;
}

void made_case_shrink(made_case *c, int fails(const made_case *)) {
    made_case *trial = malloc(sizeof *trial);
    for (int again = 1; trial && again;) {
        again = 0;
        for (int change = 0; change < CHANGES; ++change)
            for (size_t i = count_of(c, change); i-- > 0;) {
                if (i >= count_of(c, change)) continue;
                *trial = *c;
                if (change == DROP_FACE) drop_face(trial, i);
                if (change == DROP_CORNER) drop_corner(trial, i);
                if (change == DROP_POSITION) drop_position(trial, i);
                if (change == SIMPLIFY) simplify(trial, (int)i);
                if (trial->soup) /* a position for each corner, in order */
                    for (size_t k = 0; k < trial->corner_count; ++k) {
                        if (change == DROP_FACE)
                            memmove(trial->positions[k], c->positions[trial->corners[k]],
                                sizeof *trial->positions);
                        trial->corners[k] = (uint32_t)k;
                    }
                if (!memcmp(trial, c, sizeof *c) || !fails(trial)) continue;
                *c = *trial;
                again |= change != SIMPLIFY;
            }
    }
    free(trial);
}
