/* findings_html.c: findings as a page with pictures. */
#define _POSIX_C_SOURCE 200809L
#include "cli/check/check.h"
#include <stdlib.h>
#include <string.h>

/* ---- Findings as one HTML file that needs nothing else: a summary, then each file
 * with its rules, a picture of the worst place of each, and what the rules mean. Information is
 * folded. Pictures share a budget, so that the page of a folder stays small enough to send. */

enum {
    PAGE_BYTES = 600000, /* of pictures, shared by the files */
    LEAST_BYTES = 8000,  /* of a file: one picture */
    MOST_BYTES = 200000,
    MOST_OF_PROBLEM = 10,
    MOST_OF_INFO = 3,
    FILES_WITH_INFO_PICTURES = 4,
    FILES_IN_SIGHT = 30 /* the list of more is folded */
};

static const char style[] =
    ":root{color-scheme:light dark;--ground:#fff;--ink:#1b1c1e;--line:#8886;--soft:#8881;"
    "--error:#b3261e;--warning:#855300;--info:#1a5fb4}\n"
    "@media(prefers-color-scheme:dark){:root{--ground:#15171a;--ink:#e4e6e8;--error:#ffb4ab;"
    "--warning:#ffcc80;--info:#a8c7fa}}\n"
    "*{box-sizing:border-box}body{font:16px/1.5 "
    "system-ui,sans-serif;margin:0;background:var(--ground);color:var(--ink)}\n"
    "main{max-width:64rem;margin:0 auto;padding:1rem;display:flex;flex-direction:column}\n"
    "main>*{order:1;min-width:0}header,#summary{order:0}\n"
    "h1{font-size:1.5rem;margin:.2rem 0}h2{font-size:1.15rem;margin:2rem 0 "
    "0;overflow-wrap:anywhere}"
    "h3{font-size:1rem;margin:0}p{margin:.3rem 0}\n"
    "a{color:var(--info)}.error{color:var(--error)}.warning{color:var(--warning)}.info{color:var("
    "--info)}.severity{font-weight:700}\n"
    ".verdict{font-size:1.15rem;font-weight:600}\n"
    "table{border-collapse:collapse;width:100%;margin:.8rem 0}th,td{text-align:left;padding:.25rem "
    ".6rem .25rem 0;border-bottom:1px solid var(--line)}.number{text-align:right;"
    "font-variant-numeric:tabular-nums}\n"
    "form{display:flex;gap:.6rem 1.2rem;flex-wrap:wrap;align-items:center;margin:.6rem 0}"
    "select,input{font:inherit;max-width:100%}\n"
    ".rule{border-left:4px solid var(--line);padding:.2rem 0 .2rem .8rem;margin:.9rem "
    "0;display:grid;grid-template-columns:1fr 220px;gap:0 1rem;align-items:start}"
    ".rule.is-error{border-color:var(--error)}.rule.is-warning{border-color:var(--warning)}\n"
    ".rule>*{grid-column:1;min-width:0}.rule>figure{grid-column:2;grid-row:1/9;margin:0}"
    "figcaption{font-size:.85rem}\n"
    "ul{margin:.3rem 0;padding-left:1.2rem}li{overflow-wrap:anywhere}.place{font-size:.9rem}\n"
    "code{font-size:.9em;background:var(--soft);padding:.1em .3em;border-radius:3px;"
    "overflow-wrap:anywhere}.fix code{user-select:all}"
    "button{font:inherit;font-size:.85rem}summary h2{display:inline;font-size:1rem;margin:0}"
    ".files ol{margin:.3rem 0;padding-left:2rem}.files li{font-size:.95rem}\n"
    "details{margin:.6rem 0}summary{cursor:pointer;padding:.2rem 0}\n"
    "figure svg{width:220px;max-width:100%;height:auto;background:#dfe3e8;border-radius:6px}\n"
    "figure path{stroke:#0005;stroke-width:.5;stroke-linejoin:round}figure .m{stroke:#a00;"
    "stroke-width:1.5;fill:#e00;fill-opacity:.45}figure .r{stroke:#d00;stroke-width:2.5;fill:none}"
    "figure .n{stroke:#0b57d0;stroke-width:2;fill:none}figure .d{fill:#0b57d0;stroke:none}\n"
    ".bins{width:auto;font-size:.85rem}.bins td{border:0;padding:0 .5rem 0 "
    "0;white-space:nowrap}.bins "
    "i{display:inline-block;height:.7em;background:var(--info)}\n"
    "@media(max-width:640px){.rule{display:block}.rule>figure{margin:.5rem 0}main{padding:.7rem}"
    "}\n"
    "[hidden]{display:none!important}\n";

