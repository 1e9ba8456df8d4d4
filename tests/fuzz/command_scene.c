/* command_scene.c: the scratch folder: made, looked at, compared. */
#define _GNU_SOURCE
#include "command_scene.h"
#include "asset_values.h"
#include "odd_asset.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MOST_FILES = 96, MOST_SIZE = 1 << 19, ASSETS = 3 };
static const char *const assets[ASSETS] = {"a.gltf", "b.gltf", "sub/c.gltf"};
const char *const fuzz_scene_files[FUZZ_SCENE_FILES] = {"a.gltf", "b.gltf", "s.bin", "t.bin",
    "m.obj", "m.mtl", "p.ply", "t.stl", "sub/c.gltf", ".norma.json", "base.json", "list.txt"};

typedef struct scene_file {
    char path[128];
    dev_t device;
    ino_t inode;
    size_t size;
    unsigned char *bytes;
} scene_file;

struct scene_state {
    scene_file files[MOST_FILES];
    size_t count;
    asset_values values[ASSETS];
};

/* ---- making */

static char scratch[64];
static int home;

static void remove_all(const char *folder, int depth) {
    DIR *open = opendir(folder);
    for (const struct dirent *entry; open && (entry = readdir(open));) {
        char path[512];
        struct stat status;
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0) continue;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (lstat(path, &status) == 0 && S_ISDIR(status.st_mode) && depth < 8) {
            remove_all(path, depth + 1);
            rmdir(path);
        } else
            unlink(path);
    }
    if (open) closedir(open);
}

static pid_t owner;

/* A child in which the tool does one file of several ends here, or libFuzzer would call its exit a
 * find. */
static void remove_scratch(int status, void *unused) {
    (void)unused;
    if (getpid() != owner) {
        fflush(NULL);
        _exit(status);
    }
    remove_all(scratch, 0);
    rmdir(scratch);
}

static void enter(void) {
    if (!scratch[0]) {
        snprintf(scratch, sizeof scratch, "%s/norma-fuzz-XXXXXX",
            access("/dev/shm", W_OK) ? "/tmp" : "/dev/shm");
        home = open(".", O_RDONLY | O_CLOEXEC);
        if (!mkdtemp(scratch)) fuzz_fail("no scratch folder");
        owner = getpid();
        on_exit(remove_scratch, NULL);
    }
    if (chdir(scratch)) fuzz_fail("the scratch folder is gone");
}

/* libFuzzer's own names are those of the folder that it was started in. */
void fuzz_scene_leave(void) {
    if (fchdir(home)) fuzz_fail("the working directory is gone");
}

static void put_bytes(const char *path, const void *bytes, size_t size) {
    const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (file < 0 || write(file, bytes, size) != (ssize_t)size) fuzz_fail("%s cannot be made", path);
    close(file);
}

static void put_text(const char *path, const char *text) { put_bytes(path, text, strlen(text)); }

static void make_asset(fuzz_bytes *bytes, const char *path) {
    static const char *const names[] = {
        "s.bin", "./s.bin", "link.bin", "t.bin", "hard.bin", "s%2Ebin"};
    static char text[ODD_TEXT_SIZE];
    const int below = strchr(path, '/') != NULL;
    const size_t size = fuzz_odd_asset(bytes, below ? names + 3 : names, below ? 1 : 6,
        fuzz_below(bytes, 2) ? "wood.png" : NULL, text);
    put_bytes(path, text, size);
}

static void link_or_fail(const char *to, const char *name) {
    if (symlink(to, name)) fuzz_fail("%s cannot be made", name);
}

