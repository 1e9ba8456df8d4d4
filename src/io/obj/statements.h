/* statements.h: OBJ text, statement by statement and token by token. Lines end in LF, CR LF or CR,
 * in any mix. A backslash before the end of a line joins the next one to the statement, in every
 * statement, but not in a comment (which may well end in the path of a Windows folder). A comment
 * begins at a # where a token could, and ends with its line. */
#ifndef NORMA_IO_OBJ_TEXT_H
#define NORMA_IO_OBJ_TEXT_H
#include <stddef.h>
#include <stdint.h>

typedef enum obj_kind {
    OBJ_NOTHING = 0, /* an empty line, a comment */
    OBJ_POSITION,
    OBJ_NORMAL,
    OBJ_FACE,
    OBJ_SMOOTHING,
    OBJ_OBJECT,
    OBJ_REFERRING, /* may name normals by v/vt/vn: surf, curv, l, p */
    OBJ_SURFACE,   /* the same, a free-form surface */
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
const char *norma_obj_find_statement_end(const char *p, const char *end);

/* Past blanks and joined lines. */
static inline const char *norma_obj_skip_blanks(const char *p, const char *end) {
    while (p < end && norma_obj_is_blank(*p)) ++p;
    return p < end && *p == '\\' ? norma_obj_skip_joined(p, end) : p;
}
/* The keyword at p, which is past blanks; *rest: the byte after it. */
obj_kind norma_obj_keyword(const char *p, const char *end, const char **rest);
/* Where the statement's last line ends: at its line end, or end. p is a token's place. */
static inline const char *norma_obj_statement_end(const char *p, const char *end) {
    return p < end && norma_obj_is_end(*p) ? p : norma_obj_find_statement_end(p, end);
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
