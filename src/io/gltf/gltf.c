/* gltf.c: a glTF document as a format: its container (text, or GLB 2.0 with its chunks), what it
 * requires, the files that go with it, and its table of functions. */
#define _POSIX_C_SOURCE 200809L
#include "io/gltf/draco_decoder.h"
#include "io/gltf/gltf_layout.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- the files that go with an asset: its buffers, and into another folder the images that it
 * names. All are written before any is renamed (by norma_document_save); a file of the same content
 * is left alone, one of other content is refused. The names come from the asset, which may be
 * anyone's: only what is an image by name and content goes along, nothing hidden, and nothing is
 * written through a link. One is in memory at a time, and each goes once, however often it is
 * named. */

typedef struct companion {
    char *path;
    const patch_buffer *buffer; /* the contents: this; NULL: these */
    const unsigned char *bytes;
    size_t size;
    file_bytes file;      /* an image's */
    int is_new;           /* overwrites nothing, even in place */
    file_stamp *replaces; /* in place: of the buffer as it was read */
} companion;

typedef struct companions {
    norma_document *document;
    gltf *g;
    char *folder; /* of the output */
    companion_writers *writers;
    int in_place;
    norma_document_error *error;
} companions;

typedef struct file_name {
    char *name, *plain; /* "./a//b.png": "a/b.png" */
    uint32_t buffer;    /* GLTF_NONE: an image */
} file_name;

static norma_document_result fail_companions(const companions *c) {
    return norma_document_fail_memory(c->document, c->error);
}

static norma_document_result refuse_companion(
    const companions *c, const char *path, const char *why) {
    const norma_document target = {.path = (char *)(uintptr_t)path};
    return norma_document_fail(&target, c->error, NORMA_DOCUMENT_ERROR_REFUSED, NULL,
        "is %s; %s needs a file of this name beside it", why, c->document->path);
}

/* ---- writing */

/* Folders below the output's for names like "textures/wood.png". */
static int make_companion_folders(companion_writers *writers, char *path, size_t known) {
    for (char *slash = strchr(path + known, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        int failed = norma_document_add_folder(writers, path);
        *slash = '/';
        if (failed) return failed;
    }
    return 0;
}

/* In slices, so that a cancel is noticed soon. */
static int write_content(const companions *c, const patch_buffer *content, file_writer *writer) {
    static const unsigned char zeros[256];
    enum { SLICE = 1 << 23 };
    int failed = 0;
    for (size_t i = 0; i < content->segment_count; ++i) {
        const patch_segment *s = &content->segments[i];
        const size_t most = s->bytes ? SLICE : sizeof zeros;
        for (size_t at = 0, part; !failed && at < s->length; at += part) {
            part = s->length - at < most ? s->length - at : most;
            failed = norma_watch_cancelled(&c->document->watch)
                         ? FILE_CANCELLED
                         : norma_file_writer_write(writer, s->bytes ? s->bytes + at : zeros, part);
        }
    }
    return failed;
}

static norma_document_result write_companion(companions *c, const companion *one) {
    file_writer *writer = NULL;
    int failed = make_companion_folders(c->writers, one->path, strlen(c->folder));
    if (!failed) failed = norma_file_writer_open(one->path, &writer);
    if (!failed && one->replaces) norma_document_expect(c->writers, writer, one->replaces);
    if (!failed) failed = write_content(c, one->buffer, writer);
    if (!failed) failed = norma_file_writer_prepare(writer);
    if (!failed)
        return norma_document_add_writer(c->writers, writer, one->path) ? NORMA_DOCUMENT_OK
                                                                        : fail_companions(c);
    norma_file_writer_abandon(writer);
    return norma_document_fail_file(one->path, c->error, "cannot be written", failed);
}

/* ---- what may be written */

/* Whether a file would land where its path says: neither it nor a folder on the way from the
 * output's folder is a link to somewhere else. A buffer that is replaced may be a link, which was
 * followed when it was read. */
static int stays_in_folder(const companions *c, const companion *one) {
    int stays = one->replaces || !norma_file_is_link(one->path);
    char *path = one->path;
    for (char *slash = strchr(path + strlen(c->folder), '/'); slash && stays;
         slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        stays = one->replaces || !norma_file_is_link(path);
        *slash = '/';
    }
    return stays;
}

/* Writes a file, unless it is there already. Takes over one->path and one->file. */
static norma_document_result add_companion(companions *c, companion one) {
    patch_segment whole = {.length = one.size, .bytes = one.bytes};
    const patch_buffer unchanged = {.length = one.size, .segments = &whole, .segment_count = 1};
    file_bytes there;
    int failed = norma_document_load_file(c->document, one.path, &there), same = 0;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!one.buffer) one.buffer = &unchanged;
    if (!failed) {
        same = norma_gltf_segments_equal(one.buffer, there.data, there.size);
        norma_file_close(&there);
    }
    if (failed == ENOMEM)
        result = fail_companions(c);
    else if (!same && !stays_in_folder(c, &one))
        result = refuse_companion(
            c, one.path, "a symbolic link, or reached through one, and is not written through");
    else if (!same && failed != ENOENT && failed != ENOTDIR &&
             (one.is_new || !(c->in_place && !failed)))
        result = refuse_companion(c, one.path, "there with other content and is not overwritten");
    if (!same && !result) result = write_companion(c, &one);
    free(one.path);
    norma_file_close(&one.file);
    return result;
}

