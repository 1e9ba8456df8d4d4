/* acid_scene.c: the acid scenes: cells in a grid, cameras, lights, marks and labels. */
#include "acid/acid_scene.h"
#include "acid/acid_glb.h"
#include "acid/acid_labels.h"
#include <stdio.h>
#include <stdlib.h>

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

/* The grid whose picture is smallest, so that patches are largest. */
static acid_grid fit_grid(size_t first, size_t count) {
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

acid_grid acid_grid_of_all(void) { return fit_grid(0, acid_cell_count); }
acid_grid acid_grid_of_one(size_t cell) { return fit_grid(cell, 1); }

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

static acid_region region_of(
    const acid_grid *grid, double x, double y, double width, double height) {
    return (acid_region){{0.5 + x / grid->width, 0.5 - y / grid->height},
        {width / grid->width, height / grid->height}};
}

acid_region acid_slot_region(const acid_grid *grid, size_t index, size_t slot) {
    const acid_vector c = slot_center(grid, index, slot);
    return region_of(grid, c.x, c.y, 2 * ACID_HALF, 2 * ACID_HALF);
}

/* Clockwise from the upper left. */
static void mark_center(const acid_grid *grid, size_t mark, double center[2]) {
    const double from_rim = grid->width * (mark_inset + mark_side / 2);
    center[0] = (grid->width / 2 - from_rim) * (mark == 1 || mark == 2 ? 1 : -1);
    center[1] = (grid->height / 2 - from_rim) * (mark < 2 ? 1 : -1);
}

acid_region acid_mark_region(const acid_grid *grid, size_t mark) {
    double center[2];
    mark_center(grid, mark, center);
    return region_of(grid, center[0], center[1], mark_side * grid->width, mark_side * grid->width);
}

/* ---- nodes */

typedef struct acid_making {
    acid_glb glb;
    const acid_grid *grid;
    image_result result;
} acid_making;

static void print_xyz(growing_bytes *to, const char *name, acid_vector v) {
    const double numbers[3] = {v.x, v.y, v.z};
    acid_print(to, ",");
    acid_print_numbers(to, name, numbers, 3);
}

static void print_step(growing_bytes *to, const acid_step *step) {
    double unit[4];
    acid_step_rotation(step, unit);
    if (acid_has_turn(step)) {
        acid_print(to, ",");
        acid_print_numbers(to, "rotation", unit, 4);
    }
    acid_print(to, ",");
    acid_print_numbers(to, "scale", step->scale, 3);
}

/* Begins a node; the caller ends it. */
static size_t begin_node(acid_making *making, const char *name, const char *what) {
    return acid_add(&making->glb.nodes, "{\"name\":\"%s %s\"", name, what);
}

static void end_node(acid_making *making) { acid_print(&making->glb.nodes.text, "}"); }

static void add_scene_root(acid_making *making, size_t node) {
    acid_add(&making->glb.roots, "%zu", node);
}

/* ---- materials: 0 is white, and so are those of subjects that need something more */

static size_t add_material(
    acid_making *making, const char *name, double white, int double_sided, const char *more) {
    const double color[4] = {white, white, white, 1};
    acid_list *materials = &making->glb.materials;
    const size_t material =
        acid_add(materials, "{\"name\":\"%s\",\"pbrMetallicRoughness\":{", name);
    acid_print_numbers(&materials->text, "baseColorFactor", color, 4);
    acid_print(&materials->text, ",\"metallicFactor\":0,\"roughnessFactor\":1}%s%s}",
        double_sided ? ",\"doubleSided\":true" : "", more);
    return material;
}

static size_t add_unlit(acid_making *making, const char *name, const double color[4]) {
    acid_list *materials = &making->glb.materials;
    const size_t material =
        acid_add(materials, "{\"name\":\"%s\",\"pbrMetallicRoughness\":{", name);
    acid_print_numbers(&materials->text, "baseColorFactor", color, 4);
    acid_print(&materials->text, ",\"metallicFactor\":0,\"roughnessFactor\":1},\"extensions\":{"
                                 "\"KHR_materials_unlit\":{}}}");
    return material;
}

static size_t add_map(acid_making *making, const acid_patch *patch) {
    growing_bytes png = {0};
    const image_result result = norma_image_write(patch->texels, patch->columns, patch->rows, &png);
    if (result && !making->result) making->result = result;
    const size_t texture = acid_add_texture(&making->glb, png.data, png.size);
    free(png.data);
    return texture;
}

static size_t subject_material(
    acid_making *making, const acid_cell *cell, const acid_patch *patch) {
    char more[128] = "";
    if (cell->map) {
        const size_t texture = add_map(making, patch);
        if (cell->normal_scale > 0)
            snprintf(more, sizeof more, ",\"normalTexture\":{\"index\":%zu,\"scale\":%g}", texture,
                cell->normal_scale);
        else
            snprintf(more, sizeof more, ",\"normalTexture\":{\"index\":%zu}", texture);
    } else if (!cell->double_sided && !(cell->white > 0)) {
        return 0;
    }
    return add_material(making, cell->id, acid_white(cell), cell->double_sided, more);
}

static size_t reference_material(acid_making *making, const acid_cell *cell, acid_fault fault) {
    static const double black[4] = {0, 0, 0, 1};
    if (fault == ACID_LOST) return add_unlit(making, "black", black);
    if (fault == ACID_NOT_NORMALIZED || !(cell->white > 0)) return 0;
    return add_material(making, cell->id, cell->white, 0, "");
}

/* ---- meshes */

enum { VERTEX_FLOATS = sizeof(acid_vertex) / sizeof(float) };

static size_t add_attribute(
    acid_making *making, const acid_patch *patch, const float *first, size_t width, int bounds) {
    return acid_add_floats(&making->glb, first, VERTEX_FLOATS, patch->vertex_count, width, bounds);
}

static void add_attributes(acid_making *making, const acid_cell *cell, const acid_patch *patch) {
    const acid_vertex *v = patch->vertices;
    growing_bytes *to = &making->glb.meshes.text;
    if (cell->way == ACID_BYTES) {
        const size_t position =
            acid_add_bytes(&making->glb, v->position, VERTEX_FLOATS, patch->vertex_count, 1, 1);
        acid_print(to, "\"POSITION\":%zu,\"NORMAL\":%zu", position,
            acid_add_bytes(&making->glb, v->normal, VERTEX_FLOATS, patch->vertex_count, 127, 0));
        return;
    }
    acid_print(to, "\"POSITION\":%zu", add_attribute(making, patch, v->position, 3, 1));
    if (cell->way != ACID_FLAT)
        acid_print(to, ",\"NORMAL\":%zu", add_attribute(making, patch, v->normal, 3, 0));
    if (cell->map == ACID_MAP_WITH_TANGENTS)
        acid_print(to, ",\"TANGENT\":%zu", add_attribute(making, patch, v->tangent, 4, 0));
    if (cell->map) acid_print(to, ",\"TEXCOORD_0\":%zu", add_attribute(making, patch, v->uv, 2, 0));
    if (cell->way == ACID_SKIN)
        acid_print(to, ",\"JOINTS_0\":%zu,\"WEIGHTS_0\":%zu",
            acid_add_joints(&making->glb, patch->vertex_count, (size_t)cell->step_count),
            add_attribute(making, patch, v->weights, 4, 0));
}

static size_t add_subject_mesh(
    acid_making *making, const acid_cell *cell, const acid_patch *patch) {
    const size_t material = subject_material(making, cell, patch);
    acid_list *meshes = &making->glb.meshes;
    const size_t mesh =
        acid_add(meshes, "{\"name\":\"%s subject\",\"primitives\":[{\"attributes\":{", cell->id);
    add_attributes(making, cell, patch);
    acid_print(&meshes->text, "},\"indices\":%zu,\"material\":%zu",
        acid_add_indices(&making->glb, patch->indices, patch->index_count), material);
    if (cell->way == ACID_MORPH)
        acid_print(&meshes->text,
            ",\"targets\":[{\"POSITION\":%zu,\"NORMAL\":%zu}]}],\"weights\":[0.7]}",
            add_attribute(making, patch, patch->vertices->moved, 3, 1),
            add_attribute(making, patch, patch->vertices->turned, 3, 0));
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

static void add_reference(acid_making *making, const acid_cell *cell, const acid_patch *subject,
    acid_fault fault, acid_vector center) {
    acid_patch patch;
    const char *id = acid_fault_id(fault);
    if (!acid_make_reference(cell, subject, fault, &patch)) {
        making->glb.failed = 1;
        return;
    }
    move_patch(&patch, center);
    const size_t material = reference_material(making, cell, fault);
    acid_list *meshes = &making->glb.meshes;
    const size_t mesh =
        acid_add(meshes, "{\"name\":\"%s %s\",\"primitives\":[{\"attributes\":{", cell->id, id);
    acid_print(&meshes->text, "\"POSITION\":%zu,\"NORMAL\":%zu",
        add_attribute(making, &patch, patch.vertices->position, 3, 1),
        add_attribute(making, &patch, patch.vertices->normal, 3, 0));
    if (patch.has_color)
        acid_print(&meshes->text, ",\"COLOR_0\":%zu",
            add_attribute(making, &patch, patch.vertices->color, 3, 0));
    acid_print(&meshes->text, "},\"indices\":%zu,\"material\":%zu}]}",
        acid_add_indices(&making->glb, patch.indices, patch.index_count), material);
    add_scene_root(making, begin_node(making, cell->id, id));
    acid_print(&making->glb.nodes.text, ",\"mesh\":%zu", mesh);
    end_node(making);
    acid_free_patch(&patch);
}

/* ---- subjects in their places */

static void place_by_nodes(
    acid_making *making, const acid_cell *cell, size_t mesh, acid_vector center) {
    growing_bytes *nodes = &making->glb.nodes.text;
    const size_t root = begin_node(making, cell->id, cell->step_count > 1 ? "parent" : "subject");
    add_scene_root(making, root);
    print_xyz(nodes, "translation", center);
    if (cell->step_count) print_step(nodes, &cell->steps[0]);
    if (cell->step_count > 1) {
        acid_print(nodes, ",\"children\":[%zu]", root + 1);
        end_node(making);
        begin_node(making, cell->id, "subject");
        print_step(nodes, &cell->steps[1]);
    }
    acid_print(nodes, ",\"mesh\":%zu", mesh);
    end_node(making);
}

/* The instance beside the subject, which is the last slot's, is the first. */
static void place_by_instances(
    acid_making *making, const acid_cell *cell, size_t mesh, acid_vector center) {
    const float beside = (float)(slot_pitch * (double)(acid_slot_count(cell) - 1));
    float translations[2][3] = {{beside, 0, 0}, {0, 0, 0}}, rotations[2][4], scales[2][3];
    growing_bytes *nodes = &making->glb.nodes.text;
    for (int i = 0; i < 2; ++i) {
        const acid_step *step = &cell->steps[1 - i];
        double unit[4];
        acid_step_rotation(step, unit);
        for (int k = 0; k < 4; ++k) rotations[i][k] = (float)unit[k];
        for (int k = 0; k < 3; ++k) scales[i][k] = (float)step->scale[k];
    }
    acid_use_extension(&making->glb, "EXT_mesh_gpu_instancing", 0);
    add_scene_root(making, begin_node(making, cell->id, "subject"));
    print_xyz(nodes, "translation", center);
    acid_print(nodes,
        ",\"mesh\":%zu,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{"
        "\"TRANSLATION\":%zu,\"ROTATION\":%zu,\"SCALE\":%zu}}}",
        mesh, acid_add_floats(&making->glb, translations[0], 3, 2, 3, 0),
        acid_add_floats(&making->glb, rotations[0], 4, 2, 4, 0),
        acid_add_floats(&making->glb, scales[0], 3, 2, 3, 0));
    end_node(making);
}

static void place_by_skin(
    acid_making *making, const acid_cell *cell, size_t mesh, acid_vector center) {
    acid_glb *glb = &making->glb;
    growing_bytes *nodes = &glb->nodes.text;
    const size_t joints = (size_t)cell->step_count,
                 skin = acid_add(&glb->skins, "{\"inverseBindMatrices\":%zu,\"joints\":[",
                     acid_add_identities(glb, joints)),
                 root = begin_node(making, cell->id, "joints");
    add_scene_root(making, root);
    print_xyz(nodes, "translation", center);
    acid_print(
        nodes, joints > 1 ? ",\"children\":[%zu,%zu]" : ",\"children\":[%zu]", root + 1, root + 2);
    end_node(making);
    for (size_t i = 0; i < joints; ++i) {
        begin_node(making, cell->id, i ? "joint 2" : "joint");
        print_step(nodes, &cell->steps[i]);
        end_node(making);
        acid_print(&glb->skins.text, "%s%zu", i ? "," : "", root + 1 + i);
    }
    acid_print(&glb->skins.text, "]}");
    add_scene_root(making, begin_node(making, cell->id, "subject"));
    if (cell->own.scale[0] != 0) print_step(nodes, &cell->own);
    acid_print(nodes, ",\"mesh\":%zu,\"skin\":%zu", mesh, skin);
    end_node(making);
}

static void place_subject(
    acid_making *making, const acid_cell *cell, const acid_patch *patch, acid_vector center) {
    if (cell->way == ACID_BYTES) acid_use_extension(&making->glb, "KHR_mesh_quantization", 1);
    const size_t mesh = add_subject_mesh(making, cell, patch);
    if (cell->way == ACID_INSTANCE)
        place_by_instances(making, cell, mesh, center);
    else if (cell->way == ACID_SKIN)
        place_by_skin(making, cell, mesh, center);
    else
        place_by_nodes(making, cell, mesh, center);
}

/* ---- words */

/* colors: three for each vertex, or NULL. */
static void add_shape(acid_making *making, const char *name, const char *what, size_t material,
    const acid_ink *ink, const float *colors) {
    acid_glb *glb = &making->glb;
    const size_t count = 4 * ink->strokes;
    const size_t mesh = acid_add(&glb->meshes,
        "{\"name\":\"%s %s\",\"primitives\":[{\"attributes\":{\"POSITION\":%zu", name, what,
        acid_add_floats(glb, ink->positions, 3, count, 3, 1));
    if (colors)
        acid_print(
            &glb->meshes.text, ",\"COLOR_0\":%zu", acid_add_floats(glb, colors, 3, count, 3, 0));
    acid_print(&glb->meshes.text, "},\"indices\":%zu,\"material\":%zu}]}",
        acid_add_indices(glb, ink->indices, 6 * ink->strokes), material);
    add_scene_root(making, begin_node(making, name, what));
    acid_print(&glb->nodes.text, ",\"mesh\":%zu", mesh);
    end_node(making);
}

static void label_cell(acid_making *making, size_t index, size_t material) {
    const acid_cell *cell = &acid_cells[index];
    acid_ink ink = {0};
    const double size = 0.072;
    for (size_t slot = 0; slot < acid_slot_count(cell); ++slot) {
        const acid_vector c = slot_center(making->grid, index, slot);
        const double left = c.x - ACID_HALF, below = c.y - ACID_HALF - 1.35 * size;
        const size_t references = 1 + acid_fault_count(cell);
        const char *words =
            slot == ACID_SUBJECT_SLOT ? "subject"
            : slot <= references
                ? acid_fault_id(slot == ACID_RIGHT_SLOT ? ACID_RIGHT
                                                        : cell->faults[slot - ACID_RIGHT_SLOT - 1])
                : "neighbour";
        if (slot == ACID_SUBJECT_SLOT)
            acid_write_words(&ink, cell->id, left, c.y + ACID_HALF + 0.05, 0.105);
        acid_write_lines(&ink, words, left, below, size, 0.97);
    }
    if (ink.failed)
        making->glb.failed = 1;
    else
        add_shape(making, cell->id, "labels", material, &ink, NULL);
    acid_free_ink(&ink);
}

/* ---- what frames and lights them */

/* Coloured by their vertices as well, for renderers that draw clay. */
static void add_marks(acid_making *making) {
    static const double colors[4][4] = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}, {1, 1, 0, 1}};
    const double half = mark_side * making->grid->width / 2;
    for (size_t mark = 0; mark < 4; ++mark) {
        double center[2];
        float positions[12], vertex_colors[12];
        uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
        mark_center(making->grid, mark, center);
        for (size_t i = 0; i < 4; ++i) {
            positions[3 * i] = (float)(center[0] + (i == 1 || i == 2 ? half : -half));
            positions[3 * i + 1] = (float)(center[1] + (i > 1 ? half : -half));
            positions[3 * i + 2] = 0;
            for (size_t k = 0; k < 3; ++k) vertex_colors[3 * i + k] = (float)colors[mark][k];
        }
        const acid_ink square = {.positions = positions, .indices = indices, .strokes = 1};
        add_shape(making, "mark", acid_mark_colors[mark],
            add_unlit(making, acid_mark_colors[mark], colors[mark]), &square, vertex_colors);
    }
}

