/* compare_scene.c: files that are compared: every mesh at its places in the scene, with node
 * transforms, skins and morph targets applied, and normals computed where there are none; then the
 * pieces of each name with those of the same name. */
#include "compare/compare_scene.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A file of a few kilobytes can ask for millions of instances. */
static const size_t most_instanced_vertices = (size_t)1 << 26;

static norma_document_result fail_compared(const compared_scene *scene, norma_document_error *error,
    norma_document_result result, const char *what) {
    snprintf(error->message, sizeof error->message, "%.800s: %s", scene->name, what);
    return error->result = result;
}

/* ---- which meshes are drawn where */

static int add_piece(compared_scene *scene, compared_piece piece) {
    if ((scene->count & (scene->count - 1)) == 0) {
        const size_t room = scene->count ? 2 * scene->count : 1;
        compared_piece *larger = realloc(scene->pieces, room * sizeof *larger);
        if (!larger) return 0;
        scene->pieces = larger;
    }
    scene->pieces[scene->count++] = piece;
    return 1;
}

/* node: SIZE_MAX where none draws it. *vertices: of all pieces, 0 where they are too many. */
static norma_document_result add_pieces_of(compared_scene *scene, const norma_node_info *node,
    size_t node_index, size_t *vertices, norma_document_error *error) {
    const int named = norma_document_format(scene->document) >= NORMA_FILE_GLTF;
    const size_t first = node ? node->first_mesh : 0,
                 count = node ? node->mesh_count : norma_document_mesh_count(scene->document);
    for (size_t i = first; i < first + count; ++i) {
        norma_mesh_info info;
        norma_document_result result = norma_document_mesh_info(scene->document, i, &info);
        if (result) return result;
        if (info.not_read || !info.faces) continue;
        norma_drawn_mesh drawn = {.shown = 1};
        if (node)
            result = norma_document_drawn_mesh(scene->document, node_index, 0, i, &drawn, error);
        if (result) return result;
        const size_t instances = !drawn.shown ? 0 : !node || drawn.skinned ? 1 : node->instances;
        if (instances > 1 && instances > (most_instanced_vertices - *vertices) / info.vertices)
            return fail_compared(scene, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
                "its instances have more than 67 million vertices");
        *vertices += instances > 1 ? instances * info.vertices : 0;
        for (size_t k = 0; k < instances; ++k)
            if (!add_piece(scene, (compared_piece){.name = named ? info.name : "",
                                      .mesh = i,
                                      .node = node_index,
                                      .instance = k}))
                return fail_compared(scene, error, NORMA_DOCUMENT_ERROR_MEMORY, "out of memory");
    }
    return NORMA_DOCUMENT_OK;
}

static int piece_order(const void *first, const void *second) {
    const compared_piece *a = first, *b = second;
    const int names = strcmp(a->name, b->name);
    if (names) return names;
    if (a->node != b->node) return a->node < b->node ? -1 : 1;
    if (a->mesh != b->mesh) return a->mesh < b->mesh ? -1 : 1;
    return a->instance < b->instance ? -1 : a->instance > b->instance;
}

static norma_document_result find_pieces(compared_scene *scene, norma_document_error *error) {
    const size_t nodes = norma_document_node_count(scene->document);
    size_t vertices = 0;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < nodes && !result; ++i) {
        norma_node_info node;
        result = norma_document_node_info(scene->document, i, &node);
        if (!result) result = add_pieces_of(scene, &node, i, &vertices, error);
    }
    if (!nodes) result = add_pieces_of(scene, NULL, SIZE_MAX, &vertices, error);
    if (!result && scene->count)
        qsort(scene->pieces, scene->count, sizeof *scene->pieces, piece_order);
    return result;
}

/* ---- their arrays */