static norma_document_result add_buffer_file(companions *c, uint32_t number) {
    const patch_buffer *b = &c->g->patch->buffers[number];
    companion one = {.path = norma_io_join(c->folder, b->name)};
    if (!one.path) return fail_companions(c);
    if (c->in_place && number < c->g->buffer_count && c->g->buffers[number].name &&
        strcmp(c->g->buffers[number].name, b->name) == 0)
        one.replaces = &c->g->buffers[number].file.stamp;
    if (b->changed) {
        one.buffer = b;
    } else {
        one.bytes = c->g->buffers[number].bytes;
        one.size = c->g->buffers[number].length;
    }
    return add_companion(c, one);
}

/* ---- images */

static int is_image(const unsigned char *bytes, size_t size) {
    static const struct {
        const char *start;
        size_t length, at;
    } kinds[] = {{"\x89PNG\r\n\x1A\n", 8, 0}, {"\xFF\xD8\xFF", 3, 0}, {"WEBP", 4, 8},
        {"\xABKTX 20\xBB\r\n\x1A\n", 12, 0}, {"\xABKTX 11\xBB\r\n\x1A\n", 12, 0}, {"DDS ", 4, 0},
        {"sB", 2, 0}, {"GIF8", 4, 0}, {"BM", 2, 0}, {"ftyp", 4, 4}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i)
        if (size >= kinds[i].at + kinds[i].length &&
            memcmp(bytes + kinds[i].at, kinds[i].start, kinds[i].length) == 0)
            return 1;
    return 0;
}

static int is_image_name(const char *name) {
    static const char *const suffixes[] = {
        "png", "jpg", "jpeg", "webp", "ktx2", "ktx", "dds", "basis", "gif", "bmp", "avif"};
    return norma_gltf_has_suffix(name, suffixes, sizeof suffixes / sizeof *suffixes);
}

static norma_document_result not_copied(const companions *c, const char *name, const char *why) {
    norma_document_add_note(c->document, "%s was not copied: %s", name, why);
    return NORMA_DOCUMENT_OK;
}

/* A file of the asset's folder under its own name, an image or (not GLTF_NONE) a buffer: one that
 * does not exist, or lies outside, stays where it is; one that cannot be read is an error. */
static norma_document_result add_file(companions *c, const file_name *file) {
    const char *name = file->name;
    const uint32_t buffer = file->buffer;
    companion one = {.path = NULL};
    char *source;
    struct stat status;
    if (!norma_gltf_path_inside(c->document->folder, name, &source))
        return errno == ENOMEM ? fail_companions(c)
                               : not_copied(c, name, "it lies outside the asset's folder");
    const char *why = buffer != GLTF_NONE          ? NULL
                      : norma_gltf_is_hidden(name) ? "it is hidden"
                      : !is_image_name(name)       ? "its name is not that of an image"
                                                   : NULL;
    if (why) {
        free(source);
        return not_copied(c, name, why);
    }
    int failed = stat(source, &status) ? errno
                 : S_ISREG(status.st_mode)
                     ? norma_document_load_file(c->document, source, &one.file)
                     : ENOENT;
    const int absent =
        failed == ENOENT || failed == ENOTDIR || failed == ENAMETOOLONG || failed == ELOOP;
    norma_document_result result =
        failed && !absent ? norma_document_fail_file(source, c->error, "cannot be read", failed)
                          : NORMA_DOCUMENT_OK;
    free(source);
    if (failed) return result;
    const int image = buffer == GLTF_NONE,
              no_image = image && !is_image(one.file.data, one.file.size);
    if (!image) result = norma_gltf_check_own_data(c->g, buffer, &one.file, c->error);
    if (result || no_image) {
        norma_file_close(&one.file);
        return result ? result : not_copied(c, name, "its first bytes are not those of an image");
    }
    one.bytes = one.file.data;
    one.size = one.file.size;
    one.path = norma_io_join(c->folder, file->plain);
    if (!one.path) {
        norma_file_close(&one.file);
        return fail_companions(c);
    }
    return add_companion(c, one);
}

