/* obj.c: OBJ as a document: one mesh, its positions as doubles, a normal for each corner that names
 * one. */
#include "io/obj/obj.h"
#include "core/call/call.h"
#include <stdlib.h>
#include <string.h>

/* ---- Faces of an OBJ reversed, cut or left out, single vn and v lines with other numbers,
 * v lines that go and come: the text is written so and read anew. */

static void take_numbers(obj_state *state, const norma_mesh_edit *edit) {
    for (size_t i = 0; edit->set_normals && i < state->normal_count; ++i)
        if (edit->set_normals[i])
            memcpy(state->normals + 3 * i, edit->normals + 3 * i, 3 * sizeof *state->normals);
    for (size_t i = 0; edit->set_positions && i < state->position_count; ++i)
        if (edit->set_positions[i])
            memcpy(state->positions + 3 * i, edit->positions + 3 * i, 3 * sizeof *state->positions);
    state->normals_turned |= edit->set_normals != NULL;
    state->positions_moved |= edit->set_positions != NULL;
}

static norma_document_result obj_edit(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    norma_document_result result = norma_edited_flush(document, error);
    if (result) return result;
    obj_state *state = document->state;
    if (edit->set_normals && !state->has_normals) /* there may be vn lines, but none that a face
                                                     names, so none that the caller was told of */
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "has no normals that could be replaced");
    result =
        edit->source_vertices ? norma_obj_edit_vertices(document, edit, error) : NORMA_DOCUMENT_OK;
    if (result) return result;
    take_numbers(state, edit);
    state->reverse_faces = edit->reverse_faces;
    state->drop_faces = edit->drop_faces;
    state->cut_faces = edit->cut_faces;
    state->cut_corners = edit->cut_corners;
    result = norma_edited_flush(document, error);
    state = document->state;
    if (result && state)
        state->reverse_faces = state->drop_faces = state->cut_faces = NULL; /* the caller's */
    return result;
}

/* ---- What an OBJ's faces have beside positions and normals: texture vertices and
 * materials. A second walk over the same statements, for those who ask. */

typedef struct walk {
    norma_document *document;
    const obj_state *state;
    const char *end;
    float *texcoords;
    size_t texcoord_count, texcoord_room;
    uint32_t *corner_texcoords; /* of each corner */
    size_t corner, face;
    norma_names materials;
    uint32_t *face_materials;
    uint32_t material; /* in force; UINT32_MAX: none */
    int failed;        /* out of memory */
} walk;

/* ---- statements */

static void scene_read_material(walk *w, const char *p) {
    p = norma_obj_skip_blanks(p, w->end);
    const char *end = norma_obj_statement_end(p, w->end, NULL);
    while (end > p && norma_obj_is_blank(end[-1])) --end;
    const char *zero = memchr(p, 0, (size_t)(end - p)); /* a text ends there */
    w->material = norma_names_number(&w->materials, p, (size_t)((zero ? zero : end) - p));
    w->failed |= w->material == UINT32_MAX;
}

static void read_texcoord(walk *w, const char *p) {
    float *texcoord =
        norma_io_add(&w->texcoords, &w->texcoord_room, &w->texcoord_count, 2 * sizeof *texcoord);
    w->failed |= !texcoord;
    if (!texcoord) return;
    for (size_t i = 0; i < 2; ++i) {
        double number = 0;
        uint64_t digits;
        p = norma_obj_skip_blanks(p, w->end);
        const char *next = norma_digits_plain(p, w->end, &number, &digits);
        if (!next) next = norma_number_parse(p, w->end, &number);
        p = norma_obj_number_end(next ? next : p, w->end);
        texcoord[i] = (float)number;
    }
}

