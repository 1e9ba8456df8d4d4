/* fuzz_check.c: norma_orient and the rules over any arrays; check, fix and edit over any document,
 * which can then still be written, and read again. The first byte says which; of a document the
 * next two say its format and the options, and the rest is the file. */
#include "fix_judge.h"
#include "made_mesh.h"
#include "mutate.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HEAD = 4 };

/* ---- orient */

static void orient(fuzz_bytes *bytes) {
    made_options made;
    norma_orient_report report, other_report;
    uint8_t kind = fuzz_u8(bytes);
    made_options_take(bytes, &made);
    made_mesh *mesh = made_mesh_take(bytes);
    size_t faces = mesh->faces < 4096 ? mesh->faces : 0;
    uint8_t *reverse = calloc(faces + 1, 1), *other = calloc(faces + 1, 1);
    norma_orient_open open = kind & 1 ? NORMA_ORIENT_OPEN_BY_RAYS : NORMA_ORIENT_OPEN_KEPT;
    norma_result result = norma_orient(&mesh->mesh, open, &made.options, reverse, faces, &report);
    fuzz_allocator_finish(&made.allocator);
    if (!result && (report.closed + report.open + report.one_sided != report.parts ||
                       isnan(report.least_confidence)))
        fuzz_fail("%zu parts: %zu closed, %zu open, %zu one-sided; confidence %g", report.parts,
            report.closed, report.open, report.one_sided, report.least_confidence);
    if (!result) {
        norma_options one = {
            .weld = made.options.weld, .weld_distance = made.options.weld_distance, .threads = 1};
        if (norma_orient(&mesh->mesh, open, &one, other, faces, &other_report) != result ||
            memcmp(reverse, other, faces) != 0 ||
            memcmp(&report, &other_report, sizeof report) != 0)
            fuzz_fail("another answer than on one thread");
    }
    free(reverse);
    free(other);
    made_mesh_free(mesh);
}

/* ---- findings */

static void read_findings(const norma_findings *findings) {
    size_t rules;
    norma_rules(&rules);
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *f = norma_findings_get(findings, i);
        if (!f || !f->rule || !f->message[0] || strchr(f->message, '\n') || f->count == 0 ||
            (f->sample_count && !f->samples) || f->severity == NORMA_SEVERITY_NONE)
            fuzz_fail("finding %zu says nothing", i);
        if (!f->where || !f->label || !f->unit || strlen(f->label) > 100000)
            fuzz_fail("finding %zu is nowhere", i);
    }
    if (norma_findings_get(findings, norma_findings_count(findings)))
        fuzz_fail("one finding too many");
}

static void scene(fuzz_bytes *bytes) {
    enum { MOST = 2 };
    made_mesh *made[MOST];
    void *blocks[MOST] = {0};
    norma_check_mesh meshes[MOST] = {0};
    size_t count = 1 + fuzz_u8(bytes) % MOST;
    uint8_t kind = fuzz_u8(bytes);
    for (size_t i = 0; i < count; ++i) {
        norma_check_mesh *m = &meshes[i];
        made[i] = made_mesh_take(bytes);
        m->data.mesh = made[i]->mesh;
        m->info = (norma_mesh_info){.name = "",
            .where = "",
            .encoding = kind & 1 ? "float" : "snorm8",
            .mesh = i,
            .vertices = made[i]->mesh.positions.count,
            .faces = made[i]->faces};
        m->info.normals = (norma_normal_storage)(kind / 2 % 4);
        size_t normals = m->info.normals == NORMA_NORMALS_PER_VERTEX   ? m->info.vertices
                         : m->info.normals == NORMA_NORMALS_PER_CORNER ? made[i]->mesh.corner_count
                         : m->info.normals                             ? made[i]->faces
                                                                       : 0;
        m->data.normals = made_view(bytes, normals < 4096 ? normals : 0, &blocks[i]);
        m->attributes =
            (norma_mesh_attributes){.material = SIZE_MAX, .tangent_encoding = "", .ignore = ""};
    }
    norma_check_scene whole = {
        .meshes = meshes, .mesh_count = count, .format = (norma_file_format)(kind >> 3 & 7)};
    norma_check_options options = {.struct_size = sizeof options,
        .strict = kind & 64,
        .profile = kind & 128 ? NORMA_CHECK_PROFILE_PRINT : NORMA_CHECK_PROFILE_AUTO};
    norma_findings *findings = NULL;
    norma_result result = norma_check_scene_run(&whole, &options, &findings);
    if (!result != (findings != NULL))
        fuzz_fail("result %d, and %s findings", (int)result, findings ? "with" : "no");
    if (!result) read_findings(findings);
    norma_findings_free(findings);
    for (size_t i = 0; i < count; ++i) {
        free(blocks[i]);
        made_mesh_free(made[i]);
    }
}

