/* check.h: the rules of norma check. They find what is wrong with normals and with the surfaces
 * they belong to, in documents or in arrays in memory, and report findings as plain data.
 *
 * A rule has an id that never changes (N301), a name (inconsistent-winding), and a severity that
 * depends on what the surface is for. A finding is the result of one rule at one place, with a
 * count, the worst value and a few samples.
 *
 * All calls are pure functions: any number may run at once as long as their data is not changed
 * meanwhile. The findings are the same for any number of threads. A zero-initialised option struct
 * means the documented defaults. */
#ifndef NORMA_CHECK_H
#define NORMA_CHECK_H
#include <norma/document.h>
#include <norma/large.h>
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
    NORMA_FIX_UNSAFE /* may change something that was intended */
} norma_fix;

typedef enum norma_check_profile {
    NORMA_CHECK_PROFILE_AUTO = 0, /* print for STL and 3MF, render for others */
    NORMA_CHECK_PROFILE_RENDER,
    NORMA_CHECK_PROFILE_PRINT,

    /* For accepting or rejecting models that a program made: the higher severity of render and
     * print, and always errors for N203, N206, N302, N303, N305, N306 and N307. */
    NORMA_CHECK_PROFILE_GENERATED
} norma_check_profile;

/* ---- rules */

typedef struct norma_rule {
    const char *id, *name;        /* "N301", "inconsistent-winding" */
    norma_severity render, print; /* the highest severity in each profile */
    norma_fix fix;
    const char *fix_verb; /* "reorient"; "" without a fix */

    /* Sentences for a reader: what is measured, how such a fault usually arises, why it matters,
     * what to do. */
    const char *what, *cause, *why, *how;

    /* Whether the Khronos glTF validator reports it: "yes", "no", "partly" or a phrase. */
    const char *validator;
} norma_rule;

/* Returns all rules, sorted by id. The array is constant and must not be freed.
 *
 *   count   written: the number of rules */
NORMA_API const norma_rule *norma_rules(size_t *count);

/* Returns the highest severity that a rule can have in a profile.
 *
 *   rule      one of norma_rules
 *   profile   AUTO counts as RENDER */
NORMA_API norma_severity norma_rule_severity(const norma_rule *rule, norma_check_profile profile);

/* Marks the rules that a list names.
 *
 *   list      ids, beginnings of ids ("N3") or names, separated by commas; spaces and case are
 *             ignored
 *   mask      one byte for each rule, in the order of norma_rules; set to 1 if the rule is named,
 *             otherwise left as it is
 *   unknown   written on an argument error: the first word that names no rule, cut to fit; or NULL
 *
 * Errors: NORMA_ERROR_ARGUMENT for a word that names no rule; then mask is unchanged. */
NORMA_API norma_result norma_rules_select(const char *list, uint8_t *mask, char unknown[64]);

/* ---- findings */

/* A place. Numbers are those of the file, from 0; SIZE_MAX: does not apply. */
typedef struct norma_sample {
    size_t vertex, face;
    size_t normal; /* the vn of an OBJ */
    int has_position;
    double position[3]; /* of the vertex, or the middle of the face; in the mesh's own space */
} norma_sample;

enum { NORMA_DEVIATION_BINS = 18 };

/* The weight and crease that explain stored normals best, and how well they do. */
typedef struct norma_deviation {
    norma_shading shading;   /* crease, smooth or flat */
    norma_weight weight;     /* unused if flat */
    double crease_angle_rad; /* NaN unless shading is crease */
    size_t corners;          /* corners compared: those with both normals */
    double mean_rad, p50_rad, p99_rad, max_rad;

    /* Corners by angle: bin i holds those below norma_deviation_bound_rad(i), and not below the
     * bound of bin i - 1. */
    size_t histogram[NORMA_DEVIATION_BINS];
} norma_deviation;

typedef struct norma_finding {
    const norma_rule *rule;
    norma_severity severity;

    /* Both are "" for a whole OBJ, PLY or STL. */
    const char *where; /* JSON pointer of the primitive, node or skin */
    const char *label; /* a name for people: mesh 0 primitive 0 "chair", node 4 "leg" */

    size_t count;
    double worst_value;          /* NaN: none */
    const char *unit;            /* of worst_value: "deg", "length", "ratio", ...; or "" */
    norma_sample worst;          /* all SIZE_MAX: no place */
    const norma_sample *samples; /* the first ones, in the order of the file */
    size_t sample_count;         /* at most options.max_samples */
    norma_fix fix;
    const char *message;              /* one line: what is wrong, how badly, why it matters */
    const norma_deviation *deviation; /* N204 only; otherwise NULL */

    /* The same for equal meshes, in whichever file: of the positions as they are decoded, in their
     * order, and the number of corners. 0: not about one mesh of a document. */
    uint64_t mesh;
} norma_finding;

