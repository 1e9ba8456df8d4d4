/* scene.c: the acid scenes, cells in a grid, cameras, lights, marks and labels, as GLB files
 * (version 2 of Khronos's specification: a JSON chunk and a binary one). */
#include "acid/acid.h"
#include "io/text/text.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- a GLB file that grows by meshes, nodes and materials */

typedef struct acid_list { /* the elements of an array of the JSON */
    growing_bytes text;
    size_t count;
} acid_list;

typedef struct acid_glb {
    growing_bytes binary;
    acid_list views, accessors, meshes, materials, nodes, roots, skins, images, textures, used,
        required;
    int failed; /* out of memory */
    const acid_grid *grid;
    image_result result; /* of normal maps */
} acid_glb;

#if defined(__GNUC__)
#define ACID_FORMAT __attribute__((format(printf, 2, 3)))
#else
#define ACID_FORMAT
#endif

/* ---- text */

static void print_list(growing_bytes *to, const char *format, va_list arguments) {
    char text[512];
    const int length = vsnprintf(text, sizeof text, format, arguments);
    if (length < 0 || (size_t)length >= sizeof text)
        to->failed = 1;
    else
        norma_io_append(to, text, (size_t)length);
}

ACID_FORMAT static void acid_print(growing_bytes *to, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    print_list(to, format, arguments);
    va_end(arguments);
}

/* The beginning of an element, whose number it returns. */
ACID_FORMAT static size_t acid_add(acid_list *list, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    if (list->count) norma_io_append(&list->text, ",\n", 2);
    print_list(&list->text, format, arguments);
    va_end(arguments);
    return list->count++;
}

/* The shortest text that reads back as the same. */
static void print_number(growing_bytes *to, const char *before, double number) {
    char text[32];
    norma_number_format_double(number + 0.0, text);
    acid_print(to, "%s%s", before, text);
}

/* before: the array's name, quoted, with all that stands before it. */
static void print_numbers(
    growing_bytes *to, const char *before, const double *numbers, size_t count) {
    acid_print(to, "%s:[", before);
    for (size_t i = 0; i < count; ++i) print_number(to, i ? "," : "", numbers[i]);
    acid_print(to, "]");
}

/* ---- binary */

static void append_little_endian(growing_bytes *to, uint32_t value, int size) {
    unsigned char bytes[4];
    for (int i = 0; i < size; ++i) bytes[i] = (unsigned char)(value >> (8 * i));
    norma_io_append(to, bytes, (size_t)size);
}

static void append_float(growing_bytes *to, float value) {
    uint32_t bits;
    value += 0.0F; /* no -0 */
    memcpy(&bits, &value, sizeof bits);
    append_little_endian(to, bits, 4);
}

static void pad(growing_bytes *to, char with) {
    while (to->size % 4 && !to->failed) norma_io_append(to, &with, 1);
}

/* Of the bytes from start on. target 0: none. */
static size_t add_bytes_view(acid_glb *glb, size_t start, int stride, int target) {
    const size_t view = acid_add(&glb->views, "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu",
        start, glb->binary.size - start);
    if (stride) acid_print(&glb->views.text, ",\"byteStride\":%d", stride);
    if (target) acid_print(&glb->views.text, ",\"target\":%d", target);
    acid_print(&glb->views.text, "}");
    pad(&glb->binary, '\0');
    return view;
}

enum {
    VERTEX_DATA = 34962,
    INDEX_DATA = 34963,
    BYTE = 5120,
    UNSIGNED_BYTE = 5121,
    SHORT = 5123,
    FLOAT = 5126
};

static void print_extent(
    acid_glb *glb, const float *first, size_t stride, size_t count, size_t width) {
    double low[4] = {0}, high[4] = {0};
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < width; ++k) {
            const double value = (double)first[i * stride + k];
            low[k] = i && low[k] <= value ? low[k] : value;
            high[k] = i && high[k] >= value ? high[k] : value;
        }
    print_numbers(&glb->accessors.text, ",\"min\"", low, width);
    print_numbers(&glb->accessors.text, ",\"max\"", high, width);
}

