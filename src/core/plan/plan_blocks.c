/* plan_blocks.c: the blocks of faces that groups are listed in. Stars are taken along a curve until
 * a block is full; then its faces and vertices are numbered and its lists written behind those of
 * the block before. */
#include "core/plan/plan.h"
#include <math.h>

/* ---- Positions in the order of a curve that stays near itself (Morton 1966), so that
 * those that follow each other are neighbours, whatever the order of the mesh. */

enum { LEVELS = 16, KEY_BITS = 32, DIGIT_BITS = 11, DIGITS = 3 };

typedef struct curve {
    double low[3], scale;
    uint32_t spread[3][2][256]; /* what a byte of a coordinate contributes to the key */
} curve;

static void find_box(const core_mesh *mesh, double low[3], double high[3]) {
    for (int k = 0; k < 3; k++) {
        low[k] = INFINITY;
        high[k] = -INFINITY;
    }
    for (size_t p = 0; p < mesh->positions.count; p++) {
        double at[3];
        norma_core_position(mesh, (uint32_t)p, at);
        if (!norma_core_finite(at)) continue;
        for (int k = 0; k < 3; k++) {
            low[k] = at[k] < low[k] ? at[k] : low[k];
            high[k] = at[k] > high[k] ? at[k] : high[k];
        }
    }
}

static int levels_of(double extent, double scale) {
    int levels = 0;
    for (uint32_t cells = (uint32_t)(extent * scale); cells; cells >>= 1) levels++;
    return levels;
}

/* Cells are cubes; an axis along which the mesh is thin has fewer of them, and takes fewer bits of
 * the key. */
static void lay_out_curve(curve *c, const int levels[3]) {
    int bit = KEY_BITS;
    memset(c->spread, 0, sizeof c->spread);
    for (int level = LEVELS; level-- > 0 && bit > 0;)
        for (int k = 0; k < 3 && bit > 0; k++) {
            if (level >= levels[k]) continue;
            bit--;
            for (uint32_t byte = 0; byte < 256; byte++)
                if (byte >> (level % 8) & 1) c->spread[k][level / 8][byte] |= (uint32_t)1 << bit;
        }
}

static void begin_curve(const core_mesh *mesh, curve *c) {
    double high[3], widest = 0;
    int levels[3];
    find_box(mesh, c->low, high);
    for (int k = 0; k < 3; k++) widest = fmax(widest, high[k] - c->low[k]);
    c->scale = widest > 0 && widest <= 0x1p1000 ? ((1 << LEVELS) - 1) / widest : 0;
    if (!(c->scale <= 0x1p1000)) c->scale = 0;
    for (int k = 0; k < 3; k++)
        levels[k] = c->scale > 0 ? levels_of(high[k] - c->low[k], c->scale) : 0;
    lay_out_curve(c, levels);
}

static uint32_t key_on_curve(const curve *c, const double p[3]) {
    uint32_t key = 0;
    if (!norma_core_finite(p)) return UINT32_MAX;
    for (int k = 0; k < 3; k++) {
        const uint32_t cell = (uint32_t)((p[k] - c->low[k]) * c->scale) & 0xffff;
        key |= c->spread[k][0][cell & 255] | c->spread[k][1][cell >> 8];
    }
    return key;
}

/* Radix sort by the high words, the low ones ascending before and after. */
static void sort_by_key(uint64_t *items, uint64_t *other, size_t count) {
    for (int digit = 0; digit < DIGITS; digit++) {
        const int shift = 32 + digit * DIGIT_BITS;
        size_t starts[1 << DIGIT_BITS], sum = 0;
        memset(starts, 0, sizeof starts);
        for (size_t i = 0; i < count; i++) starts[items[i] >> shift & ((1 << DIGIT_BITS) - 1)]++;
        for (size_t d = 0; d < (size_t)1 << DIGIT_BITS; d++) {
            const size_t here = starts[d];
            starts[d] = sum;
            sum += here;
        }
        for (size_t i = 0; i < count; i++)
            other[starts[items[i] >> shift & ((1 << DIGIT_BITS) - 1)]++] = items[i];
        uint64_t *sorted = other;
        other = items;
        items = sorted;
    }
}

