/* workshop.c: a file of the page as a document: packed for the picture, fixed or computed anew, and
 * written, with the same calls as norma check --fix and norma compute, so that the bytes are
 * theirs. */
#include "model.h"
#include "../../package/wasm/exports.h"
#include <math.h>
#include <norma/check.h>
#include <string.h>

/* path: of the page's files. NULL: error says why. */
norma_document *WEB_EXPORT(document_open)(const char *path, norma_document_error *error) {
    norma_document *document = NULL;
    const norma_document_options options = {.struct_size = sizeof options, .lenient = 1};
    *error = (norma_document_error){0};
    return norma_document_open(path, &options, &document, error) ? NULL : document;
}

void WEB_EXPORT(document_close)(norma_document *document) { norma_document_close(document); }

/* unchecked: without what norma check says, which takes longer than all else. NULL: error says why.
 */
unsigned char *WEB_EXPORT(document_pack)(
    norma_document *document, int unchecked, size_t *size, norma_document_error *error) {
    view_pack pack = {0};
    *error = (norma_document_error){0};
    const view_pack_options options = {.threads = 1, .unchecked = unchecked};
    const norma_document_result result = view_pack_document(document, &options, &pack, error);
    *size = pack.size;
    return result ? NULL : pack.bytes;
}

/* numbers: whether anything changed. Nonzero: error says why. */
int WEB_EXPORT(document_fix)(
    norma_document *document, int unsafe, double numbers[1], norma_document_error *error) {
    const norma_check_options options = {
        .struct_size = sizeof options, .threads = 1, .fix_from = NORMA_SEVERITY_WARNING};
    norma_fix_summary summary = {0};
    *error = (norma_document_error){0};
    const norma_document_result result =
        norma_fix_document(document, &options, unsafe, &summary, error);
    numbers[0] = summary.changed;
    return (int)result;
}

/* Whether a program can fix what a rule finds: a norma_fix. */
int WEB_EXPORT(rule_fix)(const char *id) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    for (size_t i = 0; i < count; ++i)
        if (strcmp(rules[i].id, id) == 0) return (int)rules[i].fix;
    return NORMA_FIX_NONE;
}

/* crease_deg: NaN: as norma compute does it without --crease. numbers: whether anything changed,
 * vertices before and after. */
int WEB_EXPORT(document_compute)(norma_document *document, norma_weight weight, norma_weld weld,
    double crease_deg, double numbers[3], norma_document_error *error) {
    const int by_crease = !isnan(crease_deg);
    const norma_compute_options options = {.struct_size = sizeof options,
        .shading = by_crease ? NORMA_SHADING_CREASE : NORMA_SHADING_DEFAULT,
        .crease_angle_rad = by_crease ? crease_deg * (3.14159265358979323846 / 180) : 0,
        .weight = weight,
        .weld = weld,
        .threads = 1};
    norma_compute_summary summary = {0};
    *error = (norma_document_error){0};
    const norma_document_result result =
        norma_document_compute(document, &options, &summary, error);
    numbers[0] = summary.changed;
    numbers[1] = (double)summary.vertices_before;
    numbers[2] = (double)summary.vertices_after;
    return (int)result;
}

/* Into the page's files, a .gltf with its buffers. */
int WEB_EXPORT(document_save)(
    norma_document *document, const char *path, norma_document_error *error) {
    const norma_save_options options = {.struct_size = sizeof options};
    *error = (norma_document_error){0};
    return (int)norma_document_save(document, path, &options, error);
}

size_t WEB_EXPORT(document_note_count)(const norma_document *document) {
    return norma_document_note_count(document);
}
const char *WEB_EXPORT(document_note)(const norma_document *document, size_t index) {
    return norma_document_note(document, index);
}
