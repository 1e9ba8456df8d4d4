/* acid_write.c: norma acid -o: the scenes, their layout, and the page that explains them. */
#include "acid/acid_scene.h"
#include "cli/acid/acid.h"
#include "cli/process/process.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- acid.json */

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
            cli_json_numbers(json, NULL, at, 2);
        }
        cli_json_close(json, ']');
        cli_json_close(json, '}');
    }
    cli_json_close(json, ']');
}

/* The members of an object that is open. */
static void write_patch_place(cli_json *json, const acid_grid *grid, size_t cell, size_t slot) {
    const acid_region place = acid_slot_region(grid, cell, slot);
    cli_json_numbers(json, "center", place.center, 2);
    cli_json_numbers(json, "size", place.size, 2);
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

int acid_write_layout(FILE *out, const acid_grid *grid) {
    static const double aspect[2] = {4, 3};
    cli_json json = {.out = out};
    cli_json_open(&json, NULL, '{');
    cli_json_string(&json, "schema", "norma-acid-scene/1");
    cli_json_string(&json, "scene", "norma-acid.glb");
    cli_json_numbers(&json, "aspect", aspect, 2);
    write_marks(&json, grid);
    cli_json_open(&json, "cells", '[');
    for (size_t i = 0; i < acid_cell_count; ++i) write_cell_layout(&json, grid, i);
    cli_json_close(&json, ']');
    cli_json_close(&json, '}');
    fputc('\n', out);
    return 1;
}

/* ---- files */

static int make_folder(const char *path, int *made) {
    struct stat found;
    *made = mkdir(path, 0777) == 0;
    if (*made) return CLI_OK;
    const int error = errno;
    if (error == EEXIST && stat(path, &found) == 0 && S_ISDIR(found.st_mode)) return CLI_OK;
    cli_error("%s: the folder cannot be made: %s", path, strerror(error));
    return CLI_FILE;
}

/* A file that is to be written, made as a whole before the first one is begun. */
typedef struct made_file {
    char *path;
    growing_bytes bytes;
} made_file;

typedef struct made_files {
    const acid_work *work;
    made_file *list;
    size_t count;
} made_files;

/* The next file, DIR/name; NULL: out of memory. */
static made_file *begin_made(made_files *files, const char *name) {
    made_file *file = &files->list[files->count++];
    file->path = cli_join(files->work->output, name);
    return file->path ? file : NULL;
}

static int make_glb_file(made_files *files, const acid_grid *grid, const char *name) {
    made_file *file = begin_made(files, name);
    const image_result result = file ? acid_write_scene(grid, &file->bytes) : IMAGE_MEMORY;
    if (!result) return CLI_OK;
    if (result == IMAGE_MEMORY) return cli_out_of_memory();
    cli_error("normal maps cannot be written: %s", acid_picture_text(result));
    return CLI_FILE;
}

static int make_alone(made_files *files, size_t index) {
    const acid_grid grid = acid_grid_of_one(index);
    char name[64];
    snprintf(name, sizeof name, "cells/%s.glb", acid_cells[index].id);
    return make_glb_file(files, &grid, name);
}

static int make_text_file(made_files *files, const acid_grid *grid, const char *name,
    int (*write)(FILE *out, const acid_grid *grid)) {
    cli_memory_stream stream;
    made_file *file = begin_made(files, name);
    if (!file || !cli_memory_open(&stream)) return cli_out_of_memory();
    const int written = write(stream.out, grid);
    if (!cli_memory_close(&stream) || !written) {
        free(stream.text);
        return cli_out_of_memory();
    }
    file->bytes = (growing_bytes){.data = stream.text, .size = stream.size};
    return CLI_OK;
}

static int make_all(made_files *files) {
    const acid_grid grid = acid_grid_of_all();
    int status = make_glb_file(files, &grid, "norma-acid.glb");
    if (!status) status = make_text_file(files, &grid, "acid.json", acid_write_layout);
    if (!status) status = make_text_file(files, &grid, "index.html", acid_write_page);
    for (size_t i = 0; i < acid_cell_count && !status; ++i) status = make_alone(files, i);
    return status;
}

/* All of them or none. A signal waits so long: it would find names of temporary files. */
static int commit_made(const made_files *files) {
    norma_document_error error;
    norma_saving **savings = calloc(files->count, sizeof *savings);
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!savings) return cli_out_of_memory();
    for (size_t i = 0; i < files->count && !result; ++i) {
        const made_file *file = &files->list[i];
        result = norma_save_begin(file->path, &savings[i], &error);
        if (!result)
            result = norma_save_piece(savings[i], file->bytes.data, file->bytes.size, &error);
    }
    if (!result)
        result = norma_save_end_together(savings, files->count, &error);
    else
        for (size_t i = 0; i < files->count; ++i) norma_save_abandon(savings[i]);
    free(savings);
    if (result) cli_print_error(&error);
    return result ? CLI_FILE : CLI_OK;
}

static int write_made(const made_files *files) {
    const char *folder = files->work->output;
    char *cells = cli_join(folder, "cells");
    int made = 0, made_cells = 0, status = CLI_OK;
    if (!cells) return cli_out_of_memory();
    for (size_t i = 0; i < files->count && !status; ++i)
        status = cli_guard_output(files->work->files.guard, files->list[i].path, NULL);
    if (!status) status = make_folder(folder, &made);
    if (!status) status = make_folder(cells, &made_cells);
    cli_writing_begin();
    if (!status) status = commit_made(files);
    if (status && made_cells) rmdir(cells);
    if (status && made) rmdir(folder);
    cli_writing_end();
    free(cells);
    return status;
}

int acid_write_scenes(const acid_work *work) {
    made_files files = {.work = work, .list = calloc(acid_cell_count + 3, sizeof *files.list)};
    int status = files.list ? make_all(&files) : cli_out_of_memory();
    if (!status) status = write_made(&files);
    for (size_t i = 0; i < files.count; ++i) {
        free(files.list[i].path);
        free(files.list[i].bytes.data);
    }
    free(files.list);
    if (!status && !work->common.quiet)
        fprintf(stderr, "%s: norma-acid.glb, %zu files in cells, acid.json, index.html\n",
            work->output, acid_cell_count);
    return cli_finish(status);
}
