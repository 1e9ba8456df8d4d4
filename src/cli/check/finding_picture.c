/* finding_picture.c: the place of a finding as a small drawing. */
#include "cli/check/check.h"
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
    norma_document *document;
    size_t mesh; /* its number there, and its data */
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

/* ---- The whole model, small in a corner of the picture: all meshes as the nodes place them, seen
 * as the close-up is, faces filled into a grid of points, the nearest wins (a depth buffer), and
 * rows of equal shade drawn as lines. A point marks the place. Of very many faces some stand for
 * all, and so do some visits, each of one mesh at one place: a small file asks for millions. What
 * is then still too much work, corners and points filled, is left out. */

enum {
    WHOLE = 64,
    WHOLE_MARGIN = 4,
    SHADES = 4,
    MOST_OF_WHOLE = 400000,
    MOST_VISITS = 50000,
    MOST_WORK = 1 << 23
};

typedef enum whole_pass { WHOLE_COUNT, WHOLE_FRAME, WHOLE_FILL } whole_pass;

typedef struct whole_model {
    double right[3], up[3], view[3], place[3]; /* in the world */
    double box[4], least[2], scale;            /* of the view, to points */
    size_t faces, stride;
    uint64_t visit_stride;
    size_t work_left; /* of this pass */
    double depth[WHOLE][WHOLE];
    unsigned char shade[WHOLE][WHOLE]; /* 0: nothing there */
} whole_model;

static void apply_matrix(const double m[16], const double v[3], double w, double out[3]) {
    for (int row = 0; row < 3; ++row)
        out[row] = m[row] * v[0] + m[4 + row] * v[1] + m[8 + row] * v[2] + m[12 + row] * w;
}

static int see_corner(const whole_model *whole, const norma_mesh *mesh, const double world[16],
    size_t corner, double seen[3]) {
    double at[3], placed[3];
    if (!read_vector(&mesh->positions, norma_mesh_corner(mesh, corner), at)) return 0;
    apply_matrix(world, at, 1, placed);
    seen[0] = (dot(placed, whole->right) - whole->least[0]) * whole->scale;
    seen[1] = (-dot(placed, whole->up) - whole->least[1]) * whole->scale;
    seen[2] = dot(placed, whole->view) * whole->scale;
    return isfinite(seen[0]) && isfinite(seen[1]) && isfinite(seen[2]);
}

/* 0: there is too much of it. */
static int takes_work(whole_model *whole, size_t work) {
    if (work > whole->work_left) return 0;
    whole->work_left -= work;
    return 1;
}

static int on_grid(double at) { return !(at > 0) ? 0 : at > WHOLE - 1 ? WHOLE - 1 : (int)at; }

/* The points of a triangle whose middle it covers, and those of its corners. */
static void fill_triangle(whole_model *whole, double p[3][3]) {
    int from[2] = {WHOLE, WHOLE}, to[2] = {0, 0};
    double a[3], b[3], normal[3];
    for (int i = 0; i < 3; ++i) {
        a[i] = p[1][i] - p[0][i], b[i] = p[2][i] - p[0][i];
        for (int axis = 0; axis < 2; ++axis) {
            const int at = on_grid(p[i][axis]);
            from[axis] = at < from[axis] ? at : from[axis];
            to[axis] = at > to[axis] ? at : to[axis];
        }
    }
    cross(a, b, normal);
    const double area = normal[2];
    if (!normalise(normal) ||
        !takes_work(whole, (size_t)(to[0] - from[0] + 1) * (size_t)(to[1] - from[1] + 1)))
        return;
    const unsigned char shade = (unsigned char)(1 + (int)((SHADES - 0.01) * fabs(normal[2])));
    const int is_small = to[0] - from[0] < 2 && to[1] - from[1] < 2;
    for (int y = from[1]; y <= to[1]; ++y)
        for (int x = from[0]; x <= to[0]; ++x) {
            double depth = 0;
            int is_in = 1;
            for (int i = 0; i < 3; ++i) {
                const double *one = p[(i + 1) % 3], *other = p[(i + 2) % 3];
                const double part = ((other[0] - one[0]) * (y + 0.5 - one[1]) -
                                        (other[1] - one[1]) * (x + 0.5 - one[0])) /
                                    area;
                is_in &= part >= 0;
                depth += part * p[i][2];
            }
            if (!is_in && is_small) depth = p[0][2];
            if ((!is_in && !is_small) || !(depth > whole->depth[y][x])) continue;
            whole->depth[y][x] = depth;
            whole->shade[y][x] = shade;
        }
}

