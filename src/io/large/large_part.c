/* large_part.c: a range of a large PLY's vertices as a mesh of its own. */
#include "io/large/large.h"

/* ---- Vertices that share their position with another one. Positions are hashed, and
 * two with the same hash count as equal here: what is computed later compares the positions
 * themselves, so that one marked too many costs time and changes nothing. */

/* ---- hashes */

static uint64_t part_mix(uint64_t x) {
    x = (x ^ x >> 32) * UINT64_C(0xd6e8feb86659fd93);
    x = (x ^ x >> 32) * UINT64_C(0xd6e8feb86659fd93);
    return x ^ x >> 32;
}

/* 0 where it is not a number, and so equal to nothing. -0 is 0. */
static uint64_t part_hash_of(const double position[3]) {
    uint64_t sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double p = position[k] + 0.0;
        uint64_t bits;
        if (p != p) return 0;
        memcpy(&bits, &p, sizeof bits);
        sum = (sum ^ bits) * UINT64_C(0x9e3779b97f4a7c15) + (uint64_t)k + 1;
        sum ^= sum >> 29;
    }
    const uint64_t hash = part_mix(sum);
    return hash ? hash : 1;
}

/* Of the vertices from first on, at most LARGE_BLOCK. */
static norma_document_result hash_block(
    large_ply *ply, size_t first, size_t count, uint64_t *hashes) {
    norma_document_result result = norma_large_ply_positions(ply, first, count, ply->scratch);
    for (size_t i = 0; i < count && !result; ++i) {
        double position[3];
        norma_large_scratch_position(ply, i, position);
        hashes[i] = part_hash_of(position);
    }
    return result;
}

/* ---- which are equal to any other */

static const uint64_t PART_EMPTY = UINT64_MAX;

typedef struct seen_table {
    uint64_t *slots; /* the upper half of a hash, and the first vertex that has it */
    size_t size;     /* a power of two */
} seen_table;

static void meet_equal(seen_table *table, uint64_t hash, size_t vertex, large_bits *equal) {
    const uint64_t upper = hash >> 32 << 32;
    size_t slot = (size_t)hash & (table->size - 1);
    for (; table->slots[slot] != PART_EMPTY; slot = (slot + 1) & (table->size - 1))
        if (table->slots[slot] >> 32 << 32 == upper) {
            norma_large_bits_set(equal, (size_t)(uint32_t)table->slots[slot]);
            norma_large_bits_set(equal, vertex);
            return;
        }
    table->slots[slot] = upper | vertex;
}

/* Of the parts into which hashes fall evenly, one. */
static size_t share_of_hash(uint64_t hash, size_t parts) {
    return (size_t)(((hash >> 8 & UINT32_MAX) * parts) >> 32);
}

static norma_document_result meet_part(large_ply *ply, seen_table *table, uint64_t *hashes,
    size_t part, size_t parts, large_bits *equal) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    memset(table->slots, 0xff, table->size * sizeof *table->slots);
    for (size_t first = 0; first < ply->vertices && !result; first += LARGE_BLOCK) {
        const size_t count = norma_large_some(ply->vertices - first, LARGE_BLOCK);
        result = hash_block(ply, first, count, hashes);
#if defined(__GNUC__)
        for (size_t i = 0; i < count && !result; ++i)
            if (hashes[i] && share_of_hash(hashes[i], parts) == part)
                __builtin_prefetch(&table->slots[(size_t)hashes[i] & (table->size - 1)], 1, 1);
#endif
        for (size_t i = 0; i < count && !result; ++i)
            if (hashes[i] && share_of_hash(hashes[i], parts) == part)
                meet_equal(table, hashes[i], first + i, equal);
        if (!result && first / LARGE_BLOCK % 32 == 0)
            result = norma_large_tell(
                ply->file, ((double)part + (double)first / (double)ply->vertices) / (double)parts);
    }
    return result;
}

