/* test_check_severities.c: where a rule has several severities, faults planted on both sides of the
 * threshold between them. */
#include "check.h"
#include "surfaces.h"

static const double origin[3] = {0, 0, 0};

static norma_findings *found;

static void run(surface *s, norma_check_profile profile, norma_file_format format) {
    norma_findings_free(found);
    found = surface_findings(s, &(norma_check_options){.profile = profile}, format);
}

/* The rule has that many findings of that severity, which count so many places. */
static void assert_counts(const char *id, norma_severity severity, size_t count) {
    size_t sum = 0;
    for (size_t i = 0; i < norma_findings_count(found); ++i) {
        const norma_finding *f = norma_findings_get(found, i);
        if (strcmp(f->rule->id, id) == 0 && f->severity == severity) sum += f->count;
    }
    if (sum != count) print_error("%s: %zu instead of %zu\n", id, sum, count);
    assert_int_equal(sum, count);
}

/* In the rule's findings: so many errors, warnings and infos. */
static void assert_found(surface *s, const char *id, size_t errors, size_t warnings, size_t infos) {
    run(s, NORMA_CHECK_PROFILE_RENDER, NORMA_FILE_GLB);
    assert_counts(id, NORMA_SEVERITY_ERROR, errors);
    assert_counts(id, NORMA_SEVERITY_WARNING, warnings);
    assert_counts(id, NORMA_SEVERITY_INFO, infos);
}

static void assert_printed(
    surface *s, const char *id, size_t errors, size_t warnings, size_t infos) {
    run(s, NORMA_CHECK_PROFILE_PRINT, NORMA_FILE_GLB);
    assert_counts(id, NORMA_SEVERITY_ERROR, errors);
    assert_counts(id, NORMA_SEVERITY_WARNING, warnings);
    assert_counts(id, NORMA_SEVERITY_INFO, infos);
}

static int tear_down(void **state) {
    (void)state;
    norma_findings_free(found);
    found = NULL;
    return 0;
}

static void scale_normal(surface *s, size_t vertex, double by) {
    for (size_t k = 0; k < 3; ++k)
        s->normals[3 * vertex + k] = (float)((double)s->normals[3 * vertex + k] * by);
}

/* ---- N103: in OBJ, numbers written with two digits */

static void lengths_of_two_digits(void **state) {
    (void)state;
    surface s = surface_torus(32, 16);
    scale_normal(&s, 7, 1.024);
    scale_normal(&s, 8, 0.976);
    assert_found(&s, "N103", 2, 0, 0);
    run(&s, NORMA_CHECK_PROFILE_AUTO, NORMA_FILE_OBJ);
    assert_counts("N103", NORMA_SEVERITY_WARNING, 2);
    assert_counts("N103", NORMA_SEVERITY_ERROR, 0);
    scale_normal(&s, 9, 1.026);
    run(&s, NORMA_CHECK_PROFILE_AUTO, NORMA_FILE_OBJ);
    assert_counts("N103", NORMA_SEVERITY_WARNING, 2);
    assert_counts("N103", NORMA_SEVERITY_ERROR, 1);
    surface_free(&s);
}

/* ---- shares of the area */

/* A right triangle with so much of the area of a torus of 64 by 32, 30 apart from it, which faces
 * up; its normals have this z. */
static size_t add_triangle(surface *s, double share, float z) {
    const double area = 4 * 3.141592653589793 * 3.141592653589793 * 3 * .995;
    const float side = (float)sqrt(2 * share * area), up[3] = {0, 0, z},
                corners[3][3] = {{30, 0, 0}, {30 + side, 0, 0}, {30, side, 0}};
    uint32_t face[3];
    for (int k = 0; k < 3; ++k) face[k] = surface_add_vertex(s, corners[k], up);
    return surface_add_face(s, face);
}

static void opposed_area(void **state) {
    (void)state;
    static const struct {
        double share;
        size_t errors, warnings, infos;
    } rows[] = {{.00009, 0, 0, 1}, {.00011, 0, 1, 0}, {.0095, 0, 1, 0}, {.0106, 1, 0, 0}};
    for (size_t i = 0; i < COUNT_OF(rows); ++i) {
        surface s = surface_torus(64, 32);
        (void)add_triangle(&s, rows[i].share, -1);
        assert_found(&s, "N201", rows[i].errors, rows[i].warnings, rows[i].infos);
        surface_free(&s);
    }
}

