/* target.c: the framebuffer that is drawn into, and how its samples become the pixels of a picture.
 */
#include "render/gl/device.h"
#include <stdlib.h>

void render_target_free(render_device *device) {
    const render_gl *gl = &device->gl;
    gl->DeleteFramebuffers(1, &device->framebuffer);
    gl->DeleteRenderbuffers(1, &device->colour);
    gl->DeleteRenderbuffers(1, &device->depth);
    device->framebuffer = device->colour = device->depth = 0;
    device->target_width = device->target_height = 0;
}

static enum render_result make_target(
    render_device *device, size_t width, size_t height, render_error *error) {
    const render_gl *gl = &device->gl;
    GLint most = 0;
    render_target_free(device);
    gl->GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most);
    if (width > (size_t)most || height > (size_t)most)
        return render_fail(error, RENDER_ERROR_ARGUMENT,
            "%s draws at most %d samples in each direction, but %zux%zu are needed; expected a "
            "smaller --size or fewer --samples",
            device->name, most, width, height);
    gl->GenFramebuffers(1, &device->framebuffer);
    gl->GenRenderbuffers(1, &device->colour);
    gl->GenRenderbuffers(1, &device->depth);
    gl->BindFramebuffer(GL_FRAMEBUFFER, device->framebuffer);
    gl->BindRenderbuffer(GL_RENDERBUFFER, device->colour);
    gl->RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, (GLsizei)width, (GLsizei)height);
    gl->FramebufferRenderbuffer(
        GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, device->colour);
    gl->BindRenderbuffer(GL_RENDERBUFFER, device->depth);
    gl->RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, (GLsizei)width, (GLsizei)height);
    gl->FramebufferRenderbuffer(
        GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, device->depth);
    if (gl->CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        return render_fail(error, RENDER_ERROR_DEVICE,
            "%s has no memory for a picture of %zux%zu samples", device->name, width, height);
    device->target_width = width;
    device->target_height = height;
    return RENDER_OK;
}

enum render_result render_target_begin(
    render_device *device, size_t width, size_t height, const float clear[4], render_error *error) {
    const render_gl *gl = &device->gl;
    if (width != device->target_width || height != device->target_height) {
        enum render_result result = make_target(device, width, height, error);
        if (result) return result;
    }
    gl->BindFramebuffer(GL_FRAMEBUFFER, device->framebuffer);
    gl->Viewport(0, 0, (GLsizei)width, (GLsizei)height);
    gl->ClearColor(clear[0], clear[1], clear[2], clear[3]);
    gl->DepthMask(GL_TRUE);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    return RENDER_OK;
}

/* One pixel of samples * samples. Samples that nothing covers have no say in its colour; a partly
 * covered one's colour is multiplied by its alpha in the framebuffer. */
static void resolve(const render_srgb *srgb, const uint8_t *samples, size_t stride, size_t each_way,
    uint8_t pixel[4]) {
    uint64_t light[3] = {0}, alpha = 0;
    for (size_t y = 0; y < each_way; ++y)
        for (size_t x = 0; x < each_way; ++x) {
            const uint8_t *at = samples + y * stride + 4 * x;
            const unsigned a = at[3];
            alpha += a;
            for (int k = 0; k < 3 && a > 0; ++k) {
                const unsigned level = a == 255 ? at[k] : (at[k] * 255U + a / 2) / a;
                light[k] += (uint64_t)srgb->linear[level < 255 ? level : 255] * a;
            }
        }
    for (int k = 0; k < 3; ++k)
        pixel[k] = alpha ? srgb->encoded[(light[k] + alpha / 2) / alpha] : 0;
    const uint64_t count = each_way * each_way;
    pixel[3] = (uint8_t)((alpha + count / 2) / count);
}

enum render_result render_target_read(render_device *device, int samples, render_picture *picture,
    const render_area *area, render_error *error) {
    const render_gl *gl = &device->gl;
    const size_t x = area->x, y = area->y, width = area->width, height = area->height;
    const size_t each_way = (size_t)samples, stride = 4 * width * each_way;
    uint8_t *all = malloc(stride * height * each_way);
    if (!all) return render_fail_memory(error);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl->ReadPixels(0, 0, (GLsizei)(width * each_way), (GLsizei)(height * each_way), GL_RGBA,
        GL_UNSIGNED_BYTE, all);
    for (size_t row = 0; row < height; ++row) /* the framebuffer's rows run upwards */
        for (size_t column = 0; column < width; ++column)
            resolve(&device->srgb,
                all + (height - 1 - row) * each_way * stride + 4 * column * each_way, stride,
                each_way, picture->pixels + 4 * ((y + row) * picture->width + x + column));
    free(all);
    const GLenum trouble = gl->GetError();
    if (trouble != GL_NO_ERROR)
        return render_fail(error, RENDER_ERROR_DEVICE, "%s: OpenGL error 0x%x%s", device->name,
            trouble, trouble == GL_OUT_OF_MEMORY ? " (out of memory)" : "");
    return RENDER_OK;
}
