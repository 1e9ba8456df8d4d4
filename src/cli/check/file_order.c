/* file_order.c: files in the order in which people read of them: the worst first, those without
 * problems last; and what several files have in common told once. */
#include "cli/check/check.h"
#include "cli/process/process.h"
#include "cli/text/text.h"
#include <stdlib.h>
#include <string.h>

int check_list_add(check_list *list, const check_entry *entry) {
    check_entry *grown = cli_grow(list->entries, list->count, &list->room, sizeof *grown);
    if (!grown) return 0;
    list->entries = grown;
    list->entries[list->count++] = *entry;
    return 1;
}

void check_list_free(check_list *list) {
    for (size_t i = 0; i < list->count; ++i) free(list->entries[i].text);
    free(list->entries);
    *list = (check_list){0};
}

static int more_first(size_t a, size_t b) { return a == b ? 0 : a > b ? -1 : 1; }

int check_compare_entries(const void *a, const void *b) {
    const check_entry *one = a, *other = b;
    int order = more_first(one->errors, other->errors);
    if (!order) order = more_first(one->warnings, other->warnings);
    if (!order) order = one->is_clean - other->is_clean;
    return order ? order : strcmp(one->path, other->path);
}

void check_list_sort(check_list *list) {
    if (list->count)
        qsort(list->entries, list->count, sizeof *list->entries, check_compare_entries);
}

/* ---- What is told once: a line with CHECK_SAME and a key in front, up to CHECK_SAME_END. The
 * first file that has it tells it, and at CHECK_ALSO names the others. */

enum { KEY_DIGITS = 16, FILES_NAMED = 3 };

typedef struct same_line {
    uint64_t key;
    size_t entry; /* of the list */
} same_line;

static int compare_same(const void *a, const void *b) {
    const same_line *one = a, *other = b;
    if (one->key != other->key) return one->key < other->key ? -1 : 1;
    return one->entry < other->entry ? -1 : one->entry > other->entry;
}

static const char *find_byte(const char *at, const char *end, char byte) {
    const char *found = at < end ? memchr(at, byte, (size_t)(end - at)) : NULL;
    return found ? found : end;
}

static uint64_t read_same_key(const char *at) {
    uint64_t key = 0;
    for (int i = 0; i < KEY_DIGITS; ++i)
        key = 16 * key + (uint64_t)(at[i] <= '9' ? at[i] - '0' : at[i] - 'a' + 10);
    return key;
}

/* lines NULL: only counts them. */
static size_t find_same(const check_list *list, same_line *lines) {
    size_t count = 0;
    for (size_t i = 0; i < list->count; ++i) {
        const char *at = list->entries[i].text, *end = at + list->entries[i].size;
        for (; (at = find_byte(at, end, CHECK_SAME)) + KEY_DIGITS < end; ++at, ++count)
            if (lines) lines[count] = (same_line){read_same_key(at + 1), i};
    }
    return count;
}

static const same_line *first_of(const same_line *lines, size_t count, uint64_t key) {
    size_t low = 0;
    while (count > low) {
        const size_t middle = low + (count - low) / 2;
        if (lines[middle].key < key)
            low = middle + 1;
        else
            count = middle;
    }
    return lines + low;
}

/* " Also in b.obj, c.obj and 2 more files." */
static void write_also(FILE *out, const check_list *list, const same_line *first,
    const same_line *end, const check_settings *settings) {
    size_t files = 0;
    for (const same_line *at = first + 1; at < end && at->key == first->key; ++at) {
        if (at->entry == at[-1].entry || files++ >= FILES_NAMED) continue;
        if (files == 1 && settings->style.width)
            fputs("\n    Also in ", out);
        else
            fputs(files == 1 ? " Also in " : ", ", out);
        cli_write_outside(out, check_shown_path(list->entries[at->entry].path));
    }
    if (files > FILES_NAMED)
        fprintf(out, " and %zu more %s", files - FILES_NAMED,
            files - FILES_NAMED == 1 ? "file" : "files");
    if (files) fputc('.', out);
}

/* From at, behind CHECK_SAME, to behind CHECK_SAME_END. */
static const char *write_same(FILE *out, const check_list *list, size_t entry, const char *at,
    const char *end, const same_line *lines, size_t count, const check_settings *settings) {
    const char *last = find_byte(at, end, CHECK_SAME_END), *also = find_byte(at, last, CHECK_ALSO);
    const same_line *first = first_of(lines, count, read_same_key(at));
    at += KEY_DIGITS;
    if (first->entry == entry) {
        fwrite(at, 1, (size_t)(also - at), out);
        write_also(out, list, first, lines + count, settings);
        if (also < last) fwrite(also + 1, 1, (size_t)(last - also - 1), out);
    }
    return last < end ? last + 1 : end;
}

int check_list_write(
    const check_list *list, const check_format *format, FILE *out, const check_settings *settings) {
    const size_t count = find_same(list, NULL);
    same_line *lines = malloc((count + 1) * sizeof *lines);
    if (!lines) return 0;
    find_same(list, lines);
    qsort(lines, count, sizeof *lines, compare_same);
    for (size_t i = 0; i < list->count; ++i) {
        const char *at = list->entries[i].text, *end = at + list->entries[i].size;
        check_begin_entry(list, i, format, out);
        while (at < end) {
            const char *mark = find_byte(at, end, CHECK_SAME);
            fwrite(at, 1, (size_t)(mark - at), out);
            at = mark + KEY_DIGITS < end
                     ? write_same(out, list, i, mark + 1, end, lines, count, settings)
                     : end;
        }
    }
    free(lines);
    return 1;
}

void check_begin_entry(
    const check_list *list, size_t entry, const check_format *format, FILE *out) {
    const check_entry *at = &list->entries[entry];
    if (format->before_clean && list->count > 1 && at->is_clean && (entry == 0 || !at[-1].is_clean))
        fputs(format->before_clean, out);
}
