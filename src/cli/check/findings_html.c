/* findings_html.c: findings as one HTML file that needs nothing else: a table that is sorted by its
 * heads, filtered by severity and words, with a drawing of each place. */
#include "cli/check/finding_picture.h"
#include "cli/process/errors.h"
#include "cli/text/report_text.h"
#include <math.h>
#include <string.h>

static const char head[] =
    "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
    "content=\"width=device-width\">\n"
    "<title>norma check</title>\n<style>\n"
    ":root{color-scheme:light "
    "dark;--line:#8884;--soft:#8882;--error:#c62828;--warning:#b26a00;--info:#2a6db0}\n"
    "@media(prefers-color-scheme:dark){:root{--error:#ff8a80;--warning:#ffc46b;--info:#8cc2ff}}\n"
    "body{font:15px/1.45 system-ui,sans-serif;margin:2rem auto;max-width:78rem;padding:0 1rem}\n"
    "h1{font-size:1.4rem;margin:0 0 .3rem}p{margin:.3rem 0}\n"
    "form{display:flex;gap:1rem;flex-wrap:wrap;align-items:center;margin:1rem 0}\n"
    "table{border-collapse:collapse;width:100%}th,td{text-align:left;vertical-align:top;padding:."
    "5rem .6rem;border-bottom:1px solid var(--line)}\n"
    "th button{all:unset;cursor:pointer;font-weight:600}th button:focus-visible{outline:2px solid "
    "currentColor}\n"
    "th[aria-sort=ascending] button::after{content:\" \\2191\"}th[aria-sort=descending] "
    "button::after{content:\" \\2193\"}\n"
    "td.number{text-align:right;font-variant-numeric:tabular-nums}\n"
    ".error{color:var(--error)}.warning{color:var(--warning)}.info{color:var(--info)}.severity{"
    "font-weight:600}\n"
    ".place{color:GrayText;font-size:.9em;overflow-wrap:anywhere}code{font-size:.92em;background:"
    "var(--soft);padding:0 .25em;border-radius:3px}\n"
    "svg{width:180px;height:180px;background:var(--soft);border-radius:6px;overflow:hidden}\n"
    "svg path{stroke:#0006;stroke-width:.5;stroke-linejoin:round}svg .m{stroke:#800}svg "
    ".n{stroke:#0b57d0;stroke-width:2;fill:none}svg circle{fill:#0b57d0}\n"
    ".bins td{padding:0 .4rem;border:0;font-size:.85em;white-space:nowrap}.bins "
    "i{display:inline-block;height:.7em;background:var(--info)}\n"
    "tr[hidden]{display:none}\n"
    "</style></head><body>\n<h1>norma check</h1>\n<p id=\"verdict\"></p>\n"
    "<form><label>Show <select id=\"least\"><option value=\"1\">everything</option><option "
    "value=\"2\">warnings and errors</option>"
    "<option value=\"3\">errors</option></select></label>\n"
    "<label>with the words <input id=\"words\" type=\"search\"></label> <span id=\"shown\" "
    "role=\"status\"></span></form>\n"
    "<table><thead><tr><th><button type=\"button\">Severity</button></th><th><button "
    "type=\"button\">Rule</button></th>"
    "<th><button type=\"button\">File and place</button></th><th><button "
    "type=\"button\">Count</button></th><th><button type=\"button\">Worst</button></th>"
    "<th>What</th><th>Where it is</th></tr></thead>\n<tbody>\n";

static const char script[] =
    "<script>\n"
    "const body=document.querySelector('table>tbody'),heads=[...document.querySelectorAll('thead "
    "th')];\n"
    "const key=(row,i)=>{const cell=row.cells[i];return "
    "cell.dataset.key!==undefined?+cell.dataset.key:cell.textContent};\n"
    "heads.forEach((th,i)=>th.querySelector('button')?.addEventListener('click',()=>{\n"
    "  const down=th.getAttribute('aria-sort')==='ascending';\n"
    "  "
    "heads.forEach(other=>other.removeAttribute('aria-sort'));th.setAttribute('aria-sort',down?'"
    "descending':'ascending');\n"
    "  const rows=[...body.children].sort((a,b)=>{const x=key(a,i),y=key(b,i);return "
    "(x<y?-1:x>y?1:0)*(down?-1:1)});\n"
    "  body.append(...rows)}));\n"
    "const show=()=>{const "
    "least=+document.getElementById('least').value,words=document.getElementById('words').value."
    "toLowerCase();let n=0;\n"
    "  for(const row of "
    "body.children){row.hidden=+row.cells[0].dataset.key<least||!row.textContent.toLowerCase()."
    "includes(words);n+=!row.hidden}\n"
    "  document.getElementById('shown').textContent=n+' of '+body.children.length};\n"
    "document.querySelector('form').addEventListener('input',show);document.querySelector('form')."
    "addEventListener('submit',e=>e.preventDefault());\n"
    "document.getElementById('verdict').textContent=document.getElementById('last').textContent;"
    "show();\n"
    "const gravest=heads[0].querySelector('button');gravest.click();gravest.click();\n"
    "</script>\n</body></html>\n";

