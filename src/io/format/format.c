/* format.c: what every format needs of its document: errors and notes, options, files beside it,
 * memory of what it tells, changes that wait beside its bytes. */
#include "io/format/format.h"
#include "io/text/text.h"
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- How a document says what is wrong: one line that names the file, the place,
 * what was found and what was expected; and its notes. */

/* A file's name or text may hold anything; a message is one line and never half a character. */
static void make_one_line(char *message, size_t capacity) {
    size_t length = strlen(message);
    if (length + 1 == capacity) {
        size_t start = length;
        while (
            start > 0 && length - start < 4 && ((unsigned char)message[start - 1] & 0xC0) == 0x80)
            --start;
        if (start > 0 && (unsigned char)message[start - 1] >= 0xC0) message[start - 1] = '\0';
    }
    for (char *at = message; *at; ++at)
        if ((unsigned char)*at < 0x20 || *at == 0x7F) *at = '?';
}

static size_t append_text(char *message, size_t capacity, size_t length, const char *text) {
    size_t size = strlen(text);
    if (size > capacity - 1 - length) size = capacity - 1 - length;
    memcpy(message + length, text, size);
    message[length + size] = '\0';
    return length + size;
}

norma_document_result norma_document_fail(const norma_document *document,
    norma_document_error *error, norma_document_result result, const char *place,
    const char *format, ...) {
    if (!error) return result;
    const size_t capacity = sizeof error->message;
    size_t length = 0;
    error->result = result;
    error->message[0] = '\0';
    if (document && document->path)
        length = append_text(error->message, capacity, length, document->path);
    if (place) {
        length = append_text(error->message, capacity, length, length ? ":" : "");
        length = append_text(error->message, capacity, length, place);
    }
    length = append_text(error->message, capacity, length, length ? ": " : "");
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->message + length, capacity - length, format, arguments);
    va_end(arguments);
    make_one_line(error->message, capacity);
    return result;
}

void norma_document_system_text(int system_error, char *text, size_t room) {
    static const char *const own[] = {
        [-FILE_CHANGED] = "another program has changed it since it was read",
        [-FILE_IN_USE] = "another program is replacing it at this moment",
        [-FILE_NOT_REGULAR] = "it is a device or a pipe, not a regular file",
        [-FILE_NOT_FLUSHED] = "the new file is in its place and complete, but its folder could not "
                              "be flushed: a power cut may bring the old one back",
        [-FILE_ATTRIBUTES] = "its access list or extended attributes could not be kept",
        [-FILE_CANCELLED] = "cancelled"};
    const char *known = system_error < 0 && -system_error < (int)(sizeof own / sizeof *own)
                            ? own[-system_error]
                            : norma_system_text(system_error);
    if (known)
        snprintf(text, room, "%s", known);
    else
        snprintf(text, room, "error %d of the system", system_error);
}

norma_document_result norma_document_fail_file(
    const char *path, norma_document_error *error, const char *what, int system_error) {
    norma_document_result result = system_error == ENOMEM           ? NORMA_DOCUMENT_ERROR_MEMORY
                                   : system_error == FILE_CANCELLED ? NORMA_DOCUMENT_CANCELLED
                                                                    : NORMA_DOCUMENT_ERROR_FILE;
    char text[160];
    norma_document_system_text(system_error, text, sizeof text);
    const norma_document named = {.path = (char *)(uintptr_t)path};
    if (system_error == FILE_NOT_FLUSHED)
        return norma_document_fail(&named, error, result, NULL, "%s", text);
    return norma_document_fail(&named, error, result, NULL, "%s: %s", what, text);
}

norma_document_result norma_document_fail_cancelled(
    const norma_document *document, norma_document_error *error) {
    return norma_document_fail(document, error, NORMA_DOCUMENT_CANCELLED, NULL, "cancelled");
}