void fuzz_scene_make(fuzz_bytes *bytes) {
    static const char *const configs[] = {
        "{}", "{\"fail-on\": \"never\"}", "{\"profile\": \"generated\"}", "{\"no\": 1}", "["};
    static const char stl[] = "solid t\nfacet normal 0 0 2\nouter loop\nvertex 0 0 0\nvertex 1 0 "
                              "0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    uint8_t contents[2 * ODD_FILE_SIZE];
    const uint8_t there = fuzz_u8(bytes);
    enter();
    remove_all(".", 0);
    fuzz_odd_contents(contents);
    fuzz_odd_contents(contents + ODD_FILE_SIZE);
    if (mkdir("sub", 0777)) fuzz_fail("sub cannot be made");
    put_bytes("s.bin", contents, there & 1 ? sizeof contents : ODD_FILE_SIZE);
    put_bytes("t.bin", contents, ODD_FILE_SIZE);
    put_bytes("sub/t.bin", contents, ODD_FILE_SIZE);
    link_or_fail("s.bin", "link.bin");
    if (link(there & 2 ? "s.bin" : "t.bin", "hard.bin")) fuzz_fail("hard.bin cannot be made");
    for (int i = 0; i < ASSETS; ++i) make_asset(bytes, assets[i]);
    if (there & 128) put_bytes("b.gltf", "", 0);
    link_or_fail("a.gltf", "alias.gltf");
    link_or_fail("sub", "way");
    link_or_fail("sub/lost.gltf", "outlink.gltf");
    put_text("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\nvn 0 0 2\nf 1//1 2//1 "
                      "3//1\nf 1 3 4\nf 1 1 2\n");
    put_text("m.mtl", "newmtl m\nmap_Kd wood.png\n");
    put_text("p.ply",
        "ply\nformat ascii 1.0\ncomment TextureFile wood.png\nelement vertex 3\nproperty "
        "float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float "
        "ny\nproperty float nz\nelement face 1\nproperty list uchar int "
        "vertex_indices\nend_header\n0 0 0 0 0 2\n1 0 0 0 0 1\n0 1 0 0 0 0\n3 0 1 2\n");
    put_text("t.stl", stl);
    put_bytes("wood.png", "\x89PNG\r\n\x1A\n....", 12);
    if (there & 4) put_text(".norma.json", configs[fuzz_below(bytes, 5)]);
    if (there & 8) put_text("sub/.norma.json", configs[fuzz_below(bytes, 5)]);
    put_text(
        "base.json", there & 16 ? "{\"schema\": \"norma-baseline/1\", \"findings\": []}" : "{");
    put_text("list.txt", there & 32 ? "a.gltf\nm.obj\n" : "none.obj\nwood.png\nsub\n");
}

/* ---- looking */

static void add_file(scene_state *s, const char *path, const struct stat *status) {
    if (s->count == MOST_FILES || status->st_size > MOST_SIZE)
        fuzz_fail("too many files, or too large: %s", path);
    scene_file *f = &s->files[s->count++];
    snprintf(f->path, sizeof f->path, "%s", path);
    f->device = status->st_dev;
    f->inode = status->st_ino;
    f->size = (size_t)status->st_size;
    f->bytes = malloc(f->size + 1);
    const int file = open(path, O_RDONLY);
    if (file < 0 || read(file, f->bytes, f->size) != (ssize_t)f->size)
        fuzz_fail("%s cannot be read", path);
    close(file);
}

static void look_in(scene_state *s, const char *folder) {
    DIR *open = opendir(folder[0] ? folder : ".");
    for (const struct dirent *entry; open && (entry = readdir(open));) {
        char path[512];
        struct stat status;
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0) continue;
        snprintf(path, sizeof path, "%s%s%s", folder, folder[0] ? "/" : "", entry->d_name);
        if (lstat(path, &status)) continue;
        if (S_ISDIR(status.st_mode))
            look_in(s, path);
        else if (S_ISREG(status.st_mode))
            add_file(s, path, &status);
    }
    if (open) closedir(open);
}

scene_state *fuzz_scene_look(void) {
    scene_state *s = calloc(1, sizeof *s);
    look_in(s, "");
    for (int i = 0; i < ASSETS; ++i) fuzz_read_asset(assets[i], &s->values[i]);
    return s;
}

