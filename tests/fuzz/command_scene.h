/* command_scene.h: a scratch folder whose files share one another, commands over them, and what no
 * command may do to it. */
#ifndef NORMA_FUZZ_COMMAND_SCENE_H
#define NORMA_FUZZ_COMMAND_SCENE_H
#include "fuzz.h"

/* Makes the folder anew from the bytes; it is the working directory then. */
void fuzz_scene_make(fuzz_bytes *bytes);
void fuzz_scene_leave(void); /* back to the folder that it was before */

enum { COMMAND_MOST_WORDS = 24 };
typedef struct command {
    char *words[COMMAND_MOST_WORDS + 1];
    int count;
    const char *inputs[2];
    int input_count;
    int in_place, fixes, unsafe, bakes, one_input, keeps_weld;
    const char *verb, *output, *folder, *baseline; /* NULL: not given */
    int reads_list, reads_baseline, reads_config;
} command;
void fuzz_command_take(fuzz_bytes *bytes, command *c);
int fuzz_command_run(command *c); /* its status; must be 0 to 3, with words where it is 2 or 3 */

/* What the folder holds, and what its assets say. */
typedef struct scene_state scene_state;
scene_state *fuzz_scene_look(void);
void fuzz_scene_forget(scene_state *state);
/* Fails where a command that ended with status has done to before what it may not do. disturbed:
 * the name of a file that another program has changed meanwhile, or NULL. */
void fuzz_scene_judge(const scene_state *before, const scene_state *after, const command *c,
    int status, const char *disturbed);
/* Fails where the same once more has changed something. */
void fuzz_scene_judge_again(const scene_state *once, const scene_state *twice, const command *c);
int fuzz_scene_size(const scene_state *state); /* of all buffers */

/* Names of the folder's files that may be changed while a command runs. */
extern const char *const fuzz_scene_files[];
enum { FUZZ_SCENE_FILES = 12 };
#endif
