/* gltf_pack.c: the smallest encoding of KHR_mesh_quantization for each accessor of normals and
 * tangents that keeps every direction within an angle. Morph targets are judged by the directions
 * that they give, each alone at full weight, so base and differences are chosen together. */
#include "core/face/unit_length.h"
#include "io/gltf/gltf_layout.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* From small to large. */
typedef enum pack_level { PACK_BYTE = 0, PACK_SHORT, PACK_KEPT } pack_level;
enum { LEVELS = PACK_KEPT + 1 };

/* What an accessor is used for; positions are never packed. */
static const bake_role PACK_UNUSED = BAKE_POSITIONS;

typedef struct pack_entry { /* of an accessor */
    bake_role role;
    uint32_t uses; /* slots of this role */
    int barred;    /* it keeps its encoding: another use, or numbers that no code can hold */
    pack_level level;
    uint32_t data;   /* what was put, or GLTF_NONE */
    gltf_array made; /* the elements as they will be; those of the file if it is kept */
    double error;    /* the worst angle */
} pack_entry;

typedef struct pack_slot { /* one use of an accessor */
    gltf_slot slot;
    uint32_t accessor;
} pack_slot;

typedef struct pack_pair { /* a target's differences on what they are added to */
    uint32_t base, delta;
} pack_pair;

typedef struct packing {
    gltf *g;
    const norma_pack_options *options;
    norma_pack_summary *summary;
    norma_document_error *error;
    pack_entry *entries;
    pack_slot *slots;
    pack_pair *pairs;
    size_t slot_count, slot_capacity, pair_count, pair_capacity;
    size_t compressed; /* primitives that Draco holds */
} packing;

static norma_document_result pack_memory(const packing *p) {
    return norma_document_fail_memory(p->g->document, p->error);
}

/* ---- which accessors, and what uses them */

static norma_document_result add_packed_use(
    packing *p, const gltf_slot *slot, uint32_t accessor, bake_role role, uint32_t width) {
    if (accessor == GLTF_NONE) return NORMA_DOCUMENT_OK;
    pack_entry *entry = &p->entries[accessor];
    pack_slot *added = norma_io_add(&p->slots, &p->slot_capacity, &p->slot_count, sizeof *added);
    if (!added) return pack_memory(p);
    *added = (pack_slot){*slot, accessor};
    if (entry->role != PACK_UNUSED && entry->role != role) entry->barred = 1;
    if (p->g->accessors[accessor].width != width) entry->barred = 1;
    entry->role = role;
    ++entry->uses;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result add_pair(packing *p, uint32_t base, uint32_t delta) {
    if (delta == GLTF_NONE) return NORMA_DOCUMENT_OK;
    if (base == GLTF_NONE || p->g->accessors[base].count != p->g->accessors[delta].count) {
        p->entries[delta].barred = 1; /* nothing says what its differences turn */
        return NORMA_DOCUMENT_OK;
    }
    pack_pair *added = norma_io_add(&p->pairs, &p->pair_capacity, &p->pair_count, sizeof *added);
    if (!added) return pack_memory(p);
    *added = (pack_pair){base, delta};
    return NORMA_DOCUMENT_OK;
}

static norma_document_result list_primitive(packing *p, uint32_t number) {
    const gltf_primitive *of = &p->g->primitives[number];
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (int32_t t = GLTF_SLOT_BASE; !result && t < (int32_t)of->target_count; ++t) {
        const int delta = t != GLTF_SLOT_BASE;
        const gltf_attributes *set = norma_gltf_set_of(p->g, of, t);
        const gltf_slot normal = {0, number, t, "NORMAL"}, tangent = {0, number, t, "TANGENT"};
        result =
            add_packed_use(p, &normal, set->normal, delta ? BAKE_NORMAL_DELTAS : BAKE_NORMALS, 3);
        if (!result)
            result = add_packed_use(p, &tangent, set->tangent,
                delta ? BAKE_TANGENT_DELTAS : BAKE_TANGENTS, delta ? 3 : 4);
        if (!result && delta) result = add_pair(p, of->base.normal, set->normal);
        if (!result && delta) result = add_pair(p, of->base.tangent, set->tangent);
    }
    return result;
}

static int compare_pack_pairs(const void *a, const void *b) {
    const pack_pair *x = a, *y = b;
    if (x->base != y->base) return x->base < y->base ? -1 : 1;
    return x->delta < y->delta ? -1 : x->delta > y->delta;
}

/* Once each, in the order of their bases. */
static void sort_pairs(packing *p) {
    size_t kept = 0;
    if (p->pair_count) qsort(p->pairs, p->pair_count, sizeof *p->pairs, compare_pack_pairs);
    for (size_t i = 0; i < p->pair_count; ++i)
        if (!kept || compare_pack_pairs(&p->pairs[kept - 1], &p->pairs[i]) != 0)
            p->pairs[kept++] = p->pairs[i];
    p->pair_count = kept;
}

static norma_document_result list_uses(packing *p) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t i = 0; !result && i < p->g->primitive_count; ++i) {
        const int compressed = p->g->primitives[i].draco.token != GLTF_NONE;
        p->compressed += (size_t)compressed;
        if (!compressed) result = list_primitive(p, i);
    }
    uint32_t *uses = result ? NULL : norma_gltf_accessor_uses(p->g);
    if (!result && !uses) return pack_memory(p);
    for (uint32_t a = 0; !result && a < p->g->accessor_count; ++a)
        p->entries[a].barred |= uses[a] != p->entries[a].uses;
    free(uses);
    if (!result) sort_pairs(p);
    return result;
}

