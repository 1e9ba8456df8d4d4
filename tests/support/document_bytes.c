/* document_bytes.c: documents opened from bytes and written back to bytes, for tests. */
#include "document_bytes.h"
#include "check.h"
#include "mesh_files.h"

document_bytes bytes_load(const char *path) {
    document_bytes bytes = {0};
    FILE *file = fopen(path, "rb");
    if (!file) fail_msg("%s cannot be opened", path);
    fseek(file, 0, SEEK_END);
    bytes.size = (size_t)ftell(file);
    rewind(file);
    bytes.data = malloc(bytes.size + 1);
    assert_non_null(bytes.data);
    assert_int_equal(fread(bytes.data, 1, bytes.size, file), bytes.size);
    bytes.data[bytes.size] = 0;
    fclose(file);
    return bytes;
}

document_bytes bytes_copy(const void *data, size_t size) {
    document_bytes bytes = {malloc(size + 1), size};
    assert_non_null(bytes.data);
    memcpy(bytes.data, data, size);
    bytes.data[size] = 0;
    return bytes;
}

void bytes_free(document_bytes *bytes) {
    free(bytes->data);
    *bytes = (document_bytes){0};
}

int bytes_equal(document_bytes a, document_bytes b) {
    return a.size == b.size && memcmp(a.data, b.data, a.size) == 0;
}

static void check(norma_document_result result, const norma_document_error *error) {
    if (result != NORMA_DOCUMENT_OK) fail_msg("%s", error->message);
}

norma_document *bytes_open(document_bytes bytes, const char *name) {
    norma_document *document = NULL;
    norma_document_error error = {0};
    check(
        norma_document_open_memory(bytes.data, bytes.size, name, NULL, &document, &error), &error);
    return document;
}

static int append(void *user, const void *data, size_t size) {
    document_bytes *bytes = user;
    bytes->data = realloc(bytes->data, bytes->size + size + 1);
    assert_non_null(bytes->data);
    memcpy(bytes->data + bytes->size, data, size);
    bytes->size += size;
    bytes->data[bytes->size] = 0;
    return 0;
}

document_bytes bytes_of(norma_document *document) {
    document_bytes bytes = bytes_copy("", 0);
    norma_document_error error = {0};
    check(norma_document_write(document, append, &bytes, &error), &error);
    return bytes;
}

document_bytes bytes_computed(document_bytes bytes, const char *name,
    const norma_compute_options *options, norma_compute_summary *summary) {
    norma_document *document = bytes_open(bytes, name);
    norma_document_error error = {0};
    check(norma_document_compute(document, options, summary, &error), &error);
    document_bytes out = bytes_of(document);
    norma_document_close(document);
    return out;
}

document_bytes bytes_transformed(document_bytes bytes, const char *name, const double matrix[16],
    norma_transform_summary *summary) {
    norma_document *document = bytes_open(bytes, name);
    norma_document_error error = {0};
    norma_transform_options options = {.struct_size = sizeof options};
    memcpy(options.matrix, matrix, sizeof options.matrix);
    check(norma_document_transform(document, &options, summary, &error), &error);
    document_bytes out = bytes_of(document);
    norma_document_close(document);
    return out;
}

norma_document_result bytes_try(
    document_bytes bytes, const char *name, norma_mesh_info *info, char *message) {
    norma_document *document = NULL;
    norma_document_error error = {0};
    norma_document_result result =
        norma_document_open_memory(bytes.data, bytes.size, name, NULL, &document, &error);
    if (message) memcpy(message, error.message, sizeof error.message);
    if (!result && info) norma_document_mesh_info(document, 0, info);
    norma_document_close(document);
    return result;
}

static const char *field(char *line, int index) {
    for (; index > 0 && line; --index) {
        line = strchr(line, '\t');
        line = line ? line + 1 : NULL;
    }
    return line ? line : "";
}

static int field_is(const char *at, const char *text) {
    return strncmp(at, text, strlen(text)) == 0 &&
           (at[strlen(text)] == '\t' || at[strlen(text)] == '\n');
}

size_t data_for_each_format(
    const char *format, void (*visit)(const char *path, const char *name, const char *expect)) {
    char line[8192], path[9216], expect[64];
    size_t count = 0;
    if (!data_folder()) return 0;
    snprintf(path, sizeof path, "%s/INDEX.tsv", data_folder());
    FILE *index = fopen(path, "rb");
    while (index && fgets(line, sizeof line, index)) {
        if (!field_is(field(line, 1), format)) continue;
        const char *wanted = field(line, 5);
        snprintf(expect, sizeof expect, "%.*s", (int)strcspn(wanted, "\t"), wanted);
        const size_t length = strcspn(line, "\t");
        line[length] = '\0';
        snprintf(path, sizeof path, "%s/%s", data_folder(), line);
        visit(path, line, expect);
        ++count;
    }
    if (index) fclose(index);
    return count;
}
