/* run_maps.c: the normal maps of a document: each image is read once, for all meshes that show it;
 * one that cannot be is told of (N002). */
#include "check/run/run_maps.h"
#include "check/maps/maps.h"
#include <stdlib.h>
#include <string.h>

typedef struct map_use {
    norma_texture_info map;
    size_t mesh; /* in the scene */
} map_use;

static int by_image(const void *first, const void *second) {
    const map_use *a = first, *b = second;
    const uintptr_t p = (uintptr_t)a->map.bytes, q = (uintptr_t)b->map.bytes;
    if (p != q) return p < q ? -1 : 1;
    if (a->map.image != b->map.image) return a->map.image < b->map.image ? -1 : 1;
    return a->mesh < b->mesh ? -1 : a->mesh > b->mesh;
}
/* Those that are not read have no bytes in common. */
static int is_same_image(const norma_texture_info *a, const norma_texture_info *b) {
    return a->bytes == b->bytes && (a->bytes || a->image == b->image);
}

static int is_wanted(const check_run *run, const norma_check_mesh *mesh) {
    uint8_t rules[CHECK_RULE_COUNT];
    memcpy(rules, run->rules, sizeof rules);
    norma_check_silence(rules, mesh->attributes.ignore);
    norma_check_silence(rules, mesh->material.ignore);
    return mesh->material.normal_map && !mesh->material.unlit && mesh->attributes.texcoords &&
           mesh->data.mesh.corner_count && (rules[RULE_N811] || rules[RULE_N812]);
}

static norma_document_result find_uses(const map_job *job, map_use *uses, size_t *count) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < job->mesh_count && !result; i++) {
        const norma_check_mesh *mesh = &job->meshes[i];
        if (!is_wanted(job->run, mesh)) continue;
        map_use *use = &uses[*count];
        use->mesh = i;
        result = norma_document_normal_map(
            job->document, mesh->attributes.material, &use->map, job->error);
        *count += !result && use->map.there;
    }
    return result;
}

/* ---- one image */

static norma_result judge(const map_job *job, const map_use *use, const map_texels *texels) {
    char label[CHECK_MESSAGE];
    check_mesh m;
    const norma_check_mesh *mesh = &job->meshes[use->mesh];
    const norma_result result = norma_check_open_mesh(job->run, mesh, &m);
    if (result) return result;
    norma_check_label(&mesh->info, label);
    m.place =
        (check_place){job->orders[use->mesh], mesh->info.where ? mesh->info.where : "", label};
    return norma_check_map(&m, &use->map, texels);
}

static norma_result tell_not_read(const map_job *job, const map_use *use, const char *why) {
    char message[CHECK_MESSAGE], where[CHECK_MESSAGE], label[CHECK_MESSAGE];
    const norma_check_mesh *mesh = &job->meshes[use->mesh];
    if (use->map.image == SIZE_MAX) { /* it names none */
        norma_check_message(where, "%s", mesh->info.where);
        norma_check_label(&mesh->info, label);
    } else {
        norma_check_message(where, "/images/%z", use->map.image);
        norma_check_message(label, "image %z", use->map.image);
    }
    const check_place place = {job->orders[use->mesh], where, label};
    norma_check_partly(job->run);
    if (!job->run->rules[RULE_N002]) return NORMA_OK;
    norma_check_message(message, "not checked: the normal map, as %s", why);
    return norma_check_add_one(
        job->run, &place, NULL, RULE_N002, NORMA_SEVERITY_WARNING, CHECK_NOWHERE, message);
}

static norma_result judge_image(const map_job *job, const map_use *uses, size_t count) {
    map_texels texels;
    if (uses->map.not_read) return tell_not_read(job, uses, uses->map.not_read);
    const image_result read = norma_map_read(&uses->map, count, &texels);
    norma_result result = NORMA_OK;
    if (read == IMAGE_MEMORY) return NORMA_ERROR_MEMORY;
    if (read) return tell_not_read(job, uses, norma_image_text(read));
    for (size_t i = 0; i < count && !result; i++) result = judge(job, &uses[i], &texels);
    norma_map_free(&texels);
    return result;
}

norma_document_result norma_check_maps(const map_job *job, norma_result *failed) {
    size_t count = 0;
    *failed = NORMA_OK;
    map_use *uses = calloc(job->mesh_count + 1, sizeof *uses);
    if (!uses) {
        *failed = NORMA_ERROR_MEMORY;
        return NORMA_DOCUMENT_OK;
    }
    const norma_document_result result = find_uses(job, uses, &count);
    if (!result && count) qsort(uses, count, sizeof *uses, by_image);
    for (size_t i = 0, end; i < count && !result && !*failed; i = end) {
        for (end = i + 1; end < count && is_same_image(&uses[i].map, &uses[end].map); end++)
            ;
        *failed = judge_image(job, &uses[i], end - i);
    }
    free(uses);
    return result;
}
