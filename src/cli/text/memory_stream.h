/* memory_stream.h: text gathered in memory, all of it or none. */
#ifndef NORMA_CLI_MEMORY_STREAM_H
#define NORMA_CLI_MEMORY_STREAM_H
#include <stddef.h>
#include <stdio.h>

typedef struct cli_memory_stream {
    FILE *out;
    char *text; /* once closed: what was written to out, ended by a 0; the caller's to free */
    size_t size, room;
} cli_memory_stream;
/* The stream stays where it is while it is open. 0: out of memory. */
int cli_memory_open(cli_memory_stream *stream);
/* Whether all that was written is there; if not, text is NULL. */
int cli_memory_close(cli_memory_stream *stream);
#endif
