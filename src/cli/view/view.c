/* view.c: norma view: a page that shows a model. */
#define _POSIX_C_SOURCE 200809L
#include "web/page/model/model_pack.h"
#include "cli/files/files.h"
#include "cli/process/process.h"
#include "cli/text/text.h"
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- The page lies in the tool as read-only data. NORMA_PAGE_FILE is its path, where the build
 * made one (-DNORMA_WEB=ON). */

#if defined(NORMA_PAGE_FILE)
#if defined(__APPLE__)
#define SECTION    ".const_data\n"
#define NAME(name) "_" name
#else
#define SECTION    ".section .rodata\n"
#define NAME(name) name
#endif
/* clang-format off */
__asm__(SECTION
    ".globl " NAME("norma_page_begin") "\n"
    ".globl " NAME("norma_page_end") "\n"
    ".balign 16\n"
    NAME("norma_page_begin") ":\n"
    ".incbin \"" NORMA_PAGE_FILE "\"\n"
    NAME("norma_page_end") ":\n"
    ".byte 0\n"
    ".text\n");
/* clang-format on */
extern const char norma_page_begin[], norma_page_end[];
#else
static const char *const norma_page_begin, *const norma_page_end; /* NULL */
#endif

/* A zero ends it. The model's place in it is empty: where a model goes in stand, once each, these
 * marks, in this order. */
static const char *const page_marks[] = {"/*NAME*/", "/*MODEL*/", "/*FILES*/"};

/* ---- Fewer triangles, by meshoptimizer's simplifier (quadrics, Garland and Heckbert 1997),
 * and by its clustering of vertices where that cannot go far enough. Equal positions count as one
 * vertex: the first of them stays. */

#if defined(NORMA_HAS_MESHOPTIMIZER)
#include <meshoptimizer.h>

/* As a part of the mesh's size. */
static const float largest_error = 0.02F;

typedef struct shared_mesh {
    float *positions;                  /* of each vertex that stays so far */
    uint32_t *remap, *first, *corners; /* first: its number in the mesh */
    size_t vertex_count, unique, corner_count;
} shared_mesh;

static void free_shared(shared_mesh *s) {
    free(s->positions);
    free(s->remap);
    free(s->first);
    free(s->corners);
}

static int make_shared_room(shared_mesh *s, const norma_mesh *mesh) {
    s->vertex_count = mesh->positions.count;
    s->corner_count = mesh->corner_count;
    s->positions = calloc(3 * s->vertex_count + 1, sizeof *s->positions);
    s->remap = malloc(4 * s->vertex_count + 1);
    s->first = malloc(4 * s->vertex_count + 1);
    s->corners = malloc(4 * s->corner_count + 1);
    return s->positions && s->remap && s->first && s->corners;
}

static void read_positions(shared_mesh *s, const norma_mesh *mesh) {
    for (size_t i = 0; i < s->vertex_count; ++i) {
        double v[3];
        norma_view_vector(&mesh->positions, i, v);
        for (size_t axis = 0; axis < 3; ++axis)
            s->positions[3 * i + axis] = isfinite(v[axis]) ? (float)v[axis] : 0;
    }
}

/* Vertices of equal positions become one. 0: a corner names none. */
static int share(shared_mesh *s, const norma_mesh *mesh) {
    read_positions(s, mesh);
    s->unique = meshopt_generateVertexRemap(
        s->remap, NULL, s->vertex_count, s->positions, s->vertex_count, 12);
    for (size_t i = s->vertex_count; i-- > 0;) s->first[s->remap[i]] = (uint32_t)i;
    meshopt_remapVertexBuffer(s->positions, s->positions, s->vertex_count, 12, s->remap);
    for (size_t i = 0; i < s->corner_count; ++i) {
        const uint32_t corner = mesh->corners ? norma_mesh_corner(mesh, i) : (uint32_t)i;
        if (corner >= s->vertex_count) return 0;
        s->corners[i] = s->remap[corner];
    }
    return 1;
}

static int simplify_mesh(shared_mesh *s, size_t most_triangles) {
    uint32_t *fewer = malloc(4 * s->corner_count + 1);
    if (!fewer) return 0;
    size_t count = meshopt_simplify(fewer, s->corners, s->corner_count, s->positions, s->unique, 12,
        3 * most_triangles, largest_error, 0, NULL);
    if (count > 4 * most_triangles)
        count = meshopt_simplifySloppy(fewer, s->corners, s->corner_count, s->positions, s->unique,
            12, 3 * most_triangles, 1, NULL);
    free(s->corners);
    s->corners = fewer;
    s->corner_count = count;
    return 1;
}

