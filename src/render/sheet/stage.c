/* stage.c: where the surfaces of a panel lie, and how its camera stands: as close as shows all of
 * them. */
#include "render/sheet/draw.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DEGREE 0.017453292519943295

static enum render_kind vertices_for(const render_panel *panel, const render_surface *surface) {
    const int flat = panel->show == RENDER_SHOW_LIT && panel->shading == RENDER_FLAT,
              mapped = surface->mask.picture || surface->normal_map.picture;
    if (panel->show == RENDER_SHOW_TANGENTS) return RENDER_MAPPED;
    if (panel->show == RENDER_SHOW_LIT && mapped) return flat ? RENDER_MAPPED_FLAT : RENDER_MAPPED;
    if (panel->show == RENDER_SHOW_ERROR) return RENDER_ERRORS;
    if (panel->show == RENDER_SHOW_MARKS) return RENDER_MARKED;
    return flat ? RENDER_FACETED : RENDER_SMOOTH;
}

/* From the box that vertices are kept in to the file's world. */
static void box_to_world(
    const render_box *box, const double world[16], const double given[16], double matrix[16]) {
    const double unbox[16] = {1 / box->scale, 0, 0, 0, 0, 1 / box->scale, 0, 0, 0, 0,
        1 / box->scale, 0, box->origin[0], box->origin[1], box->origin[2], 1};
    double local_to_world[16];
    render_local_to_world(world, given, local_to_world);
    render_multiply(local_to_world, unbox, matrix);
}

static enum render_result place_surface(render_device *device, render_stage *stage,
    const render_draw *draw, render_placed *placed, render_error *error) {
    render_panel *panel = stage->panel;
    placed->surface = &panel->scene->surfaces[draw->surface];
    enum render_result result = render_upload_of(
        device, placed->surface, vertices_for(panel, placed->surface), &placed->upload, error);
    for (unsigned k = 0; k < RENDER_LINE_KINDS && !result; ++k)
        if (panel->lines & 1U << k) {
            result = render_lines_of(
                device, placed->surface, 1U << k, stage->look, &placed->lines[k], error);
            panel->lines_left_out += result ? 0 : placed->lines[k]->set.left_out;
        }
    if (result) return result;
    box_to_world(&placed->upload->vertices.box, draw->world, panel->matrix, placed->to_world);
    for (int i = 0; i < 16; ++i)
        if (!isfinite(placed->to_world[i]))
            return render_fail(error, RENDER_ERROR_ARGUMENT, "a transform that is not finite");
    const size_t vertices = placed->upload->vertices.indices ? placed->upload->vertices.index_count
                                                             : placed->upload->vertices.count;
    panel->triangles += vertices / 3;
    panel->worst_error_rad = fmax(
        panel->worst_error_rad, placed->upload->vertices.worst_error_rad); /* a NaN gives way */
    panel->uncompared |= placed->upload->vertices.uncompared;
    panel->most_errors_rad = fmax(panel->most_errors_rad, placed->upload->vertices.most_errors_rad);
    return RENDER_OK;
}

/* ---- the error of plain M, over the normals that are drawn */

void render_normal_matrices(
    const double to_world[16], float right[9], float plain[9], int *mirrored) {
    double matrix[9] = {0}, largest[2] = {0, 0};
    norma_matrix_info info = {0};
    norma_normal_matrix_double(to_world, NORMA_WINDING_REVERSED, matrix, &info);
    for (int i = 0; i < 9; ++i) {
        largest[0] = fmax(largest[0], fabs(matrix[i]));
        largest[1] = fmax(largest[1], fabs(to_world[4 * (i / 3) + i % 3]));
    }
    for (int i = 0; i < 9; ++i) {
        right[i] = (float)(largest[0] > 0 ? matrix[i] / largest[0] : 0);
        plain[i] = (float)(largest[1] > 0 ? to_world[4 * (i / 3) + i % 3] / largest[1] : 0);
    }
    *mirrored = info.mirrored;
}

static void multiply_normal(const float m[9], const float n[3], double out[3]) {
    for (int row = 0; row < 3; ++row)
        out[row] = (double)m[row] * (double)n[0] + (double)m[3 + row] * (double)n[1] +
                   (double)m[6 + row] * (double)n[2];
}