void fuzz_scene_forget(scene_state *s) {
    for (size_t i = 0; i < s->count; ++i) free(s->files[i].bytes);
    free(s);
}

static const scene_file *find(const scene_state *s, const char *path) {
    for (size_t i = 0; i < s->count; ++i)
        if (strcmp(s->files[i].path, path) == 0) return &s->files[i];
    return NULL;
}

int fuzz_scene_size(const scene_state *s) {
    size_t size = 0;
    for (size_t i = 0; i < s->count; ++i)
        if (strstr(s->files[i].path, ".bin")) size += s->files[i].size;
    return (int)size;
}

static int differ(const scene_file *a, const scene_file *b) {
    return !b || a->size != b->size || memcmp(a->bytes, b->bytes, a->size) != 0;
}

/* ---- what a command reads */

static int ends_with(const char *text, const char *end) {
    const size_t a = strlen(text), b = strlen(end);
    return a >= b && strcmp(text + a - b, end) == 0;
}

static int is_mesh(const char *path) {
    static const char *const ends[] = {".gltf", ".obj", ".ply", ".stl"};
    for (int i = 0; i < 4; ++i)
        if (ends_with(path, ends[i])) return 1;
    return 0;
}

/* Whether the file at path is one that word stands for. */
static int stands_for(const char *word, const char *path) {
    const int below = strchr(path, '/') != NULL;
    if (strcmp(word, ".") == 0) return is_mesh(path);
    if (strcmp(word, "sub") == 0 || strcmp(word, "way") == 0)
        return strncmp(path, "sub/", 4) == 0 && is_mesh(path);
    if (strcmp(word, "*.gltf") == 0) return !below && ends_with(path, ".gltf");
    if (strcmp(word, "**/*.gltf") == 0) return ends_with(path, ".gltf");
    if (strncmp(word, "./", 2) == 0) word += 2;
    return strcmp(word, path) == 0 ||
           (strcmp(word, "alias.gltf") == 0 && strcmp(path, "a.gltf") == 0);
}

static int is_input(const scene_state *before, const command *c, const char *path) {
    const scene_file *list = find(before, "list.txt");
    for (int i = 0; i < c->input_count; ++i)
        if (stands_for(c->inputs[i], path)) return 1;
    if (!c->reads_list || !list) return 0;
    if (memmem(list->bytes, list->size, "a.gltf", 6))
        return strcmp(path, "a.gltf") == 0 || strcmp(path, "m.obj") == 0;
    return strncmp(path, "sub/", 4) == 0 && is_mesh(path);
}

/* Whether the mesh names the file, as far as a search of its text tells. */
static int names(const scene_file *mesh, const char *path) {
    static const char *const spellings[][2] = {{"s.bin", "s.bin"}, {"s%2Ebin", "s.bin"},
        {"link.bin", "s.bin"}, {"t.bin", "t.bin"}, {"hard.bin", "hard.bin"},
        {"wood.png", "wood.png"}, {"m.mtl", "m.mtl"}};
    const char *slash = strrchr(path, '/'), *own = strrchr(mesh->path, '/');
    if ((slash ? slash - path : 0) != (own ? own - mesh->path : 0)) return 0;
    for (size_t i = 0; i < sizeof spellings / sizeof *spellings; ++i)
        if (strcmp(slash ? slash + 1 : path, spellings[i][1]) == 0 &&
            memmem(mesh->bytes, mesh->size, spellings[i][0], strlen(spellings[i][0])))
            return 1;
    return 0;
}

static int is_read(const scene_state *before, const command *c, const scene_file *file) {
    if (c->reads_config && ends_with(file->path, ".norma.json") && !strchr(file->path, '/'))
        return 1;
    if (c->reads_baseline && strcmp(file->path, "base.json") == 0) return 1;
    if (c->reads_list && strcmp(file->path, "list.txt") == 0) return 1;
    for (size_t i = 0; i < before->count; ++i) {
        const scene_file *mesh = &before->files[i];
        if (!is_input(before, c, mesh->path)) continue;
        if (mesh == file || names(mesh, file->path)) return 1;
        for (size_t k = 0; k < before->count; ++k) /* its other names */
            if (before->files[k].inode == file->inode && names(mesh, before->files[k].path))
                return 1;
    }
    return 0;
}

