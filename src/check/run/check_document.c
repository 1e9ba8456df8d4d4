/* check_document.c: the rules over an open document: each mesh that it could read, its normal maps,
 * then its nodes and skins; what it could not read is told of (N002), and so is a file that could
 * not be opened (N001). */
#include "check/rules/rules.h"
#include "core/call/table.h"
#include "io/format/for_fixes.h"
#include <stdlib.h>
#include <string.h>

/* ---- what another document has shown already. A trial of a fix changes few meshes of its copy,
 * and of those often the normals alone: only what may differ is looked at again, the rest of the
 * findings are copied. */

/* Rules that look at positions and corners only, and at whether there are normals. */
static int is_of_surface(check_rule rule) {
    return (rule >= RULE_N301 && rule <= RULE_N307) || (rule >= RULE_N401 && rule <= RULE_N405) ||
           rule == RULE_N502 || rule == RULE_N503 || rule == RULE_N701;
}

/* ---- whether meshes are the same */

static int is_same_array(const void *a, const void *b, size_t count, size_t size) {
    return a == b || (a && b && memcmp(a, b, count * size) == 0);
}

static int is_same_view(const norma_vec3_view *a, const norma_vec3_view *b) {
    const size_t size = 3 * norma_format_size(a->format);
    const char *p = a->data, *q = b->data;
    if (a->count != b->count || a->format != b->format) return 0;
    if (norma_view_stride(a) == size && norma_view_stride(b) == size)
        return is_same_array(p, q, a->count, size);
    for (size_t i = 0; i < a->count; ++i, p += norma_view_stride(a), q += norma_view_stride(b))
        if (memcmp(p, q, size) != 0) return 0;
    return 1;
}

static int is_same_surface(const norma_mesh *a, const norma_mesh *b) {
    const size_t faces = a->face_starts ? a->face_count : a->corner_count / 3;
    return is_same_view(&a->positions, &b->positions) && a->corner_count == b->corner_count &&
           a->corner_size == b->corner_size && a->face_count == b->face_count &&
           is_same_array(
               a->corners, b->corners, a->corner_count, a->corner_size ? a->corner_size : 4) &&
           is_same_array(a->face_starts, b->face_starts, faces + 1, sizeof *a->face_starts) &&
           is_same_array(
               a->smoothing_groups, b->smoothing_groups, faces, sizeof *a->smoothing_groups) &&
           is_same_array(a->hard_edges, b->hard_edges, a->corner_count, sizeof *a->hard_edges);
}

static int is_same_material(const norma_material_info *a, const norma_material_info *b) {
    return a->double_sided == b->double_sided && a->unlit == b->unlit &&
           a->not_opaque == b->not_opaque && a->normal_map == b->normal_map &&
           a->normal_texcoord == b->normal_texcoord &&
           memcmp(a->normal_turn, b->normal_turn, sizeof a->normal_turn) == 0 &&
           strcmp(a->ignore ? a->ignore : "", b->ignore ? b->ignore : "") == 0;
}

static int is_same_attributes(
    const norma_mesh_attributes *a, const norma_mesh_attributes *b, const norma_mesh *mesh) {
    const size_t faces = mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
    return a->texcoord_count == b->texcoord_count && a->tangent_count == b->tangent_count &&
           a->normals_missing == b->normals_missing && a->normals_surplus == b->normals_surplus &&
           a->normals_out_of_range == b->normals_out_of_range &&
           strcmp(a->tangent_encoding, b->tangent_encoding) == 0 &&
           memcmp(a->texcoord_turn, b->texcoord_turn, sizeof a->texcoord_turn) == 0 &&
           is_same_array(a->face_materials, b->face_materials, faces, sizeof *a->face_materials) &&
           is_same_array(a->texcoords, b->texcoords, a->texcoord_count, 2 * sizeof(float)) &&
           is_same_array(a->corner_texcoords, b->corner_texcoords, mesh->corner_count,
               sizeof *a->corner_texcoords) &&
           is_same_array(a->colors, b->colors, mesh->positions.count, 4 * sizeof(float)) &&
           is_same_array(a->tangents, b->tangents, a->tangent_count, 4 * sizeof(float)) &&
           is_same_array(a->face_faults, b->face_faults, faces, 1);
}