static void begin(FILE *out, const check_settings *settings) {
    (void)settings;
    fputs(head, out);
}

static void write_worst(FILE *out, const norma_finding *finding) {
    char text[32];
    if (!isfinite(finding->worst_value)) {
        fputs("<td class=\"number\" data-key=\"-1\"></td>", out);
        return;
    }
    snprintf(text, sizeof text, "%.4g", finding->worst_value);
    fprintf(out, "<td class=\"number\" data-key=\"%.9g\">%s%s%s</td>", finding->worst_value, text,
        finding->unit[0] ? " " : "", finding->unit);
}

static void write_place(FILE *out, const norma_finding *finding) {
    const norma_sample *worst = &finding->worst;
    fputs("<p class=\"place\">", out);
    if (worst->vertex != SIZE_MAX) fprintf(out, "vertex %zu ", worst->vertex);
    if (worst->face != SIZE_MAX) fprintf(out, "face %zu ", worst->face);
    if (worst->has_position)
        fprintf(out, "at (%.6g, %.6g, %.6g)", worst->position[0], worst->position[1],
            worst->position[2]);
    fputs("</p>", out);
}

/* Bars of how many corners are how far off; empty bins at the end are left out. */
static void write_histogram(FILE *out, const norma_deviation *deviation) {
    size_t most = 1, last = 0;
    for (size_t bin = 0; bin < NORMA_DEVIATION_BINS; ++bin) {
        most = deviation->histogram[bin] > most ? deviation->histogram[bin] : most;
        last = deviation->histogram[bin] ? bin : last;
    }
    fputs("<table class=\"bins\">", out);
    for (size_t bin = 0; bin <= last; ++bin)
        fprintf(out,
            "<tr><td>below %g\302\260</td><td><i style=\"width:%.1fem\"></i> %zu</td></tr>",
            cli_given_degrees(norma_deviation_bound_rad(bin)),
            8.0 * (double)deviation->histogram[bin] / (double)most, deviation->histogram[bin]);
    fputs("</table>", out);
}

static void write_item(FILE *out, const check_report *report, const check_item *item) {
    const norma_finding *finding = item->finding;
    const char *severity = check_severity_name(item->severity);
    fprintf(out, "<tr><td class=\"severity %s\" data-key=\"%d\">%s</td><td>%s<br>%s</td><td>",
        severity, (int)item->severity, severity, finding->rule->id, finding->rule->name);
    cli_write_outside_html(out, cli_input_name(report->path));
    fputs("<p class=\"place\">", out);
    cli_write_outside_html(out, finding->label);
    if (finding->where[0]) {
        fputs("<br><code>", out);
        cli_write_outside_html(out, finding->where);
        fputs("</code>", out);
    }
    fprintf(out, "</p></td><td class=\"number\" data-key=\"%zu\">", finding->count);
    cli_count(out, finding->count);
    fputs("</td>", out);
    write_worst(out, finding);
    fputs("<td>", out);
    cli_write_outside_html(out, finding->message);
    if (item->command) {
        fputs("<p>Fix: <code>", out);
        cli_write_outside_html(out, item->command);
        fputs("</code></p>", out);
    }
    fputs("</td><td>", out);
    if (finding->deviation) write_histogram(out, finding->deviation);
    check_draw_finding(out, report->document, finding);
    write_place(out, finding);
    fputs("</td></tr>\n", out);
}

static void write_file(FILE *out, const check_report *report) {
    for (size_t i = 0; i < report->count; ++i) write_item(out, report, &report->items[i]);
}

static void end(FILE *out, const check_totals *totals, const check_settings *settings) {
    (void)settings;
    fputs("</tbody></table>\n<p id=\"last\">", out);
    check_write_verdict(out, totals);
    fputs("</p>\n", out);
    fputs(script, out);
}

const check_format check_format_html = {"html", begin, write_file, "", end};
