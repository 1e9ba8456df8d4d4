/* acid_read_layout.c: acid.json: where the marks and the patches of an acid scene lie. */
#include "cli/acid/acid.h"
#include "cli/check/check.h"
#include "cli/process/process.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static int refuse_layout(const acid_work *work, const char *where, const char *expected) {
    cli_error("%s: %s: expected %s, as in acid.json of norma acid", work->scene, where, expected);
    return CLI_FILE;
}

/* ---- parts */

static int read_pair(cli_value pair, double to[2]) {
    return cli_elements(pair) == 2 && cli_number_of(cli_element(pair, 0), &to[0]) &&
           cli_number_of(cli_element(pair, 1), &to[1]);
}

static int is_sound_box(const acid_box *box) {
    for (int k = 0; k < 2; ++k)
        if (!(fabs(box->center[k]) <= 2 && box->size[k] > 1e-4 && box->size[k] <= 2)) return 0;
    return 1;
}

static int read_box(cli_value place, acid_box *box) {
    return read_pair(cli_get(place, "center"), box->center) &&
           read_pair(cli_get(place, "size"), box->size) && is_sound_box(box);
}

static int copy_id(cli_value id, char to[ACID_ID_ROOM]) {
    const char *text = cli_string(id);
    const size_t length = text ? strlen(text) : 0;
    if (!length || length >= ACID_ID_ROOM) return 0;
    memcpy(to, text, length + 1);
    return 1;
}

/* The box around a mark's corners. */
static int read_mark(cli_value corners, acid_box *box) {
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY}, at[2];
    if (cli_elements(corners) != 4) return 0;
    for (uint32_t i = 0; i < 4; ++i) {
        if (!read_pair(cli_element(corners, i), at)) return 0;
        for (int k = 0; k < 2; ++k) {
            low[k] = fmin(low[k], at[k]);
            high[k] = fmax(high[k], at[k]);
        }
    }
    for (int k = 0; k < 2; ++k) {
        box->center[k] = (low[k] + high[k]) / 2;
        box->size[k] = high[k] - low[k];
    }
    return is_sound_box(box);
}

static int read_marks(cli_value marks, acid_box boxes[ACID_MARKS]) {
    static const char *const colors[ACID_MARKS] = {"red", "green", "blue", "yellow"};
    int found = 0;
    for (cli_value mark = cli_first(marks); mark.in; mark = cli_next(mark)) {
        const char *color = cli_string(cli_get(mark, "color"));
        for (int i = 0; i < ACID_MARKS; ++i)
            if (color && strcmp(color, colors[i]) == 0 &&
                read_mark(cli_get(mark, "corners"), &boxes[i]))
                found |= 1 << i;
    }
    return found == (1 << ACID_MARKS) - 1;
}

/* "right" becomes the first. */
static int read_references(cli_value references, acid_row *row) {
    int right = -1;
    for (cli_value r = cli_first(references); r.in; r = cli_next(r)) {
        if (row->reference_count == ACID_MOST_REFERENCES) return 0;
        acid_place *place = &row->references[row->reference_count];
        if (!copy_id(cli_get(r, "id"), place->id) || !read_box(r, &place->box)) return 0;
        if (strcmp(place->id, "right") == 0) right = (int)row->reference_count;
        ++row->reference_count;
    }
    if (right < 0) return 0;
    const acid_place first = row->references[0];
    row->references[0] = row->references[right];
    row->references[right] = first;
    return 1;
}

static int lacks(const acid_work *work, const char *extension) {
    for (size_t i = 0; extension && i < work->without_count; ++i)
        if (strlen(extension) == work->without[i].length &&
            memcmp(extension, work->without[i].name, work->without[i].length) == 0)
            return 1;
    return 0;
}

/* places: the cell itself, or its "alone". */
static int read_row(const acid_work *work, cli_value cell, cli_value places, acid_row *row) {
    const cli_value extensions = cli_get(cell, "extensions");
    for (cli_value name = cli_first(extensions); name.in; name = cli_next(name))
        row->skipped |= lacks(work, cli_string(name));
    return copy_id(cli_get(cell, "id"), row->id) &&
           read_box(cli_get(places, "subject"), &row->subject) &&
           read_references(cli_get(places, "references"), row);
}

/* ---- scenes */

