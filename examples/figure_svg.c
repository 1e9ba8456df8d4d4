/* figure_svg.c: draws a figure of the guide: a round tube scaled by (2, 0.5), with the normals that
 * M itself gives and those of the normal matrix.
 *
 *     figure_svg > normal-matrix.svg
 *
 * Every point and every arrow is Norma's output: the tube's normals, the points through M, the
 * normals through M and through norma_normal_matrix. */
#include <math.h>
#include <norma/norma.h>
#include <stdio.h>

enum {
    SIDES = 32,
    VERTICES = 2 * SIDES,
    CORNERS = 4 * SIDES,
    MARKED = SIDES / 8
}; /* the marked vertex is at 45 degrees */

#define DEGREES 57.29577951308232
static const double unit = 62, arrow = 34; /* pixels */

typedef struct panel {
    double x, y; /* of its centre, in pixels */
    const char *title, *formula, *colour;
    float points[VERTICES][3], normals[VERTICES][3];
} panel;

/* A tube round the z axis, of quads, open at both ends; vertices 0 to SIDES - 1 are the section
 * that is drawn. */
static int make_tube(panel *p) {
    uint32_t corners[CORNERS], starts[SIDES + 1];
    for (uint32_t i = 0; i < SIDES; ++i) {
        const double turn = 2 * 3.14159265358979 * i / SIDES;
        for (uint32_t end = 0; end < 2; ++end) {
            float *point = p->points[i + end * SIDES];
            point[0] = (float)cos(turn);
            point[1] = (float)sin(turn);
            point[2] = (float)end;
        }
        const uint32_t next = (i + 1) % SIDES, quad[4] = {i, next, next + SIDES, i + SIDES};
        for (uint32_t k = 0; k < 4; ++k) corners[4 * i + k] = quad[k];
        starts[i] = 4 * i;
    }
    starts[SIDES] = CORNERS;
    const norma_mesh mesh = {.positions = {.data = p->points, .count = VERTICES},
        .corners = corners,
        .corner_count = CORNERS,
        .face_starts = starts,
        .face_count = SIDES};
    return norma_vertex_normals(&mesh, NULL, p->normals[0], VERTICES, NULL) == NORMA_OK;
}

static int transform(const panel *from, const double model[16], const float matrix[9], panel *to) {
    const norma_vec3_view points = {.data = from->points, .count = VERTICES},
                          normals = {.data = from->normals, .count = VERTICES};
    return norma_transform_positions(model, points, to->points[0], 0, VERTICES) == NORMA_OK &&
           norma_transform_normals(matrix, normals, to->normals[0], 0, VERTICES) == NORMA_OK;
}