/* ---- documents */

static norma_file_format format_of(uint8_t byte) { return (norma_file_format)(1 + byte % 5); }

static norma_document *open(
    const uint8_t *bytes, size_t size, norma_file_format format, int lenient) {
    norma_document_options options = {
        .struct_size = sizeof options, .format = format, .threads = 1, .lenient = lenient};
    norma_document *document;
    return norma_document_open_memory(bytes, size, NULL, &options, &document, NULL) ? NULL
                                                                                    : document;
}

/* What a fix writes is judged by RULES.md, "What a fix may never do". */
static void check_and_fix(norma_document *document, const fuzz_bytes *file, uint8_t kind) {
    norma_check_options options = {.struct_size = sizeof options,
        .strict = kind & 1,
        .profile = (norma_check_profile)(kind / 2 % 3),
        .threads = kind & 8 ? 2 : 1};
    norma_findings *findings;
    norma_document_error error;
    if (norma_document_mesh_count(document) > 64) return;
    const norma_document_result result =
        norma_check_document(document, &options, &findings, &error);
    if (result == NORMA_DOCUMENT_ERROR_ARGUMENT)
        fuzz_fail("an argument error of our own making: %s", error.message);
    if (result) return;
    read_findings(findings);
    norma_findings_free(findings);
    /* A fix tries its plans: two seconds more than a check alone. The judge is not timed. */
    fuzz_meter_begin(4 * file->left + (2 << 17));
    const fix_verdict verdict =
        judge_fix("fuzz", (fix_file){file->at, file->left, norma_document_format(document)},
            &options, kind & 16, fuzz_meter_end);
    fflush(stdout);
    if (verdict.wrong) fuzz_fail("a fix does %zu things that it may never do", verdict.wrong);
}

/* What could be changed can be written, unless a buffer that checks have no use for is in a file;
 * and what is written can be read. */
static void write_and_read(norma_document *document, norma_file_format format) {
    fuzz_blob blob = {0};
    norma_document_error error = {0};
    if (!norma_document_write(document, fuzz_blob_write, &blob, &error)) {
        norma_document *again = open(blob.bytes, blob.size, format, 1);
        if (!again) fuzz_fail("what was written cannot be read");
        norma_document_close(again);
    } else if (error.result != NORMA_DOCUMENT_ERROR_MEMORY &&
               error.result != NORMA_DOCUMENT_ERROR_MALFORMED &&
               error.result != NORMA_DOCUMENT_ERROR_UNSUPPORTED &&
               error.result != NORMA_DOCUMENT_ERROR_REFUSED)
        fuzz_fail("not written: %s", error.message);
    free(blob.bytes);
}

static void *marks(fuzz_random *random, size_t count, size_t one_in) {
    uint8_t *m = calloc(count + 1, 1);
    for (size_t i = 0; i < count; ++i) m[i] = fuzz_random_below(random, one_in) == 0;
    return m;
}