static norma_document_result add_given(companions *c, const given_image *image) {
    const companion one = {.path = norma_io_join(c->folder, image->name),
        .bytes = image->bytes,
        .size = image->size,
        .is_new = 1};
    return one.path ? add_companion(c, one) : fail_companions(c);
}

/* ---- the names of an asset, each once */

typedef struct file_names {
    file_name *list;
    size_t count, capacity;
} file_names;

/* A name without what names nothing; an absolute path stays one. */
static char *plain_name(const char *name) {
    char *plain = norma_io_join(name, ""), *to = plain;
    for (const char *from = name; plain && name[0] != '/' && *from;) {
        const size_t length = strcspn(from, "/"), next = length + (from[length] == '/');
        if (length > 0 && !(length == 1 && *from == '.')) {
            memcpy(to, from, next);
            to += next;
        }
        from += next;
    }
    if (plain && name[0] != '/') *to = '\0';
    return plain;
}

static int compare_file_names(const void *a, const void *b) {
    const file_name *x = a, *y = b;
    const int order = strcmp(x->plain, y->plain);
    return order ? order : (x->buffer > y->buffer) - (x->buffer < y->buffer);
}

static norma_document_result add_name(
    companions *c, file_names *names, char *name, uint32_t buffer) {
    file_name *added = norma_io_add(&names->list, &names->capacity, &names->count, sizeof *added);
    if (added)
        *added = (file_name){name, name ? plain_name(name) : NULL, buffer};
    else
        free(name);
    return added && added->plain ? NORMA_DOCUMENT_OK : fail_companions(c);
}

static norma_document_result add_image_names(companions *c, file_names *names) {
    const json *j = &c->g->json;
    uint32_t images = norma_json_member(j, 0, "images");
    norma_document_result result = NORMA_DOCUMENT_OK;
    size_t number = 0;
    for (uint32_t image = JSON_NONE; !result && norma_json_each(j, images, &image);) {
        int failed;
        if (norma_document_given_image(c->document, number++)) continue;
        char *name = norma_gltf_file_name(j, image, &failed);
        if (name)
            result = add_name(c, names, name, GLTF_NONE);
        else if (failed)
            result = fail_companions(c);
    }
    return result;
}

static norma_document_result add_files(companions *c, int buffers, int images) {
    const gltf *g = c->g;
    file_names names = {0};
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t b = 0; buffers && !result && b < g->buffer_count; ++b)
        if (g->buffers[b].name)
            result = add_name(c, &names, norma_io_join(g->buffers[b].name, ""), b);
    if (!result && images) result = add_image_names(c, &names);
    if (!result && names.count)
        qsort(names.list, names.count, sizeof *names.list, compare_file_names);
    for (size_t i = 0; !result && i < names.count; ++i)
        if (i == 0 || strcmp(names.list[i - 1].plain, names.list[i].plain) != 0)
            result = add_file(c, &names.list[i]);
    for (size_t i = 0; i < names.count; ++i) {
        free(names.list[i].name);
        free(names.list[i].plain);
    }
    free(names.list);
    return result;
}

static norma_document_result collect_companions(companions *c, const char *path) {
    gltf *g = c->g;
    int elsewhere = !norma_gltf_same_folder(g, path);
    norma_document_result result = NORMA_DOCUMENT_OK;
    const int differs = norma_gltf_differs(g);
    for (uint32_t b = 0; differs && !result && b <= g->buffer_count; ++b)
        if (g->patch->buffers[b].name && (!c->in_place || g->patch->buffers[b].changed))
            result = add_buffer_file(c, b);
    for (size_t i = 0; !result && i < c->document->image_count; ++i)
        result = add_given(c, &c->document->images[i]);
    return result || !elsewhere ? result : add_files(c, !differs, c->document->folder != NULL);
}