typedef struct norma_findings norma_findings;

/* Returns the number of findings. */
NORMA_API size_t norma_findings_count(const norma_findings *findings);

/* Returns one finding, or NULL if index is out of range. They are sorted by place, in the order of
 * the file; at one place the most severe comes first. The finding belongs to findings. */
NORMA_API const norma_finding *norma_findings_get(const norma_findings *findings, size_t index);

/* The program that commands to be pasted begin with. The npm package is built with another. */
#if !defined(NORMA_PROGRAM)
#define NORMA_PROGRAM "norma"
#endif

/* Writes the command that fixes a finding, to paste into a POSIX shell:
 * norma check chair.glb --fix-unsafe --select N602 -o chair.fixed.glb
 * Names are quoted if a shell needs it.
 *
 *   finding    any finding; or NULL for the command that shows the file and what is found in it:
 *              norma view chair.glb -o chair.glb.html
 *   path       the file that it is about
 *   options    further words of the command, ended by NULL; or NULL
 *   command    written, ended by a zero and cut to fit; or NULL
 *   capacity   the size of command in bytes
 *
 * Returns the length of the command without its zero, even if it did not fit; 0 if the finding has
 * no fix, or the path is "-". */
NORMA_API size_t norma_finding_command(const norma_finding *finding, const char *path,
    const char *const *options, char *command, size_t capacity);

/* Returns the profile that was applied: render, print or generated. */
NORMA_API norma_check_profile norma_findings_profile(const norma_findings *findings);

/* Returns nonzero if a part was not checked. N002 reports such parts, even if that rule was not
 * selected. */
NORMA_API int norma_findings_partly(const norma_findings *findings);

/* Frees findings. NULL is fine. */
NORMA_API void norma_findings_free(norma_findings *findings);

/* ---- checking */

typedef struct norma_check_options {
    size_t struct_size; /* sizeof(norma_check_options) of the caller; 0: the first version */
    norma_check_profile profile;
    int strict;           /* nonzero: lengths within 1e-4 of 1, not 5e-4, except 8- and 10-bit */
    size_t max_samples;   /* for each finding; 0: ten */
    const uint8_t *rules; /* a byte for each rule of norma_rules, 0 to skip it; NULL: all rules */
    uint32_t threads;     /* as in norma_options */
    norma_progress *progress; /* called by the calling thread; nonzero cancels */
    void *progress_user;

    /* Nonzero: norma_fix_document with unsafe fixes turns open parts (N304) as a majority of rays
     * suggests. */
    int open_by_rays;

    /* norma_fix_document: unsafe fixes are for findings of this severity and above;
     * NORMA_SEVERITY_NONE: for all. norma check --fix-unsafe does not touch informations unless
     * their rules are selected. */
    norma_severity fix_from;

    /* Nonzero: samples of N302 go on, behind the count faces that stand for a component each, with
     * the other faces of those components, as far as these lie in the finding's own mesh and
     * max_samples reaches: sample_count may exceed count. A picture marks whole solids by it. */
    int whole_components;
} norma_check_options;

/* A surface in memory, described as a document describes one primitive. Set members without data to
 * zero, except attributes.material, which is then SIZE_MAX. info needs vertices, faces, normals
 * (per vertex, corner or facet) and encoding. Findings take their where and label from info.where,
 * info.name, info.mesh and info.primitive. */
typedef struct norma_check_mesh {
    norma_mesh_info info;
    norma_mesh_data data;
    norma_mesh_attributes attributes;
    norma_material_info material; /* all zero without names: opaque, single-sided */
    const norma_morph_data *morphs;
    size_t morph_count;
} norma_check_mesh;

typedef struct norma_check_scene {
    const norma_check_mesh *meshes;
    size_t mesh_count;
    const norma_node_info *nodes; /* they refer to meshes by info.mesh */
    size_t node_count;
    const norma_skin_info *skins;
    size_t skin_count;

    /* Decides what is counted (facets in STL, vn in OBJ) and the default profile. Unknown: as
     * glTF. */
    norma_file_format format;
} norma_check_scene;

/* Applies the rules to arrays in memory.
 *
 *   scene      the meshes, nodes and skins
 *   options    NULL for the defaults
 *   findings   written on success; release them with norma_findings_free
 *
 * Errors: NORMA_ERROR_ARGUMENT: scene or findings is NULL, an option is out of range, or the arrays
 * are such that norma_vertex_normals would refuse them; NORMA_ERROR_INDEX, NORMA_ERROR_OVERFLOW,
 * NORMA_ERROR_MEMORY, NORMA_CANCELLED.
 * Cost: O(n log n), and 60 bytes of scratch memory per triangle. */
