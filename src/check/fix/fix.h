/* fix.h: what the files of fixing share: one mesh of a document, what the rules found in it, and
 * the edit that grows out of it. */
#ifndef NORMA_CHECK_FIX_FIX_H
#define NORMA_CHECK_FIX_FIX_H
#include "check/findings/check_run.h"
#include <math.h>
#include "core/mesh/mesh.h"

/* What may be done: the fixes asked for, less those that would harm. */
typedef struct fix_left_out {
    check_rule rule;
    char *where;
} fix_left_out;

typedef struct fix_request {
    norma_check_options options;      /* max_samples: all of them; rules: NULL */
    uint8_t wanted[CHECK_RULE_COUNT]; /* rules that were selected */
    int unsafe, by_rays;              /* by_rays: open parts are turned (N304) */
    norma_severity from; /* of unsafe fixes: findings below this severity are left as they are */
    int reads_maps;      /* normal maps are looked at before anything is fixed */
    int changes_maps;    /* and measured afterwards */
    check_judge *judges; /* as in check_known, of the document as it is; or NULL */

    uint8_t left_out[CHECK_RULE_COUNT];
    const fix_left_out *places; /* a rule at one mesh or node; sorted */
    size_t place_count;
} fix_request;
/* Frees what is there twice. Returns how many are left. */
size_t norma_fix_sort_left_out(fix_left_out *places, size_t count);
/* Whether a finding may be mended; context: the request. */
int norma_fix_may(const void *context, const norma_finding *finding);

/* What could not be done. */
#define FIX_RULE(rule) ((uint64_t)1 << (rule))
_Static_assert(CHECK_RULE_COUNT <= 64, "a bit for each rule");
typedef struct fix_note {
    char *text;
    const char *why; /* the reason in it */
    uint64_t rules;  /* whose fix it is about */
} fix_note;

/* One step: what is to be done to each mesh, then to the whole document. (fix_plan.c) */
typedef struct fix_plan {
    norma_mesh_edit *edits;
    size_t mesh_count;
    uint8_t *recentred; /* marks of meshes, or NULL */
    uint8_t *greens;    /* the same: green channels of their normal maps are inverted */
    uint8_t *tangents;  /* the same: broken and missing tangents are computed */
    uint8_t *smoothed;  /* the same: normals are computed with a crease */
    int replaces, computes, morphs, bakes;
    int breaks; /* OBJ: normals that are none are computed, for each corner, as deviation says */
    norma_deviation deviation;
    uint8_t asked[CHECK_RULE_COUNT]; /* rules whose fixes these are */
    size_t by_rays, undecided;       /* as in norma_fix_summary */
    double least_confidence;
    fix_note *notes;
    size_t note_count;
} fix_plan;
/* found: all that the rules find in the document, every element. After an error there is nothing to
 * free. */
norma_document_result norma_fix_make_plan(norma_document *document, const fix_request *request,
    const norma_findings *found, fix_plan *plan, norma_document_error *error);
int norma_fix_plan_is_empty(const fix_plan *plan);
norma_document_result norma_fix_apply(norma_document *document, const fix_plan *plan,
    uint32_t threads, int *changed, norma_document_error *error);
/* why: a constant, and a part of text. Without memory it is lost. */
void norma_fix_note(fix_plan *plan, uint64_t rules, const char *text, const char *why);
void norma_fix_plan_free(fix_plan *plan);

/* What is known of a mesh by those that belong to it: blocks of its own. */
typedef struct fix_shared {
    uint8_t *turned; /* of each face: it is reversed with a whole body; NULL: none */
    uint8_t *sides;  /* of each face, as core_side_judge has it; NULL: not asked for */
    float *smooth;   /* of each vertex at a seam of several primitives its normal, else NaN; NULL:
                        there are none */
} fix_shared;

