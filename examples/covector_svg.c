/* covector_svg.c: draws a figure of the guide: a covector as evenly spaced lines, and a step that
 * crosses some of them; then both through a matrix.
 *
 *     covector_svg > covector.svg
 *
 * A covector n is drawn as the lines n . x = 0, 1, 2, ...: what it returns for a step is the number
 * of lines that the step crosses. Points that lay on a line still do after the transform, so the
 * right lines cross the moved step as often as before. */
#include <math.h>
#include <stdio.h>

typedef struct vec2 {
    double x, y;
} vec2;

typedef struct mat2 {
    double xx, xy, yx, yy; /* row by row */
} mat2;

static const double unit = 46; /* pixels */

static vec2 apply(mat2 m, vec2 v) {
    return (vec2){m.xx * v.x + m.xy * v.y, m.yx * v.x + m.yy * v.y};
}

static double dot(vec2 a, vec2 b) { return a.x * b.x + a.y * b.y; }

/* The inverse transpose: the cofactors, divided by the determinant. */
static mat2 inverse_transpose(mat2 m) {
    const double det = m.xx * m.yy - m.xy * m.yx;
    return (mat2){m.yy / det, -m.yx / det, -m.xy / det, m.xx / det};
}

/* An arrow from the panel's origin. */
static void draw_arrow(double x, double y, vec2 v, const char *colour) {
    const double length = hypot(v.x, v.y), dx = v.x / length, dy = v.y / length;
    const double tip_x = x + v.x * unit, tip_y = y - v.y * unit;
    const double neck_x = tip_x - dx * 9, neck_y = tip_y + dy * 9;
    printf("<path d=\"M%.2f %.2fL%.2f %.2f\" stroke=\"%s\" stroke-width=\"2.4\"/>", x, y, neck_x,
        neck_y, colour);
    printf("<path d=\"M%.2f %.2fL%.2f %.2fL%.2f %.2fZ\" fill=\"%s\"/>\n", tip_x, tip_y,
        neck_x + dy * 4, neck_y + dx * 4, neck_x - dy * 4, neck_y - dx * 4, colour);
}

/* The lines n . x = -4 ... 5 as far as the panel's clip path lets them show. */
static void draw_lines(double x, double y, vec2 n, const char *colour) {
    const double square = dot(n, n), reach = 9;
    for (int i = -4; i <= 5; ++i) {
        const vec2 foot = {n.x * i / square, n.y * i / square};
        const vec2 along = {-n.y / sqrt(square) * reach, n.x / sqrt(square) * reach};
        printf("<path d=\"M%.2f %.2fL%.2f %.2f\" stroke=\"%s\" stroke-width=\"%s\"/>\n",
            x + (foot.x - along.x) * unit, y - (foot.y - along.y) * unit,
            x + (foot.x + along.x) * unit, y - (foot.y + along.y) * unit, colour,
            i ? "1.2" : "2.6");
    }
}

static void draw_panel(double left, const char *title, vec2 n, vec2 step, const char *colour) {
    const double x = left + 110, y = 210;
    printf("<g>\n<text x=\"%.0f\" y=\"38\" class=\"title\">%s</text>\n", left + 150, title);
    printf("<clipPath id=\"c%.0f\"><rect x=\"%.0f\" y=\"58\" width=\"280\" height=\"210\"/>"
           "</clipPath>\n<g clip-path=\"url(#c%.0f)\">\n",
        left, left + 10, left);
    draw_lines(x, y, n, colour);
    printf("</g>\n");
    draw_arrow(x, y, step, "#222");
    printf("<text x=\"%.0f\" y=\"300\" class=\"note\" fill=\"%s\">the step crosses %.2g lines"
           "</text>\n</g>\n",
        left + 150, colour, dot(n, step));
}

int main(void) {
    const mat2 model = {1.5, 0.5, 0, 0.75};
    const vec2 n = {0.6, 0.8}, step = {1.2, 1.6};
    const vec2 moved = apply(model, step);
    printf("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 960 330\" width=\"960\" "
           "height=\"330\" role=\"img\" aria-labelledby=\"title\">\n");
    printf("<title id=\"title\">Evenly spaced lines and an arrow that crosses two of them; after a "
           "stretch and a shear, lines through M are crossed %.2g times, lines through the inverse "
           "transpose twice</title>\n",
        dot(apply(model, n), moved));
    printf("<style>text{font-family:Helvetica,Arial,'Liberation "
           "Sans',sans-serif;text-anchor:middle}.title{font-size:17px;font-weight:bold;fill:#222}"
           ".note{font-size:16px;font-weight:bold}</style>\n");
    printf("<rect width=\"960\" height=\"330\" rx=\"8\" fill=\"#fdfcf9\"/>\n");
    draw_panel(10, "covector n, step v", n, step, "#2b5c9e");
    draw_panel(330, "wrong: M n, M v", apply(model, n), moved, "#c0392b");
    draw_panel(650,
        "right: M<tspan dy=\"-5\" font-size=\"11\">−T</tspan><tspan dy=\"5\">&#160;n, "
        "M v</tspan>",
        apply(inverse_transpose(model), n), moved, "#1d7a4a");
    printf("</svg>\n");
    return 0;
}