static uint32_t texture_of(const walk *w, const obj_corner *corner) {
    int64_t index;
    const char *slash = memchr(corner->begin, '/', (size_t)(corner->end - corner->begin));
    if (!corner->has_texture || !slash ||
        !norma_number_parse_integer(slash + 1, corner->end, &index))
        return UINT32_MAX;
    uint32_t number = norma_obj_resolve(index, w->texcoord_count);
    return number == UINT32_MAX - 2 ? UINT32_MAX : number;
}

static void scene_read_face(walk *w, const char *p) {
    obj_corner corner;
    size_t first = w->corner;
    for (p = norma_obj_skip_blanks(p, w->end);
         w->corner < w->state->corner_count && norma_obj_corner(p, w->end, &corner);
         p = norma_obj_skip_blanks(corner.end, w->end))
        w->corner_texcoords[w->corner++] = texture_of(w, &corner);
    if (w->corner > first && w->face < w->state->face_count)
        w->face_materials[w->face++] = w->material;
}

/* ---- plain lines, nearly all of a file. What is not plain is read the long way. */

/* Where the line ends; NULL: not plain, nothing has been read. */
static const char *read_plain_face(walk *w, const char *p) {
    size_t corner = w->corner;
    while (corner < w->state->corner_count) {
        obj_plain_corner plain;
        while (p < w->end && *p == ' ') ++p;
        if (p < w->end && *p == '\n') break;
        if (w->end - p < OBJ_PLAIN_LENGTH || !norma_obj_read_plain_corner(p, &plain)) return NULL;
        w->corner_texcoords[corner++] = plain.texture - 1;
        p = plain.end;
    }
    while (p < w->end && *p == ' ') ++p;
    if (p >= w->end || *p != '\n' || corner == w->corner || w->face >= w->state->face_count)
        return NULL;
    w->corner = corner;
    w->face_materials[w->face++] = w->material;
    return p;
}

static int is_word(const char *p, const char *end, const char *word, size_t length) {
    return (size_t)(end - p) > length && memcmp(p, word, length) == 0 &&
           norma_obj_is_blank(p[length]);
}

/* Where its line ends. */
static const char *scene_read_statement(walk *w, const char *p) {
    const char *rest = p, *plain = NULL;
    if (*p == 'f' && is_word(p, w->end, "f", 1)) plain = read_plain_face(w, p + 1);
    if (plain) return plain;
    if (*p == 'f' && norma_obj_keyword(p, w->end, &rest) == OBJ_FACE)
        scene_read_face(w, rest);
    else if (*p == 'v' && is_word(p, w->end, "vt", 2))
        read_texcoord(w, p + 2);
    else if (*p == 'u' && is_word(p, w->end, "usemtl", 6))
        scene_read_material(w, p + 6);
    return norma_obj_statement_end(p, w->end, NULL);
}

static void scene_walk_all(walk *w) {
    const char *text = (const char *)w->document->source.data;
    if (w->document->source.size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0) text += 3;
    for (const char *p = text; p < w->end && !w->failed;) {
        p = norma_obj_skip_blanks(p, w->end);
        p = p < w->end ? norma_obj_skip_end(scene_read_statement(w, p), w->end) : p;
    }
}

/* ---- the document's */

static int keep_materials(walk *w) {
    norma_scene *scene = w->document->scene;
    const size_t count = w->materials.count;
    norma_material_info *materials = norma_scene_allocate(scene, count, sizeof *materials);
    if (!materials) return 0;
    for (size_t i = 0; i < count; ++i) {
        const char *name = norma_scene_text(scene, w->materials.list[i]);
        if (!name) return 0;
        materials[i] = (norma_material_info){
            .name = name, .where = "", .base_color = {1, 1, 1, 1}, .ignore = ""};
    }
    scene->materials = materials;
    scene->material_count = count;
    return 1;
}

static int several(const walk *w) {
    for (size_t i = 1; i < w->face; ++i)
        if (w->face_materials[i] != w->face_materials[0]) return 1;
    return 0;
}