static void repeated_area(void **state) {
    (void)state;
    for (int more = 0; more < 2; ++more) {
        surface s = surface_torus(64, 32);
        const size_t face = add_triangle(&s, more ? .00011 : .00009, 1);
        uint32_t copy[3];
        memcpy(copy, s.corners + 3 * face, sizeof copy);
        (void)surface_add_face(&s, copy);
        assert_found(&s, "N305", 0, more != 0, !more);
        surface_free(&s);
    }
}

/* ---- N205 */

static surface facets_of_torus(void) {
    surface s = surface_soup(surface_torus(64, 32));
    const norma_mesh mesh = {
        .positions = {s.positions, s.vertices, 0, NORMA_FORMAT_FLOAT}, .corner_count = 3 * s.faces};
    assert_ok(norma_face_normals(&mesh, NULL, s.normals, s.faces, NULL));
    s.mesh.info.normals = NORMA_NORMALS_PER_FACET;
    return s;
}

static void lean_facet(surface *s, size_t facet, double degrees) {
    float *n = s->normals + 3 * facet;
    double a[3] = {(double)n[0], (double)n[1], (double)n[2]}, across[3];
    const double up[3] = {0, 0, 1};
    across[0] = a[1] * up[2] - a[2] * up[1];
    across[1] = a[2] * up[0] - a[0] * up[2];
    across[2] = a[0] * up[1] - a[1] * up[0];
    const double length =
        sqrt(across[0] * across[0] + across[1] * across[1] + across[2] * across[2]);
    for (int k = 0; k < 3; ++k)
        n[k] = (float)(cos(degrees / DEGREES) * a[k] + sin(degrees / DEGREES) * across[k] / length);
}

static void facets(void **state) {
    (void)state;
    static const struct {
        double degrees; /* 0: a zero normal */
        size_t of;      /* of so many facets one */
        norma_severity severity;
    } rows[] = {{0, 1, NORMA_SEVERITY_INFO}, {9.9, 1, NORMA_SEVERITY_INFO},
        {10.1, 1, NORMA_SEVERITY_WARNING}, {10.1, 500, NORMA_SEVERITY_WARNING},
        {10.1, 2000, NORMA_SEVERITY_INFO}, {4.9, 1, NORMA_SEVERITY_NONE}};
    for (size_t i = 0; i < COUNT_OF(rows); ++i) {
        surface s = facets_of_torus();
        size_t hit = 0;
        for (size_t f = rows[i].of / 2; f < s.faces; f += rows[i].of, ++hit)
            if (rows[i].degrees > 0)
                lean_facet(&s, f, rows[i].degrees);
            else
                scale_normal(&s, f, 0);
        run(&s, NORMA_CHECK_PROFILE_AUTO, NORMA_FILE_STL);
        for (int severity = NORMA_SEVERITY_INFO; severity <= NORMA_SEVERITY_ERROR; ++severity)
            assert_counts(
                "N205", (norma_severity)severity, severity == (int)rows[i].severity ? hit : 0);
        surface_free(&s);
    }
}

/* ---- N207 */

/* Two squares beside a torus, each half of which has so much of the area, whose edge bends by so
 * many degrees; all their normals are so far off the first of them, towards the other. Positions of
 * the second are doubled, with normals that are apart degrees further on. */
static surface smoothed_edge(double share, double bend, double off, double apart) {
    surface s = surface_torus(64, 32);
    const double area = 4 * 3.141592653589793 * 3.141592653589793 * 3 * .995,
                 side = sqrt(share * area / (.5 - 2 * share));
    uint32_t v[8];
    for (int k = 0; k < 8; ++k) {
        const double along = k % 4 / 2 ? side : 0, y = k % 2 ? side : 0,
                     lean = (off + (k < 4 ? 0 : apart)) / DEGREES, a = k < 4 ? 0 : bend / DEGREES,
                     x = k < 4 ? -along : along * cos(a);
        v[k] = surface_add_vertex(&s,
            (const float[3]){(float)(30 + x), (float)y, k < 4 ? 0 : (float)(-along * sin(a))},
            (const float[3]){(float)sin(lean), 0, (float)cos(lean)});
    }
    static const int faces[4][3] = {{0, 1, 3}, {0, 3, 2}, {4, 7, 5}, {4, 6, 7}};
    for (int f = 0; f < 4; ++f)
        (void)surface_add_face(&s, (uint32_t[]){v[faces[f][0]], v[faces[f][1]], v[faces[f][2]]});
    return s;
}

