/* render_scene.c: a file as a scene: its meshes in the world, with materials and bodies. */
#include "cli/render/render.h"
#include "cli/process/process.h"
#include <norma/check.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* ---- A file that is drawn: opened, closed, and the blocks that live as long as it. */

static norma_document_result file_fail(norma_document_error *error, norma_document_result result,
    const char *input, const char *what) {
    error->result = result;
    snprintf(error->message, sizeof error->message, "%.500s: %.400s", cli_input_name(input), what);
    return result;
}

static norma_document_result no_memory_for_scene(
    norma_document_error *error, const render_scene_file *file) {
    return file_fail(error, NORMA_DOCUMENT_ERROR_MEMORY, file->input, "out of memory");
}

static int is_gltf(const render_scene_file *file) {
    return norma_file_format_is_gltf(norma_document_format(file->document));
}

norma_document_result render_file_open(const render_settings *settings, const char *input,
    render_scene_file *file, norma_document_error *error) {
    static const norma_document_options reading = {.lenient = 1};
    *file = (render_scene_file){.input = input};
    return cli_read(&settings->files, &settings->common, input, &reading, &file->document,
        &file->memory, error);
}

static void free_scene(render_scene *scene) {
    free((void *)scene->surfaces);
    free((void *)scene->draws);
    *scene = (render_scene){0};
}

void render_file_close(render_scene_file *file) {
    for (size_t i = 0; i < file->variant_count; ++i) free_scene(&file->scenes[i]);
    for (size_t i = 0; i < file->owned_count; ++i) free(file->owned[i]);
    free(file->owned);
    free(file->document_meshes);
    norma_document_close(file->document);
    free(file->memory);
    *file = (render_scene_file){0};
}

/* Freed with the file; 0: out of memory, and the block is freed. */
static int keep_block(render_scene_file *file, void *block) {
    void **larger = cli_grow(file->owned, file->owned_count, &file->owned_room, sizeof *larger);
    if (!larger) {
        free(block);
        return 0;
    }
    file->owned = larger;
    file->owned[file->owned_count++] = block;
    return 1;
}