/* ---- what it may do */

static int same_path(const char *a, const char *b) {
    char real_a[PATH_MAX], real_b[PATH_MAX];
    return a && realpath(a, real_a) && realpath(b, real_b) && strcmp(real_a, real_b) == 0;
}

static int lies_below(const char *folder, const char *path) {
    char real[PATH_MAX], of_path[PATH_MAX];
    if (!folder || !realpath(folder, real) || !realpath(path, of_path)) return 0;
    const size_t length = strlen(real);
    return strncmp(of_path, real, length) == 0 && of_path[length] == '/';
}

/* "x.bin", "x_0.bin", "x-1.bin" for "x.gltf", in its folder; an output that is a link has them
 * beside the link. */
static int is_buffer_of(const char *asset, const char *path) {
    if (!asset || !ends_with(asset, ".gltf") || !ends_with(path, ".bin")) return 0;
    const char *slash = strrchr(asset, '/');
    char folder[PATH_MAX], real[2 * PATH_MAX], of_path[PATH_MAX];
    snprintf(real, sizeof real, "%.*s", slash ? (int)(slash - asset) : 1, slash ? asset : ".");
    if (!realpath(real, folder) || !realpath(path, of_path)) return 0;
    const int stem = snprintf(real, sizeof real, "%s/%.*s", folder,
        (int)(strlen(slash ? slash + 1 : asset) - strlen(".gltf")), slash ? slash + 1 : asset);
    return strncmp(real, of_path, (size_t)stem) == 0 && !strchr(of_path + stem, '/');
}

static int is_output(const command *c, const char *path) {
    if (same_path(c->output, path) || same_path(c->baseline, path) || lies_below(c->folder, path))
        return 1;
    return !c->in_place && is_buffer_of(c->output, path);
}

/* Into another folder go, as they are, the files that the asset names. */
static int is_copy(
    const scene_state *before, const scene_state *after, const command *c, const scene_file *copy) {
    const char *name = strrchr(copy->path, '/');
    int named = 0, same = 0;
    if (c->in_place || !c->output || !strchr(c->output, '/') || !name++) return 0;
    for (size_t i = 0; i < before->count; ++i) {
        const scene_file *file = &before->files[i];
        const char *spelled = strcmp(name, "s.bin") ? name : "s%2Ebin";
        named |= is_input(before, c, file->path) &&
                 (memmem(file->bytes, file->size, name, strlen(name)) ||
                     memmem(file->bytes, file->size, spelled, strlen(spelled)));
        same |= !strchr(file->path, '/') &&
                (!differ(copy, file) || !differ(copy, find(after, file->path)));
    }
    return named && same;
}

static int is_new_in_place(const scene_state *before, const command *c, const char *path) {
    for (size_t i = 0; c->in_place && i < before->count; ++i)
        if (is_input(before, c, before->files[i].path) && is_buffer_of(before->files[i].path, path))
            return 1;
    return 0;
}

static void show(const command *c, int status) {
    fputs("fuzz: norma", stderr);
    for (int i = 1; i < c->count; ++i) fprintf(stderr, " %s", c->words[i]);
    fprintf(stderr, ": status %d\n", status);
}

#define FAIL(...) (show(c, status), fuzz_fail(__VA_ARGS__))

/* Written even if a file could not be read, as every report of check's is. */
static int is_report(const command *c, int status, const char *path) {
    return status == 3 && same_path(c->baseline, path);
}

