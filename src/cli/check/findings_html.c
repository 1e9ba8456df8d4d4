/* findings_html.c: findings as a page with pictures. */
#define _POSIX_C_SOURCE 200809L
#include "cli/check/check.h"
#include "cli/process/process.h"
#include "cli/text/text.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- The surface round a finding's worst place, as SVG: its nearest faces seen
 * along the normals of those that are meant, from far to near (the painter's algorithm; Newell,
 * Newell, Sancha 1972), grey by their slope to the light. Those that are named are drawn once more
 * over all others, so that they are seen wherever they lie, and ringed if they are small; stored
 * normals of vertices that are named are lines. */

enum { SIDE = 220, MOST_FACES = 140, MOST_SAMPLES = 10, SMALL = 14 };

typedef struct near_face {
    size_t face;
    double distance; /* from the place, then along the view */
} near_face;

typedef struct picture {
    const norma_mesh_data *data;
    const norma_finding *finding;
    double place[3], radius;
    double right[3], up[3], view[3]; /* view: towards the eye */
    near_face *faces;
    size_t count;
} picture;

/* ---- reading the mesh */

static size_t count_faces(const norma_mesh *mesh) {
    return mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
}
static size_t face_begin(const norma_mesh *mesh, size_t face) {
    return mesh->face_starts ? mesh->face_starts[face] : 3 * face;
}
static size_t face_end(const norma_mesh *mesh, size_t face) { return face_begin(mesh, face + 1); }

static int read_vector(const norma_vec3_view *view, size_t index, double vector[3]) {
    if (index >= view->count) return 0;
    norma_view_vector(view, index, vector);
    return isfinite(vector[0]) && isfinite(vector[1]) && isfinite(vector[2]);
}

/* ---- small vectors */

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3]) {
    double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2],
           z = a[0] * b[1] - a[1] * b[0];
    out[0] = x, out[1] = y, out[2] = z;
}

static int normalise(double v[3]) {
    double length = sqrt(dot(v, v));
    if (!(length > 0) || !isfinite(length)) return 0;
    for (int axis = 0; axis < 3; ++axis) v[axis] /= length;
    return 1;
}

/* The vector area of a face relative to its first corner; 0: it has none. */
static int direction_of_face(const norma_mesh *mesh, size_t face, double normal[3]) {
    size_t begin = face_begin(mesh, face), end = face_end(mesh, face);
    double first[3], a[3], b[3], part[3];
    memset(normal, 0, 3 * sizeof *normal);
    if (end - begin < 3 || !read_vector(&mesh->positions, norma_mesh_corner(mesh, begin), first))
        return 0;
    for (size_t corner = begin + 1; corner + 1 < end; ++corner) {
        if (!read_vector(&mesh->positions, norma_mesh_corner(mesh, corner), a) ||
            !read_vector(&mesh->positions, norma_mesh_corner(mesh, corner + 1), b))
            return 0;
        for (int axis = 0; axis < 3; ++axis) a[axis] -= first[axis], b[axis] -= first[axis];
        cross(a, b, part);
        for (int axis = 0; axis < 3; ++axis) normal[axis] += part[axis];
    }
    return normalise(normal);
}

/* ---- what is meant */

static int is_sampled_face(const norma_finding *finding, size_t face) {
    for (size_t i = 0; i < finding->sample_count; ++i)
        if (finding->samples[i].face == face) return 1;
    return finding->worst.face == face;
}

static int is_sampled_vertex(const norma_finding *finding, size_t vertex) {
    for (size_t i = 0; i < finding->sample_count; ++i)
        if (finding->samples[i].vertex == vertex) return 1;
    return finding->worst.vertex == vertex;
}

static int is_named_face(const picture *drawn, size_t face) {
    const norma_mesh *mesh = &drawn->data->mesh;
    if (is_sampled_face(drawn->finding, face)) return 1;
    if (drawn->finding->worst.face != SIZE_MAX) return 0;
    size_t end = face_end(mesh, face);
    for (size_t corner = face_begin(mesh, face); corner < end; ++corner)
        if (is_sampled_vertex(drawn->finding, norma_mesh_corner(mesh, corner))) return 1;
    return 0;
}