void render_file_note(render_scene_file *file, const char *format, ...) {
    char text[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (size_t i = 0; i < file->note_count; ++i)
        if (strcmp(file->notes[i], text) == 0) return;
    if (file->note_count == sizeof file->notes / sizeof *file->notes) return;
    char *kept = malloc(strlen(text) + 1);
    if (!kept) return;
    strcpy(kept, text);
    if (keep_block(file, kept)) file->notes[file->note_count++] = kept;
}

/* ---- Which way is up in a file. */

const char *render_up_name(enum render_up up) {
    static const char *const names[] = {"y", "z", "x", "-y", "-z", "-x"};
    return names[up];
}

/* glTF says that y points up. Where nothing shows, OBJ is taken as modellers export it, STL
 * and PLY as printers and scanners have them. */
enum render_up render_find_up(
    const norma_document *document, const render_surface *surfaces, size_t count) {
    const norma_file_format format = norma_document_format(document);
    if (norma_file_format_is_gltf(format)) return RENDER_UP_Y;
    return render_guess_up(surfaces, count, format == NORMA_FILE_OBJ ? RENDER_UP_Y : RENDER_UP_Z);
}

/* ---- names in a note */

void render_add_name(char *list, size_t room, const char *name) {
    const size_t length = strlen(list), dots = sizeof ", ...";
    if (length >= dots && strcmp(list + length - 3, "...") == 0) return;
    snprintf(list + length, room - length, "%s%s", length ? ", " : "",
        length + strlen(name) + 2 * dots < room ? name : "...");
}

/* ---- What a surface looks like: clay or the colours of its vertices, bent by its normal
 * map, cut by its mask; which of its sides are there. */

/* Linear; mid-grey, so that light and shade both show. Whatever has no material of its own, too. */
static const float clay[3] = {0.55F, 0.53F, 0.48F};

/* ---- images, each decoded once for a file */

typedef struct render_file_image {
    struct render_file_image *next;
    size_t number; /* in the file */
    render_picture picture;
} render_file_image;

/* What cannot be drawn is named in the picture, and in a note with the reason. */
static void leave_image(render_scene_file *file, const char *list, size_t number, const char *why) {
    char name[48];
    snprintf(name, sizeof name, "/%s/%zu", list, number);
    ++file->images_left_out;
    render_add_name(file->left_out_names, sizeof file->left_out_names, name);
    render_file_note(file, "%s is not drawn: %.300s", name, why);
}

/* A picture without pixels: it could not be decoded. NULL: out of memory. */
static const render_picture *picture_of(render_scene_file *file, const norma_texture_info *info) {
    for (const render_file_image *known = file->images; known; known = known->next)
        if (known->number == info->image) return &known->picture;
    render_file_image *made = calloc(1, sizeof *made);
    if (!made || !keep_block(file, made)) return NULL;
    render_error why = {.message = "it has no bytes"};
    made->number = info->image;
    if (info->bytes) render_image_decode(info->bytes, info->size, &made->picture, &why);
    if (!made->picture.pixels)
        leave_image(file, "images", info->image, info->not_read ? info->not_read : why.message);
    if (made->picture.pixels && !keep_block(file, made->picture.pixels)) return NULL;
    made->next = file->images;
    file->images = made;
    return &made->picture;
}

/* ---- texture coordinates, as they are looked up */

static norma_document_result read_texcoords(render_scene_file *file, size_t mesh,
    const norma_texture_info *info, render_texture *map, norma_document_error *error) {
    const float *texcoords = NULL;
    size_t count = 0;
    norma_document_result result =
        norma_document_texcoords(file->document, mesh, info->texcoord, &texcoords, &count, error);
    if (result || !texcoords) return result;
    float *placed = malloc((2 * count + 1) * sizeof *placed);
    if (!placed || !keep_block(file, placed)) return no_memory_for_scene(error, file);
    norma_texture_place(info, texcoords, count, 2, placed);
    map->texcoords = placed;
    return NORMA_DOCUMENT_OK;
}

typedef struct surface_of { /* numbers in the document */
    size_t mesh, material;
} surface_of;

/* Without coordinates, or with an image that cannot be read, the surface is drawn without it. */
static norma_document_result set_map(render_scene_file *file, const surface_of *of,
    const norma_texture_info *info, render_texture *map, norma_document_error *error) {
    if (!info->there) return NORMA_DOCUMENT_OK;
    *map = (render_texture){.wrap_s = info->wrap_s,
        .wrap_t = info->wrap_t,
        .mag_filter = info->mag_filter,
        .min_filter = info->min_filter};
    norma_document_result result = read_texcoords(file, of->mesh, info, map, error);
    if (result || !map->texcoords) return result;
    if (info->image == SIZE_MAX) {
        leave_image(
            file, "materials", of->material, info->not_read ? info->not_read : "it names no image");
        return NORMA_DOCUMENT_OK;
    }
    const render_picture *picture = picture_of(file, info);
    if (!picture) return no_memory_for_scene(error, file);
    if (picture->pixels) map->picture = picture;
    return NORMA_DOCUMENT_OK;
}

/* ---- materials */

/* Whether some texels have half of the light and more, and some less. */
static int has_outline(const render_picture *picture) {
    size_t solid = 0;
    const size_t texels = picture->width * picture->height;
    for (size_t i = 0; i < texels; ++i) solid += picture->pixels[4 * i + 3] >= 128;
    return solid > 0 && solid < texels;
}

/* What cuts an outline: the image of a mask, and what blends, at half, where its image has one
 * (leaves, hair). All else that lets light through is clay. */
static norma_document_result set_mask(render_scene_file *file, const surface_of *of,
    const norma_material_maps *maps, render_surface *surface, norma_document_error *error) {
    norma_material_info info;
    norma_document_result result = set_map(file, of, &maps->base_color, &surface->mask, error);
    if (result || norma_document_material_info(file->document, of->material, &info)) return result;
    const float alpha = info.base_color[3], cutoff = maps->alpha_cutoff;
    if (maps->alpha_mode == NORMA_ALPHA_BLEND)
        surface->alpha_cutoff =
            surface->mask.picture && has_outline(surface->mask.picture) ? 0.5F : 0;
    else if (cutoff > 0)
        surface->alpha_cutoff = cutoff <= alpha ? cutoff / alpha : 2; /* of the image */
    return NORMA_DOCUMENT_OK;
}

static norma_document_result set_maps(const render_settings *settings, render_scene_file *file,
    size_t mesh, size_t material, render_surface *surface, norma_document_error *error) {
    norma_material_maps maps;
    norma_document_result result =
        norma_document_material_maps(file->document, material, &maps, error);
    if (result) return result;
    if (settings->show == RENDER_SHOW_TANGENTS)
        return maps.normal.there
                   ? read_texcoords(file, mesh, &maps.normal, &surface->normal_map, error)
                   : NORMA_DOCUMENT_OK;
    if (settings->show != RENDER_SHOW_LIT || settings->clay) return NORMA_DOCUMENT_OK;
    surface->normal_strength = maps.normal.strength;
    const surface_of of = {mesh, material};
    if (maps.alpha_mode != NORMA_ALPHA_OPAQUE) result = set_mask(file, &of, &maps, surface, error);
    return result ? result : set_map(file, &of, &maps.normal, &surface->normal_map, error);
}

static void set_colours(const norma_mesh_attributes *attributes, render_surface *surface) {
    surface->colours = attributes->colors;
    if (attributes->colors)
        for (int k = 0; k < 3; ++k) surface->base_colour[k] = 1;
}

/* Its colours, images and sides; mesh: its number in the document. */
static norma_document_result render_file_set_material(const render_settings *settings,
    render_scene_file *file, size_t mesh, const norma_mesh_attributes *attributes,
    render_surface *surface, norma_document_error *error) {
    static const norma_texture_info plain = {.scale = {1, 1}};
    norma_material_info material;
    const int gltf = is_gltf(file);
    const int known =
        gltf && attributes->material != SIZE_MAX &&
        !norma_document_material_info(file->document, attributes->material, &material);
    memcpy(surface->base_colour, clay, sizeof clay);
    surface->two_sided = gltf ? known && material.double_sided : 1; /* only glTF has sides */
    if (surface->stored == RENDER_NORMALS_PER_VERTEX &&
        attributes->tangent_count >= surface->mesh.positions.count)
        surface->tangents = attributes->tangents;
    if (!settings->clay) set_colours(attributes, surface);
    norma_document_result result =
        known ? set_maps(settings, file, mesh, attributes->material, surface, error)
              : NORMA_DOCUMENT_OK;
    if (!result && settings->show == RENDER_SHOW_TANGENTS && !surface->normal_map.texcoords)
        result = read_texcoords(file, mesh, &plain, &surface->normal_map, error);
    file->with_tangents += surface->tangents != NULL;
    file->with_texcoords += surface->normal_map.texcoords != NULL;
    return result;
}

/* ---- GlTF: the primitives of a mesh are one body, whose normals are computed
 * together.
 */

static int render_join_primitives(
    render_scene_file *file, render_surface *first, size_t count, norma_document_error *error) {
    enum { MOST_JOINED = 64 };
    float *normals;
    render_error trouble;
    if (count < 2 || count > MOST_JOINED) return 1;
    if (render_expect(first, count, &normals, &trouble)) {
        file_fail(error, NORMA_DOCUMENT_ERROR_MEMORY, file->input, trouble.message);
        return 0;
    }
    if (keep_block(file, normals)) return 1;
    no_memory_for_scene(error, file);
    return 0;
}

/* Normals are computed for the surfaces of one mesh: all that are not stored and not flat, and all
 * that errors are measured against. */
static int render_join_needed(
    const render_settings *settings, const render_surface *surfaces, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (settings->show == RENDER_SHOW_ERROR ||
            (surfaces[i].stored == RENDER_NORMALS_NONE && surfaces[i].crease_rad >= 0))
            return 1;
    return 0;
}

/* ---- What norma check names, coloured: faces, the corners of vertices, and a dot at
 * each place, by the gravest that was found there. */

const uint32_t render_finding_colours[4] = {[NORMA_SEVERITY_INFO] = 0x2F7FC4,
    [NORMA_SEVERITY_WARNING] = 0xE39A1E,
    [NORMA_SEVERITY_ERROR] = 0xD12B2B};
static const uint32_t *const colours = render_finding_colours;
enum { MOST_SAMPLES = 20000 }; /* of one finding */

/* One surface's marks while they are made: severities first, so that the gravest stays. */
typedef struct marks {
    const render_surface *surface;
    size_t faces;
    uint8_t *of_faces, *of_vertices, *of_normals;
    render_dot *dots;
    size_t dot_count, dot_room;
} marks;

static int begin_marks(marks *m, const render_surface *surface) {
    const norma_mesh *mesh = &surface->mesh;
    *m = (marks){
        .surface = surface, .faces = mesh->face_starts ? mesh->face_count : mesh->corner_count / 3};
    m->of_faces = calloc(m->faces + 1, 1);
    m->of_vertices = calloc(mesh->positions.count + 1, 1);
    m->of_normals = calloc(surface->normals.count + 1, 1);
    return m->of_faces && m->of_vertices && m->of_normals;
}

static void end_marks(marks *m) {
    free(m->of_faces);
    free(m->of_vertices);
    free(m->of_normals);
    free(m->dots);
}

static void raise(uint8_t *severity, norma_severity to) {
    *severity = *severity < to ? (uint8_t)to : *severity;
}

static int add_dot(marks *m, const norma_sample *sample, norma_severity severity) {
    if (!sample->has_position) return 1;
    render_dot *larger = cli_grow(m->dots, m->dot_count, &m->dot_room, sizeof *larger);
    if (!larger) return 0;
    m->dots = larger;
    memcpy(m->dots[m->dot_count].position, sample->position, sizeof sample->position);
    m->dots[m->dot_count].vertex = sample->vertex;
    m->dots[m->dot_count].face = sample->face;
    m->dots[m->dot_count++].colour = colours[severity];
    return 1;
}

static void mark_sample(marks *m, const norma_sample *sample, norma_severity severity) {
    if (sample->face < m->faces) raise(&m->of_faces[sample->face], severity);
    if (sample->vertex < m->surface->mesh.positions.count)
        raise(&m->of_vertices[sample->vertex], severity);
    if (sample->normal < m->surface->normals.count) raise(&m->of_normals[sample->normal], severity);
}

/* Dots mark what is small or far between; where very many places are named, the faces' colours do.
 * An info that names most of a mesh says something of the mesh, and would only hide the rest. */
static const size_t most_dots = 400;

static int is_of_the_whole(const marks *m, const norma_finding *finding) {
    return finding->severity == NORMA_SEVERITY_INFO && finding->count > m->faces / 4;
}

static int mark_finding(marks *m, const norma_finding *finding) {
    int good = 1;
    for (size_t i = 0; i < finding->sample_count && good && !is_of_the_whole(m, finding); ++i) {
        mark_sample(m, &finding->samples[i], finding->severity);
        if (i < finding->count && finding->count <= most_dots &&
            finding->severity >= NORMA_SEVERITY_WARNING)
            good = add_dot(m, &finding->samples[i], finding->severity);
    }
    return good;
}

/* Of faces; and of corners, by their vertices and the normals that they name. */
static int colour_marks(render_scene_file *file, const marks *m, render_surface *surface) {
    const norma_mesh *mesh = &surface->mesh;
    uint32_t *faces = malloc((m->faces + 1) * sizeof *faces),
             *corners = malloc((mesh->corner_count + 1) * sizeof *corners);
    for (size_t i = 0; faces && i < m->faces; ++i) faces[i] = colours[m->of_faces[i]];
    for (size_t i = 0; corners && i < mesh->corner_count; ++i) {
        const uint32_t normal = surface->corner_normals ? surface->corner_normals[i] : UINT32_MAX;
        uint8_t severity = m->of_vertices[norma_mesh_corner(mesh, i)];
        if (normal < surface->normals.count) raise(&severity, m->of_normals[normal]);
        corners[i] = colours[severity];
    }
    surface->face_marks = faces;
    surface->corner_marks = corners;
    const int kept = keep_block(file, faces);
    return keep_block(file, corners) && kept && faces && corners;
}

static int mark_surface(render_scene_file *file, const norma_findings *findings, const char *where,
    render_surface *surface) {
    marks m;
    int good = begin_marks(&m, surface);
    /* Errors last, so that their dots lie above. */
    for (int severity = NORMA_SEVERITY_INFO; severity <= NORMA_SEVERITY_ERROR; ++severity)
        for (size_t i = 0; good && i < norma_findings_count(findings); ++i) {
            const norma_finding *finding = norma_findings_get(findings, i);
            if ((int)finding->severity == severity && strcmp(finding->where, where) == 0)
                good = mark_finding(&m, finding);
        }
    if (good) good = colour_marks(file, &m, surface);
    if (good && m.dots) {
        surface->dots = m.dots;
        surface->dot_count = m.dot_count;
        good = keep_block(file, m.dots);
        m.dots = NULL;
    }
    end_marks(&m);
    return good;
}

/* How many of each severity, the rules of the gravest by name while there is room, and how many
 * have no place on a surface. */
static void tell_found(const norma_findings *findings, render_scene_file *file) {
    const size_t room = sizeof file->found;
    size_t length = 0, named = 0;
    memset(file->found_counts, 0, sizeof file->found_counts);
    file->found_nowhere = 0;
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        ++file->found_counts[finding->severity];
        file->found_nowhere += finding->sample_count == 0;
    }
    snprintf(file->found, room, "nothing found");
    for (int severity = NORMA_SEVERITY_ERROR; severity >= NORMA_SEVERITY_INFO; --severity)
        for (size_t i = 0; i < norma_findings_count(findings) && named < 3; ++i) {
            const norma_finding *finding = norma_findings_get(findings, i);
            char name[120];
            snprintf(name, sizeof name, "%s %s", finding->rule->id, finding->rule->name);
            if ((int)finding->severity != severity || (named && strstr(file->found, name)))
                continue;
            const int more =
                snprintf(file->found + length, room - length, "%s%s", named++ ? ", " : "", name);
            length += more > 0 && (size_t)more < room - length ? (size_t)more : 0;
        }
}

