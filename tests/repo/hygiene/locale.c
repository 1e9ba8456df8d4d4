/* locale.c DECIMAL-POINT FILE...: a program in the locale of its environment, whose decimal point
 * must be the one given: reads files, computes, transforms, checks, and prints what is written and
 * said. tests/repo/hygiene.sh runs it in two locales: the bytes must be the same. */
#include <locale.h>
#include <norma/check.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int put(void *user, const void *bytes, size_t size) {
    return fwrite(bytes, 1, size, user) != size;
}

static void said(norma_document_result result, const norma_document_error *error) {
    if (result) printf("%d: %s\n", (int)result, error->message);
}

static void one(const char *path, int change) {
    norma_document *document = NULL;
    norma_findings *findings = NULL;
    norma_document_error error = {0};
    const norma_document_result opened = norma_document_open(path, NULL, &document, &error);
    said(opened, &error);
    if (opened) return;
    if (change == 0) {
        said(norma_check_document(document, NULL, &findings, &error), &error);
        for (size_t i = 0; findings && i < norma_findings_count(findings); ++i)
            puts(norma_findings_get(findings, i)->message);
        norma_findings_free(findings);
        said(norma_document_compute(document, NULL, NULL, &error), &error);
    } else {
        const norma_transform_options options = {
            .matrix = {1.5, 0, 0, 0, .25, .5, 0, 0, 0, 0, 2, 0, .1, .2, .3, 1}};
        said(norma_document_transform(document, &options, NULL, &error), &error);
    }
    said(norma_document_write(document, put, stdout, &error), &error);
    norma_document_close(document);
}

int main(int count, char **words) {
    if (count < 3 || !setlocale(LC_ALL, "") || strcmp(localeconv()->decimal_point, words[1]) != 0) {
        fprintf(stderr, "the locale is not there, or its decimal point is \"%s\"\n",
            localeconv()->decimal_point);
        return 2;
    }
    for (int i = 2; i < count; ++i) {
        one(words[i], 0);
        one(words[i], 1);
    }
    one("no-such-folder/file.obj", 0);
    one(".", 0);
    return ferror(stdout) ? 1 : 0;
}
