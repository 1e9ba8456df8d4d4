/* components.c: faces are visited from edge to edge, each component from its lower_of face on. */
#include "core/topology/topology.h"
#include "core/face/face.h"

typedef struct search {
    const core_topology *topology;
    core_components *out;
    core_joining joining;
    const core_components *parts; /* with CORE_JOIN_BODIES, where edges of many faces exist: what
                                     other edges hold together */
    size_t found;                 /* faces so far: those before `next` are done */
} search;

static norma_result grow_components(const core_call *call, core_components *c) {
    if (c->count < c->room) return NORMA_OK;
    const size_t room = 2 * c->room;
    uint32_t *starts = norma_core_allocate(call, room + 1, sizeof *starts);
    core_component *each = norma_core_allocate(call, room, sizeof *each);
    if (starts && each) {
        memcpy(starts, c->starts, (c->room + 1) * sizeof *starts);
        memcpy(each, c->each, c->room * sizeof *each);
        norma_core_release(call, c->starts, c->room + 1, sizeof *c->starts);
        norma_core_release(call, c->each, c->room, sizeof *c->each);
        c->starts = starts;
        c->each = each;
        c->room = room;
        return NORMA_OK;
    }
    norma_core_release(call, starts, room + 1, sizeof *starts);
    norma_core_release(call, each, room, sizeof *each);
    return NORMA_ERROR_MEMORY;
}

/* Reaches a face from one whose winding differs from it or does not. */
static void reach_partner(search *s, core_component *component, uint32_t number, size_t corner,
    size_t from, int differs) {
    core_components *c = s->out;
    const size_t face = norma_core_topology_face(s->topology, corner);
    const uint8_t reverse = c->reverse ? (uint8_t)(c->reverse[from] ^ differs) : 0;
    if (c->of[face] == UINT32_MAX) {
        c->of[face] = number;
        c->faces[s->found++] = (uint32_t)face;
        if (c->reverse) c->reverse[face] = reverse;
    } else if (c->reverse && c->reverse[face] != reverse) {
        component->flags |= COMPONENT_ONE_SIDED;
    }
}

static int is_unbalanced(const core_components *parts, size_t face) {
    return parts->of[face] == UINT32_MAX ||
           (parts->each[parts->of[face]].flags & COMPONENT_UNBALANCED) != 0;
}

static int joins_many(const search *s, size_t face, size_t corner) {
    return s->parts && (is_unbalanced(s->parts, face) ||
                           is_unbalanced(s->parts, norma_core_topology_face(s->topology, corner)));
}

static void visit_edges(search *s, core_component *component, uint32_t number, size_t face) {
    const core_topology *t = s->topology;
    for (size_t corner = norma_core_face_begin(&t->mesh, face);
         corner < norma_core_face_end(&t->mesh, face); ++corner) {
        const uint32_t partner = t->partners[corner];
        if (partner < CORE_EDGE_SPECIAL) {
            reach_partner(s, component, number, partner, face, 0);
        } else if (partner == CORE_EDGE_OPEN) {
            component->flags |= COMPONENT_OPEN;
        } else if (partner == CORE_EDGE_CONFLICT) {
            component->flags |= COMPONENT_CONFLICT;
            if (s->joining != CORE_JOIN_ALIKE)
                reach_partner(s, component, number, t->others[corner], face, 1);
        } else if (partner == CORE_EDGE_MANY) {
            component->flags |= COMPONENT_MANY;
            if (joins_many(s, face, t->others[corner]))
                reach_partner(s, component, number, t->others[corner], face, 0);
        }
    }
}

static int face_has_edges(const core_topology *t, size_t face) {
    if (t->polygons) return t->polygons[face].anchor != UINT32_MAX;
    return t->partners[3 * face] != CORE_EDGE_NONE;
}

