/* ply_describe.c: what is in a binary PLY, counted piece by piece. */
#include "io/large/passes.h"
#include "io/large/ply_survey.h"

static norma_document_result include_vertices(
    large_ply *ply, norma_large_description *description) {
    const float *floats = (const float *)(const void *)ply->scratch;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = 0; first < ply->vertices && !result; first += LARGE_BLOCK) {
        const size_t left = ply->vertices - first, count = left < LARGE_BLOCK ? left : LARGE_BLOCK;
        result = norma_large_ply_positions(ply, first, count, ply->scratch);
        for (size_t i = 0; i < count && !result; ++i) {
            double at[3];
            for (size_t k = 0; k < 3; ++k)
                at[k] = ply->single ? (double)floats[3 * i + k] : ply->scratch[3 * i + k];
            norma_large_include(description, at);
        }
        if (!result) result = norma_large_tell(ply->file, (double)first / (double)ply->vertices);
    }
    return result;
}

norma_document_result norma_large_describe_ply(
    large_file *file, norma_large_description *description) {
    large_ply ply;
    large_survey survey = {0};
    norma_document_result result = norma_large_ply_open(file, &ply);
    norma_large_stage(file, 0, 0.7);
    if (!result) result = norma_large_survey(&ply, &survey);
    norma_large_stage(file, 0.7, 1);
    if (!result) result = include_vertices(&ply, description);
    if (!result) {
        norma_mesh_info info = {.encoding = ""};
        file->document->functions->mesh_info(file->document, 0, &info);
        description->vertices = ply.vertices;
        description->faces = (size_t)ply.faces;
        description->triangles = (size_t)survey.triangles;
        description->normals = info.normals;
        description->encoding = info.encoding;
    }
    norma_large_survey_close(&ply, &survey);
    norma_large_ply_close(&ply);
    return result;
}