/* ---- sizes */

static int add_file_size(void *user, const char *path) {
    struct stat status;
    if (stat(path, &status) == 0 && S_ISREG(status.st_mode))
        *(uint64_t *)user += (uint64_t)status.st_size;
    return 0;
}

/* Returns 1 if visit stopped, -1 if memory is out, else 0. */
static int visit_buffer(
    const norma_document *document, uint32_t buffer, norma_visit_file *visit, void *user) {
    const char *name = norma_gltf_of(document)->buffers[buffer].name;
    return name ? norma_document_visit_name(document, name, strlen(name), visit, user) : 0;
}

static int visit_images(const norma_document *document, norma_visit_file *visit, void *user) {
    const json *j = &norma_gltf_of(document)->json;
    const uint32_t images = norma_json_member(j, 0, "images");
    int stop = 0;
    size_t number = 0;
    for (uint32_t image = JSON_NONE; !stop && norma_json_each(j, images, &image);) {
        if (norma_document_given_image(document, number++)) continue;
        char *name = norma_gltf_file_name(j, image, &stop);
        if (stop) return -1;
        if (name) stop = norma_document_visit_name(document, name, strlen(name), visit, user);
        free(name);
    }
    return stop;
}

/* Of all buffers and images beside the output; those that do not change are as long as they were
 * beside the input. 0: memory is out. */
static int measure_companions(const companions *c, uint64_t *size) {
    const gltf *g = c->g;
    const patch_buffer *made = norma_gltf_differs(g) ? g->patch->buffers : NULL;
    int failed = 0;
    for (uint32_t b = 0; made && b <= g->buffer_count; ++b)
        if (made[b].changed && made[b].name) *size += made[b].length;
    for (size_t i = 0; i < c->document->image_count; ++i) *size += c->document->images[i].size;
    if (!c->document->folder) return 1;
    for (uint32_t b = 0; b < g->buffer_count && !failed; ++b)
        if (!made || !made[b].changed) failed = visit_buffer(c->document, b, add_file_size, size);
    return !failed && !visit_images(c->document, add_file_size, size);
}

static norma_document_result gltf_write_companions(norma_document *document, const char *path,
    int in_place, companion_writers *writers, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    companions c = {.document = document,
        .g = g,
        .folder = norma_gltf_folder_of(path),
        .writers = writers,
        .error = error};
    c.in_place = in_place && norma_gltf_destination(g, path) == GLTF_IN_PLACE;
    norma_document_result result = c.folder ? NORMA_DOCUMENT_OK : fail_companions(&c);
    if (!result && norma_gltf_differs(g)) result = norma_gltf_lay_out(g, path, error);
    if (!result) result = collect_companions(&c, path);
    if (!result && !measure_companions(&c, &writers->size)) result = fail_companions(&c);
    free(c.folder);
    return result;
}

static int gltf_visit_files(const norma_document *document, norma_visit_file *visit, void *user) {
    const gltf *g = norma_gltf_of(document);
    int stop = 0;
    for (uint32_t b = 0; g->buffers && b < g->buffer_count && !stop; ++b)
        stop = visit_buffer(document, b, visit, user);
    return stop ? stop : visit_images(document, visit, user);
}

static char *gltf_changed_companion(const norma_document *document) {
    const gltf *g = norma_gltf_of(document);
    for (uint32_t b = 0; g->buffers && b < g->buffer_count && document->folder; ++b) {
        char *file = g->buffers[b].name && g->buffers[b].file.stamp.known
                         ? norma_io_join(document->folder, g->buffers[b].name)
                         : NULL;
        if (file && norma_file_has_changed(file, &g->buffers[b].file.stamp)) return file;
        free(file);
    }
    return NULL;
}

/* ---- the container: text, or GLB with its chunks */

enum { GLB_HEADER = 12, GLB_CHUNK_HEADER = 8 };
static const uint32_t GLB_MAGIC = 0x46546C67, GLB_JSON = 0x4E4F534A, GLB_BIN = 0x004E4942;