/* ---- encodings */

static size_t padded_size(size_t size) { return (size + 3) / 4 * 4; }

/* Bytes of all elements that are stored. */
static size_t level_bytes(const packing *p, uint32_t accessor, pack_level level) {
    const gltf_accessor *a = &p->g->accessors[accessor];
    const size_t of[LEVELS] = {a->width, (size_t)2 * a->width, a->element_size};
    const size_t dense = a->view == GLTF_NONE ? 0 : a->count;
    return dense * padded_size(of[level]) + a->sparse.count * of[level];
}

/* A code is there for the number that a tangent's sign is. */
static int is_sign(double w) { return w == 1 || w == -1 || w == 0; }

/* The elements as doubles; NULL: out of memory. *held: whether codes can stand for them. */
static double *read_values(const gltf_array *array, int *held) {
    double *values = norma_io_allocate(array->count + 1, array->width * sizeof *values);
    *held = 1;
    for (size_t i = 0; values && i < array->count; ++i) {
        double *value = values + i * array->width;
        norma_gltf_doubles(array, i, value);
        *held &= isfinite(value[0]) && isfinite(value[1]) && isfinite(value[2]);
        *held &= array->width < 4 || is_sign(value[3]);
    }
    return values;
}

typedef struct pack_elements { /* of an accessor, at a level */
    gltf_array array;
    gltf_data data; /* its bytes are to be freed; at PACK_KEPT there are none but the file's */
    int held;       /* 0: no code of the level can hold them, and nothing was made */
} pack_elements;

static norma_document_result make_level(
    packing *p, uint32_t accessor, pack_level level, pack_elements *made) {
    *made = (pack_elements){.held = 1};
    norma_document_result result = norma_gltf_array(p->g, accessor, &made->array, p->error);
    if (result || level == PACK_KEPT) return result;
    gltf_array like = made->array;
    like.component = level == PACK_BYTE ? GLTF_BYTE : GLTF_SHORT;
    like.normalized = 1;
    made->held = 0;
    if (p->entries[accessor].barred ||
        level_bytes(p, accessor, level) >= level_bytes(p, accessor, PACK_KEPT))
        return NORMA_DOCUMENT_OK;
    double *values = read_values(&made->array, &made->held);
    bake_encoded encoded = values ? BAKE_ENCODED : BAKE_NO_MEMORY;
    if (values && made->held)
        encoded = norma_gltf_encode(p->entries[accessor].role, &like, values, &made->data);
    free(values);
    if (encoded == BAKE_NO_MEMORY) return pack_memory(p);
    if (encoded == BAKE_TOO_LARGE || made->data.component != like.component) { /* out of range */
        free(made->data.bytes);
        *made = (pack_elements){.held = 0};
    }
    made->array = norma_gltf_array_of(&made->data);
    return NORMA_DOCUMENT_OK;
}