static void visit_face(whole_model *whole, whole_pass pass, const norma_mesh *mesh,
    const double world[16], size_t face) {
    const size_t begin = face_begin(mesh, face), end = face_end(mesh, face);
    double p[3][3];
    int seen[3] = {0};
    if (!takes_work(whole, end - begin)) return;
    for (size_t corner = begin; corner < end; ++corner) {
        const int to = corner == begin ? 0 : 2; /* a fan from the first corner */
        memcpy(p[1], p[2], sizeof p[1]);
        seen[1] = seen[2];
        seen[to] = see_corner(whole, mesh, world, corner, p[to]);
        if (pass == WHOLE_FILL && corner > begin + 1 && seen[0] && seen[1] && seen[2])
            fill_triangle(whole, p);
        for (int axis = 0; axis < 2 && pass == WHOLE_FRAME && seen[to]; ++axis) {
            whole->box[axis] = fmin(whole->box[axis], p[to][axis]);
            whole->box[2 + axis] = fmax(whole->box[2 + axis], p[to][axis]);
        }
    }
}

/* One mesh at one place. */
static void visit_placed(const picture *drawn, whole_model *whole, whole_pass pass, size_t mesh,
    const double world[16]) {
    norma_mesh_info info;
    norma_mesh_data data;
    if (norma_document_mesh_info(drawn->document, mesh, &info) || info.not_read) return;
    if (pass == WHOLE_COUNT) whole->faces += info.faces;
    if (pass == WHOLE_COUNT || norma_document_mesh_data(drawn->document, mesh, &data, NULL)) return;
    for (size_t face = 0; face < count_faces(&data.mesh); face += whole->stride)
        visit_face(whole, pass, &data.mesh, world, face);
}

/* A skin places its mesh itself: in the pose that it was bound in. */
static int place_node(
    const picture *drawn, const norma_node_info *node, size_t index, size_t k, double world[16]) {
    static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    memcpy(world, identity, sizeof identity);
    return node->skin != SIZE_MAX ||
           !norma_document_instance_world(drawn->document, index, k, world, NULL);
}

/* world: where the mesh of the picture is drawn first. 0: nowhere, or there are no nodes. */
static int find_first_node(const picture *drawn, double world[16]) {
    norma_mesh_info info;
    norma_node_info node;
    if (norma_document_mesh_info(drawn->document, drawn->mesh, &info)) return 0;
    for (size_t i = 0; i < norma_document_node_count(drawn->document); ++i)
        if (!norma_document_node_info(drawn->document, i, &node) && node.mesh == info.mesh)
            return place_node(drawn, &node, i, 0, world);
    return 0;
}

static uint64_t choose_visit_stride(norma_document *document) {
    norma_node_info node;
    uint64_t visits = 0;
    for (size_t i = 0; i < norma_document_node_count(document); ++i)
        if (!norma_document_node_info(document, i, &node))
            visits += (uint64_t)node.instances * node.mesh_count;
    return 1 + visits / MOST_VISITS;
}

/* All that the nodes draw; the mesh alone where none draws it. first: where the mesh of the picture
 * is drawn, which is never left out. */
static void visit_model(const picture *drawn, whole_model *whole, whole_pass pass, int by_nodes,
    const double first[16]) {
    norma_node_info node;
    double world[16];
    uint64_t at = 0; /* the next visit, from the first of the node */
    whole->work_left = MOST_WORK;
    if (!by_nodes || whole->visit_stride > 1) visit_placed(drawn, whole, pass, drawn->mesh, first);
    for (size_t i = 0; by_nodes && i < norma_document_node_count(drawn->document); ++i) {
        if (norma_document_node_info(drawn->document, i, &node)) continue;
        const size_t count = node.mesh_count;
        const uint64_t visits = (uint64_t)node.instances * count;
        for (; at < visits; at += whole->visit_stride) /* each primitive has its turn */
            if (place_node(drawn, &node, i, (size_t)(at / count), world))
                visit_placed(drawn, whole, pass,
                    node.first_mesh + (size_t)(at / whole->visit_stride % count), world);
        at -= visits;
    }
}