/* The positions that have corners, in an order in which neighbours are near each
 * other; order has room for all positions. */
static norma_result core_plan_order(
    const core_prepared_mesh *prepared, uint32_t *order, size_t *count) {
    const core_mesh *mesh = &prepared->mesh;
    const size_t room = mesh->positions.count;
    uint64_t *items = norma_core_allocate(prepared->call, room, sizeof *items),
             *other = norma_core_allocate(prepared->call, room, sizeof *other);
    *count = 0;
    if (items && other) {
        curve c;
        begin_curve(mesh, &c);
        for (size_t p = 0; p < room; p++) {
            double at[3];
            if (prepared->corners_of.starts[p] == prepared->corners_of.starts[p + 1]) continue;
            norma_core_position(mesh, (uint32_t)p, at);
            items[(*count)++] = (uint64_t)key_on_curve(&c, at) << 32 | p;
        }
        sort_by_key(items, other, *count);
        for (size_t i = 0; i < *count; i++) order[i] = (uint32_t)(DIGITS % 2 ? other[i] : items[i]);
    }
    const norma_result result = items && other ? NORMA_OK : NORMA_ERROR_MEMORY;
    norma_core_release(prepared->call, items, room, sizeof *items);
    norma_core_release(prepared->call, other, room, sizeof *other);
    return result;
}

enum {
    TABLE = 1 << 12,
    FIRST_BLOCKS = 16,
    BLOCK_FOURS = BLOCK_SLOTS / 4,
    MOST_IN_FOURS = 2 * BLOCK_CORNERS
};

/* Numbers of the mesh, each with a number of the block's. */
typedef struct block_table {
    uint32_t keys[TABLE]; /* and 1 */
    uint16_t values[TABLE];
    uint32_t count;
} block_table;

typedef struct staged_group {
    uint32_t member_end, vertex_end;
    int joined;
} staged_group;

/* Groups as they come, by the mesh's numbers. */
typedef struct block_stage {
    size_t group_count, member_count, vertex_count;
    staged_group groups[BLOCK_SLOTS];
    uint32_t members[BLOCK_MEMBERS], vertices[BLOCK_VERTICES];
    int overflow, first_at_position;
} block_stage;

typedef struct block_builder {
    norma_plan *plan;
    plan_groups *groups;
    const core_mesh *mesh;
    const uint32_t *corner_faces; /* polygons */
    uint8_t *overflow;
    block_table faces, vertices, own;
    block_stage stage, star;
    uint32_t face_list[BLOCK_FACES], vertex_list[BLOCK_VERTICES];
    uint32_t corner_count; /* of the faces listed */
    uint32_t *words;       /* growing */
    size_t word_count, word_room;
    plan_block *blocks;
    size_t block_count, block_room, occurrences;
    norma_result result;
} block_builder;

/* ---- tables */

static uint32_t group_in_table(const block_table *t, uint32_t key) {
    uint32_t at = (key * UINT32_C(0x9e3779b1)) >> 20;
    while (t->keys[at] && t->keys[at] != key + 1) at = (at + 1) & (TABLE - 1);
    return at;
}

static void clear_table(block_table *t) {
    memset(t->keys, 0, sizeof t->keys);
    t->count = 0;
}

/* Whether the key is new; it then gets the next number. */
static int enter(block_table *t, uint32_t key) {
    const uint32_t at = group_in_table(t, key);
    if (t->keys[at]) return 0;
    t->keys[at] = key + 1;
    t->values[at] = (uint16_t)t->count++;
    return 1;
}

static uint32_t number_in_block(const block_table *t, uint32_t key) {
    return t->values[group_in_table(t, key)];
}
static int has(const block_table *t, uint32_t key) { return t->keys[group_in_table(t, key)] != 0; }