/* Colours the faces and vertices that norma check names, and fills file->found. */
static norma_document_result render_file_mark(const render_settings *settings,
    render_scene_file *file, render_surface *surfaces, size_t surface_count,
    norma_document_error *error) {
    cli_progress progress;
    const norma_check_options options = {.struct_size = sizeof options,
        .max_samples = MOST_SAMPLES,
        .whole_components = 1,
        .rules = settings->has_select ? settings->select : NULL,
        .threads = settings->common.threads,
        .progress = cli_progress_elapsed,
        .progress_user = &progress};
    norma_findings *findings = NULL;
    cli_progress_start(&progress, "checking", file->input, settings->common.quiet, 0);
    norma_document_result result = norma_check_document(file->document, &options, &findings, error);
    cli_progress_stop(&progress);
    for (size_t i = 0; i < surface_count && !result; ++i) {
        norma_mesh_info info;
        result = norma_document_mesh_info(file->document, file->document_meshes[i], &info);
        if (!result && !mark_surface(file, findings, info.where, &surfaces[i]))
            result = no_memory_for_scene(error, file);
    }
    if (!result) tell_found(findings, file);
    norma_findings_free(findings);
    error->result = result;
    return result;
}

/* ---- Where the surfaces of a file stand, as a viewer of the format draws them at rest:
 * at each instance of each node of its scene, moved by morph targets and skins. */

