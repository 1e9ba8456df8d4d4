/* acid.h: norma acid: what its parts share. */
#ifndef NORMA_CLI_ACID_ACID_H
#define NORMA_CLI_ACID_ACID_H
#include "acid/acid_judge.h"
#include "acid/acid_scene.h"
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

/* Where things lie in the scene that was drawn: as a layout file has it, or as this program writes
 * scenes, of one cell where the scene is that cell's .glb. A status;
 * CLI_OK: the caller frees layout->rows. */
int acid_layout_of(const acid_work *work, acid_layout *layout);

void acid_print_json(const acid_work *work, const acid_layout *layout, const acid_judgement *found);
void acid_print_tap(const acid_work *work, const acid_layout *layout, const acid_judgement *found);
void acid_print_text(const acid_work *work, const acid_layout *layout, const acid_judgement *found);

/* 0: out of memory. */
int acid_write_layout(FILE *out, const acid_grid *grid); /* acid.json */
int acid_write_page(FILE *out, const acid_grid *grid);
int acid_write_scenes(const acid_work *work); /* into the folder work->output; a status */

int acid_judge_shot(const cli_subcommand *command, acid_work *work); /* a status */
#endif