static uint32_t block_face_of(const block_builder *b, uint32_t corner) {
    return b->corner_faces ? b->corner_faces[corner] : corner / 3;
}

/* ---- staging */

static void clear_stage(block_stage *s) {
    s->group_count = s->member_count = s->vertex_count = 0;
    s->overflow = 0;
}

static void stage_group(void *context, const uint32_t *members, size_t member_count,
    const uint32_t *vertices, size_t vertex_count) {
    block_stage *s = context;
    if (s->group_count == BLOCK_SLOTS || member_count > BLOCK_MEMBERS - s->member_count ||
        vertex_count > BLOCK_VERTICES - s->vertex_count)
        s->overflow = 1;
    if (s->overflow) return;
    memcpy(s->members + s->member_count, members, member_count * sizeof *members);
    if (vertex_count)
        memcpy(s->vertices + s->vertex_count, vertices, vertex_count * sizeof *vertices);
    s->member_count += member_count;
    s->vertex_count += vertex_count;
    s->groups[s->group_count++] =
        (staged_group){(uint32_t)s->member_count, (uint32_t)s->vertex_count, !s->first_at_position};
    s->first_at_position = 0;
}

static int join_stage(block_stage *s, const block_stage *star) {
    if (s->group_count + star->group_count > BLOCK_SLOTS ||
        s->member_count + star->member_count > BLOCK_MEMBERS ||
        s->vertex_count + star->vertex_count > BLOCK_VERTICES)
        return 0;
    memcpy(s->members + s->member_count, star->members, star->member_count * sizeof *s->members);
    memcpy(s->vertices + s->vertex_count, star->vertices, star->vertex_count * sizeof *s->vertices);
    for (size_t i = 0; i < star->group_count; i++) {
        s->groups[s->group_count + i] = star->groups[i];
        s->groups[s->group_count + i].member_end += (uint32_t)s->member_count;
        s->groups[s->group_count + i].vertex_end += (uint32_t)s->vertex_count;
    }
    s->group_count += star->group_count;
    s->member_count += star->member_count;
    s->vertex_count += star->vertex_count;
    return 1;
}

/* ---- the faces and vertices of a block to be; 0 where one more star does not fit, the tables then
 * of no more use than for what was there before */

typedef struct block_mark {
    uint32_t faces, vertices, corners;
} block_mark;

static void take_back_position(block_table *t, const uint32_t *list, uint32_t count) {
    /* Keys that came last are nobody's way to another's place but theirs: taken out in reverse, the
     * table is as it was. */
    while (t->count > count) t->keys[group_in_table(t, list[--t->count])] = 0;
}

static int enter_vertex(block_builder *b, uint32_t vertex) {
    if (has(&b->vertices, vertex)) return 1;
    if (b->vertices.count == BLOCK_VERTICES) return 0;
    b->vertex_list[b->vertices.count] = vertex;
    return enter(&b->vertices, vertex);
}

static int enter_face(block_builder *b, uint32_t face) {
    const size_t begin = norma_core_face_begin(b->mesh, face),
                 end = norma_core_face_end(b->mesh, face);
    if (has(&b->faces, face)) return 1;
    if (b->faces.count == BLOCK_MOST_FACES || end - begin > BLOCK_CORNERS - b->corner_count)
        return 0;
    b->face_list[b->faces.count] = face;
    enter(&b->faces, face);
    b->corner_count += (uint32_t)(end - begin);
    for (size_t c = begin; c < end; c++)
        if (!enter_vertex(b, norma_core_corner(b->mesh, c))) return 0;
    return 1;
}

static int enter_star(block_builder *b, const block_stage *star) {
    const block_mark before = {b->faces.count, b->vertices.count, b->corner_count};
    int fits = 1;
    for (size_t i = 0; i < star->member_count && fits; i++)
        fits = enter_face(b, block_face_of(b, star->members[i]));
    if (fits && join_stage(&b->stage, star)) return 1;
    take_back_position(&b->faces, b->face_list, before.faces);
    take_back_position(&b->vertices, b->vertex_list, before.vertices);
    b->corner_count = before.corners;
    return 0;
}

