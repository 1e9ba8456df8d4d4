/* package.c: the parts of a 3MF in its zip, found by their relationships. Source: ECMA-376 part 2
 * (Open Packaging Conventions); 3MF Core 1.3, chapter 2. */
#include "io/3mf/3mf.h"
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

norma_document_result norma_3mf_open(norma_document *document, norma_document_error *error) {
    zip_archive *zip = &((tmf_state *)document->state)->zip;
    const char *wrong = norma_zip_read(document->source.data, document->source.size, zip);
    return wrong ? fail_package(document, error, "is not the zip that a 3MF is: ", wrong)
                 : NORMA_DOCUMENT_OK;
}

void norma_3mf_close(norma_document *document) {
    zip_archive *zip = &((tmf_state *)document->state)->zip;
    free(zip->members);
    *zip = (zip_archive){.members = NULL};
}

static norma_document_result fail_part(const norma_document *document, norma_document_error *error,
    const char *name, size_t length, const char *wrong) {
    char part[300];
    snprintf(part, sizeof part, "the part %.*s ", (int)(length < 200 ? length : 200), name);
    return fail_package(document, error, part, wrong);
}

/* The contents of a member, to be freed. */
static norma_document_result unpack_member(norma_document *document, const char *name,
    size_t length, char **text, size_t *size, norma_document_error *error) {
    tmf_state *state = document->state;
    const char *wrong = NULL;
    const uint64_t most = (uint64_t)document->source.size * UNPACKED_A_BYTE + FREE_BYTES;
    const size_t member = norma_zip_find(&state->zip, name, length);
    *text = NULL;
    if (member == SIZE_MAX) return fail_part(document, error, name, length, "is missing");
    if (state->zip.members[member].size > most - state->unpacked)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "the part %.*s unpacks to far more than the file; at most %d bytes are read for each "
            "byte of it",
            (int)(length < 200 ? length : 200), name, UNPACKED_A_BYTE);
    *size = (size_t)state->zip.members[member].size;
    state->unpacked += *size;
    *text = norma_zip_unpack(&state->zip, member, &wrong);
    return *text ? NORMA_DOCUMENT_OK : fail_part(document, error, name, length, wrong);
}

norma_document_result norma_3mf_add_part(norma_document *document, const char *name, size_t length,
    uint32_t *part, norma_document_error *error) {
    tmf_state *state = document->state;
    if (length && name[0] == '/') ++name, --length;
    const size_t found = norma_zip_find(&state->zip, name, length);
    if (found == SIZE_MAX) return fail_part(document, error, name, length, "is missing");
    zip_member *member = &state->zip.members[found];
    if (member->part) { /* its number, from 1 */
        *part = member->part - 1;
        return NORMA_DOCUMENT_OK;
    }
    tmf_part *added =
        norma_io_add(&state->parts, &state->part_capacity, &state->part_count, sizeof *added);
    if (!added) return norma_document_fail_memory(document, error);
    *added = (tmf_part){.name = norma_io_copy_text(name, length)};
    member->part = (uint32_t)state->part_count;
    *part = member->part - 1;
    return added->name ? NORMA_DOCUMENT_OK : norma_document_fail_memory(document, error);
}

norma_document_result norma_3mf_unpack(
    norma_document *document, uint32_t number, norma_document_error *error) {
    tmf_part *part = &((tmf_state *)document->state)->parts[number];
    free(part->text);
    return unpack_member(document, part->name, strlen(part->name), &part->text, &part->size, error);
}

/* ---- relationships */

#define TMF_RELATION "http://schemas.microsoft.com/3dmanufacturing/2013/01/"

enum { TMF_MODEL_RELATION, TMF_TICKET_RELATION, TMF_RELATIONS = 4 };

/* What a part names must be in the package (chapter 2.1.1), if it is of one of these types. */
static const char *const RELATIONS[TMF_RELATIONS] = {TMF_RELATION "3dmodel",
    TMF_RELATION "printticket", TMF_RELATION "3dtexture",
    "http://schemas.openxmlformats.org/package/2006/relationships/metadata/thumbnail"};

typedef struct relationships {
    const zip_archive *zip;
    const char *source; /* the part that has them; "": the package */
    size_t counts[TMF_RELATIONS];
    char model[512];
    int is_outside;  /* what wrong says is that it names something outside */
    char wrong[600]; /* "": nothing */
} relationships;

/* Targets are relative to the folder of their source. Those with escapes, dots, or letters that
 * member names escape, are not looked for. */
static void find_target(relationships *found, const char *target, int is_external) {
    const char *slash = strrchr(found->source, '/');
    const size_t folder = slash && target[0] != '/' ? (size_t)(slash + 1 - found->source) : 0;
    char name[600];
    const int length = snprintf(
        name, sizeof name, "%.*s%s", (int)folder, found->source, target + (*target == '/'));
    int plain =
        (size_t)length < sizeof name && !name[strcspn(name, "%?#\\")] && !strstr(name, "./");
    for (size_t i = 0; plain && name[i]; ++i) plain = name[i] > ' ' && name[i] < 0x7f;
    if (is_external)
        snprintf(found->wrong, sizeof found->wrong,
            "%.400s lies outside the package; it is not opened", target);
    else if (plain && norma_zip_find(found->zip, name, (size_t)length) == SIZE_MAX)
        snprintf(found->wrong, sizeof found->wrong,
            "names the part %.400s, which is not in the package", name);
    else
        return;
    found->is_outside = is_external;
}

