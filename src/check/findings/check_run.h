/* check_run.h: what the files of src/check share: one run over a file, one mesh in it with the
 * geometry that its rules have in common, and how findings are added. */
#ifndef NORMA_CHECK_INTERNAL_H
#define NORMA_CHECK_INTERNAL_H
#include <norma/check.h>
#include <stdatomic.h>
#include "core/topology/topology.h"
#include <math.h>
#include "core/face/face.h"

typedef enum check_rule {
#define RULE(id, name, render, print, fix, verb, validator, what, cause, why, how) RULE_##id,
#include "check/findings/rules.def"
#undef RULE
    CHECK_RULE_COUNT
} check_rule;

/* ---- one run, and what it looks at */

typedef struct check_spot { /* SIZE_MAX: does not apply */
    size_t vertex, face, normal;
} check_spot;
#define CHECK_NOWHERE ((check_spot){SIZE_MAX, SIZE_MAX, SIZE_MAX})
static inline check_spot norma_check_vertex(size_t vertex) {
    return (check_spot){vertex, SIZE_MAX, SIZE_MAX};
}
static inline check_spot norma_check_face(size_t face) {
    return (check_spot){SIZE_MAX, face, SIZE_MAX};
}

/* What one finding is made of while it is gathered: each block of a loop has its own, and they are
 * merged in ascending order. Zero-initialised. */
typedef struct check_hits {
    size_t count;
    int least;    /* the worst is the least value, not the greatest */
    double worst; /* of count > 0 */
    check_spot worst_spot;
    check_spot *samples; /* the first ones, to be freed by norma_check_hits_free */
    size_t sample_count, sample_room;
    int failed; /* out of memory: told by norma_check_add */
} check_hits;

/* What a pass over elements sums up: places that were hit, counts, an area. Zero-initialised, but
 * for what is least; each rule says what it keeps where. */
enum { CHECK_SUM_HITS = 4, CHECK_SUM_COUNTS = 3 };
typedef struct check_sum {
    check_hits hits[CHECK_SUM_HITS];
    size_t counts[CHECK_SUM_COUNTS];
    double twice_area;
} check_sum;

typedef struct check_mesh check_mesh;

/* Several meshes as one, of positions of its own: its faces are theirs, one after another.
 * (check_mesh.c) */
typedef struct check_joined {
    norma_mesh mesh;
    double *positions;
    uint32_t *corners, *starts; /* starts: NULL where all are triangles */
} check_joined;
/* MEMORY, OVERFLOW: there is nothing to free. */
norma_result norma_check_join(const core_mesh *meshes, size_t count, check_joined *joined);
norma_result norma_check_join_held(check_mesh *const *held, size_t count, check_joined *joined);
void norma_check_unjoin(check_joined *joined);

/* Which sides the faces of a group have: made when first asked for (check_mesh.c). */
typedef struct check_judge {
    core_side_judge sides;
    int is_open;
    check_joined whole; /* whose faces they are, where that had to be made */
} check_judge;

/* The primitives of one glTF mesh, or the one mesh of another file. */
typedef struct check_group {
    const norma_check_mesh *meshes;
    size_t count;
    check_mesh *each;             /* of them */
    check_mesh **seams, **solids; /* those of each that are held until the last one has come: for
                                     N501; for N301, N302, N304 and N307 */
    size_t seam_count, solid_count;
    check_judge
        *judge; /* of all their faces together: own, or that of a surface that is the same */
    check_judge own;
} check_group;

/* Where the mesh that is looked at lies in its file, if it is a part of it. */
typedef struct check_part {
    size_t first_face, first_vertex;
    const uint32_t *vertices; /* the number of each vertex; NULL: they follow first_vertex */
} check_part;

typedef struct check_run {
    norma_check_options options; /* every field valid */
    norma_check_profile profile; /* render or print; generated models are judged as prints, which no
                                    rule takes less seriously, and their findings raised */
    norma_file_format format;
    uint8_t rules[CHECK_RULE_COUNT]; /* wanted: nonzero */
    core_call call;                  /* memory, threads, progress */
    norma_findings *findings;
    const struct check_places *known; /* of a document that differs little; or NULL */
    int is_trial;                     /* of a fix: see check_known */
    check_judge *judge;     /* of a surface that the next group's is the same as; or NULL */
    const check_part *part; /* what is hit has the numbers of this part; NULL: those of the file */
    /* NULL, or gives the name of a material's normal map, or NULL; from map_names */
    const char *(*map_name)(void *map_names, size_t material);
    void *map_names;
    int has_tile_instances; /* what they do to a node no fix can bake */
    size_t next_order;      /* places are numbered as they come */
    check_group *group;     /* the meshes that are looked at together now */
} check_run;

