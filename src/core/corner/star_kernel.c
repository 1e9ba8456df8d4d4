/* star_kernel.c: ordinary stars, many at a time: their triangles are measured eight at a time, what
 * memory has to say is asked for ahead, and fans are joined and summed in loops over lanes. */
#include "core/corner/star_kernel.h"
#include "core/face/eight_vectors.h"
#include "core/face/face.h"
#include "core/call/call.h"
#include "core/mesh/mesh.h"

void norma_core_clear_measured(measured_faces *m) {
    memset(m->number, 0xff, sizeof m->number);
    memset(m->used, 0, sizeof m->used);
    m->batch = 1;
    m->waiting_count = 0;
}

CORE_INLINE void load_edges(
    const core_mesh *mesh, const uint32_t at[3 * CORE_LANES], core_batch *batch) {
    double p[3][3];
    if (core_can_gather(mesh)) {
        core_gather_edges(core_points_of(mesh, at, 3), batch);
        return;
    }
    for (int i = 0; i < CORE_LANES; i++) {
        for (int k = 0; k < 3; k++) norma_core_position(mesh, at[3 * i + k], p[k]);
        core_set_edges(batch, i, (const double(*)[3])p);
    }
}

/* Eight faces, and where they go. */
typedef void measure_eight(
    const core_prepared_mesh *s, const uint32_t *faces, const uint16_t *places, measured_face *out);

CORE_INLINE void measure(const core_prepared_mesh *s, const uint32_t *faces, const uint16_t *places,
    measured_face *out) {
    uint32_t at[3 * CORE_LANES];
    core_batch b;
    core_rows normals, weights;
    for (size_t i = 0; i < CORE_LANES; i++)
        for (size_t k = 0; k < 3; k++)
            at[3 * i + k] = norma_core_corner(&s->mesh, 3 * (size_t)faces[i] + k);
    load_edges(&s->mesh, at, &b);
    norma_core_measure(s->call->level, &b, s->call->options.weight, CORE_ALL_CORNERS);
    core_lanes_to_rows(b.normal[0], b.normal[1], b.normal[2], b.sure, &normals);
    core_lanes_to_rows(b.weight[0], b.weight[1], b.weight[2], b.sure, &weights);
    for (size_t i = 0; i < CORE_LANES; i++) {
        memcpy(out[places[i]].normal, normals.row[i], sizeof out->normal);
        memcpy(out[places[i]].weight, weights.row[i], sizeof out->weight);
    }
}

static void measure_portable(const core_prepared_mesh *s, const uint32_t *faces,
    const uint16_t *places, measured_face *out) {
    measure(s, faces, places, out);
}
#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static void measure_avx2(const core_prepared_mesh *s, const uint32_t *faces,
    const uint16_t *places, measured_face *out) {
    measure(s, faces, places, out);
}
static measure_eight *const MEASURE[] = {
    measure_portable, measure_avx2, measure_avx2}; /* rows are of four */
#else
static measure_eight *const MEASURE[] = {measure_portable};
#endif

void norma_core_measure_waiting(const core_prepared_mesh *prepared, measured_faces *m) {
    measure_eight *const measure_them = MEASURE[prepared->call->level];
    for (uint32_t i = m->waiting_count; i % CORE_LANES; i++) {
        m->waiting[i] = m->waiting[0];
        m->waiting_place[i] = m->waiting_place[0];
    }
    for (uint32_t i = 0; i < m->waiting_count; i += CORE_LANES)
        measure_them(prepared, m->waiting + i, m->waiting_place + i, m->room);
    m->waiting_count = 0;
    m->batch++;
}

/* ---- small meshes */

/* No more than what is small beside a thread's stack: 64 kB. */
enum { SMALL_FACES = 1 << 10, FACES_IN_TASK = 1 << 9 };
_Static_assert(SMALL_FACES <= UINT16_MAX, "a place is a face's number");

static void measure_task(void *context, size_t task) {
    const core_prepared_mesh *s = context;
    const size_t count = s->mesh.face_count, begin = task * FACES_IN_TASK,
                 end = count - begin < FACES_IN_TASK ? count : begin + FACES_IN_TASK;
    for (size_t f = begin; f < end; f += CORE_LANES) {
        uint32_t faces[CORE_LANES];
        uint16_t places[CORE_LANES];
        for (size_t i = 0; i < CORE_LANES; i++) {
            faces[i] = (uint32_t)(f + i < end ? f + i : f);
            places[i] = (uint16_t)faces[i];
        }
        MEASURE[s->call->level](s, faces, places, s->measured);
    }
}

