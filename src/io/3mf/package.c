/* package.c: the parts of a 3MF in its zip, found by their relationships. Source: ECMA-376 part 2
 * (Open Packaging Conventions); 3MF Core 1.3, chapter 2. */
#include "io/3mf/3mf.h"
#include "io/3mf/xml.h"
#include "io/3mf/zip.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* XML packs to a tenth or a thirtieth; what unpacks to far more is made to fill memory. */
enum { UNPACKED_A_BYTE = 100, FREE_BYTES = 1 << 20 };

static norma_document_result fail_package(const norma_document *document,
    norma_document_error *error, const char *part, const char *wrong) {
    return wrong[0] ? norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_MALFORMED, NULL,
                          "%s%s", part, wrong)
                    : norma_document_fail_memory(document, error);
}

static norma_document_result open_package(
    norma_document *document, zip_archive *zip, norma_document_error *error) {
    const char *wrong = norma_zip_read(document->source.data, document->source.size, zip);
    return wrong ? fail_package(document, error, "is not the zip that a 3MF is: ", wrong)
                 : NORMA_DOCUMENT_OK;
}

/* The contents of a member, to be freed. */
static norma_document_result unpack_member(norma_document *document, const char *name,
    size_t length, char **text, size_t *size, norma_document_error *error) {
    tmf_state *state = document->state;
    zip_archive zip;
    char part[300];
    const char *wrong = NULL;
    const uint64_t most = (uint64_t)document->source.size * UNPACKED_A_BYTE + FREE_BYTES;
    norma_document_result result = open_package(document, &zip, error);
    const size_t member = result ? 0 : norma_zip_find(&zip, name, length);
    snprintf(part, sizeof part, "the part %.*s ", (int)(length < 200 ? length : 200), name);
    *text = NULL;
    if (!result && member == SIZE_MAX) result = fail_package(document, error, part, "is missing");
    if (!result && zip.members[member].size > most - state->unpacked)
        result = norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "%sunpacks to far more than the file; at most %d bytes are read for each byte of it",
            part, UNPACKED_A_BYTE);
    if (!result) {
        *size = (size_t)zip.members[member].size;
        state->unpacked += *size;
        *text = norma_zip_unpack(&zip, member, &wrong);
        if (!*text) result = fail_package(document, error, part, wrong);
    }
    free(zip.members);
    return result;
}

norma_document_result norma_3mf_add_part(norma_document *document, const char *name, size_t length,
    uint32_t *part, norma_document_error *error) {
    tmf_state *state = document->state;
    if (length && name[0] == '/') ++name, --length;
    for (*part = 0; *part < state->part_count; ++*part)
        if (strlen(state->parts[*part].name) == length &&
            memcmp(state->parts[*part].name, name, length) == 0)
            return NORMA_DOCUMENT_OK;
    tmf_part *parts =
        norma_io_grow(state->parts, &state->part_capacity, state->part_count + 1, sizeof *parts);
    if (!parts) return norma_document_fail_memory(document, error);
    state->parts = parts;
    parts[state->part_count] = (tmf_part){.name = norma_io_copy_text(name, length)};
    return parts[state->part_count++].name ? NORMA_DOCUMENT_OK
                                           : norma_document_fail_memory(document, error);
}

norma_document_result norma_3mf_unpack(
    norma_document *document, uint32_t number, norma_document_error *error) {
    tmf_part *part = &((tmf_state *)document->state)->parts[number];
    free(part->text);
    return unpack_member(document, part->name, strlen(part->name), &part->text, &part->size, error);
}

/* ---- which part is the model */

typedef struct relationships {
    char target[512];
    size_t models;
    int is_external;
} relationships;

static void add_relationship(relationships *found, const char *name, const char **attributes) {
    static const char model[] = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
    const char *type = "", *target = "", *mode = "";
    if (strcmp(name, "Relationship") != 0) return;
    for (; attributes[0]; attributes += 2) {
        if (strcmp(attributes[0], "Type") == 0) type = attributes[1];
        if (strcmp(attributes[0], "Target") == 0) target = attributes[1];
        if (strcmp(attributes[0], "TargetMode") == 0) mode = attributes[1];
    }
    if (strcmp(type, model) != 0) return;
    ++found->models;
    found->is_external = strcmp(mode, "External") == 0;
    snprintf(found->target, sizeof found->target, "%s", target);
}

static norma_document_result read_relationships(norma_document *document, const char *text,
    size_t size, relationships *found, norma_document_error *error) {
    xml_reader xml = {.text = text, .size = size};
    xml_event event = XML_BEGINS;
    while (event < XML_DONE) {
        event = norma_xml_next(&xml);
        if (event == XML_BEGINS) add_relationship(found, xml.name, xml.attributes);
    }
    norma_xml_free(&xml);
    if (event == XML_NO_MEMORY) return norma_document_fail_memory(document, error);
    if (event != XML_DONE)
        return norma_document_fail(
            document, error, NORMA_DOCUMENT_ERROR_MALFORMED, "_rels/.rels", "%s", xml.wrong);
    if (found->models != 1)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_MALFORMED, "_rels/.rels",
            "names %zu models; a 3MF has one", found->models);
    if (found->is_external)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_REFUSED, "_rels/.rels",
            "the model lies outside the package; it is not opened");
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_3mf_find_model(norma_document *document, norma_document_error *error) {
    static const char name[] = "_rels/.rels";
    relationships found = {.models = 0};
    char *text = NULL;
    size_t size = 0;
    uint32_t part;
    norma_document_result result =
        unpack_member(document, name, sizeof name - 1, &text, &size, error);
    if (!result) result = read_relationships(document, text, size, &found, error);
    free(text);
    return result ? result
                  : norma_3mf_add_part(document, found.target, strlen(found.target), &part, error);
}

norma_document_result norma_3mf_pack(norma_document *document, growing_bytes *texts,
    growing_bytes *package, norma_document_error *error) {
    const tmf_state *state = document->state;
    zip_archive zip;
    norma_document_result result = open_package(document, &zip, error);
    growing_bytes *contents = result ? NULL : norma_io_allocate(zip.count + 1, sizeof *contents);
    if (!result && !contents) result = norma_document_fail_memory(document, error);
    for (size_t i = 0; !result && i < state->part_count; ++i) {
        const char *name = state->parts[i].name;
        if (texts[i].size) contents[norma_zip_find(&zip, name, strlen(name))] = texts[i];
    }
    const char *wrong = result ? NULL : norma_zip_replace(&zip, contents, package);
    if (wrong) result = fail_package(document, error, "cannot be written: ", wrong);
    free(contents);
    free(zip.members);
    return result;
}