static void smoothed_over_edges(void **state) {
    (void)state;
    static const struct {
        double share, bend, off, apart;
        int found;
    } rows[] = {{.052, 70, 60, 0, 1}, {.048, 70, 60, 0, 0}, /* of the area */
        {.052, 61, 60, 0, 1}, {.052, 59, 60, 0, 0}, {.052, 70, 46, 0, 1}, {.052, 70, 44, 0, 0},
        {.052, 70, 60, .9, 1}, {.052, 70, 60, 1.1, 0}};
    for (size_t i = 0; i < COUNT_OF(rows); ++i) {
        surface s = smoothed_edge(rows[i].share, rows[i].bend, rows[i].off, rows[i].apart);
        const size_t faces = rows[i].found ? 1 : 0; /* the one at the edge of the first square */
        assert_found(&s, "N207", 0, faces, 0);
        s.mesh.material.not_opaque = 1;
        assert_found(&s, "N207", 0, 0, faces);
        surface_free(&s);
    }
}

/* A box with the smooth normals of a ball, all its faces turned: N201 says so, and neither are its
 * edges shaded rounder than right ones, nor its normals far from the surface. A small face at one
 * corner, 85 degrees off the normal there, is not turned. */
static void turned_faces(void **state) {
    (void)state;
    surface s = surface_box((const double[3]){0, 0, 0}, 1, 1);
    for (size_t i = 0; i < 3 * s.vertices; ++i) s.normals[i] = s.positions[i] / sqrtf(3);
    const double n = -1 / sqrt(3), u[3] = {1 / sqrt(2), -1 / sqrt(2), 0},
                 w[3] = {1 / sqrt(6), 1 / sqrt(6), -2 / sqrt(6)}, c = cos(85 / DEGREES),
                 d = sin(85 / DEGREES);
    float normal[3], one[3], other[3];
    for (int k = 0; k < 3; ++k) {
        normal[k] = (float)(c * n + d * u[k]);
        one[k] = (float)(-1 + .2 * w[k]);
        other[k] = (float)(-1 + .2 * (d * n - c * u[k]));
    }
    uint32_t corner = 0;
    while (s.positions[3 * corner] > 0 || s.positions[3 * corner + 1] > 0 ||
           s.positions[3 * corner + 2] > 0)
        ++corner;
    const uint32_t a = surface_add_vertex(&s, one, normal),
                   b = surface_add_vertex(&s, other, normal);
    (void)surface_add_face(&s, (uint32_t[]){corner, b, a});
    assert_found(&s, "N207", 0, 0, 0);
    assert_found(&s, "N202", 0, 0, 0);
    assert_found(&s, "N201", 12, 0, 0);
    surface_free(&s);
}

/* ---- N301 */

/* A pyramid over an equilateral triangle of this side, whose other faces rise by so many degrees;
 * the base is turned. */