norma_result norma_core_measure_small(core_prepared_mesh *s) {
    const size_t faces = s->mesh.face_count;
    if (s->mesh.face_starts || s->measured || faces > SMALL_FACES ||
        s->corners_of.starts[s->corners_of.position_count] < faces)
        return NORMA_OK;
    if (!(s->measured = norma_core_allocate(s->call, faces, sizeof *s->measured)))
        return NORMA_ERROR_MEMORY;
    return norma_core_parallel(
        s->call, faces / FACES_IN_TASK + (faces % FACES_IN_TASK != 0), measure_task, s);
}

/* ---- what memory has to say about a batch of stars. In meshes of random order each of a corner's
 * reads misses the caches, so they are asked for in stages, each while something else is computed,
 * so that memory is never idle: the mesh's corners two batches ahead, the positions that these name
 * one batch ahead, the places where the normals go when the star is first touched. */

enum { CORNERS_AHEAD = 2 * BATCH_CORNERS, NEAR = 1 << 17 };

int norma_core_can_batch(const core_prepared_mesh *prepared) {
    const norma_options *o = &prepared->call->options;
    return o->weight != NORMA_WEIGHT_VISIBLE &&
           !(prepared->mesh.weld && o->weld == NORMA_WELD_DISTANCE);
}

void norma_core_clear_batch(fan_batch *batch) {
    norma_core_clear_measured(&batch->measured);
    memset(batch->notes, 0, sizeof batch->notes);
}

void norma_core_clear_list(star_list *list, const position_visit *visit) {
    list->visit = visit;
    list->corner_count = 0;
    list->star_count = 0;
}

static void read_polygon_corners(const core_prepared_mesh *prepared, star_list *list) {
    const core_mesh *mesh = &prepared->mesh;
    for (size_t i = 0; i < list->corner_count; i++) {
        const size_t corner = list->corners[i],
                     face = norma_core_face_of(&prepared->corners_of, list->corners[i]);
        list->face[i] = (uint32_t)face;
        list->turn[i] = 0;
        list->next[i] = norma_core_corner(mesh, norma_core_next_in_face(mesh, face, corner));
        list->previous[i] =
            norma_core_corner(mesh, norma_core_previous_in_face(mesh, face, corner));
    }
}

/* Corners of 32 bits in a loop without a question inside. */
static inline uint32_t corner_at(const core_mesh *mesh, size_t corner, int plain) {
    uint32_t index;
    if (!plain) return norma_core_corner(mesh, corner);
    memcpy(&index, (const unsigned char *)mesh->corners + 4 * corner, sizeof index);
    return index;
}

static inline void read_triangle_corners(const core_mesh *mesh, star_list *list, int plain) {
    for (size_t i = 0; i < list->corner_count; i++) {
        const uint32_t corner = list->corners[i], face = corner / 3, turn = corner - 3 * face;
        list->face[i] = face;
        list->turn[i] = turn;
        list->next[i] = corner_at(mesh, turn == 2 ? corner - 2 : corner + 1, plain);
        list->previous[i] = corner_at(mesh, turn == 0 ? corner + 2 : corner - 1, plain);
    }
}

/* Of most stars, each next is also a previous. */
static void ask_for_positions(
    const core_prepared_mesh *prepared, const star_list *list, size_t begin, size_t count) {
    const core_mesh *mesh = &prepared->mesh;
    const uint32_t *next = list->next + begin;
    for (size_t i = 0; i < count; i++) {
        __builtin_prefetch(
            (const unsigned char *)mesh->positions.data + next[i] * mesh->positions.stride);
        if (mesh->weld) __builtin_prefetch(&mesh->weld[next[i]]);
        if (prepared->faces) __builtin_prefetch(&prepared->faces[list->face[begin + i]]);
    }
}

