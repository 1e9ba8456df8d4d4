/* acid_screens.c: made screenshots of an acid scene for scripts, and what the judge says of many.
 *   acid_screens layout OUT.json         their layout
 *   acid_screens shot NUMBER OUT.png     one of them; prints what each subject shows
 *   acid_screens table COUNT [FIRST]     judges COUNT of them: mistake put in by verdict, in
 * Markdown
 */
#include "acid_shots.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *shown_name(const acid_shot *shot, const acid_layout *layout, size_t row) {
    const int what = shot->shows[row];
    return what == ACID_SHOWS_NOTHING ? "nothing"
           : what == ACID_SHOWS_OTHER ? "other"
                                      : layout->rows[row].references[what].id;
}

/* ---- files */

static int write_file(const char *path, const void *bytes, size_t size) {
    FILE *out = fopen(path, "wb");
    if (!out) return 3;
    const int whole = fwrite(bytes, 1, size, out) == size;
    return fclose(out) == 0 && whole ? 0 : 3;
}

static void print_box(FILE *out, const acid_box *box) {
    fprintf(out, "\"center\": [%.17g, %.17g], \"size\": [%.17g, %.17g]", box->center[0],
        box->center[1], box->size[0], box->size[1]);
}

static int write_layout(const acid_layout *layout, const char *path) {
    static const char *const colors[ACID_MARKS] = {"red", "green", "blue", "yellow"};
    FILE *out = fopen(path, "w");
    if (!out) return 3;
    fputs("{\"schema\": \"norma-acid-scene/1\", \"aspect\": [4, 3], \"marks\": [", out);
    for (int i = 0; i < ACID_MARKS; ++i) {
        const acid_box *box = &layout->marks[i];
        const double left = box->center[0] - box->size[0] / 2,
                     top = box->center[1] - box->size[1] / 2, right = left + box->size[0],
                     bottom = top + box->size[1];
        fprintf(out,
            "%s{\"color\": \"%s\", \"corners\": [[%.17g, %.17g], [%.17g, %.17g], [%.17g, %.17g], "
            "[%.17g, %.17g]]}",
            i ? ", " : "", colors[i], left, top, right, top, right, bottom, left, bottom);
    }
    fputs("],\n\"cells\": [", out);
    for (size_t i = 0; i < layout->row_count; ++i) {
        const acid_row *row = &layout->rows[i];
        fprintf(out, "%s{\"id\": \"%s\", \"extensions\": [%s], \"subject\": {", i ? ",\n" : "",
            row->id, strncmp(row->id, "instanced", 9) ? "" : "\"EXT_mesh_gpu_instancing\"");
        print_box(out, &row->subject);
        fputs("}, \"references\": [", out);
        for (size_t k = 0; k < row->reference_count; ++k) {
            fprintf(out, "%s{\"id\": \"%s\", ", k ? ", " : "", row->references[k].id);
            print_box(out, &row->references[k].box);
            fputc('}', out);
        }
        fputs("]}", out);
    }
    fputs("]}\n", out);
    return fclose(out) ? 3 : 0;
}

static int write_shot(const acid_layout *layout, uint32_t number, const char *path) {
    acid_shot shot;
    acid_picture picture;
    growing_bytes png = {0};
    acid_shot_choose(&shot, layout, number);
    if (!acid_shot_take(&shot, layout, &picture) ||
        norma_image_write(picture.pixels, picture.width, picture.height, &png))
        return 3;
    for (size_t i = 0; i < layout->row_count; ++i)
        printf("%s %s\n", layout->rows[i].id, shown_name(&shot, layout, i));
    free(picture.pixels);
    const int status = write_file(path, png.data, png.size);
    free(png.data);
    return status;
}

/* ---- the table */

enum { MOST_KINDS = 64 };
typedef struct kind { /* a mistake, "right", "nothing" or "other" */
    const char *name;
    size_t count, named, unclear, wrong;
} kind;
typedef struct tally {
    kind kinds[MOST_KINDS];
    size_t kind_count, lost; /* lost: pictures whose marks were not found */
} tally;

static kind *kind_of(tally *t, const char *name) {
    for (size_t i = 0; i < t->kind_count; ++i)
        if (strcmp(t->kinds[i].name, name) == 0) return &t->kinds[i];
    t->kinds[t->kind_count].name = name;
    return &t->kinds[t->kind_count++];
}