typedef struct scene_maker {
    render_surface *surfaces;
    render_draw *draws;
    size_t surface_count, draw_count;
    size_t *mesh_of; /* the file's number of the mesh of each surface that does not move */
} scene_maker;

/* The surfaces of a mesh of the file, which come in the order of their meshes. */
static int surfaces_of(
    const scene_maker *m, size_t base_count, size_t mesh, size_t *first, size_t *count) {
    size_t low = 0, high = base_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (m->mesh_of[middle] < mesh)
            low = middle + 1;
        else
            high = middle;
    }
    for (*first = low, *count = 0; low < base_count && m->mesh_of[low] == mesh; ++low) ++*count;
    return *count > 0;
}

/* ---- a surface that moves */

static void find_middle(const norma_mesh *mesh, size_t face, double middle[3]) {
    memset(middle, 0, 3 * sizeof *middle);
    for (size_t corner = 3 * face; corner < 3 * face + 3; ++corner) {
        double p[3];
        norma_view_vector(&mesh->positions, norma_mesh_corner(mesh, corner), p);
        for (int k = 0; k < 3; ++k) middle[k] += p[k] / 3;
    }
}

static int move_dots(render_scene_file *file, render_surface *surface) {
    render_dot *dots = malloc((surface->dot_count + 1) * sizeof *dots);
    if (!dots) return 0;
    for (size_t i = 0; i < surface->dot_count; ++i) {
        dots[i] = surface->dots[i];
        if (dots[i].vertex < surface->mesh.positions.count)
            norma_view_vector(&surface->mesh.positions, dots[i].vertex, dots[i].position);
        else if (3 * dots[i].face < surface->mesh.corner_count) /* a glTF's are triangles */
            find_middle(&surface->mesh, dots[i].face, dots[i].position);
    }
    surface->dots = dots;
    return keep_block(file, dots);
}