static norma_document_result fail_glb(
    const gltf *g, norma_document_error *error, size_t byte, const char *expected) {
    char place[40], found[40] = "the end of the file";
    const unsigned char *at = g->document->source.data + g->tile.at + byte;
    snprintf(place, sizeof place, "byte %zu", g->tile.at + byte);
    for (size_t i = 0; i < GLB_CHUNK_HEADER && i < g->tile.end - g->tile.at - byte; ++i)
        snprintf(found + 3 * i, sizeof found - 3 * i, " %02X", at[i]);
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED, place,
        "expected %s; found %s", expected, found + (found[0] == ' '));
}

/* Chunks behind the JSON: the first BIN is the buffer without a uri; all others are kept as they
 * are. */
static norma_document_result read_glb_chunks(gltf *g, size_t end, norma_document_error *error) {
    const unsigned char *bytes = g->document->source.data + g->tile.at;
    size_t at = GLB_HEADER;
    for (uint32_t i = 0; at < end; ++i) {
        if (end - at < GLB_CHUNK_HEADER)
            return fail_glb(g, error, at, "the 8 bytes of a chunk's header");
        size_t length = norma_gltf_u32(bytes + at);
        uint32_t type = norma_gltf_u32(bytes + at + 4);
        if (length > end - at - GLB_CHUNK_HEADER)
            return fail_glb(
                g, error, at, "a chunk that ends within the length that the header declares");
        if ((i == 0) != (type == GLB_JSON))
            return fail_glb(g, error, at, i == 0 ? "a JSON chunk first" : "one JSON chunk");
        if (i == 0) {
            g->text = (const char *)bytes + at + GLB_CHUNK_HEADER;
            g->text_size = length;
        } else if (type == GLB_BIN) {
            if (g->bin) return fail_glb(g, error, at, "one BIN chunk");
            g->bin = bytes + at + GLB_CHUNK_HEADER;
            g->bin_size = length;
            g->bin_chunk = at;
        }
        at += GLB_CHUNK_HEADER + length;
    }
    return g->text ? NORMA_DOCUMENT_OK : fail_glb(g, error, at, "a JSON chunk");
}

static norma_document_result read_glb(gltf *g, norma_document_error *error) {
    norma_document_result result = norma_gltf_find_tile(g, error);
    if (result) return result;
    const unsigned char *bytes = g->document->source.data + g->tile.at;
    const size_t size = g->tile.end - g->tile.at;
    char place[40];
    if (size < GLB_HEADER || norma_gltf_u32(bytes) != GLB_MAGIC)
        return fail_glb(g, error, 0, "the 12 bytes of a GLB header, \"glTF\" first");
    uint32_t version = norma_gltf_u32(bytes + 4), length = norma_gltf_u32(bytes + 8);
    snprintf(place, sizeof place, "byte %zu", g->tile.at + (version == 2 ? 8 : 4));
    if (version != 2)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, place,
            "this is GLB version %u; only version 2 can be read", (unsigned)version);
    if (length > size)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED, place,
            "the header declares %u bytes, but the %s has only %zu", (unsigned)length,
            g->tile.depth ? "tile" : "file", size);
    g->container_size = length;
    if (norma_gltf_surplus(g))
        norma_document_add_note(g->document,
            "%zu bytes follow the %u that the header declares; they are kept, not read",
            size - length, (unsigned)length);
    return read_glb_chunks(g, length, error);
}

static norma_document_result parse_text(gltf *g, norma_document_error *error) {
    json_error wrong;
    if (norma_json_parse(
            g->text, g->text_size, norma_document_watch(g->document), &g->json, &wrong))
        return norma_json_is(&g->json, 0, JSON_OBJECT)
                   ? NORMA_DOCUMENT_OK
                   : norma_gltf_malformed(g, error, 0, "an object");
    if (!wrong.expected) return norma_document_fail_memory(g->document, error);
    char place[40], found[24] = "the end of the text";
    const unsigned char *at = (const unsigned char *)g->text + wrong.byte;
    snprintf(place, sizeof place, "byte %zu", (size_t)(at - g->document->source.data));
    if (wrong.byte < g->text_size)
        snprintf(found, sizeof found, *at > ' ' && *at < 127 ? "%c" : "the byte %02X", *at);
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED, place,
        "is not JSON: expected %s; found %s", wrong.expected, found);
}

