/* render.h: pictures of meshes without a display. Plain arrays in, a picture in memory out; the
 * tool fills the arrays from a document and writes the file.
 *
 * A sheet is a row of panels of one size. Each panel draws a scene its own way; all have one
 * scale. The way of a vertex is the one of the textbooks, local, world, view, clip, viewport:
 * parts.h. Below this only the core. */
#ifndef NORMA_RENDER_H
#define NORMA_RENDER_H
#include <norma/norma.h>
#include <stddef.h>
#include <stdint.h>

enum render_result {
    RENDER_OK = 0,
    RENDER_ERROR_ARGUMENT,
    RENDER_ERROR_DEVICE,
    RENDER_ERROR_MEMORY
};
typedef struct render_error {
    enum render_result result;
    char message[400]; /* one line, without the name of a file */
} render_error;

/* ---- what is drawn */

enum render_normals {
    RENDER_NORMALS_NONE = 0,
    RENDER_NORMALS_PER_VERTEX,
    RENDER_NORMALS_PER_CORNER,
    RENDER_NORMALS_PER_FACET
};

typedef struct render_dot {
    double position[3];  /* in the mesh's space */
    uint32_t colour;     /* 0xRRGGBB */
    size_t vertex, face; /* whose position, or middle, it is; SIZE_MAX: of none */
} render_dot;

typedef struct render_picture {
    size_t width, height;
    uint8_t *pixels; /* RGBA, encoded as sRGB, alpha not multiplied in; row by row from the top */
} render_picture;

typedef struct render_texture {    /* an image on a surface */
    const render_picture *picture; /* NULL: none */
    const float *texcoords;        /* two for each position: 0, 0 is the image's upper left */
    int wrap_s, wrap_t, mag_filter, min_filter; /* as in OpenGL; 0: repeat, linear with levels */
} render_texture;

typedef struct render_surface { /* one mesh; the arrays stay the caller's, and stay as they are
                                   until the sheet is drawn */
    norma_mesh mesh;
    const struct render_surface *stored_surface; /* the same as it is stored, before morph targets
                                                    and skins moved it: errors are measured there.
                                                    NULL: this one */
    enum render_normals stored;
    norma_vec3_view normals; /* the stored ones, any length */
    const uint32_t
        *corner_normals; /* per corner: the number of each corner's normal, UINT32_MAX for none */
    double crease_rad; /* of the normals that are computed: those that are missing, and the error's;
                          negative: flat */
    norma_weight weight;
    int replace_zeros;     /* stored per corner or facet: those of no length are computed */
    const float *expected; /* three for each corner: the computed normals, where this mesh is a part
                              of a larger body (render_expect); NULL: of this mesh alone */
    const float *colours;  /* four for each position, linear; NULL: none */
    const uint32_t
        *face_marks; /* of each face, and of each corner: 0 none, else 0xRRGGBB; NULL: none */
    const uint32_t *corner_marks;
    const struct render_dot
        *dots; /* drawn with the marks, as large on the picture wherever they are */
    size_t dot_count;
    float base_colour[3];            /* linear */
    render_texture mask, normal_map; /* looked at in lit pictures */
    float alpha_cutoff;              /* what has less in the mask is not drawn; 0: all is drawn */
    float normal_strength;
    const float *tangents; /* x, y, z, sign for each position, v counted downwards; NULL: as
                              MikkTSpace makes them. Of the normal map */
    int two_sided;         /* 0: faces seen from behind are not drawn */
} render_surface;

typedef struct render_draw { /* a surface at its place */
    size_t surface;
    double world[16];
} render_draw;

typedef struct render_scene {
    const render_surface *surfaces;
    size_t surface_count;
    const render_draw *draws;
    size_t draw_count;
} render_scene;

/* The normals that surfaces of one body have together, so that an edge where two of them meet is no
 * border: expected of each is set to its part of *normals, which is the caller's to free. Weight
 * and crease are the first surface's. */
enum render_result render_expect(
    render_surface *surfaces, size_t count, float **normals, render_error *error);

/* ---- how it is drawn */

enum render_shading { RENDER_FLAT = 0, RENDER_GOURAUD, RENDER_PHONG };
enum render_show {
    RENDER_SHOW_LIT = 0,
    RENDER_SHOW_NORMALS,
    RENDER_SHOW_WINDING,
    RENDER_SHOW_ERROR,
    RENDER_SHOW_MARKS,
    RENDER_SHOW_MATCAP,  /* as a studio's lights reflect in it, whichever way it turns */
    RENDER_SHOW_ZEBRA,   /* stripes of light, mirrored: a crease parts them, a seam bends them */
    RENDER_SHOW_TANGENTS /* as colours, 0.5 + 0.5 t; darker where the sign is -1 */
};
enum render_up {
    RENDER_UP_Y = 0,
    RENDER_UP_Z,
    RENDER_UP_X,
    RENDER_UP_MINUS_Y,
    RENDER_UP_MINUS_Z,
    RENDER_UP_MINUS_X,
    RENDER_UPS
};
enum render_space { RENDER_SPACE_WORLD = 0, RENDER_SPACE_VIEW };
enum render_lines {
    RENDER_VERTEX_LINES = 1,
    RENDER_FACE_LINES = 2,
    RENDER_EDGE_LINES = 4,
    RENDER_WIREFRAME = 8,
    RENDER_DOTS = 16
}; /* edge lines: normals interpolated along edges */