/* Of the bytes from start on; what has bounds is printed behind it. */
static size_t begin_accessor(acid_glb *glb, size_t start, int target, int type, size_t count,
    const char *of, int is_normalized) {
    return acid_add(&glb->accessors,
        "{\"bufferView\":%zu,\"componentType\":%d,%s\"count\":%zu,\"type\":\"%s\"",
        add_bytes_view(glb, start, type == BYTE ? 4 : 0, target), type,
        is_normalized ? "\"normalized\":true," : "", count, of);
}

static size_t end_accessor(acid_glb *glb, size_t accessor) {
    acid_print(&glb->accessors.text, "}");
    return accessor;
}

static size_t add_floats(
    acid_glb *glb, const float *first, size_t stride, size_t count, size_t width, int has_bounds) {
    static const char *const types[] = {"", "", "VEC2", "VEC3", "VEC4"};
    const size_t start = glb->binary.size;
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < width; ++k) append_float(&glb->binary, first[i * stride + k]);
    const size_t accessor = begin_accessor(glb, start, VERTEX_DATA, FLOAT, count, types[width], 0);
    if (has_bounds) print_extent(glb, first, stride, count, width);
    return end_accessor(glb, accessor);
}

/* Three bytes and one to fill up. Normals are normalized, positions are not. */
static size_t add_bytes(
    acid_glb *glb, const float *first, size_t stride, size_t count, double scale, int is_position) {
    const size_t start = glb->binary.size;
    for (size_t i = 0; i < count; ++i) {
        uint32_t word = 0;
        for (size_t k = 0; k < 3; ++k) {
            const int value = (int)floor((double)first[i * stride + k] * scale + 0.5);
            word |= (uint32_t)(value & 255) << (8 * k);
        }
        append_little_endian(&glb->binary, word, 4);
    }
    const size_t accessor =
        begin_accessor(glb, start, VERTEX_DATA, BYTE, count, "VEC3", !is_position);
    if (is_position) print_extent(glb, first, stride, count, 3);
    return end_accessor(glb, accessor);
}

/* Of a skin: matrices of the identity. */
static size_t add_identities(acid_glb *glb, size_t joints) {
    const size_t start = glb->binary.size;
    for (size_t i = 0; i < 16 * joints; ++i) append_float(&glb->binary, i % 16 % 5 ? 0 : 1);
    return end_accessor(glb, begin_accessor(glb, start, 0, FLOAT, joints, "MAT4", 0));
}

/* Of vertices with this many joints. */
static size_t add_joint_numbers(acid_glb *glb, size_t count, size_t joints) {
    const size_t start = glb->binary.size;
    for (size_t i = 0; i < count; ++i)
        append_little_endian(&glb->binary, joints > 1 ? 1 << 8 : 0, 4);
    return end_accessor(
        glb, begin_accessor(glb, start, VERTEX_DATA, UNSIGNED_BYTE, count, "VEC4", 0));
}

static size_t add_indices(acid_glb *glb, const uint16_t *indices, size_t count) {
    const size_t start = glb->binary.size;
    for (size_t i = 0; i < count; ++i) append_little_endian(&glb->binary, indices[i], 2);
    return end_accessor(glb, begin_accessor(glb, start, INDEX_DATA, SHORT, count, "SCALAR", 0));
}

static void name_extension(acid_list *list, const char *name) {
    char quoted[64];
    const int length = snprintf(quoted, sizeof quoted, "\"%s\"", name);
    for (size_t at = 0; at + (size_t)length <= list->text.size; ++at)
        if (memcmp(list->text.data + at, quoted, (size_t)length) == 0) return;
    acid_add(list, "%s", quoted);
}

static void use_extension(acid_glb *glb, const char *name, int is_required) {
    name_extension(&glb->used, name);
    if (is_required) name_extension(&glb->required, name);
}

/* ---- the file */

static void print_array(growing_bytes *to, const char *name, acid_list *list) {
    if (list->count) {
        acid_print(to, "\"%s\":[", name);
        norma_io_append(to, list->text.data, list->text.size);
        acid_print(to, "],\n");
    }
    to->failed |= list->text.failed;
    free(list->text.data);
}