/* Errors are measured where the file stores normals: between them and those of the mesh as it is
 * stored. */
static int add_moved(
    render_scene_file *file, scene_maker *m, size_t from, const norma_drawn_mesh *drawn) {
    render_surface *surface = &m->surfaces[m->surface_count++];
    *surface = m->surfaces[from];
    surface->stored_surface = &m->surfaces[from];
    surface->mesh.positions = drawn->positions;
    surface->normals = drawn->normals;
    if (surface->tangents) surface->tangents = drawn->tangents;
    surface->expected = NULL;
    return !surface->dots || move_dots(file, surface);
}

/* ---- draws */

typedef struct node_draws { /* the surfaces of one node's mesh */
    size_t node, first, count;
} node_draws;

static norma_document_result drawn_at(const render_scene_file *file, const node_draws *draws,
    size_t instance, size_t surface, norma_drawn_mesh *drawn, norma_document_error *error) {
    return norma_document_drawn_mesh(file->document, draws->node, instance,
        file->document_meshes[draws->first + surface], drawn, error);
}

/* If any of the node's surfaces moves, all of them are made anew, so that they stay one body. */
static norma_document_result move_surfaces(const render_settings *settings, render_scene_file *file,
    scene_maker *m, const node_draws *draws, size_t *first, norma_document_error *error) {
    const size_t begin = m->surface_count;
    norma_drawn_mesh drawn;
    int any = 0;
    *first = draws->first;
    for (size_t k = 0; k < draws->count && !any; ++k) {
        norma_document_result result = drawn_at(file, draws, 0, k, &drawn, error);
        if (result) return result;
        any = drawn.moved;
    }
    for (size_t k = 0; k < draws->count && any; ++k) {
        norma_document_result result = drawn_at(file, draws, 0, k, &drawn, error);
        if (result) return result;
        if (!add_moved(file, m, draws->first + k, &drawn)) return no_memory_for_scene(error, file);
    }
    if (any) *first = begin;
    return !any || !render_join_needed(settings, &m->surfaces[begin], draws->count) ||
                   render_join_primitives(file, &m->surfaces[begin], draws->count, error)
               ? NORMA_DOCUMENT_OK
               : error->result;
}

