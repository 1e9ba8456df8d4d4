/* device.c: opening and closing a renderer. */
#include "render/gl/device.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum render_result render_device_open(int software, render_device **device, render_error *error) {
    render_device *made = *device = calloc(1, sizeof *made);
    if (!made) return render_fail_memory(error);
    enum render_result result = render_egl_open(software, &made->egl, &made->gl, error);
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
    render_target_free(device);
    device->gl.DeleteVertexArrays(1, &device->empty_array);
    for (int i = 0; i < RENDER_PROGRAMS; ++i)
        for (int k = 0; k < 2; ++k)
            if (device->programs[i][k].program)
                device->gl.DeleteProgram(device->programs[i][k].program);
    render_egl_close(&device->egl);
    free(device);
}

const char *render_device_name(const render_device *device) { return device->name; }