static int is_same_normals(const norma_check_mesh *a, const norma_check_mesh *b) {
    return strcmp(a->info.encoding, b->info.encoding) == 0 &&
           is_same_view(&a->data.normals, &b->data.normals) &&
           is_same_array(a->data.corner_normals, b->data.corner_normals, a->data.mesh.corner_count,
               sizeof *a->data.corner_normals);
}

static int is_same_morphs(const norma_check_mesh *a, const norma_check_mesh *b) {
    if (a->morph_count != b->morph_count) return 0;
    for (size_t i = 0; i < a->morph_count; ++i)
        if (!is_same_view(&a->morphs[i].positions, &b->morphs[i].positions) ||
            !is_same_view(&a->morphs[i].normals, &b->morphs[i].normals) ||
            !is_same_view(&a->morphs[i].tangents, &b->morphs[i].tangents))
            return 0;
    return 1;
}

/* How a mesh differs from another. */
typedef enum check_change { CHECK_SAME, CHECK_SAME_SURFACE, CHECK_ALL_CHANGED } check_change;

static check_change check_compare(const norma_check_mesh *a, const norma_check_mesh *b) {
    if (strcmp(a->info.where, b->info.where) != 0 || a->info.normals != b->info.normals ||
        a->attributes.material != b->attributes.material ||
        strcmp(a->attributes.ignore, b->attributes.ignore) != 0 ||
        !is_same_material(&a->material, &b->material) ||
        !is_same_surface(&a->data.mesh, &b->data.mesh))
        return CHECK_ALL_CHANGED;
    return is_same_normals(a, b) && is_same_morphs(a, b) &&
                   is_same_attributes(&a->attributes, &b->attributes, &a->data.mesh)
               ? CHECK_SAME
           /* Of an STL's facets the normals are evidence for their windings. */
           : a->info.normals == NORMA_NORMALS_PER_FACET ? CHECK_ALL_CHANGED
                                                        : CHECK_SAME_SURFACE;
}

/* ---- what is not looked at again */

/* Takes from rules those to which it makes no difference; whoever reported N002 does so again. */
static void check_leave_known(uint8_t rules[CHECK_RULE_COUNT], check_change change) {
    for (size_t rule = 0; rule < CHECK_RULE_COUNT; ++rule)
        if (rule != RULE_N002 && (change == CHECK_SAME || (change == CHECK_SAME_SURFACE &&
                                                              is_of_surface((check_rule)rule))))
            rules[rule] = 0;
}

/* ---- a document */

typedef struct document_check {
    check_run run;
    norma_document *document;
    const check_known *known;
    check_places places; /* of what is known */
    norma_document_error *error;
    norma_check_mesh *meshes;  /* those that were read; for the nodes that draw them */
    norma_morph_data **morphs; /* of each */
    size_t *orders;            /* of their places */
    norma_node_info *nodes;
    norma_skin_info *skins;
    size_t mesh_count, skin_count, next_unread;
    size_t multiplied; /* nodes whose instances are those in a tile, all together */
} document_check;

/* N001, N002: something cannot be read, or was not checked. */
static norma_document_result tell_unread(document_check *d, check_rule rule,
    const check_place *place, const char *format, const char *why) {
    char message[CHECK_MESSAGE];
    norma_check_partly(&d->run);
    if (!d->run.rules[rule]) return NORMA_DOCUMENT_OK;
    norma_check_message(message, format, why);
    return norma_check_fail(
        d->error, norma_check_add_one(&d->run, place, rule,
                      rule == RULE_N001 ? NORMA_SEVERITY_ERROR : NORMA_SEVERITY_WARNING, message));
}

/* ---- normal maps: each image is read once, for all meshes that show it; one that cannot be is
 * told of (N002) */

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