static void print_document(acid_glb *glb, const growing_bytes *more, growing_bytes *text) {
    acid_print(text, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"norma acid\"},\n");
    print_array(text, "extensionsUsed", &glb->used);
    print_array(text, "extensionsRequired", &glb->required);
    if (glb->textures.count)
        acid_print(text, "\"samplers\":[{\"magFilter\":9729,\"minFilter\":9729,\"wrapS\":33071,"
                         "\"wrapT\":33071}],\n");
    norma_io_append(text, more->data, more->size);
    acid_print(text, "\"scene\":0,\n\"scenes\":[{\"name\":\"acid\",\"nodes\":[");
    norma_io_append(text, glb->roots.text.data, glb->roots.text.size);
    text->failed |= glb->roots.text.failed | more->failed;
    acid_print(text, "]}],\n");
    free(glb->roots.text.data);
    print_array(text, "nodes", &glb->nodes);
    print_array(text, "meshes", &glb->meshes);
    print_array(text, "skins", &glb->skins);
    print_array(text, "materials", &glb->materials);
    print_array(text, "textures", &glb->textures);
    print_array(text, "images", &glb->images);
    print_array(text, "accessors", &glb->accessors);
    print_array(text, "bufferViews", &glb->views);
    acid_print(text, "\"buffers\":[{\"byteLength\":%zu}]}", glb->binary.size);
    pad(text, ' ');
}

static image_result finish_glb(acid_glb *glb, const growing_bytes *more, growing_bytes *file) {
    growing_bytes text = {0};
    print_document(glb, more, &text);
    const size_t total = 12 + 8 + text.size + 8 + glb->binary.size;
    append_little_endian(file, 0x46546C67, 4);
    append_little_endian(file, 2, 4);
    append_little_endian(file, (uint32_t)total, 4);
    append_little_endian(file, (uint32_t)text.size, 4);
    append_little_endian(file, 0x4E4F534A, 4);
    norma_io_append(file, text.data, text.size);
    append_little_endian(file, (uint32_t)glb->binary.size, 4);
    append_little_endian(file, 0x004E4942, 4);
    norma_io_append(file, glb->binary.data, glb->binary.size);
    const int failed = glb->failed || glb->binary.failed || text.failed || file->failed;
    free(glb->binary.data);
    free(text.data);
    return glb->result ? glb->result : failed ? IMAGE_MEMORY : IMAGE_OK;
}

/* ---- layout: everything has its size in metres; the picture's follows */

static const double slot_pitch = 1.04, cell_height = 1.33, title_height = 0.2;
/* Shares of the picture's width: a mark's side, its distance from the rim, and what is left free
 * above and below for them, and left and right. */
static const double mark_side = 0.03125, mark_inset = 0.00625, free_rows = 0.0405,
                    free_columns = 0.0125;
const char *const acid_mark_colors[4] = {"red", "green", "blue", "yellow"};

size_t acid_slot_count(const acid_cell *cell) {
    return 2 + acid_fault_count(cell) + (cell->way == ACID_INSTANCE);
}

static double width_needed(size_t columns, size_t rows, size_t slots) {
    const double by_columns = (double)columns * (double)slots * slot_pitch / (1 - 2 * free_columns),
                 by_rows = (double)rows * cell_height / (0.75 - 2 * free_rows);
    return by_columns > by_rows ? by_columns : by_rows;
}

acid_grid acid_grid_of(size_t first, size_t count) {
    acid_grid grid = {.first = first, .count = count};
    for (size_t i = first; i < first + count; ++i) {
        const size_t slots = acid_slot_count(&acid_cells[i]);
        grid.slots = slots > grid.slots ? slots : grid.slots;
    }
    for (size_t columns = 1; columns <= count; ++columns) {
        const size_t rows = (count + columns - 1) / columns;
        const double width = width_needed(columns, rows, grid.slots);
        if (columns > 1 && width >= grid.width) continue;
        grid.columns = columns;
        grid.rows = rows;
        grid.width = width;
        grid.height = 0.75 * width;
    }
    return grid;
}

/* The upper left corner of a cell, the picture's centre being (0, 0), y upwards. */
static void cell_corner(const acid_grid *grid, size_t index, double corner[2]) {
    const size_t at = index - grid->first, column = at % grid->columns, row = at / grid->columns;
    const double across = grid->width * (1 - 2 * free_columns) / (double)grid->columns,
                 down = (grid->height - 2 * free_rows * grid->width) / (double)grid->rows;
    corner[0] = grid->width * (free_columns - 0.5) + across * (double)column +
                (across - (double)grid->slots * slot_pitch) / 2;
    corner[1] =
        grid->height / 2 - free_rows * grid->width - down * (double)row - (down - cell_height) / 2;
}