/* Two slots for three vertices at least, as long as it takes no more than half of what is left. */
static size_t table_size(const large_ply *ply) {
    const large_budget *budget = &ply->file->budget;
    const uint64_t most = (budget->most - budget->used) / 2 / sizeof(uint64_t);
    size_t size = 1024;
    while (size < ply->vertices + ply->vertices / 2 && 2 * (uint64_t)size <= most) size *= 2;
    return size;
}

norma_document_result norma_large_find_equal(large_ply *ply, large_bits *equal, int *any) {
    large_budget *budget = &ply->file->budget;
    seen_table table = {.size = table_size(ply)};
    const size_t parts = ply->vertices / (table.size - table.size / 4) + 1;
    uint64_t *hashes = norma_large_take(budget, LARGE_BLOCK, sizeof *hashes);
    table.slots = norma_large_take(budget, table.size, sizeof *table.slots);
    norma_document_result result =
        hashes && table.slots ? NORMA_DOCUMENT_OK : norma_large_fail_memory(ply->file);
    for (size_t part = 0; part < parts && !result; ++part)
        result = meet_part(ply, &table, hashes, part, parts, equal);
    norma_large_give(budget, table.slots, table.size, sizeof *table.slots);
    norma_large_give(budget, hashes, LARGE_BLOCK, sizeof *hashes);
    *any = !result && norma_large_bits_count(equal) > 0;
    return result;
}

/* ---- which are equal to those of a range */

typedef struct hash_set {
    uint32_t *slots; /* 0: empty */
    size_t size;
} hash_set;

static uint32_t print_of(uint64_t hash) { return (uint32_t)(hash >> 32) | 1u; }

/* The slot of its print, or the empty one where it belongs. */
static uint32_t *print_slot(const hash_set *set, uint64_t hash) {
    size_t slot = (size_t)hash & (set->size - 1);
    while (set->slots[slot] && set->slots[slot] != print_of(hash))
        slot = (slot + 1) & (set->size - 1);
    return &set->slots[slot];
}

static norma_document_result part_gather(large_ply *ply, const large_bits *equal, size_t begin,
    size_t end, hash_set *set, uint64_t *hashes) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = begin; first < end && !result; first += LARGE_BLOCK) {
        const size_t count = norma_large_some(end - first, LARGE_BLOCK);
        if (!norma_large_bits_any(equal, first, first + count)) continue;
        result = hash_block(ply, first, count, hashes);
        for (size_t i = 0; i < count && !result; ++i)
            if (norma_large_bits_has(equal, first + i) && hashes[i])
                *print_slot(set, hashes[i]) = print_of(hashes[i]);
    }
    return result;
}

static norma_document_result match(large_ply *ply, const large_bits *equal, const hash_set *set,
    uint64_t *hashes, large_bits *members) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = 0; first < ply->vertices && !result; first += LARGE_BLOCK) {
        const size_t count = norma_large_some(ply->vertices - first, LARGE_BLOCK);
        if (!norma_large_bits_any(equal, first, first + count)) continue;
        result = hash_block(ply, first, count, hashes);
        for (size_t i = 0; i < count && !result; ++i)
            if (norma_large_bits_has(equal, first + i) && hashes[i] && *print_slot(set, hashes[i]))
                norma_large_bits_set(members, first + i);
    }
    return result;
}

/* Marks in members each vertex of equal that may lie where one of those from begin to before end
 * does. MEMORY: the range is too large. */
