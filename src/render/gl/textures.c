/* textures.c: images in the memory of the graphics processor, each sent once. */
#include "render/gl/device.h"
#include <stdlib.h>

static int has_levels(int min_filter) { return min_filter >= 0x2700 && min_filter <= 0x2703; }

static void set_sampler(const render_gl *gl, const render_texture *texture) {
    const GLint usual = GL_LINEAR_MIPMAP_LINEAR;
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER,
        texture->min_filter == GL_NEAREST || texture->min_filter == GL_LINEAR ||
                has_levels(texture->min_filter)
            ? texture->min_filter
            : usual);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER,
        texture->mag_filter == GL_NEAREST ? GL_NEAREST : GL_LINEAR);
    const int wraps[2] = {texture->wrap_s, texture->wrap_t};
    for (int k = 0; k < 2; ++k)
        gl->TexParameteri(GL_TEXTURE_2D, k ? GL_TEXTURE_WRAP_T : GL_TEXTURE_WRAP_S,
            wraps[k] == GL_CLAMP_TO_EDGE || wraps[k] == GL_MIRRORED_REPEAT ? wraps[k] : GL_REPEAT);
}

static void send_texture(
    const render_gl *gl, const render_texture *texture, int is_colour, GLuint *name) {
    const render_picture *picture = texture->picture;
    gl->GenTextures(1, name);
    gl->BindTexture(GL_TEXTURE_2D, *name);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    gl->TexImage2D(GL_TEXTURE_2D, 0, is_colour ? GL_SRGB8_ALPHA8 : GL_RGBA8,
        (GLsizei)picture->width, (GLsizei)picture->height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
        picture->pixels);
    gl->GenerateMipmap(GL_TEXTURE_2D);
    set_sampler(gl, texture);
}

static int is_same(const render_texture_upload *upload, const render_texture *texture, int colour) {
    return upload->texture.picture == texture->picture && upload->is_colour == colour &&
           upload->texture.wrap_s == texture->wrap_s && upload->texture.wrap_t == texture->wrap_t &&
           upload->texture.mag_filter == texture->mag_filter &&
           upload->texture.min_filter == texture->min_filter;
}

enum render_result render_texture_bind(render_device *device, const render_texture *texture,
    int is_colour, int unit, render_error *error) {
    const render_gl *gl = &device->gl;
    GLint most = 0;
    gl->ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    for (size_t i = 0; i < device->texture_count; ++i)
        if (is_same(&device->textures[i], texture, is_colour)) {
            gl->BindTexture(GL_TEXTURE_2D, device->textures[i].name);
            return RENDER_OK;
        }
    gl->GetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    if (texture->picture->width > (size_t)most || texture->picture->height > (size_t)most)
        return render_fail(error, RENDER_ERROR_DEVICE,
            "%s holds images of at most %d pixels in each direction, but a material's image has "
            "%zux%zu; --clay draws without images",
            device->name, most, texture->picture->width, texture->picture->height);
    render_texture_upload *larger =
        realloc(device->textures, (device->texture_count + 1) * sizeof *larger);
    if (!larger) return render_fail_memory(error);
    device->textures = larger;
    render_texture_upload *made = &larger[device->texture_count++];
    *made = (render_texture_upload){.texture = *texture, .is_colour = is_colour};
    send_texture(gl, texture, is_colour, &made->name);
    return RENDER_OK;
}

void render_textures_forget(render_device *device) {
    for (size_t i = 0; i < device->texture_count; ++i)
        device->gl.DeleteTextures(1, &device->textures[i].name);
    free(device->textures);
    device->textures = NULL;
    device->texture_count = 0;
}
