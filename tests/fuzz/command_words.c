/* command_words.c: command lines made of bytes, and run in this process with the tool's own main.
 */
#define _GNU_SOURCE
#include "command_scene.h"
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

int norma_main(int count, char **arguments);

#define COUNT(array)  ((uint32_t)(sizeof(array) / sizeof((array)[0])))
#define ONE_OF(array) ((array)[fuzz_below(bytes, COUNT(array))])

static const char *const inputs[] = {"a.gltf", "b.gltf", "./a.gltf", "alias.gltf", "sub/c.gltf",
    "m.obj", "p.ply", "t.stl", ".", "sub", "way", "*.gltf", "**/*.gltf", "none.obj", "s.bin"};
static const char *const outputs[] = {"new.gltf", "a.gltf", "b.gltf", "s.bin", "link.bin",
    "hard.bin", "wood.png", "m.obj", "m.mtl", "p.ply", "t.stl", ".norma.json", "base.json",
    "list.txt", "new.obj", "new.ply", "new.stl", "new.json", "new.html", "sub/new.gltf",
    "alias.gltf", "outlink.gltf", "way/new.gltf", "none/new.gltf", "sub", "", "t.bin"};
static const char *const folders[] = {
    "new", ".", "sub", "new/deep", "way", "a.gltf", "none/../new"};

static void add(command *c, const char *word) {
    if (c->count < COMMAND_MOST_WORDS) c->words[c->count++] = (char *)(uintptr_t)word;
    c->words[c->count] = NULL;
}

static void add_pair(command *c, const char *option, const char *value) {
    if (c->count + 2 > COMMAND_MOST_WORDS) return;
    add(c, option);
    add(c, value);
}

/* Each group of options with its words. */
static void add_options(fuzz_bytes *bytes, command *c) {
    static const char *const of_compute[][2] = {{"--weight", "area"}, {"--crease", "30"},
        {"--smooth", NULL}, {"--flat", NULL}, {"--only", "missing"}, {"--only", "broken"},
        {"--weld", "none"}, {"--morphs", NULL}, {"--json", NULL}, {"--threads", "2"}};
    static const char *const of_transform[][2] = {{"--scale", "2,1,1"}, {"--scale", "-1"},
        {"--translate", "1,2,3"}, {"--rotate", "0,0,1,30"}, {"--bake", NULL}, {"--scale", "1e30"},
        {"--json", NULL}};
    static const char *const of_check[][2] = {{"--fix", NULL}, {"--fix-unsafe", NULL},
        {"--baseline", "base.json"}, {"--config", ".norma.json"}, {"--no-config", NULL},
        {"--files-from", "list.txt"}, {"--format", "json"}, {"--format", "html"},
        {"--profile", "generated"}, {"--select", "N1"}, {"--fail-on", "never"},
        {"--open-by-rays", NULL}, {"--dry-run", NULL}, {"--write-baseline", NULL}};
    static const char *const of_tangents[][2] = {{"--mode", "mikk"}, {"--mode", "steady"},
        {"--texcoord", "0"}, {"--texcoord", "3"}, {"--only", "missing"}, {"--only", "broken"},
        {"--weight", "area"}, {"--json", NULL}, {"--threads", "2"}};
    static const char *const of_info[][2] = {{"--deep", NULL}, {"--json", NULL}};
    for (uint32_t i = fuzz_below(bytes, 4); i > 0; --i) {
        const char *const *o = c->verb[1] == 'o'   ? ONE_OF(of_compute)
                               : c->verb[1] == 'r' ? ONE_OF(of_transform)
                               : c->verb[1] == 'a' ? ONE_OF(of_tangents)
                               : c->verb[1] == 'h' ? ONE_OF(of_check)
                                                   : ONE_OF(of_info);
        if (strcmp(o[0], "--write-baseline") == 0)
            add_pair(c, o[0], c->baseline = ONE_OF(outputs));
        else if (o[1])
            add_pair(c, o[0], o[1]);
        else
            add(c, o[0]);
        c->unsafe |= strcmp(o[0], "--fix-unsafe") == 0;
        c->fixes |= strncmp(o[0], "--fix", 5) == 0;
        c->bakes |= strcmp(o[0], "--bake") == 0;
        c->keeps_weld |= strcmp(o[0], "--weld") == 0;
        c->reads_list |= strcmp(o[0], "--files-from") == 0;
        if (strcmp(o[0], "--no-config") == 0) c->reads_config = 0;
        c->reads_baseline |= strcmp(o[0], "--baseline") == 0;
    }
}

void fuzz_command_take(fuzz_bytes *bytes, command *c) {
    static const char *const verbs[] = {
        "compute", "transform", "check", "info", "explain", "view", "render"};
    const uint32_t drawn = fuzz_below(bytes, 256); /* seeds were made before tangents was there */
    *c = (command){.verb = drawn < 224 ? verbs[drawn % COUNT(verbs)] : "tangents"};
    add(c, "norma");
    add(c, c->verb);
    c->reads_config = c->verb[1] == 'h';
    const uint32_t files = 1 + (fuzz_below(bytes, 3) == 2);
    for (; c->input_count < (int)files; ++c->input_count)
        add(c, c->inputs[c->input_count] = ONE_OF(inputs));
    add_options(bytes, c);
    switch (fuzz_below(bytes, 5)) {
    case 0:
    case 1:
        add(c, "--in-place");
        c->in_place = 1;
        break;
    case 2:
        add_pair(c, "-o", c->output = ONE_OF(outputs));
        break;
    case 3:
        add_pair(c, "--out-dir", c->folder = ONE_OF(folders));
        break;
    default:
        if (c->verb[1] == 'o' || c->verb[0] == 't') add_pair(c, "-o", "-");
    }
    c->one_input = files == 1 && !c->reads_list && strchr(c->words[2], '.') &&
                   c->words[2][1] != '\0' && !strchr(c->words[2], '*');
}

/* ---- running */

static void point_to(int descriptor, int to) {
    fflush(descriptor == STDOUT_FILENO ? stdout : stderr);
    if (dup2(to, descriptor) < 0) fuzz_fail("no descriptor %d", descriptor);
}

int fuzz_command_run(command *c) {
    static int output = -1, messages, own_output, own_messages;
    struct stat said, reported;
    if (output < 0) {
        output = memfd_create("output", MFD_CLOEXEC);
        messages = memfd_create("messages", MFD_CLOEXEC);
        own_output = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
        own_messages = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
    }
    if (ftruncate(output, 0) || ftruncate(messages, 0)) fuzz_fail("no memory for output");
    lseek(output, 0, SEEK_SET);
    lseek(messages, 0, SEEK_SET);
    point_to(STDOUT_FILENO, output);
    point_to(STDERR_FILENO, messages);
    const int status = norma_main(c->count, c->words);
    point_to(STDOUT_FILENO, own_output);
    point_to(STDERR_FILENO, own_messages);
    clearerr(stdout);
    const int failed = fstat(messages, &said) || fstat(output, &reported) || status < 0 ||
                       status > 3 ||
                       (status > 1 && said.st_size + reported.st_size == 0 && !c->output);
    if (failed || getenv("FUZZ_TELL_COMMANDS")) {
        char text[4096];
        const ssize_t length = pread(messages, text, sizeof text, 0);
        for (int i = 0; i < c->count; ++i) fprintf(stderr, "%s ", c->words[i]);
        fprintf(stderr, "-> %d\n%.*s", status, (int)length, text);
    }
    if (failed)
        fuzz_fail(
            "%s ends with %d and %lld bytes of messages", c->verb, status, (long long)said.st_size);
    return status;
}
