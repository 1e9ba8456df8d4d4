/* fuzz_roundtrip.c: read, compute or transform, write, read, compare. The first bytes say format,
 * verb and options; the rest is the file. Where computing succeeds the file can be written and
 * read; it has the faces that it had (of a strip or a fan that became a list those that do not name
 * a vertex twice), every corner lies where it lay, bit for bit; each normal is a unit vector, or of
 * the length that its encoding has; and computing once more changes nothing but, at most, once. */
#include "mutate.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HEAD = 8, MOST_MESHES = 64 };

typedef struct verb {
    norma_file_format format;
    int transforms, bakes;
    norma_compute_options compute;
    norma_transform_options transform;
} verb;

static verb take_verb(fuzz_bytes *bytes) {
    static const double scales[] = {1, 2, -1, 0.5, 0, 3};
    uint8_t head[HEAD];
    fuzz_take(bytes, head, sizeof head);
    verb v = {.format = (norma_file_format)(1 + head[0] % 5),
        .transforms = head[1] % 4 == 3,
        .bakes = head[1] & 8};
    v.compute = (norma_compute_options){.struct_size = sizeof v.compute,
        .shading = (norma_shading)(head[2] % 4),
        .weight = (norma_weight)(head[2] / 4 % 7),
        .weld = (norma_weld)(head[3] % 3),
        .non_manifold = (norma_non_manifold)(head[3] / 3 % 2),
        .only = (norma_only)(head[3] / 6 % 3),
        .groups = (norma_groups)(head[3] / 18 % 2),
        .morphs = head[4] & 1,
        .threads = head[4] & 2 ? 2 : 1,
        .weld_distance = 0.01 * head[5],
        .crease_angle_rad = 0.02 * head[6]};
    v.transform =
        (norma_transform_options){.struct_size = sizeof v.transform, .bake = v.bakes, .threads = 1};
    for (int i = 0; i < 3; ++i) v.transform.matrix[5 * i] = scales[(head[2] >> i) % 6];
    v.transform.matrix[4] = head[3] & 1 ? 0.5 : 0;
    v.transform.matrix[12] = head[4];
    v.transform.matrix[15] = 1;
    return v;
}

static norma_document *open(const uint8_t *bytes, size_t size, norma_file_format format) {
    norma_document_options options = {
        .struct_size = sizeof options, .format = format, .threads = 1};
    norma_document *document;
    return norma_document_open_memory(bytes, size, NULL, &options, &document, NULL) ? NULL
                                                                                    : document;
}

/* ---- what was there: of each mesh the place of every corner */

typedef struct corners {
    size_t faces, count;
    uint32_t *starts; /* NULL: triangles */
    double *places;
    uint8_t *sews; /* of each triangle: it names a vertex twice */
} corners;

static size_t corner_position(const norma_mesh *mesh, size_t c) {
    if (!mesh->corners) return c;
    if (mesh->corner_size == 1) return ((const uint8_t *)mesh->corners)[c];
    return mesh->corner_size == 2 ? ((const uint16_t *)mesh->corners)[c]
                                  : ((const uint32_t *)mesh->corners)[c];
}

static double component(const norma_vec3_view *view, size_t i, size_t k) {
    static const size_t sizes[] = {4, 8, 1, 1, 2, 2};
    const size_t size = sizes[view->format], stride = view->stride ? view->stride : 3 * size;
    const uint8_t *at = (const uint8_t *)view->data + i * stride + k * size;
    float f;
    double d;
    int16_t s;
    switch (view->format) {
    case NORMA_FORMAT_FLOAT:
        memcpy(&f, at, 4);
        return (double)f;
    case NORMA_FORMAT_DOUBLE:
        memcpy(&d, at, 8);
        return d;
    case NORMA_FORMAT_INT8:
        return (int8_t)at[0];
    case NORMA_FORMAT_UINT8:
        return at[0];
    case NORMA_FORMAT_INT16:
        memcpy(&s, at, 2);
        return s;
    default:
        memcpy(&s, at, 2);
        return (uint16_t)s;
    }
}

