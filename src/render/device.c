/* device.c: drawing by OpenGL ES 3.0 without a window: programs, textures, targets, vertices. EGL
 * on a device of its own, a GPU before Mesa's software renderer, in a context without a surface. */
#include "render/device.h"
#include "norma_glsl.h"
#include "shaders.h"
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_DEVICES = 16 };

/* dlsym gives an object pointer where a function pointer is wanted; POSIX says that they are of one
 * size. */
static int load_egl(void *library, render_egl *egl) {
    int good = 1;
#define RENDER_EGL_LOAD(type, name)                                                                \
    do {                                                                                           \
        void *found = dlsym(library, "egl" #name);                                                 \
        memcpy(&egl->name, &found, sizeof egl->name);                                              \
        good &= found != NULL;                                                                     \
    } while (0);
    RENDER_EGL_FUNCTIONS(RENDER_EGL_LOAD)
#undef RENDER_EGL_LOAD
    if (!good) return 0;
#define RENDER_EGL_FIND(type, name) egl->name = (type)egl->GetProcAddress("egl" #name);
    RENDER_EGL_EXTENSIONS(RENDER_EGL_FIND)
#undef RENDER_EGL_FIND
    return 1;
}

/* ---- displays to try, the best first */

typedef struct candidates {
    EGLDisplay displays[MOST_DEVICES + 2];
    int count;
} candidates;

static int has_word(const char *list, const char *word) {
    size_t length = strlen(word);
    for (const char *at = list; at && (at = strstr(at, word)); at += length)
        if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0')) return 1;
    return 0;
}

static void add_devices(const render_egl *egl, int software, candidates *list) {
    EGLDeviceEXT devices[MOST_DEVICES];
    EGLint count = 0;
    if (!egl->QueryDevicesEXT || !egl->QueryDeviceStringEXT || !egl->GetPlatformDisplayEXT ||
        !egl->QueryDevicesEXT(MOST_DEVICES, devices, &count))
        return;
    for (EGLint i = 0; i < count; ++i)
        if (has_word(egl->QueryDeviceStringEXT(devices[i], EGL_EXTENSIONS),
                "EGL_MESA_device_software") == software)
            list->displays[list->count++] =
                egl->GetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], NULL);
}

static void find_displays(const render_egl *egl, int software, candidates *list) {
    if (!software) add_devices(egl, 0, list);
    add_devices(egl, 1, list);
    if (software) return;
    if (egl->GetPlatformDisplayEXT)
        list->displays[list->count++] = egl->GetPlatformDisplayEXT(
            EGL_PLATFORM_SURFACELESS_MESA, (void *)EGL_DEFAULT_DISPLAY, NULL);
    list->displays[list->count++] = egl->GetDisplay(EGL_DEFAULT_DISPLAY);
}