/* ---- angles */

static double pack_angle(const double a[3], const double b[3]) {
    double cross[3];
    const int zero = a[0] == 0 && a[1] == 0 && a[2] == 0;
    if (zero && b[0] == 0 && b[1] == 0 && b[2] == 0) return 0;
    if (zero || (b[0] == 0 && b[1] == 0 && b[2] == 0)) return INFINITY;
    norma_core_cross(a, b, cross);
    return norma_core_angle(sqrt(norma_core_dot(cross, cross)), norma_core_dot(a, b));
}

/* An element, and what a target adds to it (NULL: nothing). */
static void read_sum(const gltf_array *base, const gltf_array *delta, size_t index, double out[4]) {
    double more[4] = {0};
    norma_gltf_doubles(base, index, out);
    if (delta) norma_gltf_doubles(delta, index, more);
    for (int k = 0; k < 3; ++k) out[k] += more[k];
}

typedef struct pack_state { /* arrays of a base and, or NULL, of one of its targets */
    const gltf_array *base, *delta;
} pack_state;

/* The worst angle between two states; what is above the bound may be said too small. */
static double worst_angle(const pack_state *before, const pack_state *after, double bound) {
    double worst = 0;
    for (size_t i = 0; worst <= bound && i < before->base->count; ++i) {
        double a[4] = {0}, b[4] = {0};
        read_sum(before->base, before->delta, i, a);
        read_sum(after->base, after->delta, i, b);
        const double angle = pack_angle(a, b);
        if (!(angle <= worst)) worst = isnan(angle) ? INFINITY : angle;
    }
    return worst;
}

/* ---- decisions */

/* The smallest level of a target's differences that stays within the bound on this base. */
static norma_document_result fit_delta(
    packing *p, const pack_pair *pair, const gltf_array *base, int *level) {
    gltf_array stored, stored_delta;
    pack_elements made;
    norma_document_result result = norma_gltf_array(p->g, pair->base, &stored, p->error);
    if (!result) result = norma_gltf_array(p->g, pair->delta, &stored_delta, p->error);
    const pack_state before = {&stored, &stored_delta}, after = {base, &made.array};
    const double bound = p->options->max_error_rad;
    for (*level = PACK_BYTE; !result && *level < LEVELS; ++*level) {
        result = make_level(p, pair->delta, (pack_level)*level, &made);
        const int fits = !result && made.held && worst_angle(&before, &after, bound) <= bound;
        free(made.data.bytes);
        if (fits) break;
    }
    return result;
}

/* All targets on a base at a level: the bytes of them all. SIZE_MAX: not within the bound. */
static norma_document_result fit_targets(
    packing *p, size_t first, size_t end, const gltf_array *base, size_t *bytes) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = first; !result && *bytes != SIZE_MAX && i < end; ++i) {
        int level = LEVELS;
        result = fit_delta(p, &p->pairs[i], base, &level);
        *bytes = level == LEVELS ? SIZE_MAX
                                 : *bytes + level_bytes(p, p->pairs[i].delta, (pack_level)level);
    }
    return result;
}

/* The level of a base, whose pairs are those from first on, that makes it and its targets smallest.
 */
