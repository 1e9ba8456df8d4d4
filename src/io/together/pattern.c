/* pattern.c: matching without recursion: only the last star is ever gone back to. */
#include "io/together/pattern.h"
#include <stddef.h>

/* One of a set, from behind its bracket; *end: behind the closing one. Without that, NULL. */
static int is_in_set(const char *p, char c, const char **end) {
    const int none_of = *p == '!' || *p == '^';
    int found = 0;
    const char *first = p += none_of;
    for (; *p && (*p != ']' || p == first); ++p) {
        if (p[1] == '-' && p[2] && p[2] != ']') {
            found |=
                (unsigned char)p[0] <= (unsigned char)c && (unsigned char)c <= (unsigned char)p[2];
            p += 2;
        } else {
            found |= *p == c;
        }
    }
    *end = *p ? p + 1 : NULL;
    return found != none_of;
}

/* Whether the first element of the pattern matches c, which is no end; *next: behind it. */
static int matches_one(const char *pattern, char c, const char **next) {
    const char *end = NULL;
    *next = pattern + 1;
    if (*pattern == '?') return 1;
    if (*pattern == '[') {
        const int found = is_in_set(pattern + 1, c, &end);
        if (end) *next = end;
        return end ? found : c == '[';
    }
    if (*pattern == '\\' && pattern[1]) {
        *next = pattern + 2;
        return pattern[1] == c;
    }
    return *pattern == c;
}

int norma_matches(const char *pattern, const char *name) {
    const char *star = NULL, *again = NULL, *next;
    while (*name) {
        if (*pattern == '*') {
            star = ++pattern;
            again = name;
        } else if (*pattern && matches_one(pattern, *name, &next)) {
            pattern = next;
            ++name;
        } else if (star) {
            pattern = star;
            name = ++again;
        } else {
            return 0;
        }
    }
    while (*pattern == '*') ++pattern;
    return !*pattern;
}
