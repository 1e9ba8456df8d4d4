/* program.c: the shaders, put together as shaders/colour.glsl says, compiled when they are first
 * used. */
#include "render/gl/device.h"
#include "shaders.h"
#include <stdio.h>
#include <string.h>

static const char preface[] = "#version 300 es\nprecision highp float; precision highp int;\n";

static const struct recipe {
    const char *define, *vertex, *fragment;
} recipes[RENDER_PROGRAMS] = {
    [RENDER_PROGRAM_FLAT] = {"SHADING_FLAT", render_shader_surface_vert,
        render_shader_surface_frag},
    [RENDER_PROGRAM_GOURAUD] = {"SHADING_GOURAUD", render_shader_surface_vert,
        render_shader_surface_frag},
    [RENDER_PROGRAM_PHONG] = {"SHADING_PHONG", render_shader_surface_vert,
        render_shader_surface_frag},
    [RENDER_PROGRAM_NORMALS] = {"SHOW_NORMALS", render_shader_surface_vert,
        render_shader_surface_frag},
    [RENDER_PROGRAM_WINDING] = {"SHOW_WINDING", render_shader_surface_vert,
        render_shader_surface_frag},
    [RENDER_PROGRAM_ERROR] = {"SHOW_ERROR", render_shader_surface_vert, render_shader_surface_frag},
    [RENDER_PROGRAM_MATCAP] = {"SHOW_MATCAP", render_shader_surface_vert,
        render_shader_surface_frag},
    [RENDER_PROGRAM_ZEBRA] = {"SHOW_ZEBRA", render_shader_surface_vert, render_shader_surface_frag},
    [RENDER_PROGRAM_TANGENTS] = {"SHOW_TANGENTS", render_shader_surface_vert,
        render_shader_surface_frag},
    [RENDER_PROGRAM_LINE] = {"LINE", render_shader_line_vert, render_shader_line_frag},
    [RENDER_PROGRAM_HEDGEHOG] = {"HEDGEHOG", render_shader_line_vert, render_shader_line_frag},
    [RENDER_PROGRAM_SCALE] = {"SCALE", render_shader_scale_vert, render_shader_scale_frag},
};

static enum render_result compile(const render_gl *gl, GLenum stage, const char *defines,
    const char *text, GLuint *shader, render_error *error) {
    const char *const parts[] = {
        preface, defines, render_shader_colour_glsl, render_shader_light_glsl, text};
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

static enum render_result link_program(const render_gl *gl, const struct recipe *recipe,
    enum render_space space, GLuint *program, render_error *error) {
    char defines[80], log[200] = "";
    GLuint vertex = 0, fragment = 0;
    GLint good = 0;
    snprintf(defines, sizeof defines, "#define %s\n%s", recipe->define,
        space == RENDER_SPACE_VIEW ? "#define LIGHT_IN_VIEW\n" : "");
    enum render_result result =
        compile(gl, GL_VERTEX_SHADER, defines, recipe->vertex, &vertex, error);
    if (!result)
        result = compile(gl, GL_FRAGMENT_SHADER, defines, recipe->fragment, &fragment, error);
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
        enum render_result result =
            link_program(gl, &recipes[program], space, &entry->program, error);
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