static norma_document_result choose_base(packing *p, uint32_t base, size_t first, size_t end) {
    const double bound = p->options->max_error_rad;
    size_t least = SIZE_MAX;
    gltf_array stored;
    pack_elements made;
    p->entries[base].level = PACK_KEPT;
    norma_document_result result = norma_gltf_array(p->g, base, &stored, p->error);
    for (int level = PACK_BYTE; !result && level < LEVELS; ++level) {
        size_t bytes = level_bytes(p, base, (pack_level)level);
        result = make_level(p, base, (pack_level)level, &made);
        const pack_state before = {&stored, NULL}, after = {&made.array, NULL};
        if (!result && made.held && worst_angle(&before, &after, bound) <= bound)
            result = fit_targets(p, first, end, &made.array, &bytes);
        else
            bytes = SIZE_MAX;
        free(made.data.bytes);
        if (bytes >= least) continue;
        least = bytes;
        p->entries[base].level = (pack_level)level;
    }
    return result;
}

/* Puts an accessor at its level, for those that come after it. */
static norma_document_result keep_level(packing *p, uint32_t accessor) {
    pack_entry *entry = &p->entries[accessor];
    pack_elements made;
    norma_document_result result = make_level(p, accessor, entry->level, &made);
    entry->made = made.array;
    if (result || entry->level == PACK_KEPT) return result;
    entry->data = norma_gltf_add_data(p->g, &made.data);
    return entry->data == GLTF_NONE ? pack_memory(p) : NORMA_DOCUMENT_OK;
}

static int is_base(const pack_entry *entry) {
    return entry->role == BAKE_NORMALS || entry->role == BAKE_TANGENTS;
}

static norma_document_result choose_bases(packing *p) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    size_t first = 0, end;
    for (uint32_t a = 0; !result && a < p->g->accessor_count; ++a) {
        if (norma_watch_cancelled(&p->g->document->watch))
            return norma_document_fail_cancelled(p->g->document, p->error);
        for (; first < p->pair_count && p->pairs[first].base < a; ++first) {
        }
        for (end = first; end < p->pair_count && p->pairs[end].base == a; ++end) {
        }
        if (!is_base(&p->entries[a])) continue;
        result = choose_base(p, a, first, end);
        if (!result) result = keep_level(p, a);
    }
    return result;
}

/* The differences, on the bases as they are now: one that several bases share suits all of them. */
static norma_document_result choose_deltas(packing *p) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t a = 0; a < p->g->accessor_count; ++a)
        if (!is_base(&p->entries[a])) p->entries[a].level = PACK_BYTE;
    for (size_t i = 0; !result && i < p->pair_count; ++i) {
        const pack_pair *pair = &p->pairs[i];
        pack_entry *delta = &p->entries[pair->delta];
        int level;
        result = fit_delta(p, pair, &p->entries[pair->base].made, &level);
        if (!result && (pack_level)level > delta->level)
            delta->level = level < LEVELS ? (pack_level)level : PACK_KEPT;
    }
    for (uint32_t a = 0; !result && a < p->g->accessor_count; ++a) {
        pack_entry *entry = &p->entries[a];
        if (is_base(entry) || entry->role == PACK_UNUSED) continue;
        if (entry->barred) entry->level = PACK_KEPT;
        result = keep_level(p, a);
    }
    return result;
}

/* Of differences that several bases share, finer ones than a base asked for need not suit it. Then
 * both keep what they have. */
static norma_document_result check_pairs(packing *p) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; !result && i < p->pair_count; ++i) {
        pack_entry *base = &p->entries[p->pairs[i].base], *delta = &p->entries[p->pairs[i].delta];
        gltf_array stored, stored_delta;
        result = norma_gltf_array(p->g, p->pairs[i].base, &stored, p->error);
        if (!result) result = norma_gltf_array(p->g, p->pairs[i].delta, &stored_delta, p->error);
        if (result) break;
        const pack_state before = {&stored, &stored_delta}, after = {&base->made, &delta->made};
        const double worst = worst_angle(&before, &after, p->options->max_error_rad);
        if (worst <= p->options->max_error_rad) {
            if (delta->level != PACK_KEPT || base->level != PACK_KEPT)
                delta->error = fmax(delta->error, worst);
            continue;
        }
        base->level = delta->level = PACK_KEPT;
        base->made = stored;
        delta->made = stored_delta;
        i = SIZE_MAX; /* from the first again */
    }
    return result;
}

