/* star_kernel.c: ordinary stars, many at a time: their triangles are measured eight at a time, and
 * fans are joined and summed in loops over lanes. */
#include "core/corner/corner.h"
#include "core/face/eight_vectors.h"
#include "core/face/face.h"
#include "core/call/call.h"
#include "core/mesh/mesh.h"

/* Eight of the faces that wait, from first on. */
CORE_INLINE void measure_waiting(
    const core_prepared_mesh *s, const star_list *list, uint32_t first, kept_faces *out) {
    core_batch b;
    core_rows normals, weights;
    double(*rows)[8] = out->row;
    uint32_t(*welded)[8] = out->at;
    core_load_edges(&s->mesh, (const uint32_t(*)[3])list->at + first, &b);
    norma_core_kernels(s->call->level)->measure(&b, s->call->options.weight);
    core_lanes_to_rows(b.normal[0], b.normal[1], b.normal[2], b.sure, &normals);
    core_lanes_to_rows(b.weight[0], b.weight[1], b.weight[2], b.sure, &weights);
    for (size_t i = 0; i < CORE_LANES; ++i) {
        const uint32_t *at = list->at[first + i], place = list->place[first + i],
                       own = norma_core_welded(&s->mesh, at[0]),
                       next = norma_core_welded(&s->mesh, at[1]),
                       previous = norma_core_welded(&s->mesh, at[2]);
        const uint32_t around[5] = {own, next, previous, own, next};
        memcpy(rows[place], normals.row[i], sizeof normals.row[i]);
        memcpy(rows[place] + 4, weights.row[i], sizeof weights.row[i]);
        memcpy(welded[place], around, sizeof around);
    }
}

CORE_INLINE void measure_all_waiting(
    const core_prepared_mesh *s, star_list *list, kept_faces *out) {
    for (uint32_t i = list->waiting; i % CORE_LANES; ++i) {
        memcpy(list->at[i], list->at[0], sizeof list->at[i]);
        list->place[i] = list->place[0];
    }
    for (uint32_t i = 0; i < list->waiting; i += CORE_LANES) measure_waiting(s, list, i, out);
}

int norma_core_can_batch(const core_prepared_mesh *prepared) {
    return !norma_core_sees(prepared->call) &&
           !(prepared->mesh.weld && norma_core_welds_near(prepared->call));
}

/* Of a triangle that is kept: its row, positions, and which it is. */
static size_t kept_bytes(size_t room) {
    const kept_faces *k = NULL;
    return (room + BATCH_CORNERS) * (sizeof *k->row + sizeof *k->at) + room * sizeof *k->held;
}

enum { LINE = 64 };

static norma_result allocate_kept(const core_call *call, size_t room, kept_faces *kept) {
    const size_t places = room + BATCH_CORNERS;
    kept->room = (uint32_t)room;
    if (!(kept->block = norma_core_allocate(call, kept_bytes(room) + LINE, 1)))
        return NORMA_ERROR_MEMORY;
    unsigned char *at = kept->block;
    at += LINE - (uintptr_t)at % LINE;
    kept->row = (double(*)[8])(void *)at;
    kept->at = (uint32_t(*)[8])(void *)(kept->row + places);
    kept->held = (uint64_t *)(void *)(kept->at + places);
    memset(kept->held, 0xff, room * sizeof *kept->held);
    return NORMA_OK;
}

/* Scratch is bounded for each triangle, and by what one who works alone has: more of them keep
 * less. */
static size_t choose_room(const core_prepared_mesh *prepared, size_t count) {
    enum { LEAST = 64, BYTES_A_FACE = 23 };
    const size_t faces = prepared->mesh.face_count, alone = kept_bytes(FACES_KEPT) + faces;
    const size_t bytes = faces < alone / BYTES_A_FACE ? BYTES_A_FACE * faces : alone;
    size_t room = norma_core_kept_faces(prepared) ? 1 : LEAST;
    while (room < FACES_KEPT && !norma_core_kept_faces(prepared) &&
           kept_bytes(2 * room) <= bytes / count)
        room *= 2;
    return room;
}

