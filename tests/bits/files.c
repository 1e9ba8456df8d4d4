/* files.c: the rules, and files from reading to writing: what a document tells, what is computed,
 * transformed and mended in it, and the bytes that are written. */
#include "bits.h"
#include <stdlib.h>
#include <string.h>

/* ---- rules */

static void add_sample(const norma_sample *sample, bits_hash *hash) {
    bits_size(hash, sample->vertex);
    bits_size(hash, sample->face);
    bits_size(hash, sample->normal);
    bits_add(hash, (uint64_t)sample->has_position);
    if (sample->has_position) bits_doubles(hash, sample->position, 3);
}

static void add_deviation(const norma_deviation *deviation, bits_hash *hash) {
    const double values[] = {deviation->crease_angle_rad, deviation->mean_rad, deviation->p50_rad,
        deviation->p99_rad, deviation->max_rad};
    bits_add(hash, (uint64_t)deviation->shading);
    bits_add(hash, (uint64_t)deviation->weight);
    bits_size(hash, deviation->corners);
    bits_doubles(hash, values, sizeof values / sizeof *values);
    for (int i = 0; i < NORMA_DEVIATION_BINS; ++i) bits_size(hash, deviation->histogram[i]);
}

void bits_findings(const norma_findings *findings, bits_hash *hash) {
    bits_size(hash, norma_findings_count(findings));
    bits_add(hash, (uint64_t)norma_findings_profile(findings));
    bits_add(hash, (uint64_t)norma_findings_partly(findings));
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *f = norma_findings_get(findings, i);
        bits_text(hash, f->rule->id);
        bits_add(hash, (uint64_t)f->severity);
        bits_text(hash, f->where);
        bits_text(hash, f->label);
        bits_size(hash, f->count);
        bits_double(hash, f->worst_value);
        bits_text(hash, f->unit);
        add_sample(&f->worst, hash);
        for (size_t s = 0; s < f->sample_count; ++s) add_sample(&f->samples[s], hash);
        bits_add(hash, (uint64_t)f->fix);
        bits_text(hash, f->message);
        if (f->deviation) add_deviation(f->deviation, hash);
    }
}

/* A made mesh, and normals for it that are wrong here and there, as a surface to judge. */
void bits_check(const bits_mesh *m, const bits_way *way, bits_hash *hash) {
    const size_t count = m->mesh.positions.count;
    float *normals = bits_room(3 * count, sizeof *normals);
    uint64_t seed = 144;
    if (norma_vertex_normals(&m->mesh, NULL, normals, count, NULL)) memset(normals, 0, 12 * count);
    for (size_t i = 0; i < count; i += 1 + bits_random(&seed) % 40)
        normals[3 * i + bits_random(&seed) % 3] *= (float)(int)(bits_random(&seed) % 3) - .99f;
    const norma_check_mesh mesh = {
        .info = {.name = m->name,
            .where = "",
            .vertices = count,
            .faces = m->mesh.face_starts ? m->mesh.face_count : m->mesh.corner_count / 3,
            .triangles = m->mesh.corner_count / 3,
            .normals = NORMA_NORMALS_PER_VERTEX,
            .encoding = "float"},
        .data = {.mesh = m->mesh, .normals = {.data = normals, .count = count}},
        .attributes = {.material = SIZE_MAX},
    };
    const norma_check_scene scene = {.meshes = &mesh, .mesh_count = 1, .format = NORMA_FILE_GLB};
    for (int profile = NORMA_CHECK_PROFILE_RENDER;
         profile <= (m->large ? NORMA_CHECK_PROFILE_RENDER : NORMA_CHECK_PROFILE_PRINT);
         ++profile) {
        const norma_check_options options = {.struct_size = sizeof options,
            .threads = way->threads,
            .profile = (norma_check_profile)profile,
            .strict = profile > 1};
        norma_findings *findings = NULL;
        bits_add(hash, (uint64_t)(int64_t)norma_check_scene_run(&scene, &options, &findings));
        if (findings) bits_findings(findings, hash);
        norma_findings_free(findings);
    }
    norma_deviation deviation;
    norma_options options = bits_options(way);
    const norma_result result =
        norma_explain_normals(&mesh.data, NORMA_NORMALS_PER_VERTEX, &options, &deviation);
    bits_add(hash, (uint64_t)(int64_t)result);
    if (!result) add_deviation(&deviation, hash);
    free(normals);
}

/* ---- files */

