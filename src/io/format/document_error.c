/* document_error.c: how a document says what is wrong: one line that names the file, the place,
 * what was found and what was expected; and its notes. */
#include "io/format/format.h"
#include "io/file/system_text.h"
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

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
    if (system_error == FILE_CHANGED)
        snprintf(text, room, "another program has changed it since it was read");
    else if (system_error == FILE_IN_USE)
        snprintf(text, room, "another program is replacing it at this moment");
    else if (system_error == FILE_NOT_REGULAR)
        snprintf(text, room, "it is a device or a pipe, not a regular file");
    else if (system_error == FILE_NOT_FLUSHED)
        snprintf(text, room,
            "the new file is in its place and complete, but its folder could not be flushed: a "
            "power cut may bring the old one back");
    else if (system_error == FILE_ATTRIBUTES)
        snprintf(text, room, "its access list or extended attributes could not be kept");
    else if (system_error == FILE_CANCELLED)
        snprintf(text, room, "cancelled");
    else if (norma_system_text(system_error))
        snprintf(text, room, "%s", norma_system_text(system_error));
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