static void begin_block(block_builder *b) {
    clear_table(&b->faces);
    clear_table(&b->vertices);
    clear_stage(&b->stage);
    b->corner_count = 0;
}

/* ---- writing a block */

static int grow_block(const core_call *call, void **memory, size_t *room, size_t count,
    size_t wanted, size_t size, size_t first) {
    size_t larger = *room ? *room : first;
    while (larger < wanted) larger += larger / 4 + 64;
    if (*memory && larger == *room) return 1;
    void *store = norma_core_allocate(call, larger, size);
    if (!store) return 0;
    if (*memory) memcpy(store, *memory, count * size);
    norma_core_release(call, *memory, *room, size);
    *memory = store;
    *room = larger;
    return 1;
}

static size_t halves(size_t count) { return count / 2 + count % 2; }

static void write_halves(block_builder *b, const uint16_t *numbers, size_t count) {
    b->words[b->word_count + halves(count) - (count != 0)] = 0;
    memcpy(b->words + b->word_count, numbers, count * sizeof *numbers);
    b->word_count += halves(count);
}

static void write_block_words(block_builder *b, const uint32_t *numbers, size_t count) {
    memcpy(b->words + b->word_count, numbers, count * sizeof *numbers);
    b->word_count += count;
}

/* Everything of the block in the block's numbers, before it is written. */
typedef struct block_draft {
    uint32_t vertices[BLOCK_VERTICES], face_starts[BLOCK_FACES + 1], mesh_corners[BLOCK_FACES],
        weld[BLOCK_VERTICES];
    uint16_t corners[BLOCK_CORNERS], corner_faces[BLOCK_CORNERS],
        member_starts[BLOCK_SLOTS + BLOCK_VERTICES + 1], members[BLOCK_MEMBERS + BLOCK_CORNERS],
        vertex_starts[BLOCK_SLOTS + 1], group_of[BLOCK_VERTICES], place[BLOCK_CORNERS],
        four_counts[BLOCK_FOURS], fours[MOST_IN_FOURS];
    plan_block block;
} block_draft;

/* Own vertices in the order of their groups, then those that only take part in faces. */
static void number_own(block_builder *b, block_draft *d) {
    const block_stage *s = &b->stage;
    const int per_vertex = b->plan->of == NORMA_PER_VERTEX;
    uint32_t first = 0, begin = 0;
    clear_table(&b->own);
    d->block.one_each = (uint8_t)per_vertex;
    for (uint32_t i = 0; i < s->group_count; i++) {
        const uint32_t end = per_vertex ? s->groups[i].vertex_end : s->groups[i].member_end;
        if (!s->groups[i].joined) first = i;
        if (b->own.count != i) d->block.one_each = 0;
        d->vertex_starts[i] = (uint16_t)b->own.count;
        for (uint32_t m = begin; m < end; m++) {
            const uint32_t vertex =
                per_vertex ? s->vertices[m] : norma_core_corner(b->mesh, s->members[m]);
            if (!enter(&b->own, vertex)) continue;
            d->group_of[b->own.count - 1] = (uint16_t)(per_vertex ? i : first);
            d->vertices[b->own.count - 1] = vertex;
        }
        begin = end;
    }
    d->block.group_count = (uint16_t)s->group_count;
    d->block.own_count = (uint16_t)b->own.count;
    d->vertex_starts[s->group_count] = (uint16_t)b->own.count;
    if (b->own.count != s->group_count) d->block.one_each = 0;
    d->block.plain = d->block.one_each;
    for (uint32_t i = 0; i < s->group_count; i++)
        if (s->groups[i].joined) d->block.plain = 0;
}