static void judge_files(const scene_state *before, const scene_state *after, const command *c,
    int status, const char *disturbed) {
    const int may_write =
        status < 2 ||
        (status == 3 && (!c->one_input || (c->verb[1] == 'h' && !c->fixes) || disturbed));
    const scene_file *was = disturbed ? find(before, disturbed) : NULL; /* and its other names */
    for (size_t i = 0; i < before->count; ++i) {
        const scene_file *f = &before->files[i], *now = find(after, f->path);
        if (!differ(f, now) || (was && f->inode == was->inode)) continue;
        if (!may_write && !is_report(c, status, f->path)) FAIL("%s has changed", f->path);
        if (is_output(c, f->path) && !is_read(before, c, f)) continue;
        if (c->in_place && (is_input(before, c, f->path) || ends_with(f->path, ".bin"))) {
            if (!now) FAIL("%s is gone", f->path);
            if (ends_with(f->path, ".bin") && now->size < f->size) FAIL("%s is shorter", f->path);
            continue;
        }
        if (!is_output(c, f->path) || is_read(before, c, f))
            FAIL("%s, a source, has changed", f->path);
    }
    for (size_t i = 0; i < after->count; ++i) {
        const char *path = after->files[i].path;
        if (find(before, path) || (disturbed && strcmp(path, disturbed) == 0)) continue;
        if (!may_write && !is_report(c, status, path)) FAIL("%s is new", path);
        if (strstr(path, ".norma-") || !(is_output(c, path) || is_new_in_place(before, c, path) ||
                                           is_copy(before, after, c, &after->files[i])))
            FAIL("%s has appeared", path);
    }
}

/* An output that no asset of the command's has to do with may be a file of another one. */
static int other_output(const scene_state *before, const scene_state *after) {
    for (size_t i = 0; i < before->count; ++i)
        if (differ(&before->files[i], find(after, before->files[i].path))) return 1;
    return 0;
}

static void judge_values(
    const scene_state *before, const scene_state *after, const command *c, int status) {
    for (int i = 0; i < ASSETS; ++i) {
        const asset_values *was = &before->values[i], *now = &after->values[i];
        const int own = c->in_place && is_input(before, c, assets[i]),
                  keeps_places = !c->bakes && !c->unsafe;
        if (!was->known || same_path(c->baseline, assets[i]) ||
            ((!c->in_place || c->baseline) && other_output(before, after)))
            continue;
        if (!now->known) FAIL("%s cannot be read any more: %s", assets[i], now->why);
        if (own ? keeps_places && was->places != now->places : was->all != now->all)
            FAIL("%s holds other values", assets[i]);
    }
    /* The one that was made holds what it was made of. */
    if (status == 0 && c->output && c->one_input && ends_with(c->output, ".gltf") &&
        !strchr(c->output, '-') && (c->verb[0] == 'c' || c->verb[0] == 't')) {
        asset_values made;
        for (int i = 0; i < ASSETS; ++i) {
            if (!is_input(before, c, assets[i]) || !before->values[i].known ||
                (c->verb[1] == 'h' && !c->fixes))
                continue;
            fuzz_read_asset(c->output, &made);
            if (!made.known) FAIL("%s is wrong: %s", c->output, made.why);
            if (!c->bakes && !c->unsafe && made.places != before->values[i].places)
                FAIL("%s holds other values than %s", c->output, assets[i]);
        }
    }
}

void fuzz_scene_judge(const scene_state *before, const scene_state *after, const command *c,
    int status, const char *disturbed) {
    judge_files(before, after, c, status, disturbed);
    if (!disturbed) judge_values(before, after, c, status);
}

void fuzz_scene_judge_again(const scene_state *once, const scene_state *twice, const command *c) {
    const int status = 0;
    for (int i = 0; i < ASSETS; ++i)
        if (once->values[i].known && once->values[i].all != twice->values[i].all)
            FAIL("%s changes once more", assets[i]);
    for (size_t i = 0; c->fixes && !c->unsafe && i < once->count; ++i)
        if (differ(&once->files[i], find(twice, once->files[i].path)))
            FAIL("%s is fixed once more", once->files[i].path);
}