/* One line; of an error of the system only that there was one: its text is the system's. */
static void add_error(
    norma_document_result result, const norma_document_error *error, bits_hash *hash) {
    bits_add(hash, (uint64_t)(int64_t)result);
    if (result && result != NORMA_DOCUMENT_ERROR_FILE) bits_text(hash, error->message);
}

typedef struct opening {
    const char *name;
    const void *bytes;
    size_t size;
    const bits_way *way;
    bits_hash *hash;
} opening;

static norma_document *open_document(const opening *o, int lenient) {
    const norma_document_options options = {
        .struct_size = sizeof options, .threads = o->way->threads, .lenient = lenient};
    norma_document *document = NULL;
    norma_document_error error = {0};
    add_error(norma_document_open_memory(o->bytes, o->size, o->name, &options, &document, &error),
        &error, o->hash);
    return document;
}

static int take_bytes(void *hash, const void *bytes, size_t size) {
    for (size_t i = 0; i < size; ++i) { /* however it is cut into pieces */
        bits_hash *h = hash;
        h->state = (h->state ^ ((const unsigned char *)bytes)[i]) * 0x100000001B3u; /* FNV-1a */
    }
    return 0;
}

static void write_document(norma_document *document, const opening *o) {
    bits_hash file = {0xCBF29CE484222325u};
    norma_document_error error = {0};
    add_error(norma_document_write(document, take_bytes, &file, &error), &error, o->hash);
    bits_add(o->hash, file.state);
    for (size_t i = 0; i < norma_document_note_count(document); ++i)
        bits_text(o->hash, norma_document_note(document, i));
    norma_document_close(document);
}

static void add_view(norma_vec3_view view, bits_hash *hash) {
    bits_size(hash, view.count);
    bits_add(hash, (uint64_t)view.format);
    for (size_t i = 0; i < view.count; ++i) {
        const unsigned char *at =
            (const unsigned char *)view.data + i * (view.stride ? view.stride
                                                       : view.format == NORMA_FORMAT_DOUBLE ? 24
                                                                                            : 12);
        float single[3];
        double wide[3];
        if (view.format == NORMA_FORMAT_DOUBLE) {
            memcpy(wide, at, sizeof wide);
            bits_doubles(hash, wide, 3);
        } else if (view.format == NORMA_FORMAT_FLOAT) {
            memcpy(single, at, sizeof single);
            bits_floats(hash, single, 3);
        }
    }
}

static void add_mesh(norma_document *document, size_t index, bits_hash *hash) {
    norma_mesh_info info;
    norma_mesh_data data;
    norma_mesh_attributes attributes;
    norma_document_error error = {0};
    if (norma_document_mesh_info(document, index, &info)) return;
    bits_text(hash, info.name);
    bits_text(hash, info.where);
    bits_size(hash, info.vertices);
    bits_size(hash, info.faces);
    bits_size(hash, info.triangles);
    bits_add(hash, (uint64_t)info.normals);
    bits_text(hash, info.encoding);
    bits_text(hash, info.not_read);
    const norma_document_result result =
        info.not_read ? NORMA_DOCUMENT_OK
                      : norma_document_mesh_data(document, index, &data, &error);
    add_error(result, &error, hash);
    if (info.not_read || result) return;
    add_view(data.mesh.positions, hash);
    add_view(data.normals, hash);
    bits_size(hash, data.mesh.corner_count);
    if (data.mesh.corners)
        bits_bytes(hash, data.mesh.corners,
            data.mesh.corner_count * (data.mesh.corner_size ? data.mesh.corner_size : 4));
    if (norma_document_mesh_attributes(document, index, &attributes, &error)) return;
    bits_size(hash, attributes.material);
    if (attributes.texcoords)
        bits_floats(hash, attributes.texcoords, 2 * attributes.texcoord_count);
    if (attributes.tangents) bits_floats(hash, attributes.tangents, 4 * attributes.tangent_count);
    if (attributes.colors) bits_floats(hash, attributes.colors, 4 * info.vertices);
}

/* What images say hangs on who decodes them: libjpeg's texels are not the same everywhere, and
 * WebAssembly has no decoder. */
static void leave_out_images(uint8_t rules[128]) {
    uint8_t images[128] = {0};
    norma_rules_select("N811,N812", images, NULL);
    for (size_t i = 0; i < 128; ++i) rules[i] = !images[i];
}