typedef struct fix_mesh {
    norma_document *document;
    fix_plan *plan;
    size_t index; /* of the mesh in the document */
    norma_mesh_info info;
    norma_mesh_data data;
    norma_mesh_attributes attributes;
    core_mesh mesh; /* corners as they were read */
    uint32_t threads;
    const norma_finding **findings; /* those that may be mended here */
    size_t finding_count;
    norma_mesh_edit *edit;        /* its arrays are the plan's */
    fix_shared shared;            /* not its own */
    const norma_deviation *known; /* of the stored normals as they are; NULL: not known */
    /* Made when first needed. */
    uint32_t *corners; /* positions of the corners as they will be run along: reversed where the
                          edit says so */
    int knows_deviation;
    norma_deviation deviation; /* of the stored normals; of N206, once they are turned back */
    float *surface; /* normals of the corners by that weight and crease, along the corners above */
    float *face_normals; /* three of each face, along the corners above */
} fix_mesh;

/* Marks elements that the findings of a rule name: vertex, face or normal, whichever number is
 * asked for. 1: there are any; 0: none; -1: out of memory. *marks is made where it is NULL, with
 * count bytes. */
typedef enum fix_element { MEND_VERTEX, MEND_FACE, MEND_NORMAL } fix_element;
int norma_fix_mark(
    const fix_mesh *m, check_rule rule, fix_element element, size_t count, uint8_t **marks);
int norma_fix_is_rule(const norma_finding *finding, check_rule rule);
int norma_fix_has(const fix_mesh *m, check_rule rule);
int norma_fix_has_edit(const norma_mesh_edit *edit);

norma_result norma_fix_surface(fix_mesh *m); /* deviation, surface */
norma_result norma_fix_face_normals(fix_mesh *m);
norma_mesh norma_fix_mesh_now(const fix_mesh *m); /* the mesh with corners as they will be */
size_t norma_fix_normal_of(const fix_mesh *m, size_t face,
    size_t corner); /* number of its stored normal; SIZE_MAX: none */
size_t norma_fix_normal_count(const fix_mesh *m);
/* A normal as it will be: the edit's where it is set, else the stored one. */
void norma_fix_normal(const fix_mesh *m, size_t number, double normal[3]);
int norma_fix_set_normal(fix_mesh *m, size_t number,
    const double
        normal[3]); /* made unit; 0: out of memory. What is no direction is left as it is */

/* A plan that is made; and the group of meshes that it looks at: the primitives of one glTF mesh,
 * or the one mesh of another file, side by side. Zero but for the document and error. */
typedef struct fix_maker {
    norma_document *document;
    norma_document_error *error;
    const fix_request *request;
    const norma_findings *findings;
    check_places mended, known; /* findings that may be mended; all */
    fix_plan *plan;
    fix_shared *shared; /* of each mesh of the document */

    size_t next;     /* mesh, in the document, that the group ends before */
    size_t *indices; /* of those of the group that were read, in the document */
    const char **wheres;
    core_mesh *meshes;
    size_t count, face_count;
    norma_mesh_info first_info;
    norma_mesh_data first_data;
    check_judge *judge; /* of all of them: made when first asked for */
} fix_maker;
/* The meshes from m->next on that belong together. */
norma_document_result norma_fix_next_group(fix_maker *m);
void norma_fix_close_groups(fix_maker *m);

/* fix_mesh.c: which faces of the group are reversed with a whole body (N302, N304). */
norma_result norma_fix_turn(fix_maker *m);
/* fix_normals.c: N501 between primitives. */
norma_result norma_fix_seams(fix_maker *m);

/* fix_mesh.c: where normals and winding disagree. Which faces are turned, for a group; then for
 * each mesh, which are reversed (N201, N301, and N302 and N304 by m->turned), and which normals. */
norma_document_result norma_fix_ask_sides(fix_maker *m);
norma_result norma_fix_windings(fix_mesh *m);
norma_result norma_fix_turn_normals(fix_mesh *m);

norma_result norma_fix_faces(fix_mesh *m);     /* fix_elements.c: N305, N401 */
norma_result norma_fix_polygons(fix_mesh *m);  /* fix_elements.c: N404, N405 */
norma_result norma_fix_positions(fix_mesh *m); /* fix_elements.c: N503 */
norma_result norma_fix_normals(
    fix_mesh *m); /* fix_normals.c: N101 to N103, N201 (by fix_mesh.c) to N203, N205, N206, N501 */
