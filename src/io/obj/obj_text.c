/* obj_text.c: the grammar of OBJ's lines, as little of it as normals need; and one pass over a part
 * of the text. */
#include "io/obj/obj.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- The grammar of OBJ's lines, as little of it as normals need. */

/* A backslash at p, then nothing but blanks up to the line end: the byte after that, else NULL. At
 * the end of the text it joins nothing. */
static const char *obj_joined(const char *p, const char *end) {
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
        const char *next = obj_joined(p, end);
        if (!next) break;
        p = next;
    }
    return p;
}

int norma_obj_is_joined(const char *p, const char *end) { return obj_joined(p, end) != NULL; }

const char *norma_obj_token_end(const char *p, const char *end) {
    while (p < end && !norma_obj_is_blank(*p) && !norma_obj_is_end(*p) &&
           (*p != '\\' || !obj_joined(p, end)))
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
static const char *obj_find_mark(const char *p, const char *end) {
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
        const char *mark = obj_find_mark(p, p + WATCH_BYTES);
        if (mark < p + WATCH_BYTES) return mark;
        if (norma_watch_cancelled(watch)) return end;
    }
    return obj_find_mark(p, end);
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

static obj_kind obj_look_up(const char *word, size_t length) {
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
    return obj_look_up(p, (size_t)(*rest - p));
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

/* ---- One pass over a part of the text, statement by statement, into arrays. They grow
 * with what the text holds, never by a count in it. Faces may name positions that follow them:
 * whether each is there is seen when all parts are together. */

enum { ASK_EACH = 1 << 18 }; /* corners of a face, from one question to the next */

typedef struct reader {
    const norma_document *document;
    norma_document_error *error; /* NULL: nobody is told; a whole reading tells */
    obj_part *part;
    const char *end;       /* of the part */
    const char *statement; /* where the one that is read now begins, blanks before it included */
    norma_watch *watch;
    const void *asked; /* where it was last asked whether to go on */
    void *grown;       /* what RESERVE got */
} reader;

static norma_document_result fail_at(const reader *r, const char *p, const char *expected) {
    char place[24];
    if (!r->error) return NORMA_DOCUMENT_ERROR_MALFORMED;
    const char *token_end = norma_obj_token_end(p, r->end);
    int length = token_end - p > 40 ? 40 : (int)(token_end - p);
    place[norma_number_format_integer(norma_obj_line(r->part->text, p), place)] = 0;
    if (length == 0)
        return norma_document_fail(r->document, r->error, NORMA_DOCUMENT_ERROR_MALFORMED, place,
            "the statement ends where %s was expected", expected);
    return norma_document_fail(r->document, r->error, NORMA_DOCUMENT_ERROR_MALFORMED, place,
        "\"%.*s\" where %s was expected", length, p, expected);
}

static norma_document_result fail_count(const reader *r, const char *what) {
    return norma_document_fail(r->document, r->error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
        "more than 4294967293 %s; this version reads no more", what);
}

static norma_document_result obj_fail_memory(const reader *r) {
    return norma_document_fail_memory(r->document, r->error);
}

/* Nonzero where block has room for needed elements of size bytes, or was given it. */
#define RESERVE(r, block, room, needed, size)                                                      \
    (((block) && (needed) <= (room)) ||                                                            \
        (((r)->grown = norma_io_grow((block), &(room), (needed), (size))) != NULL &&               \
            ((block) = (r)->grown, 1)))

static void see_oddity(obj_oddity *oddity, const char *p) {
    if (!oddity->count++) oddity->first = p;
}

/* Whether the number has more digits than a float needs. plain: it without its point, or more. */
static int is_long(uint64_t plain, const char *p, const char *end) {
    const uint64_t limit = 1000000000; /* ten digits */
    return plain >= limit && norma_significant_digits(p, end) > FLT_DECIMAL_DIG;
}

/* What follows a number in its token is passed over, as other readers do ("3.1+e2" is 3.1), and
 * noted; but not a comma, which were a decimal one. *has_long is set if a number is long. */
static norma_document_result obj_read_numbers(
    reader *r, const char **p, double numbers[3], const char *expected, int *has_long) {
    for (int i = 0; i < 3; ++i) {
        uint64_t plain = UINT64_MAX;
        *p = norma_obj_skip_blanks(*p, r->end);
        const char *next = norma_digits_plain(*p, r->end, &numbers[i], &plain);
        if (!next) next = norma_number_parse(*p, r->end, &numbers[i]);
        int whole = next && norma_obj_is_delimiter(next, r->end);
        if (!next || (!whole && *next == ',')) return fail_at(r, *p, expected);
        *has_long |= is_long(plain, *p, next);
        if (!whole) {
            see_oddity(&r->part->odd_number, *p);
            next = norma_obj_number_end(next, r->end);
        }
        *p = next;
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result obj_read_position(reader *r, const char **p) {
    obj_part *part = r->part;
    if (part->position_count >= OBJ_MOST) return fail_count(r, "positions");
    if (!RESERVE(
            r, part->positions, part->position_room, part->position_count + 1, 3 * sizeof(double)))
        return obj_fail_memory(r);
    norma_document_result result =
        obj_read_numbers(r, p, part->positions + 3 * part->position_count,
            "one of a position's three numbers", &part->has_long_positions);
    part->position_count += result == NORMA_DOCUMENT_OK;
    return result;
}

static float to_float(double value) {
    return fabs(value) > 3.4028235677973366e38 ? copysignf(INFINITY, (float)copysign(1, value))
                                               : (float)value;
}

static void see_first(const reader *r, size_t *first) {
    if (*first == SIZE_MAX) *first = (size_t)(r->statement - r->part->text);
}

static norma_document_result obj_read_normal(reader *r, const char **p) {
    obj_part *part = r->part;
    size_t count = part->normal_count;
    double numbers[3];
    int has_long = 1;
    if (count >= OBJ_MOST) return fail_count(r, "normals");
    if (!RESERVE(r, part->normals, part->normal_room, count + 1, 3 * sizeof(float)) ||
        !RESERVE(r, part->normal_offsets, part->normal_offset_room, count + 1, sizeof(size_t)))
        return obj_fail_memory(r);
    norma_document_result result =
        obj_read_numbers(r, p, numbers, "one of a normal's three numbers", &has_long);
    if (result) return result;
    see_first(r, &part->first_normal);
    for (int i = 0; i < 3; ++i) part->normals[3 * count + (size_t)i] = to_float(numbers[i]);
    part->normal_offsets[count] = (size_t)(r->statement - part->text);
    part->normal_count = count + 1;
    return NORMA_DOCUMENT_OK;
}

/* ---- faces */

/* The number that an index means, of an element in slot of a list, where count of what it names
 * stand before it in the part; UINT32_MAX: none. What counts back is remembered, and nothing yet.
 */
static norma_document_result obj_resolve(
    reader *r, int64_t index, size_t count, obj_list list, size_t slot, uint32_t *number) {
    obj_part *part = r->part;
    if (index >= 0 || part->whole) {
        *number = norma_obj_resolve(index, count);
        return NORMA_DOCUMENT_OK;
    }
    *number = 0;
    if (!RESERVE(r, part->relatives, part->relative_room, part->relative_count + 1,
            sizeof(obj_relative)))
        return obj_fail_memory(r);
    const int64_t least = -(int64_t)OBJ_MOST - 1; /* farther back is before all that may be there */
    part->relatives[part->relative_count++] =
        (obj_relative){list, slot, (index < least ? 2 * least : index) + (int64_t)count};
    return NORMA_DOCUMENT_OK;
}

/* The normal of the corner that comes next. Those before the first one that names any have none. */
static norma_document_result name_normal(reader *r, const obj_corner *corner, uint32_t *normal) {
    obj_part *part = r->part;
    *normal = OBJ_NO_NORMAL;
    if (!corner->has_normal) return NORMA_DOCUMENT_OK;
    if (!part->names_normals && part->corner_count)
        memset(part->corner_normals, 0xff, part->corner_count * sizeof *part->corner_normals);
    part->names_normals = 1;
    norma_document_result result = obj_resolve(
        r, corner->normal, part->normal_count, OBJ_OF_CORNER_NORMAL, part->corner_count, normal);
    if (result || (corner->normal < 0 && !part->whole)) return result;
    if (*normal == UINT32_MAX)
        *normal = OBJ_BAD_NORMAL;
    else if (*normal > part->last_normal)
        part->last_normal = *normal;
    part->has_normals |= *normal != OBJ_BAD_NORMAL;
    part->bad_normal_count += *normal == OBJ_BAD_NORMAL;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result obj_add_corner(reader *r, const obj_corner *corner) {
    obj_part *part = r->part;
    size_t count = part->corner_count;
    uint32_t position, normal;
    if (count >= OBJ_MOST) return fail_count(r, "corners");
    if (!RESERVE(r, part->corners, part->corner_room, count + 1, sizeof(uint32_t)) ||
        !RESERVE(r, part->corner_normals, part->corner_normal_room, count + 1, sizeof(uint32_t)))
        return obj_fail_memory(r);
    norma_document_result result =
        obj_resolve(r, corner->position, part->position_count, OBJ_OF_CORNER, count, &position);
    if (!result && position == UINT32_MAX)
        return fail_at(r, corner->begin,
            corner->position ? "a position that stands before this face"
                             : "a position, numbered from 1,");
    if (!result) result = name_normal(r, corner, &normal);
    if (result) return result;
    if (position > part->last_position) part->last_position = position;
    part->corners[count] = position;
    if (part->names_normals) part->corner_normals[count] = normal;
    part->corner_count = count + 1;
    return NORMA_DOCUMENT_OK;
}

/* Plain corners, as far as there is room and they come: how many. The part's first corner that
 * names a normal is not among them, nor one without a normal behind it. */
static size_t add_plain_corners(reader *r, const char **p) {
    obj_part *part = r->part;
    const size_t before = part->corner_count, room = part->corner_normal_room < part->corner_room
                                                         ? part->corner_normal_room
                                                         : part->corner_room;
    size_t count = before;
    uint32_t last = part->last_position, last_normal = part->last_normal;
    obj_plain_corner corner;
    for (const char *at = *p; r->end - at > OBJ_PLAIN_LENGTH && count < room && *at == ' ';) {
        if (!norma_obj_read_plain_corner(at + 1, &corner) || !corner.position ||
            corner.has_normal != part->names_normals || (corner.has_normal && !corner.normal))
            break;
        const uint32_t position = corner.position - 1, normal = corner.normal - 1;
        last = position > last ? position : last;
        part->corners[count] = position;
        if (corner.has_normal) {
            last_normal = normal > last_normal ? normal : last_normal;
            part->corner_normals[count] = normal;
            part->has_normals = 1;
        }
        ++count;
        *p = at = corner.end;
    }
    part->last_position = last;
    part->last_normal = last_normal;
    part->corner_count = count;
    return count - before;
}

static norma_document_result end_face(reader *r, size_t corners) {
    obj_part *part = r->part;
    if (!RESERVE(r, part->face_ends, part->face_room, part->face_count + 1, sizeof(uint32_t)))
        return obj_fail_memory(r);
    see_first(r, &part->first_face);
    part->has_polygons |= corners != 3;
    part->face_ends[part->face_count++] = (uint32_t)part->corner_count;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result read_face(reader *r, const char **p) {
    size_t corners = add_plain_corners(r, p);
    for (;; ++corners) {
        obj_corner corner;
        if (corners % ASK_EACH == ASK_EACH - 1 && norma_watch_cancelled(r->watch))
            return NORMA_DOCUMENT_CANCELLED;
        *p = norma_obj_skip_blanks(*p, r->end);
        if (*p >= r->end || norma_obj_is_end(**p) || **p == '#') break;
        if (!norma_obj_corner(*p, r->end, &corner))
            return fail_at(r, *p, "a corner (v, v/vt, v//vn or v/vt/vn)");
        norma_document_result result = obj_add_corner(r, &corner);
        if (result) return result;
        *p = corner.end;
    }
    if (corners >= 3) return end_face(r, corners);
    if (corners == 0) { /* it says nothing, and is passed through like what is not known */
        see_oddity(&r->part->empty_face, r->statement);
        return NORMA_DOCUMENT_OK;
    }
    if (!r->error) return NORMA_DOCUMENT_ERROR_MALFORMED;
    char place[24];
    const char *first = norma_obj_skip_blanks(r->statement, r->end);
    place[norma_number_format_integer(norma_obj_line(r->part->text, first), place)] = 0;
    return norma_document_fail(r->document, r->error, NORMA_DOCUMENT_ERROR_MALFORMED, place,
        "a face of %zu corners, where at least three were expected", corners);
}

/* Normals that surfaces, curves, lines and points name: a v/vt/vn anywhere in them. */
static norma_document_result read_referring(reader *r, const char **p) {
    obj_part *part = r->part;
    for (;;) {
        obj_corner corner;
        if (norma_watch_passed(r->watch, &r->asked, *p)) return NORMA_DOCUMENT_CANCELLED;
        *p = norma_obj_skip_blanks(*p, r->end);
        if (*p >= r->end || norma_obj_is_end(**p) || **p == '#') return NORMA_DOCUMENT_OK;
        if (norma_obj_corner(*p, r->end, &corner) && corner.has_normal) {
            uint32_t normal;
            if (!RESERVE(r, part->other_normals, part->other_room, part->other_count + 1,
                    sizeof(uint32_t)))
                return obj_fail_memory(r);
            norma_document_result result = obj_resolve(r, corner.normal, part->normal_count,
                OBJ_OF_OTHER_NORMAL, part->other_count, &normal);
            if (result) return result;
            part->other_normals[part->other_count++] =
                normal == UINT32_MAX ? OBJ_BAD_NORMAL : normal;
        }
        *p = norma_obj_token_end(*p, r->end);
    }
}

/* ---- other statements */

/* Another number for every other text. */
static int64_t group_of_text(const char *p, const char *end) {
    uint64_t hash = UINT64_C(14695981039346656037);
    for (; p < end; ++p) hash = (hash ^ (unsigned char)*p) * UINT64_C(1099511628211);
    return (int64_t)(hash >> 2 | UINT64_C(1) << 62);
}

/* A number, "off", or nothing, which is off. Numbers too large for 64 bits, and words, are groups
 * as well: equal texts are equal. */
static norma_document_result read_smoothing(reader *r, const char **p) {
    obj_part *part = r->part;
    int64_t group = 0;
    *p = norma_obj_skip_blanks(*p, r->end);
    const char *token_end = norma_obj_token_end(*p, r->end);
    size_t length = (size_t)(token_end - *p);
    int off = length == 0 || **p == '#' || (length == 3 && memcmp(*p, "off", 3) == 0);
    if (!off && norma_number_parse_integer(*p, r->end, &group) != token_end)
        group = group_of_text(*p, token_end);
    if (!RESERVE(r, part->runs, part->run_room, part->run_count + 1, sizeof(obj_run)))
        return obj_fail_memory(r);
    part->runs[part->run_count++] = (obj_run){part->face_count, group};
    return NORMA_DOCUMENT_OK;
}

static void read_object(reader *r, const char **p) {
    *p = norma_obj_skip_blanks(*p, r->end);
    const char *name = *p;
    *p = norma_obj_statement_end(*p, r->end, r->watch);
    if (r->part->name) return;
    const char *name_end = *p;
    while (name_end > name && norma_obj_is_blank(name_end[-1])) --name_end;
    r->part->name = name;
    r->part->name_end = name_end;
}

static void see_library(obj_part *part, size_t offset) {
    if (part->first_library == SIZE_MAX) part->first_library = offset;
    part->last_library = offset;
}

/* A word that is no OBJ statement is passed through, and noted; but what is not even text is no
 * OBJ. */
static norma_document_result see_unknown(reader *r, const char *word, const char *word_end) {
    for (const char *p = word; p < word_end; ++p)
        if ((unsigned char)*p < 0x20 || *p == 0x7f) {
            char place[24];
            if (!r->error) return NORMA_DOCUMENT_ERROR_MALFORMED;
            place[norma_number_format_integer(norma_obj_line(r->part->text, p), place)] = 0;
            return norma_document_fail(r->document, r->error, NORMA_DOCUMENT_ERROR_MALFORMED, place,
                "a byte of value %d where a statement's text was expected", (unsigned char)*p);
        }
    see_oddity(&r->part->unknown, word);
    return NORMA_DOCUMENT_OK;
}

/* Reads what the statement's kind needs; *p then lies somewhere in the statement, at a token or a
 * token's end. */
static norma_document_result read_statement(reader *r, const char **p) {
    const char *word = *p;
    obj_kind kind = norma_obj_keyword(word, r->end, p);
    r->part->has_surfaces |= kind == OBJ_SURFACE;
    r->part->known |= kind != OBJ_NOTHING && kind != OBJ_UNKNOWN;
    switch (kind) {
    case OBJ_POSITION:
        return obj_read_position(r, p);
    case OBJ_NORMAL:
        return obj_read_normal(r, p);
    case OBJ_FACE:
        return read_face(r, p);
    case OBJ_REFERRING:
    case OBJ_SURFACE:
        return read_referring(r, p);
    case OBJ_SMOOTHING:
        return read_smoothing(r, p);
    case OBJ_OBJECT:
        read_object(r, p);
        return NORMA_DOCUMENT_OK;
    case OBJ_LIBRARY:
        see_library(r->part, (size_t)(word - r->part->text));
        return NORMA_DOCUMENT_OK;
    case OBJ_UNKNOWN:
        return see_unknown(r, word, *p);
    default:
        return NORMA_DOCUMENT_OK;
    }
}

/* ---- parts */

static void empty(obj_part *part) {
    part->position_count = part->corner_count = part->face_count = part->normal_count =
        part->other_count = part->run_count = part->relative_count = 0;
    part->last_position = part->last_normal = 0;
    part->bad_normal_count = 0;
    part->name = part->name_end = NULL;
    part->first_normal = part->first_face = part->first_library = part->last_library = SIZE_MAX;
    part->names_normals = part->has_normals = part->has_surfaces = part->has_polygons =
        part->known = part->has_long_positions = 0;
    part->unknown = part->empty_face = part->odd_number = (obj_oddity){0, NULL};
}

norma_document_result norma_obj_read_part(
    const norma_document *document, obj_part *part, norma_document_error *error) {
    reader r = {.document = document,
        .error = error,
        .part = part,
        .end = part->end,
        .watch = norma_document_watch(document),
        .asked = part->begin};
    empty(part);
    part->result = NORMA_DOCUMENT_OK;
    for (const char *p = part->begin; p < part->end && !part->result;) {
        r.statement = p;
        p = norma_obj_skip_blanks(p, part->end);
        part->result = read_statement(&r, &p);
        if (!part->result)
            p = norma_obj_skip_end(norma_obj_statement_end(p, part->end, r.watch), part->end);
        if (!part->result && norma_watch_passed(r.watch, &r.asked, p))
            part->result = NORMA_DOCUMENT_CANCELLED;
    }
    return part->result;
}

void norma_obj_free_part(obj_part *part) {
    free(part->positions);
    free(part->corners);
    free(part->corner_normals);
    free(part->face_ends);
    free(part->other_normals);
    free(part->normals);
    free(part->normal_offsets);
    free(part->runs);
    free(part->relatives);
}

/* A backslash before the line end, blanks between them aside, may join the next line: what follows
 * such a line is taken as no beginning. */
static int may_be_joined(const char *text, const char *line_end) {
    while (line_end > text && norma_obj_is_blank(line_end[-1])) --line_end;
    return line_end > text && line_end[-1] == '\\';
}

const char *norma_obj_part_end(
    const char *text, const char *from, const char *end, norma_watch *watch) {
    const void *asked = from;
    for (const char *p = from; p < end && !norma_watch_passed(watch, &asked, p);) {
        if (!norma_obj_is_end(*p)) {
            ++p;
            continue;
        }
        const char *line_end = *p == '\n' && p > text && p[-1] == '\r' ? p - 1 : p;
        p = norma_obj_skip_end(p, end);
        if (!may_be_joined(text, line_end)) return p;
    }
    return end;
}