static acid_vector slot_center(const acid_grid *grid, size_t index, size_t slot) {
    double corner[2];
    cell_corner(grid, index, corner);
    return (acid_vector){
        corner[0] + slot_pitch * ((double)slot + 0.5), corner[1] - title_height - ACID_HALF, 0};
}

static acid_box grid_box(const acid_grid *grid, double x, double y, double width, double height) {
    return (acid_box){{0.5 + x / grid->width, 0.5 - y / grid->height},
        {width / grid->width, height / grid->height}};
}

acid_box acid_slot_box(const acid_grid *grid, size_t index, size_t slot) {
    const acid_vector c = slot_center(grid, index, slot);
    return grid_box(grid, c.x, c.y, 2 * ACID_HALF, 2 * ACID_HALF);
}

/* Clockwise from the upper left. */
static void mark_center(const acid_grid *grid, size_t mark, double center[2]) {
    const double from_rim = grid->width * (mark_inset + mark_side / 2);
    center[0] = (grid->width / 2 - from_rim) * (mark == 1 || mark == 2 ? 1 : -1);
    center[1] = (grid->height / 2 - from_rim) * (mark < 2 ? 1 : -1);
}

acid_box acid_mark_box(const acid_grid *grid, size_t mark) {
    double center[2];
    mark_center(grid, mark, center);
    return grid_box(grid, center[0], center[1], mark_side * grid->width, mark_side * grid->width);
}

/* ---- nodes */

static void print_translation(growing_bytes *to, acid_vector v) {
    const double numbers[3] = {v.x, v.y, v.z};
    print_numbers(to, ",\"translation\"", numbers, 3);
}

static void print_step(growing_bytes *to, const acid_step *step) {
    double unit[4];
    acid_step_rotation(step, unit);
    if (step->turn[0] != 0 || step->turn[1] != 0 || step->turn[2] != 0)
        print_numbers(to, ",\"rotation\"", unit, 4);
    print_numbers(to, ",\"scale\"", step->scale, 3);
}

/* Begins a node; the caller ends it. */
static size_t begin_node(acid_glb *glb, const char *name, const char *what) {
    return acid_add(&glb->nodes, "{\"name\":\"%s %s\"", name, what);
}

static void end_node(acid_glb *glb) { acid_print(&glb->nodes.text, "}"); }

/* The same for a root of the scene. */
static size_t begin_root(acid_glb *glb, const char *name, const char *what) {
    const size_t node = begin_node(glb, name, what);
    acid_add(&glb->roots, "%zu", node);
    return node;
}

/* ---- materials: 0 is white, and so are those of subjects that need something more */

/* more: behind its colour. */
static size_t add_color(acid_glb *glb, const char *name, const double color[4], const char *more) {
    acid_list *materials = &glb->materials;
    const size_t material =
        acid_add(materials, "{\"name\":\"%s\",\"pbrMetallicRoughness\":{", name);
    print_numbers(&materials->text, "\"baseColorFactor\"", color, 4);
    acid_print(&materials->text, ",\"metallicFactor\":0,\"roughnessFactor\":1}%s}", more);
    return material;
}

static size_t add_unlit(acid_glb *glb, const char *name, const double color[4]) {
    return add_color(glb, name, color, ",\"extensions\":{\"KHR_materials_unlit\":{}}");
}

static size_t add_white(acid_glb *glb, const char *name, double white, const char *more) {
    const double color[4] = {white, white, white, 1};
    return add_color(glb, name, color, more);
}

/* The number of a texture, which interpolates between texels. */
static size_t add_map(acid_glb *glb, const acid_patch *patch) {
    growing_bytes png = {0};
    const image_result result = norma_image_write(patch->texels, patch->columns, patch->rows, &png);
    if (result && !glb->result) glb->result = result;
    const size_t start = glb->binary.size;
    norma_io_append(&glb->binary, png.data, png.size);
    free(png.data);
    const size_t view = add_bytes_view(glb, start, 0, 0),
                 image = acid_add(
                     &glb->images, "{\"bufferView\":%zu,\"mimeType\":\"image/png\"}", view);
    return acid_add(&glb->textures, "{\"sampler\":0,\"source\":%zu}", image);
}