static const char script[] =
    "<script>\n"
    "const all=(at,what)=>[...at.querySelectorAll(what)],make=(kind,words)=>Object.assign(doc"
    "ument.createElement(kind),{textContent:words});\n"
    "const main=document.querySelector('main'),summary=document.getElementById('summary');\n"
    "document.querySelector('header').after(summary);\n"
    "const linkTo=file=>{const head=file.querySelector('h2'),link=make('a',head.textContent);"
    "link.href='#'+head.id;return link};\n"
    "const first={};\n"
    "for(const at of all(main,'[data-same]')){const file=at.closest('.file'),same=first[at.da"
    "taset.same]||={at,file,others:new Set()};\n"
    "  if(same.file===file)continue;\n"
    "  same.others.add(file);at.remove()}\n"
    "for(const {at,others} of Object.values(first)){let n=0;\n"
    "  for(const file of others){if(n===3)break;at.append(n++?', ':' Also in ',linkTo(file))}\n"
    "  if(others.size>n)at.append(` and ${others.size-n} more`);\n"
    "  if(n)at.append('.')}\n"
    "document.getElementById('how').hidden=!!main.querySelector('a.place')||!main.querySelecto"
    "r('.rule');\n"
    "for(const rule of all(main,'.rule'))if(!rule.querySelector('li'))rule.remove();\n"
    "for(const file of all(main,'.file:not([data-clean])'))if(!file.querySelector(':scope>.ru"
    "le'))file.querySelector('p').append(' What it has is told at the files above that have i"
    "t too.');\n"
    "for(const code of all(main,'.fix code')){const button=make('button','Copy');button.type="
    "'button';\n"
    "  button.onclick=async()=>{try{await navigator.clipboard.writeText(code.textContent)}cat"
    "ch{getSelection().selectAllChildren(code);document.execCommand('copy')}\n"
    "    button.textContent='Copied';setTimeout(()=>{button.textContent='Copy'},2000)};\n"
    "  code.after(' ',button)}\n"
    "const unfold=()=>{for(let at=document.getElementById(location.hash.slice(1));at;at=at.pa"
    "rentElement)if(at.tagName==='DETAILS')at.open=true};\n"
    "addEventListener('hashchange',unfold);unfold();\n"
    "const least=document.getElementById('least'),words=document.getElementById('words'),show"
    "n=document.getElementById('shown');\n"
    "const show=()=>{const text=words.value.toLowerCase();let n=0,of=0;\n"
    "  for(const file of all(main,'.file')){let any=false;\n"
    "    for(const rule of all(file,'.rule')){const seen=+rule.dataset.severity>=+least.value"
    "&&(file.dataset.path+' '+rule.textContent).toLowerCase().includes(text);\n"
    "      rule.hidden=!seen;any||=seen;n+=seen;of++}\n"
    "    const infos=file.querySelector('.infos');if(infos)infos.hidden=!infos.querySelector("
    "'.rule:not([hidden])');\n"
    "    file.hidden=!any&&(text!==''||least.value>0)}\n"
    "  const clean=document.getElementById('clean');if(clean)clean.hidden=!clean.querySelecto"
    "r('.file:not([hidden])');\n"
    "  shown.textContent=n+' of '+of+' shown'};\n"
    "document.querySelector('form').hidden=false;\n"
    "document.querySelector('form').addEventListener('input',show);\n"
    "document.querySelector('form').addEventListener('submit',e=>e.preventDefault());show();\n"
    "</script>\n";

static void begin_html(FILE *out, const check_settings *settings) {
    (void)settings;
    fputs(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
        "content=\"width=device-width,initial-scale=1\">\n<title>norma check</title>\n<style>\n",
        out);
    fputs(style, out);
    cli_write_rule_style(out);
    fputs("</style></head><body>\n<main>\n<header><h1>norma check</h1></header>\n", out);
}