static int read_scene(const acid_work *work, cli_value root, acid_layout *layout) {
    const cli_value cells = cli_get(root, "cells");
    const size_t count = cli_elements(cells);
    if (!read_marks(cli_get(root, "marks"), layout->marks))
        return refuse_layout(work, "\"marks\"", "red, green, blue and yellow with four corners");
    if (!count || count > ACID_MOST_CELLS)
        return refuse_layout(work, "\"cells\"", "one cell at least, and 256 at most");
    layout->rows = calloc(count, sizeof *layout->rows);
    if (!layout->rows) return cli_out_of_memory();
    for (cli_value cell = cli_first(cells); cell.in; cell = cli_next(cell)) {
        acid_row *row = &layout->rows[layout->row_count++];
        char where[64];
        if (read_row(work, cell, cell, row)) continue;
        snprintf(where, sizeof where, "cell %zu", layout->row_count);
        return refuse_layout(work, where,
            "\"id\", \"subject\", and \"references\" of which one is \"right\", each with "
            "\"center\" and \"size\"");
    }
    return CLI_OK;
}

/* A cell's own file. */
static int read_alone(
    const acid_work *work, cli_value root, const char *id, size_t length, acid_layout *layout) {
    cli_value cell = cli_first(cli_get(root, "cells"));
    for (; cell.in; cell = cli_next(cell)) {
        const char *name = cli_string(cli_get(cell, "id"));
        if (name && strlen(name) == length && memcmp(name, id, length) == 0) break;
    }
    const cli_value alone = cli_get(cell, "alone");
    if (!cell.in)
        return refuse_layout(
            work, "its name is not that of a cell", "norma-acid.glb or cells/ID.glb");
    layout->rows = calloc(1, sizeof *layout->rows);
    if (!layout->rows) return cli_out_of_memory();
    layout->row_count = 1;
    if (!read_marks(cli_get(alone, "marks"), layout->marks) ||
        !read_row(work, cell, alone, layout->rows))
        return refuse_layout(work, "\"alone\"", "\"marks\", \"subject\" and \"references\"");
    return CLI_OK;
}

/* Whether the scene is a .glb; *id: the cell of which it is the own file, by its name. */
static int is_glb(const char *scene, const char **id, size_t *length) {
    const char *base = cli_base_name(scene), *dot = strrchr(base, '.');
    if (!dot || strcmp(dot, ".glb") != 0) return 0;
    *id = strcmp(base, "norma-acid.glb") == 0 ? NULL : base;
    *length = (size_t)(dot - base);
    return 1;
}

/* The layout of the scenes that norma acid -o writes. */
static cli_parsed *built_in_layout(void) {
    const acid_grid grid = acid_grid_of_all();
    cli_memory_stream stream;
    cli_json_fault fault;
    cli_parsed *parsed = NULL;
    if (cli_memory_open(&stream)) {
        acid_write_layout(stream.out, &grid);
        if (cli_memory_close(&stream)) parsed = cli_json_parse(stream.text, stream.size, &fault);
        free(stream.text);
    }
    if (!parsed) cli_out_of_memory();
    return parsed;
}

static int is_schema(cli_value root) {
    const char *schema = cli_string(cli_get(root, "schema"));
    return schema && strcmp(schema, "norma-acid-scene/1") == 0;
}

static int read_layout(
    const acid_work *work, cli_value root, const char *id, size_t length, acid_layout *layout) {
    if (!is_schema(root)) return refuse_layout(work, "\"schema\"", "\"norma-acid-scene/1\"");
    return id ? read_alone(work, root, id, length, layout) : read_scene(work, root, layout);
}

int acid_layout_of(const acid_work *work, acid_layout *layout) {
    const char *id = NULL;
    size_t length = 0;
    const int is_built_in = !work->scene || is_glb(work->scene, &id, &length);
    *layout = (acid_layout){0};
    cli_parsed *parsed = is_built_in ? built_in_layout()
                                     : check_load_json(work->scene, "the layout of an acid scene");
    if (work->scene) cli_guard_read(work->files.guard, work->scene);
    if (!parsed) return CLI_FILE;
    int status = read_layout(work, cli_json_root(parsed), id, length, layout);
    cli_json_free(parsed);
    if (status) {
        free(layout->rows);
        *layout = (acid_layout){0};
    }
    return status;
}