static int find_place(picture *drawn) {
    const norma_sample *sample = drawn->finding->worst.has_position ? &drawn->finding->worst
                                 : drawn->finding->sample_count     ? drawn->finding->samples
                                                                    : NULL;
    if (!sample || !sample->has_position) return 0;
    memcpy(drawn->place, sample->position, sizeof drawn->place);
    return isfinite(dot(drawn->place, drawn->place));
}

/* ---- which faces */

static int compare_distance(const void *a, const void *b) {
    const near_face *one = a, *other = b;
    if (one->distance != other->distance) return one->distance < other->distance ? -1 : 1;
    return one->face < other->face ? -1 : one->face > other->face;
}

/* By the nearest corner; infinite: a corner is not finite. */
static double distance_of(const picture *drawn, size_t face) {
    const norma_mesh *mesh = &drawn->data->mesh;
    size_t end = face_end(mesh, face);
    double nearest = INFINITY, at[3];
    for (size_t corner = face_begin(mesh, face); corner < end; ++corner) {
        if (!read_vector(&mesh->positions, norma_mesh_corner(mesh, corner), at)) return INFINITY;
        for (int axis = 0; axis < 3; ++axis) at[axis] -= drawn->place[axis];
        nearest = fmin(nearest, dot(at, at));
    }
    return nearest;
}

/* The nearest MOST_FACES, kept as a heap would: the list is cut back whenever it is twice as long.
 */
static int find_nearest_faces(picture *drawn) {
    const norma_mesh *mesh = &drawn->data->mesh;
    drawn->faces = malloc(2 * MOST_FACES * sizeof *drawn->faces);
    if (!drawn->faces) return 0;
    for (size_t face = 0; face < count_faces(mesh); ++face) {
        double distance = distance_of(drawn, face);
        if (!isfinite(distance)) continue;
        drawn->faces[drawn->count++] = (near_face){face, distance};
        if (drawn->count == 2 * MOST_FACES) {
            qsort(drawn->faces, drawn->count, sizeof *drawn->faces, compare_distance);
            drawn->count = MOST_FACES;
        }
    }
    qsort(drawn->faces, drawn->count, sizeof *drawn->faces, compare_distance);
    drawn->count = drawn->count < MOST_FACES ? drawn->count : MOST_FACES;
    return drawn->count > 0;
}

/* ---- the view: along what is meant, a little from the side, so that depth shows */

/* The nearest faces count most, and those that are meant alone if there are any: they then face the
 * eye. */
static void sum_normals(const picture *drawn, int meant_only, double sum[3]) {
    double normal[3];
    for (size_t i = 0; i < drawn->count; ++i) {
        const size_t face = drawn->faces[i].face;
        if (meant_only && !is_named_face(drawn, face)) continue;
        if (!direction_of_face(&drawn->data->mesh, face, normal)) continue;
        for (int axis = 0; axis < 3; ++axis) sum[axis] += normal[axis] / (1.0 + (double)i);
    }
}

static void look(picture *drawn) {
    double sum[3] = {0, 0, 0}, helper[3] = {0, 1, 0};
    sum_normals(drawn, 1, sum);
    if (dot(sum, sum) < 1e-6) sum_normals(drawn, 0, sum);
    if (!normalise(sum)) sum[0] = sum[1] = 0, sum[2] = 1;
    if (fabs(sum[1]) > 0.9) helper[1] = 0, helper[2] = 1;
    cross(helper, sum, drawn->right);
    normalise(drawn->right);
    cross(sum, drawn->right, drawn->up);
    for (int axis = 0; axis < 3; ++axis)
        drawn->view[axis] = sum[axis] + 0.35 * drawn->right[axis] + 0.3 * drawn->up[axis];
    normalise(drawn->view);
    cross(drawn->up, drawn->view, drawn->right);
    normalise(drawn->right);
    cross(drawn->view, drawn->right, drawn->up);
}

/* So far that some two dozen faces show. */
static void choose_radius(picture *drawn) {
    size_t last = drawn->count < 24 ? drawn->count - 1 : 23;
    double far_squared = drawn->faces[last].distance, at[3];
    const norma_mesh *mesh = &drawn->data->mesh;
    size_t nearest = drawn->faces[0].face;
    for (size_t corner = face_begin(mesh, nearest); corner < face_end(mesh, nearest); ++corner)
        if (read_vector(&mesh->positions, norma_mesh_corner(mesh, corner), at)) {
            for (int axis = 0; axis < 3; ++axis) at[axis] -= drawn->place[axis];
            far_squared = fmax(far_squared, dot(at, at));
        }
    drawn->radius = 1.3 * sqrt(far_squared);
}

