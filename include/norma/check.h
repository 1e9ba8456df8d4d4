/* check.h: what is wrong with normals, and with the surfaces they belong to: the rules of norma
 * check, over documents or over arrays in memory, and their findings as plain data.
 *
 * A rule has an id that never changes (N301), a name (inconsistent-winding) and a severity that
 * hangs on what a surface is for. A finding tells one rule's verdict on one place, with a count,
 * the worst of it and a few samples. Calls are pure functions of what they are given: any number
 * may run at once, on data that nobody changes; the findings are the same for any number of
 * threads. Zero-initialised option structs mean the documented defaults. */
#ifndef NORMA_CHECK_H
#define NORMA_CHECK_H
#include <norma/document.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef enum norma_severity {
    NORMA_SEVERITY_NONE = 0,
    NORMA_SEVERITY_INFO,
    NORMA_SEVERITY_WARNING,
    NORMA_SEVERITY_ERROR
} norma_severity;
typedef enum norma_fix {
    NORMA_FIX_NONE = 0,
    NORMA_FIX_SAFE,
    NORMA_FIX_UNSAFE /* may change what was meant */
} norma_fix;
typedef enum norma_check_profile {
    NORMA_CHECK_PROFILE_AUTO = 0, /* print for STL, render for all else */
    NORMA_CHECK_PROFILE_RENDER,
    NORMA_CHECK_PROFILE_PRINT
} norma_check_profile;

/* ---- rules */

typedef struct norma_rule {
    const char *id, *name;        /* "N301", "inconsistent-winding" */
    norma_severity render, print; /* the gravest that it takes in each profile */
    norma_fix fix;
    const char *fix_verb; /* "reorient"; "" where there is no fix */
    const char *what, *why,
        *how; /* what is measured, why it matters, what to do: sentences for a reader */
    const char *validator; /* what the glTF validator has of it: "yes", "no", "partly", ... */
} norma_rule;

/* All rules, by id; the library's own, never freed. count: how many there are. */
NORMA_API const norma_rule *norma_rules(size_t *count);
/* Sets mask[i] to 1 for each rule i of norma_rules that a list names, by ids, beginnings of ids
 * ("N3") or names, with commas between; spaces and case do not matter. Other bytes stay as they
 * are. NORMA_ERROR_ARGUMENT for a word that names no rule: it is in unknown (which may be NULL),
 * cut to fit, and mask is as it was. */
NORMA_API norma_result norma_rules_select(const char *list, uint8_t *mask, char unknown[64]);

/* ---- findings */

typedef struct norma_sample { /* a place; numbers are those of the file, from 0; SIZE_MAX: does not
                                 apply */
    size_t vertex, face;
    size_t normal; /* of the vn in OBJ */
    int has_position;
    double position[3]; /* of the vertex, else the middle of the face; in the mesh's own space */
} norma_sample;

enum { NORMA_DEVIATION_BINS = 18 };

typedef struct norma_deviation { /* which weight and crease explain stored normals best, and how
                                    well */
    norma_shading shading;       /* crease, smooth or flat */
    norma_weight weight;         /* not with flat */
    double crease_angle_rad;     /* with crease; else NaN */
    size_t corners;              /* compared: those that have both normals */
    double mean_rad, p50_rad, p99_rad, max_rad;
    size_t histogram[NORMA_DEVIATION_BINS]; /* of those corners, by angle: bin i is below
                                               norma_deviation_bound_rad(i), and not below that of i
                                               - 1 */
} norma_deviation;

typedef struct norma_finding {
    const norma_rule *rule;
    norma_severity severity;
    const char *where; /* JSON pointer of primitive, node or skin; "" for a whole OBJ, PLY or STL */
    const char *label; /* as a person says it: mesh 0 primitive 0 "chair", node 4 "leg"; "" for a
                          whole OBJ, PLY or STL */
    size_t count;
    double worst_value;          /* NaN: there is none */
    const char *unit;            /* of worst_value: "deg", "length", "ratio", ...; "" */
    norma_sample worst;          /* all SIZE_MAX: no place */
    const norma_sample *samples; /* the first in the file's order */
    size_t sample_count;         /* at most options.max_samples */
    norma_fix fix;
    const char *message;              /* one line: what, how bad, why it matters */
    const norma_deviation *deviation; /* of N204; else NULL */
} norma_finding;

typedef struct norma_findings norma_findings;

NORMA_API size_t norma_findings_count(const norma_findings *findings);
/* By place, in the order of the file; at one place by rule, the gravest first. Owned by findings.
 * NULL for an index that is not there. */
NORMA_API const norma_finding *norma_findings_get(const norma_findings *findings, size_t index);
NORMA_API norma_check_profile norma_findings_profile(
    const norma_findings *findings); /* as it was judged: render or print */
NORMA_API int norma_findings_partly(
    const norma_findings *findings); /* nonzero: a part was not checked (N002, told of even where
                                        that rule was not asked for) */
NORMA_API void norma_findings_free(norma_findings *findings); /* NULL is fine */

/* ---- checking */