static void add_pyramid(surface *s, double side, double degrees) {
    const double inner = side * sqrt(3) / 6;
    const float up[3] = {0, 0, 1}, corners[4][3] = {{30, 0, 0}, {(float)(30 + side), 0, 0},
                                       {(float)(30 + side / 2), (float)(3 * inner), 0},
                                       {(float)(30 + side / 2), (float)inner,
                                           (float)(inner * tan(degrees / DEGREES))}};
    static const size_t faces[4][3] = {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    uint32_t v[4];
    for (int k = 0; k < 4; ++k) v[k] = surface_add_vertex(s, corners[k], up);
    for (int f = 0; f < 4; ++f)
        (void)surface_add_face(s, (uint32_t[]){v[faces[f][0]], v[faces[f][1]], v[faces[f][2]]});
}

static void turned_area(void **state) {
    (void)state;
    for (int more = 0; more < 2; ++more) {
        surface s = surface_torus(64, 32);
        const double area = 4 * 3.141592653589793 * 3.141592653589793 * 3 * .995;
        add_pyramid(&s, sqrt((more ? .00011 : .00009) * area * 4 / sqrt(3)), 70);
        assert_found(&s, "N301", more ? 3 : 0, 0, more ? 0 : 3);
        assert_int_equal(finding_of(found, "N301", NORMA_SEVERITY_NONE)->fix, NORMA_FIX_UNSAFE);
        surface_free(&s);
    }
}

/* Two squares of a sheet that nothing decides, wound against each other; and a large one apart. */
static void undecided_area(void **state) {
    (void)state;
    for (int more = 0; more < 2; ++more) {
        surface s = surface_box(origin, 1, 0);
        s.vertices = s.faces = 0;
        const float up[3] = {0, 0, 1}, size = more ? .0152F : .0136F;
        const float corners[8][2] = {
            {0, 0}, {1, 0}, {1, 1}, {0, 1}, {9, 0}, {9 + size, 0}, {9, size}, {9 - size, 0}};
        for (int k = 0; k < 8; ++k)
            (void)surface_add_vertex(&s, (const float[3]){corners[k][0], corners[k][1], 0}, up);
        static const uint32_t faces[4][3] = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 7, 6}};
        for (int f = 0; f < 4; ++f) (void)surface_add_face(&s, faces[f]);
        assert_found(&s, "N301", 0, more != 0, !more);
        surface_free(&s);
    }
}

/* Below 60 degrees the base of a pyramid lies folded over its sides: turned or not, it is as wrong.
 */
static void folded_faces(void **state) {
    (void)state;
    for (int fold = 0; fold < 2; ++fold) {
        surface s = surface_box(origin, 1, 0);
        add_pyramid(&s, 1, fold ? 59 : 61);
        assert_found(&s, "N301", fold ? 0 : 3, 0, fold ? 3 : 0);
        assert_int_equal(finding_of(found, "N301", NORMA_SEVERITY_NONE)->fix,
            fold ? NORMA_FIX_NONE : NORMA_FIX_UNSAFE);
        surface_free(&s);
    }
}

/* ---- N202 */

/* A normal along the side of a box, whose faces have a longest edge of 2 * sqrt(2) times its half
 * size; two boxes far apart make the diagonal. */
static void far_normals_of_small_faces(void **state) {
    (void)state;
    for (int large = 0; large < 2; ++large) {
        const double half = 1, diagonal = 2 * sqrt(2) * half / (large ? .0201 : .0199),
                     apart = sqrt(diagonal * diagonal - 2 * 4 * half * half) - 2 * half;
        surface s = surface_join(
            surface_box(origin, half, 0), surface_box((double[3]){apart, 0, 0}, half, 0));
        for (size_t k = 20; k < 24; ++k) /* of the side along z: away from the box, sideways */
            if (s.positions[3 * k] < 0 && s.positions[3 * k + 1] < 0) {
                s.normals[3 * k] = 1;
                s.normals[3 * k + 2] = 0;
            }
        assert_found(&s, "N202", 0, large != 0, !large);
        s.mesh.material.not_opaque = 1;
        assert_found(&s, "N202", 0, 0, 1);
        surface_free(&s);
    }
}

/* A normal into the box at the tip of a needle, as long as the box and 0.002 wide: it shades no
 * other face, though the large faces of the box meet there too; 2 wide, it can be seen. */
static void far_normals_of_needles(void **state) {
    (void)state;
    for (int wide = 0; wide < 2; ++wide) {
        surface s = surface_box(origin, 1, 0);
        const float width = wide ? 2 : .002f, into[3] = {-.57735f, -.57735f, -.57735f},
                    up[3] = {0, 0, 1};
        const uint32_t tip = surface_add_vertex(&s, (const float[3]){1, 1, 1}, into),
                       a = surface_add_vertex(&s, (const float[3]){3, 1, 1}, up),
                       b = surface_add_vertex(&s, (const float[3]){3, 1 + width, 1}, up);
        (void)surface_add_face(&s, (uint32_t[]){tip, a, b});
        assert_found(&s, "N202", 0, wide != 0, !wide);
        surface_free(&s);
    }
}

/* ---- N501 */

/* A strip of two columns of squares that bends by so many degrees in the middle, where vertices are
 * doubled, with UVs of their own and normals 3 degrees apart, if there is a seam. */