/* A million radii away: of such a corner only the direction shows, and pixels stay whole numbers.
 */
static void pull_near(double local[3], double radius) {
    const double most = 1e6;
    double far = 0;
    for (int axis = 0; axis < 3; ++axis) {
        local[axis] = fmax(-DBL_MAX, fmin(DBL_MAX, local[axis])); /* a difference overflows */
        far = fmax(far, fabs(local[axis]));
    }
    if (far / radius <= most) return;
    for (int axis = 0; axis < 3; ++axis) local[axis] = local[axis] / far * most * radius;
}

static void project(const picture *drawn, const double at[3], double *x, double *y, double *depth) {
    double local[3] = {at[0] - drawn->place[0], at[1] - drawn->place[1], at[2] - drawn->place[2]};
    pull_near(local, drawn->radius);
    *x = SIDE / 2.0 + SIDE / 2.0 * (dot(local, drawn->right) / drawn->radius);
    *y = SIDE / 2.0 - SIDE / 2.0 * (dot(local, drawn->up) / drawn->radius);
    *depth = dot(local, drawn->view);
}

/* ---- drawing */

/* From far to near; faces beyond the picture's border, most of them, are left out. */
static void sort_by_depth(picture *drawn) {
    const norma_mesh *mesh = &drawn->data->mesh;
    size_t kept = 0;
    for (size_t i = 0; i < drawn->count; ++i) {
        const size_t face = drawn->faces[i].face, begin = face_begin(mesh, face),
                     end = face_end(mesh, face);
        double sum = 0, at[3], x, y, depth, least[2] = {SIDE, SIDE}, most[2] = {0, 0};
        for (size_t corner = begin; corner < end; ++corner)
            if (read_vector(&mesh->positions, norma_mesh_corner(mesh, corner), at)) {
                project(drawn, at, &x, &y, &depth);
                least[0] = fmin(least[0], x), least[1] = fmin(least[1], y);
                most[0] = fmax(most[0], x), most[1] = fmax(most[1], y);
                sum += depth;
            }
        if (least[0] < SIDE && least[1] < SIDE && most[0] > 0 && most[1] > 0)
            drawn->faces[kept++] = (near_face){face, sum / (double)(end - begin)};
    }
    drawn->count = kept;
    qsort(drawn->faces, drawn->count, sizeof *drawn->faces, compare_distance);
}

/* Corners as whole points, each from the last: a page holds many faces. */
static void draw_outline(FILE *out, const picture *drawn, size_t face) {
    const norma_mesh *mesh = &drawn->data->mesh;
    long last[2] = {0, 0};
    int count = 0;
    for (size_t corner = face_begin(mesh, face); corner < face_end(mesh, face); ++corner) {
        double at[3], x, y, depth;
        if (!read_vector(&mesh->positions, norma_mesh_corner(mesh, corner), at)) continue;
        project(drawn, at, &x, &y, &depth);
        const long point[2] = {lround(x), lround(y)};
        fprintf(out, count++ ? "l%ld %ld" : "M%ld %ld", point[0] - last[0], point[1] - last[1]);
        last[0] = point[0], last[1] = point[1];
    }
    fputs("z'/>\n", out);
}

static void draw_face(FILE *out, const picture *drawn, size_t face) {
    static const char digits[] = "0123456789abcdef";
    double normal[3] = {0, 0, 0};
    const double slope =
        direction_of_face(&drawn->data->mesh, face, normal) ? fabs(dot(normal, drawn->view)) : 1;
    const char grey = digits[(int)(6 + 8.9 * fmin(slope, 1))];
    fprintf(out, "<path fill='#%c%c%c' d='", grey, grey, grey);
    draw_outline(out, drawn, face);
}