norma_result norma_core_kept_allocate(
    const core_prepared_mesh *prepared, size_t count, kept_faces **kept) {
    const core_call *call = prepared->call;
    const size_t room = choose_room(prepared, count);
    norma_result result = NORMA_OK;
    if (!(*kept = norma_core_allocate(call, count, sizeof **kept))) return NORMA_ERROR_MEMORY;
    memset(*kept, 0, count * sizeof **kept);
    for (size_t i = 0; i < count && !result; ++i) {
        atomic_init(&(*kept)[i].taken, 0);
        result = allocate_kept(call, room, &(*kept)[i]);
    }
    if (!result) return NORMA_OK;
    norma_core_kept_release(prepared, count, *kept);
    *kept = NULL;
    return result;
}

void norma_core_kept_release(const core_prepared_mesh *prepared, size_t count, kept_faces *kept) {
    for (size_t i = 0; i < count && kept; ++i)
        norma_core_release(prepared->call, kept[i].block, kept_bytes(kept[i].room) + LINE, 1);
    norma_core_release(prepared->call, kept, count, sizeof *kept);
}

static uint32_t place_behind(const kept_faces *kept, size_t corner) {
    return kept->room + (uint32_t)corner;
}

CORE_INLINE void read_face_corners(const core_mesh *mesh, size_t face, uint32_t at[3]) {
    if (mesh->corners && mesh->corner_size == sizeof *at)
        memcpy(at, (const unsigned char *)mesh->corners + 3 * face * sizeof *at, 3 * sizeof *at);
    else
        for (size_t k = 0; k < 3; ++k) at[k] = norma_core_corner(mesh, 3 * face + k);
}

/* The place of each corner's face, there already or once none waits. Which of the two is written
 * beyond the end of those that wait, or not: no branch could foretell it. near: no two faces of the
 * list have the same place, so that none needs one behind. Returns how many wait. */
CORE_INLINE uint32_t find_places(kept_faces *kept, star_list *list, int near) {
    const uint64_t lists = (uint64_t)++kept->lists << 32;
    const uint32_t mask = kept->room - 1, *corners = list->corners;
    uint64_t *holds = kept->held;
    const size_t count = list->corner_count;
    uint32_t waiting = 0;
    for (size_t i = 0; i < count; ++i) {
        const uint32_t corner = corners[i], face = corner / 3, own = face & mask;
        const uint64_t held = holds[own];
        const int waits = (uint32_t)held != face,
                  is_taken = (near ? 0 : waits) & (held >> 32 == lists >> 32);
        const uint32_t place = is_taken ? place_behind(kept, i) : own;
        holds[own] = is_taken ? held : lists | face;
        list->key[i] = 8 * place + (corner - 3 * face);
        list->face[waiting] = face;
        list->place[waiting] = (uint16_t)place;
        waiting += (uint32_t)waits;
    }
    return waiting;
}

static void read_triangles(const core_mesh *mesh, kept_faces *kept, star_list *list) {
    const int near = list->corner_count && list->most / 3 - list->least / 3 < kept->room;
    list->waiting = near ? find_places(kept, list, 1) : find_places(kept, list, 0);
    for (uint32_t i = 0; i < list->waiting; ++i)
        read_face_corners(mesh, list->face[i], list->at[i]);
}

static void read_polygon_corners(
    const core_prepared_mesh *prepared, const kept_faces *kept, star_list *list) {
    const core_mesh *mesh = &prepared->mesh;
    for (size_t i = 0; i < list->corner_count; ++i) {
        const size_t corner = list->corners[i],
                     face = norma_core_face_of(&prepared->corners_of, corner);
        list->face[i] = (uint32_t)face;
        list->key[i] = 8 * place_behind(kept, i);
        list->at[i][0] = norma_core_corner(mesh, corner);
        list->at[i][1] = norma_core_corner(mesh, norma_core_next_in_face(mesh, face, corner));
        list->at[i][2] = norma_core_corner(mesh, norma_core_previous_in_face(mesh, face, corner));
    }
    list->waiting = (uint32_t)list->corner_count;
}

void norma_core_read_list(const core_prepared_mesh *prepared, fan_batch *batch, star_list *list) {
    if (norma_core_kept_faces(prepared))
        read_polygon_corners(prepared, batch->kept, list);
    else
        read_triangles(&prepared->mesh, batch->kept, list);
}

