/* draw.c: A panel's picture: each surface with the matrices of its pipeline, its normal matrix
 * beside them, then the lines. */
#include "render/sheet/draw.h"
#include <math.h>
#include <string.h>

#define DEGREE 0.017453292519943295

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
    render_normal_matrices(to_world, right, plain, mirrored);
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
    switch (panel->show) {
    case RENDER_SHOW_NORMALS:
        return RENDER_PROGRAM_NORMALS;
    case RENDER_SHOW_WINDING:
        return RENDER_PROGRAM_WINDING;
    case RENDER_SHOW_ERROR:
        return RENDER_PROGRAM_ERROR;
    case RENDER_SHOW_MATCAP:
        return RENDER_PROGRAM_MATCAP;
    case RENDER_SHOW_ZEBRA:
        return RENDER_PROGRAM_ZEBRA;
    case RENDER_SHOW_TANGENTS:
        return RENDER_PROGRAM_TANGENTS;
    case RENDER_SHOW_MARKS:
        return RENDER_PROGRAM_PHONG;
    case RENDER_SHOW_LIT:
        break;
    }
    return panel->shading == RENDER_FLAT      ? RENDER_PROGRAM_FLAT
           : panel->shading == RENDER_GOURAUD ? RENDER_PROGRAM_GOURAUD
                                              : RENDER_PROGRAM_PHONG;
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
    switch (kind) {
    case RENDER_VERTEX_LINES:
        return panel->line_colour ? panel->line_colour : RENDER_VERTEX_COLOUR;
    case RENDER_FACE_LINES:
        return RENDER_FACE_COLOUR;
    case RENDER_EDGE_LINES:
        return RENDER_EDGE_COLOUR;
    default:
        return 0x2A2A2A;
    }
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
    double sum = 0;
    int mirrored;
    enum render_result result =
        render_program_use(p->device, hedgehog ? RENDER_PROGRAM_HEDGEHOG : RENDER_PROGRAM_LINE,
            RENDER_SPACE_WORLD, &program, error);
    if (result) return result;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            sum += placed->to_world[4 * column + row] * placed->to_world[4 * column + row];
    set_matrices(p, &program->at, placed->to_world);
    if (hedgehog) set_normal_matrix(p, &program->at, placed->to_world, 0, &mirrored);
    p->gl->Uniform1f(program->at.reach_scale, (float)sqrt(sum / 3));
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

static void tell_camera(const render_stage *stage, const painter *p, const double to_clip[16]) {
    const double s = stage->shrunk, *c = stage->ball.centre;
    const double shrink[16] = {
        s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0, -s * c[0], -s * c[1], -s * c[2], 1};
    double to_view[16];
    render_multiply(p->world_to_view, shrink, to_view);
    render_multiply(to_clip, to_view, stage->panel->world_to_clip);
}

enum render_result render_stage_draw(
    render_device *device, const render_stage *stage, render_error *error) {
    const render_look *look = stage->look;
    const size_t each_way = (size_t)look->samples;
    painter p = {.device = device, .gl = &device->gl, .stage = stage};
    float clear[4] = {0, 0, 0, 0};
    double to_clip[16];
    for (int k = 0; k < 4 && look->background[3]; ++k)
        clear[k] = (float)look->background[k] / 255.0F;
    enum render_result result =
        render_target_begin(device, look->width * each_way, look->height * each_way, clear, error);
    if (result) return result;
    render_world_to_view(&stage->camera, p.world_to_view);
    render_view_to_clip(&stage->camera, to_clip);
    to_floats(p.world_to_view, p.view, 16);
    to_floats(to_clip, p.clip, 16);
    tell_camera(stage, &p, to_clip);
    set_lights(&p);
    set_eye(&p);
    p.gl->Enable(GL_DEPTH_TEST);
    p.gl->DepthFunc(GL_LEQUAL);
    result = draw_surfaces(&p, error);
    if (!result) result = draw_all_lines(&p, error);
    p.gl->BindVertexArray(0);
    return result;
}