/* Over all others; the extent of all of them is what a ring is drawn around. */
static void draw_meant(FILE *out, const picture *drawn) {
    const norma_mesh *mesh = &drawn->data->mesh;
    double least[2] = {INFINITY, INFINITY}, most[2] = {-INFINITY, -INFINITY}, at[3], x, y, depth;
    for (size_t i = 0; i < drawn->count; ++i) {
        const size_t face = drawn->faces[i].face;
        if (!is_named_face(drawn, face)) continue;
        fputs("<path class='m' d='", out);
        draw_outline(out, drawn, face);
        for (size_t corner = face_begin(mesh, face); corner < face_end(mesh, face); ++corner)
            if (read_vector(&mesh->positions, norma_mesh_corner(mesh, corner), at)) {
                project(drawn, at, &x, &y, &depth);
                least[0] = fmin(least[0], x), least[1] = fmin(least[1], y);
                most[0] = fmax(most[0], x), most[1] = fmax(most[1], y);
            }
    }
    const int is_seen = fmin(most[0] - least[0], most[1] - least[1]) >= SMALL;
    project(drawn, drawn->place, &x, &y, &depth);
    if (!is_seen) fprintf(out, "<circle class='r' cx='%.0f' cy='%.0f' r='%d'/>\n", x, y, SMALL);
}

/* Stored normals of the vertices that are named, a quarter of the picture long. */
static void draw_normals(FILE *out, const picture *drawn) {
    if (drawn->data->corner_normals) return;
    for (size_t i = 0; i < drawn->finding->sample_count && i < MOST_SAMPLES; ++i) {
        const norma_sample *sample = &drawn->finding->samples[i];
        double normal[3], from[3], to[3], x0, y0, x1, y1, depth;
        if (sample->vertex == SIZE_MAX || !sample->has_position ||
            !read_vector(&drawn->data->normals, sample->vertex, normal) || !normalise(normal))
            continue;
        memcpy(from, sample->position, sizeof from);
        for (int axis = 0; axis < 3; ++axis)
            to[axis] = from[axis] + 0.5 * drawn->radius * normal[axis];
        project(drawn, from, &x0, &y0, &depth);
        project(drawn, to, &x1, &y1, &depth);
        fprintf(out,
            "<path class='n' d='M%.0f %.0fL%.0f %.0f'/><circle class='d' cx='%.0f' cy='%.0f' "
            "r='3'/>\n",
            x0, y0, x1, y1, x0, y0);
    }
}

static int find_mesh(norma_document *document, const char *where, norma_mesh_data *data) {
    norma_mesh_info info;
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i)
        if (!norma_document_mesh_info(document, i, &info) && strcmp(info.where, where) == 0)
            return !info.not_read && !norma_document_mesh_data(document, i, data, NULL);
    return 0;
}

void check_draw_finding(FILE *out, norma_document *document, const norma_finding *finding) {
    norma_mesh_data data;
    picture drawn = {.data = &data, .finding = finding};
    if (document && find_place(&drawn) && find_mesh(document, finding->where, &data) &&
        find_nearest_faces(&drawn)) {
        look(&drawn);
        choose_radius(&drawn);
        if (drawn.radius > 0 && isfinite(drawn.radius)) {
            sort_by_depth(&drawn);
            fprintf(out,
                "<svg viewBox='0 0 %d %d' role='img' aria-label='%s: the worst place, marked in "
                "red'>\n",
                SIDE, SIDE, finding->rule->name);
            for (size_t i = 0; i < drawn.count; ++i) draw_face(out, &drawn, drawn.faces[i].face);
            draw_meant(out, &drawn);
            draw_normals(out, &drawn);
            fputs("</svg>\n", out);
        }
    }
    free(drawn.faces);
}

/* ---- Findings as one HTML file that needs nothing else: a summary, then each file
 * with its rules, a picture of the worst place of each, and what the rules mean. Information is
 * folded. Pictures share a budget, so that the page of a folder stays small enough to send. */