static int is_map_wanted(const check_run *run, const norma_check_mesh *mesh) {
    uint8_t rules[CHECK_RULE_COUNT];
    memcpy(rules, run->rules, sizeof rules);
    norma_check_silence(rules, mesh->attributes.ignore);
    norma_check_silence(rules, mesh->material.ignore);
    return mesh->material.normal_map && !mesh->material.unlit && mesh->attributes.texcoords &&
           mesh->data.mesh.corner_count && (rules[RULE_N811] || rules[RULE_N812]);
}

static norma_document_result find_uses(document_check *d, map_use *uses, size_t *count) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < d->mesh_count && !result; ++i) {
        const norma_check_mesh *mesh = &d->meshes[i];
        if (!is_map_wanted(&d->run, mesh)) continue;
        map_use *use = &uses[*count];
        use->mesh = i;
        result =
            norma_document_normal_map(d->document, mesh->attributes.material, &use->map, d->error);
        *count += !result && use->map.there;
    }
    return result;
}

/* ---- one image */

static norma_result judge_map_of(document_check *d, const map_use *use, const map_texels *texels) {
    check_mesh m;
    const norma_result result = norma_check_open_mesh(&d->run, &d->meshes[use->mesh], &m);
    m.order = d->orders[use->mesh];
    return result ? result : norma_check_map(&m, &use->map, texels);
}

static norma_document_result tell_not_read(document_check *d, const map_use *use, const char *why) {
    char where[CHECK_MESSAGE], label[CHECK_MESSAGE];
    const norma_check_mesh *mesh = &d->meshes[use->mesh];
    if (use->map.image == SIZE_MAX) { /* it names none */
        norma_check_message(where, "%s", mesh->info.where);
        norma_check_label(&mesh->info, label);
    } else {
        norma_check_message(where, "/images/%z", use->map.image);
        norma_check_message(label, use->map.name ? "image %z \"%s\"" : "image %z", use->map.image,
            use->map.name ? use->map.name : "");
    }
    return tell_unread(d, RULE_N002, &(check_place){d->orders[use->mesh], where, label},
        "not checked: the normal map, as %s", why);
}

static norma_document_result judge_image(document_check *d, const map_use *uses, size_t count) {
    map_texels texels;
    if (uses->map.not_read) return tell_not_read(d, uses, uses->map.not_read);
    const image_result read = norma_map_read(&uses->map, count, &texels);
    norma_result result = NORMA_OK;
    if (read == IMAGE_MEMORY) return norma_check_fail(d->error, NORMA_ERROR_MEMORY);
    if (read) return tell_not_read(d, uses, norma_image_text(read));
    for (size_t i = 0; i < count && !result; ++i) result = judge_map_of(d, &uses[i], &texels);
    norma_map_free(&texels);
    return norma_check_fail(d->error, result);
}

static norma_document_result check_maps(document_check *d) {
    size_t count = 0;
    map_use *uses = calloc(d->mesh_count + 1, sizeof *uses);
    if (!uses) return norma_check_fail(d->error, NORMA_ERROR_MEMORY);
    norma_document_result result = find_uses(d, uses, &count);
    if (!result && count) qsort(uses, count, sizeof *uses, by_image);
    for (size_t i = 0, end; i < count && !result; i = end) {
        for (end = i + 1; end < count && is_same_image(&uses[i].map, &uses[end].map); ++end)
            ;
        result = judge_image(d, &uses[i], end - i);
    }
    free(uses);
    return result;
}

/* ---- the rest of a document */

enum { MOST_PLACED = 1 << 18 };

norma_document_result norma_check_fail_to(
    norma_document_error *error, norma_result result, const char *verb) {
    if (!result) return NORMA_DOCUMENT_OK;
    norma_document_result as = result == NORMA_CANCELLED        ? NORMA_DOCUMENT_CANCELLED
                               : result == NORMA_ERROR_MEMORY   ? NORMA_DOCUMENT_ERROR_MEMORY
                               : result == NORMA_ERROR_ARGUMENT ? NORMA_DOCUMENT_ERROR_ARGUMENT
                                                                : NORMA_DOCUMENT_ERROR_MALFORMED;
    if (error) {
        error->result = as;
        norma_check_message(error->message, "cannot be %s: %s", verb, norma_result_text(result));
    }
    return as;
}

/* ---- N002 */

