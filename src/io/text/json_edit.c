/* json_edit.c: changes to a JSON text. Each is kept with the value that it is about; writing turns
 * them into splices of the old text, so that every byte that no splice covers is copied as it was.
 * What is added stands behind what was there, with the white space that the last one there had
 * before it. */
#include "io/text/text.h"
#include <stdlib.h>
#include <string.h>

typedef struct addition {
    char *key; /* NULL in an array */
    char *text;
    uint32_t next; /* the container's next addition, or JSON_NONE */
} addition;

typedef struct edit {
    uint32_t token;
    char *replacement; /* NULL: none */
    int removed;
    int child_removed;
    uint32_t first_added, last_added;
} edit;

struct json_edits {
    const json *j;
    uint32_t first, tokens; /* the value that they are about: itself and all that is in it */
    uint32_t *of_token;     /* for each of these tokens the number of its edit + 1; 0: none */
    edit *list;
    addition *additions;
    uint32_t count, addition_count;
    size_t capacity, addition_capacity;
    int failed;
};

static char *json_copy_text(const char *text) { return norma_io_copy_text(text, strlen(text)); }

json_edits *norma_json_edits_create(const json *j, uint32_t value) {
    const uint32_t tokens = value < j->count ? j->tokens[value].next - value : 0;
    json_edits *edits = calloc(1, sizeof *edits);
    uint32_t *of_token = calloc(tokens ? tokens : 1, sizeof *of_token);
    if (!edits || !of_token) {
        free(edits);
        free(of_token);
        return NULL;
    }
    edits->j = j;
    edits->first = value;
    edits->tokens = tokens;
    edits->of_token = of_token;
    return edits;
}

void norma_json_edits_destroy(json_edits *edits) {
    if (!edits) return;
    for (uint32_t i = 0; i < edits->count; ++i) free(edits->list[i].replacement);
    for (uint32_t i = 0; i < edits->addition_count; ++i) {
        free(edits->additions[i].key);
        free(edits->additions[i].text);
    }
    free(edits->list);
    free(edits->additions);
    free(edits->of_token);
    free(edits);
}

static int is_within(const json_edits *edits, uint32_t token) {
    return token >= edits->first && token - edits->first < edits->tokens;
}

static edit *edit_of(json_edits *edits, uint32_t token) {
    if (!is_within(edits, token)) {
        edits->failed = 1;
        return NULL;
    }
    uint32_t *number = &edits->of_token[token - edits->first];
    if (*number == 0) {
        edit *grown =
            norma_io_grow(edits->list, &edits->capacity, (size_t)edits->count + 1, sizeof *grown);
        if (!grown) {
            edits->failed = 1;
            return NULL;
        }
        edits->list = grown;
        edits->list[edits->count] =
            (edit){.token = token, .first_added = JSON_NONE, .last_added = JSON_NONE};
        *number = ++edits->count;
    }
    return &edits->list[*number - 1];
}

static const edit *find_edit(const json_edits *edits, uint32_t token) {
    const uint32_t number = is_within(edits, token) ? edits->of_token[token - edits->first] : 0;
    return number ? &edits->list[number - 1] : NULL;
}

static int add_copy_of(json_edits *copy, const json_edits *edits) {
    copy->list = calloc(edits->count ? edits->count : 1, sizeof *copy->list);
    copy->additions =
        calloc(edits->addition_count ? edits->addition_count : 1, sizeof *copy->additions);
    if (!copy->list || !copy->additions) return 0;
    copy->capacity = edits->count;
    copy->addition_capacity = edits->addition_count;
    for (; copy->count < edits->count; ++copy->count) {
        edit *e = &copy->list[copy->count];
        *e = edits->list[copy->count];
        if (e->replacement && !(e->replacement = json_copy_text(e->replacement))) return 0;
    }
    for (; copy->addition_count < edits->addition_count; ++copy->addition_count) {
        addition *to = &copy->additions[copy->addition_count];
        const addition *from = &edits->additions[copy->addition_count];
        *to = (addition){.next = from->next,
            .text = json_copy_text(from->text),
            .key = from->key ? json_copy_text(from->key) : NULL};
        if (!to->text || (from->key && !to->key)) {
            free(to->text);
            free(to->key);
            return 0;
        }
    }
    memcpy(copy->of_token, edits->of_token, edits->tokens * sizeof *copy->of_token);
    copy->failed = edits->failed;
    return 1;
}

json_edits *norma_json_edits_copy(const json_edits *edits) {
    json_edits *copy = norma_json_edits_create(edits->j, edits->first);
    if (copy && !add_copy_of(copy, edits)) {
        norma_json_edits_destroy(copy);
        return NULL;
    }
    return copy;
}

int norma_json_edits_failed(const json_edits *edits) { return edits->failed; }

int norma_json_edits_any(const json_edits *edits) { return edits->count > 0; }

static void set_text(json_edits *edits, char **place, const char *text) {
    char *copy = json_copy_text(text);
    if (!copy) {
        edits->failed = 1;
        return;
    }
    free(*place);
    *place = copy;
}