int norma_core_list_star(
    const core_prepared_mesh *prepared, uint32_t position, uint32_t count, star_list *list) {
    const uint32_t *corners = prepared->corners_of.corners + prepared->corners_of.starts[position],
                   at = (uint32_t)list->corner_count;
    if (at + count > BATCH_CORNERS) return 0;
    memcpy(list->corners + at, corners, count * sizeof *corners);
    list->stars[list->star_count++] = (listed_star){.position = position,
        .begin = (uint16_t)at,
        .count = (uint16_t)count,
        .scattered = corners[count - 1] - corners[0] > NEAR};
    list->corner_count += count;
    return 1;
}

void norma_core_read_list(const core_prepared_mesh *prepared, star_list *list) {
    if (prepared->faces)
        read_polygon_corners(prepared, list);
    else if (prepared->mesh.corner_size == sizeof(uint32_t))
        read_triangle_corners(&prepared->mesh, list, 1);
    else
        read_triangle_corners(&prepared->mesh, list, 0);
    for (size_t i = 0; i < list->star_count; i++)
        if (list->stars[i].scattered)
            ask_for_positions(prepared, list, list->stars[i].begin, list->stars[i].count);
}

void norma_core_ask_for_targets(const star_list *list, const listed_star *star) {
    const position_visit *visit = list->visit;
    for (size_t i = star->begin; i < (size_t)star->begin + star->count && visit->target; i++)
        __builtin_prefetch(
            (const unsigned char *)visit->target + visit->target_size * list->corners[i], 1);
}

void norma_core_ask_for_corners(const core_prepared_mesh *prepared, const listed_star *star) {
    const core_corners_of_position *corners_of = &prepared->corners_of;
    const core_mesh *mesh = &prepared->mesh;
    const size_t begin = corners_of->starts[star->position] + (size_t)CORNERS_AHEAD,
                 listed = corners_of->starts[corners_of->position_count];
    for (size_t i = begin; i < begin + star->count && i < listed && mesh->corners; i++)
        __builtin_prefetch(
            (const unsigned char *)mesh->corners + mesh->corner_size * corners_of->corners[i]);
}

/* ---- a batch of stars joined and summed: loops over lanes, compiled for each instruction set as
 * those of measure_faces.c are. */

/* ---- weights of polygons' corners; triangles are measured as faces  */

typedef struct polygon_lanes {
    _Alignas(64) core_lane at[3], next_at[3], previous_at[3]; /* in: positions */
    core_lane normal[3], area, is_triangle;                   /* in: of the face; twice the area */
    core_lane sure, weight; /* in and out: 1 where doubles are enough, else 0; out */
} polygon_lanes;

/* A polygon's corner: its direction and area are there. Weights are those of face_geometry.c. */
CORE_INLINE void measure_polygon_corner(polygon_lanes *t, size_t i, norma_weight weight) {
    const int by_angle = core_weighed(weight) == CORE_BY_ANGLE,
              is_triangle = t->is_triangle[i] != 0;
    double a[3], b[3], cross[3];
    for (int k = 0; k < 3; k++) {
        a[k] = t->next_at[k][i] - t->at[k][i];
        b[k] = t->previous_at[k][i] - t->at[k][i];
    }
    norma_core_cross(a, b, cross);
    const double aa = norma_core_dot(a, a), bb = norma_core_dot(b, b),
                 square = norma_core_dot(cross, cross), own = sqrt(square),
                 length = is_triangle ? t->area[i] : own,
                 along = cross[0] * t->normal[0][i] + cross[1] * t->normal[1][i] +
                         cross[2] * t->normal[2][i];
    const double turn = by_angle ? norma_core_weight_angle(length, norma_core_dot(a, b)) : 0,
                 angle = along < 0 && !is_triangle ? 2 * NORMA_PI - turn : turn;
    const int sure = core_weighed(weight) == CORE_BY_FACE || is_triangle ||
                     (norma_core_corner_is_sure(square, aa * bb) &
                         ((by_angle == 0) | norma_core_turn_is_sure(along, length)));
    t->sure[i] = sure ? t->sure[i] : 0;
    t->weight[i] = norma_core_weight_of(weight, aa, bb, angle, length, t->area[i]);
}

CORE_INLINE void measure_lanes(polygon_lanes *t, norma_weight weight) {
    for (size_t i = 0; i < CORE_LANES; i++) measure_polygon_corner(t, i, weight);
}