/* ---- one rule in one file */

static void write_html_worst(FILE *out, const check_report *report, const norma_finding *finding) {
    const norma_sample *worst = &finding->worst;
    if (worst->vertex == SIZE_MAX && worst->face == SIZE_MAX && !worst->has_position) return;
    fputs(" <span class=\"place\">Worst: ", out);
    if (worst->vertex != SIZE_MAX) fprintf(out, "vertex %zu ", worst->vertex);
    if (worst->vertex == SIZE_MAX && worst->face != SIZE_MAX)
        fprintf(out, "face %zu ", worst->face);
    if (worst->has_position)
        fprintf(out, "at (%.6g, %.6g, %.6g)", worst->position[0], worst->position[1],
            worst->position[2]);
    const char *node = check_node_path(report->document, finding->where);
    if (node) {
        fputs(" in node ", out);
        cli_write_outside_html(out, node);
    }
    fputs("</span>", out);
}

/* Bars of how many corners are how far off; empty bins at the end are left out. */
static void write_histogram(FILE *out, const norma_deviation *deviation) {
    size_t most = 1, last = 0;
    for (size_t bin = 0; bin < NORMA_DEVIATION_BINS; ++bin) {
        most = deviation->histogram[bin] > most ? deviation->histogram[bin] : most;
        last = deviation->histogram[bin] ? bin : last;
    }
    fputs("<table class=\"bins\"><tbody>", out);
    for (size_t bin = 0; bin <= last; ++bin)
        fprintf(out,
            "<tr><td>below %g\302\260</td><td><i style=\"width:%.1fem\"></i> %zu</td></tr>",
            cli_given_degrees(norma_deviation_bound_rad(bin)),
            8.0 * (double)deviation->histogram[bin] / (double)most, deviation->histogram[bin]);
    fputs("</tbody></table>", out);
}

/* To the page that shows the file and presses the finding: norma.html, which opens it, or the page
 * that norma view made for it in a folder. */
static void write_page_link(FILE *out, const check_report *report, const norma_finding *finding) {
    if (!report->page) return;
    fputs(" <a class=\"place\" href=\"", out);
    cli_write_outside_html(out, report->settings->page);
    if (!check_page_is_folder(report->settings)) fputs("?src=", out);
    check_write_uri(out, report->page, "-._~/");
    fprintf(out, "#finding=%s:", finding->rule->id);
    check_write_uri(out, finding->label, "-._~/");
    fputs("\">Look at it</a>", out);
}

static void write_place(FILE *out, const check_report *report, const check_item *item) {
    const norma_finding *finding = item->finding;
    const uint64_t key = check_key(report, item);
    if (key)
        fprintf(out, "<li data-same=\"%016" PRIx64 "\">", key);
    else
        fputs("<li>", out);
    if (finding->label[0]) {
        cli_write_outside_html(out, finding->label);
        fputs(": ", out);
    }
    cli_write_outside_html(out, finding->message);
    const size_t length = strlen(finding->message);
    if (length && !strchr(".!?", finding->message[length - 1])) fputc('.', out);
    write_html_worst(out, report, finding);
    write_page_link(out, report, finding);
    fputs("</li>\n", out);
}

static void write_findings(FILE *out, const check_report *report, const check_item *first) {
    const size_t most = first->severity == NORMA_SEVERITY_INFO ? MOST_OF_INFO : MOST_OF_PROBLEM;
    const size_t count = check_count_same(report, first);
    size_t written = 0;
    fputs("<ul>\n", out);
    for (const check_item *item = first; written < count && written < most; ++item) {
        if (!check_is_same(first, item)) continue;
        write_place(out, report, item);
        ++written;
    }
    if (count > written) fprintf(out, "<li>and %zu more</li>\n", count - written);
    fputs("</ul>\n", out);
}