static norma_document_result tell_place_unread(
    document_check *d, const char *where, const char *label, const char *why) {
    return tell_unread(
        d, RULE_N002, &(check_place){d->run.next_order++, where, label}, "not checked: %s", why);
}

/* It has no vertices; or no normals, and no face whose positions are points: that finding alone of
 * N002 names faces. */
static int is_unchecked(const document_check *d, const norma_mesh_info *info) {
    for (size_t i = 0; info->normals == NORMA_NORMALS_NONE && i < d->run.findings->count; ++i) {
        const norma_finding *finding = norma_findings_get(d->run.findings, i);
        if (finding->rule == &norma_rules(NULL)[RULE_N002] && finding->worst.face != SIZE_MAX &&
            finding->count == info->faces && strcmp(finding->where, info->where) == 0)
            return 1;
    }
    return info->vertices == 0;
}

static int is_empty(const document_check *d) {
    size_t i = 0;
    while (i < d->mesh_count && is_unchecked(d, &d->meshes[i].info)) ++i;
    return i == d->mesh_count;
}

/* Where nothing could be checked, that is an error. */
static void raise_unread(document_check *d) {
    for (size_t i = 0; i < d->run.findings->count; ++i) {
        norma_finding *finding = norma_findings_change(d->run.findings, i);
        if (finding->rule == &norma_rules(NULL)[RULE_N002])
            finding->severity = NORMA_SEVERITY_ERROR;
    }
}

/* Those of the whole file stand first, those of primitives in their order; where: up to which one.
 */
static norma_document_result tell_up_to(document_check *d, const norma_mesh_info *info) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    char label[CHECK_MESSAGE] = "";
    for (size_t count = norma_document_unread_count(d->document); d->next_unread < count && !result;
         ++d->next_unread) {
        norma_unread unread;
        result = norma_document_unread(d->document, d->next_unread, &unread);
        int of_mesh = !result && strncmp(unread.where, "/meshes/", 8) == 0;
        if (of_mesh && !info) break;
        if (of_mesh && strcmp(unread.where, info->where) != 0) break;
        if (of_mesh) norma_check_label(info, label);
        if (!result) result = tell_place_unread(d, unread.where, label, unread.why);
    }
    return result;
}

/* ---- meshes */

/* morphs: to be freed in any case. */
static norma_document_result read_morphs(norma_document *document, size_t index,
    norma_check_mesh *mesh, norma_morph_data **morphs, norma_document_error *error) {
    const size_t count = mesh->info.morph_targets;
    *morphs = count ? calloc(count, sizeof **morphs) : NULL;
    if (count && !*morphs) return norma_check_fail(error, NORMA_ERROR_MEMORY);
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t t = 0; t < count && !result; ++t)
        result = norma_document_morph_data(document, index, t, &(*morphs)[t], error);
    mesh->morphs = *morphs;
    mesh->morph_count = count;
    return result;
}

/* After its info. */
static norma_document_result read_arrays(norma_document *document, size_t index,
    norma_check_mesh *mesh, norma_morph_data **morphs, norma_document_error *error) {
    norma_document_result result = norma_document_mesh_data(document, index, &mesh->data, error);
    if (!result) result = norma_document_mesh_attributes(document, index, &mesh->attributes, error);
    if (!result && mesh->attributes.material < norma_document_material_count(document))
        result = norma_document_material_info(document, mesh->attributes.material, &mesh->material);
    return result ? result : read_morphs(document, index, mesh, morphs, error);
}

/* Reads a mesh, and numbers its place; one that cannot be read only has its place told. */
static norma_document_result read_mesh(document_check *d, size_t index) {
    norma_check_mesh *mesh = &d->meshes[d->mesh_count];
    norma_document_result result = norma_document_mesh_info(d->document, index, &mesh->info);
    if (!result) result = tell_up_to(d, &mesh->info);
    if (!result && mesh->info.not_read) return NORMA_DOCUMENT_OK;
    if (!result)
        result = read_arrays(d->document, index, mesh, &d->morphs[d->mesh_count], d->error);
    if (!result) d->orders[d->mesh_count++] = d->run.next_order++;
    return result;
}