typedef struct check_place {
    size_t order;              /* of run->next_order++ */
    const char *where, *label; /* copied when a finding is added */
} check_place;

typedef struct check_finding { /* to be added, by norma_check_report or norma_check_add */
    check_rule rule;
    norma_severity severity;
    const char *unit;  /* NULL: "" */
    int no_value;      /* worst_value is NaN */
    int no_fix;        /* else the rule's own */
    int fix_is_unsafe; /* though the rule's own is safe */
    check_hits *hits;  /* count 0: nothing is added. Emptied */
    const char *message;
    const norma_deviation *deviation;
} check_finding;

/* run.c: the fields that the caller's header has: a struct_size of 0 is that of the first version,
 * what it does not know is zero. ARGUMENT: a later caller asks for what this library does not know.
 */
norma_result norma_check_take_options(
    const norma_check_options *given, norma_check_options *options);

/* ---- findings (findings.c) */

/* Room for one more element of size bytes than count. NULL: out of memory; the block stays. */
void *norma_check_grow(void *block, size_t count, size_t *room, size_t size);

/* The greatest angle of one kind, at a corner of the mesh; so small that it is nobody's fault, at
 * no place. */
void norma_check_hit_greatest(const check_mesh *m, check_hits *hits, double degrees, size_t corner);
/* value: how bad (NaN: nothing to compare). */
void norma_check_hit(const check_run *run, check_hits *hits, double value, check_spot spot);
/* One more place of something that was counted: a sample alone. */
void norma_check_also(const check_run *run, check_hits *hits, check_spot spot);
/* into is followed by from; from is emptied. */
void norma_check_hits_merge(const check_run *run, check_hits *into, check_hits *from);
void norma_check_hits_free(check_hits *hits);
/* With a message, at a place that is no mesh. MEMORY. Frees the hits' samples in any case. */
norma_result norma_check_add(check_run *run, const check_place *place, check_finding *report);
/* A finding of count 1 without a value. */
norma_result norma_check_add_one(check_run *run, const check_place *place, check_rule rule,
    norma_severity severity, const char *message);
void norma_check_partly(
    check_run *run); /* something was not checked, whether N002 was asked for or not */

/* rule_table.c: whether a generated model must be free of what the rule finds. */
int norma_check_is_required(const norma_rule *rule);

/* ---- messages, without locale: %s text, %z size_t, %g double with three significant
 * digits, %% a percent sign */
enum { CHECK_MESSAGE = 1000 };
void norma_check_message(char text[CHECK_MESSAGE], const char *format, ...);
/* norma_check_add at the mesh's place, with such a message. */
norma_result norma_check_report(check_mesh *m, check_finding *report, const char *format, ...);
/* The same of one that counts 1. degrees: its value; NaN: it has none. */
norma_result norma_check_report_one(check_mesh *m, check_rule rule, norma_severity severity,
    double degrees, const char *format, ...);
/* For messages: "1 tangent", "2 tangents". */
static inline const char *norma_check_plural(size_t count) { return count == 1 ? "" : "s"; }

/* ---- one mesh (check_mesh.c) */

typedef struct check_face {
    float normal[3]; /* unit; zero: the face is degenerate, or not finite */
    float height;    /* over its longest edge: twice the area / longest edge squared; 1 where a
                        position is not finite; its breadth where a polygon's area cancels, which
                        has no direction */
} check_face;