static norma_document_result draw_node(const render_settings *settings, render_scene_file *file,
    scene_maker *m, const node_draws *draws, size_t instances, norma_document_error *error) {
    size_t first;
    norma_document_result result = move_surfaces(settings, file, m, draws, &first, error);
    for (size_t instance = 0; instance < instances && !result; ++instance)
        for (size_t k = 0; k < draws->count && !result; ++k) {
            norma_drawn_mesh drawn;
            result = drawn_at(file, draws, instance, k, &drawn, error);
            file->not_shown += !result && !drawn.shown;
            if (result || !drawn.shown || (drawn.skinned && instance > 0)) continue;
            m->draws[m->draw_count].surface = first + k;
            memcpy(m->draws[m->draw_count++].world, drawn.world, sizeof drawn.world);
        }
    return result;
}

/* Room for all draws, and for the surfaces that may move. */
static norma_document_result make_draw_room(
    render_scene_file *file, scene_maker *m, norma_document_error *error) {
    norma_document *document = file->document;
    size_t draws = 0, moved = 0;
    for (size_t i = 0; i < norma_document_node_count(document); ++i) {
        norma_node_info node;
        norma_mesh_info info;
        size_t first, count;
        norma_document_result result = norma_document_node_info(document, i, &node);
        if (result) return result;
        if (!surfaces_of(m, m->surface_count, node.mesh, &first, &count)) continue;
        draws += count * node.instances;
        int moves = node.skin != SIZE_MAX;
        for (size_t k = 0; k < count && !moves && !result; ++k) {
            result = norma_document_mesh_info(document, file->document_meshes[first + k], &info);
            moves = info.morph_targets > 0;
        }
        if (result) return result;
        moved += moves ? count : 0;
    }
    render_surface *larger =
        realloc(m->surfaces, (m->surface_count + moved + 1) * sizeof *m->surfaces);
    if (larger) m->surfaces = larger;
    m->draws = calloc(draws + 1, sizeof *m->draws);
    return larger && m->draws ? NORMA_DOCUMENT_OK : no_memory_for_scene(error, file);
}