/* ---- meshes that are known */

/* mesh: as it is here. */
static norma_document_result compare_with_known(
    document_check *d, size_t index, const norma_check_mesh *mesh, check_change *change) {
    norma_document *document = d->known->document;
    norma_check_mesh before = {.data.normals.count = 0};
    norma_morph_data *morphs = NULL;
    norma_document_result result = norma_document_mesh_info(document, index, &before.info);
    if (result || before.info.not_read) {
        *change = CHECK_ALL_CHANGED;
        return NORMA_DOCUMENT_OK;
    }
    result = read_arrays(document, index, &before, &morphs, d->error);
    const check_change own = result ? CHECK_ALL_CHANGED : check_compare(&before, mesh);
    *change = own > *change ? own : *change;
    free(morphs);
    return result;
}

/* Where the surface is the same, its judge is. */
static norma_document_result compare_meshes(
    document_check *d, size_t begin, size_t end, size_t first, check_change *change) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    size_t group = SIZE_MAX;
    *change = d->known ? CHECK_SAME : CHECK_ALL_CHANGED;
    for (size_t i = begin; i < end && !result && *change != CHECK_ALL_CHANGED; ++i) {
        norma_mesh_info info;
        result = norma_document_mesh_info(d->document, i, &info);
        if (result || info.not_read) continue;
        result = compare_with_known(d, i, &d->meshes[first++], change);
        group = group == SIZE_MAX ? i : group;
    }
    d->run.judge = *change != CHECK_ALL_CHANGED && group != SIZE_MAX && d->known->judges
                       ? &d->known->judges[group]
                       : NULL;
    return result;
}

static int is_told_with_meshes(check_rule rule) {
    return rule != RULE_N002 && rule != RULE_N811 && rule != RULE_N812;
}

/* Of the rules that are wanted, but not looked at; and how normals that are the same were made. */
static norma_result copy_known(
    document_check *d, size_t first, const uint8_t *wanted, check_change change) {
    for (size_t mesh = first; mesh < d->mesh_count; ++mesh) {
        size_t count;
        const norma_finding **found =
            norma_places_find(&d->places, d->meshes[mesh].info.where, &count);
        for (size_t i = 0; i < count; ++i) {
            const size_t rule = (size_t)(found[i]->rule - norma_rules(NULL));
            const int is_copied = (wanted[rule] || (found[i]->deviation && change == CHECK_SAME)) &&
                                  !d->run.rules[rule] && is_told_with_meshes((check_rule)rule);
            if (is_copied && !norma_findings_copy(d->run.findings, found[i], d->orders[mesh]))
                return NORMA_ERROR_MEMORY;
        }
    }
    return NORMA_OK;
}

/* The meshes from first on. */
static norma_result run_group(document_check *d, size_t first, check_change change) {
    uint8_t wanted[CHECK_RULE_COUNT];
    norma_result result = NORMA_OK;
    memcpy(wanted, d->run.rules, sizeof wanted);
    check_leave_known(d->run.rules, change);
    for (size_t rule = 0; d->known && d->known->again && rule < CHECK_RULE_COUNT; ++rule)
        d->run.rules[rule] |= wanted[rule] && d->known->again[rule];
    if (change != CHECK_ALL_CHANGED) result = copy_known(d, first, wanted, change);
    if (!result && memchr(d->run.rules, 1, sizeof d->run.rules))
        result = norma_check_run_group(
            &d->run, &d->meshes[first], d->mesh_count - first, &d->orders[first]);
    memcpy(d->run.rules, wanted, sizeof wanted);
    return result;
}

/* Whether the mesh belongs to those before it: primitives that cannot be read do not part them. */
static int continues(const document_check *d, size_t index, size_t first) {
    norma_mesh_info info;
    return d->mesh_count == first || norma_document_mesh_info(d->document, index, &info) ||
           info.not_read || norma_check_siblings(&d->meshes[d->mesh_count - 1].info, &info);
}