static void number_block_corners(block_builder *b, block_draft *d) {
    uint32_t corners = 0;
    for (uint32_t f = 0; f < b->faces.count; f++) {
        const size_t begin = norma_core_face_begin(b->mesh, b->face_list[f]),
                     end = norma_core_face_end(b->mesh, b->face_list[f]);
        d->face_starts[f] = corners;
        d->mesh_corners[f] = (uint32_t)begin;
        for (size_t c = begin; c < end; c++) {
            const uint32_t vertex = norma_core_corner(b->mesh, c);
            if (enter(&b->own, vertex)) d->vertices[b->own.count - 1] = vertex;
            d->place[corners] = (uint16_t)norma_core_block_member(
                b->mesh->face_starts != NULL, f, (uint32_t)(c - begin), corners);
            d->corner_faces[corners] = (uint16_t)f;
            d->corners[corners++] = (uint16_t)number_in_block(&b->own, vertex);
        }
    }
    d->face_starts[b->faces.count] = corners;
    d->block.face_count = (uint16_t)b->faces.count;
    d->block.corner_count = (uint16_t)corners;
    d->block.vertex_count = (uint16_t)b->own.count;
}

static void list_own_members(block_builder *b, block_draft *d) {
    const block_stage *s = &b->stage;
    uint32_t begin = 0;
    for (size_t i = 0; i < s->group_count; i++) {
        d->member_starts[i] = (uint16_t)(begin | (s->groups[i].joined ? BLOCK_JOINED : 0U));
        for (uint32_t m = begin; m < s->groups[i].member_end; m++) {
            const uint32_t face = number_in_block(&b->faces, block_face_of(b, s->members[m])),
                           number = s->members[m] - d->mesh_corners[face];
            d->members[m] = d->place[d->face_starts[face] + number];
        }
        begin = s->groups[i].member_end;
    }
}

/* The corners here of vertices that are not own: a counting sort. */
static void list_other_members(block_draft *d) {
    const uint32_t own = d->block.own_count, others = d->block.vertex_count - own;
    uint16_t *starts = d->member_starts + d->block.group_count;
    uint32_t sum = d->block.member_count;
    for (uint32_t i = 0; i < others; i++) starts[i] = 0;
    for (uint32_t c = 0; c < d->block.corner_count; c++)
        if (d->corners[c] >= own) starts[d->corners[c] - own]++;
    for (uint32_t i = 0; i < others; i++) starts[i] = (uint16_t)(sum += starts[i]);
    starts[others] = (uint16_t)sum;
    for (uint32_t c = d->block.corner_count; c-- > 0;)
        if (d->corners[c] >= own) d->members[--starts[d->corners[c] - own]] = d->place[c];
    d->block.member_count = (uint16_t)sum;
}

/* The members of four groups, one of each in turn, so that they are added up side by side without
 * asking who has one more: who has none left has BLOCK_NOBODY. Groups up to a multiple of eight are
 * the last one again. Where that takes much more room than the members themselves, there are none.
 */
static void list_fours(block_draft *d) {
    const uint32_t groups = d->block.group_count, fours = 2 * norma_core_block_eights(groups);
    const uint32_t all = d->member_starts[groups] & (BLOCK_JOINED - 1U),
                   most = all + all / 2 + 64 < MOST_IN_FOURS ? all + all / 2 + 64 : MOST_IN_FOURS;
    uint32_t listed = 0;
    d->block.four_count = 0;
    for (uint32_t i = 0; i < fours; i++) {
        uint32_t begin[4], count[4], longest = 0;
        for (uint32_t k = 0; k < 4; k++) {
            const uint32_t group = 4 * i + k < groups ? 4 * i + k : groups - 1;
            begin[k] = d->member_starts[group] & (BLOCK_JOINED - 1U);
            count[k] = (d->member_starts[group + 1] & (BLOCK_JOINED - 1U)) - begin[k];
            longest = count[k] > longest ? count[k] : longest;
        }
        if (d->block.polygons || listed + 4 * longest > most) return;
        d->four_counts[i] = (uint16_t)longest;
        for (uint32_t m = 0; m < longest; m++)
            for (uint32_t k = 0; k < 4; k++)
                d->fours[listed++] =
                    m < count[k] ? d->members[begin[k] + m] : (uint16_t)BLOCK_NOBODY;
    }
    d->block.four_count = listed;
}

