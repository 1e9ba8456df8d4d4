/* upload.c: surfaces and lines in the memory of the graphics processor, each made and sent once
 * however many panels show it. */
#include "render/gl/device.h"
#include <stdlib.h>

static void *grown(void *list, size_t *room, size_t count, size_t size) {
    if (count < *room) return list;
    const size_t wanted = *room ? 2 * *room : 8;
    void *larger = wanted <= SIZE_MAX / size ? realloc(list, wanted * size) : NULL;
    if (larger) *room = wanted;
    return larger;
}

static void send(
    const render_gl *gl, GLenum target, GLuint buffer, const void *data, size_t bytes) {
    gl->BindBuffer(target, buffer);
    gl->BufferData(target, (GLsizeiptr)bytes, data, GL_STATIC_DRAW);
}

static void attribute(
    const render_gl *gl, GLuint location, GLint floats, size_t stride, size_t offset) {
    gl->EnableVertexAttribArray(location);
    gl->VertexAttribPointer(
        location, floats, GL_FLOAT, GL_FALSE, (GLsizei)stride, (const void *)(uintptr_t)offset);
}

static void send_vertices(const render_gl *gl, render_upload *u) {
    const render_vertices *v = &u->vertices;
    const struct {
        const float *data;
        GLint floats;
    } streams[] = {{v->positions, 3}, {v->normals, 3}, {v->colours, 4}, {v->values, 1},
        {v->texcoords, 4}, {v->tangents, 4}};
    gl->GenVertexArrays(1, &u->array);
    gl->BindVertexArray(u->array);
    gl->GenBuffers(RENDER_BUFFERS, u->buffers);
    for (GLuint i = 0; i < sizeof streams / sizeof *streams; ++i) {
        if (!streams[i].data) continue;
        send(gl, GL_ARRAY_BUFFER, u->buffers[i], streams[i].data,
            v->count * (size_t)streams[i].floats * sizeof(float));
        attribute(gl, i, streams[i].floats, 0, 0);
    }
    if (v->indices)
        send(gl, GL_ELEMENT_ARRAY_BUFFER, u->buffers[RENDER_BUFFERS - 1], v->indices,
            v->index_count * sizeof *v->indices);
    gl->BindVertexArray(0);
}

enum render_result render_upload_of(render_device *device, const render_surface *surface,
    enum render_kind kind, const render_upload **upload, render_error *error) {
    for (size_t i = 0; i < device->upload_count; ++i)
        if (device->uploads[i]->surface == surface && device->uploads[i]->kind == kind) {
            *upload = device->uploads[i];
            return RENDER_OK;
        }
    render_upload **list =
        grown(device->uploads, &device->upload_room, device->upload_count, sizeof *list);
    render_upload *made = list ? calloc(1, sizeof *made) : NULL;
    device->uploads = list ? list : device->uploads;
    if (!made) return render_fail_memory(error);
    made->surface = surface;
    made->kind = kind;
    enum render_result result = render_vertices_make(surface, kind, &made->vertices, error);
    if (result) {
        free(made);
        return result;
    }
    send_vertices(&device->gl, made);
    device->uploads[device->upload_count++] = made;
    *upload = made;
    return RENDER_OK;
}

/* ---- lines */

static void send_lines(const render_gl *gl, render_line_upload *u) {
    const size_t stride = RENDER_LINE_FLOATS * sizeof(float);
    gl->GenVertexArrays(1, &u->array);
    gl->BindVertexArray(u->array);
    gl->GenBuffers(2, u->buffers);
    if (u->set.colours) {
        send(gl, GL_ARRAY_BUFFER, u->buffers[1], u->set.colours, 4 * u->set.count * sizeof(float));
        attribute(gl, 2, 4, 0, 0);
        gl->VertexAttribDivisor(2, 1);
    }
    send(gl, GL_ARRAY_BUFFER, u->buffers[0], u->set.floats, u->set.count * stride);
    attribute(gl, 0, 3, stride, 0);
    attribute(gl, 1, 3, stride, 3 * sizeof(float));
    attribute(gl, 3, 1, stride, 6 * sizeof(float));
    gl->VertexAttribDivisor(0, 1);
    gl->VertexAttribDivisor(1, 1);
    gl->VertexAttribDivisor(3, 1);
    gl->BindVertexArray(0);
}

enum render_result render_lines_of(render_device *device, const render_surface *surface,
    unsigned kind, const render_look *look, const render_line_upload **lines, render_error *error) {
    for (size_t i = 0; i < device->line_count; ++i)
        if (device->lines[i]->surface == surface && device->lines[i]->kind == kind) {
            *lines = device->lines[i];
            return RENDER_OK;
        }
    render_line_upload **list =
        grown(device->lines, &device->line_room, device->line_count, sizeof *list);
    render_line_upload *made = list ? calloc(1, sizeof *made) : NULL;
    device->lines = list ? list : device->lines;
    if (!made) return render_fail_memory(error);
    made->surface = surface;
    made->kind = kind;
    made->box = render_box_of(&surface->mesh);
    enum render_result result =
        render_lines_make(surface, kind, look->reach, look->most_lines, &made->set, error);
    if (result) {
        free(made);
        return result;
    }
    send_lines(&device->gl, made);
    device->lines[device->line_count++] = made;
    *lines = made;
    return RENDER_OK;
}

void render_device_forget(render_device *device) {
    const render_gl *gl = &device->gl;
    for (size_t i = 0; i < device->upload_count; ++i) {
        gl->DeleteVertexArrays(1, &device->uploads[i]->array);
        gl->DeleteBuffers(RENDER_BUFFERS, device->uploads[i]->buffers);
        render_vertices_free(&device->uploads[i]->vertices);
        free(device->uploads[i]);
    }
    for (size_t i = 0; i < device->line_count; ++i) {
        gl->DeleteVertexArrays(1, &device->lines[i]->array);
        gl->DeleteBuffers(2, device->lines[i]->buffers);
        render_lines_free(&device->lines[i]->set);
        free(device->lines[i]);
    }
    render_textures_forget(device);
    free(device->uploads);
    free(device->lines);
    device->uploads = NULL;
    device->lines = NULL;
    device->upload_count = device->upload_room = device->line_count = device->line_room = 0;
}