void norma_json_replace(json_edits *edits, uint32_t value, const char *text) {
    edit *e = edit_of(edits, value);
    if (!e) return;
    e->removed = 0;
    set_text(edits, &e->replacement, text);
}

static void mark_removed(json_edits *edits, uint32_t value) {
    edit *e = edit_of(edits, value);
    if (!e) return;
    e->removed = 1;
    uint32_t parent = edits->j->tokens[value].parent;
    e = parent == JSON_NONE ? NULL : edit_of(edits, parent);
    if (e) e->child_removed = 1;
}

static void json_add(json_edits *edits, uint32_t container, const char *key, const char *text) {
    edit *e = edit_of(edits, container);
    addition *grown = e ? norma_io_grow(edits->additions, &edits->addition_capacity,
                              (size_t)edits->addition_count + 1, sizeof *grown)
                        : NULL;
    if (!grown) {
        edits->failed = 1;
        return;
    }
    edits->additions = grown;
    addition *added = &edits->additions[edits->addition_count];
    *added = (addition){
        .next = JSON_NONE, .text = json_copy_text(text), .key = key ? json_copy_text(key) : NULL};
    if (!added->text || (key && !added->key)) {
        free(added->text);
        free(added->key);
        edits->failed = 1;
        return;
    }
    if (e->last_added == JSON_NONE)
        e->first_added = edits->addition_count;
    else
        edits->additions[e->last_added].next = edits->addition_count;
    e->last_added = edits->addition_count++;
}

void norma_json_append(json_edits *edits, uint32_t array, const char *text) {
    json_add(edits, array, NULL, text);
}

/* The member that was put into an object, or NULL. */
static addition *added_member(json_edits *edits, uint32_t object, const char *key) {
    const edit *e = find_edit(edits, object);
    uint32_t i = e ? e->first_added : JSON_NONE;
    while (i != JSON_NONE && strcmp(edits->additions[i].key, key) != 0)
        i = edits->additions[i].next;
    return i == JSON_NONE ? NULL : &edits->additions[i];
}

void norma_json_set(json_edits *edits, uint32_t object, const char *key, const char *text) {
    uint32_t value = norma_json_member(edits->j, object, key);
    if (value != JSON_NONE) {
        norma_json_replace(edits, value, text);
        return;
    }
    addition *added = added_member(edits, object, key);
    if (added)
        set_text(edits, &added->text, text);
    else
        json_add(edits, object, key, text);
}

void norma_json_unset(json_edits *edits, uint32_t object, const char *key) {
    for (uint32_t value = JSON_NONE; norma_json_each(edits->j, object, &value);)
        if (norma_json_equals(edits->j, value - 1, key)) mark_removed(edits, value);
}

void norma_json_set_made(json_edits *edits, uint32_t object, const char *key, json_text *made) {
    const int is_empty = made->size == 0;
    norma_json_add(made, "", 1);
    if (made->failed)
        edits->failed = 1;
    else if (is_empty)
        norma_json_unset(edits, object, key);
    else
        norma_json_set(edits, object, key, made->data);
    free(made->data);
    *made = (json_text){0};
}

void norma_json_append_made(json_edits *edits, uint32_t object, const char *key, json_text *made) {
    const uint32_t array = norma_json_member(edits->j, object, key);
    const addition *added = array == JSON_NONE ? added_member(edits, object, key) : NULL;
    json_text whole = {0};
    if (array == JSON_NONE) {
        norma_json_add(&whole, added ? added->text : "[", added ? strlen(added->text) - 1 : 1);
        norma_json_add_text(&whole, added ? "," : "");
        norma_json_add(&whole, made->data, made->size);
        norma_json_add_text(&whole, "]");
        whole.failed |= made->failed;
        norma_json_set_made(edits, object, key, &whole);
    } else {
        norma_json_add(made, "", 1);
        if (made->failed)
            edits->failed = 1;
        else
            norma_json_append(edits, array, made->data);
    }
    free(made->data);
    *made = (json_text){0};
}

/* With those of the same name before it, one of which would count instead. */
void norma_json_remove(json_edits *edits, uint32_t value) {
    const uint32_t parent = edits->j->tokens[value].parent;
    if (parent == JSON_NONE || !norma_json_is(edits->j, parent, JSON_OBJECT)) {
        mark_removed(edits, value);
        return;
    }
    char *key = norma_json_string(edits->j, value - 1);
    if (key)
        norma_json_unset(edits, parent, key);
    else
        edits->failed = 1;
    free(key);
}

static void uint_text(uint64_t number, char out[24]) {
    json_text text = {.data = out, .capacity = 24};
    norma_json_add_uint(&text, number);
    out[text.size] = '\0';
}

void norma_json_replace_uint(json_edits *edits, uint32_t value, uint64_t number) {
    char text[24];
    uint_text(number, text);
    norma_json_replace(edits, value, text);
}

void norma_json_set_uint(json_edits *edits, uint32_t object, const char *key, uint64_t number) {
    char text[24];
    uint_text(number, text);
    norma_json_set(edits, object, key, text);
}

/* ---- writing */