norma_document_result norma_document_fail_core(
    const norma_document *document, norma_document_error *error, norma_result result) {
    switch (result) {
    case NORMA_OK:
        return NORMA_DOCUMENT_OK;
    case NORMA_CANCELLED:
        return norma_document_fail_cancelled(document, error);
    case NORMA_ERROR_MEMORY:
        return norma_document_fail_memory(document, error);
    default:
        return norma_document_fail(
            document, error, NORMA_DOCUMENT_ERROR_MALFORMED, NULL, "%s", norma_result_text(result));
    }
}

int norma_document_add_note(norma_document *document, const char *format, ...) {
    char text[1000];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    make_one_line(text, sizeof text);
    char **notes = norma_io_grow(
        document->notes, &document->note_capacity, document->note_count + 1, sizeof *notes);
    if (!notes) return 0;
    document->notes = notes;
    char *note = norma_io_copy_text(text, strlen(text));
    if (!note) return 0;
    notes[document->note_count++] = note;
    return 1;
}

/* ---- Small things that every format needs: files beside its own, formats and
 * their names. */

int norma_document_load_file(const norma_document *document, const char *path, file_bytes *bytes) {
    const file_reading how = {
        .progress = norma_watch_tell, .progress_user = norma_document_watch(document)};
    return norma_file_open(path, &how, bytes);
}

static const struct {
    norma_file_format format;
    const char *name; /* and the extension */
} FORMAT_NAMES[] = {
    {NORMA_FILE_OBJ, "obj"},
    {NORMA_FILE_PLY, "ply"},
    {NORMA_FILE_STL, "stl"},
    {NORMA_FILE_GLTF, "gltf"},
    {NORMA_FILE_GLB, "glb"},
    {NORMA_FILE_GLB, "vrm"},
    {NORMA_FILE_B3DM, "b3dm"},
    {NORMA_FILE_I3DM, "i3dm"},
    {NORMA_FILE_CMPT, "cmpt"},
    {NORMA_FILE_3MF, "3mf"},
};
enum { FORMAT_COUNT = sizeof FORMAT_NAMES / sizeof FORMAT_NAMES[0] };

const char *norma_file_format_name(norma_file_format format) {
    for (size_t i = 0; i < FORMAT_COUNT; ++i)
        if (FORMAT_NAMES[i].format == format) return FORMAT_NAMES[i].name;
    return "";
}

int norma_file_format_is_gltf(norma_file_format format) {
    return format >= NORMA_FILE_GLTF && format <= NORMA_FILE_CMPT;
}

static int equal_case_aside(const char *text, const char *lower) {
    while (*text && *lower) {
        char letter = *text >= 'A' && *text <= 'Z' ? (char)(*text - 'A' + 'a') : *text;
        if (letter != *lower) return 0;
        ++text;
        ++lower;
    }
    return *text == *lower;
}

norma_file_format norma_file_format_of_path(const char *path) {
    const char *slash = path ? strrchr(path, '/') : NULL;
    const char *name = slash ? slash + 1 : path;
    const char *dot = name ? strrchr(name, '.') : NULL;
    for (size_t i = 0; dot && i < FORMAT_COUNT; ++i)
        if (equal_case_aside(dot + 1, FORMAT_NAMES[i].name)) return FORMAT_NAMES[i].format;
    return NORMA_FILE_UNKNOWN;
}

/* ---- The files that go beside a document, written and waiting to be renamed. */

int norma_document_add_writer(companion_writers *writers, file_writer *writer, const char *path) {
    file_writer **list =
        norma_io_grow(writers->list, &writers->list_capacity, writers->count + 1, sizeof *list);
    writers->list = list ? list : writers->list;
    char **paths = list ? norma_io_grow(writers->paths, &writers->path_capacity, writers->count + 1,
                              sizeof *paths)
                        : NULL,
         *copy = paths ? norma_io_copy_text(path, strlen(path)) : NULL;
    writers->paths = paths ? paths : writers->paths;
    if (!copy) {
        norma_file_writer_abandon(writer);
        return 0;
    }
    list[writers->count] = writer;
    paths[writers->count++] = copy;
    return 1;
}

