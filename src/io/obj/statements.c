/* statements.c: the grammar of OBJ's lines, as little of it as normals need. */
#include "io/obj/statements.h"
#include <string.h>
#include "io/text/digits.h"
#include "io/text/number.h"

/* A backslash at p, then nothing but blanks up to the line end: the byte after that, else NULL. At
 * the end of the text it joins nothing. */
static const char *joined(const char *p, const char *end) {
    if (*p != '\\') return NULL;
    do ++p;
    while (p < end && norma_obj_is_blank(*p));
    if (p < end && !norma_obj_is_end(*p)) return NULL;
    return norma_obj_skip_end(p, end);
}

const char *norma_obj_skip_joined(const char *p, const char *end) {
    while (p < end) {
        if (norma_obj_is_blank(*p)) {
            ++p;
            continue;
        }
        const char *next = joined(p, end);
        if (!next) break;
        p = next;
    }
    return p;
}

int norma_obj_is_joined(const char *p, const char *end) { return joined(p, end) != NULL; }

const char *norma_obj_token_end(const char *p, const char *end) {
    while (p < end && !norma_obj_is_blank(*p) && !norma_obj_is_end(*p) &&
           (*p != '\\' || !joined(p, end)))
        ++p;
    return p;
}

const char *norma_obj_number_end(const char *p, const char *end) {
    return norma_obj_is_delimiter(p, end) ? p : norma_obj_token_end(p, end);
}

static const char *line_end(const char *p, const char *end, norma_watch *watch) {
    for (const void *asked = p; p < end && !norma_obj_is_end(*p); ++p)
        if (norma_watch_passed(watch, &asked, p)) return end;
    return p;
}

/* Comparisons of sixteen bytes at once, where gcc and clang have instructions for them. */
#if NORMA_DIGITS_BY_WORD && (defined(__SSE2__) || defined(__ARM_NEON) || defined(__wasm_simd128__))
#define BY_VECTOR 1
typedef char text_vector __attribute__((vector_size(16)));
#else
#define BY_VECTOR 0
#endif

/* The first byte that may end a statement, begin a comment or join a line; end if there is none. */
static const char *find_mark(const char *p, const char *end) {
#if BY_VECTOR
    for (text_vector bytes; end - p >= 16; p += 16) {
        uint64_t marks[2];
        memcpy(&bytes, p, sizeof bytes);
        bytes = (text_vector)((bytes == '\n') | (bytes == '\r') | (bytes == '#') | (bytes == '\\'));
        memcpy(marks, &bytes, sizeof marks);
        if (marks[0]) return p + __builtin_ctzll(marks[0]) / 8;
        if (marks[1]) return p + 8 + __builtin_ctzll(marks[1]) / 8;
    }
#endif
#if NORMA_DIGITS_BY_WORD
    const uint64_t ones = UINT64_C(0x0101010101010101);
    for (uint64_t bytes; end - p >= 8; p += 8) {
        memcpy(&bytes, p, sizeof bytes);
        uint64_t marks = 0;
        for (size_t i = 0; i < 4; ++i) {
            const uint64_t others = bytes ^ ones * (unsigned char)"\n\r#\\"[i];
            marks |= (others - ones) & ~others; /* the lowest that is set is one */
        }
        marks &= ones << 7;
        if (marks) return p + __builtin_ctzll(marks) / 8;
    }
#endif
    while (p < end && !norma_obj_is_end(*p) && *p != '#' && *p != '\\') ++p;
    return p;
}

/* In slices, so that a cancel is noticed soon. */
static const char *find_mark_watched(const char *p, const char *end, norma_watch *watch) {
    for (; end - p > WATCH_BYTES; p += WATCH_BYTES) {
        const char *mark = find_mark(p, p + WATCH_BYTES);
        if (mark < p + WATCH_BYTES) return mark;
        if (norma_watch_cancelled(watch)) return end;
    }
    return find_mark(p, end);
}

const char *norma_obj_find_statement_end(const char *p, const char *end, norma_watch *watch) {
    const char *mark = find_mark_watched(p, end, watch); /* nearly always the end of the line */
    if (mark >= end || norma_obj_is_end(*mark)) return mark;
    for (const void *asked = p; !norma_watch_passed(watch, &asked, p);) {
        p = norma_obj_skip_blanks(p, end);
        if (p >= end || norma_obj_is_end(*p)) return p;
        if (*p == '#') return line_end(p, end, watch);
        p = norma_obj_token_end(p, end);
    }
    return end;
}

size_t norma_obj_line(const char *text, const char *p) {
    size_t line = 1;
    for (const char *q = text; q < p; ++q)
        line += *q == '\n' || (*q == '\r' && (q + 1 == p || q[1] != '\n'));
    return line;
}

