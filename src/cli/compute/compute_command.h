/* compute_command.h: what norma compute keeps of a file at hand. */
#ifndef NORMA_CLI_COMPUTE_COMMAND_H
#define NORMA_CLI_COMPUTE_COMMAND_H
#include <norma/document.h>
#include <stddef.h>

typedef struct compute_work {
    norma_compute_options options;
    norma_compute_summary summary;
    int crease_given, smooth_given, flat_given;
    int tangents_given;
    norma_file_format format; /* of the file at hand */
    size_t passes;            /* over it; 0: it fits into memory */
    int together, levels;
    const char **locks;
    size_t lock_count, lock_room;
    const char *votes; /* of norma seams apply; NULL: all files are given */
} compute_work;

struct cli_subcommand;
/* norma seams apply: smooth normals by votes of all tiles, which --votes names. */
int compute_with_votes(const struct cli_subcommand *command, int count, char **arguments);

#endif