NORMA_API norma_result norma_check_scene_run(
    const norma_check_scene *scene, const norma_check_options *options, norma_findings **findings);

/* Applies the rules to a document.
 *
 *   document   opened whole. Open it leniently too; otherwise N106 finds nothing
 *   options    NULL for the defaults
 *   findings   written on success; release them with norma_findings_free
 *   error      written on failure; or NULL
 *
 * Parts with a not_read in their info are reported by N002. Cost: as norma_check_scene_run. */
NORMA_API norma_document_result norma_check_document(norma_document *document,
    const norma_check_options *options, norma_findings **findings, norma_document_error *error);

/* Applies the rules that need no neighbours to a binary PLY or STL that is larger than memory,
 * which is read part by part: N101 to N104, N205, N401, N402, N404, N405, N701 and N702. Their
 * findings are those of norma_check_document; only whether a facet's normal or its winding is wrong
 * (N205) is not looked at. N002 names the selected rules that were not applied.
 *
 *   path       the file
 *   large      NULL for the defaults; uses max_memory and format
 *   options    NULL for the defaults
 *   findings   written on success; release them with norma_findings_free
 *   error      written on failure; or NULL
 *
 * Errors: NORMA_DOCUMENT_ERROR_UNSUPPORTED if the file can only be read whole, and as
 * norma_document_open. Cost: two readings of the file, and two to four more if N701 finds
 * something. */
NORMA_API norma_document_result norma_check_large(const char *path,
    const norma_large_options *large, const norma_check_options *options, norma_findings **findings,
    norma_document_error *error);

/* Returns the findings for a file that could not be opened: a single N001 with the error's message.
 *
 *   error     from norma_document_open
 *   format    of the file
 *   options   as they would have been for norma_check_document
 *
 * Returns NULL if out of memory. */
NORMA_API norma_findings *norma_check_unreadable(const norma_document_error *error,
    norma_file_format format, const norma_check_options *options);

/* ---- fixing */

typedef struct norma_fix_summary {
    int changed; /* 0: the document would be written byte for byte as it was read */

    /* With open_by_rays: open parts that rays turned or confirmed, and parts that were left as they
     * are because the rays do not agree. */
    size_t by_rays, undecided;
    double least_confidence; /* of by_rays: (rays for it - rays against it) / rays */

    /* Fixes that were skipped because they would do harm. For each, a note of the document names
     * the rule that would have reported more. */
    size_t left_out;
} norma_fix_summary;

/* Fixes the findings of the selected rules that a program can fix. Nothing else in the document
 * changes.
 *
 * The fixes are tried on a copy first. A fix is skipped if some rule, selected or not, would then
 * report more elements than before at warning or above, or a higher severity, or if a closed edge
 * would become open. The other fixes are still applied.
 *
 *   document   opened leniently
 *   options    as for norma_check_document; max_samples is ignored
 *   unsafe     0: only safe fixes; nonzero: also those that may change intended things (see
 *              norma_rule.fix)
 *   summary    written; or NULL
 *   error      written on failure; or NULL
 *
 * New normals are computed from the surface, with the weight and crease that explain the other
 * normals of the file best. If all faces at a normal are reversed, the normal is reversed with
 * them. A fix may uncover faults that another fix repairs; these are fixed too. Calling it again
 * changes nothing more. Cost: that of a few checks, and memory for a copy of the file. If a fix has
 * to be skipped, a few more checks for each rule.
 * The models of a composite (norma_document_tile) are fixed each by itself.
 * Errors: those of norma_check_document and norma_document_edit. After an error the document can
 * only be closed. */
NORMA_API norma_document_result norma_fix_document(norma_document *document,
    const norma_check_options *options, int unsafe, norma_fix_summary *summary,
    norma_document_error *error);

/* Tries what findings offer: each rule's fix by itself, on a copy of the document. A finding that
 * its fix would not remove offers none from then on (its fix is NORMA_FIX_NONE, and
 * norma_finding_command returns 0), and its message ends with the reason.
 *
 *   document   what was checked; it stays as it is
 *   options    as for norma_check_document; rules and max_samples are ignored
 *   from       findings below this severity are left as they are
 *   findings   those of norma_check_document
 *   error      written on failure; or NULL
 *
 * Cost: at most about one check for each rule that offers a fix, and memory for a copy of the file:
 * what findings tell is not looked for again if they are of the same options and all rules, nor
 * what a fix cannot change. After twenty checks no more fixes are tried, and the findings say so.
 * Errors: those of norma_fix_document. */