static double angle_between(const float a[3], const float b[3]) {
    const double dot =
        (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
    return acos(fmax(-1, fmin(1, dot))) * DEGREES;
}

/* The tangent at the marked vertex of a section: from one neighbour to the other. */
static void marked_tangent(const panel *p, float tangent[3]) {
    const float *a = p->points[MARKED + 1], *b = p->points[MARKED - 1];
    const double x = (double)b[0] - (double)a[0], y = (double)b[1] - (double)a[1],
                 length = hypot(x, y);
    tangent[0] = (float)(x / length);
    tangent[1] = (float)(y / length);
    tangent[2] = 0;
}

static void draw_arrow(
    double x, double y, double dx, double dy, double length, const char *colour, double width) {
    const double tip_x = x + dx * length, tip_y = y - dy * length, head = 4 + 1.5 * width;
    const double neck_x = tip_x - dx * head, neck_y = tip_y + dy * head, side = 0.42 * head;
    printf("<path d=\"M%.2f %.2fL%.2f %.2f\" stroke=\"%s\" stroke-width=\"%.1f\"/>", x, y, neck_x,
        neck_y, colour, width);
    printf("<path d=\"M%.2f %.2fL%.2f %.2fL%.2f %.2fZ\" fill=\"%s\"/>\n", tip_x, tip_y,
        neck_x + dy * side, neck_y + dx * side, neck_x - dy * side, neck_y - dx * side, colour);
}

/* An arc round (x, y) from direction a to direction b, which lie less than half a turn apart. */
static void draw_arc(double x, double y, const float a[3], const float b[3], double radius) {
    const int anticlockwise = (double)a[0] * (double)b[1] - (double)a[1] * (double)b[0] > 0;
    printf("<path d=\"M%.2f %.2fA%.1f %.1f 0 0 %d %.2f %.2f\" fill=\"none\" stroke=\"#222\" "
           "stroke-width=\"1.2\"/>\n",
        x + (double)a[0] * radius, y - (double)a[1] * radius, radius, radius, anticlockwise ? 0 : 1,
        x + (double)b[0] * radius, y - (double)b[1] * radius);
}

static void draw_panel(const panel *p) {
    printf("<g>\n<text x=\"%.0f\" y=\"40\" class=\"title\">%s</text>\n<text x=\"%.0f\" y=\"64\" "
           "class=\"formula\">%s</text>\n",
        p->x, p->title, p->x, p->formula);
    printf("<path d=\"");
    for (int i = 0; i < SIDES; ++i)
        printf("%c%.2f %.2f", i ? 'L' : 'M', p->x + (double)p->points[i][0] * unit,
            p->y - (double)p->points[i][1] * unit);
    printf("Z\" fill=\"#e9e6de\" stroke=\"#57534a\" stroke-width=\"1.6\"/>\n");
    for (int i = 0; i < SIDES; ++i)
        if (i != MARKED)
            draw_arrow(p->x + (double)p->points[i][0] * unit, p->y - (double)p->points[i][1] * unit,
                (double)p->normals[i][0], (double)p->normals[i][1], arrow * 0.72, p->colour, 1.1);
}

/* The marked vertex: its tangent, its normal and the angle between them; where the normal is wrong,
 * the right one dashed. */
static void draw_marked(const panel *p, const float right[3]) {
    const double x = p->x + (double)p->points[MARKED][0] * unit,
                 y = p->y - (double)p->points[MARKED][1] * unit;
    const float *n = p->normals[MARKED];
    float tangent[3];
    marked_tangent(p, tangent);
    printf("<path d=\"M%.2f %.2fL%.2f %.2f\" stroke=\"#222\" stroke-width=\"1.4\"/>\n",
        x - (double)tangent[0] * 52, y + (double)tangent[1] * 52, x + (double)tangent[0] * 52,
        y - (double)tangent[1] * 52);
    if (right)
        printf("<path d=\"M%.2f %.2fL%.2f %.2f\" stroke=\"#1d7a4a\" stroke-width=\"1.6\" "
               "stroke-dasharray=\"4 3\"/>\n",
            x, y, x + (double)right[0] * arrow * 1.6, y - (double)right[1] * arrow * 1.6);
    draw_arc(x, y, n, tangent, 17);
    draw_arrow(x, y, (double)n[0], (double)n[1], arrow * 1.6, p->colour, 2.4);
    printf("<circle cx=\"%.2f\" cy=\"%.2f\" r=\"3\" fill=\"#222\"/>\n", x, y);
    printf("<text x=\"%.0f\" y=\"300\" class=\"note\" fill=\"%s\">%.1f° to the surface", p->x,
        p->colour, angle_between(n, tangent));
    if (right) printf(", %.1f° off", angle_between(n, right));
    printf("</text>\n</g>\n");
}

int main(void) {
    const double model[16] = {2, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const float plain[9] = {2, 0, 0, 0, 0.5F, 0, 0, 0, 1};
    float model_float[16], matrix[9];
    for (int i = 0; i < 16; ++i) model_float[i] = (float)model[i];

    static panel before = {
        .x = 150, .y = 180, .title = "before", .formula = "normals n", .colour = "#2b5c9e"};
    static panel wrong = {.x = 455,
        .y = 180,
        .title = "scaled by (2, 0.5): wrong",
        .formula = "M n, renormalised",
        .colour = "#c0392b"};
    static panel good = {.x = 805,
        .y = 180,
        .title = "scaled by (2, 0.5): right",
        .formula = "M<tspan dy=\"-5\" font-size=\"11\">−T</tspan><tspan dy=\"5\">&#160;n, "
                   "renormalised</tspan>",
        .colour = "#1d7a4a"};
    norma_matrix_info info;
    if (norma_normal_matrix(model_float, NORMA_WINDING_REVERSED, matrix, &info) != NORMA_OK ||
        !make_tube(&before) || !transform(&before, model, plain, &wrong) ||
        !transform(&before, model, matrix, &good))
        return 1;

    printf("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 980 330\" width=\"980\" "
           "height=\"330\" role=\"img\" aria-labelledby=\"title\">\n");
    printf("<title id=\"title\">A circle with its normals, and scaled by (2, 0.5): the normals "
           "through M lean by up to %.1f degrees, those through the normal "
           "matrix stay perpendicular</title>\n",
        info.worst_error_rad * DEGREES);
    printf("<style>text{font-family:Helvetica,Arial,'Liberation "
           "Sans',sans-serif;text-anchor:middle}.title{font-size:17px;font-weight:bold;fill:#222}"
           ".formula{font-size:15px;fill:#444}.note{font-size:16px;font-weight:bold}</style>\n");
    printf("<rect width=\"980\" height=\"330\" rx=\"8\" fill=\"#fdfcf9\"/>\n");
    draw_panel(&before), draw_marked(&before, NULL);
    draw_panel(&wrong), draw_marked(&wrong, good.normals[MARKED]);
    draw_panel(&good), draw_marked(&good, NULL);
    printf("</svg>\n");
    return 0;
}