CORE_INLINE void load_position(
    const core_mesh *mesh, uint32_t index, core_lane to[3], size_t lane) {
    double p[3];
    if (mesh->positions.format == NORMA_FORMAT_DOUBLE) /* of polygons, nearly always: OBJ */
        norma_core_double_position(mesh, index, p);
    else
        norma_core_position(mesh, index, p);
    for (int k = 0; k < 3; k++) to[k][lane] = p[k];
}

/* Sure are polygons that keep all their corners and have a direction. */
static void load_polygon(const core_prepared_mesh *s, const star_list *list, size_t corner,
    polygon_lanes *t, size_t lane) {
    const size_t f = list->face[corner],
                 corners = norma_core_face_end(&s->mesh, f) - norma_core_face_begin(&s->mesh, f);
    const core_face *face = &s->faces[f];
    load_position(&s->mesh, norma_core_welded_corner(&s->mesh, list->corners[corner]), t->at, lane);
    load_position(&s->mesh, list->next[corner], t->next_at, lane);
    load_position(&s->mesh, list->previous[corner], t->previous_at, lane);
    for (int k = 0; k < 3; k++) t->normal[k][lane] = face->normal[k];
    t->area[lane] = face->twice_area;
    t->is_triangle[lane] = corners == 3 ? 1 : 0;
    t->sure[lane] = (face->flags & CORE_FACE_DIRECTED) && face->kept == corners ? 1 : 0;
}

CORE_INLINE void measure_polygons(
    const core_prepared_mesh *s, const star_list *list, fan_batch *b) {
    polygon_lanes t;
    for (size_t from = 0; from < list->corner_count; from += CORE_LANES) {
        const size_t left = list->corner_count - from,
                     count = left < CORE_LANES ? left : CORE_LANES;
        for (size_t i = 0; i < CORE_LANES; i++)
            load_polygon(s, list, from + (i < count ? i : 0), &t, i);
        CORE_LOOP_FOR_WEIGHT(s->call->options.weight, measure_lanes, &t)
        for (size_t i = 0; i < count; i++) {
            b->place[from + i] = norma_core_place_of_corner(from + i);
            b->measured.room[b->place[from + i]] =
                (measured_face){{t.normal[0][i], t.normal[1][i], t.normal[2][i], t.sure[i]},
                    {t.weight[i], 0, 0, 0}};
        }
    }
}

/* ---- the order round a star: from each face to the one whose edge to next is its own edge from
 * previous */

/* Where the corner is noted that has its next at this position, unless another takes the place. */
static inline uint32_t note_of(uint32_t position) {
    return position * UINT32_C(0x9e3779b1) >> (32 - NOTE_BITS);
}

/* Closed stars, most of them. If two corners had the same previous, some other could not be
 * reached. Also 0 if two share a note. All notes are looked up before the walk, which would
 * otherwise wait for each of them. */
CORE_INLINE int walk_closed(const uint32_t *next, const uint32_t *previous, uint32_t count,
    uint8_t *notes, uint8_t *order) {
    uint8_t leads_to[ORDINARY_CORNERS];
    uint32_t at = 0, seen = 0, missed = 0;
    for (uint32_t i = 0; i < count; i++) notes[note_of(next[i])] = (uint8_t)i;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t note = notes[note_of(previous[i])];
        leads_to[i] = (uint8_t)(note < count ? note : 0);
        missed |= next[leads_to[i]] ^ previous[i];
    }
    if (missed) return 0;
    for (uint32_t i = 0; i < count; i++) {
        order[i] = (uint8_t)at;
        seen |= 1U << at;
        at = leads_to[at];
    }
    return at == 0 && seen == (1U << count) - 1 && count > 2;
}

static inline uint32_t lowest(uint32_t bits) { return (uint32_t)__builtin_ctz(bits); }

/* Any star: open ones begin at the corner whose next is nobody's previous. 0: there is no single
 * way through all corners, so that edges of other than two faces, twins, or fans that only touch
 * are here. */