struct check_mesh {
    check_run *run;
    const norma_check_mesh *given;
    size_t order;                    /* of its place */
    uint8_t rules[CHECK_RULE_COUNT]; /* wanted here: without those that extras silence */
    int in_parts;   /* the whole of a file that is never in memory: it has counts, but no arrays */
    size_t number;  /* in run->group */
    int siblings;   /* other primitives of the same mesh are checked too */
    int on_purpose; /* the material is double-sided or not opaque: normals and windings may be meant
                       as they are */
    core_mesh mesh; /* checked; as the file has it, not welded */
    /* Made when first asked for, freed with the mesh. */
    core_topology topology; /* topology.mesh: the same with corners that are welded positions, the
                               least of those that are exactly equal */
    int has_topology;
    check_face *faces;
    uint32_t *users; /* where corners name normals (OBJ): of each normal the first corner that does;
                        UINT32_MAX: none */
    uint8_t *opposed;                /* of each face: whether N201 names it. NULL: not looked at */
    size_t opposed_count, far_count; /* far: corners whose normal is far from their face (N202) */
    atomic_uchar *far;               /* of each normal: it is one of these; filled with opposed */
    double opposed_area;             /* twice */
    int placeholder, frame;          /* CHECK_UNKNOWN, _NO or _YES: N203, N206 hold */
    int has_deviation;
    norma_deviation deviation;
    size_t deviation_corner; /* where it is greatest; SIZE_MAX: all are zero */
    /* Of one of the group's solids: */
    uint32_t *welded; /* of each corner: positions that are one, the least of them */
    uint8_t *loose;   /* of each face: its component is not closed */
};
enum { CHECK_UNKNOWN = 0, CHECK_NO, CHECK_YES };

static inline int norma_check_wants(const check_mesh *m, check_rule rule) {
    return m->rules[rule] != 0;
}
/* Whether any rule from first to last is wanted. */
static inline int norma_check_wants_any(const check_mesh *m, check_rule first, check_rule last) {
    int wanted = 0;
    for (size_t rule = (size_t)first; rule <= (size_t)last; ++rule) wanted |= m->rules[rule];
    return wanted;
}

/* Each makes what is not there yet. OK, MEMORY or CANCELLED. */
norma_result norma_check_weld(check_mesh *m);  /* topology.mesh */
norma_result norma_check_faces(check_mesh *m); /* faces */
norma_result norma_check_around(
    check_mesh *m); /* topology.corners_of: the corners at each position */
norma_result norma_check_users(check_mesh *m); /* users, where data.corner_normals is given */
size_t norma_check_face_of(const check_mesh *m, size_t corner);

/* How many normals are stored: of vertices, vn, facets. Of vn only those count that a face uses. */
static inline size_t norma_check_normal_count(const check_mesh *m) {
    return m->given->info.normals == NORMA_NORMALS_NONE ? 0 : m->given->data.normals.count;
}

/* A face whose height is less than this of its longest edge: its direction says little, and its
 * area is almost nothing. */
static inline int norma_check_is_sliver(const check_face *face) { return face->height < 1e-4F; }
/* Twice the area of some face, 0 where it is not finite; and sum with that of each
 * face added, one after another. */
double norma_check_twice_area(const check_mesh *m, size_t face);
double norma_check_add_areas(const check_mesh *m, double sum);
double norma_check_diagonal(const core_mesh *mesh); /* of the box of all positions; 0: none */

/* The number of a corner's stored normal; SIZE_MAX: none. */
static inline size_t norma_check_normal_of(const check_mesh *m, size_t face, size_t corner) {
    const norma_mesh_data *data = &m->given->data;
    size_t number = data->corner_normals ? data->corner_normals[corner]
                    : m->given->info.normals == NORMA_NORMALS_PER_FACET ? face
                    : m->given->info.normals == NORMA_NORMALS_PER_CORNER
                        ? corner
                        : norma_core_corner(&m->mesh, corner);
    return number < norma_check_normal_count(m) ? number : SIZE_MAX;
}

static inline void norma_check_normal(const check_mesh *m, size_t number, double normal[3]) {
    const norma_vec3_view *view = &m->given->data.normals;
    if (view->format != NORMA_FORMAT_FLOAT) {
        norma_view_read(view, number, normal);
        return;
    }
    const unsigned char *at = (const unsigned char *)view->data +
                              number * (view->stride ? view->stride : 3 * sizeof(float));
    for (size_t i = 0; i < 3; ++i) {
        float n;
        memcpy(&n, at + i * sizeof n, sizeof n); /* one by one: no detour through memory */
        normal[i] = (double)n;
    }
}

