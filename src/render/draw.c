/* draw.c: a panel: where its surfaces lie, how its camera stands, as close as shows all of them,
 * and its picture: each surface with the matrices of its pipeline, its normal matrix beside them,
 * then the lines. */
#include "render/device.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DEGREE 0.017453292519943295

/* ---- where the surfaces lie */

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

/* The two matrices that a normal may go through, of a local to world matrix: 3x3, column-major, the
 * largest entry about 1. *mirrored: its determinant is below 0. */
static void normal_matrices(
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
        normal_matrices(stage->placed[i].to_world, right, plain, &mirrored);
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

/* The shorter side of the picture has the angle of view. */
static render_camera camera_of(const render_look *look, const render_panel *panel) {
    const double aspect = (double)look->width / (double)look->height;
    return (render_camera){.azimuth_deg = panel->azimuth_deg,
        .elevation_deg = panel->elevation_deg,
        .up = panel->up,
        .aspect = aspect,
        .tangent = tan(look->field_of_view_deg / 2 * DEGREE) / fmin(aspect, 1)};
}

enum render_result render_stage_make(render_device *device, const render_look *look,
    render_panel *panel, render_stage *stage, render_error *error) {
    const render_scene *scene = panel->scene;
    *stage = (render_stage){.look = look,
        .panel = panel,
        .camera = camera_of(look, panel),
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
        normal_matrices(placed->to_world, right, plain, &mirrored);
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
    memcpy(stage->shrink, shrink, sizeof shrink);
    for (size_t i = 0; i < stage->placed_count; ++i) {
        double unit[16];
        render_multiply(shrink, stage->placed[i].to_world, unit);
        memcpy(stage->placed[i].to_world, unit, sizeof unit);
    }
    return find_tips(stage, error);
}

/* ---- the camera */

render_frame render_stage_frame(const render_stage *stage) {
    render_frame frame = {.distance = -1}; /* without memory */
    const int orthographic = !(stage->look->field_of_view_deg > 0);
    render_cloud *clouds = calloc(stage->placed_count + 2, sizeof *clouds);
    if (clouds)
        frame = render_closest_frame(
            &stage->camera, orthographic, RENDER_MARGIN, clouds, clouds_of(stage, clouds));
    free(clouds);
    return frame;
}

void render_stage_aim(render_stage *stage, const render_frame *frame, double distance) {
    double right[3], up[3], back[3];
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

/* ---- the picture */

typedef struct painter {
    render_device *device;
    const render_gl *gl;
    const render_stage *stage;
    double world_to_view[16];
    float view[16], clip[16], eye[4], light_directions[3 * RENDER_MOST_LIGHTS],
        light_colours[3 * RENDER_MOST_LIGHTS];
} painter;

static void to_floats(const double *from, float *to, int count) {
    for (int i = 0; i < count; ++i) to[i] = (float)from[i];
}

/* Lights stand with the camera: their directions are given along its axes, which are those of view
 * space. */
static void set_lights(painter *p) {
    const render_look *look = p->stage->look;
    double axes[3][3];
    render_camera_axes(&p->stage->camera, axes[0], axes[1], axes[2]);
    for (int i = 0; i < look->light_count; ++i) {
        const double a = look->lights[i].azimuth_deg * DEGREE,
                     e = look->lights[i].elevation_deg * DEGREE;
        const double seen[3] = {sin(a) * cos(e), sin(e), cos(a) * cos(e)};
        for (int k = 0; k < 3; ++k) {
            const double world = seen[0] * axes[0][k] + seen[1] * axes[1][k] + seen[2] * axes[2][k];
            p->light_directions[3 * i + k] =
                (float)(p->stage->panel->space == RENDER_SPACE_VIEW ? seen[k] : world);
            p->light_colours[3 * i + k] = (float)look->lights[i].strength;
        }
    }
}

/* Of a perspective camera a place, of an orthographic one a direction; in lit space. */
static void set_eye(painter *p) {
    const render_camera *camera = &p->stage->camera;
    const int orthographic = camera->half_height > 0,
              in_view = p->stage->panel->space == RENDER_SPACE_VIEW;
    double right[3], up[3], back[3];
    render_camera_axes(camera, right, up, back);
    p->eye[3] = orthographic ? 0 : 1;
    for (int k = 0; k < 3; ++k) {
        const double world =
            orthographic ? back[k] : camera->centre[k] + camera->distance * back[k];
        p->eye[k] = (float)(!in_view ? world : orthographic && k == 2 ? 1 : 0);
    }
}

static void set_matrices(const painter *p, const render_uniforms *at, const double to_world[16]) {
    float world[16];
    to_floats(to_world, world, 16);
    p->gl->UniformMatrix4fv(at->local_to_world, 1, GL_FALSE, world);
    p->gl->UniformMatrix4fv(at->world_to_view, 1, GL_FALSE, p->view);
    p->gl->UniformMatrix4fv(at->view_to_clip, 1, GL_FALSE, p->clip);
}

/* From the node's local space to lit space, once for each node: the one place where wrong and right
 * part. */
static void set_normal_matrix(const painter *p, const render_uniforms *at,
    const double to_world[16], int in_view, int *mirrored) {
    float right[9], plain[9], model[16];
    normal_matrices(to_world, right, plain, mirrored);
    if (in_view) {
        double turned[16];
        to_floats(to_world, model, 16);
        norma_normal_matrix_model_view(model, p->view, NORMA_WINDING_REVERSED, right, NULL);
        render_multiply(p->world_to_view, to_world, turned);
        for (int i = 0; i < 9; ++i) plain[i] = (float)turned[4 * (i / 3) + i % 3];
    }
    p->gl->UniformMatrix3fv(at->normal_matrix, 1, GL_FALSE, p->stage->panel->plain ? plain : right);
}

static enum render_program program_of(const render_panel *panel) {
    static const enum render_program programs[] = {[RENDER_SHOW_NORMALS] = RENDER_PROGRAM_NORMALS,
        [RENDER_SHOW_WINDING] = RENDER_PROGRAM_WINDING,
        [RENDER_SHOW_ERROR] = RENDER_PROGRAM_ERROR,
        [RENDER_SHOW_MARKS] = RENDER_PROGRAM_PHONG,
        [RENDER_SHOW_MATCAP] = RENDER_PROGRAM_MATCAP,
        [RENDER_SHOW_ZEBRA] = RENDER_PROGRAM_ZEBRA,
        [RENDER_SHOW_TANGENTS] = RENDER_PROGRAM_TANGENTS};
    static const enum render_program shadings[] = {[RENDER_FLAT] = RENDER_PROGRAM_FLAT,
        [RENDER_GOURAUD] = RENDER_PROGRAM_GOURAUD,
        [RENDER_PHONG] = RENDER_PROGRAM_PHONG};
    return panel->show == RENDER_SHOW_LIT ? shadings[panel->shading] : programs[panel->show];
}

/* What a fragment does with images: surface.frag. */
static enum render_result bind_maps(const painter *p, const render_uniforms *at,
    const render_surface *surface, render_error *error) {
    const render_panel *panel = p->stage->panel;
    const int lit = panel->show == RENDER_SHOW_LIT,
              bends = lit && surface->normal_map.picture && panel->shading == RENDER_PHONG,
              cuts = lit && surface->alpha_cutoff > 0;
    enum render_result result = RENDER_OK;
    if (cuts && surface->mask.picture)
        result = render_texture_bind(p->device, &surface->mask, 0, error);
    if (!result && bends) result = render_texture_bind(p->device, &surface->normal_map, 1, error);
    p->gl->Uniform1i(at->base_map, 0);
    p->gl->Uniform1i(at->normal_map, 1);
    p->gl->Uniform4f(at->maps, cuts && surface->mask.picture ? 2 : 0,
        bends ? surface->normal_strength : 0, cuts ? surface->alpha_cutoff : 0, 0);
    return result;
}

static void set_material(
    const painter *p, const render_uniforms *at, const render_surface *surface) {
    const render_look *look = p->stage->look;
    const render_panel *panel = p->stage->panel;
    static const float white[3] = {1, 1, 1};
    /* Winding, errors and findings are looked for on either side. */
    const int either = panel->show == RENDER_SHOW_WINDING || panel->show == RENDER_SHOW_ERROR ||
                       panel->show == RENDER_SHOW_MARKS;
    const float usual[4] = {
        (float)look->ambient, (float)look->diffuse, (float)look->specular, (float)look->exponent};
    p->gl->Uniform3fv(
        at->base_colour, 1, panel->show == RENDER_SHOW_MARKS ? white : surface->base_colour);
    p->gl->Uniform1f(at->two_sided, surface->two_sided || either ? 1 : 0);
    p->gl->Uniform4fv(at->phong, 1, usual);
    (!surface->two_sided && !either ? p->gl->Enable : p->gl->Disable)(GL_CULL_FACE);
}

static enum render_result draw_surface(
    const painter *p, const render_uniforms *at, const render_placed *placed, render_error *error) {
    const render_vertices *v = &placed->upload->vertices;
    int mirrored;
    set_matrices(p, at, placed->to_world);
    set_normal_matrix(
        p, at, placed->to_world, p->stage->panel->space == RENDER_SPACE_VIEW, &mirrored);
    set_material(p, at, placed->surface);
    enum render_result result = bind_maps(p, at, placed->surface, error);
    if (result) return result;
    p->gl->FrontFace(mirrored ? GL_CW : GL_CCW);
    p->gl->VertexAttrib4f(2, 1, 1, 1, 1);
    p->gl->BindVertexArray(placed->upload->array);
    if (v->indices)
        p->gl->DrawElements(GL_TRIANGLES, (GLsizei)v->index_count, GL_UNSIGNED_INT, NULL);
    else
        p->gl->DrawArrays(GL_TRIANGLES, 0, (GLsizei)v->count);
    return RENDER_OK;
}

static enum render_result draw_surfaces(const painter *p, render_error *error) {
    const render_stage *stage = p->stage;
    const render_panel *panel = stage->panel;
    const render_compiled *program;
    enum render_result result =
        render_program_use(p->device, program_of(panel), panel->space, &program, error);
    if (result) return result;
    const render_uniforms *at = &program->at;
    p->gl->Uniform4fv(at->eye, 1, p->eye);
    p->gl->Uniform1i(at->light_count, stage->look->light_count);
    p->gl->Uniform3fv(at->light_direction, RENDER_MOST_LIGHTS, p->light_directions);
    p->gl->Uniform3fv(at->light_colour, RENDER_MOST_LIGHTS, p->light_colours);
    p->gl->Uniform1f(at->scale_top, (float)(stage->error_top_deg > 0 ? stage->error_top_deg : 1));
    for (size_t i = 0; i < stage->placed_count && !result; ++i)
        result = draw_surface(p, at, &stage->placed[i], error);
    p->gl->Disable(GL_CULL_FACE);
    return result;
}

/* ---- lines */

static uint32_t colour_of(const render_panel *panel, unsigned kind) {
    if (kind == RENDER_VERTEX_LINES && panel->line_colour) return panel->line_colour;
    return kind == RENDER_VERTEX_LINES ? RENDER_VERTEX_COLOUR
           : kind == RENDER_FACE_LINES ? RENDER_FACE_COLOUR
           : kind == RENDER_EDGE_LINES ? RENDER_EDGE_COLOUR
                                       : 0x2A2A2A;
}

/* An arrow's head tells which end is which, while there is room for it. */
static const size_t most_arrows = 600;

static const float dot_widths = 4; /* of a line */

static enum render_result draw_lines(const painter *p, unsigned kind, const render_placed *placed,
    const render_line_upload *lines, render_error *error) {
    const render_stage *stage = p->stage;
    const int hedgehog = kind != RENDER_WIREFRAME && kind != RENDER_DOTS;
    const float samples = (float)stage->look->samples,
                width = (float)stage->look->line_pixels * samples *
                        (hedgehog                 ? 1.0F
                            : kind == RENDER_DOTS ? dot_widths
                                                  : 0.7F);
    const uint32_t colour = colour_of(stage->panel, kind);
    const render_compiled *program;
    int mirrored;
    enum render_result result =
        render_program_use(p->device, hedgehog ? RENDER_PROGRAM_HEDGEHOG : RENDER_PROGRAM_LINE,
            RENDER_SPACE_WORLD, &program, error);
    if (result) return result;
    set_matrices(p, &program->at, placed->to_world);
    if (hedgehog) set_normal_matrix(p, &program->at, placed->to_world, 0, &mirrored);
    p->gl->Uniform1f(program->at.reach_scale, (float)reach_scale(placed->to_world));
    p->gl->Uniform1f(program->at.width, width);
    p->gl->Uniform1f(
        program->at.head, hedgehog && lines->set.count <= most_arrows ? 5.5F * width : 0);
    p->gl->Uniform1f(program->at.lift, 0.0015F);
    p->gl->Uniform2f(program->at.viewport, samples * (float)stage->look->width,
        samples * (float)stage->look->height);
    p->gl->VertexAttrib4f(2, render_linear(colour >> 16), render_linear(colour >> 8 & 0xFF),
        render_linear(colour & 0xFF), hedgehog ? 1 : 0.75F);
    p->gl->BindVertexArray(lines->array);
    p->gl->DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, (GLsizei)lines->set.count);
    return RENDER_OK;
}

static enum render_result draw_all_lines(const painter *p, render_error *error) {
    static const unsigned order[RENDER_LINE_KINDS] = {
        3, 1, 2, 0, 4}; /* the wireframe below the rest, dots above */
    enum render_result result = RENDER_OK;
    p->gl->Enable(GL_BLEND);
    p->gl->BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    p->gl->DepthMask(GL_FALSE);
    for (int k = 0; k < RENDER_LINE_KINDS; ++k)
        for (size_t i = 0; i < p->stage->placed_count && !result; ++i) {
            const render_placed *placed = &p->stage->placed[i];
            if (placed->lines[order[k]] && placed->lines[order[k]]->set.count)
                result = draw_lines(p, 1U << order[k], placed, placed->lines[order[k]], error);
        }
    p->gl->DepthMask(GL_TRUE);
    p->gl->Disable(GL_BLEND);
    return result;
}

enum render_result render_stage_draw(
    render_device *device, const render_stage *stage, render_error *error) {
    const render_look *look = stage->look;
    const size_t each_way = (size_t)look->samples;
    painter p = {.device = device, .gl = &device->gl, .stage = stage};
    float clear[4] = {0, 0, 0, 0};
    double to_clip[16], to_view[16];
    for (int k = 0; k < 4 && look->background[3]; ++k)
        clear[k] = (float)look->background[k] / 255.0F;
    enum render_result result =
        render_target_begin(device, look->width * each_way, look->height * each_way, clear, error);
    if (result) return result;
    render_world_to_view(&stage->camera, p.world_to_view);
    render_view_to_clip(&stage->camera, to_clip);
    to_floats(p.world_to_view, p.view, 16);
    to_floats(to_clip, p.clip, 16);
    render_multiply(p.world_to_view, stage->shrink, to_view);
    render_multiply(to_clip, to_view, stage->panel->world_to_clip);
    set_lights(&p);
    set_eye(&p);
    p.gl->Enable(GL_DEPTH_TEST);
    p.gl->DepthFunc(GL_LEQUAL);
    result = draw_surfaces(&p, error);
    if (!result) result = draw_all_lines(&p, error);
    p.gl->BindVertexArray(0);
    return result;
}