typedef struct norma_check_options {
    size_t struct_size; /* sizeof of the caller's header; 0: this first version */
    norma_check_profile profile;
    int strict;           /* nonzero: lengths of normals that no encoding rounds within 1e-4 */
    size_t max_samples;   /* of a finding; 0: ten */
    const uint8_t *rules; /* NULL: all; else a byte for each of norma_rules, 0: is not looked at */
    uint32_t threads;     /* as in norma_options */
    norma_progress *progress; /* by the calling thread; nonzero cancels */
    void *progress_user;
    int open_by_rays; /* nonzero: norma_fix_document, where it may change what was meant, turns
                         open components (N304) as a majority of rays has it */
} norma_check_options;

/* A surface in memory: what a document would tell of one primitive. What there is not is zero (but
 * attributes.material SIZE_MAX). info needs vertices, faces and normals (per vertex, corner, facet)
 * and says how they are encoded; where and label of findings come from info.where, info.name,
 * info.mesh, info.primitive. */
typedef struct norma_check_mesh {
    norma_mesh_info info;
    norma_mesh_data data;
    norma_mesh_attributes attributes;
    norma_material_info material; /* of the surface; all zero and no names: opaque, of one side */
    const norma_morph_data *morphs;
    size_t morph_count;
} norma_check_mesh;

typedef struct norma_check_scene {
    const norma_check_mesh *meshes;
    size_t mesh_count;
    const norma_node_info *nodes; /* they name meshes by info.mesh */
    size_t node_count;
    const norma_skin_info *skins;
    size_t skin_count;
    norma_file_format format; /* decides what is counted and which profile is meant: facets in STL,
                                 numbers of vn in OBJ; unknown: as glTF */
} norma_check_scene;

/* The rules over arrays. *findings is set on NORMA_OK only, to be freed by norma_findings_free.
 * NORMA_ERROR_ARGUMENT: a NULL, an option out of its range, arrays that norma_vertex_normals would
 * refuse; NORMA_ERROR_INDEX, _OVERFLOW, _MEMORY, NORMA_CANCELLED. O(n log n) and 60 bytes a
 * triangle of scratch. */
NORMA_API norma_result norma_check_scene_run(
    const norma_check_scene *scene, const norma_check_options *options, norma_findings **findings);
/* The rules over a document, opened whole and, for N106 to have something to say, leniently. What
 * its infos call not_read is told of by N002. */
NORMA_API norma_document_result norma_check_document(norma_document *document,
    const norma_check_options *options, norma_findings **findings, norma_document_error *error);
/* The finding of a file that could not be opened: N001 with what the error says. NULL: out of
 * memory. */
NORMA_API norma_findings *norma_check_unreadable(const norma_document_error *error,
    norma_file_format format, const norma_check_options *options);

/* ---- mending */

typedef struct norma_fix_summary {
    int changed; /* 0: the document would be written as it was read, byte for byte */
    int again;   /* nonzero: a glTF, which takes one change, is to be saved, opened and mended once
                    more */
    size_t by_rays, undecided; /* with open_by_rays: open components that were turned or confirmed;
                                  those on which rays could not agree, left as they were */
    double least_confidence;   /* of by_rays: (rays for it - rays against it) / 256 */
} norma_fix_summary;

/* Puts right in the document what the rules of options find and a program can: what is safe, and
 * where unsafe is nonzero also what may change what was meant (each rule's fix tells). Nothing else
 * changes. New normals come from the surface, with the weight and crease that the file's other
 * normals show; where the winding of all faces at a normal is reversed, it turns with them.
 * options: as for norma_check_document, but for max_samples and profile, which is that of the
 * rules. Errors as of norma_check_document and norma_document_edit; after one the document can only
 * be closed. The document is to be opened leniently. */
NORMA_API norma_document_result norma_fix_document(norma_document *document,
    const norma_check_options *options, int unsafe, norma_fix_summary *summary,
    norma_document_error *error);

/* Deprecated names of version 0.1. */
#define norma_mend_summary  norma_fix_summary
#define norma_mend_document norma_fix_document

/* ---- how normals were made */

/* Which weight and crease explain the normals of a surface best: those whose normals lie nearest to
 * the stored ones, by mean angle; of several that explain as well, the likeliest. Creases are tried
 * with angle weights, then weights with the best crease, then creases again; where there are very
 * many faces, on a part of them, and what is told is of all. NORMA_OK with deviation->corners 0:
 * nothing to compare (no normals, facets, none that is a direction). options may be NULL; of it
 * threads, progress and allocator are used. Errors are those of norma_corner_normals. */
NORMA_API norma_result norma_explain_normals(const norma_mesh_data *data,
    norma_normal_storage storage, const norma_options *options, norma_deviation *deviation);
/* Upper bound of a bin of the histogram: .01, .02, .05, .1, .2, .5, 1, 2, 5, 10, 15, 20, 30, 45,
 * 60, 90, 120, 180 degrees, in radians; the last one is in its bin. */
NORMA_API double norma_deviation_bound_rad(size_t bin);

#ifdef __cplusplus
}
#endif
#endif