static surface bent_strip(size_t rows, double bend, int seam) {
    surface s = surface_box(origin, 1, 0);
    s.vertices = s.faces = 0;
    const double a = bend / 2 / DEGREES;
    for (int half = 0; half < 2; ++half) {
        const uint32_t first = (uint32_t)s.vertices;
        const double sign = half ? 1 : -1;
        for (size_t y = 0; y <= rows; ++y)
            for (int outer = 0; outer < 2; ++outer) {
                const double lean = outer ? a : seam ? 1.5 / DEGREES : 0;
                const float p[3] = {(float)(sign * cos(a) * outer + (seam ? 0 : 20)), (float)y,
                    (float)(-sin(a) * outer)},
                            n[3] = {(float)(sign * sin(lean)), 0, (float)cos(lean)};
                const uint32_t v = surface_add_vertex(&s, p, n);
                s.texcoords[2 * v] = (float)(seam * half);
            }
        for (uint32_t y = 0; y < rows; ++y) {
            const uint32_t at = first + 2 * y, square[4] = {at, at + 1, at + 3, at + 2};
            for (uint32_t k = 0; k < 2; ++k) {
                const uint32_t b = square[1 + k], c = square[2 + k];
                (void)surface_add_face(&s, half ? (uint32_t[]){at, b, c} : (uint32_t[]){at, c, b});
            }
        }
    }
    return s;
}

static void few_positions(void **state) {
    (void)state;
    for (size_t rows = 5; rows <= 6; ++rows) { /* those inside: one fewer than rows */
        surface s = surface_join(bent_strip(rows, 12, 1), bent_strip(9, 12, 0));
        assert_found(&s, "N501", 0, rows > 5 ? 5 : 0, rows > 5 ? 0 : 4);
        surface_free(&s);
    }
}

static void nothing_to_compare(void **state) {
    (void)state;
    static const struct {
        size_t rows;
        double bend;
        int shown;
    } rows[] = {{4, 12.5, 0}, {5, 12.5, 1}, {5, 6.9, 0}, {5, 7.6, 1}, {5, 17.4, 1}, {5, 18.1, 0}};
    for (size_t i = 0; i < COUNT_OF(rows); ++i) {
        surface s = surface_join(bent_strip(9, 12.5, 1), bent_strip(rows[i].rows, rows[i].bend, 0));
        assert_found(&s, "N501", 0, rows[i].shown ? 8 : 0, rows[i].shown ? 0 : 8);
        surface_free(&s);
    }
}

/* ---- N306 */

/* A square of two triangles, far away, and each of them the other way round. */
static void add_sheet(surface *s, int faces) {
    const float up[3] = {0, 0, 1}, corners[4][3] = {{30, 0, 0}, {31, 0, 0}, {31, 1, 0}, {30, 1, 0}};
    uint32_t v[4];
    for (int k = 0; k < 4; ++k) v[k] = surface_add_vertex(s, corners[k], up);
    for (int f = 0; f < faces; ++f) {
        (void)surface_add_face(s, (uint32_t[]){v[0], v[1 + f], v[2 + f]});
        (void)surface_add_face(s, (uint32_t[]){v[0], v[2 + f], v[1 + f]});
    }
}

static void back_to_back(void **state) {
    (void)state;
    surface s = surface_box(origin, 1, 0);
    add_sheet(&s, 1);
    assert_found(&s, "N306", 0, 0, 1);
    assert_printed(&s, "N306", 0, 1, 0);
    s.mesh.material.not_opaque = 1;
    assert_found(&s, "N306", 0, 0, 1);
    s.mesh.material.double_sided = 1;
    assert_found(&s, "N306", 0, 1, 0);
    surface_free(&s);
    s = surface_box(origin, 1, 0);
    add_sheet(&s, 2);
    assert_found(&s, "N306", 0, 0, 2);
    assert_printed(&s, "N306", 2, 0, 0);
    surface_free(&s);
}