/* 1 / tan(1 degree), and 2 degrees in radians: the far camera sees as much as the other one. */
static const double far_distance = 57.289961630759424, far_angle = 0.034906585039886592;

static void add_cameras(acid_making *making, growing_bytes *more) {
    const double half[2] = {making->grid->width / 2, making->grid->height / 2};
    acid_print(more, "\"cameras\":[{\"name\":\"norma-acid\",\"type\":\"orthographic\","
                     "\"orthographic\":{");
    acid_print_number(more, "xmag", half[0]);
    acid_print(more, ",");
    acid_print_number(more, "ymag", half[1]);
    acid_print(more, ",\"znear\":0.1,\"zfar\":20}},{\"name\":\"norma-acid-far\",\"type\":"
                     "\"perspective\",\"perspective\":{\"aspectRatio\":1.3333333333333333,");
    acid_print_number(more, "yfov", far_angle);
    acid_print(more, ",");
    const double distance = far_distance * half[1];
    acid_print_number(more, "znear", distance - 10);
    acid_print(more, ",");
    acid_print_number(more, "zfar", distance + 10);
    acid_print(more, "}}],\n");
    /* Their nodes have no names, and the scene has another one: loaders that make names unique
     * would rename the cameras. */
    for (int i = 0; i < 2; ++i) {
        add_scene_root(making, acid_add(&making->glb.nodes, "{\"camera\":%d", i));
        print_xyz(&making->glb.nodes.text, "translation", (acid_vector){0, 0, i ? distance : 10});
        end_node(making);
    }
}