static size_t subject_material(acid_glb *glb, const acid_cell *cell, const acid_patch *patch) {
    char map[96] = "", more[128];
    if (cell->map) {
        const size_t texture = add_map(glb, patch);
        if (cell->normal_scale > 0)
            snprintf(map, sizeof map, ",\"normalTexture\":{\"index\":%zu,\"scale\":%g}", texture,
                cell->normal_scale);
        else
            snprintf(map, sizeof map, ",\"normalTexture\":{\"index\":%zu}", texture);
    } else if (!cell->double_sided && !(cell->white > 0)) {
        return 0;
    }
    snprintf(more, sizeof more, "%s%s", cell->double_sided ? ",\"doubleSided\":true" : "", map);
    return add_white(glb, cell->id, acid_white(cell), more);
}

static size_t reference_material(acid_glb *glb, const acid_cell *cell, acid_fault fault) {
    static const double black[4] = {0, 0, 0, 1};
    if (fault == ACID_LOST) return add_unlit(glb, "black", black);
    if (fault == ACID_NOT_NORMALIZED || !(cell->white > 0)) return 0;
    return add_white(glb, cell->id, cell->white, "");
}

/* ---- meshes */

enum { VERTEX_FLOATS = sizeof(acid_vertex) / sizeof(float) };

static size_t add_attribute(
    acid_glb *glb, const acid_patch *patch, const float *first, size_t width, int bounds) {
    return add_floats(glb, first, VERTEX_FLOATS, patch->vertex_count, width, bounds);
}

static void add_attributes(acid_glb *glb, const acid_cell *cell, const acid_patch *patch) {
    const acid_vertex *v = patch->vertices;
    growing_bytes *to = &glb->meshes.text;
    if (cell->way == ACID_BYTES) {
        const size_t position =
            add_bytes(glb, v->position, VERTEX_FLOATS, patch->vertex_count, 1, 1);
        acid_print(to, "\"POSITION\":%zu,\"NORMAL\":%zu", position,
            add_bytes(glb, v->normal, VERTEX_FLOATS, patch->vertex_count, 127, 0));
        return;
    }
    acid_print(to, "\"POSITION\":%zu", add_attribute(glb, patch, v->position, 3, 1));
    if (cell->way != ACID_FLAT)
        acid_print(to, ",\"NORMAL\":%zu", add_attribute(glb, patch, v->normal, 3, 0));
    if (cell->map == ACID_MAP_WITH_TANGENTS)
        acid_print(to, ",\"TANGENT\":%zu", add_attribute(glb, patch, v->tangent, 4, 0));
    if (cell->map) acid_print(to, ",\"TEXCOORD_0\":%zu", add_attribute(glb, patch, v->uv, 2, 0));
    if (cell->way == ACID_SKIN)
        acid_print(to, ",\"JOINTS_0\":%zu,\"WEIGHTS_0\":%zu",
            add_joint_numbers(glb, patch->vertex_count, (size_t)cell->step_count),
            add_attribute(glb, patch, v->weights, 4, 0));
}

static size_t add_subject_mesh(acid_glb *glb, const acid_cell *cell, const acid_patch *patch) {
    const size_t material = subject_material(glb, cell, patch);
    acid_list *meshes = &glb->meshes;
    const size_t mesh =
        acid_add(meshes, "{\"name\":\"%s subject\",\"primitives\":[{\"attributes\":{", cell->id);
    add_attributes(glb, cell, patch);
    acid_print(&meshes->text, "},\"indices\":%zu,\"material\":%zu",
        add_indices(glb, patch->indices, patch->index_count), material);
    if (cell->way == ACID_MORPH)
        acid_print(&meshes->text,
            ",\"targets\":[{\"POSITION\":%zu,\"NORMAL\":%zu}]}],\"weights\":[0.7]}",
            add_attribute(glb, patch, patch->vertices->moved, 3, 1),
            add_attribute(glb, patch, patch->vertices->turned, 3, 0));
    else
        acid_print(&meshes->text, "}]}");
    return mesh;
}

static void move_patch(acid_patch *patch, acid_vector by) {
    for (size_t i = 0; i < patch->vertex_count; ++i) {
        float *p = patch->vertices[i].position;
        p[0] = (float)((double)p[0] + by.x);
        p[1] = (float)((double)p[1] + by.y);
        p[2] = (float)((double)p[2] + by.z);
    }
}