static int walk(
    const uint32_t *next, const uint32_t *previous, uint32_t count, uint8_t *order, int *open) {
    const uint32_t all = (1U << count) - 1;
    uint32_t same[ORDINARY_CORNERS], any = 0, seen = 0, at = 0;
    for (uint32_t j = 0; j < count; j++) {
        same[j] = 0;
        for (uint32_t i = 0; i < count; i++) same[j] |= (uint32_t)(previous[j] == next[i]) << i;
        any |= same[j];
    }
    *open = any != all;
    if (*open) at = lowest(any ^ all);
    for (uint32_t i = 0; i < count; i++) {
        order[i] = (uint8_t)at;
        seen |= 1U << at;
        if (!same[at]) return *open && seen == all;
        at = lowest(same[at]);
    }
    return !*open && at == 0 && seen == all && count > 2;
}

/* 0: the star is not ordinary, and its corners are left as they come. */
CORE_INLINE int order_star(
    const core_mesh *mesh, const star_list *list, listed_star *star, fan_batch *t) {
    uint32_t welded[2][ORDINARY_CORNERS];
    const uint32_t *next = list->next + star->begin, *previous = list->previous + star->begin;
    uint8_t *order = t->order + star->begin;
    int open = 0;
    for (uint32_t i = 0; i < star->count && mesh->weld; i++) {
        welded[0][i] = mesh->weld[next[i]];
        welded[1][i] = mesh->weld[previous[i]];
    }
    if (mesh->weld) {
        next = welded[0];
        previous = welded[1];
    }
    const int ordinary = walk_closed(next, previous, star->count, t->notes, order) ||
                         walk(next, previous, star->count, order, &open);
    for (uint32_t i = 0; i < star->count && !ordinary; i++) order[i] = (uint8_t)i;
    star->open = (uint16_t)open;
    return ordinary;
}

/* ---- joining: between a star's corners, in order, are its edges, each before the corner of its
 * number; the first one is between the last corner and the first. */

typedef double row_lanes __attribute__((vector_size(4 * sizeof(double))));

/* Of each edge the products of the two faces' normals, and of whether they are sure. */
CORE_INLINE void multiply_normals(fan_batch *t, const listed_star *star) {
    const uint8_t *order = t->order + star->begin;
    const uint16_t *place = t->place + star->begin;
    const measured_face *faces = t->faces;
    double(*to)[4] = t->row + star->begin;
    row_lanes last, normal, product;
    memcpy(&last, faces[place[order[star->count - 1U]]].normal, sizeof last);
    for (uint32_t i = 0; i < star->count; i++, last = normal) {
        memcpy(&normal, faces[place[order[i]]].normal, sizeof normal);
        product = last * normal;
        memcpy(to[i], &product, sizeof product);
    }
}

/* Of all edges, without a branch: no branch could foretell any of it. */
CORE_INLINE void find_cuts(const core_crease *crease, fan_batch *t, size_t count) {
    for (size_t e = 0; e < count; e++) {
        const double *product = t->row[e], cosine = product[0] + product[1] + product[2];
        const int hard = norma_core_is_surely_hard(crease, cosine),
                  smooth = norma_core_is_surely_smooth(crease, cosine);
        t->edge[e] = (hard ? EDGE_CUT : 0) | (hard | smooth ? 0 : EDGE_NEAR_CREASE) |
                     (product[3] != 0 ? 0 : EDGE_UNSURE);
    }
}

/* out begins at the star, back ends there. */
static int is_unmarked(const core_prepared_mesh *s, uint32_t out, uint32_t back) {
    const size_t face = norma_core_face_of(&s->corners_of, back);
    return norma_core_is_unmarked(&s->mesh, out, (uint32_t)norma_core_face_of(&s->corners_of, out),
        (uint32_t)norma_core_previous_in_face(&s->mesh, face, back), (uint32_t)face);
}

/* Edges that the caller marks as hard are cut, whatever their angle. */
static void cut_marked(
    const core_prepared_mesh *s, const star_list *list, const listed_star *star, fan_batch *t) {
    const uint32_t *corners = list->corners + star->begin;
    const uint8_t *order = t->order + star->begin;
    for (uint32_t i = star->open; i < star->count; i++) {
        const uint32_t before = i ? i - 1 : star->count - 1U;
        if (is_unmarked(s, corners[order[i]], corners[order[before]])) continue;
        t->edge[star->begin + i] = EDGE_CUT | (t->edge[star->begin + i] & EDGE_UNSURE);
    }
}