/* A light shines along its node's -z: the turn of +z to where it stands. */
static void add_lights(acid_making *making, growing_bytes *more) {
    static const char *const colors[ACID_LIGHTS] = {"1,0,0", "0,1,0", "0,0,1"};
    acid_use_extension(&making->glb, "KHR_lights_punctual", 0);
    acid_print(more, "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[");
    for (int i = 0; i < ACID_LIGHTS; ++i) {
        const acid_vector l = acid_lights[i];
        const acid_step turn = {{1, 1, 1}, {-l.y, l.x, 0, 1 + l.z}};
        double unit[4];
        acid_print(more, "%s{\"type\":\"directional\",\"color\":[%s],\"intensity\":2.8}",
            i ? "," : "", colors[i]);
        acid_step_rotation(&turn, unit);
        add_scene_root(making, begin_node(making, "light", acid_mark_colors[i]));
        acid_print(&making->glb.nodes.text, ",");
        acid_print_numbers(&making->glb.nodes.text, "rotation", unit, 4);
        acid_print(
            &making->glb.nodes.text, ",\"extensions\":{\"KHR_lights_punctual\":{\"light\":%d}}", i);
        end_node(making);
    }
    acid_print(more, "]}},\n");
}

/* ---- the whole */

static void add_cell(acid_making *making, size_t index, size_t ink) {
    const acid_cell *cell = &acid_cells[index];
    acid_patch subject;
    if (!acid_make_subject(cell, &subject)) {
        making->glb.failed = 1;
        return;
    }
    place_subject(making, cell, &subject, slot_center(making->grid, index, ACID_SUBJECT_SLOT));
    for (size_t i = 0; i <= acid_fault_count(cell); ++i)
        add_reference(making, cell, &subject, i ? cell->faults[i - 1] : ACID_RIGHT,
            slot_center(making->grid, index, ACID_RIGHT_SLOT + i));
    label_cell(making, index, ink);
    acid_free_patch(&subject);
}

image_result acid_write_scene(const acid_grid *grid, growing_bytes *file) {
    static const double grey[4] = {0.4, 0.4, 0.4, 1};
    acid_making making = {.grid = grid};
    growing_bytes more = {0};
    acid_use_extension(&making.glb, "KHR_materials_unlit", 0);
    add_material(&making, "white", 1, 0, "");
    add_cameras(&making, &more);
    add_lights(&making, &more);
    add_marks(&making);
    const size_t ink = add_unlit(&making, "ink", grey);
    for (size_t i = 0; i < grid->count; ++i) add_cell(&making, grid->first + i, ink);
    const int finished = acid_finish(&making.glb, &more, file);
    free(more.data);
    return making.result ? making.result : finished ? IMAGE_OK : IMAGE_MEMORY;
}