static norma_document_result large_add_equal(
    large_ply *ply, const large_bits *equal, size_t begin, size_t end, large_bits *members) {
    large_budget *budget = &ply->file->budget;
    const size_t marked =
        norma_large_bits_before(equal, end) - norma_large_bits_before(equal, begin);
    if (!marked) return NORMA_DOCUMENT_OK;
    hash_set set = {.size = 1024};
    while (set.size < 2 * marked) set.size *= 2;
    uint64_t *hashes = norma_large_take(budget, LARGE_BLOCK, sizeof *hashes);
    set.slots = norma_large_take_zeroed(budget, set.size, sizeof *set.slots);
    norma_document_result result =
        hashes && set.slots ? NORMA_DOCUMENT_OK : NORMA_DOCUMENT_ERROR_MEMORY;
    if (!result) result = part_gather(ply, equal, begin, end, &set, hashes);
    if (!result) result = match(ply, equal, &set, hashes, members);
    norma_large_give(budget, set.slots, set.size, sizeof *set.slots);
    norma_large_give(budget, hashes, LARGE_BLOCK, sizeof *hashes);
    return result;
}

/* ---- A range of a large PLY's vertices as a mesh of its own: every face that touches one
 * of them, or another vertex at the same position, in ascending order, so that each sum runs over
 * the same faces in the same order as in the whole mesh, and its bits are the same. */

/* ---- how much fits */

/* What a vertex and a face of a part are reckoned to take, the core's scratch memory included. */
enum { CORE_VERTEX = 56, OUTPUT_VERTEX = 13, TRIANGLE = 12, POLYGON = 112 };

static double least_of(double a, double b) { return a < b ? a : b; }

/* What is counted before stretches, before any vertex. */
static double before(const large_survey *survey, const uint64_t *counts, size_t vertex) {
    const size_t stretch = vertex / survey->stretch;
    const double within = (double)(vertex - stretch * survey->stretch) / (double)survey->stretch,
                 from = (double)counts[stretch];
    return stretch < survey->stretches ? from + within * ((double)counts[stretch + 1] - from)
                                       : from;
}

/* Two bounds for the faces that touch a range and for those that reach beyond it: what stretches
 * count, good for faces in no order, and what the faces span, good for faces in rows. */
static double cost(
    const large_parts *parts, size_t begin, size_t end, double touching, double crossing) {
    const large_survey *survey = parts->survey;
    const double over_begin =
                     before(survey, survey->begun, begin) - before(survey, survey->ended, begin),
                 over_end = before(survey, survey->begun, end) - before(survey, survey->ended, end),
                 spanning =
                     before(survey, survey->begun, end) - before(survey, survey->ended, begin);
    touching = least_of(touching, spanning);
    const double others = least_of(2 * least_of(crossing, over_begin + over_end), 3 * touching);
    const double vertex = CORE_VERTEX + OUTPUT_VERTEX +
                          (double)norma_large_position_size(parts->ply) +
                          (parts->equal.words ? 24 : 0);
    return ((double)(end - begin) + others) * vertex +
           touching * (survey->polygons ? POLYGON : TRIANGLE);
}

size_t norma_large_part_end(const large_parts *parts, size_t begin) {
    const large_survey *survey = parts->survey;
    const large_budget *budget = &parts->ply->file->budget;
    const double most = (double)(budget->most - budget->used) * parts->share;
    const size_t vertices = parts->ply->vertices;
    double touching = 0, crossing = 0, so_far = 0;
    size_t end = begin;
    while (end < vertices) {
        const size_t stretch = end / survey->stretch,
                     stretch_end = (size_t)least_of(
                         (double)((stretch + 1) * survey->stretch), (double)vertices);
        const double part = (double)(stretch_end - end) / (double)survey->stretch;
        touching += part * survey->touching[stretch];
        crossing += part * survey->crossing[stretch];
        const double with_it = cost(parts, begin, stretch_end, touching, crossing);
        if (with_it > most) {
            if (most > so_far && with_it > so_far)
                end += (size_t)((double)(stretch_end - end) * (most - so_far) / (with_it - so_far));
            break;
        }
        so_far = with_it;
        end = stretch_end;
    }
    return end > begin ? end : begin + 1 < vertices ? begin + 1 : vertices;
}

