/* memory_limit.h: --max-memory, for the whole process. */
#ifndef NORMA_CLI_MEMORY_LIMIT_H
#define NORMA_CLI_MEMORY_LIMIT_H
#include <stdint.h>

const char *cli_limit_memory(const char *value); /* NULL, or what was expected */
/* In bytes: what the option allows, else what this machine has. */
uint64_t cli_memory_limit(void);
/* What of it may be allocated for data, beside the program itself. */
uint64_t cli_memory_for_data(void);
/* "; memory is limited to 512M (--max-memory)", or "" without a limit: the end of a message. */
enum { CLI_LIMIT_ROOM = 96 };
void cli_memory_limit_words(char text[CLI_LIMIT_ROOM]);
#endif
