/* acid.h: norma acid: what its parts share. */
#ifndef NORMA_CLI_ACID_ACID_H
#define NORMA_CLI_ACID_ACID_H
#include "acid/acid.h"
#include "cli/files/files.h"

typedef struct acid_work {
    cli_common common;
    cli_files files; /* its guard; no words */
    const char *judge, *scene, *output;
    int tap;
    struct acid_without {
        const char *name; /* of an extension that the renderer lacks; not ended by a 0 */
        size_t length;
    } without[64];
    size_t without_count;
} acid_work;

int acid_write_layout(FILE *out, const acid_grid *grid); /* acid.json; 0: out of memory */
int acid_write_scenes(const acid_work *work); /* into the folder work->output; a status */
#endif