/* vt numbers past the last one name none. */
static void scene_keep_texcoords(walk *w, norma_mesh_attributes *made) {
    int any = 0;
    for (size_t i = 0; i < w->corner; ++i) {
        if (w->corner_texcoords[i] >= w->texcoord_count) w->corner_texcoords[i] = UINT32_MAX;
        any |= w->corner_texcoords[i] != UINT32_MAX;
    }
    float *kept =
        any ? norma_scene_allocate(w->document->scene, w->texcoord_count, 2 * sizeof *kept) : NULL;
    w->failed |= any && !kept;
    if (!kept) return;
    memcpy(kept, w->texcoords, w->texcoord_count * 2 * sizeof *kept);
    made->texcoords = kept;
    made->texcoord_count = w->texcoord_count;
    made->corner_texcoords = w->corner_texcoords;
}

/* 1: some corners name a normal and others none; 2: one names a normal that is not there. */
static uint8_t fault_of(const obj_state *state, size_t face) {
    int bad = 0, without = 0, with = 0;
    for (size_t i = norma_obj_face_start(state, face); i < norma_obj_face_start(state, face + 1);
         ++i) {
        bad |= state->corner_normals[i] == OBJ_BAD_NORMAL;
        without |= state->corner_normals[i] == OBJ_NO_NORMAL;
        with |= state->corner_normals[i] < OBJ_BAD_NORMAL;
    }
    return bad ? 2 : with && without;
}

static void obj_judge_normals(walk *w, norma_mesh_attributes *made) {
    const obj_state *state = w->state;
    uint8_t *faults = NULL;
    for (size_t face = 0; state->corner_normals && face < state->face_count; ++face) {
        uint8_t fault = fault_of(state, face);
        if (!fault) continue;
        if (!faults && !(faults = norma_scene_allocate(w->document->scene, state->face_count, 1))) {
            w->failed = 1;
            return;
        }
        faults[face] = fault;
        made->normals_missing += fault == 1;
        made->normals_out_of_range += fault == 2;
    }
    made->face_faults = faults;
}

/* Both, materials and attributes, come of one walk. */
static norma_document_result walk_all(norma_document *document, norma_document_error *error) {
    norma_scene *scene = document->scene;
    const obj_state *state = document->state;
    walk w = {.document = document,
        .state = state,
        .end = (const char *)document->source.data + document->source.size,
        .material = UINT32_MAX};
    norma_mesh_attributes *made = norma_scene_allocate(scene, 1, sizeof *made);
    norma_mesh_attributes **list = norma_scene_allocate(scene, 1, sizeof *list);
    w.corner_texcoords =
        norma_scene_allocate(scene, state->corner_count, sizeof *w.corner_texcoords);
    w.face_materials = norma_scene_allocate(scene, state->face_count, sizeof *w.face_materials);
    w.failed = !made || !list || !w.corner_texcoords || !w.face_materials;
    if (!w.failed) scene_walk_all(&w);
    if (!w.failed) {
        *made = (norma_mesh_attributes){.material = SIZE_MAX, .tangent_encoding = "", .ignore = ""};
        scene_keep_texcoords(&w, made);
        obj_judge_normals(&w, made);
        if (w.face && w.face_materials[0] != UINT32_MAX) made->material = w.face_materials[0];
        if (several(&w)) made->face_materials = w.face_materials;
        list[0] = made;
    }
    w.failed = w.failed || !keep_materials(&w);
    if (!w.failed) scene->attributes = list;
    free(w.texcoords);
    norma_names_free(&w.materials);
    return w.failed ? norma_document_fail_memory(document, error) : NORMA_DOCUMENT_OK;
}

static norma_document_result scene_read_unread(
    norma_document *document, norma_document_error *error) {
    const obj_state *state = document->state;
    norma_unread *unread = norma_scene_tell_unread(document, state->has_surfaces != 0, error);
    if (unread && state->has_surfaces)
        *unread = (norma_unread){
            .where = "", .why = "free-form surfaces are not read, only the polygons beside them"};
    return unread ? NORMA_DOCUMENT_OK : NORMA_DOCUMENT_ERROR_MEMORY;
}