static int take_corners(norma_document *document, size_t mesh, corners *c) {
    norma_mesh_data data;
    *c = (corners){0};
    if (norma_document_mesh_data(document, mesh, &data, NULL)) return 0;
    const norma_mesh *m = &data.mesh;
    c->count = m->corner_count;
    c->faces = m->face_starts ? m->face_count : m->corner_count / 3;
    c->places = calloc(3 * c->count + 1, sizeof(double));
    for (size_t i = 0; i < 3 * c->count; ++i)
        c->places[i] = component(&m->positions, corner_position(m, i / 3), i % 3);
    c->sews = calloc(c->faces + 1, 1);
    for (size_t f = 0; !m->face_starts && f < c->faces; ++f) {
        const size_t x = corner_position(m, 3 * f), y = corner_position(m, 3 * f + 1),
                     z = corner_position(m, 3 * f + 2);
        c->sews[f] = x == y || y == z || z == x;
    }
    if (m->face_starts) {
        c->starts = malloc((c->faces + 1) * sizeof *c->starts);
        memcpy(c->starts, m->face_starts, (c->faces + 1) * sizeof *c->starts);
    }
    return 1;
}

static int same_place(double a, double b) {
    return memcmp(&a, &b, sizeof a) == 0 || (isnan(a) && isnan(b));
}

/* Strips and fans that become lists lose what only sewed their parts together. */
static void leave_out_stitches(corners *c) {
    size_t kept = 0;
    for (size_t f = 0; f < c->faces; ++f)
        if (!c->sews[f]) memmove(c->places + 9 * kept++, c->places + 9 * f, 9 * sizeof *c->places);
    c->faces = kept;
    c->count = 3 * kept;
}

/* A glTF that names no mode, nor anything in other letters than its own, has no strips and no fans.
 */
static int may_be_sewn(const verb *v, const fuzz_bytes *file) {
    static const char mode[] = "mode";
    int found = 0;
    for (size_t i = 0; i < file->left && !found; ++i)
        found = file->at[i] == '\\' ||
                (file->left - i >= strlen(mode) && memcmp(file->at + i, mode, strlen(mode)) == 0);
    return found && (v->format == NORMA_FILE_GLTF || v->format == NORMA_FILE_GLB);
}

static void compare(corners *before, const corners *after, size_t mesh, int sewn) {
    if (sewn && after->faces < before->faces) leave_out_stitches(before);
    if (before->faces != after->faces || before->count != after->count ||
        !before->starts != !after->starts)
        fuzz_fail("mesh %zu: %zu faces and %zu corners, before %zu and %zu", mesh, after->faces,
            after->count, before->faces, before->count);
    if (before->starts &&
        memcmp(before->starts, after->starts, (before->faces + 1) * sizeof *before->starts) != 0)
        fuzz_fail("mesh %zu: faces of other sizes", mesh);
    for (size_t i = 0; i < 3 * before->count; ++i)
        if (!same_place(before->places[i], after->places[i]))
            fuzz_fail("mesh %zu: corner %zu lies at %a, before at %a", mesh, i / 3,
                after->places[i], before->places[i]);
}

static void free_corners(corners *c) {
    free(c->starts);
    free(c->places);
    free(c->sews);
}

/* ---- the normals that are there now */

static void judge_normals(
    norma_document *document, size_t mesh, int has_summary, const norma_compute_summary *summary) {
    norma_mesh_info info;
    norma_mesh_data data;
    if (norma_document_mesh_info(document, mesh, &info) || info.not_read ||
        norma_document_mesh_data(document, mesh, &data, NULL) || !has_summary || !summary->changed)
        return;
    double factor = strcmp(info.encoding, "snorm8") == 0    ? 127
                    : strcmp(info.encoding, "snorm16") == 0 ? 32767
                                                            : 1,
           bound = factor == 127     ? 0.00674
                   : factor == 32767 ? 0.0001
                   : strcmp(info.encoding, "float16") == 0
                       ? 1.0 / 2048 + 1e-5 /* each number to half a unit in its eleventh bit */
                       : 1e-5;
    factor = data.normals.format == NORMA_FORMAT_FLOAT || data.normals.format == NORMA_FORMAT_DOUBLE
                 ? 1
                 : factor;
    size_t count =
        data.corner_normals
            ? data.mesh.corner_count
            : data.normals.count; /* an OBJ may have more, which its lines name, and which stay */
    for (size_t k = 0; k < count; ++k) {
        const size_t i = data.corner_normals ? data.corner_normals[k] : k;
        if (i >= data.normals.count) continue;
        double x = component(&data.normals, i, 0) / factor,
               y = component(&data.normals, i, 1) / factor,
               z = component(&data.normals, i, 2) / factor, length = sqrt(x * x + y * y + z * z);
        if (!(fabs(length - 1) <= bound))
            fuzz_fail("mesh %zu: normal %zu has length %.9g as %s", mesh, i, length, info.encoding);
    }
}