size_t norma_large_part_count(const large_parts *parts) {
    size_t count = 0;
    for (size_t at = 0; at < parts->ply->vertices; ++count) at = norma_large_part_end(parts, at);
    return count;
}

/* ---- faces */

static int part_make_room(const large_parts *parts, large_part *part, size_t corners) {
    large_budget *budget = &parts->ply->file->budget;
    const size_t needed = part->corner_count + corners;
    if (needed > UINT32_MAX) return 0; /* starts of faces are 32 bits: a smaller part */
    if (needed > part->corner_capacity) {
        const size_t more = part->corner_capacity / 4 + (size_t)6 * LARGE_CHUNK + corners;
        uint32_t *grown = norma_large_grow(budget, part->corners, part->corner_capacity,
            part->corner_capacity + more, sizeof *grown);
        if (!grown) return 0;
        part->corners = grown;
        part->corner_capacity += more;
    }
    if (!parts->survey->polygons || part->face_count + 1 < part->face_capacity) return 1;
    const size_t more = part->face_capacity / 4 + (size_t)2 * LARGE_CHUNK;
    uint32_t *grown = norma_large_grow(
        budget, part->starts, part->face_capacity, part->face_capacity + more, sizeof *grown);
    if (!grown) return 0;
    part->starts = grown;
    part->face_capacity += more;
    return 1;
}

static int touches(const large_bits *members, const uint32_t *corners, size_t count) {
    int any = 0;
    for (size_t k = 0; k < count; ++k) any |= norma_large_bits_has(members, corners[k]);
    return any;
}

static int part_take_faces(const large_parts *parts, large_part *part) {
    const large_faces *faces = &parts->ply->chunk;
    for (size_t i = 0; i < faces->count; ++i) {
        const uint32_t *corners = faces->corners + faces->starts[i];
        const size_t count = faces->starts[i + 1] - faces->starts[i];
        if (!touches(&part->members, corners, count)) continue;
        if (!part_make_room(parts, part, count)) return 0;
        for (size_t k = 0; k < count; ++k) {
            part->corners[part->corner_count + k] = corners[k];
            norma_large_bits_set(&part->needed, corners[k]);
        }
        part->corner_count += count;
        ++part->face_count;
        if (part->starts) part->starts[part->face_count] = (uint32_t)part->corner_count;
    }
    return 1;
}

static norma_document_result part_gather_faces(const large_parts *parts, large_part *part) {
    const large_survey *survey = parts->survey;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!part_make_room(parts, part, 0)) return NORMA_DOCUMENT_ERROR_MEMORY;
    if (part->starts) part->starts[0] = 0;
    for (size_t i = 0; i < survey->chunk_count && !result; ++i) {
        const large_chunk *chunk = &survey->chunks[i];
        uint64_t offset = chunk->offset;
        if (chunk->least > chunk->most ||
            !norma_large_bits_any(&part->members, chunk->least, (size_t)chunk->most + 1))
            continue;
        part->chunks[part->chunk_count] = (uint32_t)i;
        part->chunk_begins[part->chunk_count++] = (uint32_t)part->face_count;
        result = norma_large_ply_chunk(
            parts->ply, (uint64_t)i * LARGE_CHUNK, norma_large_chunk_faces(parts->ply, i), &offset);
        if (!result && !part_take_faces(parts, part)) result = NORMA_DOCUMENT_ERROR_MEMORY;
        if (!result && i % 64 == 0)
            result =
                norma_large_tell(parts->ply->file, 0.4 * (double)i / (double)survey->chunk_count);
    }
    return result;
}

static void part_number_corners(large_part *part) {
    const size_t range = part->end - part->begin;
    for (size_t c = 0; c < part->corner_count; ++c) {
        const size_t vertex = part->corners[c];
        part->corners[c] = (uint32_t)(vertex - part->begin < range
                                          ? part->first + (vertex - part->begin)
                                          : norma_large_bits_before(&part->needed, vertex));
    }
}