static int is_named(const acid_shot *shot, const acid_row *row, size_t i, const acid_finding *f) {
    const int what = shot->shows[i];
    if (what == ACID_SHOWS_OTHER) return 0;
    if (what == ACID_SHOWS_NOTHING)
        return strcmp(row->id, "flattened") == 0 ? f->verdict == ACID_FAIL && f->nearest == 1
                                                 : f->verdict == ACID_MISSING;
    return f->verdict == (what ? ACID_FAIL : ACID_PASS) && f->nearest == what;
}

static void tell_wrong(const acid_shot *shot, uint32_t number, const acid_row *row,
    const char *shows, const acid_finding *f) {
    fprintf(stderr, "%" PRIu32 " %s shows %s: verdict %d, nearest %d, reason %d, distances", number,
        row->id, shows, (int)f->verdict, f->nearest, (int)f->reason);
    for (size_t k = 0; k < row->reference_count; ++k) fprintf(stderr, " %.4f", f->distances[k]);
    fprintf(stderr, " apart %.4f; %zux%zu, %s, exposure %.2f, gamma %.2f, JPEG %d, ambient %.2f\n",
        f->apart, shot->width, shot->height, acid_curve_names[shot->curve], shot->exposure,
        shot->gamma, shot->quality, shot->environment);
}

static int judge_number(tally *t, const acid_layout *layout, uint32_t number) {
    acid_shot shot;
    acid_picture picture;
    acid_map map;
    acid_judgement judgement;
    acid_shot_choose(&shot, layout, number);
    if (!acid_shot_take(&shot, layout, &picture)) return 0;
    const int found = acid_find_marks(&picture, layout, &map);
    if (found != 1) {
        ++t->lost;
        fprintf(stderr, "%" PRIu32 ": no marks\n", number);
    } else if (!acid_judge(&picture, layout, &map, &judgement)) {
        return 0;
    }
    for (size_t i = 0; i < layout->row_count && found == 1; ++i) {
        const acid_row *row = &layout->rows[i];
        const acid_finding *f = &judgement.findings[i];
        const char *shows = shown_name(&shot, layout, i);
        const int can_name = acid_shot_can_name(&shot, layout, i);
        kind *k = kind_of(t, can_name ? shows : "what another cell, or the ground, must tell");
        const int named = is_named(&shot, row, i, f), unclear = f->verdict == ACID_UNCLEAR;
        ++k->count;
        k->named += (size_t)named;
        k->unclear += (size_t)unclear;
        k->wrong += (size_t)(!named && !unclear);
        if (!named && !(unclear && (shot.shows[i] == ACID_SHOWS_OTHER || !can_name)))
            tell_wrong(&shot, number, row, shows, f);
    }
    if (found == 1) free(judgement.findings);
    free(picture.pixels);
    return 1;
}

static int write_table(const acid_layout *layout, uint32_t count, uint32_t first) {
    tally t = {.kind_count = 0};
    size_t wrong = 0;
    for (uint32_t number = first; number < first + count; ++number)
        if (!judge_number(&t, layout, number)) return 3;
    puts("| Put in | Subjects | Named | Unclear | Wrong |\n|---|---:|---:|---:|---:|");
    for (size_t i = 0; i < t.kind_count; ++i) {
        const kind *k = &t.kinds[i];
        printf("| `%s` | %zu | %zu | %zu | %zu |\n", k->name, k->count, k->named, k->unclear,
            k->wrong);
        wrong += k->wrong;
    }
    printf("\n%" PRIu32 " pictures, marks not found in %zu, %zu wrong verdicts\n", count, t.lost,
        wrong);
    return wrong || t.lost;
}

int main(int count, char **words) {
    acid_layout layout;
    int status = 2;
    if (!acid_shots_layout(&layout)) return 3;
    if (count == 3 && strcmp(words[1], "layout") == 0)
        status = write_layout(&layout, words[2]);
    else if (count == 4 && strcmp(words[1], "shot") == 0)
        status = write_shot(&layout, (uint32_t)strtoul(words[2], NULL, 10), words[3]);
    else if (count >= 3 && strcmp(words[1], "table") == 0)
        status = write_table(&layout, (uint32_t)strtoul(words[2], NULL, 10),
            count > 3 ? (uint32_t)strtoul(words[3], NULL, 10) : 0);
    free(layout.rows);
    return status;
}