enum {
    PAGE_BYTES = 600000, /* of pictures, shared by the files */
    LEAST_BYTES = 5000,  /* of a file: one picture */
    MOST_BYTES = 200000,
    PLACES_OF_PROBLEM = 10,
    PLACES_OF_INFO = 3,
    FILES_WITH_INFO_PICTURES = 4
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
    "overflow-wrap:anywhere}.fix code{user-select:all}\n"
    "details{margin:.6rem 0}summary{cursor:pointer;padding:.2rem 0}\n"
    "figure svg{width:220px;max-width:100%;height:auto;background:#dfe3e8;border-radius:6px}\n"
    "figure path{stroke:#0005;stroke-width:.5;stroke-linejoin:round}figure .m{stroke:#a00;"
    "stroke-width:1.5;fill:#e00;fill-opacity:.45}figure .r{stroke:#d00;stroke-width:2.5;fill:none}"
    "figure .n{stroke:#0b57d0;stroke-width:2;fill:none}figure .d{fill:#0b57d0;stroke:none}\n"
    ".bins{width:auto;font-size:.85rem}.bins td{border:0;padding:0 .5rem 0 "
    "0;white-space:nowrap}.bins "
    "i{display:inline-block;height:.7em;background:var(--info)}\n"
    "@media(max-width:640px){.rule{display:block}.rule>figure{margin:.5rem 0}main{padding:.7rem}"
    ".wide{display:none}}\n"
    "[hidden]{display:none!important}\n";

static const char script[] =
    "<script>\n"
    "const main=document.querySelector('main'),summary=document.getElementById('summary');\n"
    "document.querySelector('header').after(summary);\n"
    "const least=document.getElementById('least'),words=document.getElementById('words'),shown="
    "document.getElementById('shown');\n"
    "const show=()=>{const text=words.value.toLowerCase();let n=0,all=0;\n"
    "  for(const file of document.querySelectorAll('.file')){let any=false;\n"
    "    for(const rule of file.querySelectorAll('.rule')){const "
    "seen=+rule.dataset.severity>=+least."
    "value&&(file.dataset.path+' "
    "'+rule.textContent).toLowerCase().includes(text);rule.hidden=!seen;"
    "any||=seen;n+=seen;all++}\n"
    "    const "
    "infos=file.querySelector('.infos');if(infos)infos.hidden=!infos.querySelector('.rule:not("
    "[hidden])');\n"
    "    file.hidden=!any&&(text!==''||+least.value>0)}\n"
    "  shown.textContent=n+' of '+all+' shown'};\n"
    "document.querySelector('form').hidden=false;\n"
    "document.querySelector('form').addEventListener('input',show);document.querySelector('form')."
    "addEventListener('submit',e=>e.preventDefault());show();\n"
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

static void write_place(FILE *out, const check_report *report, const check_item *item) {
    const norma_finding *finding = item->finding;
    fputs("<li>", out);
    if (finding->label[0]) {
        cli_write_outside_html(out, finding->label);
        fputs(": ", out);
    }
    cli_write_outside_html(out, finding->message);
    const size_t length = strlen(finding->message);
    if (length && !strchr(".!?", finding->message[length - 1])) fputc('.', out);
    write_html_worst(out, report, finding);
    fputs("</li>\n", out);
}

static void write_places(FILE *out, const check_report *report, const check_item *first) {
    const size_t most = first->severity == NORMA_SEVERITY_INFO ? PLACES_OF_INFO : PLACES_OF_PROBLEM;
    const size_t places = check_places(report, first);
    size_t written = 0;
    fputs("<ul>\n", out);
    for (const check_item *item = first; written < places && written < most; ++item) {
        if (!check_is_same(first, item)) continue;
        write_place(out, report, item);
        ++written;
    }
    if (places > written) fprintf(out, "<li>and %zu more places</li>\n", places - written);
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
            item->finding->label[0] ? "The worst place of the first" : "The worst place");
        *budget -= drawing.size;
    }
    free(drawing.text);
}

static void write_html_rule(
    FILE *out, const check_report *report, const check_item *item, size_t *budget) {
    const norma_rule *rule = item->finding->rule;
    const char *severity = cli_severity_name(item->severity);
    const size_t places = check_places(report, item);
    fprintf(out,
        "<section class=\"rule is-%s\" data-severity=\"%d\"><h3><span class=\"severity "
        "%s\">%s</span> "
        "<a href=\"#%s\">%s %s</a>",
        severity, (int)item->severity, severity, severity, rule->id, rule->id, rule->name);
    if (places > 1) fprintf(out, ", %zu places", places);
    fputs("</h3>\n", out);
    write_places(out, report, item);
    if (item->finding->deviation && places == 1) write_histogram(out, item->finding->deviation);
    if (item->command) {
        fputs("<p class=\"fix\">Fix: <code>", out);
        cli_write_outside_html(out, item->command);
        fputs("</code></p>\n", out);
    }
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
        fputs("No problems found", out);
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
    if (!report->document) return;
    for (size_t i = report->first_note; i < norma_document_note_count(report->document); ++i) {
        if (!check_is_new_note(report->document, report->first_note, i)) continue;
        fputs("<p>Not fixed: ", out);
        cli_write_outside_html(out, norma_document_note(report->document, i));
        fputs("</p>\n", out);
    }
}