static int frame_whole(whole_model *whole) {
    const double *box = whole->box;
    const double width = box[2] - box[0], height = box[3] - box[1], size = fmax(width, height);
    whole->scale = (WHOLE - 2) / size;
    whole->least[0] = box[0] - (size - width) / 2 - size / (WHOLE - 2);
    whole->least[1] = box[1] - (size - height) / 2 - size / (WHOLE - 2);
    return size > 0 && isfinite(size) && isfinite(whole->scale);
}

static void draw_rows(FILE *out, const whole_model *whole, int shade) {
    fprintf(out, "<path style='stroke:#%x%x%x;stroke-width:1.1' d='", 4 + 2 * shade, 4 + 2 * shade,
        4 + 2 * shade);
    for (int y = 0; y < WHOLE; ++y)
        for (int x = 0, to; x < WHOLE; x = to + 1) {
            for (to = x; to < WHOLE && whole->shade[y][to] == shade; ++to)
                ;
            if (to > x) fprintf(out, "M%d %d.5h%d", x, y, to - x);
        }
    fputs("'/>\n", out);
}

static void draw_filled(FILE *out, const whole_model *whole) {
    const double x = (dot(whole->place, whole->right) - whole->least[0]) * whole->scale,
                 y = (-dot(whole->place, whole->up) - whole->least[1]) * whole->scale;
    fprintf(out,
        "<g transform='translate(%d %d)'><title>The whole model</title><rect width='%d' "
        "height='%d' rx='4' fill='#fff' fill-opacity='.9'/>\n",
        SIDE - WHOLE - WHOLE_MARGIN, WHOLE_MARGIN, WHOLE, WHOLE);
    for (int shade = 1; shade <= SHADES; ++shade) draw_rows(out, whole, shade);
    fprintf(out, "<circle cx='%d' cy='%d' r='3.5' fill='#e00' stroke='#fff'/></g>\n", on_grid(x),
        on_grid(y));
}

/* Nothing where the close-up shows all of it, or without memory. */
static void draw_whole(FILE *out, const picture *drawn) {
    double world[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    whole_model *whole = calloc(1, sizeof *whole);
    if (!whole) return;
    const int by_nodes = find_first_node(drawn, world);
    apply_matrix(world, drawn->place, 1, whole->place);
    apply_matrix(world, drawn->view, 0, whole->view);
    apply_matrix(world, drawn->up, 0, whole->up);
    cross(whole->up, whole->view, whole->right);
    const int is_seen = normalise(whole->view) && normalise(whole->right);
    cross(whole->view, whole->right, whole->up);
    whole->visit_stride = choose_visit_stride(drawn->document);
    visit_model(drawn, whole, WHOLE_COUNT, by_nodes, world);
    whole->stride = 1 + whole->faces / MOST_OF_WHOLE;
    whole->scale = 1;
    if (is_seen && whole->faces > drawn->count) {
        for (int axis = 0; axis < 2; ++axis)
            whole->box[axis] = INFINITY, whole->box[2 + axis] = -INFINITY;
        visit_model(drawn, whole, WHOLE_FRAME, by_nodes, world);
        for (int i = 0; i < WHOLE * WHOLE; ++i) whole->depth[i / WHOLE][i % WHOLE] = -INFINITY;
        if (frame_whole(whole)) {
            visit_model(drawn, whole, WHOLE_FILL, by_nodes, world);
            draw_filled(out, whole);
        }
    }
    free(whole);
}

/* The mesh that a finding stands at, in its model of a composite. 0: none, or it was not read. */
static int find_mesh(picture *drawn, norma_mesh_data *data) {
    norma_mesh_info info;
    size_t tile;
    const char *where = check_where_in_tile(drawn->finding->where, &tile);
    drawn->document = norma_document_tile(drawn->document, tile);
    for (drawn->mesh = 0; drawn->mesh < norma_document_mesh_count(drawn->document); ++drawn->mesh)
        if (!norma_document_mesh_info(drawn->document, drawn->mesh, &info) &&
            strcmp(info.where, where) == 0)
            return !info.not_read &&
                   !norma_document_mesh_data(drawn->document, drawn->mesh, data, NULL);
    return 0;
}

void check_draw_finding(FILE *out, norma_document *document, const norma_finding *finding) {
    norma_mesh_data data;
    picture drawn = {.document = document, .data = &data, .finding = finding};
    if (document && find_place(&drawn) && find_mesh(&drawn, &data) && find_nearest_faces(&drawn)) {
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
            draw_whole(out, &drawn);
            fputs("</svg>\n", out);
        }
    }
    free(drawn.faces);
}