/* Edges to positions of higher number: one at each face's previous, and at the first one's next if
 * that is another. */
static void count_edges(const core_prepared_mesh *s, const star_list *list, const fan_batch *t,
    const listed_star *star, norma_edges *edges) {
    for (uint32_t i = 0; i < star->count; i++) {
        const size_t corner = (size_t)star->begin + t->order[star->begin + i];
        const size_t higher = star->position < norma_core_welded(&s->mesh, list->previous[corner]);
        const uint32_t following = i + 1U == star->count ? 0 : i + 1;
        edges->count += higher;
        if (!following && star->open)
            edges->open += higher;
        else if (t->edge[star->begin + following] & EDGE_CUT)
            edges->hard += higher;
        else
            edges->smooth += higher;
        if (!star->open || i) continue;
        const size_t first = star->position < norma_core_welded(&s->mesh, list->next[corner]);
        edges->count += first;
        edges->open += first;
    }
}

/* ---- fans: from one cut to the next; the last one, where no cut ends it, goes on in the first */

/* Returns how many there are; 0: some direction is unsure, or some edge too near the crease to tell
 * by the cosine. Corners of a last fan that goes on in the first get that number. */
CORE_INLINE uint32_t number_fans(fan_batch *t, const listed_star *star) {
    const uint8_t *order = t->order + star->begin;
    const uint32_t *cut = t->edge + star->begin;
    const uint32_t first = star->open ? EDGE_CUT | (cut[0] & EDGE_UNSURE) : cut[0];
    uint32_t *fan_of = t->fan_of + star->begin, fan = 0, all = first;
    fan_of[order[0]] = 0;
    for (uint32_t i = 1; i < star->count; i++) {
        fan += cut[i] & EDGE_CUT;
        all |= cut[i];
        fan_of[order[i]] = fan;
    }
    if (all & (EDGE_NEAR_CREASE | EDGE_UNSURE)) return 0;
    return fan + (first & EDGE_CUT || !fan);
}

/* The one fan of most stars, in a register: a sum in memory would wait for its last store. */
CORE_INLINE void sum_one_fan(fan_batch *t, const star_list *list, const listed_star *star) {
    const uint32_t *turn = list->turn + star->begin;
    const uint16_t *place = t->place + star->begin;
    row_lanes normal, sum = {0};
    for (uint32_t i = 0; i < star->count; i++) {
        const measured_face *face = &t->faces[place[i]];
        memcpy(&normal, face->normal, sizeof normal);
        sum += normal * face->weight[turn[i]];
        t->fan_of[star->begin + i] = 0;
    }
    memcpy(t->row[star->first_fan], &sum, sizeof sum);
}

/* Several fans, each in the order of its corners. */
CORE_INLINE void sum_fans(fan_batch *t, const star_list *list, const listed_star *star) {
    const uint32_t *turn = list->turn + star->begin, fans = star->fan_count;
    const uint16_t *place = t->place + star->begin;
    const measured_face *faces = t->faces;
    uint32_t *fan_of = t->fan_of + star->begin;
    double(*sums)[4] = t->row + star->first_fan;
    for (uint32_t i = 0; i < fans; i++)
        for (int k = 0; k < 4; k++) sums[i][k] = 0;
    for (uint32_t i = 0; i < star->count; i++) {
        const measured_face *face = &faces[place[i]];
        fan_of[i] = fan_of[i] == fans ? 0 : fan_of[i];
        core_add_row(sums[fan_of[i]], face->normal, face->weight[turn[i]]);
    }
}

/* Returns how many. */
CORE_INLINE uint32_t settle_star(const core_prepared_mesh *s, const star_list *list, fan_batch *t,
    listed_star *star, uint32_t first_fan, norma_edges *edges) {
    if (s->mesh.hard_edges || s->mesh.smoothing_groups) cut_marked(s, list, star, t);
    star->first_fan = (uint16_t)first_fan;
    star->fan_count = (uint16_t)number_fans(t, star);
    if (!star->fan_count) return 0;
    if (star->fan_count == 1)
        sum_one_fan(t, list, star);
    else
        sum_fans(t, list, star);
    if (edges) count_edges(s, list, t, star, edges);
    return star->fan_count;
}