static norma_document_result check_group_of(document_check *d, size_t *index, size_t count) {
    const size_t first = d->mesh_count, begin = *index;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (; *index < count && !result && continues(d, *index, first); ++*index)
        result = read_mesh(d, *index);
    check_change change;
    if (result || d->mesh_count == first) return result;
    result = compare_meshes(d, begin, *index, first, &change);
    if (result) return result;
    norma_core_stage(&d->run.call, (double)begin / (double)count, (double)*index / (double)count);
    const norma_result checked = run_group(d, first, change);
    return norma_check_fail(d->error, checked);
}

static norma_document_result check_meshes(document_check *d) {
    size_t count = norma_document_mesh_count(d->document);
    d->meshes = calloc(count + 1, sizeof *d->meshes);
    d->morphs = calloc(count + 1, sizeof *d->morphs);
    d->orders = calloc(count + 1, sizeof *d->orders);
    if (!d->meshes || !d->morphs || !d->orders)
        return norma_check_fail(d->error, NORMA_ERROR_MEMORY);
    norma_document_result result = tell_up_to(d, NULL);
    for (size_t i = 0; i < count && !result;) result = check_group_of(d, &i, count);
    return result;
}

/* ---- nodes and skins */

static void multiply_upper(const double a[16], double b[16]) { /* of 4 x 4, into b */
    double product[9];
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            product[3 * column + row] = a[row] * b[4 * column] + a[4 + row] * b[4 * column + 1] +
                                        a[8 + row] * b[4 * column + 2];
    for (int i = 0; i < 9; ++i) b[4 * (i / 3) + i % 3] = product[i];
}

/* A tile may draw all that again and again: its instances are then those of each of its own, one
 * after another. No rule asks where they are. */
static norma_result instance_world(void *context, size_t index, size_t instance, double world[16]) {
    const document_check *d = context;
    double matrix[16];
    const size_t in_tile = norma_document_tile_instance(d->document, SIZE_MAX, matrix),
                 all = d->nodes[index].instances,
                 own = index >= d->multiplied ? all
                       : all > in_tile        ? all / in_tile
                                              : 1;
    const norma_document_result result =
        norma_document_instance_world(d->document, index, instance % own, world, d->error);
    if (!result && in_tile) {
        (void)norma_document_tile_instance(d->document, instance / own, matrix);
        multiply_upper(matrix, world);
    }
    return !result                                 ? NORMA_OK
           : result == NORMA_DOCUMENT_ERROR_MEMORY ? NORMA_ERROR_MEMORY
                                                   : NORMA_ERROR_INDEX;
}

/* A skin whose joints or animations are malformed is not read, one with more of them than this
 * version plays is not checked; the meshes are all the same. */
static norma_document_result tell_malformed(
    document_check *d, size_t skin, norma_document_result how, const char *why) {
    char where[CHECK_MESSAGE], label[CHECK_MESSAGE];
    norma_check_message(where, "/skins/%z", skin);
    norma_check_message(label, "skin %z", skin);
    if (how == NORMA_DOCUMENT_ERROR_UNSUPPORTED) return tell_place_unread(d, where, label, why);
    return tell_unread(d, RULE_N001, &(check_place){d->run.next_order++, where, label}, "%s", why);
}

static norma_document_result read_skins(document_check *d) {
    size_t count = norma_document_skin_count(d->document);
    norma_document_result result = NORMA_DOCUMENT_OK;
    d->skins = calloc(count + 1, sizeof *d->skins);
    if (!d->skins) return norma_check_fail(d->error, NORMA_ERROR_MEMORY);
    for (; d->skin_count < count && !result; ++d->skin_count) {
        norma_skin_info *skin = &d->skins[d->skin_count];
        norma_document_error error;
        norma_document_result read =
            norma_document_skin_info(d->document, d->skin_count, skin, &error);
        if (read == NORMA_DOCUMENT_ERROR_MEMORY)
            return norma_check_fail(d->error, NORMA_ERROR_MEMORY);
        if (!read) continue;
        *skin = (norma_skin_info){.name = "", .where = "", .ignore = "", .joint = SIZE_MAX};
        result = tell_malformed(d, d->skin_count, read, error.message);
    }
    return result;
}