/* ---- a batch of stars joined and summed: loops over lanes, compiled for each instruction set as
 * those of face_kernel.template.h are. */

/* ---- weights of polygons' corners; triangles are measured as faces  */

typedef struct polygon_lanes {
    core_batch edges; /* to the next corner and to the previous one: u and v */
    core_lane is_triangle,
        is_whole;           /* in: whole faces keep all their corners and have a direction */
    core_lane sure, weight; /* out: 1 where doubles are enough, else 0 */
} polygon_lanes;

/* A polygon's corner: its direction and area are there. Weights are those of face_geometry.c. */
CORE_INLINE void measure_polygon_corner(polygon_lanes *t, size_t i, norma_weight weight) {
    const core_batch *e = &t->edges;
    const int by_angle = core_weighed(weight) == CORE_BY_ANGLE,
              is_triangle = t->is_triangle[i] != 0;
    const double a[3] = {e->u[0][i], e->u[1][i], e->u[2][i]},
                 b[3] = {e->v[0][i], e->v[1][i], e->v[2][i]};
    double cross[3];
    norma_core_cross(a, b, cross);
    const double aa = norma_core_dot(a, a), bb = norma_core_dot(b, b),
                 square = norma_core_dot(cross, cross), own = sqrt(square),
                 length = is_triangle ? e->twice_area[i] : own,
                 along = cross[0] * e->normal[0][i] + cross[1] * e->normal[1][i] +
                         cross[2] * e->normal[2][i];
    const double turn = by_angle ? norma_core_weight_angle(length, norma_core_dot(a, b)) : 0,
                 angle = along < 0 && !is_triangle ? 2 * NORMA_PI - turn : turn;
    const int sure = core_weighed(weight) == CORE_BY_FACE || is_triangle ||
                     (norma_core_corner_is_sure(square, aa * bb) &
                         ((by_angle == 0) | norma_core_turn_is_sure(along, length)));
    t->sure[i] = sure ? t->is_whole[i] : 0;
    t->weight[i] = norma_core_weight_of(weight, aa, bb, angle, length, e->twice_area[i]);
}

CORE_INLINE void measure_lanes(polygon_lanes *t, norma_weight weight) {
    for (size_t i = 0; i < CORE_LANES; ++i) measure_polygon_corner(t, i, weight);
}

/* What is known of the faces of eight corners. */
CORE_INLINE void load_faces(const core_prepared_mesh *s, const uint32_t *faces, polygon_lanes *t) {
    core_rows rows;
    core_batch *e = &t->edges;
    for (size_t i = 0; i < CORE_LANES; ++i) {
        const size_t f = faces[i], corners = norma_core_face_end(&s->mesh, f) -
                                             norma_core_face_begin(&s->mesh, f);
        const core_face *face = &s->faces[f];
        memcpy(rows.row[i], face->normal, sizeof face->normal);
        rows.row[i][3] = face->twice_area;
        t->is_triangle[i] = corners == 3 ? 1 : 0;
        t->is_whole[i] = (face->flags & CORE_FACE_DIRECTED) && face->kept == corners ? 1 : 0;
    }
    core_rows_to_lanes(
        (const double(*)[4])rows.row, e->normal[0], e->normal[1], e->normal[2], e->twice_area);
}

/* Each corner's face has a place of its own, its corner there the first. */
CORE_INLINE void weigh_polygons(const core_prepared_mesh *s, star_list *list, kept_faces *out) {
    const size_t count = list->corner_count;
    polygon_lanes t;
    for (size_t i = count; i % CORE_LANES; ++i) {
        memcpy(list->at[i], list->at[0], sizeof list->at[i]);
        list->face[i] = list->face[0];
    }
    for (size_t from = 0; from < count; from += CORE_LANES) {
        core_rows rows;
        core_load_edges(&s->mesh, (const uint32_t(*)[3])list->at + from, &t.edges);
        load_faces(s, list->face + from, &t);
        CORE_LOOP_FOR_WEIGHT(s->call->options.weight, measure_lanes, &t)
        core_lanes_to_rows(t.edges.normal[0], t.edges.normal[1], t.edges.normal[2], t.sure, &rows);
        for (size_t i = 0; i < CORE_LANES && from + i < count; ++i) {
            const uint32_t place = place_behind(out, from + i);
            memcpy(out->row[place], rows.row[i], sizeof rows.row[i]);
            out->row[place][4] = t.weight[i];
            for (int k = 1; k < 3; ++k)
                out->at[place][k] = norma_core_welded(&s->mesh, list->at[from + i][k]);
        }
    }
}