/* ---- the core */

static norma_mesh part_mesh_of(const large_parts *parts, const large_part *part) {
    return (norma_mesh){
        .positions = {.data = part->positions,
            .count = part->count,
            .format = parts->ply->single ? NORMA_FORMAT_FLOAT : NORMA_FORMAT_DOUBLE},
        .corners = part->corners,
        .corner_count = part->corner_count,
        .corner_size = 4,
        .face_starts = part->starts,
        .face_count = part->starts ? part->face_count : 0};
}

typedef struct part_progress {
    large_file *file;
    norma_document_result result;
} part_progress;

static int part_tell(void *user, double fraction) {
    part_progress *progress = user;
    progress->result = norma_large_tell(progress->file, 0.5 + 0.4 * fraction);
    return progress->result != NORMA_DOCUMENT_OK;
}

static norma_document_result result_of(
    const large_parts *parts, norma_result failed, const part_progress *progress) {
    if (failed == NORMA_ERROR_MEMORY) return NORMA_DOCUMENT_ERROR_MEMORY;
    if (failed == NORMA_CANCELLED && progress->result) return progress->result;
    return norma_document_fail_core(parts->ply->file->document, parts->ply->file->error, failed);
}

/* The number in the file of a face of the part. */
static norma_document_result number_in_file(
    const large_parts *parts, large_part *part, size_t face, size_t *number) {
    size_t from = part->chunk_count - 1;
    while (part->chunk_begins[from] > face) --from;
    const size_t chunk = part->chunks[from];
    uint64_t offset = parts->survey->chunks[chunk].offset;
    size_t left = face - part->chunk_begins[from], i = 0;
    norma_document_result result = norma_large_ply_chunk(parts->ply, (uint64_t)chunk * LARGE_CHUNK,
        norma_large_chunk_faces(parts->ply, chunk), &offset);
    const large_faces *faces = &parts->ply->chunk;
    for (; i < faces->count && !result; ++i)
        if (touches(&part->members, faces->corners + faces->starts[i],
                faces->starts[i + 1] - faces->starts[i]) &&
            left-- == 0)
            break;
    *number = chunk * (size_t)LARGE_CHUNK + i;
    return result;
}

/* Each face without a direction counts in the part that has its first corner. */
static norma_document_result part_count_degenerate(const large_parts *parts, large_part *part) {
    large_budget *budget = &parts->ply->file->budget;
    const norma_mesh mesh = part_mesh_of(parts, part);
    float *normals = norma_large_take(budget, part->face_count, 3 * sizeof *normals);
    uint8_t *reasons = norma_large_take(budget, part->face_count, 1);
    norma_options core = parts->core;
    size_t first = SIZE_MAX;
    core.reasons = reasons;
    core.allocator = norma_large_allocator(budget);
    core.progress = NULL;
    norma_result failed = normals && reasons
                              ? norma_face_normals(&mesh, &core, normals, part->face_count, NULL)
                              : NORMA_ERROR_MEMORY;
    for (size_t f = 0; f < part->face_count && !failed; ++f) {
        const size_t corner = part->starts ? part->starts[f] : 3 * f;
        if (reasons[f] != NORMA_REASON_DEGENERATE ||
            part->corners[corner] - part->first >= part->end - part->begin)
            continue;
        if (part->degenerate.count++ == 0) first = f;
    }
    norma_large_give(budget, normals, part->face_count, 3 * sizeof *normals);
    norma_large_give(budget, reasons, part->face_count, 1);
    const part_progress progress = {0};
    if (failed) return result_of(parts, failed, &progress);
    return first == SIZE_MAX ? NORMA_DOCUMENT_OK
                             : number_in_file(parts, part, first, &part->degenerate.first);
}