void norma_document_expect(
    const companion_writers *writers, file_writer *writer, file_stamp *stamp) {
    if (writers->outlive)
        norma_file_writer_expect_once(writer, stamp);
    else
        norma_file_writer_expect(writer, stamp);
}

int norma_document_add_folder(companion_writers *writers, const char *path) {
    int made;
    char *copy = norma_io_copy_text(path, strlen(path)),
         **folders = copy ? norma_io_grow(writers->folders, &writers->folder_capacity,
                                writers->folder_count + 1, sizeof *folders)
                          : NULL;
    writers->folders = folders ? folders : writers->folders;
    const int error = folders ? norma_folder_make(path, &made) : ENOMEM;
    if (error || !made)
        free(copy);
    else
        folders[writers->folder_count++] = copy;
    return error;
}

norma_document_result norma_document_commit(
    companion_writers *writers, norma_document_error *error) {
    size_t at;
    const int failed = norma_file_writers_commit(writers->list, writers->count, &at);
    for (size_t i = 0; i < writers->count; ++i) writers->list[i] = NULL;
    return failed ? norma_document_fail_file(writers->paths[at], error, "cannot be written", failed)
                  : NORMA_DOCUMENT_OK;
}

void norma_document_free_writers(companion_writers *writers, int abandon) {
    for (size_t i = 0; i < writers->count; ++i) {
        if (abandon) norma_file_writer_abandon(writers->list[i]);
        free(writers->paths[i]);
    }
    while (writers->folder_count > 0) { /* what lies in another was made after it */
        if (abandon) norma_folder_remove(writers->folders[writers->folder_count - 1]);
        free(writers->folders[--writers->folder_count]);
    }
    free(writers->list);
    free(writers->paths);
    free(writers->folders);
}

/* ---- Images that a change has made, until they are files. */

const given_image *norma_document_given_image(const norma_document *document, size_t number) {
    for (size_t i = 0; i < document->image_count; ++i)
        if (document->images[i].number == number) return &document->images[i];
    return NULL;
}

void norma_document_forget_images(norma_document *document) {
    for (size_t i = 0; i < document->image_count; ++i) {
        free(document->images[i].bytes);
        free(document->images[i].name);
    }
    free(document->images);
    document->images = NULL;
    document->image_count = 0;
}

/* ---- Names in a file as the paths that they may stand for. */

int norma_document_visit_name(const norma_document *document, const char *name, size_t length,
    norma_visit_file *visit, void *user) {
    const size_t folder_length = length && name[0] == '/' ? 0 : strlen(document->folder);
    if (length == 0 || memchr(name, '\0', length)) return 0;
    char *path = norma_io_allocate(folder_length + length + 1, 1);
    if (!path) return -1;
    memcpy(path, document->folder, folder_length);
    memcpy(path + folder_length, name, length);
    const int stop = visit(user, path) != 0;
    free(path);
    return stop;
}

int norma_document_visit_names(const norma_document *document, const char *text, size_t length,
    norma_visit_file *visit, void *user) {
    static const char blanks[] = " \t";
    while (length && strchr(blanks, text[length - 1])) --length;
    while (length && strchr(blanks, text[0])) ++text, --length;
    int stop = norma_document_visit_name(document, text, length, visit, user);
    for (size_t at = 0, end; at < length && !stop; at = end) {
        while (at < length && strchr(blanks, text[at])) ++at;
        for (end = at; end < length && !strchr(blanks, text[end]);) ++end;
        if (at > 0 || end < length) /* one alone is all of the text */
            stop = norma_document_visit_name(document, text + at, end - at, visit, user);
    }
    return stop;
}

/* ---- The memory that what is told of a document lives in. */

struct scene_block {
    scene_block *next;
    max_align_t bytes[];
};