/* Fills draws, and adds the surfaces that move. No draw: no node of the file draws a surface. */
static norma_document_result render_file_draws(const render_settings *settings,
    render_scene_file *file, scene_maker *m, norma_document_error *error) {
    const size_t base_count = m->surface_count;
    file->not_shown = 0;
    norma_document_result result = make_draw_room(file, m, error);
    for (size_t i = 0; i < norma_document_node_count(file->document) && !result; ++i) {
        norma_node_info node;
        node_draws draws = {.node = i};
        result = norma_document_node_info(file->document, i, &node);
        if (!result && surfaces_of(m, base_count, node.mesh, &draws.first, &draws.count))
            result = draw_node(settings, file, m, &draws, node.instances, error);
    }
    return result;
}

/* ---- A document as a scene: each mesh a surface, each node that draws one, and each of
 * its instances, a draw. */

static enum render_normals stored_as(const norma_mesh_info *info, const norma_mesh_data *data) {
    if (!data->normals.data || data->normals.count == 0) return RENDER_NORMALS_NONE;
    switch (info->normals) {
    case NORMA_NORMALS_NONE:
        return RENDER_NORMALS_NONE;
    case NORMA_NORMALS_PER_VERTEX:
        return data->normals.count < info->vertices ? RENDER_NORMALS_PER_CORNER
                                                    : RENDER_NORMALS_PER_VERTEX;
    case NORMA_NORMALS_PER_CORNER:
        return RENDER_NORMALS_PER_CORNER;
    case NORMA_NORMALS_PER_FACET:
        return RENDER_NORMALS_PER_FACET;
    }
    return RENDER_NORMALS_NONE;
}

/* What the format leaves open, as norma compute has it; glTF says that a mesh without normals is
 * flat. */
static double usual_crease(
    const render_settings *settings, norma_file_format format, const render_surface *surface) {
    const double flat = -1, all = 3.14159265358979, sixty = 1.0471975511965976;
    switch (format) {
    case NORMA_FILE_STL:
        return flat;
    case NORMA_FILE_PLY:
        return all;
    case NORMA_FILE_OBJ:
        return surface->mesh.smoothing_groups ? all : sixty;
    default:
        return surface->stored == RENDER_NORMALS_NONE && settings->show != RENDER_SHOW_ERROR &&
                       !settings->normals.compute
                   ? flat
                   : sixty;
    }
}

static norma_document_result fill_surface(const render_settings *settings, render_scene_file *file,
    const render_variant *variant, size_t index, const norma_mesh_info *info,
    render_surface *surface, norma_document_error *error) {
    norma_mesh_data data;
    norma_mesh_attributes attributes;
    norma_document_result result = norma_document_mesh_data(file->document, index, &data, error);
    if (!result) result = norma_document_mesh_attributes(file->document, index, &attributes, error);
    if (result) return result;
    const norma_file_format format = norma_document_format(file->document);
    *surface = (render_surface){.mesh = data.mesh,
        .normals = data.normals,
        .corner_normals = data.corner_normals,
        .stored = stored_as(info, &data)};
    if (variant->compute) surface->stored = RENDER_NORMALS_NONE;
    surface->replace_zeros = format == NORMA_FILE_STL;
    surface->weight = variant->weight;
    surface->crease_rad =
        variant->crease_given ? variant->crease_rad : usual_crease(settings, format, surface);
    return render_file_set_material(settings, file, index, &attributes, surface, error);
}

/* ---- the scene */