/* The angle between M n and the right normal; below 0: one of them is zero. */
static double error_of(const float right[9], const float plain[9], const float n[3]) {
    double a[3], b[3];
    multiply_normal(right, n, a);
    multiply_normal(plain, n, b);
    const double cross[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0]},
                 dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const double across = cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2];
    if (!(dot != 0 || across > 0)) return -1;
    return atan2(sqrt(across), dot);
}

static void measure_worst_plain(render_stage *stage) {
    render_panel *panel = stage->panel;
    panel->worst_plain_rad = 0;
    for (size_t i = 0; i < stage->placed_count; ++i) {
        const render_vertices *v = &stage->placed[i].upload->vertices;
        float right[9], plain[9];
        int mirrored;
        render_normal_matrices(stage->placed[i].to_world, right, plain, &mirrored);
        for (size_t k = 0; k < v->count; ++k)
            panel->worst_plain_rad =
                fmax(panel->worst_plain_rad, error_of(right, plain, v->normals + 3 * k));
    }
}

/* ---- the world */

/* So many points at most are looked at for a camera; of larger scenes with many draws, the corners
 * of each draw's box. */
static const size_t most_points = 50000000;
static const float box_corners[24] = {
    -1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1, -1, -1, 1, 1, -1, 1, -1, 1, 1, 1, 1, 1};

static size_t clouds_of(const render_stage *stage, render_cloud *clouds) {
    size_t points = 0, count = 0;
    for (size_t i = 0; i < stage->placed_count; ++i)
        points += stage->placed[i].upload->vertices.point_count;
    for (size_t i = 0; i < stage->placed_count; ++i) {
        const render_vertices *v = &stage->placed[i].upload->vertices;
        clouds[count] = points > most_points
                            ? (render_cloud){.points = box_corners, .count = 8}
                            : (render_cloud){.points = v->points, .count = v->point_count};
        memcpy(clouds[count++].matrix, stage->placed[i].to_world, sizeof clouds->matrix);
    }
    if (stage->tips)
        clouds[count++] = (render_cloud){.points = stage->tips,
            .count = stage->tip_count,
            .matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    return count;
}

enum render_result render_stage_make(render_device *device, const render_look *look,
    render_panel *panel, render_stage *stage, render_error *error) {
    const render_scene *scene = panel->scene;
    *stage = (render_stage){.look = look,
        .panel = panel,
        .placed = calloc(scene->draw_count + 1, sizeof *stage->placed),
        .placed_count = scene->draw_count};
    render_cloud *clouds = calloc(scene->draw_count + 2, sizeof *clouds);
    enum render_result result = stage->placed && clouds ? RENDER_OK : render_fail_memory(error);
    panel->worst_error_rad = NAN;
    panel->most_errors_rad = 0;
    panel->uncompared = 0;
    panel->triangles = panel->lines_left_out = 0;
    for (size_t i = 0; i < scene->draw_count && !result; ++i)
        result = place_surface(device, stage, &scene->draws[i], &stage->placed[i], error);
    if (!result) {
        stage->ball = render_smallest_ball(clouds, clouds_of(stage, clouds));
        if (panel->measured) measure_worst_plain(stage);
    }
    free(clouds);
    if (result) render_stage_free(stage);
    return result;
}

void render_stage_free(render_stage *stage) {
    free(stage->placed);
    free(stage->tips);
    *stage = (render_stage){0};
}

/* ---- lines that reach out of the surface */

static double reach_scale(const double m[16]) {
    double sum = 0;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) sum += m[4 * column + row] * m[4 * column + row];
    return sqrt(sum / 3);
}

static size_t hedgehog_lines(const render_placed *placed) {
    size_t count = 0;
    for (unsigned k = 0; k < RENDER_LINE_KINDS; ++k)
        count += placed->lines[k] && 1U << k < RENDER_WIREFRAME ? placed->lines[k]->set.count : 0;
    return count;
}