int norma_is_padding(const unsigned char *bytes, size_t size) {
    size_t i = 0;
    while (i < size && (bytes[i] == 0 || norma_is_blank(bytes[i]))) ++i;
    return i == size;
}

void *norma_scene_allocate(norma_scene *scene, size_t count, size_t size) {
    if (size && count > (SIZE_MAX - sizeof(scene_block)) / size) return NULL;
    scene_block *block = norma_io_allocate(sizeof *block + count * size, 1);
    if (!block) return NULL;
    block->next = scene->blocks;
    scene->blocks = block;
    return block->bytes;
}

norma_unread *norma_scene_tell_unread(
    norma_document *document, size_t count, norma_document_error *error) {
    norma_scene *scene = document->scene;
    scene->unread = norma_scene_allocate(scene, count, sizeof *scene->unread);
    scene->unread_count = scene->unread ? count : 0;
    if (!scene->unread) norma_document_fail_memory(document, error);
    return scene->unread;
}

char *norma_scene_text(norma_scene *scene, const char *text) {
    size_t length = strlen(text);
    char *copy = norma_scene_allocate(scene, length + 1, 1);
    if (copy) memcpy(copy, text, length);
    return copy;
}

char *norma_scene_join(norma_scene *scene, const char *first, const char *second) {
    size_t a = strlen(first), b = strlen(second), comma = a && b;
    char *both = norma_scene_allocate(scene, a + comma + b + 1, 1);
    if (!both) return NULL;
    memcpy(both, first, a);
    if (comma) both[a] = ',';
    memcpy(both + a + comma, second, b);
    return both;
}

void norma_scene_forget(norma_scene *scene) {
    if (!scene) return;
    for (scene_block *block = scene->blocks, *next; block; block = next) {
        next = block->next;
        free(block);
    }
    *scene = (norma_scene){0};
}

/* ---- Files whose changes wait beside the bytes that were read: opened, written,
 * compared, and turned into bytes of the document's own. */

norma_document_result norma_edited_write(norma_document *document, const char *path,
    norma_write *write, void *user, norma_document_error *error) {
    const edited_format *format = document->functions->edited;
    norma_document_result result = NORMA_DOCUMENT_OK;
    norma_sink *sink = norma_sink_create(write, user);
    (void)path;
    if (!sink) return norma_document_fail_memory(document, error);
    if (format->has_edit(document->state))
        result = format->write_changed(document, sink, error);
    else
        norma_sink_put(sink, document->source.data, document->source.size);
    int failed = norma_sink_finish(sink);
    if (!result && failed)
        return norma_document_fail(
            document, error, NORMA_DOCUMENT_ERROR_FILE, NULL, "the output could not be written");
    return result;
}

norma_document_result norma_edited_put_ordered(norma_document *document, norma_sink *sink,
    size_t count, norma_make_data_run *make, void *context, norma_document_error *error) {
    norma_sink_flush(sink);
    if (sink->failed) return NORMA_DOCUMENT_OK;
    const norma_ordered_result result =
        norma_write_ordered((norma_ordered_how){document->threads, &document->watch}, count, make,
            context, sink->write, sink->user);
    sink->failed = result == NORMA_ORDERED_REFUSED;
    return result == NORMA_ORDERED_MEMORY ? norma_document_fail_memory(document, error)
                                          : NORMA_DOCUMENT_OK;
}

norma_document_result norma_edited_drop_idle(
    norma_document *document, int *changed, norma_document_error *error) {
    norma_compare_sink same = {document->source.data, document->source.size};
    norma_document_result result =
        document->functions->write(document, NULL, norma_compare_sink_write, &same, NULL);
    *changed = result == NORMA_DOCUMENT_ERROR_FILE || same.left > 0;
    if (!*changed) document->functions->edited->forget_edit(document->state);
    return result == NORMA_DOCUMENT_ERROR_MEMORY ? norma_document_fail_memory(document, error)
                                                 : NORMA_DOCUMENT_OK;
}