static inline double norma_check_dot(const float a[3], const double b[3]) {
    return (double)a[0] * b[0] + (double)a[1] * b[1] + (double)a[2] * b[2];
}
static inline int norma_check_directed(const check_face *face) {
    return face->normal[0] != 0 || face->normal[1] != 0 || face->normal[2] != 0;
}

/* The spot of a stored normal: a vertex in glTF and PLY, a vn with the first vertex and face that
 * use it in OBJ (norma_check_users was called), a facet in STL. */
check_spot norma_check_normal_spot(const check_mesh *m, size_t number);

/* Greatest error of the normals' encoding in radians; 0: as good as none. */
double norma_check_encoding_bound(const char *encoding);

/* Calls task for blocks of size elements out of count; by threads where there is more than one
 * block. What is gathered in a block is merged in their order. */
typedef void check_block(void *context, size_t block, size_t begin, size_t end);
norma_result norma_check_blocks(
    core_call *call, size_t count, size_t size, check_block *task, void *context);
static inline size_t norma_check_block_count(size_t count, size_t size) {
    return count / size + (count % size != 0);
}
/* Adds to sum what look adds to a part for each block of elements. */
typedef void check_look(const void *pass, check_sum *part, size_t begin, size_t end);
norma_result norma_check_gather(
    check_run *run, size_t count, size_t size, check_look *look, const void *pass, check_sum *sum);
void norma_check_sum_merge(const check_run *run, check_sum *sum, check_sum *part); /* empties it */
void norma_check_sum_free(check_sum *sum);

/* Of an ascending list the place of the last number that is no greater; 0: the first is. */
size_t norma_check_last_at(const uint32_t *sorted, size_t count, size_t number);

/* ---- which faces are turned (check_mesh.c) */

/* Which faces are turned, as core_side_judge says; asked: a mark for each face that
 * matters. sides: of each face of the mesh. */
norma_result norma_check_sides(check_mesh *m, const uint8_t *asked, uint8_t *sides);
/* judge: all zero, or open; threads: 0: all. */
norma_result norma_check_open_judge(
    const core_mesh *meshes, size_t count, uint32_t threads, check_judge *judge);
void norma_check_close_judge(check_judge *judge);
/* Of an STL's facets whose sides neither volume nor rays decide: a normal within 25 degrees of its
 * winding, or of its winding's opposite, that agrees with its neighbours' says which it is. */
#define CHECK_LEAN_COSINE 0.9063077870366499
norma_result norma_check_sides_by_facets(
    const core_side_judge *judge, const norma_vec3_view *normals, uint8_t *sides);
int norma_check_is_turned(uint8_t side); /* shown to be, not only different from most */
/* Whether the faces of two corners, which run along an edge in the same direction from there, lie
 * folded over one another: their normals agree. */
int norma_check_is_fold(const core_topology *topology, size_t first, size_t second);
/* sides: of count faces from first on. What is wound against the rest of its part only where it
 * lies folded over that is not shown to be turned, except by rays. */
norma_result norma_check_sides_at_folds(
    const core_side_judge *judge, size_t first, size_t count, uint8_t *sides);
/* After that: how many faces are shown to be turned, of those and of all in components whose faces
 * do not agree; and twice their area. */
size_t norma_check_count_turned(
    const check_mesh *m, const uint8_t *asked, const uint8_t *sides, double *twice_area);

/* ---- places (findings.c) */

/* "mesh 0 primitive 1 \"name\"", or "" for the one mesh of OBJ, PLY and STL. */
void norma_check_label(const norma_mesh_info *info, char label[CHECK_MESSAGE]);
/* Takes from mask the rules that a list of extras' "ignore" names. Words that name no rule are
 * skipped. */
void norma_check_silence(uint8_t mask[CHECK_RULE_COUNT], const char *ignore);
/* Whether both are primitives of one glTF mesh, in this order. */
int norma_check_siblings(const norma_mesh_info *first, const norma_mesh_info *second);

/* ---- what stands behind norma_findings (findings.c) */

typedef struct findings_entry {
    norma_finding finding;
    size_t order; /* of its place, then of its addition */
    size_t number;
} findings_entry;

struct norma_findings {
    norma_check_profile profile;
    norma_check_options options;     /* asked for; the pointers in it are not to be followed */
    uint8_t rules[CHECK_RULE_COUNT]; /* asked for */
    int partly;
    findings_entry *entries;
    size_t count, room;
};