/* Only vertices that are still used, in the order of the mesh. */
static int keep_used(shared_mesh *s, view_decimated *decimated) {
    decimated->vertices = malloc(4 * s->unique + 1);
    if (!decimated->vertices) return 0;
    memset(s->remap, 0, 4 * s->vertex_count);
    for (size_t i = 0; i < s->corner_count; ++i) s->remap[s->corners[i]] = 1;
    for (size_t i = 0; i < s->unique; ++i)
        if (s->remap[i]) {
            decimated->vertices[decimated->vertex_count] = s->first[i];
            s->remap[i] = (uint32_t)decimated->vertex_count++;
        }
    for (size_t i = 0; i < s->corner_count; ++i) s->corners[i] = s->remap[s->corners[i]];
    decimated->corners = s->corners;
    decimated->corner_count = s->corner_count;
    s->corners = NULL;
    return 1;
}

/* As view_pack_options.decimate. Without meshoptimizer the mesh is left as it is. */
static int view_decimate(const norma_mesh *mesh, size_t most_triangles, view_decimated *decimated) {
    shared_mesh s = {0};
    if (mesh->corner_count <= 3 * most_triangles) return 1;
    int good = make_shared_room(&s, mesh);
    if (good && share(&s, mesh))
        good = simplify_mesh(&s, most_triangles) && keep_used(&s, decimated);
    free_shared(&s);
    return good;
}
#else
static int view_decimate(const norma_mesh *mesh, size_t most_triangles, view_decimated *decimated) {
    (void)mesh, (void)most_triangles, (void)decimated;
    return 1;
}
#endif

/* ---- Norma view: one HTML file with the page and the model in it. The page is the
 * playground that `make web` leaves; the model is packed by model_pack.c. */

static const char view_help[] =
    "norma view IN -o OUT.html: writes one HTML page that shows the model offline in any browser\n"
    "\n"
    "Examples\n"
    "  norma view chair.glb -o chair.html\n"
    "  norma view scan.ply -o - > scan.html\n"
    "  norma view models/ --out-dir pages              one page for each file of the folder\n"
    "\n"
    "On the page you can turn the model, shade it flat, by Gouraud or by Phong, and draw normals, "
    "winding\n"
    "and the error of stored normals. Sliders change the crease and the weight. Choose a scale, "
    "shear or\n"
    "mirror to compare normals under M itself with normals under the normal matrix. The page also "
    "lists what\n"
    "norma check finds; press a finding to see the place. You can drop other files on the page. A "
    "model of\n"
    "more than a million triangles is simplified for display, but the findings are those of the "
    "whole file.\n"
    "\n"
    "Options\n"
    "  -o, --output OUT.html the page; - is standard output\n"
    "  --out-dir FOLDER      the folder for several inputs; the pages are called "
    "FOLDER/NAME.html\n" CLI_INPUT_FORMAT_HELP
    "  --threads N           uses at most N threads to read (all processors)\n"
    "  --max-memory SIZE     uses at most SIZE (512M, 2G); files that need more fail\n"
    "  --json                prints a summary as JSON\n"
    "  --quiet               prints only errors\n"
    "\n"
    "Exit status: 0 fine, 2 wrong usage, 3 a file could not be read or written, 130 interrupted.\n";

/* More make pages that browsers open slowly or not at all. */
enum { MOST_TRIANGLES = 1000000 };

typedef struct view_work {
    cli_common common;
    cli_files files; /* its inputs, their format, and where pages go */
} view_work;

/* ---- writing */

/* The file of a glTF and those that it refers to, from which the page takes materials and images,
 * and which it can fix: a line for each, its path and its bytes. */
typedef struct view_sources {
    FILE *out;
    const char *folder; /* of the file: paths are written relative to it */
    size_t folder_length;
    int status;
} view_sources;

/* Returns how many bytes were read, fewer only at the end, or -1. */
static ssize_t read_part(int file, unsigned char *part, size_t size) {
    size_t got = 0;
    while (got < size) {
        const ssize_t more = read(file, part + got, size - got);
        if (more < 0 && errno == EINTR) continue;
        if (more < 0) return -1;
        if (more == 0) break;
        got += (size_t)more;
    }
    return (ssize_t)got;
}

static void write_source_name(const view_sources *to, const char *path) {
    const int inside = strncmp(path, to->folder, to->folder_length) == 0;
    const char *name = inside ? path + to->folder_length : cli_base_name(path);
    cli_write_base64(to->out, (const unsigned char *)name, strlen(name));
}

/* Returns 0 or errno. */
static int copy_source(const view_sources *to, const char *path, int file) {
    unsigned char part[3 * 4096];
    ssize_t size;
    write_source_name(to, path);
    fputc(' ', to->out);
    while ((size = read_part(file, part, sizeof part)) > 0)
        cli_write_base64(to->out, part, (size_t)size);
    fputc('\n', to->out);
    return size < 0 ? errno : 0;
}