/* Triangles up to a multiple of eight are the last one again. */
static void fill_eights(block_draft *d) {
    for (uint32_t c = d->block.corner_count;
         c < 3 * CORE_LANES * norma_core_block_eights(d->block.face_count); c++)
        d->corners[c] = d->corners[c - 3];
}

static void find_shared_corners(block_builder *b, block_draft *d) {
    clear_table(&b->vertices);
    d->block.welded = 0;
    for (uint32_t v = 0, first[BLOCK_VERTICES]; v < d->block.vertex_count; v++) {
        const uint32_t position = norma_core_welded(b->mesh, d->vertices[v]);
        if (enter(&b->vertices, position)) first[b->vertices.count - 1] = v;
        d->weld[v] = first[number_in_block(&b->vertices, position)];
        d->block.welded |= d->weld[v] != v;
    }
}

static size_t corners_kept(const plan_block *t) {
    return t->polygons ? t->corner_count
                       : (size_t)3 * CORE_LANES * norma_core_block_eights(t->face_count);
}
static size_t fours_of(const plan_block *t) {
    return t->four_count ? 2 * (size_t)norma_core_block_eights(t->group_count) : 0;
}

static size_t words_of_block(const plan_block *t) {
    const size_t polygons = t->polygons != 0;
    return t->vertex_count * (size_t)(1 + (t->welded != 0)) + t->face_count * (1 + 2 * polygons) +
           polygons + halves(corners_kept(t)) * (1 + polygons) +
           halves((size_t)t->group_count + t->vertex_count - t->own_count + 1) +
           halves(t->member_count) + halves(fours_of(t)) + halves(t->four_count) +
           halves((size_t)t->group_count + 1) + halves(t->own_count);
}

static void write_draft(block_builder *b, const block_draft *d) {
    const plan_block *t = &d->block;
    write_block_words(b, d->vertices, t->vertex_count);
    write_block_words(b, b->face_list, t->face_count);
    if (t->polygons) write_block_words(b, d->mesh_corners, t->face_count);
    if (t->polygons) write_block_words(b, d->face_starts, (size_t)t->face_count + 1);
    if (t->welded) write_block_words(b, d->weld, t->vertex_count);
    write_halves(b, d->corners, corners_kept(t));
    if (t->polygons) write_halves(b, d->corner_faces, t->corner_count);
    write_halves(b, d->member_starts, (size_t)t->group_count + t->vertex_count - t->own_count + 1);
    write_halves(b, d->members, t->member_count);
    write_halves(b, d->four_counts, fours_of(t));
    write_halves(b, d->fours, t->four_count);
    if (t->one_each) return;
    if (b->plan->of == NORMA_PER_VERTEX)
        write_halves(b, d->vertex_starts, (size_t)t->group_count + 1);
    write_halves(b, d->group_of, t->own_count);
}

block_view norma_core_block(const norma_plan *plan, size_t block) {
    const plan_block *t = &plan->blocks[block];
    const uint32_t *words = plan->words + t->at;
    block_view v = {t->vertex_count, t->own_count, t->group_count, t->face_count, t->corner_count,
        t->member_count, t->first_occurrence, t->four_count, t->plain, .vertices = words};
    v.faces = words += t->vertex_count;
    words += t->face_count;
    if (t->polygons) {
        v.mesh_corners = words;
        v.face_starts = words += t->face_count;
        words += t->face_count + 1U;
    }
    if (t->welded) {
        v.weld = words;
        words += t->vertex_count;
    }
    const uint16_t *numbers = (const uint16_t *)(const void *)words;
    v.corners = numbers;
    numbers += 2 * halves(corners_kept(t));
    if (t->polygons) {
        v.corner_faces = numbers;
        numbers += 2 * halves(t->corner_count);
    }
    v.member_starts = numbers;
    v.members = numbers += 2 * halves((size_t)t->group_count + t->vertex_count - t->own_count + 1);
    numbers += 2 * halves(t->member_count);
    if (t->four_count) {
        v.four_counts = numbers;
        v.fours = numbers += 2 * halves(fours_of(t));
        numbers += 2 * halves(t->four_count);
    }
    if (t->one_each) return v;
    if (plan->of == NORMA_PER_VERTEX) {
        v.vertex_starts = numbers;
        numbers += 2 * halves((size_t)t->group_count + 1);
    }
    v.group_of = numbers;
    return v;
}

