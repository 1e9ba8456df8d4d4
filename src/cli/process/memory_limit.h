/* memory_limit.h: --max-memory, for the whole process. */
#ifndef NORMA_CLI_MEMORY_LIMIT_H
#define NORMA_CLI_MEMORY_LIMIT_H

const char *cli_limit_memory(const char *value); /* NULL, or what was expected */
/* "; memory is limited to 512M (--max-memory)", or "" without a limit: the end of a message. */
enum { CLI_LIMIT_ROOM = 96 };
void cli_memory_limit_words(char text[CLI_LIMIT_ROOM]);
#endif