static norma_document_result fill_surfaces(const render_settings *settings, render_scene_file *file,
    const render_variant *variant, scene_maker *m, norma_document_error *error) {
    for (size_t i = 0; i < norma_document_mesh_count(file->document); ++i) {
        norma_mesh_info info;
        norma_document_result result = norma_document_mesh_info(file->document, i, &info);
        if (!result && (info.not_read || info.triangles == 0)) continue;
        if (!result)
            result = fill_surface(
                settings, file, variant, i, &info, &m->surfaces[m->surface_count], error);
        if (result) return result;
        file->document_meshes[m->surface_count] = i;
        m->mesh_of[m->surface_count++] = info.mesh;
    }
    for (size_t first = 0, next; first < m->surface_count; first = next) {
        for (next = first + 1; next < m->surface_count && m->mesh_of[next] == m->mesh_of[first];)
            ++next;
        if (render_join_needed(settings, &m->surfaces[first], next - first) &&
            !render_join_primitives(file, &m->surfaces[first], next - first, error))
            return error->result;
    }
    return NORMA_DOCUMENT_OK;
}

/* Without nodes each mesh stands where its numbers say. */
static void draw_each_once(scene_maker *m) {
    for (size_t i = 0; i < m->surface_count; ++i) {
        m->draws[i].surface = i;
        memcpy(m->draws[i].world, cli_matrix_identity.matrix, sizeof m->draws[i].world);
    }
    m->draw_count = m->surface_count;
}

static norma_document_result fill_scene(const render_settings *settings, render_scene_file *file,
    const render_variant *variant, scene_maker *m, norma_document_error *error) {
    norma_document_result result = fill_surfaces(settings, file, variant, m, error);
    if (!result && settings->show == RENDER_SHOW_MARKS)
        result = render_file_mark(settings, file, m->surfaces, m->surface_count, error);
    if (!result) result = render_file_draws(settings, file, m, error);
    if (result || m->draw_count > 0) return result;
    free(m->draws);
    m->draws = calloc(m->surface_count + 1, sizeof *m->draws);
    if (!m->draws) return no_memory_for_scene(error, file);
    draw_each_once(m);
    return result;
}

static norma_document_result make_scene(const render_settings *settings, render_scene_file *file,
    const render_variant *variant, render_scene *scene, norma_document_error *error) {
    const size_t meshes = norma_document_mesh_count(file->document);
    scene_maker m = {.surfaces = calloc(meshes + 1, sizeof *m.surfaces),
        .mesh_of = calloc(meshes + 1, sizeof *m.mesh_of)};
    if (!file->document_meshes)
        file->document_meshes = calloc(meshes + 1, sizeof *file->document_meshes);
    norma_document_result result = m.surfaces && m.mesh_of && file->document_meshes
                                       ? fill_scene(settings, file, variant, &m, error)
                                       : no_memory_for_scene(error, file);
    free(m.mesh_of);
    *scene = (render_scene){m.surfaces, m.surface_count, m.draws, m.draw_count};
    if (!result && m.draw_count == 0)
        result = cli_fail_empty(file->document, file->input, "draw", error);
    if (!result && settings->show == RENDER_SHOW_TANGENTS && !file->with_tangents &&
        !file->with_texcoords)
        result = file_fail(error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, file->input,
            "there are no tangents to show: no surface stores any, nor the texture coordinates "
            "that glTF tangents are computed from");
    if (result) {
        free_scene(scene);
    } else {
        file->up_guessed = !settings->up_given && !is_gltf(file);
        file->up = settings->up_given ? settings->up
                                      : render_find_up(file->document, m.surfaces, m.surface_count);
    }
    error->result = result;
    return result;
}

static int same_variant(const render_variant *a, const render_variant *b) {
    return a->compute == b->compute && a->crease_given == b->crease_given &&
           a->weight == b->weight && !(a->crease_given && a->crease_rad != b->crease_rad);
}

const render_scene *render_file_scene(const render_settings *settings, render_scene_file *file,
    const render_variant *variant, norma_document_error *error) {
    for (size_t i = 0; i < file->variant_count; ++i)
        if (same_variant(&file->variants[i], variant)) return &file->scenes[i];
    if (file->variant_count == RENDER_MOST_PANELS) {
        file_fail(error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, file->input,
            "would be drawn in too many variants");
        return NULL;
    }
    if (make_scene(settings, file, variant, &file->scenes[file->variant_count], error)) return NULL;
    file->variants[file->variant_count] = *variant;
    return &file->scenes[file->variant_count++];
}