static norma_result find_all(search *s) {
    core_components *c = s->out;
    for (size_t face = 0; face < c->face_count; ++face) {
        if (c->of[face] != UINT32_MAX || !face_has_edges(s->topology, face)) continue;
        if (grow_components(s->topology->call, c)) return NORMA_ERROR_MEMORY;
        const uint32_t number = (uint32_t)c->count;
        core_component component = {.parent = UINT32_MAX};
        size_t next = s->found;
        c->starts[number] = (uint32_t)next;
        c->of[face] = number;
        c->faces[s->found++] = (uint32_t)face;
        while (next < s->found) visit_edges(s, &component, number, c->faces[next++]);
        c->each[number] = component;
        ++c->count;
        c->starts[c->count] = (uint32_t)s->found;
    }
    return norma_core_progress(s->topology->call, 1) ? NORMA_CANCELLED : NORMA_OK;
}

/* ---- edges of more than two faces along which a part's own faces cancel: it is closed although it
 * touches itself or others there */

enum { MOST_AROUND = 64 };

static int run_way(const core_topology *t, const core_components *c, size_t corner) {
    const size_t face = norma_core_topology_face(t, corner);
    const int ascends = t->corners[corner] < t->corners[norma_core_topology_next(t, face, corner)];
    return (c->reverse && c->reverse[face]) == ascends ? -1 : 1;
}

static int is_corner_balanced(const core_topology *t, const core_components *c, size_t corner) {
    const uint32_t own = c->of[norma_core_topology_face(t, corner)];
    size_t at = corner;
    int sum = 0, count = 0;
    do {
        if (c->of[norma_core_topology_face(t, at)] == own) sum += run_way(t, c, at);
        at = t->others[at];
    } while (at != corner && ++count < MOST_AROUND);
    return at == corner && sum == 0;
}

static void find_unbalanced(const core_topology *t, core_components *c) {
    for (size_t corner = 0; corner < t->mesh.corner_count; ++corner) {
        if (t->partners[corner] != CORE_EDGE_MANY) continue;
        core_component *component = &c->each[c->of[norma_core_topology_face(t, corner)]];
        if (!(component->flags & COMPONENT_UNBALANCED) && !is_corner_balanced(t, c, corner))
            component->flags |= COMPONENT_UNBALANCED;
    }
}

/* The winding that fewer faces must give up is kept. */
static void keep_majority(core_components *c) {
    for (size_t i = 0; i < c->count; ++i) {
        const size_t begin = c->starts[i], end = c->starts[i + 1];
        size_t reversed = 0;
        for (size_t k = begin; k < end; ++k) reversed += c->reverse[c->faces[k]];
        const int one_sided = (c->each[i].flags & COMPONENT_ONE_SIDED) != 0,
                  other = 2 * reversed > end - begin;
        if (!one_sided && !other) continue;
        for (size_t k = begin; k < end; ++k)
            c->reverse[c->faces[k]] = (uint8_t)(one_sided ? 0 : !c->reverse[c->faces[k]]);
    }
}

static int has_many(const core_topology *t) {
    size_t corner = 0;
    while (corner < t->mesh.corner_count && t->partners[corner] != CORE_EDGE_MANY) ++corner;
    return corner < t->mesh.corner_count;
}

static norma_result find_components(const core_topology *t, core_joining joining,
    const core_components *parts, core_components *c) {
    enum { FEW = 64 };
    *c = (core_components){.face_count = t->mesh.face_count, .room = FEW};
    c->of = norma_core_allocate(t->call, c->face_count, sizeof *c->of);
    c->faces = norma_core_allocate(t->call, c->face_count, sizeof *c->faces);
    c->starts = norma_core_allocate(t->call, FEW + 1, sizeof *c->starts);
    c->each = norma_core_allocate(t->call, FEW, sizeof *c->each);
    const int reverses = joining != CORE_JOIN_BODIES;
    if (reverses) c->reverse = norma_core_allocate(t->call, c->face_count, 1);
    norma_result result = c->of && c->faces && c->starts && c->each && (c->reverse || !reverses)
                              ? NORMA_OK
                              : NORMA_ERROR_MEMORY;
    if (!result) {
        search s = {t, c, joining, parts, 0};
        memset(c->of, 0xff, c->face_count * sizeof *c->of);
        if (c->reverse) memset(c->reverse, 0, c->face_count);
        c->starts[0] = 0;
        result = find_all(&s);
    }
    if (!result && c->reverse) keep_majority(c);
    if (!result) find_unbalanced(t, c);
    if (result) norma_core_release_components(t->call, c);
    return result;
}