/* ---- normals */

/* What norma_core_decide_sum does, where neither overflow nor cancelling is near; decided: 0 where
 * they are. */
CORE_INLINE void decide(fan_batch *t, size_t count) {
    for (size_t from = 0; from < count; from += CORE_LANES)
        for (size_t f = from; f < from + CORE_LANES; f++) {
            const double x = t->row[f][0], y = t->row[f][1], z = t->row[f][2],
                         square = x * x + y * y + z * z, length = sqrt(square),
                         inverse = 1 / length;
            t->direction[0][f] = (float)(x * inverse) + 0.0F;
            t->direction[1][f] = (float)(y * inverse) + 0.0F;
            t->direction[2][f] = (float)(z * inverse) + 0.0F;
            t->decided[f] = ((square > NORMA_TINIEST) & (square < NORMA_HUGEST) &
                                (length > 0x1p-20 * t->row[f][3]))
                                ? 1
                                : 0;
        }
}

/* Written as one, since it will be read so: what is written in pieces is read late. */
typedef float fan_lanes __attribute__((vector_size(sizeof(core_fan))));
_Static_assert(NORMA_REASON_NONE == 0, "a fan with a normal ends in zeros");

CORE_INLINE void name_fans(fan_batch *t, size_t count) {
    for (size_t f = 0; f < count; f++) {
        const fan_lanes fan = {t->direction[0][f], t->direction[1][f], t->direction[2][f], 0};
        memcpy(&t->fans[f], &fan, sizeof fan);
        if (t->decided[f] == 0) norma_core_decide_sum(t->row[f], t->row[f][3], &t->fans[f]);
    }
}

CORE_INLINE void measure_faces(const core_prepared_mesh *s, const star_list *list, fan_batch *t) {
    t->faces = s->measured ? s->measured : t->measured.room;
    if (s->faces) {
        measure_polygons(s, list, t);
        return;
    }
    for (size_t i = 0; i < list->corner_count; i++)
        t->place[i] = s->measured ? (uint16_t)list->face[i]
                                  : norma_core_place_of_face(&t->measured, list->face[i], i);
    norma_core_measure_waiting(s, &t->measured);
}

CORE_INLINE int settle(
    const core_prepared_mesh *s, star_list *list, fan_batch *t, norma_edges *edges) {
    uint32_t fans = 0;
    int all = 1;
    for (size_t i = 0; i < list->star_count; i++) {
        listed_star *star = &list->stars[i];
        if (star->scattered) norma_core_ask_for_targets(list, star);
        star->fan_count = (uint16_t)order_star(&s->mesh, list, star, t);
    }
    measure_faces(s, list, t);
    for (size_t i = 0; i < list->star_count; i++) {
        if (list->stars[i].scattered) norma_core_ask_for_corners(s, &list->stars[i]);
        multiply_normals(t, &list->stars[i]);
    }
    find_cuts(&s->crease, t, list->corner_count);
    for (size_t i = 0; i < list->star_count; i++) {
        listed_star *star = &list->stars[i];
        const uint32_t added = star->fan_count ? settle_star(s, list, t, star, fans, edges) : 0;
        fans += added;
        all &= added != 0;
    }
    memset(t->row[fans], 0, CORE_LANES * sizeof t->row[0]);
    decide(t, fans);
    name_fans(t, fans);
    return all;
}

/* ---- instruction sets */

static int settle_portable(
    const core_prepared_mesh *s, star_list *list, fan_batch *t, norma_edges *edges) {
    return settle(s, list, t, edges);
}

#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static int settle_avx2(
    const core_prepared_mesh *s, star_list *list, fan_batch *t, norma_edges *edges) {
    return settle(s, list, t, edges);
}
#if defined(CORE_HAS_AVX512)
CORE_FOR_AVX512 static int settle_avx512(
    const core_prepared_mesh *s, star_list *list, fan_batch *t, norma_edges *edges) {
    return settle(s, list, t, edges);
}
#endif
#endif

fans_simd *norma_core_choose_fans(norma_isa isa) {
    static fans_simd *const settles[] = CORE_KERNELS(settle);
    return settles[norma_core_level(isa)];
}