static void draft_block(block_builder *b, block_draft *d) {
    d->block = (plan_block){.at = b->word_count,
        .first_occurrence = (uint32_t)b->occurrences,
        .polygons = b->mesh->face_starts != NULL};
    number_own(b, d);
    number_block_corners(b, d);
    list_own_members(b, d);
    d->block.member_count = (uint16_t)b->stage.member_count;
    list_other_members(d);
    list_fours(d);
    if (!d->block.polygons) fill_eights(d);
    find_shared_corners(b, d);
}

/* What a mesh of triangles, two for each vertex, takes, and a little more. */
static size_t about_words(const block_builder *b) { return 14 * (b->mesh->corner_count / 6) + 256; }

static void end_block(block_builder *b, block_draft *d) {
    const core_call *call = b->groups->prepared->call;
    if (!b->stage.group_count || b->result != NORMA_OK) return;
    draft_block(b, d);
    if (!grow_block(call, (void **)&b->words, &b->word_room, b->word_count,
            b->word_count + words_of_block(&d->block), sizeof *b->words, about_words(b)) ||
        !grow_block(call, (void **)&b->blocks, &b->block_room, b->block_count, b->block_count + 1,
            sizeof *b->blocks, FIRST_BLOCKS) ||
        b->occurrences > UINT32_MAX - BLOCK_VERTICES) {
        b->result = NORMA_ERROR_MEMORY;
        return;
    }
    write_draft(b, d);
    b->blocks[b->block_count++] = d->block;
    b->occurrences += d->block.vertex_count;
    begin_block(b);
}

/* ---- all of them */

static void take_star(block_builder *b, block_draft *d, uint32_t position) {
    const uint32_t *starts = b->groups->prepared->corners_of.starts;
    clear_stage(&b->star);
    b->star.first_at_position = 1;
    if (starts[position + 1] - starts[position] > BLOCK_STAR)
        b->star.overflow = 1;
    else
        norma_core_plan_groups_at(b->groups, position, stage_group, &b->star);
    if (!b->star.overflow && enter_star(b, &b->star)) return;
    if (!b->star.overflow && b->stage.group_count) {
        end_block(b, d);
        if (b->result != NORMA_OK || enter_star(b, &b->star)) return;
    }
    b->overflow[position] = 1;
}

/* A store that is nearly full becomes the plan's as it is: to copy it would cost fresh memory. */
static void *keep_grown(norma_plan *plan, void **memory, size_t *room, size_t count, size_t size) {
    if (*memory && *room - count <= count / 8 && plan->store_count < PLAN_MOST_BLOCKS) {
        void *kept = *memory;
        plan->stores[plan->store_count++] = (plan_store){kept, *room, size};
        plan->bytes += *room * size;
        *memory = NULL;
        *room = 0;
        return kept;
    }
    void *copy = norma_core_plan_keep(plan, count, size);
    if (copy && count) memcpy(copy, *memory, count * size);
    return copy;
}

static norma_result keep_blocks(block_builder *b) {
    norma_plan *plan = b->plan;
    plan->blocks =
        keep_grown(plan, (void **)&b->blocks, &b->block_room, b->block_count, sizeof *plan->blocks);
    plan->words =
        keep_grown(plan, (void **)&b->words, &b->word_room, b->word_count, sizeof *plan->words);
    if (!plan->blocks || !plan->words) return NORMA_ERROR_MEMORY;
    plan->block_count = b->block_count;
    plan->occurrence_count = b->occurrences;
    return NORMA_OK;
}