/* ---- the edges of a star: which faces run back along each corner's edge to next, and which run
 * out along its edge from previous, as bits of a number. Four corners, a quad, are compared at once
 * with all of the star, or the half or the quarter that suffices (foliage takes 7 % less); how many
 * it has is not asked: those of the next star are masked. Said as vectors, since clang makes
 * numbers, one by one, of the same loop for WebAssembly, where corner normals take a sixth less so
 * (without AVX2 a tenth). */

enum { QUAD = 4, HALF = ORDINARY_CORNERS / 2 };
_Static_assert(HALF % QUAD == 0, "a star is made of quads");
typedef uint32_t quad __attribute__((vector_size(QUAD * sizeof(uint32_t))));
typedef int32_t signed_quad __attribute__((vector_size(QUAD * sizeof(int32_t))));
typedef float float_quad __attribute__((vector_size(QUAD * sizeof(float))));

CORE_INLINE quad load_quad(const uint32_t *at) {
    quad lanes;
    memcpy(&lanes, at, sizeof lanes);
    return lanes;
}

CORE_INLINE void store_quad(uint32_t *at, quad lanes) { memcpy(at, &lanes, sizeof lanes); }

/* a where the condition, all ones or all zeros, holds. */
CORE_INLINE quad choose_quad(quad condition, quad a, quad b) {
    return (a & condition) | (b & ~condition);
}

CORE_INLINE quad number_quad(uint32_t from) { return (quad){0, 1, 2, 3} + from; }

/* The bits of all lanes. */
CORE_INLINE uint32_t any_of_quad(quad lanes) {
    return (lanes[0] | lanes[1]) | (lanes[2] | lanes[3]);
}

CORE_INLINE quad all_but_lowest(quad bits) { return bits & (bits - 1); }

/* All ones where a number has one bit. */
CORE_INLINE quad is_only_bit(quad bits) {
    return (quad)(bits != 0) & (quad)(all_but_lowest(bits) == 0);
}

/* The place of each number's only bit, counted from begin; from its exponent as a float: there is
 * an instruction for that on every machine. */
CORE_INLINE quad place_of_bit(quad bit, uint32_t begin) {
    return ((quad) __builtin_convertvector((signed_quad)bit, float_quad) >> 23) + (begin - 127);
}

/* Of a star of so many corners at most. Returns whether an edge has more than one face that runs
 * out or back, or two faces share both edges, as twins do. */
CORE_INLINE int find_edges(
    const fan_batch *t, const listed_star *star, uint32_t corners, quad *back, quad *out) {
    const uint32_t *next = t->next + star->begin, *previous = t->previous + star->begin,
                   count = star->count, quads = corners / QUAD;
    quad odd = {0};
    for (uint32_t q = 0; q < quads; ++q) back[q] = out[q] = odd;
    for (uint32_t k = 0; k < corners; ++k)
        for (uint32_t q = 0; q < quads; ++q) {
            back[q] |= (quad)(load_quad(next + QUAD * q) == previous[k]) & (1U << k);
            out[q] |= (quad)(load_quad(previous + QUAD * q) == next[k]) & (1U << k);
        }
    for (uint32_t q = 0; q < quads; ++q) {
        const quad own = (quad)(number_quad(QUAD * q) < count) & ((1U << count) - 1);
        back[q] &= own;
        out[q] &= own;
        odd |= all_but_lowest(back[q]) | all_but_lowest(out[q]) | (back[q] & out[q]);
    }
    return any_of_quad(odd) != 0;
}

/* Where more than two faces meet, each has those across the edge as partners that are not its
 * twins; of triangles, twins share both edges. Two that are each other's only one stay. */
