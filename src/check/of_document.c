/* of_document.c: the rules over an open document: each mesh that it could read, then its nodes and skins; what it could not read is told of. */
#include "findings.h"
#include <stdlib.h>
#include <string.h>

static norma_document_result fail(norma_document_error *error, norma_result result) {
    norma_document_result as = result == NORMA_CANCELLED           ? NORMA_DOCUMENT_CANCELLED
                               : result == NORMA_ERROR_MEMORY      ? NORMA_DOCUMENT_ERROR_MEMORY
                               : result == NORMA_ERROR_ARGUMENT    ? NORMA_DOCUMENT_ERROR_ARGUMENT
                                                                   : NORMA_DOCUMENT_ERROR_MALFORMED;
    if (error) {
        error->result = as;
        norma_check_message(error->message, "cannot be checked: %s", norma_result_text(result));
    }
    return as;
}

static norma_document_result check_mesh_of(check_run *run, norma_document *document, size_t index, norma_document_error *error) {
    norma_check_mesh mesh = {0};
    norma_document_result result = norma_document_mesh_info(document, index, &mesh.info);
    if (!result && mesh.info.not_read)
        return NORMA_DOCUMENT_OK;
    if (!result)
        result = norma_document_mesh_data(document, index, &mesh.data, error);
    if (!result)
        result = norma_document_mesh_attributes(document, index, &mesh.attributes, error);
    if (!result && mesh.attributes.material < norma_document_material_count(document))
        result = norma_document_material_info(document, mesh.attributes.material, &mesh.material);
    norma_result checked = result ? NORMA_OK : norma_check_run_mesh(run, &mesh);
    return checked ? fail(error, checked) : result;
}

norma_document_result norma_check_document(norma_document *document, const norma_check_options *options, norma_findings **findings, norma_document_error *error) {
    check_run run;
    if (!document || !findings)
        return fail(error, NORMA_ERROR_ARGUMENT);
    norma_result begun = norma_check_begin(&run, options, norma_document_format(document));
    if (begun)
        return fail(error, begun);
    norma_document_result result = NORMA_DOCUMENT_OK;
    size_t count = norma_document_mesh_count(document);
    for (size_t i = 0; i < count && !result; i++) {
        norma_core_stage(&run.call, (double)i / (double)count, (double)(i + 1) / (double)count);
        result = check_mesh_of(&run, document, i, error);
    }
    if (result)
        norma_check_abandon(&run);
    else
        *findings = norma_check_finish(&run);
    return result;
}

norma_findings *norma_check_unreadable(const norma_document_error *error, norma_file_format format, const norma_check_options *options) {
    check_run run;
    if (!error || norma_check_begin(&run, options, format))
        return NULL;
    const check_place whole = {.order = 0, .where = "", .label = ""};
    norma_result result = norma_check_add_one(&run, &whole, NULL, RULE_N001, NORMA_SEVERITY_ERROR, CHECK_NOWHERE, error->message);
    if (result)
        norma_check_abandon(&run);
    return result ? NULL : norma_check_finish(&run);
}
