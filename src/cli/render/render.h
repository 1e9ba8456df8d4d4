/* render.h: what the files of norma render share. */
#ifndef NORMA_CLI_RENDER_RENDER_H
#define NORMA_CLI_RENDER_RENDER_H
#include "cli/files/files.h"
#include "cli/options/options.h"
#include "render/render.h"

/* ---- settings */

enum { RENDER_MOST_WORDS = RENDER_MOST_PANELS, RENDER_MOST_RULES = 256 };

typedef struct render_variant { /* how normals come about; those of one scene may be drawn several
                                   ways */
    int compute;                /* although there are stored ones */
    int crease_given;
    double crease_rad;
    norma_weight weight;
} render_variant;

typedef struct render_settings {
    cli_files files;
    cli_matrix matrix;
    cli_common common;
    render_look look;
    enum render_shading shading;
    enum render_show show;
    enum render_space space;
    unsigned lines;    /* asked for by --show */
    unsigned hedgehog; /* which lines a hedgehog has, by --lines; 0: vertices and faces */
    int compare;       /* 1: plain M and the normal matrix; 2: what compare_list says */
    const char *compare_list;
    double azimuth_deg, elevation_deg;
    render_variant normals; /* compute: --normals computed; stored ones are not looked at */
    int clay; /* materials are left out; -1: where nothing else is looked for in the picture */
    int up_given;
    enum render_up up;
    int has_select; /* findings of some rules only */
    uint8_t select[RENDER_MOST_RULES];
    int software;
    int light_given;
    unsigned given; /* of enum render_given: options that may turn out to have no effect */
    const char *labels[RENDER_MOST_WORDS];
    size_t label_count;
} render_settings;
enum render_given {
    RENDER_GIVEN_SHADING = 1,
    RENDER_GIVEN_PHONG = 2,
    RENDER_GIVEN_WEIGHT = 4,
    RENDER_GIVEN_LENGTH = 8,
    RENDER_GIVEN_WIDTH = 16,
    RENDER_GIVEN_MOST = 32
};
extern const cli_option render_options[];
extern const size_t render_option_count;
void render_settings_default(render_settings *settings);
/* What contradicts itself: CLI_USAGE, said already. */
int render_settings_check(const cli_subcommand *command, render_settings *settings);
/* Whether no picture that is to be written is a source, as far as it is known. A status. */
int render_guard_outputs(const render_settings *settings);

/* ---- a document as a scene */

typedef struct render_scene_file {
    norma_document *document;
    void *memory;
    const char *input;
    render_variant variants[RENDER_MOST_PANELS];
    render_scene scenes[RENDER_MOST_PANELS]; /* one for each variant */
    size_t variant_count;
    size_t *document_meshes; /* of each surface of any scene: its number in the document */
    char found[200];         /* --show findings: the rules, in words */
    size_t found_counts[4], found_nowhere; /* by severity; those without a place to draw */
    size_t not_shown;                      /* draws of nodes outside the file's scene */
    size_t with_tangents, with_texcoords;  /* surfaces that store tangents; that have coordinates */
    struct render_file_image *images;      /* of materials, as pictures */
    size_t images_left_out;
    char left_out_names[120]; /* of those images */
    const char *notes[32];    /* for the summary */
    size_t note_count;
    enum render_up up;
    int up_guessed;
    void **owned; /* arrays that the scenes point to */
    size_t owned_count, owned_room;
} render_scene_file;

norma_document_result render_file_open(const render_settings *settings, const char *input,
    render_scene_file *file, norma_document_error *error);
/* The scene with normals of this variant; made when it is first asked for. NULL: failed, and error
 * says why. together: normals are computed for errors as well. */
const render_scene *render_file_scene(const render_settings *settings, render_scene_file *file,
    const render_variant *variant, norma_document_error *error);
/* Adds a note to the summary; what does not fit in memory or in the list is left out. */
CLI_FORMAT(2, 3) void render_file_note(render_scene_file *file, const char *format, ...);
void render_file_close(render_scene_file *file);

extern const uint32_t render_finding_colours[4]; /* by severity */
const char *render_up_name(enum render_up up);
enum render_up render_find_up(
    const norma_document *document, const render_surface *surfaces, size_t count);
/* Another name at the end of a list; of one that is full, "..." */
void render_add_name(char *list, size_t room, const char *name);

/* ---- panels */

typedef struct render_plan { /* of one picture */
    render_panel panels[RENDER_MOST_PANELS];
    size_t count;
    char above[RENDER_MOST_PANELS][160], below[RENDER_MOST_PANELS][160], footer[200];
    char left_out[560], keys[4][40]; /* keys: of findings, by severity */
    const render_scene_file *file;
    size_t unstored; /* --show error: surfaces with nothing to compare */
    const render_settings *settings;
    int difference; /* largest between panels of shadings, of 255; -1: none */
} render_plan;

/* Adds the panels of the file: one, or what --compare sets side by side. A status; said already. */
int render_plan_add(render_plan *plan, render_scene_file *file, norma_document_error *error);
/* The words under a picture that are known before it is drawn. */
void render_plan_legend(render_plan *plan, render_sheet *sheet);
/* A render_tell: user is the plan. */
void render_plan_tell(void *user, render_sheet *sheet, const render_picture *picture);
/* The end of a message, behind the limit: Mesa's renderer alone was seen to take 70 to 100 MB. */
#define RENDER_DRIVER_NEEDS "; a renderer needs at least 128M"

/* ---- what a renderer says */

/* Starts one. A status; reported already, as all of these are. */
int render_start(int software, render_device **device);
int render_fail_drawing(const char *input, const render_error *error);

/* ---- what norma compare found */

struct compared_pair;
/* OTHER from two sides, coloured by how far its normals are off from BASE's, with dots, as a PNG
 * to be freed. A status. */
int render_compared(
    const struct compared_pair *pair, const render_dot *dots, size_t dot_count, render_png *png);

#endif