static int load_gl(const render_egl *egl, render_gl *gl) {
    int good = 1;
#define RENDER_GL_LOAD(type, name)                                                                 \
    good &= (gl->name = (type)egl->GetProcAddress("gl" #name)) != NULL;
    RENDER_GL_FUNCTIONS(RENDER_GL_LOAD)
#undef RENDER_GL_LOAD
    return good;
}

static int try_display(render_egl *egl, EGLDisplay display, render_gl *gl) {
    static const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_SURFACE_TYPE, 0,
        EGL_NONE},
                        version[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
    EGLConfig config = NULL;
    EGLint major, minor, configs = 0;
    if (display == EGL_NO_DISPLAY || !egl->Initialize(display, &major, &minor)) return 0;
    const char *extensions = egl->QueryString(display, EGL_EXTENSIONS);
    if (has_word(extensions, "EGL_KHR_surfaceless_context") && egl->BindAPI(EGL_OPENGL_ES_API)) {
        if (!egl->ChooseConfig(display, wanted, &config, 1, &configs) || configs < 1)
            config = NULL; /* EGL_KHR_no_config_context */
        egl->context = egl->CreateContext(display, config, EGL_NO_CONTEXT, version);
        if (egl->context != EGL_NO_CONTEXT &&
            egl->MakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl->context) &&
            load_gl(egl, gl)) {
            egl->display = display;
            return 1;
        }
    }
    egl->Terminate(display);
    return 0;
}

static enum render_result egl_open(
    int software, render_egl *egl, render_gl *gl, render_error *error) {
    candidates list = {.count = 0};
    void *library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return render_fail(error, RENDER_ERROR_DEVICE,
            "cannot draw: EGL is not installed (%s); on Debian, install libegl1, and "
            "libgl1-mesa-dri for a software renderer",
            dlerror());
    if (!load_egl(library, egl))
        return render_fail(
            error, RENDER_ERROR_DEVICE, "cannot draw: libEGL.so.1 lacks functions of EGL 1.4");
    find_displays(egl, software, &list);
    for (int i = 0; i < list.count; ++i)
        if (try_display(egl, list.displays[i], gl)) return RENDER_OK;
    return render_fail(error, RENDER_ERROR_DEVICE,
        "cannot draw: EGL has no OpenGL ES 3.0 context without a window on any of %d displays; on "
        "Debian, libgl1-mesa-dri is a software renderer",
        list.count);
}

/* The library stays loaded: what drivers leave to be done at exit would have no code any more. */
static void egl_close(render_egl *egl) {
    if (!egl->context) return;
    egl->MakeCurrent(egl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    egl->DestroyContext(egl->display, egl->context);
    egl->Terminate(egl->display);
    *egl = (render_egl){0};
}

/* ---- The shaders, put together as shaders/colour.glsl says, compiled when they are first
 * used. */

static const char preface[] = "#version 300 es\nprecision highp float; precision highp int;\n";

/* What each program defines; those of surfaces stand before RENDER_PROGRAM_LINE. */
static const char *const program_defines[RENDER_PROGRAMS] = {"SHADING_FLAT", "SHADING_GOURAUD",
    "SHADING_PHONG", "SHOW_NORMALS", "SHOW_WINDING", "SHOW_ERROR", "SHOW_MATCAP", "SHOW_ZEBRA",
    "SHOW_TANGENTS", "LINE", "HEDGEHOG", "SCALE"};

static enum render_result compile(const render_gl *gl, GLenum stage, const char *defines,
    const char *text, GLuint *shader, render_error *error) {
    const char *const parts[] = {
        preface, defines, norma_glsl, render_shader_colour_glsl, render_shader_light_glsl, text};
    char log[200] = "";
    GLint good = 0;
    *shader = gl->CreateShader(stage);
    gl->ShaderSource(*shader, (GLsizei)(sizeof parts / sizeof *parts), parts, NULL);
    gl->CompileShader(*shader);
    gl->GetShaderiv(*shader, GL_COMPILE_STATUS, &good);
    if (good) return RENDER_OK;
    gl->GetShaderInfoLog(*shader, sizeof log, NULL, log);
    log[strcspn(log, "\n")] = '\0';
    return render_fail(
        error, RENDER_ERROR_DEVICE, "cannot draw: the graphics driver refuses a shader: %s", log);
}

static enum render_result link_program(const render_gl *gl, enum render_program kind,
    enum render_space space, GLuint *program, render_error *error) {
    char defines[80], log[200] = "";
    GLuint vertex = 0, fragment = 0;
    GLint good = 0;
    snprintf(defines, sizeof defines, "#define %s\n%s", program_defines[kind],
        space == RENDER_SPACE_VIEW ? "#define LIGHT_IN_VIEW\n" : "");
    enum render_result result = compile(gl, GL_VERTEX_SHADER, defines,
        kind < RENDER_PROGRAM_LINE    ? render_shader_surface_vert
        : kind < RENDER_PROGRAM_SCALE ? render_shader_line_vert
                                      : render_shader_scale_vert,
        &vertex, error);
    if (!result)
        result = compile(gl, GL_FRAGMENT_SHADER, defines,
            kind < RENDER_PROGRAM_LINE    ? render_shader_surface_frag
            : kind < RENDER_PROGRAM_SCALE ? render_shader_line_frag
                                          : render_shader_scale_frag,
            &fragment, error);
    if (!result) {
        *program = gl->CreateProgram();
        gl->AttachShader(*program, vertex);
        gl->AttachShader(*program, fragment);
        gl->LinkProgram(*program);
        gl->GetProgramiv(*program, GL_LINK_STATUS, &good);
        gl->GetProgramInfoLog(*program, sizeof log, NULL, log);
        log[strcspn(log, "\n")] = '\0';
        if (!good)
            result = render_fail(error, RENDER_ERROR_DEVICE,
                "cannot draw: the graphics driver refuses a program: %s", log);
    }
    gl->DeleteShader(vertex);
    gl->DeleteShader(fragment);
    return result;
}

enum render_result render_program_use(render_device *device, enum render_program program,
    enum render_space space, const render_compiled **compiled, render_error *error) {
    const render_gl *gl = &device->gl;
    render_compiled *entry = &device->programs[program][space];
    if (!entry->program) {
        enum render_result result = link_program(gl, program, space, &entry->program, error);
        if (result) return result;
#define RENDER_UNIFORM_FIND(name) entry->at.name = gl->GetUniformLocation(entry->program, #name);
        RENDER_MATRICES(RENDER_UNIFORM_FIND)
        RENDER_COLOURS(RENDER_UNIFORM_FIND)
        RENDER_MAPS(RENDER_UNIFORM_FIND)
        RENDER_LIGHTS(RENDER_UNIFORM_FIND)
        RENDER_LINES(RENDER_UNIFORM_FIND)
#undef RENDER_UNIFORM_FIND
    }
    gl->UseProgram(entry->program);
    *compiled = entry;
    return RENDER_OK;
}

/* ---- Images in the memory of the graphics processor, each sent once. */

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

static void send_texture(const render_gl *gl, const render_texture *texture, GLuint *name) {
    const render_picture *picture = texture->picture;
    gl->GenTextures(1, name);
    gl->BindTexture(GL_TEXTURE_2D, *name);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, (GLsizei)picture->width, (GLsizei)picture->height, 0,
        GL_RGBA, GL_UNSIGNED_BYTE, picture->pixels);
    gl->GenerateMipmap(GL_TEXTURE_2D);
    set_sampler(gl, texture);
}

static int is_upload_of(const render_texture_upload *upload, const render_texture *texture) {
    return upload->texture.picture == texture->picture &&
           upload->texture.wrap_s == texture->wrap_s && upload->texture.wrap_t == texture->wrap_t &&
           upload->texture.mag_filter == texture->mag_filter &&
           upload->texture.min_filter == texture->min_filter;
}

enum render_result render_texture_bind(
    render_device *device, const render_texture *texture, int unit, render_error *error) {
    const render_gl *gl = &device->gl;
    GLint most = 0;
    gl->ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    for (const render_texture_upload *u = device->textures; u; u = u->next)
        if (is_upload_of(u, texture)) {
            gl->BindTexture(GL_TEXTURE_2D, u->name);
            return RENDER_OK;
        }
    gl->GetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    if (texture->picture->width > (size_t)most || texture->picture->height > (size_t)most)
        return render_fail(error, RENDER_ERROR_DEVICE,
            "%s holds images of at most %d pixels in each direction, but a material's image has "
            "%zux%zu; --clay draws without images",
            device->name, most, texture->picture->width, texture->picture->height);
    render_texture_upload *made = calloc(1, sizeof *made);
    if (!made) return render_fail_memory(error);
    *made = (render_texture_upload){.next = device->textures, .texture = *texture};
    device->textures = made;
    send_texture(gl, texture, &made->name);
    return RENDER_OK;
}

/* ---- The framebuffer that is drawn into, and how its samples become the pixels of a picture. */

static void target_free(render_device *device) {
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
    target_free(device);
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
static void resolve_pixel(const render_srgb *srgb, const uint8_t *samples, size_t stride,
    size_t each_way, uint8_t pixel[4]) {
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
            resolve_pixel(&device->srgb,
                all + (height - 1 - row) * each_way * stride + 4 * column * each_way, stride,
                each_way, picture->pixels + 4 * ((y + row) * picture->width + x + column));
    free(all);
    const GLenum trouble = gl->GetError();
    if (trouble != GL_NO_ERROR)
        return render_fail(error, RENDER_ERROR_DEVICE, "%s: OpenGL error 0x%x%s", device->name,
            trouble, trouble == GL_OUT_OF_MEMORY ? " (out of memory)" : "");
    return RENDER_OK;
}

/* ---- Surfaces and lines in the memory of the graphics processor, each made and sent once
 * however many panels show it. */

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
    const render_upload *known = device->uploads;
    while (known && !(known->surface == surface && known->kind == kind)) known = known->next;
    if ((*upload = known) != NULL) return RENDER_OK;
    render_upload *made = calloc(1, sizeof *made);
    if (!made) return render_fail_memory(error);
    enum render_result result = render_vertices_make(surface, kind, &made->vertices, error);
    if (result) {
        free(made);
        return result;
    }
    made->surface = surface;
    made->kind = kind;
    send_vertices(&device->gl, made);
    made->next = device->uploads;
    *upload = device->uploads = made;
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
    const render_line_upload *known = device->lines;
    while (known && !(known->surface == surface && known->kind == kind)) known = known->next;
    if ((*lines = known) != NULL) return RENDER_OK;
    render_line_upload *made = calloc(1, sizeof *made);
    if (!made) return render_fail_memory(error);
    enum render_result result =
        render_lines_make(surface, kind, look->reach, look->most_lines, &made->set, error);
    if (result) {
        free(made);
        return result;
    }
    made->surface = surface;
    made->kind = kind;
    send_lines(&device->gl, made);
    made->next = device->lines;
    *lines = device->lines = made;
    return RENDER_OK;
}

void render_device_forget(render_device *device) {
    const render_gl *gl = &device->gl;
    for (render_upload *u; (u = device->uploads) != NULL; free(u)) {
        device->uploads = u->next;
        gl->DeleteVertexArrays(1, &u->array);
        gl->DeleteBuffers(RENDER_BUFFERS, u->buffers);
        render_vertices_free(&u->vertices);
    }
    for (render_line_upload *u; (u = device->lines) != NULL; free(u)) {
        device->lines = u->next;
        gl->DeleteVertexArrays(1, &u->array);
        gl->DeleteBuffers(2, u->buffers);
        render_lines_free(&u->set);
    }
    for (render_texture_upload *u; (u = device->textures) != NULL; free(u)) {
        device->textures = u->next;
        gl->DeleteTextures(1, &u->name);
    }
}

/* ---- Opening and closing a renderer. */

enum render_result render_device_open(int software, render_device **device, render_error *error) {
    render_device *made = *device = calloc(1, sizeof *made);
    if (!made) return render_fail_memory(error);
    enum render_result result = egl_open(software, &made->egl, &made->gl, error);
    if (result) {
        free(made);
        *device = NULL;
        return result;
    }
    const char *name = (const char *)made->gl.GetString(GL_RENDERER);
    snprintf(made->name, sizeof made->name, "%s", name ? name : "unknown renderer");
    made->gl.GenVertexArrays(1, &made->empty_array);
    render_srgb_make(&made->srgb);
    return RENDER_OK;
}

void render_device_close(render_device *device) {
    if (!device) return;
    render_device_forget(device);
    target_free(device);
    device->gl.DeleteVertexArrays(1, &device->empty_array);
    for (int i = 0; i < RENDER_PROGRAMS; ++i)
        for (int k = 0; k < 2; ++k)
            if (device->programs[i][k].program)
                device->gl.DeleteProgram(device->programs[i][k].program);
    egl_close(&device->egl);
    free(device);
}

const char *render_device_name(const render_device *device) { return device->name; }
