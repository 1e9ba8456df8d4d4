/* missing.h: what the tool takes from POSIX and WASI lacks; no_posix.c defines it, with what node
 * says (web/package/tool.js). Included in front of every file of the tool. */
#ifndef NORMA_TOOL_MISSING_H
#define NORMA_TOOL_MISSING_H
#define _GNU_SOURCE /* fopencookie */
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

char *realpath(const char *restrict path, char *restrict resolved);
int madvise(void *address, unsigned long size, int advice);
long tool_sysconf(int what);
#define sysconf(what) tool_sysconf(what)

/* WASI knows no rights and owners of files: modes have none, and no one may not write. */
int tool_stat(const char *path, struct stat *status);
int tool_lstat(const char *path, struct stat *status);
int tool_fstat(int descriptor, struct stat *status);
int tool_access(const char *path, int mode);
#define stat(path, status)        tool_stat(path, status)
#define lstat(path, status)       tool_lstat(path, status)
#define fstat(descriptor, status) tool_fstat(descriptor, status)
#define access(path, mode)        tool_access(path, mode)
int fchmod(int descriptor, mode_t mode);
int fchown(int descriptor, uid_t owner, gid_t group);
uid_t geteuid(void);
pid_t getpid(void);
int dup(int descriptor); /* to read it from its start */

static inline void flockfile(FILE *file) { (void)file; /* one thread */ }
static inline void funlockfile(FILE *file) { (void)file; }
#endif