NORMA_API norma_document_result norma_document_try_fixes(norma_document *document,
    const norma_check_options *options, norma_severity from, norma_findings *findings,
    norma_document_error *error);

/* Deprecated names of version 0.1. */
#define norma_mend_summary  norma_fix_summary
#define norma_mend_document norma_fix_document

/* ---- how normals were made */

/* Finds the weight and crease that explain the normals of a surface best: those whose normals are
 * nearest to the stored ones by mean angle. Of several that explain them equally well, the most
 * common one wins.
 *
 *   data        the surface with its normals
 *   storage     where its normals are stored
 *   options     uses threads, progress and allocator; NULL for the defaults
 *   deviation   written; corners is 0 if there is nothing to compare (no normals, facets, or no
 *               normal that is a direction)
 *
 * Tries creases with angle weights, then weights with the best crease, then creases again, on a
 * sample of the faces if there are very many. The figures returned are always of all faces.
 * Errors: those of norma_corner_normals. */
NORMA_API norma_result norma_explain_normals(const norma_mesh_data *data,
    norma_normal_storage storage, const norma_options *options, norma_deviation *deviation);

/* A way to make tangents. */
typedef enum norma_tangent_source {
    NORMA_TANGENTS_UNCOMPARED = 0,   /* there is nothing to compare */
    NORMA_TANGENTS_BY_MIKK,          /* MikkTSpace (Mikkelsen 2008) on the triangles */
    NORMA_TANGENTS_BY_MIKK_ON_QUADS, /* on quads: neighbours in the list put together again */
    NORMA_TANGENTS_BY_VERTEX_SUMS,   /* sums over the triangles at each vertex (Lengyel 2001) */
    NORMA_TANGENTS_BY_MESHOPT,       /* meshoptimizer 1.3 with its default weights */
    NORMA_TANGENTS_BY_STEADY         /* NORMA_TANGENTS_STEADY of norma.h, weighted by angle */
} norma_tangent_source;

/* Angles between stored tangents and those that a renderer would make itself. A normal map baked
 * for the stored ones errs by at most the angle at that corner. */
typedef struct norma_map_error {
    double p50_rad, p99_rad, max_rad;
} norma_map_error;

/* The way that explains stored tangents best, and how well it does. */
typedef struct norma_tangent_deviation {
    norma_tangent_source source;
    int negated;        /* nonzero: most signs are the opposite of what this way gives for the
                         * texture coordinates as stored, as glTF needs it; 0: most are the same */
    int transformed;    /* nonzero: through the KHR_texture_transform of the normal map */
    size_t signs_other; /* corners whose sign differs from that of the majority */
    size_t corners;     /* corners compared: those with both tangents */
    size_t explained;   /* corners within a tenth of a degree plus the encoding's rounding */
    double mean_rad, p50_rad, p99_rad, max_rad; /* of the angles between the two */

    /* If a renderer makes tangents in these ways: MikkTSpace on triangles, meshoptimizer, sums at
     * vertices. */
    norma_map_error under_mikk, under_meshopt, under_vertex_sums;
} norma_tangent_deviation;

/* Finds the way of making tangents that explains the stored ones best: the one with the smallest
 * mean angle between its tangents and the stored ones. Angles above 5 degrees count as 5.
 *
 *   data         the surface with its normals
 *   attributes   its tangents and texture coordinates, as norma_document_mesh_attributes returns
 *                them
 *   options      uses threads and allocator; NULL for the defaults
 *   deviation    written; corners is 0 if there is nothing to compare
 *
 * Cost: up to seven times that of norma_corner_tangents, usually three. Errors: those of
 * norma_corner_normals. */
NORMA_API norma_result norma_explain_tangents(const norma_mesh_data *data,
    const norma_mesh_attributes *attributes, const norma_options *options,
    norma_tangent_deviation *deviation);

/* Returns a name for people, "MikkTSpace on quads"; NULL for NORMA_TANGENTS_UNCOMPARED and unknown
 * ways. */
NORMA_API const char *norma_tangent_source_name(norma_tangent_source source);

/* Returns the upper bound of a bin of the histogram in radians. In degrees: .01, .02, .05, .1, .2,
 * .5, 1, 2, 5, 10, 15, 20, 30, 45, 60, 90, 120, 180 (180 itself lies in the last bin). */
NORMA_API double norma_deviation_bound_rad(size_t bin);

#ifdef __cplusplus
}
#endif
#endif