static const double identity_matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static norma_document_result read_drawn(const compared_scene *scene, const compared_piece *piece,
    norma_mesh_data *data, norma_drawn_mesh *drawn, norma_document_error *error) {
    norma_document_result result =
        norma_document_mesh_data(scene->document, piece->mesh, data, error);
    if (result) return result;
    if (piece->node != SIZE_MAX)
        return norma_document_drawn_mesh(
            scene->document, piece->node, piece->instance, piece->mesh, drawn, error);
    *drawn = (norma_drawn_mesh){.positions = data->mesh.positions, .normals = data->normals};
    memcpy(drawn->world, identity_matrix, sizeof drawn->world);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result count_piece(
    compared_scene *scene, size_t number, norma_document_error *error) {
    compared_piece *piece = &scene->pieces[number];
    norma_mesh_data data;
    norma_drawn_mesh drawn;
    const norma_document_result result = read_drawn(scene, piece, &data, &drawn, error);
    if (result) return result;
    piece->positions = drawn.positions.count;
    piece->normals = drawn.normals.count;
    piece->corners = data.mesh.corner_count;
    piece->faces = data.mesh.face_starts ? data.mesh.face_count : data.mesh.corner_count / 3;
    if (!number) return NORMA_DOCUMENT_OK;
    const compared_piece *before = piece - 1;
    piece->first_position = before->first_position + before->positions;
    piece->first_normal = before->first_normal + before->normals;
    piece->first_corner = before->first_corner + before->corners;
    piece->first_face = before->first_face + before->faces;
    return NORMA_DOCUMENT_OK;
}

/* Along the cofactors, whose entries are brought near 1 so that they fit floats. */
static void normals_in_scene(const double world[16], norma_vec3_view normals, float *out) {
    double matrix[9], largest = 0;
    float fitting[9];
    norma_normal_matrix_double(world, NORMA_WINDING_REVERSED, matrix, NULL);
    for (int i = 0; i < 9; ++i) largest = fmax(largest, fabs(matrix[i]));
    for (int i = 0; i < 9; ++i) fitting[i] = (float)(largest > 0 ? matrix[i] / largest : 0);
    norma_transform_normals(fitting, normals, out, 0, normals.count);
}

static uint32_t stored_normal(
    const norma_mesh_data *data, int per_facet, size_t count, size_t face, size_t corner) {
    const uint32_t number = data->corner_normals ? data->corner_normals[corner]
                            : per_facet          ? (uint32_t)face
                                                 : norma_mesh_corner(&data->mesh, corner);
    return number < count ? number : UINT32_MAX;
}

static void fill_corners(const compared_scene *scene, const compared_piece *piece,
    const norma_mesh_data *data, int per_facet) {
    const uint32_t *starts = data->mesh.face_starts;
    for (size_t face = 0; face < piece->faces; ++face) {
        const size_t begin = starts ? starts[face] : 3 * face,
                     count = starts ? starts[face + 1] - begin : 3;
        scene->sizes[piece->first_face + face] = (uint32_t)count;
        for (size_t i = 0; i < count; ++i) {
            const size_t from = begin + (piece->mirrored ? (count - i) % count : i),
                         to = piece->first_corner + begin + i;
            scene->corners[to] = norma_mesh_corner(&data->mesh, from);
            scene->numbers[to] = stored_normal(data, per_facet, piece->normals, face, from);
        }
    }
}

static norma_document_result fill_piece(
    compared_scene *scene, size_t number, norma_document_error *error) {
    compared_piece *piece = &scene->pieces[number];
    norma_mesh_info info;
    norma_mesh_data data;
    norma_drawn_mesh drawn;
    norma_matrix_info matrix = {.mirrored = 0};
    double normal_matrix[9];
    norma_document_result result = norma_document_mesh_info(scene->document, piece->mesh, &info);
    if (!result) result = read_drawn(scene, piece, &data, &drawn, error);
    if (result) return result;
    norma_normal_matrix_double(drawn.world, NORMA_WINDING_REVERSED, normal_matrix, &matrix);
    norma_transform_positions_double(drawn.world, drawn.positions,
        scene->positions + 3 * piece->first_position, 0, piece->positions);
    normals_in_scene(drawn.world, drawn.normals, scene->normals + 3 * piece->first_normal);
    piece->mirrored = matrix.mirrored;
    fill_corners(scene, piece, &data, info.normals == NORMA_NORMALS_PER_FACET);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result fill_pieces(compared_scene *scene, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < scene->count && !result; ++i) result = count_piece(scene, i, error);
    if (result) return result;
    const compared_piece *last = &scene->pieces[scene->count - 1];
    const size_t corners = last->first_corner + last->corners;
    if (corners >= UINT32_MAX || last->first_position + last->positions >= UINT32_MAX)
        return fail_compared(scene, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
            "has too many corners to be compared; expected less than 4,294,967,295");
    scene->positions = calloc(last->first_position + last->positions + 1, 3 * sizeof(double));
    scene->normals = calloc(last->first_normal + last->normals + 1, 3 * sizeof(float));
    scene->corners = calloc(corners + 1, sizeof *scene->corners);
    scene->numbers = calloc(corners + 1, sizeof *scene->numbers);
    scene->sizes = calloc(last->first_face + last->faces + 1, sizeof *scene->sizes);
    if (!scene->positions || !scene->normals || !scene->corners || !scene->numbers || !scene->sizes)
        return fail_compared(scene, error, NORMA_DOCUMENT_ERROR_MEMORY, "out of memory");
    for (size_t i = 0; i < scene->count && !result; ++i) result = fill_piece(scene, i, error);
    return result;
}

norma_document_result compared_scene_make(norma_document *document, const char *name,
    uint32_t threads, compared_scene *scene, norma_document_error *error) {
    const norma_compute_options computing = {
        .struct_size = sizeof computing, .only = NORMA_ONLY_MISSING, .threads = threads};
    norma_compute_summary summary;
    *scene = (compared_scene){.name = name, .document = document};
    norma_document_result result = norma_document_compute(document, &computing, &summary, error);
    if (result) return result;
    scene->computed = summary.changed;
    result = find_pieces(scene, error);
    return result || !scene->count ? result : fill_pieces(scene, error);
}

static void close_scene(compared_scene *scene) {
    free(scene->pieces);
    free(scene->positions);
    free(scene->normals);
    free(scene->corners);
    free(scene->numbers);
    free(scene->sizes);
    *scene = (compared_scene){.name = scene->name, .computed = scene->computed};
}

/* ---- some of them as one surface */

int compared_surface_make(
    const compared_scene *scene, size_t first, size_t end, norma_surface *surface) {
    const compared_piece *begin = &scene->pieces[first], *last = &scene->pieces[end - 1];
    const size_t corner_count = last->first_corner + last->corners - begin->first_corner,
                 face_count = last->first_face + last->faces - begin->first_face;
    uint32_t *corners = malloc((corner_count + 1) * sizeof *corners),
             *numbers = malloc((corner_count + 1) * sizeof *numbers),
             *starts = malloc((face_count + 1) * sizeof *starts);
    *surface = (norma_surface){
        .mesh = {.positions = {scene->positions + 3 * begin->first_position,
                     last->first_position + last->positions - begin->first_position, 0,
                     NORMA_FORMAT_DOUBLE},
            .corners = corners,
            .corner_count = corner_count,
            .face_starts = starts,
            .face_count = face_count},
        .normals = {scene->normals + 3 * begin->first_normal,
            last->first_normal + last->normals - begin->first_normal + 1, 0, NORMA_FORMAT_FLOAT},
        .corner_normals = numbers};
    if (!corners || !numbers || !starts) return 0;
    for (const compared_piece *p = begin; p <= last; ++p)
        for (size_t i = p->first_corner; i < p->first_corner + p->corners; ++i) {
            const size_t to = i - begin->first_corner, of = scene->numbers[i];
            corners[to] = scene->corners[i] + (uint32_t)(p->first_position - begin->first_position);
            numbers[to] = of == UINT32_MAX ? UINT32_MAX
                                           : (uint32_t)(of + p->first_normal - begin->first_normal);
        }
    starts[0] = 0;
    for (size_t f = 0; f < face_count; ++f)
        starts[f + 1] = starts[f] + scene->sizes[begin->first_face + f];
    return 1;
}

void compared_surface_free(norma_surface *surface) {
    free((void *)(uintptr_t)surface->mesh.corners);
    free((void *)(uintptr_t)surface->corner_normals);
    free((void *)(uintptr_t)surface->mesh.face_starts);
    *surface = (norma_surface){.corner_normals = NULL};
}

/* ---- comparing */

static size_t end_of_name(const compared_scene *scene, size_t first) {
    size_t end = first + 1;
    while (end < scene->count && strcmp(scene->pieces[end].name, scene->pieces[first].name) == 0)
        ++end;
    return end;
}

/* named: the first piece of BASE of that name; its count where there are none. */
static norma_result compare_group(compared_pair *pair, compared_group *group, size_t named,
    const norma_surface *whole_base, double max_rad, const norma_options *options) {
    const compared_piece *first = &pair->other.pieces[group->first],
                         *last = &pair->other.pieces[group->end - 1];
    const size_t corners = last->first_corner + last->corners - first->first_corner;
    norma_surface base = *whole_base, other;
    group->named = named < pair->base.count;
    norma_result result = NORMA_OK;
    if (group->named &&
        !compared_surface_make(&pair->base, named, end_of_name(&pair->base, named), &base))
        result = NORMA_ERROR_MEMORY;
    if (!compared_surface_make(&pair->other, group->first, group->end, &other))
        result = NORMA_ERROR_MEMORY;
    if (!result)
        result = norma_compare(&base, &other, options, pair->samples + first->first_corner, corners,
            &group->same_faces);
    if (!result)
        result = norma_compare_summary(
            pair->samples + first->first_corner, corners, max_rad, options, &group->sum);
    if (group->named) compared_surface_free(&base);
    compared_surface_free(&other);
    return result;
}

static norma_result compare_groups(
    compared_pair *pair, double max_rad, const norma_options *options) {
    const compared_piece *last = &pair->other.pieces[pair->other.count - 1];
    norma_surface whole;
    norma_result result = NORMA_OK;
    pair->corners = last->first_corner + last->corners;
    pair->samples = malloc((pair->corners + 1) * sizeof *pair->samples);
    pair->groups = calloc(pair->other.count, sizeof *pair->groups);
    if (!compared_surface_make(&pair->base, 0, pair->base.count, &whole) || !pair->samples ||
        !pair->groups)
        result = NORMA_ERROR_MEMORY;
    for (size_t i = 0, base = 0; i < pair->other.count && !result;) {
        compared_group *group = &pair->groups[pair->group_count++];
        group->first = i;
        group->end = i = end_of_name(&pair->other, i);
        const char *name = pair->other.pieces[group->first].name;
        int order = -1; /* of names, in which both are sorted */
        while (base < pair->base.count && (order = strcmp(pair->base.pieces[base].name, name)) < 0)
            ++base;
        result = compare_group(
            pair, group, name[0] && !order ? base : pair->base.count, &whole, max_rad, options);
    }
    compared_surface_free(&whole);
    if (result || pair->group_count == 1) {
        pair->all = pair->groups ? pair->groups->sum : pair->all;
        return result;
    }
    return norma_compare_summary(pair->samples, pair->corners, max_rad, options, &pair->all);
}

norma_document_result compared_pair_measure(compared_pair *pair, double max_rad,
    const norma_options *options, norma_document_error *error) {
    const norma_result compared = compare_groups(pair, max_rad, options);
    if (!compared && pair->all.area > 0) return error->result = NORMA_DOCUMENT_OK;
    if (!compared)
        return fail_compared(&pair->other, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
            "nothing can be compared: no face has an area");
    snprintf(error->message, sizeof error->message, "%.800s: cannot be compared: %s",
        pair->other.name,
        compared == NORMA_ERROR_OVERFLOW
            ? "too many triangles are equally far from its corners, so comparing them would take "
              "too long"
            : norma_result_text(compared));
    return error->result = compared == NORMA_ERROR_MEMORY ? NORMA_DOCUMENT_ERROR_MEMORY
                                                          : NORMA_DOCUMENT_ERROR_MALFORMED;
}

void compared_pair_close(compared_pair *pair) {
    free(pair->samples);
    free(pair->groups);
    close_scene(&pair->base);
    close_scene(&pair->other);
    pair->samples = NULL;
    pair->groups = NULL;
    pair->group_count = 0;
}

const char *compared_way(const compared_pair *pair) {
    size_t same = 0;
    for (size_t i = 0; i < pair->group_count; ++i) same += pair->groups[i].same_faces != 0;
    return same == pair->group_count ? "corners" : same ? "mixed" : "nearest";
}
