/* acid_write.c: norma acid -o: the scenes, their layout, and the page that explains them. */
#include "acid/acid_scene.h"
#include "cli/acid/acid.h"
#include "cli/process/process.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- acid.json */

static void write_pair(cli_json *json, const char *key, const double pair[2]) {
    cli_json_open(json, key, '[');
    for (int k = 0; k < 2; ++k) cli_json_number(json, NULL, pair[k]);
    cli_json_close(json, ']');
}

static void write_marks(cli_json *json, const acid_grid *grid) {
    cli_json_open(json, "marks", '[');
    for (size_t i = 0; i < 4; ++i) {
        const acid_region mark = acid_mark_region(grid, i);
        cli_json_open(json, NULL, '{');
        cli_json_string(json, "color", acid_mark_colors[i]);
        cli_json_open(json, "corners", '[');
        for (int corner = 0; corner < 4; ++corner) {
            const double at[2] = {
                mark.center[0] + (corner == 1 || corner == 2 ? 0.5 : -0.5) * mark.size[0],
                mark.center[1] + (corner > 1 ? 0.5 : -0.5) * mark.size[1]};
            write_pair(json, NULL, at);
        }
        cli_json_close(json, ']');
        cli_json_close(json, '}');
    }
    cli_json_close(json, ']');
}

/* The members of an object that is open. */
static void write_patch_place(cli_json *json, const acid_grid *grid, size_t cell, size_t slot) {
    const acid_region place = acid_slot_region(grid, cell, slot);
    write_pair(json, "center", place.center);
    write_pair(json, "size", place.size);
}

static void write_patches(cli_json *json, const acid_grid *grid, size_t index) {
    const acid_cell *cell = &acid_cells[index];
    const size_t references = 1 + acid_fault_count(cell);
    cli_json_open(json, "subject", '{');
    write_patch_place(json, grid, index, ACID_SUBJECT_SLOT);
    cli_json_close(json, '}');
    cli_json_open(json, "references", '[');
    for (size_t i = 0; i < references; ++i) {
        cli_json_open(json, NULL, '{');
        cli_json_string(json, "id", acid_fault_id(i ? cell->faults[i - 1] : ACID_RIGHT));
        write_patch_place(json, grid, index, ACID_RIGHT_SLOT + i);
        cli_json_close(json, '}');
    }
    cli_json_close(json, ']');
    cli_json_open(json, "others", '[');
    for (size_t slot = ACID_RIGHT_SLOT + references; slot < acid_slot_count(cell); ++slot) {
        cli_json_open(json, NULL, '{');
        write_patch_place(json, grid, index, slot);
        cli_json_close(json, '}');
    }
    cli_json_close(json, ']');
}

static void write_cell_layout(cli_json *json, const acid_grid *grid, size_t index) {
    const acid_cell *cell = &acid_cells[index];
    const acid_grid alone = acid_grid_of_one(index);
    const char *extension = acid_cell_extension(cell);
    char name[64];
    snprintf(name, sizeof name, "cells/%s.glb", cell->id);
    cli_json_open(json, NULL, '{');
    cli_json_string(json, "id", cell->id);
    cli_json_string(json, "file", name);
    cli_json_open(json, "extensions", '[');
    if (extension) cli_json_string(json, NULL, extension);
    cli_json_close(json, ']');
    write_patches(json, grid, index);
    cli_json_open(json, "alone", '{');
    write_marks(json, &alone);
    write_patches(json, &alone, index);
    cli_json_close(json, '}');
    cli_json_close(json, '}');
}

void acid_write_layout(FILE *out, const acid_grid *grid) {
    static const double aspect[2] = {4, 3};
    cli_json json = {.out = out};
    cli_json_open(&json, NULL, '{');
    cli_json_string(&json, "schema", "norma-acid-scene/1");
    cli_json_string(&json, "scene", "norma-acid.glb");
    write_pair(&json, "aspect", aspect);
    write_marks(&json, grid);
    cli_json_open(&json, "cells", '[');
    for (size_t i = 0; i < acid_cell_count; ++i) write_cell_layout(&json, grid, i);
    cli_json_close(&json, ']');
    cli_json_close(&json, '}');
    fputc('\n', out);
}

/* ---- files */

static int make_folder(const char *path) {
    struct stat found;
    if (mkdir(path, 0777) == 0) return CLI_OK;
    const int error = errno;
    if (error == EEXIST && stat(path, &found) == 0 && S_ISDIR(found.st_mode)) return CLI_OK;
    cli_error("%s: the folder cannot be made: %s", path, strerror(error));
    return CLI_FILE;
}

/* Begins DIR/name. *path: the caller's to free once the output has ended. */
static int begin_in_folder(
    const acid_work *work, const char *name, cli_output *output, char **path) {
    *path = cli_join(work->output, name);
    return *path ? cli_output_begin(output, *path, work->files.guard) : cli_out_of_memory();
}

static int write_one_scene(const acid_work *work, const acid_grid *grid, const char *name) {
    growing_bytes glb = {0};
    cli_output output;
    char *path = NULL;
    const image_result result = acid_write_scene(grid, &glb);
    int status = CLI_OK;
    if (result == IMAGE_MEMORY)
        status = cli_out_of_memory();
    else if (result) {
        cli_error("normal maps cannot be written: %s", acid_picture_text(result));
        status = CLI_FILE;
    }
    if (!status) status = begin_in_folder(work, name, &output, &path);
    if (!status) {
        fwrite(glb.data, 1, glb.size, output.out);
        status = cli_output_end(&output);
    }
    free(path);
    free(glb.data);
    return status;
}

static int write_alone(const acid_work *work, size_t index) {
    const acid_grid grid = acid_grid_of_one(index);
    char name[64];
    snprintf(name, sizeof name, "cells/%s.glb", acid_cells[index].id);
    return write_one_scene(work, &grid, name);
}

static int write_text(const acid_work *work, const acid_grid *grid, const char *name,
    void (*write)(FILE *out, const acid_grid *grid)) {
    cli_output output;
    char *path = NULL;
    int status = begin_in_folder(work, name, &output, &path);
    if (!status) {
        write(output.out, grid);
        status = cli_output_end(&output);
    }
    free(path);
    return status;
}

static int make_folders_of(const acid_work *work) {
    int status = make_folder(work->output);
    char *cells = status ? NULL : cli_join(work->output, "cells");
    if (!status) status = cells ? make_folder(cells) : cli_out_of_memory();
    free(cells);
    return status;
}

int acid_write_scenes(const acid_work *work) {
    const acid_grid grid = acid_grid_of_all();
    int status = make_folders_of(work);
    if (!status) status = write_one_scene(work, &grid, "norma-acid.glb");
    for (size_t i = 0; i < acid_cell_count && !status; ++i) status = write_alone(work, i);
    if (!status) status = write_text(work, &grid, "acid.json", acid_write_layout);
    if (!status) status = write_text(work, &grid, "index.html", acid_write_page);
    if (!status && !work->common.quiet)
        fprintf(stderr, "%s: norma-acid.glb, %zu files in cells, acid.json, index.html\n",
            work->output, acid_cell_count);
    return cli_finish(status);
}
