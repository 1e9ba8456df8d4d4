/* topology.c: edges are paired around each position. Where the corners there form what a whole
 * surface has, fans of two faces at each edge, comparing the few of them with one another is
 * enough; all else is sorted. */
#include "core/topology/topology.h"
#include "core/call/call.h"
#include "core/face/face.h"
#include "core/mesh/mesh.h"
#include <stdlib.h>

/* ---- welded corners */

enum { CORNERS_IN_BLOCK = 1 << 15, FACES_IN_BLOCK = 1 << 12, POSITIONS_IN_BLOCK = 1 << 12 };

static size_t block_count_of(size_t count, size_t size) {
    return count / size + (count % size != 0);
}

typedef struct corner_copy {
    const core_mesh *from;
    uint32_t *to;
} corner_copy;

static void weld_corners(void *context, size_t block) {
    const corner_copy *copy = context;
    const size_t count = copy->from->corner_count, begin = block * CORNERS_IN_BLOCK,
                 end = count - begin < CORNERS_IN_BLOCK ? count : begin + CORNERS_IN_BLOCK;
    for (size_t c = begin; c < end; ++c) copy->to[c] = norma_core_welded_corner(copy->from, c);
}

/* ---- what a polygon has in common with its twins */

static uint64_t pair_of(uint32_t a, uint32_t b) {
    return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

static core_polygon polygon_of(const core_mesh *mesh, size_t face) {
    core_polygon polygon = {.anchor = UINT32_MAX};
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    uint32_t least = UINT32_MAX;
    for (size_t c = begin; c < end; ++c) {
        const uint32_t here = norma_core_corner(mesh, c),
                       next = norma_core_corner(mesh, norma_core_next_in_face(mesh, face, c));
        if (here == next) continue;
        ++polygon.kept;
        if (here < least) {
            least = here;
            polygon.anchor = (uint32_t)c;
        }
    }
    if (polygon.kept < 3)
        polygon.anchor = UINT32_MAX;
    else
        polygon.key = norma_core_twin_key(mesh, face);
    return polygon;
}

static void find_polygons(void *context, size_t block) {
    const core_topology *t = context;
    const size_t count = t->mesh.face_count, begin = block * FACES_IN_BLOCK,
                 end = count - begin < FACES_IN_BLOCK ? count : begin + FACES_IN_BLOCK;
    for (size_t f = begin; f < end; ++f) t->polygons[f] = polygon_of(&t->mesh, f);
}

/* ---- opening */

static norma_result fill_topology(core_topology *t, const core_mesh *welded) {
    corner_copy copy = {welded, t->corners};
    norma_result result = norma_core_parallel(
        t->call, block_count_of(welded->corner_count, CORNERS_IN_BLOCK), weld_corners, &copy);
    t->mesh = *welded;
    t->mesh.weld = NULL;
    t->mesh.corners = t->corners;
    t->mesh.corner_size = 4;
    if (!result && t->polygons)
        result = norma_core_parallel(
            t->call, block_count_of(t->mesh.face_count, FACES_IN_BLOCK), find_polygons, t);
    return result;
}

norma_result norma_core_topology_open(
    core_call *call, const core_mesh *checked, core_topology *topology) {
    core_mesh welded = *checked;
    *topology = (core_topology){.call = call, .mesh = *checked};
    norma_result result = norma_core_weld(call, &welded);
    if (result) return result;
    topology->corners = norma_core_allocate(call, checked->corner_count, sizeof *topology->corners);
    if (checked->face_starts)
        topology->polygons =
            norma_core_allocate(call, checked->face_count, sizeof *topology->polygons);
    result = topology->corners && (topology->polygons || !checked->face_starts)
                 ? fill_topology(topology, &welded)
                 : NORMA_ERROR_MEMORY;
    norma_core_unweld(call, &welded);
    if (result) norma_core_topology_close(topology);
    return result;
}

void norma_core_topology_close(core_topology *t) {
    norma_core_release(t->call, t->partners, t->mesh.corner_count, sizeof *t->partners);
    norma_core_release(t->call, t->others, t->mesh.corner_count, sizeof *t->others);
    if (t->corners_of.starts) norma_core_corners_of_position_release(t->call, &t->corners_of);
    norma_core_release(t->call, t->polygons, t->mesh.face_count, sizeof *t->polygons);
    norma_core_release(t->call, t->corners, t->mesh.corner_count, sizeof *t->corners);
    *t = (core_topology){0};
}

/* ---- the corners at one position */

typedef struct star_slot {
    uint32_t next, previous;          /* positions of the kept neighbours */
    uint32_t corner, previous_corner; /* where the edges to next and from previous begin */
    uint32_t face;
    uint32_t anchor; /* nonzero: the face is judged as a twin at this corner */
} star_slot;

typedef struct star {
    star_slot *slots;
    core_edge_run *runs; /* two for each slot */
    core_twin *twins;
    uint32_t *fans; /* of each slot a lower one of the same fan, or itself */
    size_t count;
    uint32_t position;
} star;

enum { STAR_SLOTS = 64, FEW_SLOTS = 12 };
typedef struct star_space {
    star_slot slots[STAR_SLOTS];
    core_edge_run runs[2 * STAR_SLOTS];
    core_twin twins[STAR_SLOTS];
    uint32_t fans[STAR_SLOTS];
} star_space;

typedef struct pairing {
    core_topology *topology;
    const core_topology_visitor *visitor;
    size_t blocks;
} pairing;

static int load_triangle(const core_topology *t, uint32_t position, size_t corner, star_slot *s) {
    const size_t face = corner / 3, begin = 3 * face,
                 next = corner + 1 < begin + 3 ? corner + 1 : begin,
                 previous = corner > begin ? corner - 1 : begin + 2;
    *s = (star_slot){t->corners[next], t->corners[previous], (uint32_t)corner, (uint32_t)previous,
        (uint32_t)face, 0};
    s->anchor = position < s->next && position < s->previous;
    return s->next != position && s->previous != position && s->next != s->previous;
}

static int load_polygon_slot(const core_topology *t, size_t corner, star_slot *s) {
    const size_t face = t->corners_of.faces[corner];
    if (t->polygons[face].anchor == UINT32_MAX || !norma_core_is_kept(&t->mesh, face, corner))
        return 0;
    const size_t next = norma_core_next_kept(&t->mesh, face, corner),
                 previous = norma_core_previous_kept(&t->mesh, face, corner);
    *s = (star_slot){t->corners[next], t->corners[previous], (uint32_t)corner, (uint32_t)previous,
        (uint32_t)face, t->polygons[face].anchor == corner};
    return 1;
}

static void load_star(const core_topology *t, uint32_t position, star *r) {
    r->count = 0;
    r->position = position;
    for (uint32_t i = t->corners_of.starts[position]; i < t->corners_of.starts[position + 1]; ++i) {
        const size_t corner = t->corners_of.corners[i];
        star_slot *s = &r->slots[r->count];
        const int has_edges =
            t->polygons ? load_polygon_slot(t, corner, s) : load_triangle(t, position, corner, s);
        r->count += has_edges != 0;
        if (!has_edges) t->partners[corner] = CORE_EDGE_NONE;
    }
}

/* ---- the ordinary star: one closed fan, one face each way at each edge */

/* Finds of each face the one that comes back along its next edge; 0: none does, or several do. */
static int pair_few(const star *r, uint8_t *after) {
    const size_t n = r->count;
    for (size_t i = 0; i < n; ++i) {
        size_t ahead = 0, matches = 0;
        for (size_t k = 0; k < n; ++k) {
            const size_t back = r->slots[k].previous == r->slots[i].next;
            matches += back;
            ahead += back * k;
        }
        if (matches != 1) return 0;
        after[i] = (uint8_t)ahead;
    }
    return 1;
}

/* Whether the first face leads to every other one before it is reached again. */
static int is_one_round(const uint8_t *after, size_t n) {
    size_t length = 0, at = 0;
    do {
        at = after[at];
        ++length;
    } while (at != 0 && length < n);
    return at == 0 && length == n;
}

/* In one round no two faces leave along the same edge, as each is the only one that comes back
 * along an edge. Two faces may be twins. */
static int pair_ordinary(const core_topology *t, const star *r) {
    uint8_t after[FEW_SLOTS];
    if (r->count < 3 || r->count > FEW_SLOTS || !pair_few(r, after) ||
        !is_one_round(after, r->count))
        return 0;
    for (size_t i = 0; i < r->count; ++i) {
        if (r->position > r->slots[i].next) continue;
        const uint32_t out = r->slots[i].corner, in = r->slots[after[i]].previous_corner;
        t->partners[out] = in;
        t->partners[in] = out;
    }
    return 1;
}

/* ---- any star */

static int run_is_less(const void *first, const void *second) {
    const core_edge_run *a = first, *b = second;
    if (a->other != b->other) return a->other < b->other;
    if (a->out != b->out) return a->out > b->out;
    return a->corner < b->corner;
}

static int twin_is_less(const void *first, const void *second) {
    const core_twin *a = first, *b = second;
    return a->key != b->key ? a->key < b->key : a->face < b->face;
}

static void sort_runs(core_edge_run *runs, size_t count) {
    if (count > 2 * FEW_SLOTS) {
        norma_core_sort(runs, count, sizeof *runs, run_is_less);
        return;
    }
    for (size_t i = 1; i < count; ++i) {
        const core_edge_run run = runs[i];
        size_t k = i;
        for (; k > 0 && run_is_less(&run, &runs[k - 1]); --k) runs[k] = runs[k - 1];
        runs[k] = run;
    }
}

static size_t list_runs(const core_topology *t, const star *r) {
    size_t count = 0;
    for (size_t i = 0; i < r->count; ++i) {
        const star_slot *s = &r->slots[i];
        const uint64_t key = t->polygons ? t->polygons[s->face].key : 0;
        r->runs[count++] = (core_edge_run){t->polygons ? key : norma_core_triangle_key(s->previous),
            s->next, s->corner, (uint32_t)i, 1};
        r->runs[count++] = (core_edge_run){t->polygons ? key : norma_core_triangle_key(s->next),
            s->previous, s->previous_corner, (uint32_t)i, 0};
    }
    sort_runs(r->runs, count);
    return count;
}

static void pair_edge(
    const pairing *p, size_t block, const star *r, const core_edge_run *runs, size_t count) {
    const core_topology *t = p->topology;
    for (size_t i = 1; i < count; ++i) norma_core_join_sets(r->fans, runs[0].slot, runs[i].slot);
    if (runs->other < r->position) return;
    if (count == 2 && runs[0].out != runs[1].out) {
        t->partners[runs[0].corner] = runs[1].corner;
        t->partners[runs[1].corner] = runs[0].corner;
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        t->partners[runs[i].corner] = count == 1   ? CORE_EDGE_OPEN
                                      : count == 2 ? CORE_EDGE_CONFLICT
                                                   : CORE_EDGE_MANY;
        if (count > 1) t->others[runs[i].corner] = runs[i + 1 < count ? i + 1 : 0].corner;
    }
    if (p->visitor && p->visitor->edge)
        p->visitor->edge(p->visitor->context, block, r->position, runs, count);
}

static void find_twins(const pairing *p, size_t block, const star *r) {
    const core_topology *t = p->topology;
    size_t count = 0;
    if (!p->visitor || !p->visitor->twins) return;
    for (size_t i = 0; i < r->count; ++i) {
        const star_slot *s = &r->slots[i];
        const uint64_t key = t->polygons ? t->polygons[s->face].key : s->next < s->previous;
        if (s->anchor)
            r->twins[count++] = (core_twin){
                t->polygons ? key & ~(uint64_t)CORE_KEY_WAY : pair_of(s->next, s->previous),
                s->face, key & 1};
    }
    if (count < 2) return;
    norma_core_sort(r->twins, count, sizeof *r->twins, twin_is_less);
    for (size_t begin = 0, end; begin < count; begin = end) {
        for (end = begin + 1; end < count && r->twins[end].key == r->twins[begin].key; ++end) {
        }
        if (end - begin > 1)
            p->visitor->twins(p->visitor->context, block, &r->twins[begin], end - begin);
    }
}

static void pair_any(const pairing *p, size_t block, const star *r) {
    size_t fans = 0;
    for (size_t i = 0; i < r->count; ++i) r->fans[i] = (uint32_t)i;
    const size_t count = list_runs(p->topology, r);
    for (size_t begin = 0, end; begin < count; begin = end) {
        for (end = begin + 1; end < count && r->runs[end].other == r->runs[begin].other; ++end) {
        }
        pair_edge(p, block, r, &r->runs[begin], end - begin);
    }
    for (size_t i = 0; i < r->count; ++i) fans += r->fans[i] == i;
    if (fans > 1 && p->visitor && p->visitor->bow_tie)
        p->visitor->bow_tie(p->visitor->context, block, r->position, fans);
    find_twins(p, block, r);
}

static void pair_star(const pairing *p, size_t block, uint32_t position, star *r) {
    load_star(p->topology, position, r);
    if (r->count && !pair_ordinary(p->topology, r)) pair_any(p, block, r);
}

/* ---- all of them */

static void pair_block(void *context, size_t block) {
    const pairing *p = context;
    const core_corners_of_position *corners_of = &p->topology->corners_of;
    const size_t count = corners_of->position_count, begin = block * POSITIONS_IN_BLOCK,
                 end = count - begin < POSITIONS_IN_BLOCK ? count : begin + POSITIONS_IN_BLOCK;
    star_space space;
    star r = {space.slots, space.runs, space.twins, space.fans, 0, 0};
    for (size_t position = begin; position < end; ++position) {
        const size_t size = corners_of->starts[position + 1] - corners_of->starts[position];
        if (size && size <= STAR_SLOTS) pair_star(p, block, (uint32_t)position, &r);
    }
}

static norma_result pair_large(const pairing *p) {
    const core_topology *t = p->topology;
    const size_t most = t->corners_of.most;
    if (most <= STAR_SLOTS) return NORMA_OK;
    star r = {norma_core_allocate(t->call, most, sizeof *r.slots),
        norma_core_allocate(t->call, 2 * most, sizeof *r.runs),
        norma_core_allocate(t->call, most, sizeof *r.twins),
        norma_core_allocate(t->call, most, sizeof *r.fans), 0, 0};
    norma_result result = r.slots && r.runs && r.twins && r.fans ? NORMA_OK : NORMA_ERROR_MEMORY;
    for (size_t position = 0; position < t->corners_of.position_count && !result; ++position) {
        if (t->corners_of.starts[position + 1] - t->corners_of.starts[position] <= STAR_SLOTS)
            continue;
        pair_star(p, p->blocks - 1, (uint32_t)position, &r);
        if (norma_core_progress(t->call, 1)) result = NORMA_CANCELLED;
    }
    norma_core_release(t->call, r.slots, most, sizeof *r.slots);
    norma_core_release(t->call, r.runs, 2 * most, sizeof *r.runs);
    norma_core_release(t->call, r.twins, most, sizeof *r.twins);
    norma_core_release(t->call, r.fans, most, sizeof *r.fans);
    return result;
}

size_t norma_core_topology_blocks(const core_topology *topology) {
    return block_count_of(topology->mesh.positions.count, POSITIONS_IN_BLOCK) + 1;
}

norma_result norma_core_pair_edges(core_topology *topology, const core_topology_visitor *visitor) {
    const pairing p = {topology, visitor, norma_core_topology_blocks(topology)};
    norma_result result = topology->corners_of.starts
                              ? NORMA_OK
                              : norma_core_corners_of_position_build(
                                    topology->call, &topology->mesh, &topology->corners_of);
    if (result) return result;
    if (!topology->partners)
        topology->partners = norma_core_allocate(
            topology->call, topology->mesh.corner_count, sizeof *topology->partners);
    if (!topology->others)
        topology->others = norma_core_allocate(
            topology->call, topology->mesh.corner_count, sizeof *topology->others);
    if (!topology->partners || !topology->others) return NORMA_ERROR_MEMORY;
    result = norma_core_parallel(topology->call, p.blocks - 1, pair_block, (void *)(uintptr_t)&p);
    return !result ? pair_large(&p) : result;
}
