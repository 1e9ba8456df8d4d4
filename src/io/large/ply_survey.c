/* ply_survey.c: the faces of a large PLY, gone through once. */
#include "io/large/ply_survey.h"

/* begun and ended hold, until all faces are counted, those of the stretch before. */
static void count_face(large_survey *survey, const uint32_t *corners, size_t count) {
    size_t seen[3], distinct = 0, least = SIZE_MAX, most = 0;
    for (size_t k = 0; k < count; ++k) {
        const size_t stretch = corners[k] / survey->stretch;
        int known = 0;
        for (size_t i = 0; i < distinct; ++i) known |= seen[i] == stretch;
        if (known || distinct == 3) continue;
        seen[distinct++] = stretch;
        ++survey->touching[stretch];
        least = stretch < least ? stretch : least;
        most = stretch > most ? stretch : most;
    }
    for (size_t i = 0; i < distinct && distinct > 1; ++i) ++survey->crossing[seen[i]];
    if (!distinct) return;
    ++survey->begun[least + 1];
    ++survey->ended[most + 1];
}

static void count_chunk(
    const large_faces *faces, uint64_t first, large_survey *survey, large_chunk *chunk) {
    for (size_t i = 0; i < faces->corner_count; ++i) {
        const uint32_t vertex = faces->corners[i];
        chunk->least = vertex < chunk->least ? vertex : chunk->least;
        chunk->most = vertex > chunk->most ? vertex : chunk->most;
    }
    for (size_t i = 0; i < faces->count; ++i) {
        const size_t corners = faces->starts[i + 1] - faces->starts[i];
        if (!corners && survey->empty.count++ == 0) survey->empty.first = (size_t)first + i;
        survey->polygons |= corners != 3;
        survey->triangles += corners > 2 ? corners - 2 : 0;
        count_face(survey, faces->corners + faces->starts[i], corners);
    }
    survey->corners += faces->corner_count;
}

static void sum_stretches(large_survey *survey) {
    for (size_t i = 1; i <= survey->stretches; ++i) {
        survey->begun[i] += survey->begun[i - 1];
        survey->ended[i] += survey->ended[i - 1];
    }
}

static int open_survey(large_ply *ply, large_survey *survey) {
    large_budget *budget = &ply->file->budget;
    survey->stretch = ply->vertices / LARGE_STRETCHES + 1;
    survey->stretches = ply->vertices / survey->stretch + 1;
    survey->chunk_count = (size_t)(ply->faces / LARGE_CHUNK) + (ply->faces % LARGE_CHUNK != 0);
    survey->chunks = norma_large_take(budget, survey->chunk_count, sizeof *survey->chunks);
    survey->touching = norma_large_take_zeroed(budget, survey->stretches, sizeof *survey->touching);
    survey->crossing = norma_large_take_zeroed(budget, survey->stretches, sizeof *survey->crossing);
    survey->begun = norma_large_take_zeroed(budget, survey->stretches + 1, sizeof *survey->begun);
    survey->ended = norma_large_take_zeroed(budget, survey->stretches + 1, sizeof *survey->ended);
    return survey->chunks && survey->touching && survey->crossing && survey->begun && survey->ended;
}

norma_document_result norma_large_survey(large_ply *ply, large_survey *survey) {
    *survey = (large_survey){.end = ply->face ? ply->face->begin : 0, .empty = {0, SIZE_MAX}};
    norma_document_result result =
        open_survey(ply, survey) ? NORMA_DOCUMENT_OK : norma_large_fail_memory(ply->file);
    for (size_t i = 0; i < survey->chunk_count && !result; ++i) {
        survey->chunks[i] = (large_chunk){survey->end, UINT32_MAX, 0};
        result = norma_large_ply_chunk(
            ply, (uint64_t)i * LARGE_CHUNK, norma_large_chunk_faces(ply, i), &survey->end);
        if (!result)
            count_chunk(&ply->chunk, (uint64_t)i * LARGE_CHUNK, survey, &survey->chunks[i]);
        if (!result && i % 64 == 0)
            result = norma_large_tell(ply->file, (double)i / (double)survey->chunk_count);
    }
    if (!result && survey->begun) sum_stretches(survey);
    return result;
}

void norma_large_survey_close(large_ply *ply, large_survey *survey) {
    large_budget *budget = &ply->file->budget;
    norma_large_give(budget, survey->chunks, survey->chunk_count, sizeof *survey->chunks);
    norma_large_give(budget, survey->touching, survey->stretches, sizeof *survey->touching);
    norma_large_give(budget, survey->crossing, survey->stretches, sizeof *survey->crossing);
    norma_large_give(budget, survey->begun, survey->stretches + 1, sizeof *survey->begun);
    norma_large_give(budget, survey->ended, survey->stretches + 1, sizeof *survey->ended);
    *survey = (large_survey){0};
}
