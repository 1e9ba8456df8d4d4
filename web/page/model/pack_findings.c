/* pack_findings.c: what norma check finds in a document, as records of a pack: text, and places
 * that the page goes to. */
#include "model_pack.h"
#include <norma/check.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_SAMPLES = 20000 }; /* of one finding */

typedef struct finding_place {
    uint32_t mesh, draw;
} finding_place;

static uint32_t append_text(view_pack *pack, const char *text) {
    return view_pack_append(pack, text, strlen(text) + 1, 1);
}

/* Numbers beyond 32 bits there are none of in a pack. */
static uint32_t number_of(size_t number) {
    return number < VIEW_PACK_NONE ? (uint32_t)number : VIEW_PACK_NONE;
}

/* Where a finding is: a mesh by its record, a node by the first of what it draws. */
static finding_place find_place(norma_document *document, const uint32_t *record_of,
    const uint32_t *draw_of_node, const view_pack *pack, const view_pack_head *head,
    const char *where) {
    norma_mesh_info mesh;
    norma_node_info node;
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i)
        if (norma_document_mesh_info(document, i, &mesh) == NORMA_DOCUMENT_OK &&
            strcmp(mesh.where, where) == 0)
            return (finding_place){record_of[i], VIEW_PACK_NONE};
    for (size_t n = 0; n < norma_document_node_count(document); ++n)
        if (norma_document_node_info(document, n, &node) == NORMA_DOCUMENT_OK &&
            strcmp(node.where, where) == 0 && draw_of_node[n] != VIEW_PACK_NONE) {
            const view_pack_draw *draws =
                (const view_pack_draw *)(const void *)(pack->bytes + head->draws);
            return (finding_place){draws[draw_of_node[n]].mesh, draw_of_node[n]};
        }
    return (finding_place){VIEW_PACK_NONE, VIEW_PACK_NONE};
}

static view_pack_sample sample_of(const norma_sample *sample) {
    return (view_pack_sample){.face = number_of(sample->face),
        .vertex = number_of(sample->vertex),
        .normal = number_of(sample->normal)};
}

static int is_same(view_pack_sample a, view_pack_sample b) {
    return a.face == b.face && a.vertex == b.vertex && a.normal == b.normal;
}

/* The worst one first, and not again. */
static uint32_t append_samples(view_pack *pack, const norma_finding *finding, uint32_t *count) {
    view_pack_sample *samples = malloc((finding->sample_count + 1) * sizeof *samples);
    if (!samples) {
        pack->failed = 1;
        return 0;
    }
    *count = 0;
    samples[(*count)++] = sample_of(&finding->worst);
    for (size_t i = 0; i < finding->sample_count; ++i) {
        samples[*count] = sample_of(&finding->samples[i]);
        *count += !is_same(samples[*count], samples[0]);
    }
    const uint32_t at = view_pack_append(pack, samples, *count, sizeof *samples);
    free(samples);
    return at;
}

static view_pack_finding pack_finding(
    view_pack *pack, const norma_finding *finding, finding_place place, int whole) {
    const norma_sample *at =
        finding->worst.has_position || !finding->sample_count ? &finding->worst : finding->samples;
    view_pack_finding record = {.severity = (uint32_t)finding->severity,
        .mesh = place.mesh,
        .draw = place.draw,
        .has_position = at->has_position != 0};
    memcpy(record.position, at->position, sizeof record.position);
    record.count = (double)finding->count;
    record.worst = finding->worst_value;
    record.id = append_text(pack, finding->rule->id);
    record.name = append_text(pack, finding->rule->name);
    record.unit = append_text(pack, finding->unit);
    record.label = append_text(pack, finding->label);
    record.message = append_text(pack, finding->message);
    if (whole) record.samples = append_samples(pack, finding, &record.sample_count);
    return record;
}

norma_document_result view_pack_findings(norma_document *document, const uint32_t *record_of,
    const uint32_t *draw_of_node, const view_pack_mesh *meshes, uint32_t threads, view_pack *pack,
    view_pack_head *head, norma_document_error *error) {
    const norma_check_options options = {.struct_size = sizeof options,
        .max_samples = MOST_SAMPLES,
        .whole_components = 1,
        .threads = threads};
    norma_findings *findings = NULL;
    norma_document_result result = norma_check_document(document, &options, &findings, error);
    if (result == NORMA_DOCUMENT_CANCELLED || result == NORMA_DOCUMENT_ERROR_MEMORY) return result;
    if (result) return NORMA_DOCUMENT_OK; /* what cannot be judged can be drawn */
    const size_t count = norma_findings_count(findings);
    view_pack_finding *records = calloc(count + 1, sizeof *records);
    for (size_t i = 0; i < count && records && !pack->failed; ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        const finding_place place =
            find_place(document, record_of, draw_of_node, pack, head, finding->where);
        records[i] = pack_finding(
            pack, finding, place, place.mesh == VIEW_PACK_NONE || !meshes[place.mesh].decimated);
    }
    if (records) {
        head->finding_count = number_of(count);
        head->findings = view_pack_append(pack, records, count, sizeof *records);
    } else
        pack->failed = 1;
    free(records);
    norma_findings_free(findings);
    return NORMA_DOCUMENT_OK;
}