norma_result norma_core_find_components(
    const core_topology *t, core_joining joining, core_components *c) {
    core_components parts;
    if (joining != CORE_JOIN_BODIES || !has_many(t)) return find_components(t, joining, NULL, c);
    norma_result result = find_components(t, CORE_JOIN_CUT, NULL, &parts);
    if (result) return result;
    result = find_components(t, joining, &parts, c);
    norma_core_release_components(t->call, &parts);
    return result;
}

void norma_core_release_components(const core_call *call, core_components *c) {
    norma_core_release(call, c->of, c->face_count, sizeof *c->of);
    norma_core_release(call, c->faces, c->face_count, sizeof *c->faces);
    norma_core_release(call, c->starts, c->room + 1, sizeof *c->starts);
    norma_core_release(call, c->each, c->room, sizeof *c->each);
    norma_core_release(call, c->reverse, c->face_count, 1);
    *c = (core_components){0};
}

/* ---- boxes and volumes: of parts in blocks of faces, whose sums are added in order */

static void widen_component(core_component *component, const double p[3]) {
    for (int k = 0; k < 3; ++k) {
        component->low[k] = p[k] < component->low[k] ? p[k] : component->low[k];
        component->high[k] = p[k] > component->high[k] ? p[k] : component->high[k];
    }
}

typedef struct extent_sum {
    core_component box;
    double volume, terms;
} extent_sum;

typedef struct measuring {
    const core_topology *topology;
    const core_components *components;
    extent_sum *sums; /* of each block */
    size_t part;
    uint8_t not_closed;
} measuring;

static void read_corner(const core_topology *t, size_t corner, const double origin[3],
    core_component *box, double from[3]) {
    double p[3];
    norma_core_position(&t->mesh, t->corners[corner], p);
    widen_component(box, p);
    norma_core_subtract(p, origin, from);
}

/* Six times the volume between a face, cut into a fan, and the origin. */
static void add_polygon_volume(
    const core_topology *t, size_t face, const double origin[3], int reversed, extent_sum *sum) {
    const size_t begin = norma_core_face_begin(&t->mesh, face),
                 end = norma_core_face_end(&t->mesh, face);
    double first[3], a[3], b[3], cross[3];
    read_corner(t, begin, origin, &sum->box, first);
    read_corner(t, begin + 1, origin, &sum->box, a);
    for (size_t corner = begin + 2; corner < end; ++corner) {
        read_corner(t, corner, origin, &sum->box, b);
        norma_core_cross(a, b, cross);
        const double term = norma_core_dot(first, cross);
        sum->volume += reversed ? -term : term;
        sum->terms += term < 0 ? -term : term;
        memcpy(a, b, sizeof a);
    }
}

enum { FACES_IN_BLOCK = 1 << 13 };

static double lower_of(double a, double b) { return a < b ? a : b; }
static double greatest(double a, double b) { return a > b ? a : b; }

/* The same of a triangle, straight. */
static void add_triangle_volume(
    const core_topology *t, size_t face, const double origin[3], int reversed, extent_sum *sum) {
    double p[3][3], cross[3];
    for (size_t k = 0; k < 3; ++k) norma_core_position(&t->mesh, t->corners[3 * face + k], p[k]);
    for (int k = 0; k < 3; ++k) {
        sum->box.low[k] = lower_of(lower_of(p[0][k], p[1][k]), lower_of(p[2][k], sum->box.low[k]));
        sum->box.high[k] =
            greatest(greatest(p[0][k], p[1][k]), greatest(p[2][k], sum->box.high[k]));
        for (int i = 0; i < 3; ++i) p[i][k] -= origin[k];
    }
    norma_core_cross(p[1], p[2], cross);
    const double term = norma_core_dot(p[0], cross);
    sum->volume += reversed ? -term : term;
    sum->terms += fabs(term);
}