/* A picture that does not fit in what is left of the file's budget is left out. */
static void write_finding_picture(
    FILE *out, const check_report *report, const check_item *item, size_t *budget) {
    cli_memory_stream drawing;
    if (*budget == 0) return;
    if (cli_memory_open(&drawing)) check_draw_finding(drawing.out, report->document, item->finding);
    if (cli_memory_close(&drawing) && drawing.size && drawing.size <= *budget) {
        fprintf(out, "<figure>%s<figcaption>%s</figcaption></figure>\n", drawing.text,
            check_count_same(report, item) > 1 ? "The worst place of the first"
                                               : "The worst place");
        *budget -= drawing.size;
    }
    free(drawing.text);
}

static void write_command(FILE *out, const char *what, const char *command) {
    if (!command) return;
    fprintf(out, "<p class=\"fix\">%s: <code>", what);
    cli_write_outside_html(out, command);
    fputs("</code></p>\n", out);
}

static void write_html_rule(
    FILE *out, const check_report *report, const check_item *item, size_t *budget) {
    const norma_rule *rule = item->finding->rule;
    const char *severity = cli_severity_name(item->severity);
    const size_t count = check_count_same(report, item);
    fprintf(out,
        "<section class=\"rule is-%s\" data-severity=\"%d\"><h3><span class=\"severity "
        "%s\">%s</span> "
        "<a href=\"#%s\">%s %s</a>",
        severity, (int)item->severity, severity, severity, rule->id, rule->id, rule->name);
    if (count > 1) fprintf(out, ", %zu findings", count);
    fputs("</h3>\n", out);
    write_findings(out, report, item);
    if (item->finding->deviation && count == 1) write_histogram(out, item->finding->deviation);
    write_command(out, "Fix", item->command);
    write_finding_picture(out, report, item, budget);
    fputs("</section>\n", out);
}

/* ---- one file */

static size_t write_rules(
    FILE *out, const check_report *report, norma_severity severity, size_t *budget) {
    size_t written = 0;
    for (size_t i = 0; i < report->count; ++i)
        if (report->items[i].severity == severity && check_is_first(report, i)) {
            write_html_rule(out, report, &report->items[i], budget);
            ++written;
        }
    return written;
}

static size_t items_of(const check_report *report, norma_severity severity) {
    size_t count = 0;
    for (size_t i = 0; i < report->count; ++i) count += report->items[i].severity == severity;
    return count;
}

static size_t budget_of(const check_report *report) {
    const size_t files = report->settings->file_count,
                 share = files ? PAGE_BYTES / files : PAGE_BYTES;
    return share < LEAST_BYTES ? LEAST_BYTES : share > MOST_BYTES ? MOST_BYTES : share;
}

static void write_infos(FILE *out, const check_report *report, size_t *budget) {
    const size_t infos = items_of(report, NORMA_SEVERITY_INFO);
    if (!infos) return;
    fputs("<details class=\"infos\"", out);
    if (report->settings->list_infos) fputs(" open", out);
    fputs("><summary>", out);
    cli_counted(out, infos, "info", "infos");
    fputs("</summary>\n", out);
    if (report->settings->file_count > FILES_WITH_INFO_PICTURES) *budget = 0;
    write_rules(out, report, NORMA_SEVERITY_INFO, budget);
    fputs("</details>\n", out);
}

static void write_counts(FILE *out, const check_report *report) {
    fputs("<p>", out);
    if (check_is_clean(report)) {
        fprintf(out, "No problems found%s", check_unseen(report));
    } else {
        cli_counted(out, items_of(report, NORMA_SEVERITY_ERROR), "error", "errors");
        fputs(", ", out);
        cli_counted(out, items_of(report, NORMA_SEVERITY_WARNING), "warning", "warnings");
    }
    fprintf(out, ". Profile %s", check_profile_name(report->profile));
    if (strcmp(report->status, "checked") != 0)
        fprintf(out, "; %s",
            strcmp(report->status, "partly") == 0 ? "checked in part" : "could not be read");
    fputs(".</p>\n", out);
}

/* What could not be fixed, and why. */
static void write_html_reasons(FILE *out, const check_report *report) {
    for (size_t i = 0; i < report->reason_count; ++i) {
        const check_reason *reason = &report->reasons[i];
        if (reason->is_folded) continue;
        fputs("<p>Not fixed: ", out);
        cli_write_outside_html(out, reason->text);
        if (reason->more) fprintf(out, " (%zu more like this)", reason->more);
        fputs("</p>\n", out);
    }
}