/* Where each vertex of the mesh occurs. */
static norma_result list_occurrences(norma_plan *plan) {
    const size_t count = plan->vertex_count;
    plan->occurrence_starts =
        norma_core_plan_keep(plan, count + 1, sizeof *plan->occurrence_starts);
    plan->occurrences =
        norma_core_plan_keep(plan, plan->occurrence_count, sizeof *plan->occurrences);
    if (!plan->occurrence_starts || !plan->occurrences) return NORMA_ERROR_MEMORY;
    uint32_t *starts = plan->occurrence_starts, sum = 0;
    memset(starts, 0, (count + 1) * sizeof *starts);
    for (size_t t = 0; t < plan->block_count; t++)
        for (uint32_t i = 0; i < plan->blocks[t].vertex_count; i++)
            starts[plan->words[plan->blocks[t].at + i]]++;
    for (size_t v = 0; v < count; v++) starts[v] = sum += starts[v];
    starts[count] = sum;
    for (size_t t = plan->block_count; t-- > 0;)
        for (uint32_t i = plan->blocks[t].vertex_count; i-- > 0;)
            plan->occurrences[--starts[plan->words[plan->blocks[t].at + i]]] =
                plan->blocks[t].first_occurrence + i;
    return NORMA_OK;
}

static norma_result keep_marks(norma_plan *plan) {
    if (plan->occurrence_count <= MARKS_IN_BLOCK) return NORMA_OK;
    plan_shared *shared = norma_core_plan_keep(plan, 1, sizeof *shared);
    uint64_t *bits = norma_core_plan_keep(plan, plan->occurrence_count / 64 + 1, sizeof *bits);
    if (!shared || !bits) return NORMA_ERROR_MEMORY;
    memset(bits, 0, (plan->occurrence_count / 64 + 1) * sizeof *bits);
    *shared = (plan_shared){ATOMIC_FLAG_INIT, bits};
    plan->shared = shared;
    return NORMA_OK;
}

static norma_result build_blocks(
    block_builder *b, block_draft *d, const uint32_t *order, size_t count) {
    enum { RINGS_BETWEEN_TELLING = 1 << 16 };
    begin_block(b);
    for (size_t i = 0; i < count && b->result == NORMA_OK; i++) {
        if (i % RINGS_BETWEEN_TELLING == 0 &&
            norma_core_progress(b->groups->prepared->call, (double)i / (double)count))
            return NORMA_CANCELLED;
        take_star(b, d, order[i]);
    }
    end_block(b, d);
    if (b->result == NORMA_OK) b->result = keep_blocks(b);
    return b->result;
}

norma_result norma_core_plan_block(norma_plan *plan, plan_groups *groups, uint8_t *overflow) {
    const core_prepared_mesh *prepared = groups->prepared;
    const core_call *call = prepared->call;
    const size_t count = prepared->mesh.positions.count;
    size_t ordered = 0;
    uint32_t *order = norma_core_allocate(call, count, sizeof *order);
    block_builder *b = norma_core_allocate(call, 1, sizeof *b);
    block_draft *d = norma_core_allocate(call, 1, sizeof *d);
    norma_result result =
        order && b && d ? core_plan_order(prepared, order, &ordered) : NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) {
        memset(b, 0, sizeof *b);
        b->plan = plan;
        b->groups = groups;
        b->mesh = &prepared->mesh;
        b->corner_faces = prepared->corners_of.faces;
        b->overflow = overflow;
        result = build_blocks(b, d, order, ordered);
        norma_core_release(call, b->words, b->word_room, sizeof *b->words);
        norma_core_release(call, b->blocks, b->block_room, sizeof *b->blocks);
        if (result == NORMA_OK) result = list_occurrences(plan);
        if (result == NORMA_OK) result = keep_marks(plan);
    }
    norma_core_release(call, order, count, sizeof *order);
    norma_core_release(call, b, 1, sizeof *b);
    norma_core_release(call, d, 1, sizeof *d);
    return result;
}
