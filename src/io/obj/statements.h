/* statements.h: OBJ text, statement by statement and token by token. Lines end in LF, CR LF or CR,
 * in any mix. A backslash before the end of a line joins the next one to the statement, in every
 * statement, but not in a comment (which may well end in the path of a Windows folder). A comment
 * begins at a # where a token could, and ends with its line. */
#ifndef NORMA_IO_OBJ_TEXT_H
#define NORMA_IO_OBJ_TEXT_H
#include "io/file/watch.h"
#include <stddef.h>
#include <stdint.h>
#include "io/text/digits.h"

typedef enum obj_kind {
    OBJ_NOTHING = 0, /* an empty line, a comment */
    OBJ_POSITION,
    OBJ_NORMAL,
    OBJ_FACE,
    OBJ_SMOOTHING,
    OBJ_OBJECT,
    OBJ_REFERRING, /* may name normals by v/vt/vn: surf, curv, l, p */
    OBJ_SURFACE,   /* the same, a free-form surface */
    OBJ_LIBRARY,   /* names files of materials */
    OBJ_OTHER,     /* passed through */
    OBJ_UNKNOWN
} obj_kind;

static inline int norma_obj_is_end(char c) { return c == '\n' || c == '\r'; }
/* A byte 0 too: ZBrush ends its files with one. */
static inline int norma_obj_is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f' || c == '\0';
}

/* statements.c. All text lies in [p, end). */

const char *norma_obj_skip_joined(const char *p, const char *end);
int norma_obj_is_joined(const char *p, const char *end);
const char *norma_obj_find_statement_end(const char *p, const char *end, norma_watch *watch);
obj_kind norma_obj_look_up_keyword(const char *p, const char *end, const char **rest);

/* Past blanks and joined lines. */
static inline const char *norma_obj_skip_blanks(const char *p, const char *end) {
    p += p < end && *p == ' '; /* nearly always all there is */
    return p < end && (norma_obj_is_blank(*p) || *p == '\\') ? norma_obj_skip_joined(p, end) : p;
}
/* The keyword at p, which is past blanks; *rest: the byte after it. */
static inline obj_kind norma_obj_keyword(const char *p, const char *end, const char **rest) {
    if (p + 1 >= end || p[1] != ' ' || (*p != 'v' && *p != 'f'))
        return norma_obj_look_up_keyword(p, end, rest);
    *rest = p + 1; /* nearly all lines of a file */
    return *p == 'v' ? OBJ_POSITION : OBJ_FACE;
}
/* Where the statement's last line ends: at its line end, or end, also where watch says that it is
 * cancelled. p is a token's place. */
static inline const char *norma_obj_statement_end(
    const char *p, const char *end, norma_watch *watch) {
    return p < end && norma_obj_is_end(*p) ? p : norma_obj_find_statement_end(p, end, watch);
}
/* Past one line end, if there is one at p. */
static inline const char *norma_obj_skip_end(const char *p, const char *end) {
    if (p < end && *p == '\r') return p + 1 < end && p[1] == '\n' ? p + 2 : p + 1;
    return p < end && *p == '\n' ? p + 1 : p;
}
/* Whether p is where a token ends. */
static inline int norma_obj_is_delimiter(const char *p, const char *end) {
    return p >= end || norma_obj_is_blank(*p) || norma_obj_is_end(*p) || *p == '#' ||
           (*p == '\\' && norma_obj_is_joined(p, end));
}
/* The byte after the token at p. */
const char *norma_obj_token_end(const char *p, const char *end);
/* Past what follows a number, which ended at p, in its token. */
const char *norma_obj_number_end(const char *p, const char *end);
/* The number, from 1, of the line that holds the byte at p. */
size_t norma_obj_line(const char *text, const char *p);

/* v, v/vt, v//vn, v/vt/vn; also with empty parts at the end. */
typedef struct obj_corner {
    int64_t position, normal; /* as written */
    int has_normal;
    const char *begin, *end;
    const char
        *texture_end; /* of what stands before the normal's slash: v or v/vt, v where vt is empty */
    int has_texture;
} obj_corner;

/* Whether a corner stands at p, a token's place. */
int norma_obj_corner(const char *p, const char *end, obj_corner *corner);

enum { OBJ_PLAIN_LENGTH = 32 }; /* bytes from p on that norma_obj_read_plain_corner may look at */

/* A corner as nearly all are written: numbers of at most seven digits, and behind them a space or
 * the end of the line. */
typedef struct obj_plain_corner {
    uint32_t position, texture, normal; /* as written; 0 if they are missing, and if they are 0 */
    int has_texture, has_normal;
    const char *texture_end, *end; /* as of obj_corner */
} obj_plain_corner;

/* The number at p and where it ends; NULL: no digit, or eight and more. */
static inline const char *norma_obj_plain_number(const char *p, uint32_t *number) {
#if NORMA_DIGITS_BY_WORD
    const uint64_t bytes = norma_digits_load(p);
    const int digits = norma_digits_count(bytes);
    if (digits == 0 || digits == 8) return NULL;
    *number = (uint32_t)norma_digits_join(bytes, digits);
    return p + digits;
#else
    (void)p, (void)number;
    return NULL;
#endif
}

/* 0: what stands at p, OBJ_PLAIN_LENGTH bytes before the end of the text at least, is something
 * else, or it cannot be told so simply. */
static inline int norma_obj_read_plain_corner(const char *p, obj_plain_corner *corner) {
    corner->texture = corner->normal = 0;
    p = norma_obj_plain_number(p, &corner->position);
    if (!p) return 0;
    corner->texture_end = p;
    corner->has_texture = *p == '/' && p[1] != '/';
    corner->has_normal = 0;
    if (corner->has_texture) {
        p = norma_obj_plain_number(p + 1, &corner->texture);
        if (!p) return 0;
        corner->texture_end = p;
    }
    if (*p == '/') {
        p = norma_obj_plain_number(p + (corner->has_texture ? 1 : 2), &corner->normal);
        if (!p) return 0;
        corner->has_normal = 1;
    }
    corner->end = p;
    return *p == ' ' || norma_obj_is_end(*p);
}

/* The number, from 0, that an index as written means where count elements stand before it;
 * UINT32_MAX: none (0, or before the first). Whether it is below the final count, which is at most
 * UINT32_MAX - 2, the caller sees. */
static inline uint32_t norma_obj_resolve(int64_t index, size_t count) {
    if (index > 0)
        return index <= (int64_t)(UINT32_MAX - 2) ? (uint32_t)(index - 1) : UINT32_MAX - 2;
    return index < 0 && -(index + 1) < (int64_t)count ? (uint32_t)((int64_t)count + index)
                                                      : UINT32_MAX;
}
#endif