/* "2.0" or "2.1" in a version string. */
static int is_version_2(const gltf *g, uint32_t token) {
    const json_token *t = &g->json.tokens[token];
    return t->type == JSON_STRING && t->end - t->start >= 5 && g->text[t->start + 1] == '2' &&
           g->text[t->start + 2] == '.';
}

static norma_document_result check_version(const gltf *g, norma_document_error *error) {
    uint32_t version =
        norma_json_member(&g->json, norma_json_member(&g->json, 0, "asset"), "version");
    if (version == JSON_NONE)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED,
            "/asset/version", "the version is missing; every glTF file has one");
    if (!is_version_2(g, version))
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
            "/asset/version", "is not version 2; only glTF 2.0 can be read");
    if (norma_gltf_needs_later(g) && !g->document->lenient)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
            "/asset/minVersion",
            "needs a later version of glTF than 2.0, the only one that can be read here");
    return NORMA_DOCUMENT_OK;
}

/* A compression that a file requires and that cannot be read here; NULL for other extensions. */
static const char *why_not_required(const char *name) {
    if (!norma_draco_reads() && strcmp(name, GLTF_DRACO) == 0) return norma_draco_missing(0);
    if (!norma_gltf_reads_meshopt() && (strcmp(name, "EXT_meshopt_compression") == 0 ||
                                           strcmp(name, "KHR_meshopt_compression") == 0))
        return "needs meshoptimizer, which this Norma was built without; save the meshes without "
               "compression";
    return NULL;
}

static norma_document_result check_required(const gltf *g, norma_document_error *error) {
    const json *j = &g->json;
    uint32_t list = norma_json_member(j, 0, "extensionsRequired");
    if (list != JSON_NONE && !norma_json_is(j, list, JSON_ARRAY))
        return norma_gltf_malformed(g, error, list, "an array");
    for (uint32_t item = JSON_NONE; norma_json_each(j, list, &item);) {
        if (!norma_json_is(j, item, JSON_STRING))
            return norma_gltf_malformed(g, error, item, "the name of an extension");
        char *name = norma_json_string(j, item);
        if (!name) return norma_document_fail_memory(g->document, error);
        const char *why = why_not_required(name);
        int known = why ? g->document->depth == NORMA_DOCUMENT_SUMMARY : norma_gltf_is_known(name);
        norma_document_result result = NORMA_DOCUMENT_OK;
        if (!known && !g->document->lenient)
            result = norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
                "/extensionsRequired", "requires %s, which %s", name,
                why ? why : "is unknown to this version");
        free(name);
        if (result) return result;
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result gltf_open(norma_document *document, norma_document_error *error) {
    gltf *g = norma_io_allocate(1, sizeof *g);
    if (!g) return norma_document_fail_memory(document, error);
    document->state = g;
    g->document = document;
    g->text = (const char *)document->source.data;
    g->text_size = document->source.size;
    g->held = document->source.size;
    g->tile.end = document->source.size;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (document->format != NORMA_FILE_GLTF) {
        g->text = NULL;
        result = read_glb(g, error);
    }
    if (!result) result = parse_text(g, error);
    norma_document_result (*const steps[])(gltf *, norma_document_error *) = {
        norma_gltf_read_buffers, norma_gltf_read_accessors, norma_gltf_read_meshes,
        norma_gltf_read_nodes, norma_gltf_read_tile_instances};
    if (!result) result = check_version(g, error);
    if (!result) result = check_required(g, error);
    for (size_t i = 0; !result && i < sizeof steps / sizeof steps[0]; ++i)
        result = steps[i](g, error);
    if (!result && !(g->edits = norma_json_edits_create(&g->json, 0)))
        result = norma_document_fail_memory(document, error);
    return result;
}

static void gltf_close(norma_document *document) {
    gltf *g = norma_gltf_of(document);
    if (!g) return;
    norma_gltf_patch_free(g);
    norma_json_edits_destroy(g->edits);
    for (uint32_t i = 0; g->buffers && i < g->buffer_count; ++i) {
        free(g->buffers[i].name);
        free(g->buffers[i].owned);
        norma_file_close(&g->buffers[i].file);
    }
    for (uint32_t i = 0; g->views && i < g->view_count; ++i) free(g->views[i].decoded);
    for (uint32_t i = 0; g->accessors && i < g->accessor_count; ++i) free(g->accessors[i].owned);
    for (uint32_t i = 0; g->meshes && i < g->mesh_count; ++i) free(g->meshes[i].name);
    for (uint32_t i = 0; g->primitives && i < g->primitive_count; ++i) {
        free(g->primitives[i].corners);
        free(g->primitives[i].corner_normals);
    }
    for (uint32_t i = 0; g->attributes && i < g->attribute_count; ++i) free(g->attributes[i].name);
    for (uint32_t i = 0; g->nodes && i < g->node_count; ++i) free(g->nodes[i].name);
    void *const blocks[] = {g->buffers, g->views, g->accessors, g->meshes, g->primitives,
        g->targets, g->attributes, g->nodes, g->drawing};
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; ++i) free(blocks[i]);
    norma_json_free(&g->json);
    free(g);
    document->state = NULL;
}