/* Returns a status. What is missing is left out, and the page draws without it, as viewers do; so
 * is a pipe, which may have no end, and which others may wait for. */
static int write_source(const view_sources *to, const char *path) {
    int file;
    if (cli_is_stream(path)) return CLI_OK;
    do file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    while (file < 0 && errno == EINTR);
    if (file < 0 && errno == ENOENT) return CLI_OK;
    const int failed = file < 0 ? errno : copy_source(to, path, file);
    if (file >= 0) close(file);
    if (!failed) return CLI_OK;
    cli_error("%s: cannot be read: %s", path, strerror(failed));
    return CLI_FILE;
}

static int visit_source(void *user, const char *path) {
    view_sources *to = user;
    to->status = write_source(to, path);
    return to->status;
}

static int write_sources(FILE *out, const char *input, norma_document *document) {
    view_sources to = {out, input, (size_t)(cli_base_name(input) - input), CLI_OK};
    norma_document_error error;
    if (visit_source(&to, input) ||
        norma_document_visit_files(document, visit_source, &to, &error) == NORMA_DOCUMENT_OK ||
        to.status)
        return to.status;
    cli_print_error(&error);
    return CLI_FILE;
}

/* document: whose files the page holds too; or NULL. A status. */
static int write_view_page(
    FILE *out, const char *input, norma_document *document, const view_pack *pack) {
    int status = CLI_OK;
    const char *page = norma_page_begin, *mark;
    for (size_t i = 0; i < CLI_COUNT(page_marks) && (mark = strstr(page, page_marks[i])); ++i) {
        fwrite(page, 1, (size_t)(mark - page), out);
        page = mark + strlen(page_marks[i]);
        if (i == 0)
            cli_write_outside_html(
                out, cli_is_standard(input) ? "standard input" : cli_base_name(input));
        else if (i == 1)
            cli_write_base64(out, pack->bytes, pack->size);
        else if (document)
            status = write_sources(out, input, document);
    }
    fwrite(page, 1, (size_t)(norma_page_end - page), out);
    return status;
}

/* ---- one file */

static norma_document_result read_pack(const view_work *work, const char *input,
    norma_document **document, void **memory, view_pack *pack, norma_document_error *error) {
    static const norma_document_options reading = {.lenient = 1};
    cli_progress progress;
    norma_document_result result =
        cli_read(&work->files, &work->common, input, &reading, document, memory, error);
    if (result) return result;
    cli_progress_start(&progress, "packing", input, work->common.quiet, 0);
    cli_progress_tick(&progress);
    const view_pack_options packing = {.threads = work->common.threads,
        .most_triangles = MOST_TRIANGLES,
        .decimate = view_decimate};
    result = view_pack_document(*document, &packing, pack, error);
    cli_progress_stop(&progress);
    return result;
}

static size_t document_triangles(const norma_document *document) {
    size_t triangles = 0;
    norma_mesh_info info;
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i)
        if (norma_document_mesh_info(document, i, &info) == NORMA_DOCUMENT_OK && !info.not_read)
            triangles += info.triangles;
    return triangles;
}

/* How many triangles of decimated meshes the page has; 0: none was decimated. */
static size_t count_decimated(const view_pack *pack, size_t *all) {
    const view_pack_head *head = (const view_pack_head *)(const void *)pack->bytes;
    const view_pack_mesh *meshes =
        (const view_pack_mesh *)(const void *)(pack->bytes + head->meshes);
    size_t decimated = 0;
    *all = 0;
    for (uint32_t i = 0; i < head->mesh_count; ++i) {
        *all += meshes[i].face_count;
        decimated += meshes[i].decimated ? meshes[i].face_count : 0;
    }
    return decimated;
}

static void report_page(const view_work *work, const char *input, const char *to,
    const norma_document *document, const view_pack *pack) {
    const size_t triangles = document_triangles(document),
                 meshes = norma_document_mesh_count(document);
    size_t shown;
    const int decimated = count_decimated(pack, &shown) > 0;
    if (decimated && !work->common.quiet)
        cli_error(
            "%s: %zu triangles are too many for a page; it shows the surface simplified to %zu",
            cli_input_name(input), triangles, shown);
    if (work->common.json) {
        cli_json json = {.out = stdout};
        cli_json_print(&json, "{input: %s, output: %s, triangles: %zu, shown: %zu, meshes: %zu",
            input, to, triangles, decimated ? shown : triangles, meshes);
        cli_json_notes(&json, document);
        cli_json_close(&json, '}');
        putchar('\n');
        return;
    }
    if (work->common.quiet) return;
    FILE *out = strcmp(to, "-") == 0 ? stderr : stdout;
    cli_say(out, "%s -> %s: ", cli_input_name(input), to);
    cli_counted(out, triangles, "triangle", "triangles");
    fputs("; open it in a browser\n", out);
    cli_print_notes(input, document);
}