static void add_reference(acid_glb *glb, const acid_cell *cell, const acid_patch *subject,
    acid_fault fault, acid_vector center) {
    acid_patch patch;
    const char *id = acid_fault_id(fault);
    if (!acid_make_reference(cell, subject, fault, &patch)) {
        glb->failed = 1;
        return;
    }
    move_patch(&patch, center);
    const size_t material = reference_material(glb, cell, fault);
    acid_list *meshes = &glb->meshes;
    const size_t mesh =
        acid_add(meshes, "{\"name\":\"%s %s\",\"primitives\":[{\"attributes\":{", cell->id, id);
    acid_print(&meshes->text, "\"POSITION\":%zu,\"NORMAL\":%zu",
        add_attribute(glb, &patch, patch.vertices->position, 3, 1),
        add_attribute(glb, &patch, patch.vertices->normal, 3, 0));
    if (patch.has_color)
        acid_print(&meshes->text, ",\"COLOR_0\":%zu",
            add_attribute(glb, &patch, patch.vertices->color, 3, 0));
    acid_print(&meshes->text, "},\"indices\":%zu,\"material\":%zu}]}",
        add_indices(glb, patch.indices, patch.index_count), material);
    begin_root(glb, cell->id, id);
    acid_print(&glb->nodes.text, ",\"mesh\":%zu}", mesh);
    acid_free_patch(&patch);
}

/* ---- subjects in their places */

static void place_by_nodes(acid_glb *glb, const acid_cell *cell, size_t mesh, acid_vector center) {
    growing_bytes *nodes = &glb->nodes.text;
    const size_t root = begin_root(glb, cell->id, cell->step_count > 1 ? "parent" : "subject");
    print_translation(nodes, center);
    if (cell->step_count) print_step(nodes, &cell->steps[0]);
    if (cell->step_count > 1) {
        acid_print(nodes, ",\"children\":[%zu]", root + 1);
        end_node(glb);
        begin_node(glb, cell->id, "subject");
        print_step(nodes, &cell->steps[1]);
    }
    acid_print(nodes, ",\"mesh\":%zu}", mesh);
}

/* The instance beside the subject, which is the last slot's, is the first. */
static void place_by_instances(
    acid_glb *glb, const acid_cell *cell, size_t mesh, acid_vector center) {
    const float beside = (float)(slot_pitch * (double)(acid_slot_count(cell) - 1));
    float translations[2][3] = {{beside, 0, 0}, {0, 0, 0}}, rotations[2][4], scales[2][3];
    growing_bytes *nodes = &glb->nodes.text;
    for (int i = 0; i < 2; ++i) {
        const acid_step *step = &cell->steps[1 - i];
        double unit[4];
        acid_step_rotation(step, unit);
        for (int k = 0; k < 4; ++k) rotations[i][k] = (float)unit[k];
        for (int k = 0; k < 3; ++k) scales[i][k] = (float)step->scale[k];
    }
    use_extension(glb, "EXT_mesh_gpu_instancing", 0);
    begin_root(glb, cell->id, "subject");
    print_translation(nodes, center);
    acid_print(nodes,
        ",\"mesh\":%zu,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{"
        "\"TRANSLATION\":%zu,\"ROTATION\":%zu,\"SCALE\":%zu}}}}",
        mesh, add_floats(glb, translations[0], 3, 2, 3, 0),
        add_floats(glb, rotations[0], 4, 2, 4, 0), add_floats(glb, scales[0], 3, 2, 3, 0));
}

static void place_by_skin(acid_glb *glb, const acid_cell *cell, size_t mesh, acid_vector center) {
    growing_bytes *nodes = &glb->nodes.text;
    const size_t joints = (size_t)cell->step_count,
                 skin = acid_add(&glb->skins, "{\"inverseBindMatrices\":%zu,\"joints\":[",
                     add_identities(glb, joints)),
                 root = begin_root(glb, cell->id, "joints");
    print_translation(nodes, center);
    acid_print(
        nodes, joints > 1 ? ",\"children\":[%zu,%zu]" : ",\"children\":[%zu]", root + 1, root + 2);
    end_node(glb);
    for (size_t i = 0; i < joints; ++i) {
        begin_node(glb, cell->id, i ? "joint 2" : "joint");
        print_step(nodes, &cell->steps[i]);
        end_node(glb);
        acid_print(&glb->skins.text, "%s%zu", i ? "," : "", root + 1 + i);
    }
    acid_print(&glb->skins.text, "]}");
    begin_root(glb, cell->id, "subject");
    if (cell->own.scale[0] != 0) print_step(nodes, &cell->own);
    acid_print(nodes, ",\"mesh\":%zu,\"skin\":%zu}", mesh, skin);
}

