/* mcp_paths.c: the folders that an agent's tools may use. A path is judged by where it leads: every
 * link is followed first, so neither ".." nor a link leads out of a root. */
#define _DEFAULT_SOURCE /* realpath, lstat */
#include "cli/mcp/mcp.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char nothing_there[] = "no such file below the roots",
                  memory_ran_out[] = "out of memory";

const char *mcp_roots_add(mcp_roots *roots, const char *folder) {
    struct stat found;
    char *real = realpath(folder, NULL);
    if (!real || stat(real, &found) || !S_ISDIR(found.st_mode)) {
        free(real);
        return "a folder that exists";
    }
    char **paths = realloc((void *)roots->paths, (roots->count + 1) * sizeof *paths);
    if (!paths) {
        free(real);
        return "less, memory ran out";
    }
    roots->paths = paths;
    paths[roots->count++] = real;
    return NULL;
}

void mcp_roots_free(mcp_roots *roots) {
    for (size_t i = 0; i < roots->count; ++i) free(roots->paths[i]);
    free((void *)roots->paths);
}

static int mcp_is_below(const mcp_roots *roots, const char *real) {
    for (size_t i = 0; i < roots->count; ++i) {
        const size_t length = strlen(roots->paths[i]);
        const int whole = strcmp(roots->paths[i], "/") == 0;
        if (strncmp(real, roots->paths[i], length) == 0 && (whole || real[length] == '/')) return 1;
    }
    return 0;
}

/* Relative paths begin at the first root. A path of the tool never begins with a dash then. */
static char *join_root(const mcp_roots *roots, const char *given) {
    const char *root = given[0] == '/' ? "" : roots->paths[0];
    char *joined = malloc(strlen(root) + strlen(given) + 2);
    if (joined) sprintf(joined, "%s%s%s", root, root[0] ? "/" : "", given);
    return joined;
}

/* As messages are to name it: below the first root, which is the working folder, without that. */
static char *shorten(const mcp_roots *roots, char *real) {
    const size_t length = strlen(roots->paths[0]);
    if (!real || strncmp(real, roots->paths[0], length) != 0 || real[length] != '/') return real;
    const char *tail = real + length + 1;
    if (tail[0] == '-') memcpy(real + length - 1, "./", 2), tail -= 2; /* not an option */
    memmove(real, tail, strlen(tail) + 1);
    return real;
}

char *mcp_input_path(const mcp_roots *roots, const char *given, const char **why) {
    struct stat found;
    char *joined = join_root(roots, given);
    char *real = joined && given[0] ? realpath(joined, NULL) : NULL;
    *why = !joined || (!real && errno == ENOMEM) ? memory_ran_out : nothing_there;
    free(joined);
    if (real && mcp_is_below(roots, real) && stat(real, &found) == 0) {
        if (S_ISREG(found.st_mode)) return shorten(roots, real);
        *why = "expected a file, not a folder or a device";
    }
    free(real);
    return NULL;
}

/* folder without links, and the name that stands below it. */
static char *join_name(char *folder, const char *name) {
    char *path = realloc(folder, strlen(folder) + strlen(name) + 2);
    if (!path) {
        free(folder);
        return NULL;
    }
    if (strcmp(path, "/") != 0) strcat(path, "/");
    return strcat(path, name);
}

char *mcp_output_path(const mcp_roots *roots, const char *given, int overwrite, const char **why) {
    struct stat found;
    char *joined = join_root(roots, given), *slash = joined ? strrchr(joined, '/') : NULL;
    const char *name = slash ? slash + 1 : "";
    *why = !joined ? memory_ran_out : "expected the name of a file in a folder below the roots";
    char *real = NULL;
    if (name[0] && strcmp(name, ".") != 0 && strcmp(name, "..") != 0) {
        if (slash == joined) {
            real = realpath("/", NULL);
        } else {
            *slash = '\0';
            real = realpath(joined, NULL);
        }
        if (real) real = join_name(real, name);
    }
    free(joined);
    if (!real || !mcp_is_below(roots, real)) {
        free(real);
        return NULL;
    }
    if (lstat(real, &found)) return shorten(roots, real);
    if (!overwrite)
        *why = "the file exists; choose another name, or set overwrite";
    else if (S_ISREG(found.st_mode)) /* a link could lead out of the roots */
        return shorten(roots, real);
    else
        *why = "exists and is not a plain file";
    free(real);
    return NULL;
}