/* All of the OBJ specification 3.0, and the older statements that it names. */
static const struct {
    const char *word;
    obj_kind kind;
} keywords[] = {{"v", OBJ_POSITION}, {"vn", OBJ_NORMAL}, {"f", OBJ_FACE}, {"vt", OBJ_OTHER},
    {"fo", OBJ_FACE}, {"s", OBJ_SMOOTHING}, {"o", OBJ_OBJECT}, {"l", OBJ_REFERRING},
    {"p", OBJ_REFERRING}, {"curv", OBJ_REFERRING}, {"surf", OBJ_SURFACE}, {"vp", OBJ_OTHER},
    {"g", OBJ_OTHER}, {"usemtl", OBJ_OTHER}, {"mtllib", OBJ_LIBRARY}, {"mg", OBJ_OTHER},
    {"usemap", OBJ_OTHER}, {"maplib", OBJ_OTHER}, {"cstype", OBJ_OTHER}, {"deg", OBJ_OTHER},
    {"bmat", OBJ_OTHER}, {"step", OBJ_OTHER}, {"curv2", OBJ_OTHER}, {"parm", OBJ_OTHER},
    {"trim", OBJ_OTHER}, {"hole", OBJ_OTHER}, {"scrv", OBJ_OTHER}, {"sp", OBJ_OTHER},
    {"end", OBJ_OTHER}, {"con", OBJ_OTHER}, {"bevel", OBJ_OTHER}, {"c_interp", OBJ_OTHER},
    {"d_interp", OBJ_OTHER}, {"lod", OBJ_OTHER}, {"shadow_obj", OBJ_OTHER},
    {"trace_obj", OBJ_OTHER}, {"ctech", OBJ_OTHER}, {"stech", OBJ_OTHER}, {"call", OBJ_OTHER},
    {"csh", OBJ_OTHER}, {"bsp", OBJ_OTHER}, {"bzp", OBJ_OTHER}, {"cdc", OBJ_OTHER},
    {"cdp", OBJ_OTHER}, {"res", OBJ_OTHER}};

static obj_kind look_up(const char *word, size_t length) {
    for (size_t i = 0; i < sizeof keywords / sizeof keywords[0]; ++i)
        if (strlen(keywords[i].word) == length && memcmp(keywords[i].word, word, length) == 0)
            return keywords[i].kind;
    return OBJ_UNKNOWN;
}

obj_kind norma_obj_look_up_keyword(const char *p, const char *end, const char **rest) {
    if (p + 2 < end && p[2] == ' ' && *p == 'v' && (p[1] == 't' || p[1] == 'n')) {
        *rest = p + 2;
        return p[1] == 't' ? OBJ_OTHER : OBJ_NORMAL;
    }
    *rest = p;
    if (p >= end || norma_obj_is_end(*p) || *p == '#') return OBJ_NOTHING;
    *rest = norma_obj_token_end(p, end);
    return look_up(p, (size_t)(*rest - p));
}

/* The digits at *p, fewer than 18, with something else behind them. 0: something else stands there,
 * or it cannot be told so simply. */
static inline int read_digits(const char **p, const char *end, int64_t *index) {
#if NORMA_DIGITS_BY_WORD
    if (end - *p >= 8) {
        const uint64_t bytes = norma_digits_load(*p);
        const int count = norma_digits_count(bytes);
        if (count > 0 && count < 8) {
            *index = (int64_t)norma_digits_join(bytes, count);
            *p += count;
            return 1;
        }
    }
#endif
    const char *digits = *p;
    int64_t value = 0;
    for (; digits < end && digits - *p < 18 && (unsigned char)(*digits - '0') < 10; ++digits)
        value = 10 * value + (*digits - '0');
    if (digits == *p || (digits < end && (unsigned char)(*digits - '0') < 10)) return 0;
    *index = value;
    *p = digits;
    return 1;
}

/* An integer, or nothing where the text is empty there (*is_there); 0 where something else stands
 * there. */
static int read_index(const char **p, const char *end, int64_t *index, int *is_there) {
    *is_there = 1;
    if (read_digits(p, end, index)) /* nearly always */
        return 1;
    *is_there = !norma_obj_is_delimiter(*p, end) && **p != '/';
    if (!*is_there) return 1;
    const char *next = norma_number_parse_integer(*p, end, index);
    if (next) *p = next;
    return next != NULL;
}

int norma_obj_corner(const char *p, const char *end, obj_corner *corner) {
    int64_t texture;
    int has_position;
    *corner = (obj_corner){.begin = p};
    if (!read_index(&p, end, &corner->position, &has_position) || !has_position) return 0;
    corner->texture_end = p;
    if (p < end && *p == '/') {
        ++p;
        if (!read_index(&p, end, &texture, &corner->has_texture)) return 0;
        if (corner->has_texture) corner->texture_end = p;
        if (p < end && *p == '/') {
            ++p;
            if (!read_index(&p, end, &corner->normal, &corner->has_normal)) return 0;
        }
    }
    corner->end = p;
    return norma_obj_is_delimiter(p, end);
}