static const scene_functions OBJ_SCENE = {.materials = walk_all, .unread = scene_read_unread};

/* ---- the document */

static norma_document_result obj_mesh_info(
    const norma_document *document, size_t index, norma_mesh_info *info) {
    const obj_state *state = document->state;
    (void)index;
    info->name = state->name ? state->name : "";
    info->vertices = state->position_count;
    info->faces = state->face_count;
    info->triangles = state->corner_count - 2 * state->face_count;
    info->normals = state->has_normals ? NORMA_NORMALS_PER_CORNER : NORMA_NORMALS_NONE;
    info->encoding = state->has_normals ? "text" : "";
    info->has_smoothing_groups = state->has_groups;
    return NORMA_DOCUMENT_OK;
}

/* Normals that are not there are shown as none. */
static const uint32_t *shown_normals(obj_state *state) {
    if (!state->bad_normal_count) return state->corner_normals;
    if (!state->shown_normals)
        state->shown_normals = norma_io_allocate(state->corner_count, sizeof *state->shown_normals);
    for (size_t i = 0; state->shown_normals && i < state->corner_count; ++i)
        state->shown_normals[i] =
            state->corner_normals[i] == OBJ_BAD_NORMAL ? OBJ_NO_NORMAL : state->corner_normals[i];
    return state->shown_normals;
}

static norma_document_result mesh_data(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error) {
    obj_state *state = document->state;
    (void)index;
    data->mesh = norma_obj_mesh(state);
    if (state->has_groups) {
        const norma_options options = {.struct_size = sizeof options};
        const norma_result result =
            state->groups_shown ? NORMA_OK : norma_obj_groups(state, &options);
        if (result) return norma_document_fail_core(document, error, result);
        state->groups_shown = 1;
        data->mesh.smoothing_groups = state->group_masks;
        data->mesh.hard_edges = state->hard_edges;
    }
    if (state->has_normals) {
        data->normals =
            (norma_vec3_view){state->normals, state->normal_count, 0, NORMA_FORMAT_FLOAT};
        data->corner_normals = shown_normals(state);
        if (!data->corner_normals) return norma_document_fail_memory(document, error);
    }
    return NORMA_DOCUMENT_OK;
}

/* mtllib statements, from the first one to the last. The word is searched for, since those between
 * are not remembered. */
static int visit_files(const norma_document *document, norma_visit_file *visit, void *user) {
    static const char word[] = "mtllib";
    const size_t length = sizeof word - 1;
    const obj_state *state = document->state;
    if (!state || state->first_library == SIZE_MAX) return 0;
    const char *text = (const char *)document->source.data, *at = text + state->first_library,
               *last = text + state->last_library, *end = text + document->source.size;
    int stop = 0;
    while (!stop && at <= last && (at = memchr(at, 'm', (size_t)(end - at)))) {
        const char *rest = at + length;
        if (end - at > (ptrdiff_t)length && memcmp(at, word, length) == 0 &&
            (*rest == ' ' || *rest == '\t')) {
            const char *stops = norma_obj_statement_end(rest, end, NULL);
            stop = norma_document_visit_names(document, rest, (size_t)(stops - rest), visit, user);
        }
        ++at;
    }
    return stop;
}

const format_functions norma_obj_functions = {.open = norma_edited_open,
    .close = norma_edited_close,
    .edited = &norma_obj_edited,
    .mesh_count = norma_edited_mesh_count,
    .mesh_info = obj_mesh_info,
    .mesh_data = mesh_data,
    .compute = norma_obj_compute,
    .transform = norma_obj_transform,
    .edit = obj_edit,
    .equal_vertices = norma_obj_equal_vertices,
    .write = norma_obj_write,
    .visit_files = visit_files,
    .scene = &OBJ_SCENE};
