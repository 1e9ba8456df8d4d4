/* gl.h: EGL and OpenGL ES 3.0, found when a picture is drawn and not before: the tool starts, and
 * does all else, where neither is installed. */
#ifndef NORMA_RENDER_GL_H
#define NORMA_RENDER_GL_H
#include "render/render.h"
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl3.h>

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
#undef RENDER_GL_MEMBER
} render_gl;

typedef struct render_egl {
    void *library;
    EGLDisplay display;
    EGLContext context;
    PFNEGLTERMINATEPROC terminate;
    PFNEGLMAKECURRENTPROC make_current;
    PFNEGLDESTROYCONTEXTPROC destroy_context;
} render_egl;

/* A current context without a surface, and the functions of OpenGL ES 3.0. */
enum render_result render_egl_open(
    int software, render_egl *egl, render_gl *gl, render_error *error);
void render_egl_close(render_egl *egl);
#endif