typedef struct splice {
    size_t start, end;        /* bytes of the old text that go */
    const edit *additions_of; /* what is put there: the additions of this container, */
    const char *text;         /* or this, or nothing */
} splice;

typedef struct splices {
    splice *list;
    size_t count, capacity;
    int failed;
} splices;

static void add_splice(splices *s, splice one) {
    splice *added = norma_io_add(&s->list, &s->capacity, &s->count, sizeof *added);
    s->failed |= !added;
    if (added) *added = one;
}

/* No two begin at one place: each value is replaced, removed or added to once, and what is added
 * comes behind a container's last value or its bracket. */
static int compare_splices(const void *a, const void *b) {
    const splice *x = a, *y = b;
    return x->start < y->start ? -1 : x->start > y->start;
}

static size_t item_start(const json *j, uint32_t container, uint32_t value) {
    return j->tokens[j->tokens[container].type == JSON_OBJECT ? value - 1 : value].start;
}

/* Removals with the comma that goes with each: the one before it, or the one behind where nothing
 * before it stays. */
static void splice_removed(const json_edits *edits, uint32_t container, splices *s) {
    const json *j = edits->j;
    int kept = 0;
    uint32_t previous = JSON_NONE;
    for (uint32_t value = JSON_NONE; norma_json_each(j, container, &value);) {
        const edit *e = find_edit(edits, value);
        uint32_t next = norma_json_next(j, container, value);
        if (!e || !e->removed)
            kept = 1;
        else if (kept)
            add_splice(s, (splice){.start = j->tokens[previous].end, .end = j->tokens[value].end});
        else
            add_splice(s, (splice){.start = item_start(j, container, value),
                              .end = next == JSON_NONE ? j->tokens[value].end
                                                       : item_start(j, container, next)});
        previous = value;
    }
}

static uint32_t last_value(const json *j, uint32_t container) {
    uint32_t last = JSON_NONE;
    for (uint32_t value = JSON_NONE; norma_json_each(j, container, &value);) last = value;
    return last;
}

static void json_collect(const json_edits *edits, uint32_t root, splices *s) {
    const json *j = edits->j;
    for (uint32_t token = root; token < j->tokens[root].next;) {
        const edit *e = find_edit(edits, token);
        if (e && e->removed) {
            token = j->tokens[token].next;
            continue;
        }
        if (e && e->replacement) {
            add_splice(s, (splice){.start = j->tokens[token].start,
                              .end = j->tokens[token].end,
                              .text = e->replacement});
            token = j->tokens[token].next;
            continue;
        }
        if (e && e->child_removed) splice_removed(edits, token, s);
        if (e && e->first_added != JSON_NONE) {
            uint32_t last = last_value(j, token);
            size_t at = last == JSON_NONE ? j->tokens[token].start + 1 : j->tokens[last].end;
            add_splice(s, (splice){.start = at, .end = at, .additions_of = e});
        }
        ++token;
    }
}

static int is_space(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

/* Whether any value that the text has there stays. */
static int keeps_any(const json_edits *edits, uint32_t container) {
    for (uint32_t value = JSON_NONE; norma_json_each(edits->j, container, &value);) {
        const edit *e = find_edit(edits, value);
        if (!e || !e->removed) return 1;
    }
    return 0;
}

static void write_additions(const json_edits *edits, const edit *e, json_text *out) {
    const json *j = edits->j;
    uint32_t last = last_value(j, e->token);
    int comma = keeps_any(edits, e->token);
    size_t space_end = last == JSON_NONE ? 0 : item_start(j, e->token, last), space = space_end;
    while (space > 0 && is_space(j->text[space - 1])) --space;
    for (uint32_t i = e->first_added; i != JSON_NONE; i = edits->additions[i].next) {
        if (comma) {
            norma_json_add(out, ",", 1);
            norma_json_add(out, j->text + space, space_end - space);
        }
        if (edits->additions[i].key) {
            norma_json_add_quoted(out, edits->additions[i].key);
            norma_json_add(out, ":", 1);
            if (space_end > space) norma_json_add(out, " ", 1);
        }
        norma_json_add_text(out, edits->additions[i].text);
        comma = 1;
    }
}

int norma_json_write(const json_edits *edits, uint32_t value, json_text *out) {
    const json *j = edits->j;
    splices s = {0};
    json_collect(edits, value, &s);
    if (s.count) qsort(s.list, s.count, sizeof *s.list, compare_splices);
    size_t at = value == 0 ? 0 : j->tokens[value].start,
           end = value == 0 ? j->size : j->tokens[value].end;
    for (size_t i = 0; i < s.count; ++i) {
        const splice *one = &s.list[i];
        if (one->start > at) {
            norma_json_add(out, j->text + at, one->start - at);
            at = one->start;
        }
        if (one->text) norma_json_add_text(out, one->text);
        if (one->additions_of) write_additions(edits, one->additions_of, out);
        if (one->end > at) at = one->end;
    }
    norma_json_add(out, j->text + at, end - at);
    free(s.list);
    return !s.failed && !edits->failed && !out->failed;
}