static void place_subject(
    acid_glb *glb, const acid_cell *cell, const acid_patch *patch, acid_vector center) {
    if (cell->way == ACID_BYTES) use_extension(glb, "KHR_mesh_quantization", 1);
    const size_t mesh = add_subject_mesh(glb, cell, patch);
    if (cell->way == ACID_INSTANCE)
        place_by_instances(glb, cell, mesh, center);
    else if (cell->way == ACID_SKIN)
        place_by_skin(glb, cell, mesh, center);
    else
        place_by_nodes(glb, cell, mesh, center);
}

/* ---- words */

/* colors: three for each vertex, or NULL. */
static void add_shape(acid_glb *glb, const char *name, const char *what, size_t material,
    const acid_ink *ink, const float *colors) {
    const size_t count = 4 * ink->strokes;
    const size_t mesh = acid_add(&glb->meshes,
        "{\"name\":\"%s %s\",\"primitives\":[{\"attributes\":{\"POSITION\":%zu", name, what,
        add_floats(glb, ink->positions, 3, count, 3, 1));
    if (colors)
        acid_print(&glb->meshes.text, ",\"COLOR_0\":%zu", add_floats(glb, colors, 3, count, 3, 0));
    acid_print(&glb->meshes.text, "},\"indices\":%zu,\"material\":%zu}]}",
        add_indices(glb, ink->indices, 6 * ink->strokes), material);
    begin_root(glb, name, what);
    acid_print(&glb->nodes.text, ",\"mesh\":%zu}", mesh);
}

static void label_cell(acid_glb *glb, size_t index, size_t material) {
    const acid_cell *cell = &acid_cells[index];
    acid_ink ink = {0};
    const double size = 0.072;
    for (size_t slot = 0; slot < acid_slot_count(cell); ++slot) {
        const acid_vector c = slot_center(glb->grid, index, slot);
        const double left = c.x - ACID_HALF, below = c.y - ACID_HALF - 1.35 * size;
        const size_t references = 1 + acid_fault_count(cell);
        const char *words =
            slot == ACID_SUBJECT_SLOT ? "subject"
            : slot <= references
                ? acid_fault_id(slot == ACID_RIGHT_SLOT ? ACID_RIGHT
                                                        : cell->faults[slot - ACID_RIGHT_SLOT - 1])
                : "neighbour";
        if (slot == ACID_SUBJECT_SLOT)
            acid_write_lines(&ink, cell->id, left, c.y + ACID_HALF + 0.05, 0.105, INFINITY);
        acid_write_lines(&ink, words, left, below, size, 0.97);
    }
    if (ink.failed)
        glb->failed = 1;
    else
        add_shape(glb, cell->id, "labels", material, &ink, NULL);
    free(ink.positions);
    free(ink.indices);
}

/* ---- what frames and lights them */

/* Coloured by their vertices as well, for renderers that draw clay. */
static void add_marks(acid_glb *glb) {
    static const double colors[4][4] = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}, {1, 1, 0, 1}};
    const double half = mark_side * glb->grid->width / 2;
    for (size_t mark = 0; mark < 4; ++mark) {
        double center[2];
        float positions[12], vertex_colors[12];
        uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
        mark_center(glb->grid, mark, center);
        for (size_t i = 0; i < 4; ++i) {
            positions[3 * i] = (float)(center[0] + (i == 1 || i == 2 ? half : -half));
            positions[3 * i + 1] = (float)(center[1] + (i > 1 ? half : -half));
            positions[3 * i + 2] = 0;
            for (size_t k = 0; k < 3; ++k) vertex_colors[3 * i + k] = (float)colors[mark][k];
        }
        const acid_ink square = {.positions = positions, .indices = indices, .strokes = 1};
        add_shape(glb, "mark", acid_mark_colors[mark],
            add_unlit(glb, acid_mark_colors[mark], colors[mark]), &square, vertex_colors);
    }
}