/* ---- opening, closing, and changes that become bytes */

norma_document_result norma_edited_open(norma_document *document, norma_document_error *error) {
    const edited_format *format = document->functions->edited;
    document->state = norma_io_allocate(1, format->state_size);
    return document->state ? format->read(document, error)
                           : norma_document_fail_memory(document, error);
}

void norma_edited_close(norma_document *document) {
    if (!document->state) return;
    document->functions->edited->free_content(document->state);
    free(document->state);
    document->state = NULL;
}

size_t norma_edited_mesh_count(const norma_document *document) {
    (void)document;
    return 1;
}

/* Reading our own bytes finds nothing new, so notes about them are removed. */
static norma_document_result read_again(norma_document *document, norma_document_error *error) {
    const edited_format *format = document->functions->edited;
    const size_t notes = document->note_count;
    format->free_content(document->state);
    memset(document->state, 0, format->state_size);
    norma_document_result result = format->read(document, error);
    norma_scene_forget(document->scene);
    while (document->note_count > notes) free(document->notes[--document->note_count]);
    return result;
}

norma_document_result norma_edited_replace(
    norma_document *document, const growing_bytes *bytes, norma_document_error *error) {
    norma_file_close(&document->source);
    document->source =
        (file_bytes){.data = (const void *)bytes->data, .size = bytes->size, .owned = 1};
    norma_document_result result = read_again(document, error);
    document->failed |= result != NORMA_DOCUMENT_OK;
    return result;
}

void norma_edited_begin(norma_document *document) {
    document->had_edit = document->functions->edited->has_edit(document->state);
}

int norma_edited_drop(norma_document *document, norma_document_result why) {
    const edited_format *format = document->functions->edited;
    if (why == NORMA_DOCUMENT_ERROR_ARGUMENT &&
        !format->has_edit(document->state) == !document->had_edit)
        return 1; /* refused before anything was done */
    /* What came before is in the bytes only if the change could begin with flushing it. */
    if (document->had_edit && (format->gathers || why == NORMA_DOCUMENT_ERROR_MEMORY)) return 0;
    return read_again(document, NULL) == NORMA_DOCUMENT_OK;
}

unsigned char *norma_edited_own_bytes(norma_document *document) {
    file_bytes *source = &document->source;
    if (!source->owned || source->mapped) {
        unsigned char *copy = malloc(source->size ? source->size : 1);
        if (!copy) return NULL;
        if (source->size) memcpy(copy, source->data, source->size);
        const file_bytes own = {.data = copy, .size = source->size, .owned = 1};
        norma_file_close(source);
        *source = own;
    }
    return (unsigned char *)(uintptr_t)source->data;
}

static norma_document_result flush_all(norma_document *document, norma_document_error *error) {
    growing_bytes memory = {0};
    norma_document_result result =
        document->functions->write(document, NULL, norma_memory_sink_write, &memory, error);
    if (!result) return norma_edited_replace(document, &memory, error);
    free(memory.data);
    return result == NORMA_DOCUMENT_ERROR_FILE ? norma_document_fail_memory(document, error)
                                               : result;
}

/* A change that is cancelled takes nothing of the changes before it away, so these are written to
 * their end. */
norma_document_result norma_edited_flush(norma_document *document, norma_document_error *error) {
    if (!document->functions->edited->has_edit(document->state)) return NORMA_DOCUMENT_OK;
    norma_progress *const progress = document->watch.progress;
    document->watch.progress = NULL;
    const norma_document_result result = flush_all(document, error);
    document->watch.progress = progress;
    return result;
}

size_t norma_edit_kept(const norma_mesh_edit *edit) {
    size_t kept = edit->vertex_count > 0;
    while (
        kept < edit->vertex_count && edit->source_vertices[kept] > edit->source_vertices[kept - 1])
        ++kept;
    return kept;
}