#define RENDER_MARGIN                                                                              \
    0.06 /* of a panel's width and height, left free on each side of what is drawn, or less on two \
            of them */

enum { RENDER_MOST_LIGHTS = 4, RENDER_MOST_PANELS = 64, RENDER_MOST_SAMPLES = 4 };

typedef struct render_light {
    double azimuth_deg, elevation_deg; /* seen from the camera: 0, 0 lies behind it, 90, 0 to its
                                          right, 0, 90 above */
    double strength;
} render_light;

typedef struct render_look { /* of all panels of a sheet */
    size_t width, height;    /* of a panel */
    int samples;             /* each way in a pixel: 1 to 4 */
    uint8_t background[4];   /* encoded; alpha 0: transparent */
    uint8_t ink[3];          /* of words */
    render_light lights[RENDER_MOST_LIGHTS];
    int light_count;
    double ambient, diffuse, specular, exponent; /* Phong's model */
    double field_of_view_deg;                    /* of the shorter side; 0: orthographic */
    double line_pixels;
    double reach;         /* length of hedgehog lines, in parts of the local edge's */
    size_t most_lines;    /* of one kind on one surface; of more, evenly chosen ones are drawn */
    double error_top_deg; /* of the colour scale; 0: as most of the errors want it */
} render_look;

typedef struct render_panel {
    const render_scene *scene;
    double matrix[16]; /* acts on the world, after the nodes */
    double azimuth_deg, elevation_deg;
    enum render_up up; /* of the scene */
    enum render_shading shading;
    enum render_show show;
    enum render_space space;
    int plain;                 /* normals go through M itself: what is wrong */
    int measured;              /* fill worst_plain_rad */
    unsigned lines;            /* of enum render_lines */
    uint32_t line_colour;      /* 0xRRGGBB of vertex lines; 0: the usual */
    const char *above, *below; /* words; NULL: none. UTF-8 */
    /* What was found. */
    double
        worst_plain_rad; /* largest angle between a normal through M and through the normal matrix,
                            over the normals that are drawn; faces reversed under a mirror */
    double worst_error_rad; /* RENDER_SHOW_ERROR: stored against computed; NaN: nothing is stored */
    double most_errors_rad; /* what 99 of 100 of them do not exceed */
    int uncompared;         /* corners that have no error: grey */
    size_t triangles, lines_left_out;
    double world_to_clip[16]; /* column-major: of the world after matrix */
} render_panel;

/* ---- pictures */

void render_picture_free(render_picture *picture);
/* The largest difference of two parts of a picture, in levels of 255, over red, green and blue. */
int render_picture_difference(const render_picture *picture, size_t ax, size_t ay, size_t bx,
    size_t by, size_t width, size_t height);

/* A PNG or JPEG as a picture, for render_picture_free. */
enum render_result render_image_decode(
    const uint8_t *bytes, size_t size, render_picture *picture, render_error *error);

typedef struct render_png {
    uint8_t *bytes;
    size_t size;
} render_png;
/* As a PNG that says it is sRGB; without alpha where all of it is opaque. The caller frees bytes.
 */
enum render_result render_png_encode(
    const render_picture *picture, render_png *png, render_error *error);

/* The axis that points up in a mesh whose format does not say: of y and z, the one that a flat
 * ground lies across or a flat foot stands on; where neither shows, the usual one. */
enum render_up render_guess_up(const render_surface *surfaces, size_t count, enum render_up usual);

/* ---- drawing */

typedef struct render_device render_device;
/* software: not the GPU, even where there is one. */
enum render_result render_device_open(int software, render_device **device, render_error *error);
void render_device_close(render_device *device); /* NULL is fine */
const char *render_device_name(const render_device *device);
/* A device keeps each surface that it has drawn, by its address: to be called before the arrays of
 * a surface change or go. */
void render_device_forget(render_device *device);

typedef struct render_key { /* a colour and what it means */
    uint32_t colour;        /* 0xRRGGBB */
    const char *words;
} render_key;

enum { RENDER_MOST_KEYS = 8 };

typedef struct render_sheet {
    render_panel *panels;
    size_t panel_count;
    const char *below; /* words under all of it; NULL: none */
    render_key keys[RENDER_MOST_KEYS];
    size_t key_count;
    const char *left_out; /* what the picture does not show, under all else; NULL: nothing. Lines
                             that are left out are added */
    /* What was found. */
    double error_top_deg;
    size_t lines_left_out; /* of all panels */
    size_t panel_x[RENDER_MOST_PANELS],
        panel_y[RENDER_MOST_PANELS]; /* where each panel's picture lies */
} render_sheet;

/* Draws all panels. Words that depend on what is found are written by tell, if given, between
 * drawing and lettering: it may set above and below of panels and of the sheet. picture holds the
 * panels already then, where panel_x and panel_y say; the strips for words are there where a text
 * is not NULL beforehand. */
typedef void render_tell(void *user, render_sheet *sheet, const render_picture *picture);
enum render_result render_sheet_draw(render_device *device, const render_look *look,
    render_sheet *sheet, render_tell *tell, void *user, render_picture *picture,
    render_error *error);
#endif