/* ---- what becomes of it */

static norma_document_result count_accessor(packing *p, uint32_t accessor) {
    const pack_entry *entry = &p->entries[accessor];
    const int normal = entry->role == BAKE_NORMALS || entry->role == BAKE_NORMAL_DELTAS;
    norma_pack_part *part = normal ? &p->summary->normals : &p->summary->tangents;
    gltf_array stored;
    norma_document_result result = norma_gltf_array(p->g, accessor, &stored, p->error);
    if (result) return result;
    const pack_state before = {&stored, NULL}, after = {&entry->made, NULL};
    const double error =
        entry->level != PACK_KEPT && is_base(entry) ? worst_angle(&before, &after, INFINITY) : 0;
    ++part->accessors;
    part->packed += entry->level != PACK_KEPT;
    part->bytes_before += level_bytes(p, accessor, PACK_KEPT);
    part->bytes_after += level_bytes(p, accessor, entry->level);
    part->max_error_rad = fmax(part->max_error_rad, fmax(error, entry->error));
    const double tolerance =
        norma_core_unit_tolerance((int)(8 * norma_gltf_component_size(stored.component)), 0);
    for (size_t i = 0; entry->level != PACK_KEPT && is_base(entry) && i < stored.count; ++i) {
        double v[4], length;
        norma_gltf_doubles(&stored, i, v);
        p->summary->made_unit +=
            norma_core_judge_length(v, tolerance, &length) == CORE_LENGTH_OTHER;
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result put_packed(packing *p) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    size_t packed = 0;
    for (uint32_t a = 0; !result && a < p->g->accessor_count; ++a)
        if (p->entries[a].role != PACK_UNUSED) result = count_accessor(p, a);
    for (size_t i = 0; !result && i < p->slot_count; ++i) {
        const pack_entry *entry = &p->entries[p->slots[i].accessor];
        if (entry->level == PACK_KEPT) continue;
        ++packed;
        if (!norma_gltf_put(p->g, &p->slots[i].slot, entry->data)) result = pack_memory(p);
    }
    if (!result && packed) norma_gltf_require(p->g, "KHR_mesh_quantization");
    return result;
}

static void note_compressed(const packing *p) {
    if (p->compressed)
        norma_document_add_note(p->g->document,
            "%zu %s compressed with " GLTF_DRACO ", which has an encoding of its own, and stay%s "
            "as %s",
            p->compressed, p->compressed == 1 ? "primitive is" : "primitives are",
            p->compressed == 1 ? "s" : "", p->compressed == 1 ? "it is" : "they are");
}

norma_document_result norma_gltf_pack(norma_document *document, const norma_pack_options *options,
    norma_pack_summary *summary, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    packing p = {.g = g, .options = options, .summary = summary, .error = error};
    norma_gltf_begin_change(g);
    gltf_patch *patch = norma_gltf_patch_of(g);
    p.entries = norma_io_allocate((size_t)g->accessor_count + 1, sizeof *p.entries);
    norma_document_result result = p.entries && patch ? list_uses(&p) : pack_memory(&p);
    if (patch) patch->tight = 1;
    if (!result) result = choose_bases(&p);
    if (!result) result = choose_deltas(&p);
    if (!result) result = check_pairs(&p);
    if (!result) result = put_packed(&p);
    if (!result) note_compressed(&p);
    if (!result) result = norma_gltf_finish(g, error);
    summary->changed = g->changed;
    free(p.entries);
    free(p.slots);
    free(p.pairs);
    return result;
}