static int write_to(const view_work *work, const char *input, const char *to,
    norma_document *document, const view_pack *pack) {
    cli_output output;
    size_t shown;
    const int whole = norma_file_format_is_gltf(norma_document_format(document)) &&
                      !cli_is_standard(input) && !count_decimated(pack, &shown);
    int status = cli_make_folders(&work->files, to);
    if (!status) status = cli_output_begin(&output, to, work->files.guard);
    if (status) return status;
    status = write_view_page(output.out, input, whole ? document : NULL, pack);
    if (!status) return cli_output_end(&output);
    cli_output_drop(&output);
    return status;
}

static int view_file(const view_work *work, const char *input, const char *to) {
    norma_document *document = NULL;
    norma_document_error error = {0};
    void *memory = NULL;
    view_pack pack = {0};
    norma_document_result result = read_pack(work, input, &document, &memory, &pack, &error);
    if (!result && document_triangles(document) == 0)
        result = cli_fail_empty(document, input, "show", &error);
    int status = cli_status_of(result);
    if (result) {
        error.result = result;
        cli_name_error(&error, input);
        cli_print_error(&error);
    } else {
        status = write_to(work, input, to, document, &pack);
        if (!status) report_page(work, input, to, document, &pack);
    }
    free(pack.bytes);
    norma_document_close(document);
    free(memory);
    return status;
}

/* ---- the command */

static int check_pages(const cli_subcommand *command, view_work *work) {
    const char *output = work->files.output;
    if (work->files.in_place)
        return cli_usage(command, "a page cannot replace its input; expected -o or --out-dir");
    if (!output && !work->files.folder)
        return cli_usage(command, "no output was given; expected -o OUT.html or --out-dir FOLDER");
    if (output && work->files.folder)
        return cli_usage(command, "-o and --out-dir exclude each other");
    if (output && work->files.inputs.count > 1)
        return cli_usage(
            command, "one -o for %zu inputs; expected --out-dir FOLDER", work->files.inputs.count);
    if (output && strcmp(output, "-") == 0)
        return work->common.json
                   ? cli_usage(command, "-o - and --json would both write to standard output")
                   : CLI_OK;
    if (output && !cli_ends_in(output, ".html") && !cli_ends_in(output, ".htm"))
        return cli_usage(
            command, "-o %s: the output is a page; expected a name that ends in .html", output);
    return cli_place_outputs(command, &work->files, ".html");
}

static int check_has_page(void) {
#if defined(NORMA_PAGE_FILE)
    return CLI_OK;
#else
    fputs("norma view: this norma was built without the page; run 'make web' in Norma's sources, "
          "which builds one with it\n",
        stderr);
    return CLI_FILE;
#endif
}

static int write_one_page(void *user, size_t file) {
    const view_work *work = user;
    char *to = cli_output_of(&work->files, file, ".html");
    const int status =
        to ? view_file(work, work->files.inputs.list[file].path, to) : cli_out_of_memory();
    free(to);
    return status;
}

static void report_lost_page(void *user, size_t file, int worker, const char *why) {
    const view_work *work = user;
    cli_remove_left_by(worker, &work->files, file);
    cli_error("%s: %s", cli_input_name(work->files.inputs.list[file].path), why);
}

static int make_pages(const cli_subcommand *command, view_work *work) {
    const int found = cli_find_inputs(command, &work->files);
    if (found == CLI_USAGE || work->files.inputs.count == 0) return found;
    int status = check_pages(command, work);
    if (!status) status = cli_guard_outputs(&work->files, ".html");
    if (!status) status = check_has_page();
    if (!status) status = cli_make_out_dir(command, &work->files);
    const cli_each each = {
        work->files.inputs.count, write_one_page, report_lost_page, work, work->files.guard};
    return status ? status : cli_worse(found, cli_run_each(&each));
}

static int view_run(const cli_subcommand *command, int count, char **arguments) {
    view_work work = {.common = {.threads = NORMA_ALL_THREADS}};
    const cli_table tables[] = {
        {cli_output_options, cli_output_option_count, &work.files},
        {cli_input_options, cli_input_option_count, &work.files},
        {cli_common_options, cli_common_option_count, &work.common},
    };
    int status = cli_read_files(command, &work.files, tables, CLI_COUNT(tables), count, arguments);
    if (status) return status;
    status = make_pages(command, &work);
    cli_remove_empty_folders(&work.files);
    cli_files_end(&work.files);
    return cli_finish(status);
}

const cli_subcommand cli_subcommand_view = {
    "view", "writes one HTML page that shows a model in any browser", view_help, view_run};