static void tell(const opening *o) {
    norma_document *document = open_document(o, 1);
    if (!document) return;
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i) add_mesh(document, i, o->hash);
    for (size_t i = 0; i < norma_document_node_count(document); ++i) {
        norma_node_info info;
        norma_document_node_info(document, i, &info);
        bits_text(o->hash, info.path);
        bits_doubles(o->hash, info.world, 16);
    }
    for (size_t i = 0; i < norma_document_skin_count(document); ++i) {
        norma_skin_info info;
        norma_document_error error = {0};
        const norma_document_result result = norma_document_skin_info(document, i, &info, &error);
        add_error(result, &error, o->hash);
        if (!result) bits_double(o->hash, info.anisotropy);
    }
    uint8_t rules[128];
    const norma_check_options options = {
        .struct_size = sizeof options, .rules = rules, .threads = o->way->threads};
    norma_findings *findings = NULL;
    norma_document_error error = {0};
    leave_out_images(rules);
    add_error(norma_check_document(document, &options, &findings, &error), &error, o->hash);
    if (findings) bits_findings(findings, o->hash);
    norma_findings_free(findings);
    norma_document_close(document);
}

static void compute(const opening *o, norma_compute_options options) {
    norma_document *document = open_document(o, 0);
    norma_compute_summary summary = {0};
    norma_document_error error = {0};
    if (!document) return;
    options.struct_size = sizeof options;
    options.threads = o->way->threads;
    const norma_document_result result =
        norma_document_compute(document, &options, &summary, &error);
    add_error(result, &error, o->hash);
    if (result) {
        norma_document_close(document);
        return;
    }
    bits_size(o->hash, summary.vertices_after);
    bits_size(o->hash, summary.hard_edges);
    bits_size(o->hash, summary.filled);
    bits_report(o->hash, &summary.report);
    write_document(document, o);
}

static void transform(const opening *o, int bake) {
    static const double matrix[16] = {2, .25, 0, 0, -.125, .5, .375, 0, 0, .1, -1, 0, 3, -2.2, 1e-3,
        1}; /* sheared and mirrored */
    static const double scale[16] = {2, 0, 0, 0, 0, .5, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    norma_document *document = open_document(o, 0);
    norma_transform_options options = {
        .struct_size = sizeof options, .bake = bake, .threads = o->way->threads};
    norma_document_error error = {0};
    if (!document) return;
    memcpy(options.matrix, bake ? matrix : scale, sizeof matrix);
    const norma_document_result result = norma_document_transform(document, &options, NULL, &error);
    add_error(result, &error, o->hash);
    if (result)
        norma_document_close(document);
    else
        write_document(document, o);
}

static void mend(const opening *o) {
    norma_document *document = open_document(o, 1);
    const norma_check_options options = {.struct_size = sizeof options, .threads = o->way->threads};
    norma_fix_summary summary = {0};
    norma_document_error error = {0};
    if (!document) return;
    const norma_document_result result =
        norma_fix_document(document, &options, 1, &summary, &error);
    add_error(result, &error, o->hash);
    bits_add(o->hash, (uint64_t)summary.changed);
    if (result)
        norma_document_close(document);
    else
        write_document(document, o);
}

void bits_file(
    const char *path, const void *bytes, size_t size, const bits_way *way, bits_hash *hash) {
    const opening o = {path, bytes, size, way, hash};
    tell(&o);
    compute(&o, (norma_compute_options){0});
    compute(&o, (norma_compute_options){
                    .shading = NORMA_SHADING_SMOOTH, .weight = NORMA_WEIGHT_MAX, .morphs = 1});
    compute(&o, (norma_compute_options){.shading = NORMA_SHADING_FLAT});
    compute(&o, (norma_compute_options){.shading = NORMA_SHADING_CREASE,
                    .crease_angle_rad = .5,
                    .weight = NORMA_WEIGHT_AREA,
                    .groups = NORMA_GROUPS_IGNORE});
    compute(&o, (norma_compute_options){.only = NORMA_ONLY_BROKEN});
    transform(&o, 0);
    transform(&o, 1);
    mend(&o);
}

void bits_meshes_of_file(
    const char *path, const void *bytes, size_t size, bits_visit *visit, void *user) {
    const norma_document_options options = {.struct_size = sizeof options, .lenient = 1};
    norma_document *document = NULL;
    if (norma_document_open_memory(bytes, size, path, &options, &document, NULL)) return;
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i) {
        norma_mesh_info info;
        norma_mesh_data data;
        if (norma_document_mesh_info(document, i, &info) || info.not_read ||
            norma_document_mesh_data(document, i, &data, NULL))
            continue;
        const bits_mesh mesh = {
            .name = path, .mesh = data.mesh, .large = data.mesh.corner_count > 30000};
        visit(user, &mesh);
    }
    norma_document_close(document);
}