CORE_INLINE void keep_only_partners(quad *back, const quad *out, uint32_t quads) {
    quad wanted = {0}; /* by one only */
    for (uint32_t q = 0; q < quads; ++q)
        wanted |= is_only_bit(out[q] & ~back[q]) & ((quad){1, 2, 4, 8} << (QUAD * q));
    const uint32_t all_wanted = any_of_quad(wanted);
    for (uint32_t q = 0; q < quads; ++q) {
        const quad backs = back[q] & ~out[q];
        back[q] = backs & all_wanted & is_only_bit(backs);
    }
}

CORE_INLINE void name_others(fan_batch *t, uint32_t begin, uint32_t from, quad back, quad out) {
    const quad number = number_quad(begin + from);
    store_quad(t->back + begin + from, back);
    store_quad(t->out + begin + from, out);
    store_quad(
        t->other + begin + from, choose_quad((quad)(back != 0), place_of_bit(back, begin), number));
}

/* Whether two run the same way along an edge, which only those ask who count it. */
static int some_run_alike(const fan_batch *t, const listed_star *star) {
    const uint32_t *next = t->next + star->begin, *previous = t->previous + star->begin;
    int alike = 0;
    for (uint32_t i = 1; i < star->count; ++i)
        for (uint32_t k = 0; k < i; ++k)
            alike |= (next[i] == next[k]) | (previous[i] == previous[k]);
    return alike;
}

/* plain: only stars with one face out and one back at most along each edge, and no twins, are
 * ordinary. */
CORE_INLINE int meet_star(
    fan_batch *t, const listed_star *star, uint32_t corners, int plain, int counting) {
    quad back[ORDINARY_CORNERS / QUAD], out[ORDINARY_CORNERS / QUAD];
    const int odd = find_edges(t, star, corners, back, out);
    if (odd) keep_only_partners(back, out, corners / QUAD);
    for (uint32_t q = 0; q < corners / QUAD; ++q)
        name_others(t, star->begin, QUAD * q, back[q], out[q]);
    return !(plain && odd) && !(counting && some_run_alike(t, star));
}

/* 0: the star is not ordinary, and of its corners each is across from itself. */
CORE_INLINE int meet_any_star(
    const core_prepared_mesh *s, fan_batch *t, const listed_star *star, int counting) {
    const int plain = counting || norma_core_kept_faces(s) != NULL ||
                      s->call->options.non_manifold != NORMA_NON_MANIFOLD_HARD;
    if (star->count <= QUAD   ? meet_star(t, star, QUAD, plain, counting)
        : star->count <= HALF ? meet_star(t, star, HALF, plain, counting)
                              : meet_star(t, star, 2 * HALF, plain, counting))
        return 1;
    for (uint32_t i = star->begin; i < (uint32_t)star->begin + star->count; ++i) t->other[i] = i;
    return 0;
}

/* ---- which edges are smooth */

enum { EDGE_CUT = 1, EDGE_NEAR_CREASE = 2, EDGE_UNSURE = 4 };

typedef double row_lanes __attribute__((vector_size(4 * sizeof(double))));

CORE_INLINE row_lanes load_row(const double *row) {
    row_lanes lanes;
    memcpy(&lanes, row, sizeof lanes);
    return lanes;
}

/* Of all corners the products of the normals of their face and of that across the edge to next, and
 * of whether they are sure. */
CORE_INLINE void multiply_normals(const uint32_t *key, fan_batch *t, size_t count) {
    const double *rows = t->kept->row[0];
    for (size_t c = 0; c < count; ++c) {
        const row_lanes product =
            load_row(rows + (key[c] & ~7U)) * load_row(rows + (key[t->other[c]] & ~7U));
        memcpy(t->row[c], &product, sizeof product);
    }
}