/* Where links lead to. */
static void write_anchor(FILE *out, const char *path) {
    fprintf(out, "f%016" PRIx64, cli_hash(CLI_HASH, path, strlen(path)));
}

static void write_html_file(FILE *out, const check_report *report) {
    size_t budget = budget_of(report);
    const int is_clean = check_is_clean(report), folds = report->settings->file_count > 1;
    fputs(CHECK_HTML_FILE, out);
    check_write_uri(out, report->path, "-._~/");
    fprintf(out, CHECK_HTML_STATUS "%s%s>", report->status, items_of(report, NORMA_SEVERITY_ERROR),
        items_of(report, NORMA_SEVERITY_WARNING), check_fails(report) ? CHECK_HTML_FAILS : "",
        is_clean ? CHECK_HTML_CLEAN : "");
    if (is_clean && folds) fputs("<details><summary>", out);
    fputs("<h2 id=\"", out);
    write_anchor(out, report->path);
    fputs("\">", out);
    cli_write_outside_html(out, report->shown);
    fputs(is_clean && folds ? "</h2></summary>\n" : "</h2>\n", out);
    write_counts(out, report);
    if (report->mended) {
        fputs("<p>Fixed:</p><pre tabindex=\"0\">", out);
        fputs(report->mended, out);
        fputs("</pre>\n", out);
    }
    write_html_reasons(out, report);
    if (!is_clean)
        write_command(out, "Turn it, and press a finding to see its place", report->view);
    write_rules(out, report, NORMA_SEVERITY_ERROR, &budget);
    write_rules(out, report, NORMA_SEVERITY_WARNING, &budget);
    write_infos(out, report, &budget);
    if (is_clean && folds) fputs("</details>", out);
    fputs(CHECK_HTML_FILE_END, out);
}

/* ---- the summary, and the rules */

static void write_html_total(
    FILE *out, const norma_rule *rule, norma_severity severity, const check_rule_total *total) {
    const char *name = cli_severity_name(severity);
    fprintf(out,
        "<tr><td><span class=\"severity %s\">%s</span></td><td><a href=\"#%s\">%s %s</a></td><td "
        "class=\"number\">%zu</td><td "
        "class=\"number\">%zu</td></tr>\n",
        name, name, rule->id, rule->id, rule->name, total->findings, total->files);
}

static size_t rules_of(const check_totals *totals, norma_severity severity) {
    size_t found = 0;
    for (size_t rule = 0; rule < CHECK_RULES; ++rule)
        found += totals->by_rule[rule][severity].findings > 0;
    return found;
}

static void write_html_totals(
    FILE *out, const check_totals *totals, norma_severity gravest, norma_severity least) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    fputs("<table><thead><tr><th scope=\"col\">Severity</th><th scope=\"col\">Rule</th><th "
          "scope=\"col\" class=\"number\">Findings</th><th scope=\"col\" "
          "class=\"number\">Files</th></tr></thead><tbody>\n",
        out);
    for (norma_severity severity = gravest; severity >= least; --severity)
        for (size_t rule = 0; rule < count; ++rule)
            if (totals->by_rule[rule][severity].findings)
                write_html_total(out, &rules[rule], severity, &totals->by_rule[rule][severity]);
    fputs("</tbody></table>\n", out);
}

static void write_all_totals(FILE *out, const check_totals *totals) {
    const size_t infos = rules_of(totals, NORMA_SEVERITY_INFO);
    if (totals->errors + totals->warnings)
        write_html_totals(out, totals, NORMA_SEVERITY_ERROR, NORMA_SEVERITY_WARNING);
    if (!infos) return;
    fputs("<details><summary>", out);
    cli_counted(out, totals->infos, "info", "infos");
    fputs(" of ", out);
    cli_counted(out, infos, "rule", "rules");
    fputs("</summary>\n", out);
    write_html_totals(out, totals, NORMA_SEVERITY_INFO, NORMA_SEVERITY_INFO);
    fputs("</details>\n", out);
}

/* ---- the list of files */