static void measure_faces_of_block(const measuring *m, size_t part, size_t block, extent_sum *sum) {
    const core_components *c = m->components;
    const size_t first = c->starts[part], count = c->starts[part + 1] - first,
                 begin = block * FACES_IN_BLOCK;
    const size_t end = count - begin < FACES_IN_BLOCK ? count : begin + FACES_IN_BLOCK;
    double origin[3];
    *sum = (extent_sum){
        .box = {.low = {INFINITY, INFINITY, INFINITY}, .high = {-INFINITY, -INFINITY, -INFINITY}}};
    norma_core_position(&m->topology->mesh,
        m->topology->corners[norma_core_face_begin(&m->topology->mesh, c->faces[first])], origin);
    for (size_t i = first + begin; i < first + end; ++i) {
        const int reversed = c->reverse && c->reverse[c->faces[i]];
        if (m->topology->polygons)
            add_polygon_volume(m->topology, c->faces[i], origin, reversed, sum);
        else
            add_triangle_volume(m->topology, c->faces[i], origin, reversed, sum);
    }
}

/* Relative to the sum of the terms' sizes: as little is no volume. */
static const double VOLUME_ROUNDING = 1e-12;

static void finish_part(core_component *component, const extent_sum *sum, uint8_t not_closed) {
    for (int k = 0; k < 3; ++k) {
        component->low[k] = sum->box.low[k];
        component->high[k] = sum->box.high[k];
    }
    component->volume = !(component->flags & not_closed) &&
                                fabs(sum->volume) > VOLUME_ROUNDING * sum->terms &&
                                sum->terms < INFINITY
                            ? sum->volume
                            : 0;
}

static void add_sum(extent_sum *sum, const extent_sum *block) {
    widen_component(&sum->box, block->box.low);
    widen_component(&sum->box, block->box.high);
    sum->volume += block->volume;
    sum->terms += block->terms;
}

static size_t blocks_of_part(const core_components *c, size_t part) {
    const size_t count = c->starts[part + 1] - c->starts[part];
    return count / FACES_IN_BLOCK + (count % FACES_IN_BLOCK != 0);
}

static void measure_small(void *context, size_t part) {
    const measuring *m = context;
    extent_sum sum;
    if (blocks_of_part(m->components, part) > 1) return;
    measure_faces_of_block(m, part, 0, &sum);
    finish_part(&m->components->each[part], &sum, m->not_closed);
}

static void measure_block_of_large(void *context, size_t block) {
    const measuring *m = context;
    measure_faces_of_block(m, m->part, block, &m->sums[block]);
}

static norma_result measure_large(measuring *m, size_t part) {
    core_call *call = m->topology->call;
    const size_t blocks = blocks_of_part(m->components, part);
    m->part = part;
    m->sums = norma_core_allocate(call, blocks, sizeof *m->sums);
    if (!m->sums) return NORMA_ERROR_MEMORY;
    const norma_result result = norma_core_parallel(call, blocks, measure_block_of_large, m);
    for (size_t i = 1; i < blocks && !result; ++i) add_sum(&m->sums[0], &m->sums[i]);
    if (!result) finish_part(&m->components->each[part], &m->sums[0], m->not_closed);
    norma_core_release(call, m->sums, blocks, sizeof *m->sums);
    return result;
}

norma_result norma_core_measure_components(
    const core_topology *topology, core_components *components, uint8_t not_closed) {
    measuring m = {.topology = topology, .components = components, .not_closed = not_closed};
    norma_result result = norma_core_parallel(topology->call, components->count, measure_small, &m);
    for (size_t i = 0; i < components->count && !result; ++i)
        if (blocks_of_part(components, i) > 1) result = measure_large(&m, i);
    return result;
}