/* Of all edges, without a branch: no branch could foretell any of it. */
CORE_INLINE void find_cuts(const core_crease *crease, fan_batch *t, size_t count) {
    for (size_t e = 0; e < count; ++e) {
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
static void cut_marked(const core_prepared_mesh *s, const star_list *list, fan_batch *t) {
    for (size_t c = 0; c < list->corner_count; ++c)
        if (t->other[c] != c && !is_unmarked(s, list->corners[c], list->corners[t->other[c]]))
            t->edge[c] = EDGE_CUT | (t->edge[c] & EDGE_UNSURE);
}

/* ---- fans: corners joined by smooth edges */

typedef struct star_links {
    uint32_t link[ORDINARY_CORNERS]; /* of each corner, as a bit, the one across a smooth edge to
                                        next; 0: none */
    uint32_t to[ORDINARY_CORNERS];   /* its number, or the corner's own */
} star_links;

static inline uint32_t lowest(uint32_t bits) { return (uint32_t)__builtin_ctz(bits); }

/* Whether all corners are one fan: from the one that no edge leads to, if there is one, along
 * smooth edges. reached: the others. */
CORE_INLINE int is_one_fan(
    const star_links *l, uint32_t count, uint32_t corners, uint32_t reached) {
    const uint32_t all = (1U << count) - 1, first = all & ~reached;
    uint32_t seen = 0, at = lowest(first ? first : 1);
    if (first & (first - 1)) return 0; /* two begin a fan */
    for (uint32_t i = 0; i < corners; ++i) {
        seen |= 1U << at;
        at = l->to[at];
    }
    return seen == all;
}

/* UNSURE: some direction is, or some edge too near the crease to tell by the cosine. */
enum { UNSURE = 0, SEVERAL_FANS, ONE_FAN };

/* Of four corners. Returns the links, and what is unsure in the bits above the corners'. */
CORE_INLINE quad link_quad(
    const fan_batch *t, const listed_star *star, uint32_t from, star_links *l) {
    const uint32_t begin = star->begin + from;
    const quad number = number_quad(from), back = load_quad(t->back + begin),
               how = load_quad(t->edge + begin), other = load_quad(t->other + begin),
               link = back & (quad)((how & EDGE_CUT) == 0),
               unsure = how & (EDGE_UNSURE | ((quad)(back != 0) & EDGE_NEAR_CREASE));
    store_quad(l->link + from, link);
    store_quad(l->to + from, choose_quad((quad)(link != 0), other - star->begin, number));
    return (link | unsure << ORDINARY_CORNERS) & (quad)(number < star->count);
}

CORE_INLINE int link_ordinary(
    const fan_batch *t, const listed_star *star, uint32_t corners, star_links *l) {
    quad links = {0};
    for (uint32_t from = 0; from < corners; from += QUAD) links |= link_quad(t, star, from, l);
    const uint32_t reached = any_of_quad(links);
    if (reached >> ORDINARY_CORNERS) return UNSURE;
    return is_one_fan(l, star->count, corners, reached) ? ONE_FAN : SEVERAL_FANS;
}

/* Edges to positions of higher number, each with one face out and one back, or one alone. */
static void count_edges(
    const fan_batch *t, const listed_star *star, const star_links *l, norma_edges *edges) {
    for (uint32_t i = 0; i < star->count; ++i) {
        const uint32_t c = star->begin + i;
        const int is_open = !t->back[c];
        const size_t next = star->position < t->next[c],
                     previous = !t->out[c] && star->position < t->previous[c];
        edges->count += next + previous;
        edges->open += previous;
        *(is_open ? &edges->open : l->link[i] ? &edges->smooth : &edges->hard) += next;
    }
}

/* The sum of some of a star's corners, in their order, in a register: one in memory would wait for
 * its last store. */
CORE_INLINE void sum_fan(fan_batch *t, const uint32_t *key, uint32_t members, uint32_t fan) {
    const double *rows = t->kept->row[0];
    row_lanes sum = {0};
    for (; members; members &= members - 1) {
        const uint32_t k = key[lowest(members)];
        sum += load_row(rows + (k & ~7U)) * rows[k + 4];
    }
    memcpy(t->row[fan], &sum, sizeof sum);
}

/* Numbers them from the star's first on, in the order of their first corners, and sums them.
 * Returns how many there are. */
CORE_INLINE uint32_t sum_fans(
    fan_batch *t, const uint32_t *key, const listed_star *star, const star_links *l) {
    uint32_t *fan_of = t->fan_of + star->begin;
    uint32_t left = (1U << star->count) - 1, first = left, fan = star->first_fan;
    for (uint32_t c = 0; c < star->count; ++c) first &= ~l->link[c];
    for (; left; ++fan) {
        const uint32_t before = left;
        uint32_t at = lowest(first & left ? first & left : left), next;
        do {
            fan_of[at] = fan;
            left &= ~(1U << at);
            next = l->link[at] & left;
            at = lowest(next | 1U << 31);
        } while (next);
        sum_fan(t, key, before & ~left, fan);
    }
    return fan - star->first_fan;
}

/* The one fan of most stars. */
CORE_INLINE void sum_one_fan(fan_batch *t, const uint32_t *key, const listed_star *star) {
    const double *rows = t->kept->row[0];
    row_lanes sum = {0};
    for (uint32_t i = 0; i < star->count; ++i)
        sum += load_row(rows + (key[i] & ~7U)) * rows[key[i] + 4];
    memcpy(t->row[star->first_fan], &sum, sizeof sum);
    for (uint32_t i = 0; i < ORDINARY_CORNERS; ++i) t->fan_of[star->begin + i] = star->first_fan;
}

/* Returns how many fans; 0: the star is not ordinary. */
CORE_INLINE uint32_t settle_star(
    fan_batch *t, const uint32_t *key, const listed_star *star, norma_edges *edges) {
    star_links l;
    uint32_t fans = 1;
    const int found = star->count <= QUAD   ? link_ordinary(t, star, QUAD, &l)
                      : star->count <= HALF ? link_ordinary(t, star, HALF, &l)
                                            : link_ordinary(t, star, 2 * HALF, &l);
    if (found == UNSURE) return 0;
    if (found == ONE_FAN)
        sum_one_fan(t, key, star);
    else
        fans = sum_fans(t, key, star, &l);
    if (edges) count_edges(t, star, &l, edges);
    return fans;
}

/* ---- normals */

/* What norma_core_decide_sum does, where neither overflow nor cancelling is near; decided: 0 where
 * they are. */
CORE_INLINE void decide(fan_batch *t, size_t count) {
    for (size_t from = 0; from < count; from += CORE_LANES)
        for (size_t f = from; f < from + CORE_LANES; ++f) {
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
    t->all_decided = 1;
    for (size_t f = 0; f < count; ++f) {
        const fan_lanes fan = {t->direction[0][f], t->direction[1][f], t->direction[2][f], 0};
        memcpy(&t->fans[f], &fan, sizeof fan);
        if (t->decided[f] != 0) continue;
        norma_core_decide_sum(t->row[f], t->row[f][3], &t->fans[f]);
        t->all_decided = 0;
    }
}

CORE_INLINE void measure_list(const core_prepared_mesh *s, star_list *list, fan_batch *t) {
    const uint32_t *at = t->kept->at[0];
    if (norma_core_kept_faces(s))
        weigh_polygons(s, list, t->kept);
    else
        measure_all_waiting(s, list, t->kept);
    for (size_t i = 0; i < list->corner_count; ++i) {
        t->next[i] = at[list->key[i] + 1];
        t->previous[i] = at[list->key[i] + 2];
    }
}

CORE_INLINE int settle(
    const core_prepared_mesh *s, star_list *list, fan_batch *t, norma_edges *edges) {
    uint32_t fans = 0;
    int all = 1;
    measure_list(s, list, t);
    for (size_t i = 0; i < list->star_count; ++i)
        list->stars[i].fan_count = (uint16_t)meet_any_star(s, t, &list->stars[i], edges != NULL);
    multiply_normals(list->key, t, list->corner_count);
    find_cuts(&s->crease, t, list->corner_count);
    if (s->mesh.hard_edges || s->mesh.smoothing_groups) cut_marked(s, list, t);
    for (size_t i = 0; i < list->star_count; ++i) {
        listed_star *star = &list->stars[i];
        star->first_fan = (uint16_t)fans;
        if (star->fan_count)
            star->fan_count = (uint16_t)settle_star(t, list->key + star->begin, star, edges);
        fans += star->fan_count;
        all &= star->fan_count != 0;
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
