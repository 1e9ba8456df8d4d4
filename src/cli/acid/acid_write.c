/* acid_write.c: norma acid -o: the scenes, their layout, and the page that explains them. */
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
        const acid_box mark = acid_mark_box(grid, i);
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
    const acid_box place = acid_slot_box(grid, cell, slot);
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
    const acid_grid alone = acid_grid_of(index, 1);
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

/* ---- the page that explains each cell */

static const char page_head[] =
    "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
    "content=\"width=device-width,initial-scale=1\">\n<title>Norma's acid test</title>\n<style>\n"
    ":root{color-scheme:light dark}body{font:16px/1.5 system-ui,sans-serif;max-width:52rem;"
    "margin:0 auto;padding:1rem}h2{margin:2.5rem 0 0;font-size:1.2rem}blockquote{margin:.5rem 0;"
    "padding-left:1rem;border-left:3px solid #888}code{font-size:.9em}dt{margin-top:.5rem;"
    "font-weight:600}dd{margin-left:1.5rem}pre{overflow-x:auto;white-space:pre-wrap}"
    ".row{display:flex;flex-wrap:wrap;gap:1rem}figure{margin:0;font-size:.85rem}img{display:block;"
    "width:96px;height:96px}\n</style></"
    "head><body><main>\n"
    "<h1>Norma's acid test</h1>\n"
    "<p>Load <code>norma-acid.glb</code> into a renderer, look through its camera "
    "<code>norma-acid</code>, and compare. Each cell is a row of patches. The first, the subject, "
    "is drawn by way of the feature under test. Those beside it are the same surface baked into "
    "the world: the first is right, each other one has the normals that one known mistake gives. "
    "The renderer is right if the subject looks like the patch called right; if it looks like "
    "another one, that is its mistake.</p>\n"
    "<p>Three lights, red, green and blue, each 30 degrees off the view, colour patches by their "
    "normals. Labels and the squares in the corners are unlit. <code>cells/</code> has each cell "
    "in a file of its own. <code>norma acid --judge SHOT.png --scene acid.json</code> does the "
    "comparison for you.</p>\n"
    "<p>A normal in a file has unit length. So the reference <em>not-normalized</em> has the right "
    "directions, and vertex colours that make it as much brighter or darker as normals of the "
    "wrong length make the light, up to the most that a renderer counts (n&#183;l = 1). The "
    "reference <em>lost</em> is drawn black.</p>\n"
    "<p>Pictures show the references of each cell as a renderer without tone mapping draws them; "
    "the subject should look like the first.</p>\n";

static void write_escaped(FILE *out, const char *before, const char *text, const char *after) {
    fputs(before, out);
    cli_write_outside_html(out, text);
    fputs(after, out);
}

/* The lines that mend it, from the file that people paste. */
static void write_mend(FILE *out, const acid_mistake *mistake) {
    const char *begin;
    if (!mistake->functions[0]) return;
    fputs("<dd><details><summary>In a shader: norma.glsl</summary><pre><code>", out);
    for (size_t i = 0; i < ACID_MOST_FUNCTIONS && mistake->functions[i]; ++i) {
        const size_t length = acid_mending_lines(mistake->functions[i], &begin);
        if (i) fputs("\n\n", out);
        for (size_t k = 0; k < length; ++k) {
            const char letter[2] = {begin[k]};
            if (letter[0] == '\n')
                fputs(letter, out);
            else
                cli_write_outside_html(out, letter);
        }
    }
    fputs("</code></pre></details></dd>\n", out);
}

/* 0: out of memory. */
static int write_patch(
    FILE *out, const acid_cell *cell, const acid_patch *subject, acid_fault fault) {
    enum { SIDE = 64 };
    uint8_t pixels[3 * SIDE * SIDE] = {0};
    const acid_picture picture = {SIDE, SIDE, pixels};
    growing_bytes png = {0};
    acid_patch patch;
    if (!acid_make_reference(cell, subject, fault, &patch)) return 0;
    acid_draw_patch(&patch, acid_white(cell), SIDE, pixels);
    acid_free_patch(&patch);
    const int made = acid_write_picture(&picture, &png);
    if (made) {
        fputs("<figure><img alt=\"\" src=\"data:image/png;base64,", out);
        cli_write_base64(out, (const unsigned char *)png.data, png.size);
        write_escaped(out, "\"><figcaption>", acid_fault_id(fault), "</figcaption></figure>\n");
    }
    free(png.data);
    return made;
}

static int write_cell_row(FILE *out, const acid_cell *cell) {
    acid_patch subject;
    if (!acid_make_subject(cell, &subject)) return 0;
    fputs("<div class=\"row\">\n", out);
    int made = write_patch(out, cell, &subject, ACID_RIGHT);
    for (size_t i = 0; i < acid_fault_count(cell) && made; ++i)
        made = write_patch(out, cell, &subject, cell->faults[i]);
    fputs("</div>\n", out);
    acid_free_patch(&subject);
    return made;
}

static void write_cell_mistakes(FILE *out, const acid_cell *cell) {
    if (!acid_fault_count(cell)) return;
    fputs("<dl>\n", out);
    for (size_t i = 0; i < acid_fault_count(cell); ++i) {
        const char *id = acid_fault_id(cell->faults[i]);
        const acid_mistake *mistake = acid_find_mistake(id);
        write_escaped(out, "<dt>", id, "</dt>");
        if (!mistake) continue;
        write_escaped(out, "<dd>What happens: ", mistake->words, ".</dd>");
        write_escaped(out, "<dd>Instead: ", mistake->mend, ".</dd>\n");
        write_mend(out, mistake);
    }
    fputs("</dl>\n", out);
}

static int write_acid_page(FILE *out, const acid_grid *grid) {
    (void)grid;
    fputs(page_head, out);
    for (size_t i = 0; i < acid_cell_count; ++i) {
        const acid_cell *cell = &acid_cells[i];
        write_escaped(out, "<h2 id=\"", cell->id, "\">");
        write_escaped(out, "", cell->id, "</h2>\n");
        write_escaped(out, "<p>", cell->tested, "</p>\n");
        write_escaped(out, "<blockquote>", cell->sentence, "<br>");
        write_escaped(out, "<small>", cell->section, "</small></blockquote>\n");
        write_escaped(out, "<p>Expected: ", cell->expected, " ");
        if (acid_cell_extension(cell))
            write_escaped(out, "Needs <code>", acid_cell_extension(cell), "</code>. ");
        write_escaped(out, "File: <code>cells/", cell->id, ".glb</code></p>\n");
        if (!write_cell_row(out, cell)) return 0;
        write_cell_mistakes(out, cell);
    }
    fputs("</main></body></html>\n", out);
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
    cli_error("normal maps cannot be written: %s", norma_image_text(result));
    return CLI_FILE;
}

static int make_alone(made_files *files, size_t index) {
    const acid_grid grid = acid_grid_of(index, 1);
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
    const acid_grid grid = acid_grid_of(0, acid_cell_count);
    int status = make_glb_file(files, &grid, "norma-acid.glb");
    if (!status) status = make_text_file(files, &grid, "acid.json", acid_write_layout);
    if (!status) status = make_text_file(files, &grid, "index.html", write_acid_page);
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
