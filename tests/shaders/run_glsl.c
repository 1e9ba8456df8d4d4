/* run_glsl.c: runs a vertex shader over records of vec4 without drawing anything (transform
 * feedback of OpenGL ES 3).
 *
 *   run_glsl SHADER IN OUT     SHADER: a whole one, with #version; IN, OUT: raw records
 *
 * Exits with 77, and says why, where there is no OpenGL ES 3. */
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { INPUTS = 12, OUTPUTS = 14, VEC4 = 16, BATCH = 65536, MISSING = 77 };

static void fail(int status, const char *what, const char *detail) {
    fprintf(stderr, "run_glsl: %s %s\n", what, detail);
    exit(status);
}

static char *read_file(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    if (!file || fseek(file, 0, SEEK_END)) fail(1, "cannot be read:", path);
    *size = (size_t)ftell(file);
    rewind(file);
    char *bytes = malloc(*size + 1);
    if (!bytes || fread(bytes, 1, *size, file) != *size) fail(1, "cannot be read:", path);
    bytes[*size] = 0;
    fclose(file);
    return bytes;
}

static void make_context(void) {
    const PFNEGLGETPLATFORMDISPLAYEXTPROC platform_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    const EGLint wanted[] = {EGL_CONTEXT_CLIENT_VERSION, 3, EGL_NONE};
    const EGLDisplay display = platform_display
                                   ? platform_display(EGL_PLATFORM_SURFACELESS_MESA, NULL, NULL)
                                   : eglGetDisplay(EGL_DEFAULT_DISPLAY);
    if (!eglInitialize(display, NULL, NULL) || !eglBindAPI(EGL_OPENGL_ES_API))
        fail(MISSING, "no EGL", "");
    const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted);
    if (!context || !eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
        fail(MISSING, "no OpenGL ES 3", "");
}

static GLuint compile(GLenum stage, const char *text) {
    char said[4000] = "";
    GLint fine = 0;
    const GLuint shader = glCreateShader(stage);
    glShaderSource(shader, 1, &text, NULL);
    glCompileShader(shader);
    glGetShaderiv(shader, GL_COMPILE_STATUS, &fine);
    glGetShaderInfoLog(shader, sizeof said, NULL, said);
    if (!fine) fail(1, "does not compile:", said);
    return shader;
}

static void use_program(const char *text) {
    static const char nothing[] =
        "#version 300 es\nprecision highp float;\nout vec4 c;\nvoid main() { c = vec4(0.0); }\n";
    const char *names[OUTPUTS] = {
        "o0", "o1", "o2", "o3", "o4", "o5", "o6", "o7", "o8", "o9", "o10", "o11", "o12", "o13"};
    char said[4000] = "";
    GLint fine = 0;
    const GLuint program = glCreateProgram();
    const int later = strncmp(text, "#version 310", 12) == 0;
    char fragment[sizeof nothing];
    memcpy(fragment, nothing, sizeof nothing);
    if (later) fragment[10] = '1';
    glAttachShader(program, compile(GL_VERTEX_SHADER, text));
    glAttachShader(program, compile(GL_FRAGMENT_SHADER, fragment));
    glTransformFeedbackVaryings(program, OUTPUTS, names, GL_INTERLEAVED_ATTRIBS);
    glLinkProgram(program);
    glGetProgramiv(program, GL_LINK_STATUS, &fine);
    glGetProgramInfoLog(program, sizeof said, NULL, said);
    if (!fine) fail(1, "does not link:", said);
    glUseProgram(program);
}

/* A context without a surface draws into nothing that is whole, even where nothing is drawn. */
static void bind_target(void) {
    GLuint frame, pixels;
    glGenFramebuffers(1, &frame);
    glGenRenderbuffers(1, &pixels);
    glBindFramebuffer(GL_FRAMEBUFFER, frame);
    glBindRenderbuffer(GL_RENDERBUFFER, pixels);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, 1, 1);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, pixels);
    glEnable(GL_RASTERIZER_DISCARD);
}

static void bind_inputs(void) {
    GLuint buffer;
    glGenBuffers(1, &buffer);
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    for (GLuint i = 0; i < INPUTS; ++i) {
        const void *offset = (const char *)0 + (size_t)i * VEC4;
        glEnableVertexAttribArray(i);
        if (i + 1 < INPUTS)
            glVertexAttribPointer(i, 4, GL_FLOAT, GL_FALSE, INPUTS * VEC4, offset);
        else
            glVertexAttribIPointer(i, 4, GL_UNSIGNED_INT, INPUTS * VEC4, offset);
    }
}

static void run_batch(const char *records, size_t count, FILE *out) {
    const size_t bytes = count * OUTPUTS * VEC4;
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(count * INPUTS * VEC4), records, GL_STREAM_DRAW);
    glBufferData(GL_TRANSFORM_FEEDBACK_BUFFER, (GLsizeiptr)bytes, NULL, GL_STREAM_READ);
    glBeginTransformFeedback(GL_POINTS);
    glDrawArrays(GL_POINTS, 0, (GLsizei)count);
    glEndTransformFeedback();
    const void *results =
        glMapBufferRange(GL_TRANSFORM_FEEDBACK_BUFFER, 0, (GLsizeiptr)bytes, GL_MAP_READ_BIT);
    if (!results || fwrite(results, 1, bytes, out) != bytes) fail(1, "no results", "");
    glUnmapBuffer(GL_TRANSFORM_FEEDBACK_BUFFER);
}

int main(int argc, char **argv) {
    size_t text_size, size;
    GLuint feedback;
    if (argc != 4) fail(2, "SHADER IN OUT expected", "");
    const char *text = read_file(argv[1], &text_size), *records = read_file(argv[2], &size);
    FILE *out = fopen(argv[3], "wb");
    if (!out) fail(1, "cannot be written:", argv[3]);
    make_context();
    use_program(text);
    bind_target();
    glGenBuffers(1, &feedback);
    glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, feedback);
    bind_inputs();
    const size_t count = size / (INPUTS * VEC4);
    for (size_t i = 0; i < count; i += BATCH)
        run_batch(records + i * INPUTS * VEC4, count - i < BATCH ? count - i : BATCH, out);
    if (fclose(out) || glGetError()) fail(1, "an error of OpenGL", "");
    return 0;
}