/* ---- what is in it */

static size_t gltf_mesh_count(const norma_document *document) {
    return norma_gltf_of(document)->primitive_count;
}

static const char *compression_of_view(const gltf *g, uint32_t accessor) {
    const uint32_t view = g->accessors[accessor].view;
    return view == GLTF_NONE || g->views[view].meshopt.token == GLTF_NONE
               ? NULL
               : norma_gltf_extension_of(g, &g->views[view].meshopt);
}

static const char *compression_of(const gltf *g, const gltf_primitive *p) {
    if (p->draco.token != GLTF_NONE) return GLTF_DRACO;
    const char *name = p->indices == GLTF_NONE ? NULL : compression_of_view(g, p->indices);
    for (uint32_t i = p->base.first; i < p->attribute_end && !name; ++i)
        name = compression_of_view(g, g->attributes[i].accessor);
    return name;
}

static norma_document_result gltf_mesh_info(
    const norma_document *document, size_t index, norma_mesh_info *info) {
    const gltf *g = norma_gltf_of(document);
    const gltf_primitive *p = &g->primitives[index];
    *info = (norma_mesh_info){
        .name = g->meshes[p->mesh].name,
        .where = p->where,
        .mesh = p->mesh,
        .primitive = p->number,
        .vertices = p->vertices,
        .faces = p->faces,
        .triangles = p->faces,
        .normals = p->base.normal == GLTF_NONE ? NORMA_NORMALS_NONE : NORMA_NORMALS_PER_VERTEX,
        .encoding = norma_gltf_encoding_name(g, p->base.normal),
        .has_tangents = p->base.tangent != GLTF_NONE,
        .morph_targets = p->target_count,
        .compression = compression_of(g, p),
        .not_read = p->not_read,
    };
    return NORMA_DOCUMENT_OK;
}

static size_t node_count(const norma_document *document) {
    return norma_gltf_of(document)->drawing_count;
}

static norma_document_result node_info(
    const norma_document *document, size_t index, norma_node_info *info) {
    const gltf *g = norma_gltf_of(document);
    const gltf_node *node = &g->nodes[g->drawing[index]];
    *info = (norma_node_info){.name = node->name,
        .node = g->drawing[index],
        .mesh = node->mesh,
        .instances = node->instances};
    memcpy(info->world, node->world, sizeof info->world);
    return norma_gltf_describe_node(document, index, info);
}

const format_functions norma_gltf_functions = {
    .open = gltf_open,
    .close = gltf_close,
    .mesh_count = gltf_mesh_count,
    .mesh_info = gltf_mesh_info,
    .mesh_data = norma_gltf_mesh_data,
    .node_count = node_count,
    .node_info = node_info,
    .compute = norma_gltf_compute,
    .tangents = norma_gltf_tangents,
    .pack = norma_gltf_pack,
    .transform = norma_gltf_transform,
    .edit = norma_gltf_edit,
    .equal_vertices = norma_gltf_equal_vertices,
    .recentre = norma_gltf_recentre,
    .turn_green = norma_gltf_turn_green,
    .write = norma_gltf_write,
    .write_companions = gltf_write_companions,
    .changed_companion = gltf_changed_companion,
    .has_change = norma_gltf_has_change,
    .reopen = norma_gltf_reopen,
    .adopt = norma_gltf_adopt,
    .drop_change = norma_gltf_drop_change,
    .visit_files = gltf_visit_files,
    .scene = &norma_gltf_scene,
};
