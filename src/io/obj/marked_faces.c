/* marked_faces.c: the faces of an OBJ whose object, group or material has a name that is asked for.
 */
#include "io/obj/marked_faces.h"
#include "io/obj/obj.h"
#include "io/obj/statements.h"
#include <stdlib.h>
#include <string.h>

enum { KINDS = 3 };
static const char *const KEYWORDS[KINDS] = {"o", "g", "usemtl"};

typedef struct marking {
    const char *end;
    obj_asks_name *asks;
    void *user;
    int marked[KINDS]; /* the name in force is asked for */
} marking;

static int ask(const marking *m, const char *name, size_t length) {
    char *copy = norma_io_copy_text(name, length);
    const int result = copy ? m->asks(m->user, copy) : -1;
    free(copy);
    return result;
}

/* A group statement has several names, the others one that may hold blanks. Returns -1: out of
 * memory. */
static int ask_names(const marking *m, const char *p, int kind) {
    p = norma_obj_skip_blanks(p, m->end);
    const char *end = norma_obj_statement_end(p, m->end, NULL);
    while (end > p && norma_obj_is_blank(end[-1])) --end;
    int asked = ask(m, p, (size_t)(end - p));
    while (kind == 1 && asked == 0 && p < end) {
        const char *word = norma_obj_token_end(p, end);
        asked = ask(m, p, (size_t)(word - p));
        p = word > p ? norma_obj_skip_blanks(word, end) : end;
    }
    return asked;
}

static int kind_of(const char *p, size_t length) {
    for (int kind = 0; kind < KINDS; ++kind)
        if (strlen(KEYWORDS[kind]) == length && memcmp(KEYWORDS[kind], p, length) == 0) return kind;
    return -1;
}

static int has_corner(const char *p, const char *end) {
    obj_corner corner;
    return norma_obj_corner(norma_obj_skip_blanks(p, end), end, &corner);
}

int norma_obj_mark_faces(
    const norma_document *document, obj_asks_name *asks, void *user, uint8_t *marks) {
    const obj_state *state = document->state;
    const char *p = (const char *)document->source.data;
    marking m = {.end = p + document->source.size, .asks = asks, .user = user};
    size_t face = 0;
    if (document->source.size >= 3 && memcmp(p, "\xef\xbb\xbf", 3) == 0) p += 3;
    while (p < m.end) {
        const char *rest;
        p = norma_obj_skip_blanks(p, m.end);
        if (p >= m.end) break;
        const obj_kind is = norma_obj_keyword(p, m.end, &rest);
        const int kind = kind_of(p, (size_t)(rest - p));
        if (kind >= 0 && (m.marked[kind] = ask_names(&m, rest, kind)) < 0) return 0;
        if (is == OBJ_FACE && face < state->face_count && has_corner(rest, m.end))
            marks[face++] = (uint8_t)(m.marked[0] | m.marked[1] | m.marked[2]);
        p = norma_obj_skip_end(norma_obj_statement_end(rest, m.end, NULL), m.end);
    }
    return 1;
}
