/* memory_stream.c: text gathered in memory, all of it or none. The C library's own memory streams
 * do not always tell when they could not grow (glibc 2.36 cuts the text there, without an error),
 * so where streams with functions of one's own exist, growing is done here. */
#define _GNU_SOURCE
#include "cli/text/memory_stream.h"
#include <stdlib.h>
#include <string.h>

#if defined(__linux__)
static ssize_t append(void *user, const char *bytes, size_t count) {
    cli_memory_stream *stream = user;
    if (count >= stream->room - stream->size) {
        size_t room = stream->room;
        while (count >= room - stream->size) room *= 2; /* one byte for the end */
        char *text = realloc(stream->text, room);
        if (!text) return 0; /* sets the stream's error */
        stream->text = text;
        stream->room = room;
    }
    memcpy(stream->text + stream->size, bytes, count);
    stream->size += count;
    return (ssize_t)count;
}

int cli_memory_open(cli_memory_stream *stream) {
    *stream = (cli_memory_stream){.room = 4096};
    stream->text = malloc(stream->room);
    stream->out =
        stream->text ? fopencookie(stream, "w", (cookie_io_functions_t){.write = append}) : NULL;
    if (!stream->out) {
        free(stream->text);
        stream->text = NULL;
    }
    return stream->out != NULL;
}
#else
int cli_memory_open(cli_memory_stream *stream) {
    *stream = (cli_memory_stream){.out = NULL};
    stream->out = open_memstream(&stream->text, &stream->size);
    return stream->out != NULL;
}
#endif

int cli_memory_close(cli_memory_stream *stream) {
    if (!stream->out) return 0;
    const int gathered = !fflush(stream->out) && !ferror(stream->out),
              closed = fclose(stream->out) == 0;
    stream->out = NULL;
    if (gathered && closed && stream->text) {
#if defined(__linux__)
        stream->text[stream->size] = '\0';
#endif
        return 1;
    }
    free(stream->text);
    stream->text = NULL;
    return 0;
}
