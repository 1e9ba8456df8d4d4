/* device.h: the renderer's state: programs that are compiled when they are first used, surfaces
 * that are uploaded once, the framebuffer. */
#ifndef NORMA_RENDER_DEVICE_H
#define NORMA_RENDER_DEVICE_H
#include "render/render.h"
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl3.h>
#include "render/parts.h"

/* ---- EGL and OpenGL ES 3.0, found when a picture is drawn and not before: the tool starts, and
 * does all else, where neither is installed. */

/* Type and name of each function that is used, without its gl. */
#define RENDER_GL_FUNCTIONS(F)                                                                     \
    F(PFNGLACTIVETEXTUREPROC, ActiveTexture)                                                       \
    F(PFNGLBINDTEXTUREPROC, BindTexture)                                                           \
    F(PFNGLDELETETEXTURESPROC, DeleteTextures)                                                     \
    F(PFNGLGENERATEMIPMAPPROC, GenerateMipmap)                                                     \
    F(PFNGLGENTEXTURESPROC, GenTextures)                                                           \
    F(PFNGLTEXIMAGE2DPROC, TexImage2D)                                                             \
    F(PFNGLTEXPARAMETERIPROC, TexParameteri)                                                       \
    F(PFNGLUNIFORM4FPROC, Uniform4f)                                                               \
    F(PFNGLATTACHSHADERPROC, AttachShader)                                                         \
    F(PFNGLBINDBUFFERPROC, BindBuffer)                                                             \
    F(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                                                   \
    F(PFNGLBINDRENDERBUFFERPROC, BindRenderbuffer)                                                 \
    F(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                                                   \
    F(PFNGLBLENDFUNCSEPARATEPROC, BlendFuncSeparate)                                               \
    F(PFNGLBUFFERDATAPROC, BufferData)                                                             \
    F(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus)                                     \
    F(PFNGLCLEARCOLORPROC, ClearColor)                                                             \
    F(PFNGLCLEARPROC, Clear)                                                                       \
    F(PFNGLCOMPILESHADERPROC, CompileShader)                                                       \
    F(PFNGLCREATEPROGRAMPROC, CreateProgram)                                                       \
    F(PFNGLCREATESHADERPROC, CreateShader)                                                         \
    F(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                                                       \
    F(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                                             \
    F(PFNGLDELETEPROGRAMPROC, DeleteProgram)                                                       \
    F(PFNGLDELETERENDERBUFFERSPROC, DeleteRenderbuffers)                                           \
    F(PFNGLDELETESHADERPROC, DeleteShader)                                                         \
    F(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                                             \
    F(PFNGLDEPTHFUNCPROC, DepthFunc)                                                               \
    F(PFNGLDEPTHMASKPROC, DepthMask)                                                               \
    F(PFNGLDISABLEPROC, Disable)                                                                   \
    F(PFNGLDISABLEVERTEXATTRIBARRAYPROC, DisableVertexAttribArray)                                 \
    F(PFNGLDRAWARRAYSINSTANCEDPROC, DrawArraysInstanced)                                           \
    F(PFNGLDRAWARRAYSPROC, DrawArrays)                                                             \
    F(PFNGLDRAWELEMENTSPROC, DrawElements)                                                         \
    F(PFNGLENABLEPROC, Enable)                                                                     \
    F(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray)                                   \
    F(PFNGLFRAMEBUFFERRENDERBUFFERPROC, FramebufferRenderbuffer)                                   \
    F(PFNGLFRONTFACEPROC, FrontFace)                                                               \
    F(PFNGLGENBUFFERSPROC, GenBuffers)                                                             \
    F(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)                                                   \
    F(PFNGLGENRENDERBUFFERSPROC, GenRenderbuffers)                                                 \
    F(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                                                   \
    F(PFNGLGETERRORPROC, GetError)                                                                 \
    F(PFNGLGETINTEGERVPROC, GetIntegerv)                                                           \
    F(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                                               \
    F(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                                         \
    F(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                                                 \
    F(PFNGLGETSHADERIVPROC, GetShaderiv)                                                           \
    F(PFNGLGETSTRINGPROC, GetString)                                                               \
    F(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                                             \
    F(PFNGLLINKPROGRAMPROC, LinkProgram)                                                           \
    F(PFNGLPIXELSTOREIPROC, PixelStorei)                                                           \
    F(PFNGLREADPIXELSPROC, ReadPixels)                                                             \
    F(PFNGLRENDERBUFFERSTORAGEPROC, RenderbufferStorage)                                           \
    F(PFNGLSHADERSOURCEPROC, ShaderSource)                                                         \
    F(PFNGLUNIFORM1FPROC, Uniform1f)                                                               \
    F(PFNGLUNIFORM1IPROC, Uniform1i)                                                               \
    F(PFNGLUNIFORM2FPROC, Uniform2f)                                                               \
    F(PFNGLUNIFORM3FVPROC, Uniform3fv)                                                             \
    F(PFNGLUNIFORM4FVPROC, Uniform4fv)                                                             \
    F(PFNGLUNIFORMMATRIX3FVPROC, UniformMatrix3fv)                                                 \
    F(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv)                                                 \
    F(PFNGLUSEPROGRAMPROC, UseProgram)                                                             \
    F(PFNGLVERTEXATTRIB4FPROC, VertexAttrib4f)                                                     \
    F(PFNGLVERTEXATTRIBDIVISORPROC, VertexAttribDivisor)                                           \
    F(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer)                                           \
    F(PFNGLVIEWPORTPROC, Viewport)

typedef struct render_gl {
#define RENDER_GL_MEMBER(type, name) type name;
    RENDER_GL_FUNCTIONS(RENDER_GL_MEMBER)
} render_gl;

/* The same of EGL, without its egl; then those that some have only, NULL where they are missing. */
#define RENDER_EGL_FUNCTIONS(F)                                                                    \
    F(PFNEGLGETPROCADDRESSPROC, GetProcAddress)                                                    \
    F(PFNEGLGETDISPLAYPROC, GetDisplay)                                                            \
    F(PFNEGLINITIALIZEPROC, Initialize)                                                            \
    F(PFNEGLBINDAPIPROC, BindAPI)                                                                  \
    F(PFNEGLCHOOSECONFIGPROC, ChooseConfig)                                                        \
    F(PFNEGLCREATECONTEXTPROC, CreateContext)                                                      \
    F(PFNEGLQUERYSTRINGPROC, QueryString)                                                          \
    F(PFNEGLTERMINATEPROC, Terminate)                                                              \
    F(PFNEGLMAKECURRENTPROC, MakeCurrent)                                                          \
    F(PFNEGLDESTROYCONTEXTPROC, DestroyContext)
#define RENDER_EGL_EXTENSIONS(F)                                                                   \
    F(PFNEGLQUERYDEVICESEXTPROC, QueryDevicesEXT)                                                  \
    F(PFNEGLQUERYDEVICESTRINGEXTPROC, QueryDeviceStringEXT)                                        \
    F(PFNEGLGETPLATFORMDISPLAYEXTPROC, GetPlatformDisplayEXT)

typedef struct render_egl {
    EGLDisplay display;
    EGLContext context;
    RENDER_EGL_FUNCTIONS(RENDER_GL_MEMBER)
    RENDER_EGL_EXTENSIONS(RENDER_GL_MEMBER)
} render_egl;

/* ---- programs */

enum render_program {
    RENDER_PROGRAM_FLAT = 0,
    RENDER_PROGRAM_GOURAUD,
    RENDER_PROGRAM_PHONG,
    RENDER_PROGRAM_NORMALS,
    RENDER_PROGRAM_WINDING,
    RENDER_PROGRAM_ERROR,
    RENDER_PROGRAM_MATCAP,
    RENDER_PROGRAM_ZEBRA,
    RENDER_PROGRAM_TANGENTS,
    RENDER_PROGRAM_LINE,
    RENDER_PROGRAM_HEDGEHOG,
    RENDER_PROGRAM_SCALE,
    RENDER_PROGRAMS
};

#define RENDER_MATRICES(U) U(local_to_world) U(world_to_view) U(view_to_clip) U(normal_matrix)
#define RENDER_COLOURS(U)  U(base_colour) U(two_sided) U(scale_top) U(eye)
#define RENDER_MAPS(U)     U(maps) U(base_map) U(normal_map)
#define RENDER_LIGHTS(U)   U(light_count) U(light_direction) U(light_colour) U(phong)
#define RENDER_LINES(U)    U(viewport) U(width) U(head) U(lift) U(reach_scale)

typedef struct render_uniforms {
#define RENDER_UNIFORM_MEMBER(name) GLint name;
    RENDER_MATRICES(RENDER_UNIFORM_MEMBER)
    RENDER_COLOURS(RENDER_UNIFORM_MEMBER)
    RENDER_MAPS(RENDER_UNIFORM_MEMBER)
    RENDER_LIGHTS(RENDER_UNIFORM_MEMBER)
    RENDER_LINES(RENDER_UNIFORM_MEMBER)
#undef RENDER_UNIFORM_MEMBER
} render_uniforms;

typedef struct render_compiled {
    GLuint program;
    render_uniforms at;
} render_compiled;

/* ---- surfaces as they were uploaded */

enum { RENDER_BUFFERS = 7, RENDER_LINE_KINDS = 5 };

typedef struct render_upload {
    struct render_upload *next;
    const render_surface *surface;
    enum render_kind kind;
    render_vertices
        vertices; /* kept: cameras are fitted to positions, errors are measured on normals */
    GLuint array, buffers[RENDER_BUFFERS];
} render_upload;

typedef struct render_line_upload {
    struct render_line_upload *next;
    const render_surface *surface;
    unsigned kind;
    render_line_set set;
    GLuint array, buffers[2];
} render_line_upload;

typedef struct render_texture_upload {
    struct render_texture_upload *next;
    render_texture texture;
    GLuint name;
} render_texture_upload;

struct render_device {
    render_egl egl;
    render_gl gl;
    char name[160];
    render_compiled programs[RENDER_PROGRAMS][2]; /* lit in world space, in view space */
    render_upload *uploads;
    render_line_upload *lines;
    render_texture_upload *textures;
    GLuint framebuffer, colour, depth, empty_array;
    size_t target_width, target_height;
    render_srgb srgb;
};

enum render_result render_program_use(render_device *device, enum render_program program,
    enum render_space space, const render_compiled **compiled, render_error *error);
enum render_result render_upload_of(render_device *device, const render_surface *surface,
    enum render_kind kind, const render_upload **upload, render_error *error);
enum render_result render_lines_of(render_device *device, const render_surface *surface,
    unsigned kind, const render_look *look, const render_line_upload **lines, render_error *error);

/* An image with its sampler on a unit, sent when it is first used; colours are sRGB. */
enum render_result render_texture_bind(
    render_device *device, const render_texture *texture, int unit, render_error *error);

/* ---- the target: a framebuffer of its own, several samples wide and high for each pixel */

enum render_result render_target_begin(
    render_device *device, size_t width, size_t height, const float clear[4], render_error *error);
typedef struct render_area {
    size_t x, y, width, height; /* pixels of a picture, from its upper left corner */
} render_area;
/* Writes what was drawn into an area of the picture: the mean of each pixel's samples, in linear
 * light. */
enum render_result render_target_read(render_device *device, int samples, render_picture *picture,
    const render_area *area, render_error *error);

/* ---- one panel: where its scene lies, how its camera stands, and its picture */

typedef struct render_placed { /* one draw of a scene, ready */
    const render_surface *surface;
    const render_upload *upload;
    const render_line_upload *lines[RENDER_LINE_KINDS];
    double to_world[16]; /* from the surface's box; first as the file has it, then so that the
                            scene's ball is the unit ball */
} render_placed;

typedef struct render_stage { /* a panel with all that its picture needs */
    const render_look *look;
    render_panel *panel;
    render_placed *placed;
    size_t placed_count;
    render_ball ball; /* of the file's world */
    double shrunk;    /* of the file's world: by so much, about the ball's centre; as a matrix */
    double shrink[16];
    double grown; /* how far lines reach out of the unit ball */
    render_camera camera;
    float *tips; /* where hedgehog lines end, in the unit world */
    size_t tip_count;
    double error_top_deg;
} render_stage;

enum render_result render_stage_make(render_device *device, const render_look *look,
    render_panel *panel, render_stage *stage, render_error *error);
void render_stage_free(render_stage *stage);
/* The world so that a ball of this radius about the panel's own centre is the unit ball. */
enum render_result render_stage_scale(render_stage *stage, double radius, render_error *error);
render_frame render_stage_frame(const render_stage *stage);
void render_stage_aim(render_stage *stage, const render_frame *frame, double distance);
enum render_result render_stage_draw(
    render_device *device, const render_stage *stage, render_error *error);

/* Of hedgehog lines; and as surface.frag has them, where they face the eye. */
enum {
    RENDER_VERTEX_COLOUR = 0x2B5C9E,
    RENDER_FACE_COLOUR = 0xC96A10,
    RENDER_EDGE_COLOUR = 0x7A4FA3,
    RENDER_FRONT_COLOUR = 0x3DB35C,
    RENDER_BACK_COLOUR = 0xDE332E,
    RENDER_NOTHING_COLOUR = 0x7B7B7B
};
#endif
