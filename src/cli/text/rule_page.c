/* rule_page.c: rules as HTML, their pictures from the table in rule_pictures.def. */
#include "cli/text/text.h"
#include <string.h>

typedef struct rule_picture {
    const char *id, *wrong, *right;
} rule_picture;

static const rule_picture pictures[] = {
#define PICTURE(id, wrong, right) {#id, wrong, right},
#include "cli/text/rule_pictures.def"
#undef PICTURE
};

void cli_write_rule_style(FILE *out) {
    fputs(
        ".meaning{border-top:1px solid var(--line,#8886);padding:.6rem 0}.meaning "
        "h3{font-size:1rem;"
        "margin:0}.meaning p{margin:.3rem "
        "0}.pair{display:flex;flex-wrap:wrap;gap:1rem;margin:.4rem "
        "0}.pair figure{margin:0}.pair figcaption{font-size:.85rem}.pair "
        "svg{width:180px;height:auto;"
        "background:#f2f4f7;border-radius:6px;font:11px sans-serif}\n"
        ".pair path{fill:none;stroke:#333;stroke-width:1.5;stroke-linecap:round;stroke-linejoin:"
        "round}.pair .f{fill:#c9d3df}.pair .g{fill:#dfe6ee}.pair "
        ".e{fill:#f5b5ae;stroke:#b3261e}.pair "
        ".s{stroke-width:2.5}.pair .h{stroke:#555;stroke-width:1}.pair "
        ".r{stroke:#b3261e;stroke-width:"
        "2.5}.pair .n{stroke:#0b57d0;stroke-width:2;marker-end:url(#norma-good)}.pair .x{stroke:"
        "#b3261e;stroke-width:2;marker-end:url(#norma-bad)}.pair .o{stroke:#0b57d0;stroke-width:6}"
        ".pair .b{stroke:#b3261e;stroke-width:8}.pair text{fill:#222}.pair .V{fill:#a01a12}\n",
        out);
}

void cli_write_rule_marks(FILE *out) {
    static const char *const marks[][2] = {{"norma-good", "#0b57d0"}, {"norma-bad", "#b3261e"}};
    fputs("<svg width=\"0\" height=\"0\" aria-hidden=\"true\" style=\"position:absolute\"><defs>",
        out);
    for (size_t i = 0; i < sizeof marks / sizeof *marks; ++i)
        fprintf(out,
            "<marker id=\"%s\" viewBox=\"0 0 8 8\" refX=\"5\" refY=\"4\" markerWidth=\"4\" "
            "markerHeight=\"4\" orient=\"auto\"><path d=\"M0 0L8 4L0 8z\" fill=\"%s\"/></marker>",
            marks[i][0], marks[i][1]);
    fputs("</defs></svg>\n", out);
}

/* "T 40 80 words": at (40, 80). */
static void write_words(FILE *out, char class, const char *text, size_t length) {
    int x = 0, y = 0, used = 0;
    if (sscanf(text, "%d %d %n", &x, &y, &used) < 2 || (size_t)used > length) return;
    fprintf(out, "<text class=\"%c\" x=\"%d\" y=\"%d\">", class, x, y);
    for (size_t i = (size_t)used; i < length; ++i)
        fputs(text[i] == '<' ? "&lt;" : (const char[]){text[i], '\0'}, out);
    fputs("</text>", out);
}

static void write_drawing(FILE *out, const char *drawing) {
    while (*drawing) {
        const size_t length = strcspn(drawing, ";");
        if (drawing[0] == 'T' || drawing[0] == 'V')
            write_words(out, drawing[0], drawing + 2, length - 2);
        else
            fprintf(
                out, "<path class=\"%c\" d=\"%.*s\"/>", drawing[0], (int)length - 2, drawing + 2);
        drawing += length + (drawing[length] == ';');
    }
}

static void write_figure(FILE *out, const norma_rule *rule, const char *word, const char *drawing) {
    fprintf(out, "<figure><svg viewBox=\"0 0 150 90\" role=\"img\" aria-label=\"%s: %s\">",
        rule->name, word);
    write_drawing(out, drawing);
    fprintf(out, "</svg><figcaption>%s</figcaption></figure>\n", word);
}

static void write_pictures(FILE *out, const norma_rule *rule) {
    for (size_t i = 0; i < sizeof pictures / sizeof *pictures; ++i) {
        if (strcmp(pictures[i].id, rule->id) != 0) continue;
        fputs("<div class=\"pair\">\n", out);
        write_figure(out, rule, "Wrong", pictures[i].wrong);
        write_figure(out, rule, "Right", pictures[i].right);
        fputs("</div>\n", out);
    }
}

static void write_html_paragraph(FILE *out, const char *label, const char *text) {
    fprintf(out, "<p>%s", label);
    cli_write_outside_html(out, text);
    fputs("</p>\n", out);
}

const norma_rule *cli_find_rule(const char *id) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    for (size_t i = 0; i < count; ++i)
        if (strcmp(rules[i].id, id) == 0) return &rules[i];
    return NULL;
}

void cli_write_rule_html(FILE *out, const norma_rule *rule, int level) {
    fprintf(out, "<article class=\"meaning\" id=\"%s\"><h%d>%s %s</h%d>\n", rule->id, level,
        rule->id, rule->name, level);
    write_pictures(out, rule);
    write_html_paragraph(out, "", rule->what);
    write_html_paragraph(out, "Usual cause: ", rule->cause);
    write_html_paragraph(out, "", rule->why);
    write_html_paragraph(out, "", rule->how);
    fputs("</article>\n", out);
}
