/* acid_page.c: the page that explains each cell of the acid scenes. */
#include "acid/acid_mistakes.h"
#include "acid/acid_scene.h"
#include "cli/acid/acid.h"

static const char page_head[] =
    "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
    "content=\"width=device-width,initial-scale=1\">\n<title>Norma's acid test</title>\n<style>\n"
    ":root{color-scheme:light dark}body{font:16px/1.5 system-ui,sans-serif;max-width:52rem;"
    "margin:0 auto;padding:1rem}h2{margin:2.5rem 0 0;font-size:1.2rem}blockquote{margin:.5rem 0;"
    "padding-left:1rem;border-left:3px solid #888}code{font-size:.9em}dt{margin-top:.5rem;"
    "font-weight:600}dd{margin-left:1.5rem}pre{overflow-x:auto;white-space:pre-wrap}\n</style></"
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
    "reference <em>lost</em> is drawn black.</p>\n";

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

void acid_write_page(FILE *out, const acid_grid *grid) {
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
        write_cell_mistakes(out, cell);
    }
    fputs("</main></body></html>\n", out);
}
