/* guard.h: sources are never outputs. Every file that a command reads (meshes, buffers, lists,
 * baselines, configurations) and every file that those name (images, material libraries) is put on
 * one list; every output is compared with it before it is written. Files are told apart by device
 * and inode, so that links and other spellings of a name count as the file. */
#ifndef NORMA_CLI_GUARD_H
#define NORMA_CLI_GUARD_H
#include <norma/document.h>

struct cli_subcommand;
typedef struct cli_guard cli_guard;
cli_guard *cli_guard_new(const struct cli_subcommand *command); /* NULL: out of memory, reported */
void cli_guard_free(cli_guard *guard);

/* A file that is read; "-" is standard input. Safe in any thread, as are all of these. */
void cli_guard_read(cli_guard *guard, const char *path);
/* The files that an open document was read from or names. Cheap unless an output exists already. */
void cli_guard_document(cli_guard *guard, norma_document *document, const char *input);
int cli_guard_watches(const cli_guard *guard); /* an output exists already */

/* What was read and named in a worker (worker.h), through its channel: *first is behind what was
 * sent before. 0: the worker has ended. */
struct cli_worker;
size_t cli_guard_count(cli_guard *guard);
void cli_guard_send(cli_guard *guard, size_t *first, const struct cli_worker *worker);
int cli_guard_receive(cli_guard *guard, const struct cli_worker *worker);

/* Called for every output before the work, when the inputs are known, and again just before it is
 * written. own: the input that it replaces in place, else NULL. CLI_OK, or the status of the error
 * that was reported. */
int cli_guard_output(cli_guard *guard, const char *output, const char *own);

/* Whether the second of two outputs would replace the first, however they are spelt. */
int cli_is_same_output(const char *a, const char *b);
#endif