/* A node is drawn in each instance of a tile, as often as it has instances itself: a few bytes of
 * both would stand for any number. left: of MOST_PLACED, or of four times the tile's; where they do
 * not reach, this node and those after it are judged in the tile's first instance. */
static norma_document_result multiply_instances(
    document_check *d, size_t node, size_t in_tile, size_t *left) {
    norma_node_info *info = &d->nodes[node];
    if (!in_tile || d->multiplied < node) return NORMA_DOCUMENT_OK;
    if (info->instances > *left / in_tile) {
        char label[CHECK_MESSAGE];
        norma_check_message(label, "node %z", info->node);
        return tell_place_unread(d, info->where, label,
            "this node and those after it in all but the tile's first instance, as there are too "
            "many together with their own");
    }
    ++d->multiplied;
    info->instances *= in_tile;
    *left -= info->instances;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result check_nodes(document_check *d) {
    double unused[16];
    const size_t in_tile = norma_document_tile_instance(d->document, SIZE_MAX, unused);
    size_t count = norma_document_node_count(d->document),
           left = in_tile < MOST_PLACED / 4 ? MOST_PLACED : 4 * in_tile;
    norma_document_result result = NORMA_DOCUMENT_OK;
    d->run.has_tile_instances = in_tile > 0;
    d->nodes = calloc(count + 1, sizeof *d->nodes);
    if (!d->nodes) return norma_check_fail(d->error, NORMA_ERROR_MEMORY);
    for (size_t i = 0; i < count && !result; ++i) {
        result = norma_document_node_info(d->document, i, &d->nodes[i]);
        double world[16];
        if (result) /* once more, for the words */
            (void)norma_document_instance_world(d->document, i, 0, world, d->error);
        if (result == NORMA_DOCUMENT_ERROR_MEMORY)
            result = norma_check_fail(d->error, NORMA_ERROR_MEMORY);
        if (!result) result = multiply_instances(d, i, in_tile, &left);
    }
    if (!result) result = read_skins(d);
    const norma_check_scene scene = {.meshes = d->meshes,
        .mesh_count = d->mesh_count,
        .nodes = d->nodes,
        .node_count = count,
        .skins = d->skins,
        .skin_count = d->skin_count};
    norma_result checked =
        result ? NORMA_OK : norma_check_nodes(&d->run, &scene, instance_world, d);
    return checked == NORMA_ERROR_INDEX ? NORMA_DOCUMENT_ERROR_MALFORMED
           : checked                    ? norma_check_fail(d->error, checked)
                                        : result;
}

/* ---- the same mesh in several files */

static uint64_t hash_mesh(const norma_mesh *mesh) {
    double position[3];
    uint64_t hash = norma_core_hash(&(uint64_t){mesh->corner_count}, sizeof(uint64_t));
    for (size_t i = 0; i < mesh->positions.count; ++i) {
        norma_view_vector(&mesh->positions, i, position);
        const uint64_t both[] = {hash, norma_core_hash(position, sizeof position)};
        hash = norma_core_hash(both, sizeof both);
    }
    return hash;
}

/* Findings of one mesh follow one another, and those of the next follow them: it is looked for from
 * there on. */
static void name_meshes(const norma_check_mesh *meshes, size_t count, norma_findings *findings) {
    const norma_finding *last = NULL;
    size_t at = 0;
    for (size_t i = 0; i < findings->count; ++i) {
        norma_finding *finding = &findings->entries[i].finding;
        if (last && strcmp(last->where, finding->where) == 0)
            finding->mesh = last->mesh;
        else
            for (size_t k = 0; k < count && !finding->mesh; ++k, at = (at + 1) % count)
                if (strcmp(meshes[at].info.where, finding->where) == 0)
                    finding->mesh = hash_mesh(&meshes[at].data.mesh);
        last = finding;
    }
}

static const char *name_of_normal_map(void *document, size_t material) {
    norma_texture_info map;
    return norma_document_normal_map(document, material, &map, NULL) ? NULL : map.name;
}

/* ---- the models of a composite tile: each is judged by itself, for where their meshes stand is
 * said beside them, and none hides another */

static int add_of_tile(check_run *run, const norma_finding *finding, size_t tile) {
    char where[CHECK_MESSAGE], label[CHECK_MESSAGE];
    norma_finding of_tile = *finding;
    const int is_within = strncmp(finding->where, "byte ", 5) != 0; /* else a tile left out */
    norma_check_message(where,
        *finding->where && *finding->where != '/' ? "/tiles/%z/%s" : "/tiles/%z%s", tile,
        finding->where);
    norma_check_message(label, *finding->label ? "tile %z %s" : "tile %z", tile, finding->label);
    of_tile.where = is_within ? where : finding->where;
    of_tile.label = is_within ? label : finding->label;
    return norma_findings_copy(run->findings, &of_tile, run->next_order++);
}

static norma_document_result check_tiles(norma_document *document,
    const norma_check_options *options, norma_findings **findings, norma_document_error *error) {
    check_run run;
    norma_document *tile;
    const norma_result begun = norma_check_begin(&run, options, norma_document_format(document));
    norma_document_result result = begun ? norma_check_fail(error, begun) : NORMA_DOCUMENT_OK;
    for (size_t i = 0; !result && (tile = norma_document_tile(document, i)) != NULL; ++i) {
        norma_findings *own = NULL;
        result = norma_check_again(tile, NULL, options, &own, error);
        for (size_t k = 0; !result && k < norma_findings_count(own); ++k)
            if (!add_of_tile(&run, norma_findings_get(own, k), i))
                result = norma_check_fail(error, NORMA_ERROR_MEMORY);
        if (norma_findings_partly(own)) norma_check_partly(&run);
        norma_findings_free(own);
    }
    if (!begun && result)
        norma_check_abandon(&run);
    else if (!begun)
        *findings = norma_check_finish(&run);
    return result;
}

norma_document_result norma_check_document(norma_document *document,
    const norma_check_options *options, norma_findings **findings, norma_document_error *error) {
    return findings && norma_document_tile(document, 1)
               ? check_tiles(document, options, findings, error)
               : norma_check_again(document, NULL, options, findings, error);
}

norma_document_result norma_check_again(norma_document *document, const check_known *known,
    const norma_check_options *options, norma_findings **findings, norma_document_error *error) {
    document_check d = {.document = document, .known = known, .error = error};
    if (!document || !findings) return norma_check_fail(error, NORMA_ERROR_ARGUMENT);
    norma_result begun = norma_check_begin(&d.run, options, norma_document_format(document));
    if (begun) return norma_check_fail(error, begun);
    d.run.map_name = name_of_normal_map;
    d.run.map_names = document;
    d.run.known = known ? &d.places : NULL;
    d.run.is_trial = known && known->is_trial;
    norma_document_result result = norma_document_ready(document, error);
    if (!result && known && !norma_places_gather(&d.places, known->findings, NULL, NULL))
        result = norma_check_fail(error, NORMA_ERROR_MEMORY);
    if (!result) result = check_meshes(&d);
    if (!result) result = check_maps(&d);
    if (!result) result = check_nodes(&d);
    if (!result && is_empty(&d)) raise_unread(&d);
    if (result)
        norma_check_abandon(&d.run);
    else
        *findings = norma_check_finish(&d.run);
    if (!result) name_meshes(d.meshes, d.mesh_count, *findings);
    for (size_t i = 0; d.morphs && i <= d.mesh_count && i < norma_document_mesh_count(document);
         ++i)
        free(d.morphs[i]);
    void *const blocks[] = {
        (void *)d.places.findings, d.meshes, (void *)d.morphs, d.orders, d.nodes, d.skins};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; ++i) free(blocks[i]);
    return result;
}

/* ---- N001 */

norma_findings *norma_check_unreadable(const norma_document_error *error, norma_file_format format,
    const norma_check_options *options) {
    check_run run;
    if (!error || norma_check_begin(&run, options, format)) return NULL;
    const check_place whole = {.order = 0, .where = "", .label = ""};
    norma_result result =
        norma_check_add_one(&run, &whole, RULE_N001, NORMA_SEVERITY_ERROR, error->message);
    if (result) norma_check_abandon(&run);
    return result ? NULL : norma_check_finish(&run);
}