/* A box and the same box inside out; without one of its faces, the copy is a sheet. */
static void a_solid_twice(void **state) {
    (void)state;
    surface s = surface_join(surface_box(origin, 1, 0), surface_box(origin, 1, 1));
    memcpy(s.corners + 3 * 12, s.corners, 3 * 12 * sizeof *s.corners); /* cut along one diagonal */
    for (size_t f = 12; f < 24; ++f) surface_turn_face(&s, f);
    assert_found(&s, "N306", 0, 12, 0);
    assert_non_null(
        strstr(finding_of(found, "N306", NORMA_SEVERITY_WARNING)->message, "inside out"));
    assert_counts("N302", NORMA_SEVERITY_WARNING, 0);
    assert_printed(&s, "N306", 12, 0, 0);
    add_sheet(&s, 2);
    assert_found(&s, "N306", 0, 12, 2);
    assert_printed(&s, "N306", 14, 0, 0);
    surface_free(&s);
    s = surface_join(surface_box(origin, 1, 0), surface_box(origin, 1, 1));
    memcpy(s.corners + 3 * 12, s.corners, 3 * 12 * sizeof *s.corners);
    for (size_t f = 12; f < 24; ++f) surface_turn_face(&s, f);
    --s.faces;
    assert_found(&s, "N306", 0, 0, 11);
    surface_free(&s);
}

/* ---- N302, N303, N805 */

static void inside_out_and_double_sided(void **state) {
    (void)state;
    surface s = surface_box(origin, 1, 1);
    assert_found(&s, "N302", 0, 1, 0);
    assert_printed(&s, "N302", 1, 0, 0);
    s.mesh.material.not_opaque = 1;
    assert_found(&s, "N302", 0, 1, 0);
    s.mesh.material.double_sided = 1;
    assert_found(&s, "N302", 0, 0, 1);
    assert_printed(&s, "N302", 1, 0, 0);
    surface_free(&s);
}

/* A tetrahedron that looks inward: beside a box, and with an edge of the box. */
static void tetrahedra_at_crowded_edges(void **state) {
    (void)state;
    for (int touches = 0; touches < 2; ++touches) {
        surface s = surface_box(origin, 1, 0);
        const float x = touches ? 1 : 1.5F, up[3] = {0, 0, 1},
                    corners[4][3] = {{x, 1, -1}, {x, 1, 1}, {3, 2, 0}, {2, 3, 0}};
        static const size_t faces[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {0, 2, 3}};
        uint32_t v[4];
        for (int k = 0; k < 4; ++k) v[k] = surface_add_vertex(&s, corners[k], up);
        for (int f = 0; f < 4; ++f)
            (void)surface_add_face(
                &s, (uint32_t[]){v[faces[f][0]], v[faces[f][1]], v[faces[f][2]]});
        assert_found(&s, "N302", 0, !touches, 0);
        assert_counts("N303", NORMA_SEVERITY_INFO, touches ? 1 : 0);
        surface_free(&s);
    }
}

static void bow_ties_alone(void **state) {
    (void)state;
    surface s = surface_join(surface_box(origin, 1, 0), surface_box((double[3]){2, 2, 2}, 1, 0));
    assert_printed(&s, "N303", 0, 0, 1);
    assert_found(&s, "N303", 0, 0, 1);
    surface_free(&s);
    s = surface_join(surface_box(origin, 1, 0), surface_box((double[3]){2, 2, 0}, 1, 0));
    assert_printed(&s, "N303", 0, 1, 0); /* they share an edge */
    assert_found(&s, "N303", 0, 0, 1);
    surface_free(&s);
}

static void no_tangents(void **state) {
    (void)state;
    surface s = surface_torus(32, 16);
    assert_found(&s, "N805", 0, 0, 0);
    s.mesh.material.normal_map = 1;
    assert_found(&s, "N805", 0, 0, 1);
    surface_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lengths_of_two_digits),
        cmocka_unit_test(opposed_area),
        cmocka_unit_test(repeated_area),
        cmocka_unit_test(facets),
        cmocka_unit_test(smoothed_over_edges),
        cmocka_unit_test(turned_faces),
        cmocka_unit_test(turned_area),
        cmocka_unit_test(undecided_area),
        cmocka_unit_test(folded_faces),
        cmocka_unit_test(far_normals_of_small_faces),
        cmocka_unit_test(far_normals_of_needles),
        cmocka_unit_test(few_positions),
        cmocka_unit_test(nothing_to_compare),
        cmocka_unit_test(back_to_back),
        cmocka_unit_test(a_solid_twice),
        cmocka_unit_test(inside_out_and_double_sided),
        cmocka_unit_test(tetrahedra_at_crowded_edges),
        cmocka_unit_test(bow_ties_alone),
        cmocka_unit_test(no_tangents),
    };
    return cmocka_run_group_tests(tests, NULL, tear_down);
}