static norma_document_result change(
    norma_document *document, const verb *v, norma_compute_summary *summary) {
    norma_document_error error = {0};
    norma_document_result result;
    if (v->transforms) {
        norma_transform_summary transformed;
        result = norma_document_transform(document, &v->transform, &transformed, &error);
    } else
        result = norma_document_compute(document, &v->compute, summary, &error);
    if (result && !error.message[0]) fuzz_fail("result %d without a message", (int)result);
    if (!result && !v->transforms && summary->report.degenerate_faces.count > summary->faces)
        fuzz_fail("%zu of %zu faces are degenerate", summary->report.degenerate_faces.count,
            summary->faces);
    return result;
}

static void again(const uint8_t *bytes, size_t size, const verb *v) {
    norma_document *document = open(bytes, size, v->format);
    norma_compute_summary summary;
    fuzz_blob blob = {0};
    if (!document) fuzz_fail("what was written cannot be read");
    if (change(document, v, &summary)) fuzz_fail("what was computed cannot be computed again");
    if (norma_document_write(document, fuzz_blob_write, &blob, NULL))
        fuzz_fail("what was computed twice cannot be written");
    free(blob.bytes);
    norma_document_close(document);
}

/* A buffer that computing had no use for, and that is in a file, or in none. */
static int is_elsewhere(const norma_document_error *error) {
    return error->result == NORMA_DOCUMENT_ERROR_REFUSED ||
           error->result == NORMA_DOCUMENT_ERROR_MALFORMED;
}

static void round_trip(norma_document *document, const fuzz_bytes *file, const verb *v) {
    int sewn = may_be_sewn(v, file);
    size_t count = norma_document_mesh_count(document);
    corners *before = calloc(count + 1, sizeof *before), after;
    int *readable = calloc(count + 1, sizeof *readable);
    fuzz_blob blob = {0};
    norma_compute_summary summary = {0};
    for (size_t i = 0; i < count; ++i) readable[i] = take_corners(document, i, &before[i]);
    norma_document_error error = {0};
    norma_document_result result = change(document, v, &summary);
    if (!result) result = norma_document_write(document, fuzz_blob_write, &blob, &error);
    if (error.result && !is_elsewhere(&error))
        fuzz_fail("what was computed cannot be written: %s", error.message);
    if (!result) {
        norma_document *written = open(blob.bytes, blob.size, v->format);
        if (!written) fuzz_fail("what was written cannot be read");
        if (!v->transforms && norma_document_mesh_count(written) != count)
            fuzz_fail("%zu meshes, before %zu", norma_document_mesh_count(written), count);
        for (size_t i = 0; !v->transforms && i < count; ++i) {
            int there = take_corners(written, i, &after);
            if (!there && readable[i]) fuzz_fail("mesh %zu cannot be read any more", i);
            if (there && readable[i]) /* normals of a kind that cannot be read are replaced by some
                                         that can */
                compare(&before[i], &after, i, sewn);
            judge_normals(written, i, v->compute.only == NORMA_ONLY_ALL, &summary);
            free_corners(&after);
        }
        norma_document_close(written);
        if (!v->transforms) again(blob.bytes, blob.size, v);
    }
    for (size_t i = 0; i < count; ++i) free_corners(&before[i]);
    free(before);
    free(readable);
    free(blob.bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fuzz_bytes rest = {bytes, size};
    verb v = take_verb(&rest);
    fuzz_meter_begin(
        4 * size); /* two documents at once, the places of all corners, the bytes of the new file */
    norma_document *document = open(rest.at, rest.left, v.format);
    if (document && norma_document_mesh_count(document) <= MOST_MESHES)
        round_trip(document, &rest, &v);
    norma_document_close(document);
    fuzz_meter_end();
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *bytes, size_t size, size_t capacity, unsigned seed) {
    fuzz_random random = {seed};
    if (size <= HEAD) return LLVMFuzzerMutate(bytes, size, capacity);
    if (fuzz_random_below(&random, 6) == 0) {
        bytes[fuzz_random_below(&random, HEAD)] = (uint8_t)fuzz_random_u32(&random);
        return size;
    }
    return HEAD + fuzz_mutate((norma_file_format)(1 + bytes[0] % 5), bytes + HEAD, size - HEAD,
                      capacity - HEAD, fuzz_random_u32(&random));
}