static norma_document_result part_run_core(const large_parts *parts, large_part *part) {
    large_budget *budget = &parts->ply->file->budget;
    const norma_mesh mesh = part_mesh_of(parts, part);
    norma_options core = parts->core;
    norma_report report;
    part_progress progress = {.file = parts->ply->file};
    part->all_normals = norma_large_take(budget, part->count, 3 * sizeof *part->all_normals);
    part->all_reasons = norma_large_take(budget, part->count, 1);
    if (!part->all_normals || !part->all_reasons) return NORMA_DOCUMENT_ERROR_MEMORY;
    core.reasons = part->all_reasons;
    core.allocator = norma_large_allocator(budget);
    core.progress = part_tell;
    core.progress_user = &progress;
    const norma_result failed =
        norma_vertex_normals(&mesh, &core, part->all_normals, part->count, &report);
    if (failed) return result_of(parts, failed, &progress);
    part->normals = part->all_normals + 3 * part->first;
    part->reasons = part->all_reasons + part->first;
    return report.degenerate_faces.count ? part_count_degenerate(parts, part) : NORMA_DOCUMENT_OK;
}

/* ---- a part as a whole */

static int part_open_part(const large_parts *parts, large_part *part) {
    large_budget *budget = &parts->ply->file->budget;
    const size_t chunks = parts->survey->chunk_count;
    part->chunks = norma_large_take(budget, chunks, sizeof *part->chunks);
    part->chunk_begins = norma_large_take(budget, chunks, sizeof *part->chunk_begins);
    return part->chunks && part->chunk_begins &&
           norma_large_bits_open(budget, parts->ply->vertices, &part->members) &&
           norma_large_bits_open(budget, parts->ply->vertices, &part->needed);
}

norma_document_result norma_large_part_compute(const large_parts *parts, large_part *part) {
    large_budget *budget = &parts->ply->file->budget;
    part->degenerate = (norma_count){0, SIZE_MAX};
    if (!part_open_part(parts, part)) return NORMA_DOCUMENT_ERROR_MEMORY;
    norma_large_bits_set_range(&part->members, part->begin, part->end);
    norma_large_bits_set_range(&part->needed, part->begin, part->end);
    if (parts->anchor != UINT32_MAX) norma_large_bits_set(&part->needed, parts->anchor);
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (parts->equal.words)
        result = large_add_equal(parts->ply, &parts->equal, part->begin, part->end, &part->members);
    if (!result) norma_large_bits_count(&part->members);
    if (!result) result = part_gather_faces(parts, part);
    if (result) return result;
    part->count = norma_large_bits_count(&part->needed);
    part->first = norma_large_bits_before(&part->needed, part->begin);
    part_number_corners(part);
    part->positions = norma_large_take(budget, part->count, norma_large_position_size(parts->ply));
    if (!part->positions) return NORMA_DOCUMENT_ERROR_MEMORY;
    result = norma_large_gather_positions(
        parts->ply, &part->needed, 0, parts->ply->vertices, part->positions);
    return result ? result : part_run_core(parts, part);
}

void norma_large_part_close(const large_parts *parts, large_part *part) {
    large_budget *budget = &parts->ply->file->budget;
    const size_t chunks = parts->survey->chunk_count;
    norma_large_give(budget, part->chunks, chunks, sizeof *part->chunks);
    norma_large_give(budget, part->chunk_begins, chunks, sizeof *part->chunk_begins);
    if (part->members.words) norma_large_bits_close(budget, &part->members);
    if (part->needed.words) norma_large_bits_close(budget, &part->needed);
    norma_large_give(budget, part->corners, part->corner_capacity, sizeof *part->corners);
    norma_large_give(budget, part->starts, part->face_capacity, sizeof *part->starts);
    norma_large_give(budget, part->positions, part->count, norma_large_position_size(parts->ply));
    norma_large_give(budget, part->all_normals, part->count, 3 * sizeof *part->all_normals);
    norma_large_give(budget, part->all_reasons, part->count, 1);
    *part = (large_part){.begin = part->begin, .end = part->end};
}