static void add_relationship(relationships *found, const char *name, const char **attributes) {
    const char *type = "", *target = "", *mode = "";
    size_t kind = 0;
    if (strcmp(name, "Relationship") != 0) return;
    for (; attributes[0]; attributes += 2) {
        if (strcmp(attributes[0], "Type") == 0) type = attributes[1];
        if (strcmp(attributes[0], "Target") == 0) target = attributes[1];
        if (strcmp(attributes[0], "TargetMode") == 0) mode = attributes[1];
    }
    while (kind < TMF_RELATIONS && strcmp(type, RELATIONS[kind]) != 0) ++kind;
    if (kind == TMF_RELATIONS) return;
    ++found->counts[kind];
    find_target(found, target, strcmp(mode, "External") == 0);
    if (kind == TMF_MODEL_RELATION) snprintf(found->model, sizeof found->model, "%s", target);
}

static void count_relationships(relationships *found) {
    const size_t models = found->counts[TMF_MODEL_RELATION];
    const size_t tickets = found->counts[TMF_TICKET_RELATION];
    if (!found->source[0] && models != 1)
        snprintf(found->wrong, sizeof found->wrong, "names %zu models; a 3MF has one", models);
    else if (tickets > 1)
        snprintf(found->wrong, sizeof found->wrong,
            "names %zu print tickets; a model has one at most", tickets);
    else
        return;
    found->is_outside = 0;
}

static norma_document_result read_relationships(norma_document *document, const char *where,
    const char *text, size_t size, relationships *found, norma_document_error *error) {
    xml_reader xml = {.text = text, .size = size};
    xml_event event = XML_BEGINS;
    while (event < XML_DONE) {
        event = norma_xml_next(&xml);
        if (event == XML_BEGINS) add_relationship(found, xml.name, xml.attributes);
    }
    norma_xml_free(&xml);
    if (event == XML_NO_MEMORY) return norma_document_fail_memory(document, error);
    if (event == XML_DONE) count_relationships(found);
    if (event == XML_DONE && !found->wrong[0]) return NORMA_DOCUMENT_OK;
    const norma_document_result kind = event == XML_DONE && found->is_outside
                                           ? NORMA_DOCUMENT_ERROR_REFUSED
                                           : NORMA_DOCUMENT_ERROR_MALFORMED;
    return norma_document_fail(
        document, error, kind, where, "%s", event == XML_DONE ? found->wrong : xml.wrong);
}

/* Those of a part stand beside it, in _rels; only the package must have some. */
static norma_document_result find_relationships(
    norma_document *document, relationships *found, norma_document_error *error) {
    const char *slash = strrchr(found->source, '/');
    const size_t folder = slash ? (size_t)(slash + 1 - found->source) : 0;
    char where[600], *text = NULL;
    size_t size = 0;
    const int length = snprintf(where, sizeof where, "%.*s_rels/%s.rels", (int)folder,
        found->source, found->source + folder);
    norma_document_result result = NORMA_DOCUMENT_OK;
    found->zip = &((tmf_state *)document->state)->zip;
    if (!found->source[0] || ((size_t)length < sizeof where &&
                                 norma_zip_find(found->zip, where, (size_t)length) != SIZE_MAX)) {
        result = unpack_member(document, where, (size_t)length, &text, &size, error);
        if (!result) result = read_relationships(document, where, text, size, found, error);
    }
    free(text);
    return result;
}

norma_document_result norma_3mf_find_model(norma_document *document, norma_document_error *error) {
    relationships found = {.source = ""};
    uint32_t part;
    const norma_document_result result = find_relationships(document, &found, error);
    return result ? result
                  : norma_3mf_add_part(document, found.model, strlen(found.model), &part, error);
}

norma_document_result norma_3mf_check_relationships(
    norma_document *document, uint32_t part, norma_document_error *error) {
    relationships found = {.source = ((tmf_state *)document->state)->parts[part].name};
    return find_relationships(document, &found, error);
}

norma_document_result norma_3mf_pack(norma_document *document, growing_bytes *texts,
    growing_bytes *package, norma_document_error *error) {
    const tmf_state *state = document->state;
    growing_bytes *contents = norma_io_allocate(state->zip.count + 1, sizeof *contents);
    if (!contents) return norma_document_fail_memory(document, error);
    for (size_t i = 0; i < state->part_count; ++i) {
        const char *name = state->parts[i].name;
        if (texts[i].size) contents[norma_zip_find(&state->zip, name, strlen(name))] = texts[i];
    }
    const char *wrong = norma_zip_replace(&state->zip, contents, package);
    free(contents);
    return wrong ? fail_package(document, error, "cannot be written: ", wrong) : NORMA_DOCUMENT_OK;
}