norma_result norma_fix_vertices(
    fix_mesh *m); /* fix_elements.c: N403, N502; last, and only where nothing else is edited */
norma_result norma_fix_tangents(fix_mesh *m); /* fix_normals.c: N801 to N805 */

/* ---- edges by the exact positions of their ends, and the parts that faces joined by them
 * make. */

typedef struct fix_edge {
    double a[3], b[3];   /* its ends, the lesser first */
    uint32_t face, mesh; /* whose it is: the caller's numbers */
    int way;             /* from a to b */
} fix_edge;

/* By x, then y, then z: below, equal to or above 0. */
int norma_fix_compare_points(const double a[3], const double b[3]);
/* Of fix_edge, for qsort: by their ends, then by mesh. */
int norma_fix_compare_edges(const void *a, const void *b);
/* A face's edges between finite positions that differ, numbered as given. edges: room for one for
 * each of its corners. Returns how many. */
size_t norma_fix_face_edges(const core_mesh *mesh, size_t face, uint32_t face_number,
    uint32_t mesh_number, fix_edge *edges);

/* ---- what fixes would make of a document, found out on a copy of it, and measured. */

enum { FIX_MOST_STEPS = 8 };

/* Edges or faces by the positions of their corners. */
typedef struct fix_shape {
    size_t begin, count; /* of its points */
    size_t mesh;         /* the first one of its group, or its own */
} fix_shape;

typedef struct fix_key {
    double key;
    size_t shape;
} fix_key;

typedef struct fix_shapes {
    fix_shape *each;
    double (*points)[3];
    fix_key *keys; /* of the points, ascending */
    size_t count, room, point_count, point_room;
    int is_cut; /* there are more, which were not noted */
} fix_shapes;

typedef struct fix_measure { /* of a document, by all rules */
    norma_findings *findings;
    int has_shape;        /* the following is known */
    size_t loose;         /* edges along which faces do not run as often one way as the other */
    size_t surplus;       /* faces at edges, beyond the second */
    double area, opposed; /* twice, of all faces; of those with normals on their other side */
    fix_shapes crowded;   /* edges of more than two faces */
    fix_shapes behind;    /* faces with normals on their other side, but slivers */
    double size;          /* diagonal of the largest group */
    int is_elsewhere;     /* positions have moved as a whole: they cannot be compared */
} fix_measure;
/* Whether it matters to a fix what the rule finds. */
int norma_fix_is_weighed(const fix_request *request, check_rule rule);
/* Every element that such rules find, to be freed by the caller. maps: those that look into images
 * as well. known: NULL, or what was found in the document that this is a changed copy of. */
norma_document_result norma_fix_find(norma_document *document, const fix_request *request, int maps,
    const check_known *known, norma_findings **findings, norma_document_error *error);
norma_document_result norma_fix_measure_shape(norma_document *document, const fix_request *request,
    fix_measure *measure, norma_document_error *error);
void norma_fix_measure_free(fix_measure *measure);

/* Rules that report more than before at warning or above, or graver; 0: there are none. worse: room
 * for a mark of each rule. What one rule gains is no excuse for what another loses. */
int norma_fix_find_worse(const fix_measure *before, const fix_measure *after, uint8_t *worse);
const char *norma_fix_worse_shape(
    const fix_measure *before, const fix_measure *after); /* NULL: it is no worse */

typedef struct fix_trial {
    fix_plan plans[FIX_MOST_STEPS]; /* of each step, until nothing more is to be done */
    size_t count;
    fix_measure after;
    char said[CHECK_MESSAGE]; /* by the format: what it could not do; "": nothing */
} fix_trial;
/* known: the document as it is, and what norma_fix_find found there. first: the plan for it; it
 * becomes the trial's. */
norma_document_result norma_fix_try(const check_known *known, const fix_request *request,
    fix_plan *first, fix_trial *trial, norma_document_error *error);
void norma_fix_trial_free(fix_trial *trial);
#endif