static void write_html_file(FILE *out, const check_report *report) {
    size_t budget = budget_of(report);
    fputs(CHECK_HTML_FILE, out);
    check_write_bytes(out, report->path);
    fprintf(out, CHECK_HTML_STATUS "%s%s<h2>", report->status,
        check_fails(report) ? CHECK_HTML_FAILS : "\">");
    cli_write_outside_html(out, cli_input_name(report->path));
    fputs("</h2>\n", out);
    write_counts(out, report);
    if (report->mended) {
        fputs("<p>Fixed:</p><pre tabindex=\"0\">", out);
        fputs(report->mended, out);
        fputs("</pre>\n", out);
    }
    write_html_reasons(out, report);
    write_rules(out, report, NORMA_SEVERITY_ERROR, &budget);
    write_rules(out, report, NORMA_SEVERITY_WARNING, &budget);
    write_infos(out, report, &budget);
    fputs(CHECK_HTML_FILE_END, out);
}

/* ---- the summary, and the rules */

static void write_html_total(
    FILE *out, const norma_rule *rule, norma_severity severity, const check_rule_total *total) {
    const char *name = cli_severity_name(severity);
    fprintf(out,
        "<tr><td><span class=\"severity %s\">%s</span></td><td><a href=\"#%s\">%s <span "
        "class=\"wide\">%s</span></a></td><td class=\"number\">%zu</td><td "
        "class=\"number\">%zu</td></tr>\n",
        name, name, rule->id, rule->id, rule->name, total->places, total->files);
}

static size_t rules_of(const check_totals *totals, norma_severity severity) {
    size_t found = 0;
    for (size_t rule = 0; rule < CHECK_RULES; ++rule)
        found += totals->by_rule[rule][severity].places > 0;
    return found;
}

static void write_html_totals(
    FILE *out, const check_totals *totals, norma_severity gravest, norma_severity least) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    fputs("<table><thead><tr><th scope=\"col\">Severity</th><th scope=\"col\">Rule</th><th "
          "scope=\"col\" class=\"number\">Places</th><th scope=\"col\" "
          "class=\"number\">Files</th></tr></thead><tbody>\n",
        out);
    for (norma_severity severity = gravest; severity >= least; --severity)
        for (size_t rule = 0; rule < count; ++rule)
            if (totals->by_rule[rule][severity].places)
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

static void write_explanations(FILE *out, const check_totals *totals) {
    size_t count, written = 0;
    const norma_rule *rules = norma_rules(&count);
    for (size_t rule = 0; rule < count; ++rule) {
        const check_rule_total *total = totals->by_rule[rule];
        if (!total[NORMA_SEVERITY_INFO].places && !total[NORMA_SEVERITY_WARNING].places &&
            !total[NORMA_SEVERITY_ERROR].places)
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
            if (!totals->by_rule[rule][severity].places) continue;
            cli_json_open(&json, NULL, '{');
            cli_json_string(&json, "rule", rules[rule].id);
            cli_json_string(&json, "severity", cli_severity_name((norma_severity)severity));
            cli_json_size(&json, "places", totals->by_rule[rule][severity].places);
            cli_json_size(&json, "files", totals->by_rule[rule][severity].files);
            cli_json_close(&json, '}');
        }
    cli_json_close(&json, ']');
    cli_json_close(&json, '}');
    fputs("</script>\n", out);
}

static void end_html(FILE *out, const check_totals *totals, const check_settings *settings) {
    write_explanations(out, totals);
    fputs("<section id=\"summary\" aria-label=\"Summary\"><p class=\"verdict\">", out);
    if (totals->errors + totals->warnings + totals->not_checked == 0)
        fputs("No problems found. ", out);
    check_write_verdict(out, totals);
    if (settings->missing) fprintf(out, "; shards %s are missing", settings->missing);
    fputs("</p>\n", out);
    write_all_totals(out, totals);
    fputs("<form hidden><label>Show <select id=\"least\"><option value=\"0\">everything</option>"
          "<option value=\"2\">errors and warnings</option><option value=\"3\">errors</option>"
          "</select></label> <label>with the words <input id=\"words\" type=\"search\"></label> "
          "<span id=\"shown\" role=\"status\"></span></form>\n</section>\n</main>\n",
        out);
    write_machine_totals(out, totals, settings);
    fputs(script, out);
    fputs("</body></html>\n", out);
}

const check_format check_format_html = {"html", begin_html, write_html_file, "", end_html};