static void add_tip(
    render_stage *stage, const render_placed *placed, const float matrix[9], const float *line) {
    const double from[3] = {(double)line[0], (double)line[1], (double)line[2]},
                 scale = reach_scale(placed->to_world);
    double start[3], direction[3], length;
    render_point(placed->to_world, from, start);
    multiply_normal(matrix, line + 3, direction);
    length = sqrt(
        direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
    for (int k = 0; k < 3; ++k)
        stage->tips[3 * stage->tip_count + (size_t)k] =
            (float)(start[k] + (length > 0 ? direction[k] / length * (double)line[6] * scale : 0));
    ++stage->tip_count;
    stage->grown = fmax(stage->grown, (double)line[6] * scale);
}

static enum render_result find_tips(render_stage *stage, render_error *error) {
    size_t count = 0;
    for (size_t i = 0; i < stage->placed_count; ++i) count += hedgehog_lines(&stage->placed[i]);
    free(stage->tips);
    stage->tips = NULL;
    stage->tip_count = 0;
    if (count == 0) return RENDER_OK;
    stage->tips = malloc(3 * count * sizeof *stage->tips);
    if (!stage->tips) return render_fail_memory(error);
    for (size_t i = 0; i < stage->placed_count; ++i) {
        const render_placed *placed = &stage->placed[i];
        float right[9], plain[9];
        int mirrored;
        render_normal_matrices(placed->to_world, right, plain, &mirrored);
        for (unsigned k = 0; k < RENDER_LINE_KINDS; ++k)
            for (size_t line = 0; placed->lines[k] && 1U << k < RENDER_WIREFRAME &&
                                  line < placed->lines[k]->set.count;
                 ++line)
                add_tip(stage, placed, stage->panel->plain ? plain : right,
                    placed->lines[k]->set.floats + RENDER_LINE_FLOATS * line);
    }
    return RENDER_OK;
}

enum render_result render_stage_scale(render_stage *stage, double radius, render_error *error) {
    const double s = radius > 0 && isfinite(1 / radius) ? 1 / radius : 1, *c = stage->ball.centre;
    const double shrink[16] = {
        s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0, -s * c[0], -s * c[1], -s * c[2], 1};
    stage->shrunk = s;
    for (size_t i = 0; i < stage->placed_count; ++i) {
        double unit[16];
        render_multiply(shrink, stage->placed[i].to_world, unit);
        memcpy(stage->placed[i].to_world, unit, sizeof unit);
    }
    return find_tips(stage, error);
}

/* ---- the camera */

/* The shorter side of the picture has the angle of view. */
static void set_lens(render_stage *stage) {
    const render_look *look = stage->look;
    render_camera *camera = &stage->camera;
    *camera = (render_camera){.azimuth_deg = stage->panel->azimuth_deg,
        .elevation_deg = stage->panel->elevation_deg,
        .up = stage->panel->up};
    camera->aspect = (double)look->width / (double)look->height;
    camera->tangent = tan(look->field_of_view_deg / 2 * DEGREE) / fmin(camera->aspect, 1);
}

render_frame render_stage_frame(const render_stage *stage) {
    render_stage lens = *stage;
    render_frame frame = {.distance = 0};
    const int orthographic = !(stage->look->field_of_view_deg > 0);
    set_lens(&lens);
    render_cloud *clouds = calloc(stage->placed_count + 2, sizeof *clouds);
    frame.distance = -1; /* without memory */
    if (clouds)
        frame = render_closest_frame(
            &lens.camera, orthographic, RENDER_MARGIN, clouds, clouds_of(stage, clouds));
    free(clouds);
    return frame;
}

void render_stage_aim(render_stage *stage, const render_frame *frame, double distance) {
    double right[3], up[3], back[3];
    set_lens(stage);
    render_camera *camera = &stage->camera;
    render_camera_axes(camera, right, up, back);
    for (int k = 0; k < 3; ++k)
        camera->centre[k] = frame->middle[0] * right[k] + frame->middle[1] * up[k];
    camera->depth = (1 + stage->grown) * 1.02;
    if (stage->look->field_of_view_deg > 0) {
        camera->distance = fmax(distance, camera->depth * 1.05);
    } else {
        camera->half_height = distance > 0 ? distance : 1;
        camera->distance = 4 * camera->depth;
    }
}
