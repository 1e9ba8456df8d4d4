/* egl.c: OpenGL ES 3.0 without a window: EGL on a device of its own, a GPU before Mesa's software
 * renderer, in a context without a surface. */
#include "render/gl/gl.h"
#include "render/fail.h"
#include <dlfcn.h>
#include <string.h>

enum { MOST_DEVICES = 16 };

/* What EGL itself is used for; found by name in its library. */
typedef struct egl_calls {
    PFNEGLGETPROCADDRESSPROC get_proc_address;
    PFNEGLGETDISPLAYPROC get_display;
    PFNEGLINITIALIZEPROC initialize;
    PFNEGLBINDAPIPROC bind_api;
    PFNEGLCHOOSECONFIGPROC choose_config;
    PFNEGLCREATECONTEXTPROC create_context;
    PFNEGLQUERYSTRINGPROC query_string;
    PFNEGLQUERYDEVICESEXTPROC query_devices; /* these three: NULL where the extension is missing */
    PFNEGLQUERYDEVICESTRINGEXTPROC query_device_string;
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display;
} egl_calls;

/* dlsym gives an object pointer where a function pointer is wanted; POSIX says that they are of one
 * size. */
#define FIND(from, pointer)                                                                        \
    do {                                                                                           \
        void *found = (from);                                                                      \
        memcpy(&(pointer), &found, sizeof(pointer));                                               \
    } while (0)

static int find_calls(void *library, render_egl *egl, egl_calls *calls) {
    FIND(dlsym(library, "eglGetProcAddress"), calls->get_proc_address);
    FIND(dlsym(library, "eglGetDisplay"), calls->get_display);
    FIND(dlsym(library, "eglInitialize"), calls->initialize);
    FIND(dlsym(library, "eglBindAPI"), calls->bind_api);
    FIND(dlsym(library, "eglChooseConfig"), calls->choose_config);
    FIND(dlsym(library, "eglCreateContext"), calls->create_context);
    FIND(dlsym(library, "eglQueryString"), calls->query_string);
    FIND(dlsym(library, "eglTerminate"), egl->terminate);
    FIND(dlsym(library, "eglMakeCurrent"), egl->make_current);
    FIND(dlsym(library, "eglDestroyContext"), egl->destroy_context);
    if (!calls->get_proc_address || !calls->get_display || !calls->initialize || !calls->bind_api ||
        !calls->choose_config || !calls->create_context || !calls->query_string ||
        !egl->terminate || !egl->make_current || !egl->destroy_context)
        return 0;
    calls->query_devices = (PFNEGLQUERYDEVICESEXTPROC)calls->get_proc_address("eglQueryDevicesEXT");
    calls->query_device_string =
        (PFNEGLQUERYDEVICESTRINGEXTPROC)calls->get_proc_address("eglQueryDeviceStringEXT");
    calls->get_platform_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)calls->get_proc_address("eglGetPlatformDisplayEXT");
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

static void add_devices(const egl_calls *calls, int software, candidates *list) {
    EGLDeviceEXT devices[MOST_DEVICES];
    EGLint count = 0;
    if (!calls->query_devices || !calls->query_device_string || !calls->get_platform_display ||
        !calls->query_devices(MOST_DEVICES, devices, &count))
        return;
    for (EGLint i = 0; i < count; ++i)
        if (has_word(calls->query_device_string(devices[i], EGL_EXTENSIONS),
                "EGL_MESA_device_software") == software)
            list->displays[list->count++] =
                calls->get_platform_display(EGL_PLATFORM_DEVICE_EXT, devices[i], NULL);
}

static void find_displays(const egl_calls *calls, int software, candidates *list) {
    if (!software) add_devices(calls, 0, list);
    add_devices(calls, 1, list);
    if (software) return;
    if (calls->get_platform_display)
        list->displays[list->count++] = calls->get_platform_display(
            EGL_PLATFORM_SURFACELESS_MESA, (void *)EGL_DEFAULT_DISPLAY, NULL);
    list->displays[list->count++] = calls->get_display(EGL_DEFAULT_DISPLAY);
}

static int load_gl(const egl_calls *calls, render_gl *gl) {
    int good = 1;
#define RENDER_GL_LOAD(type, name)                                                                 \
    good &= (gl->name = (type)calls->get_proc_address("gl" #name)) != NULL;
    RENDER_GL_FUNCTIONS(RENDER_GL_LOAD)
#undef RENDER_GL_LOAD
    return good;
}

static int try_display(const egl_calls *calls, EGLDisplay display, render_egl *egl, render_gl *gl) {
    static const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_SURFACE_TYPE, 0,
        EGL_NONE},
                        version[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
    EGLConfig config = NULL;
    EGLint major, minor, configs = 0;
    if (display == EGL_NO_DISPLAY || !calls->initialize(display, &major, &minor)) return 0;
    const char *extensions = calls->query_string(display, EGL_EXTENSIONS);
    if (has_word(extensions, "EGL_KHR_surfaceless_context") && calls->bind_api(EGL_OPENGL_ES_API)) {
        if (!calls->choose_config(display, wanted, &config, 1, &configs) || configs < 1)
            config = NULL; /* EGL_KHR_no_config_context */
        egl->context = calls->create_context(display, config, EGL_NO_CONTEXT, version);
        if (egl->context != EGL_NO_CONTEXT &&
            egl->make_current(display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl->context) &&
            load_gl(calls, gl)) {
            egl->display = display;
            return 1;
        }
    }
    egl->terminate(display);
    return 0;
}

enum render_result render_egl_open(
    int software, render_egl *egl, render_gl *gl, render_error *error) {
    egl_calls calls = {0};
    candidates list = {.count = 0};
    *egl = (render_egl){.library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL)};
    if (!egl->library)
        return render_fail(error, RENDER_ERROR_DEVICE,
            "cannot draw: EGL is not installed (%s); on Debian, install libegl1, and "
            "libgl1-mesa-dri for a software renderer",
            dlerror());
    if (!find_calls(egl->library, egl, &calls))
        return render_fail(
            error, RENDER_ERROR_DEVICE, "cannot draw: libEGL.so.1 lacks functions of EGL 1.4");
    find_displays(&calls, software, &list);
    for (int i = 0; i < list.count; ++i)
        if (try_display(&calls, list.displays[i], egl, gl)) return RENDER_OK;
    return render_fail(error, RENDER_ERROR_DEVICE,
        "cannot draw: EGL has no OpenGL ES 3.0 context without a window on any of %d displays; on "
        "Debian, libgl1-mesa-dri is a software renderer",
        list.count);
}

/* The library stays loaded: what drivers leave to be done at exit would have no code any more. */
void render_egl_close(render_egl *egl) {
    if (!egl->context) return;
    egl->make_current(egl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    egl->destroy_context(egl->display, egl->context);
    egl->terminate(egl->display);
    *egl = (render_egl){0};
}