/* 1 / tan(1 degree), and 2 degrees in radians: the far camera sees as much as the other one. */
static const double far_distance = 57.289961630759424, far_angle = 0.034906585039886592;

static void add_cameras(acid_glb *glb, growing_bytes *more) {
    const double half[2] = {glb->grid->width / 2, glb->grid->height / 2};
    acid_print(more, "\"cameras\":[{\"name\":\"norma-acid\",\"type\":\"orthographic\","
                     "\"orthographic\":{");
    print_number(more, "\"xmag\":", half[0]);
    print_number(more, ",\"ymag\":", half[1]);
    acid_print(more, ",\"znear\":0.1,\"zfar\":20}},{\"name\":\"norma-acid-far\",\"type\":"
                     "\"perspective\",\"perspective\":{\"aspectRatio\":1.3333333333333333,");
    const double distance = far_distance * half[1];
    print_number(more, "\"yfov\":", far_angle);
    print_number(more, ",\"znear\":", distance - 10);
    print_number(more, ",\"zfar\":", distance + 10);
    acid_print(more, "}}],\n");
    /* Their nodes have no names, and the scene has another one: loaders that make names unique
     * would rename the cameras. */
    for (int i = 0; i < 2; ++i) {
        acid_add(&glb->roots, "%zu", acid_add(&glb->nodes, "{\"camera\":%d", i));
        print_translation(&glb->nodes.text, (acid_vector){0, 0, i ? distance : 10});
        end_node(glb);
    }
}

/* A light shines along its node's -z: the turn of +z to where it stands. */
static void add_lights(acid_glb *glb, growing_bytes *more) {
    static const char *const colors[ACID_LIGHTS] = {"1,0,0", "0,1,0", "0,0,1"};
    use_extension(glb, "KHR_lights_punctual", 0);
    acid_print(more, "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[");
    for (int i = 0; i < ACID_LIGHTS; ++i) {
        const acid_vector l = acid_lights[i];
        const acid_step turn = {{1, 1, 1}, {-l.y, l.x, 0, 1 + l.z}};
        double unit[4];
        acid_print(more, "%s{\"type\":\"directional\",\"color\":[%s],\"intensity\":2.8}",
            i ? "," : "", colors[i]);
        acid_step_rotation(&turn, unit);
        begin_root(glb, "light", acid_mark_colors[i]);
        print_numbers(&glb->nodes.text, ",\"rotation\"", unit, 4);
        acid_print(
            &glb->nodes.text, ",\"extensions\":{\"KHR_lights_punctual\":{\"light\":%d}}}", i);
    }
    acid_print(more, "]}},\n");
}

/* ---- the whole */

static void add_cell(acid_glb *glb, size_t index, size_t ink) {
    const acid_cell *cell = &acid_cells[index];
    acid_patch subject;
    if (!acid_make_subject(cell, &subject)) {
        glb->failed = 1;
        return;
    }
    place_subject(glb, cell, &subject, slot_center(glb->grid, index, ACID_SUBJECT_SLOT));
    for (size_t i = 0; i <= acid_fault_count(cell); ++i)
        add_reference(glb, cell, &subject, i ? cell->faults[i - 1] : ACID_RIGHT,
            slot_center(glb->grid, index, ACID_RIGHT_SLOT + i));
    label_cell(glb, index, ink);
    acid_free_patch(&subject);
}

image_result acid_write_scene(const acid_grid *grid, growing_bytes *file) {
    static const double grey[4] = {0.4, 0.4, 0.4, 1};
    acid_glb glb = {.grid = grid};
    growing_bytes more = {0};
    use_extension(&glb, "KHR_materials_unlit", 0);
    add_white(&glb, "white", 1, "");
    add_cameras(&glb, &more);
    add_lights(&glb, &more);
    add_marks(&glb);
    const size_t ink = add_unlit(&glb, "ink", grey);
    for (size_t i = 0; i < grid->count; ++i) add_cell(&glb, grid->first + i, ink);
    const image_result result = finish_glb(&glb, &more, file);
    free(more.data);
    return result;
}
