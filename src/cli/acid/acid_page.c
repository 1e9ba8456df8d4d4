/* acid_page.c: the page that explains each cell of the acid scenes. */
#include "acid/acid_judge.h"
#include "acid/acid_mesh.h"
#include "acid/acid_mistakes.h"
#include "acid/acid_scene.h"
#include "cli/acid/acid.h"
#include <stdlib.h>

static const char page_head[] =
    "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
    "content=\"width=device-width,initial-scale=1\">\n<title>Norma's acid test</title>\n<style>\n"
    ":root{color-scheme:light dark}body{font:16px/1.5 system-ui,sans-serif;max-width:52rem;"
    "margin:0 auto;padding:1rem}h2{margin:2.5rem 0 0;font-size:1.2rem}blockquote{margin:.5rem 0;"
    "padding-left:1rem;border-left:3px solid #888}code{font-size:.9em}dt{margin-top:.5rem;"
    "font-weight:600}dd{margin-left:1.5rem}pre{overflow-x:auto;white-space:pre-wrap}"
    ".row{display:flex;flex-wrap:wrap;gap:1rem}figure{margin:0;font-size:.85rem}img{display:block;"
    "width:96px;height:96px}\n</style></"
    "head><body><main>\n"
    "<h1>Norma's acid test</h1>\n"
    "<p>Load <code>norma-acid.glb</code> into a renderer, look through its camera "
    "<code>norma-acid</code>, and compare. Each cell is a row of patches. The first, the subject, "
    "is drawn by way of the feature under test. Those beside it are the same surface baked into "
    "the world: the first is right, each other one has the normals that one known mistake gives. "
    "The renderer is right if the subject looks like the patch called right; if it looks like "
    "another one, that is its mistake.</p>\n"
    "<p>Three lights, red, green and blue, each 30 degrees off the view, colour patches by their "
    "normals. Labels and the squares in the corners are unlit. <code>cells/</code> has each cell "
    "in a file of its own. <code>norma acid --judge SHOT.png --scene acid.json</code> does the "
    "comparison for you.</p>\n"
    "<p>A normal in a file has unit length. So the reference <em>not-normalized</em> has the right "
    "directions, and vertex colours that make it as much brighter or darker as normals of the "
    "wrong length make the light, up to the most that a renderer counts (n&#183;l = 1). The "
    "reference <em>lost</em> is drawn black.</p>\n"
    "<p>Pictures show the references of each cell as a renderer without tone mapping draws them; "
    "the subject should look like the first.</p>\n";

static void write_escaped(FILE *out, const char *before, const char *text, const char *after) {
    fputs(before, out);
    cli_write_outside_html(out, text);
    fputs(after, out);
}

/* The lines that mend it, from the file that people paste. */
static void write_mend(FILE *out, const acid_mistake *mistake) {
    const char *begin;
    if (!mistake->functions[0]) return;
    fputs("<dd><details><summary>In a shader: norma.glsl</summary><pre><code>", out);
    for (size_t i = 0; i < ACID_MOST_FUNCTIONS && mistake->functions[i]; ++i) {
        const size_t length = acid_mending_lines(mistake->functions[i], &begin);
        if (i) fputs("\n\n", out);
        for (size_t k = 0; k < length; ++k) {
            const char letter[2] = {begin[k]};
            if (letter[0] == '\n')
                fputs(letter, out);
            else
                cli_write_outside_html(out, letter);
        }
    }
    fputs("</code></pre></details></dd>\n", out);
}

/* 0: out of memory. */
static int write_patch(
    FILE *out, const acid_cell *cell, const acid_patch *subject, acid_fault fault) {
    enum { SIDE = 64 };
    uint8_t pixels[3 * SIDE * SIDE] = {0};
    const acid_picture picture = {SIDE, SIDE, pixels};
    growing_bytes png = {0};
    acid_patch patch;
    if (!acid_make_reference(cell, subject, fault, &patch)) return 0;
    acid_draw_patch(&patch, acid_white(cell), SIDE, pixels);
    acid_free_patch(&patch);
    const int made = acid_write_picture(&picture, &png);
    if (made) {
        fputs("<figure><img alt=\"\" src=\"data:image/png;base64,", out);
        cli_write_base64(out, (const unsigned char *)png.data, png.size);
        write_escaped(out, "\"><figcaption>", acid_fault_id(fault), "</figcaption></figure>\n");
    }
    free(png.data);
    return made;
}

static int write_cell_row(FILE *out, const acid_cell *cell) {
    acid_patch subject;
    if (!acid_make_subject(cell, &subject)) return 0;
    fputs("<div class=\"row\">\n", out);
    int made = write_patch(out, cell, &subject, ACID_RIGHT);
    for (size_t i = 0; i < acid_fault_count(cell) && made; ++i)
        made = write_patch(out, cell, &subject, cell->faults[i]);
    fputs("</div>\n", out);
    acid_free_patch(&subject);
    return made;
}

static void write_cell_mistakes(FILE *out, const acid_cell *cell) {
    if (!acid_fault_count(cell)) return;
    fputs("<dl>\n", out);
    for (size_t i = 0; i < acid_fault_count(cell); ++i) {
        const char *id = acid_fault_id(cell->faults[i]);
        const acid_mistake *mistake = acid_find_mistake(id);
        write_escaped(out, "<dt>", id, "</dt>");
        if (!mistake) continue;
        write_escaped(out, "<dd>What happens: ", mistake->words, ".</dd>");
        write_escaped(out, "<dd>Instead: ", mistake->mend, ".</dd>\n");
        write_mend(out, mistake);
    }
    fputs("</dl>\n", out);
}

int acid_write_page(FILE *out, const acid_grid *grid) {
    (void)grid;
    fputs(page_head, out);
    for (size_t i = 0; i < acid_cell_count; ++i) {
        const acid_cell *cell = &acid_cells[i];
        write_escaped(out, "<h2 id=\"", cell->id, "\">");
        write_escaped(out, "", cell->id, "</h2>\n");
        write_escaped(out, "<p>", cell->tested, "</p>\n");
        write_escaped(out, "<blockquote>", cell->sentence, "<br>");
        write_escaped(out, "<small>", cell->section, "</small></blockquote>\n");
        write_escaped(out, "<p>Expected: ", cell->expected, " ");
        if (acid_cell_extension(cell))
            write_escaped(out, "Needs <code>", acid_cell_extension(cell), "</code>. ");
        write_escaped(out, "File: <code>cells/", cell->id, ".glb</code></p>\n");
        if (!write_cell_row(out, cell)) return 0;
        write_cell_mistakes(out, cell);
    }
    fputs("</main></body></html>\n", out);
    return 1;
}