static void write_listed_file(FILE *out, const check_entry *entry) {
    fputs("<li><a href=\"#", out);
    write_anchor(out, entry->path);
    fputs("\">", out);
    cli_write_outside_html(out, check_shown_path(entry->path));
    fputs("</a> ", out);
    if (entry->errors) cli_counted(out, entry->errors, "error", "errors");
    if (entry->errors && entry->warnings) fputs(", ", out);
    if (entry->warnings) cli_counted(out, entry->warnings, "warning", "warnings");
    fputs("</li>\n", out);
}

static void write_file_list(FILE *out, const check_list *list) {
    size_t troubled = 0;
    while (troubled < list->count && !list->entries[troubled].is_clean) ++troubled;
    if (list->count < 2 || !troubled) return;
    fprintf(out, "<details class=\"files\"%s><summary>", troubled > FILES_IN_SIGHT ? "" : " open");
    cli_counted(out, troubled, "file", "files");
    fputs(" with problems</summary>\n<ol>\n", out);
    for (size_t i = 0; i < troubled; ++i) write_listed_file(out, &list->entries[i]);
    fputs("</ol></details>\n", out);
}

static int has_clean_fold(const check_list *list) {
    return list->count > 1 && list->entries[list->count - 1].is_clean;
}

static void write_explanations(FILE *out, const check_totals *totals) {
    size_t count, written = 0;
    const norma_rule *rules = norma_rules(&count);
    for (size_t rule = 0; rule < count; ++rule) {
        const check_rule_total *total = totals->by_rule[rule];
        if (!total[NORMA_SEVERITY_INFO].findings && !total[NORMA_SEVERITY_WARNING].findings &&
            !total[NORMA_SEVERITY_ERROR].findings)
            continue;
        if (!written++) {
            fputs("<section><h2>What the rules mean</h2>\n", out);
            cli_write_rule_marks(out);
        }
        cli_write_rule_html(out, &rules[rule], 3);
    }
    if (written) fputs("</section>\n", out);
}

/* For norma report, which puts pages together. */
static void write_machine_totals(
    FILE *out, const check_totals *totals, const check_settings *settings) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    cli_json json = {.out = out};
    fputs(CHECK_HTML_TOTALS, out);
    cli_json_open(&json, NULL, '{');
    check_write_counts(&json, totals, 1);
    check_write_shard(&json, settings);
    cli_json_open(&json, "rules", '[');
    for (size_t rule = 0; rule < count; ++rule)
        for (size_t severity = 0; severity < CHECK_SEVERITIES; ++severity) {
            const check_rule_total *total = &totals->by_rule[rule][severity];
            if (!total->findings) continue;
            cli_json_print(&json, "{rule: %s, severity: %s, findings: %zu, files: %zu}",
                rules[rule].id, cli_severity_name((norma_severity)severity), total->findings,
                total->files);
        }
    cli_json_print(&json, "]}");
    fputs("</script>\n", out);
}

static void end_html(FILE *out, const check_totals *totals, const check_settings *settings) {
    if (has_clean_fold(totals->list)) fputs("</details>\n", out);
    write_explanations(out, totals);
    fputs("<section id=\"summary\" aria-label=\"Summary\"><p class=\"verdict\">", out);
    if (totals->errors + totals->warnings + totals->not_checked == 0)
        fputs("No problems found. ", out);
    check_write_verdict(out, totals);
    if (settings->missing) fprintf(out, "; shards %s are missing", settings->missing);
    fputs("</p>\n", out);
    write_all_totals(out, totals);
    write_file_list(out, totals->list);
    fputs("<form hidden><label>Show <select id=\"least\"><option value=\"0\">everything</option>"
          "<option value=\"2\">errors and warnings</option><option value=\"3\">errors</option>"
          "</select></label> <label>with the words <input id=\"words\" type=\"search\"></label> "
          "<span id=\"shown\" role=\"status\"></span></form>\n<p id=\"how\" hidden>Each finding "
          "can link to a page in which the model turns and the place is marked: run <code>norma "
          "view</code> with the same files and <code>--out-dir pages</code>, then check again with "
          "<code>--page pages/</code>.</p>\n</section>\n</main>\n",
        out);
    write_machine_totals(out, totals, settings);
    fputs(script, out);
    fputs("</body></html>\n", out);
}

const check_format check_format_html = {"html", begin_html, write_html_file, "", end_html, 1,
    "<details id=\"clean\"><summary>Files without problems</summary>\n"};