norma_findings *norma_findings_new(norma_check_profile profile); /* NULL: out of memory */
void norma_findings_sort(norma_findings *findings);              /* by place, rule, severity */
typedef struct check_places { /* findings, sorted by place; those of one place as they were found */
    const norma_finding **findings;
    size_t count;
} check_places;
typedef int check_is_place(const void *context, const norma_finding *finding);

/* Of all findings, or of those that are; its array is to be freed. 0: out of memory. */
int norma_places_gather(check_places *places, const norma_findings *findings,
    check_is_place *is_place, const void *context);
const norma_finding **norma_places_find(
    const check_places *places, const char *where, size_t *count);
/* How the stored normals at a place were made, as N204 says; NULL: it does not. */
const norma_deviation *norma_places_deviation(const check_places *places, const char *where);
/* Adds a copy of another's finding. 0: out of memory. */
int norma_findings_copy(norma_findings *findings, const norma_finding *finding, size_t order);

/* To be changed: by norma_finding_withdraw, which takes its fix from it and gives it another
 * message. 0: out of memory. */
norma_finding *norma_findings_change(norma_findings *findings, size_t index);
int norma_finding_withdraw(norma_finding *finding, const char *message);

/* Fills in the positions of samples, as locate finds that of their vertex or else the middle of
 * their face. */
typedef norma_document_result check_locate(void *context, norma_sample *sample);
norma_document_result norma_findings_locate(
    norma_findings *findings, check_locate *locate, void *context);

/* ---- angles of cosines and sines, by the core's own arc tangent: the C library's differ
 * between systems by a last bit, and findings are the same on all of them. */

/* Of a cosine from -1 to 1: 0 to pi. */
static inline double norma_check_arc_cosine(double cosine) {
    return norma_core_angle(sqrt(fmax((1 - cosine) * (1 + cosine), 0)), cosine);
}

/* Of a sine from 0 to 1: 0 to pi/2. */
static inline double norma_check_arc_sine(double sine) {
    return norma_core_angle(sine, sqrt(fmax((1 - sine) * (1 + sine), 0)));
}

/* ---- run.c: a run over a file: begin; norma_check_run_group for each glTF mesh or the one mesh of
 * another file; rules on nodes and the like; finish or abandon. */

/* format decides the profile where options do not. ARGUMENT, MEMORY: nothing to abandon. */
norma_result norma_check_begin(
    check_run *run, const norma_check_options *options, norma_file_format format);
/* Without a place. Owns nothing until a rule asks for its geometry. ARGUMENT, INDEX, OVERFLOW:
 * arrays that no rule may walk. */
norma_result norma_check_open_mesh(check_run *run, const norma_check_mesh *given, check_mesh *m);
void norma_check_close_mesh(check_mesh *m);
/* meshes: those that belong together, as norma_check_siblings has it. orders: of their places, or
 * NULL: they are next. */
norma_result norma_check_run_group(
    check_run *run, const norma_check_mesh *meshes, size_t count, const size_t *orders);
norma_findings *norma_check_finish(check_run *run);
void norma_check_abandon(check_run *run);

/* check_document.c: what is the same in known->document as here is not looked at again, but by the
 * rules of known->again: the findings there, of every rule that is asked for, are copied. known
 * NULL: nothing is known. */
typedef struct check_known {
    norma_document *document;
    const norma_findings *findings;
    const uint8_t *again; /* NULL: none */
    check_judge *judges;  /* NULL, or for each mesh of the document that of the group it begins */
    int is_trial;         /* of a fix: findings are counted, and their words read by nobody */
} check_known;
norma_document_result norma_check_again(norma_document *document, const check_known *known,
    const norma_check_options *options, norma_findings **findings, norma_document_error *error);

/* check_document.c: that a document cannot be checked, or fixed, in words. NORMA_OK: nothing. */
norma_document_result norma_check_fail_to(
    norma_document_error *error, norma_result result, const char *verb);
static inline norma_document_result norma_check_fail(
    norma_document_error *error, norma_result result) {
    return norma_check_fail_to(error, result, "checked");
}
static inline norma_document_result norma_fix_fail(
    norma_document_error *error, norma_result result) {
    return norma_check_fail_to(error, result, "fixed");
}
#endif