static void fill_edit(
    norma_document *document, size_t mesh, fuzz_random *random, norma_mesh_edit *edit) {
    norma_mesh_data data;
    if (norma_document_mesh_data(document, mesh, &data, NULL)) return;
    size_t faces = data.mesh.face_starts ? data.mesh.face_count : data.mesh.corner_count / 3,
           kinds = fuzz_random_u32(random);
    if (kinds & 1) edit->reverse_faces = marks(random, faces, 2);
    if (kinds & 2) edit->drop_faces = marks(random, faces, 3);
    if (kinds & 4) {
        float *normals = calloc(3 * data.normals.count + 3, sizeof *normals);
        for (size_t i = 0; i < data.normals.count; ++i)
            normals[3 * i + fuzz_random_below(random, 3)] = 1;
        edit->normals = normals;
        edit->set_normals = marks(random, data.normals.count, 2);
    }
    if (kinds & 8) {
        double *positions = calloc(3 * data.mesh.positions.count + 3, sizeof *positions);
        for (size_t i = 0; i < 3 * data.mesh.positions.count; ++i)
            positions[i] = (double)fuzz_random_u32(random) / 1e6;
        edit->positions = positions;
        edit->set_positions = marks(random, data.mesh.positions.count, 2);
    }
    if ((kinds & 48) == 48 && data.mesh.positions.count) {
        size_t count = edit->vertex_count =
            1 + fuzz_random_below(random, 2 * data.mesh.positions.count);
        uint32_t *sources = calloc(count, 4), *corners = calloc(data.mesh.corner_count + 1, 4);
        for (size_t i = 0; i < count; ++i)
            sources[i] = (uint32_t)fuzz_random_below(random, data.mesh.positions.count);
        for (size_t i = 0; i < data.mesh.corner_count; ++i)
            corners[i] = (uint32_t)fuzz_random_below(random, count);
        edit->source_vertices = sources;
        edit->new_corners = corners;
        free((void *)(uintptr_t)edit->normals), free((void *)(uintptr_t)edit->positions),
            free((void *)(uintptr_t)edit->set_normals),
            free((void *)(uintptr_t)edit->set_positions);
        edit->normals = NULL;
        edit->positions = NULL;
        edit->set_normals = edit->set_positions = NULL;
    } else
        edit->strip_normals = kinds & 64 && kinds & 128 ? NORMA_STRIP_ALL : NORMA_STRIP_NOTHING;
    if ((kinds & 0x300) == 0x300 && !edit->source_vertices &&
        norma_document_format(document) >= NORMA_FILE_GLTF) {
        float *tangents = calloc(4 * data.mesh.positions.count + 4, sizeof *tangents);
        for (size_t i = 0; i < data.mesh.positions.count; ++i)
            tangents[4 * i + fuzz_random_below(random, 3)] = tangents[4 * i + 3] = 1;
        edit->tangents = tangents;
        edit->set_tangents = marks(random, data.mesh.positions.count, 2);
    }
}

static void edit(norma_document *document, norma_file_format format, uint8_t seed) {
    size_t count = norma_document_mesh_count(document);
    norma_mesh_edit *edits = calloc(count + 1, sizeof *edits);
    fuzz_random random = {seed};
    norma_document_error error;
    for (size_t i = 0; i < count && i < 16; ++i) fill_edit(document, i, &random, &edits[i]);
    if (!norma_document_edit(document, edits, &error)) write_and_read(document, format);
    for (size_t i = 0; i < count; ++i) {
        const void *const blocks[] = {edits[i].reverse_faces, edits[i].drop_faces, edits[i].normals,
            edits[i].set_normals, edits[i].positions, edits[i].set_positions,
            edits[i].source_vertices, edits[i].new_corners, edits[i].tangents,
            edits[i].set_tangents};
        for (size_t k = 0; k < sizeof blocks / sizeof *blocks; ++k)
            free((void *)(uintptr_t)blocks[k]);
    }
    free(edits);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fuzz_bytes rest = {bytes, size};
    uint8_t what = fuzz_u8(&rest) % 4;
    fuzz_meter_begin(what < 2 ? 65536 : 4 * size); /* several documents at once */
    if (what == 0)
        orient(&rest);
    else if (what == 1)
        scene(&rest);
    else {
        norma_file_format format = format_of(fuzz_u8(&rest));
        uint8_t kind = fuzz_u8(&rest), seed = fuzz_u8(&rest);
        norma_document *document = open(rest.at, rest.left, format, 1);
        if (document && what == 2)
            check_and_fix(document, &rest, kind);
        else if (document)
            edit(document, format, seed);
        norma_document_close(document);
    }
    fuzz_meter_end();
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *bytes, size_t size, size_t capacity, unsigned seed) {
    fuzz_random random = {seed};
    if (size <= HEAD || bytes[0] % 4 < 2) return LLVMFuzzerMutate(bytes, size, capacity);
    if (fuzz_random_below(&random, 8) == 0) {
        bytes[fuzz_random_below(&random, HEAD)] = (uint8_t)fuzz_random_u32(&random);
        return size;
    }
    return HEAD + fuzz_mutate(format_of(bytes[1]), bytes + HEAD, size - HEAD, capacity - HEAD,
                      fuzz_random_u32(&random));
}
