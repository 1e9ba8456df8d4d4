/* model_exports.c: models as JavaScript handles them: by address, with their counts and arrays by
 * number. */
#include "model.h"
#include "../../package/wasm/exports.h"
#include <stdlib.h>
#include <string.h>

size_t WEB_EXPORT(model_error_size)(void) { return sizeof(norma_document_error); }
const char *WEB_EXPORT(model_error_text)(const norma_document_error *error) {
    return error->message;
}

model *WEB_EXPORT(model_of_pack)(unsigned char *pack, size_t size) {
    return model_open(pack, size);
}
void WEB_EXPORT(model_free)(model *m) { model_close(m); }

uint32_t WEB_EXPORT(model_mesh_count)(const model *m) { return m->head->mesh_count; }
uint32_t WEB_EXPORT(model_draw_count)(const model *m) { return m->head->draw_count; }
uint32_t WEB_EXPORT(model_format)(const model *m) { return m->head->format; }
uint32_t WEB_EXPORT(model_unread_count)(const model *m) { return m->head->unread_count; }
uint32_t WEB_EXPORT(model_draw_mesh)(const model *m, uint32_t draw) { return m->draws[draw].mesh; }
const double *WEB_EXPORT(model_draw_world)(const model *m, uint32_t draw) {
    return m->draws[draw].world;
}

uint32_t WEB_EXPORT(model_triangles)(const model *m, uint32_t mesh) {
    return (uint32_t)m->meshes[mesh].triangle_count;
}
uint32_t WEB_EXPORT(model_faces)(const model *m, uint32_t mesh) {
    return m->meshes[mesh].record->face_count;
}
uint32_t WEB_EXPORT(model_vertices)(const model *m, uint32_t mesh) {
    return m->meshes[mesh].record->position_count;
}
uint32_t WEB_EXPORT(model_storage)(const model *m, uint32_t mesh) {
    return m->meshes[mesh].stored.count ? m->meshes[mesh].record->storage : NORMA_NORMALS_NONE;
}
int WEB_EXPORT(model_is_decimated)(const model *m, uint32_t mesh) {
    return m->meshes[mesh].record->decimated != 0;
}
const float *WEB_EXPORT(model_colour)(const model *m, uint32_t mesh) {
    return m->meshes[mesh].record->colour;
}
/* Centre and radius: four numbers. */
void WEB_EXPORT(model_ball)(const model *m, uint32_t mesh, double ball[4]) {
    memcpy(ball, m->meshes[mesh].centre, 3 * sizeof *ball);
    ball[3] = m->meshes[mesh].radius;
}
const float *WEB_EXPORT(model_draw_positions)(const model *m, uint32_t mesh) {
    return m->meshes[mesh].draw_positions;
}
const float *WEB_EXPORT(model_draw_normals)(const model *m, uint32_t mesh) {
    return m->meshes[mesh].draw_normals;
}
const float *WEB_EXPORT(model_draw_values)(const model *m, uint32_t mesh) {
    return m->meshes[mesh].draw_values;
}
