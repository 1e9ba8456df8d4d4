/* mikk_groups.c: vertex by vertex the groups of triangles, what each sums to, and what is written.
 */
#include "core/tangent/tangents.h"

/* ---- The corners at one vertex, and the tangent spaces that they share. */

typedef struct mikk_space {
    float s[3], t[3]; /* t and the lengths: only of meshes with quads */
    float length_s, length_t, angle;
    int positive;
    uint32_t ends; /* of all tangents of a group that records sum */
    int opposed;   /* of a group: some of its tangents may be opposed to each other */
} mikk_space;

typedef struct mikk_star {
    const mikk_mesh *mesh;
    uint32_t vertex;
    size_t count;
    const uint32_t *corners;           /* of triangles, ascending */
    const uint32_t *next, *previous;   /* the vertices beside it in each corner's triangle */
    const uint8_t *flags;              /* of each corner's triangle */
    const mikk_corners *contributions; /* corner j's are in lane first + j */
    size_t first;
    mikk_edge_table *table; /* NULL: the star is small */
    mikk_links links;
    uint32_t *space;    /* of each corner, or MIKK_NONE */
    uint32_t *sequence; /* of each corner: how many got their space before it */
    uint32_t *seeds;    /* of each space: the corner that its group began with */
    mikk_space *spaces; /* room for twice the corners */
    size_t space_count;
} mikk_star;

static inline uint8_t mikk_flags_of(const mikk_star *star, size_t j) { return star->flags[j]; }
static inline const mikk_corners *mikk_block(const mikk_star *star, size_t j) {
    return &star->contributions[(star->first + j) / MIKK_LANES];
}
static inline size_t mikk_lane_of(const mikk_star *star, size_t j) {
    return (star->first + j) % MIKK_LANES;
}

/* Adds what a corner contributes. */
static inline void mikk_add(const mikk_corners *c, size_t lane, int has_quads, mikk_space *space) {
    const float angle = c->angle[lane];
    for (int k = 0; k < 3; ++k) space->s[k] += angle * c->s[k][lane];
    if (!has_quads) return;
    for (int k = 0; k < 3; ++k) space->t[k] += angle * c->t[k][lane];
    space->length_s += angle * c->length_s[lane];
    space->length_t += angle * c->length_t[lane];
    space->angle += angle;
}
static inline void add_contribution(const mikk_star *star, size_t j, mikk_space *space) {
    mikk_add(mikk_block(star, j), mikk_lane_of(star, j), star->mesh->has_quads, space);
}

static inline int mikk_follows(const mikk_star *star, size_t j) {
    return mikk_flags_of(star, j) & MIKK_FOLLOWS;
}

/* ends: of some vectors together. Six bits for the ends of each axis that grow, six for the others.
 */
static inline int mikk_ends_oppose(unsigned ends) { return (ends & ends >> 6 & 63) != 0; }

static inline uint32_t mikk_target(const mikk_mesh *mesh, uint32_t corner) {
    return mesh->corners ? mesh->corners[corner] : corner;
}

/* ---- The tangent space that a sum of contributions comes to. */

static void core_mikk_normalise(float v[3]) {
    if (mikk_is_zero(v[0]) && mikk_is_zero(v[1]) && mikk_is_zero(v[2])) return;
    const float by = 1 / sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; ++k) v[k] = by * v[k];
}

/* Makes the sum a space. */
static void core_mikk_finish(const mikk_star *star, mikk_space *space) {
    core_mikk_normalise(space->s);
    if (!star->mesh->has_quads) return;
    core_mikk_normalise(space->t);
    if (space->angle > 0) {
        space->length_s /= space->angle;
        space->length_t /= space->angle;
    }
}

/* ---- Who shares an edge, among the corners of one vertex. Of the triangles along an
 * edge, in ascending order, each takes the first one before it that runs the other way and has no
 * partner yet: what the reference's search over its sorted edges comes to, also where more than two
 * meet. */

static void link_small(
    const uint32_t *next, const uint32_t *previous, size_t count, const mikk_links *links) {
    for (uint32_t j = 0; j < count; ++j) {
        links->left[j] = links->right[j] = MIKK_NONE;
        for (uint32_t i = 0; i < j; ++i) {
            if (previous[i] == next[j] && links->right[i] == MIKK_NONE &&
                links->left[j] == MIKK_NONE) {
                links->left[j] = i;
                links->right[i] = j;
            }
            if (next[i] == previous[j] && links->left[i] == MIKK_NONE &&
                links->right[j] == MIKK_NONE) {
                links->right[j] = i;
                links->left[i] = j;
            }
        }
    }
}

static struct mikk_edge *edge_to(const mikk_edge_table *table, size_t room, uint32_t vertex) {
    const uint32_t hash = vertex * UINT32_C(2654435769);
    size_t slot = (hash ^ hash >> 15) & (room - 1);
    while (table->edges[slot].first != MIKK_NONE && table->edges[slot].vertex != vertex)
        slot = (slot + 1) & (room - 1);
    return &table->edges[slot];
}

/* Edges that wait for a partner stand in line behind their vertex: 2 * corner, and 1 more for an
 * edge in. All in one line run the same way. A line that has become empty keeps its place, with
 * last at MIKK_NONE. */
static void meet_edge(
    const mikk_edge_table *table, size_t room, uint32_t vertex, uint32_t edge, mikk_links *links) {
    struct mikk_edge *line = edge_to(table, room, vertex);
    const int waits = line->first != MIKK_NONE && line->last != MIKK_NONE;
    if (waits && ((line->first ^ edge) & 1)) {
        const uint32_t out = edge & 1 ? line->first : edge, in = edge & 1 ? edge : line->first;
        links->left[out / 2] = in / 2;
        links->right[in / 2] = out / 2;
        if (line->first == line->last)
            line->last = MIKK_NONE;
        else
            line->first = table->following[line->first];
        return;
    }
    if (waits)
        table->following[line->last] = edge;
    else
        line->first = edge;
    line->vertex = vertex;
    line->last = edge;
}

static size_t table_room(size_t corners) {
    size_t room = 16;
    while (room < 4 * corners) room *= 2;
    return room;
}

void norma_core_mikk_link(const uint32_t *next, const uint32_t *previous, size_t count,
    mikk_edge_table *table, mikk_links *links) {
    if (count <= MIKK_SMALL_STAR) {
        link_small(next, previous, count, links);
        return;
    }
    const size_t room = table_room(count);
    memset(table->edges, 0xff, room * sizeof *table->edges);
    memset(links->left, 0xff, count * sizeof *links->left);
    memset(links->right, 0xff, count * sizeof *links->right);
    for (uint32_t j = 0; j < count; ++j) {
        meet_edge(table, room, next[j], 2 * j, links);
        meet_edge(table, room, previous[j], 2 * j + 1, links);
    }
}

norma_result norma_core_mikk_table_open(
    const core_call *call, size_t most_corners, mikk_edge_table *table) {
    *table = (mikk_edge_table){0};
    if (most_corners <= MIKK_SMALL_STAR) return NORMA_OK;
    table->room = table_room(most_corners);
    table->edges = norma_core_allocate(call, table->room, sizeof *table->edges);
    table->following = norma_core_allocate(call, 2 * most_corners, sizeof *table->following);
    return table->edges && table->following ? NORMA_OK : NORMA_ERROR_MEMORY;
}

void norma_core_mikk_table_close(
    const core_call *call, size_t most_corners, mikk_edge_table *table) {
    norma_core_release(call, table->edges, table->room, sizeof *table->edges);
    norma_core_release(call, table->following, 2 * most_corners, sizeof *table->following);
}

/* ---- Groups with tangents that are opposed to each other. The reference joins two
 * triangles of a group if the cosines between their tangents and between their bitangents are above
 * -1, in floats; so those that point exactly the other way, give or take a rounding, are left out
 * of each other's sums. Finding them takes the square of the corners, and so there is a bound. */

enum { MOST_DIVIDED = 2048 }; /* corners of a group */

static float cosine(const mikk_lane *a, size_t at, const mikk_lane *b, size_t to) {
    return a[0][at] * b[0][to] + a[1][at] * b[1][to] + a[2][at] * b[2][to];
}

static int are_one_quad(const mikk_star *star, size_t i, size_t j) {
    const size_t first = i < j ? i : j, second = i < j ? j : i;
    return star->corners[first] / 3 + 1 == star->corners[second] / 3 &&
           (mikk_flags_of(star, second) & MIKK_SECOND);
}

/* Whether neither of two corners of a group is left out of the other's sum. */
static int are_joined(const mikk_star *star, size_t i, size_t j) {
    const mikk_corners *a = mikk_block(star, i), *b = mikk_block(star, j);
    const size_t at = mikk_lane_of(star, i), to = mikk_lane_of(star, j);
    if (i == j || mikk_follows(star, i) || mikk_follows(star, j)) return 1;
    return (cosine(a->s, at, b->s, to) > -1 && cosine(a->t, at, b->t, to) > -1) ||
           are_one_quad(star, i, j);
}

typedef struct division {
    mikk_star *star;
    const uint32_t *first, *following; /* of each group, of each corner: the next in the group */
} division;

static int joins_all(const division *d, uint32_t group, uint32_t j) {
    for (uint32_t i = d->first[group]; i != MIKK_NONE; i = d->following[i])
        if (!are_joined(d->star, j, i)) return 0;
    return 1;
}

static void divide_group(const division *d, uint32_t group) {
    mikk_star *star = d->star;
    for (uint32_t j = d->first[group]; j != MIKK_NONE; j = d->following[j]) {
        if (joins_all(d, group, j)) continue;
        mikk_space *space = &star->spaces[star->space_count];
        *space = (mikk_space){.positive = star->spaces[group].positive};
        for (uint32_t i = d->first[group]; i != MIKK_NONE; i = d->following[i])
            if (are_joined(star, j, i) && !mikk_follows(star, i)) add_contribution(star, i, space);
        core_mikk_finish(star, space);
        star->space[j] = (uint32_t)star->space_count++;
    }
}

/* Of a group that is too large to compare all with all: each corner has its own triangle's tangent,
 * which is what it comes to where a texture goes round a pole. */
static void part_group(const division *d, uint32_t group) {
    mikk_star *star = d->star;
    for (uint32_t j = d->first[group]; j != MIKK_NONE; j = d->following[j]) {
        if (mikk_follows(star, j)) continue;
        mikk_space *space = &star->spaces[star->space_count];
        *space = (mikk_space){.positive = star->spaces[group].positive};
        add_contribution(star, j, space);
        core_mikk_finish(star, space);
        star->space[j] = (uint32_t)star->space_count++;
    }
}

static size_t count_corners(const division *d, uint32_t group) {
    size_t count = 0;
    for (uint32_t j = d->first[group]; j != MIKK_NONE; j = d->following[j]) ++count;
    return count;
}

/* In groups in which tangents may be opposed to each other, each corner gets the space of all
 * corners of the group that are not opposed to it. Links are used up. */
static void core_mikk_divide(mikk_star *star) {
    uint32_t *first = star->links.right, *following = star->links.left;
    const division d = {star, first, following};
    const size_t groups = star->space_count;
    memset(first, 0xff, groups * sizeof *first);
    for (uint32_t j = (uint32_t)star->count; j-- > 0;) {
        const uint32_t group = star->space[j];
        if (group == MIKK_NONE) continue;
        following[j] = first[group];
        first[group] = j;
    }
    for (uint32_t g = 0; g < groups; ++g) {
        if (!star->spaces[g].opposed) continue;
        if (count_corners(&d, g) > MOST_DIVIDED)
            part_group(&d, g);
        else
            divide_group(&d, g);
    }
}

/* ---- The groups of triangles at one vertex, and the sum over each. */

/* Along one of the two lists of links, until a triangle is of another sign or another group. */
static uint32_t spread_group(
    mikk_star *star, const uint32_t *links, uint32_t seed, uint32_t group, uint32_t sequence) {
    const int sign = mikk_flags_of(star, seed) & MIKK_POSITIVE;
    for (uint32_t j = links[seed]; j != MIKK_NONE && star->space[j] == MIKK_NONE; j = links[j]) {
        if ((mikk_flags_of(star, j) & MIKK_POSITIVE) != sign) break;
        star->space[j] = group;
        star->sequence[j] = sequence++;
    }
    return sequence;
}

static void find_mikk_groups(mikk_star *star) {
    uint32_t sequence = 0;
    memset(star->space, 0xff, star->count * sizeof *star->space);
    star->space_count = 0;
    for (uint32_t j = 0; j < star->count; ++j) {
        const uint8_t flags = mikk_flags_of(star, j);
        if (star->space[j] != MIKK_NONE || (flags & MIKK_FOLLOWS)) continue;
        const uint32_t group = (uint32_t)star->space_count++;
        star->seeds[group] = j;
        star->spaces[group] = (mikk_space){.positive = flags & MIKK_POSITIVE};
        star->space[j] = group;
        star->sequence[j] = sequence++;
        sequence = spread_group(star, star->links.left, j, group, sequence);
        sequence = spread_group(star, star->links.right, j, group, sequence);
    }
}

typedef struct seed_vectors {
    float s[3], t[3];
} seed_vectors;

static seed_vectors seed_of(const mikk_star *star, uint32_t group) {
    const mikk_corners *c = mikk_block(star, star->seeds[group]);
    const size_t lane = mikk_lane_of(star, star->seeds[group]);
    return (seed_vectors){{c->s[0][lane], c->s[1][lane], c->s[2][lane]},
        {c->t[0][lane], c->t[1][lane], c->t[2][lane]}};
}

/* Two tangents that each lie well within a right angle of a third are not opposed to each other. */
static int lies_near(const mikk_corners *c, size_t lane, const seed_vectors *seed) {
    float s = 0, t = 0;
    for (int k = 0; k < 3; ++k) {
        s += c->s[k][lane] * seed->s[k];
        t += c->t[k][lane] * seed->t[k];
    }
    return (s > 0.0625F) & (t > 0.0625F);
}

/* Returns whether some group's tangents may be opposed to each other. */
static int sum_mikk_groups(mikk_star *star) {
    const int has_quads = star->mesh->has_quads;
    uint32_t seeded = MIKK_NONE; /* the group that seed is of */
    seed_vectors seed = {{0}, {0}};
    int opposed = 0;
    for (size_t j = 0; j < star->count; ++j) {
        const uint32_t g = star->space[j];
        if (g == MIKK_NONE || (mikk_flags_of(star, j) & MIKK_FOLLOWS)) continue;
        const mikk_corners *c = mikk_block(star, j);
        const size_t lane = mikk_lane_of(star, j);
        if (g != seeded) seed = seed_of(star, seeded = g);
        mikk_add(c, lane, has_quads, &star->spaces[g]);
        if (!lies_near(c, lane, &seed)) star->spaces[g].opposed = opposed = 1;
    }
    return opposed;
}

/* Returns whether some group's tangents may be opposed to each other. */
static int sum_records(mikk_star *star) {
    int opposed = 0;
    for (size_t j = 0; j < star->count; ++j) {
        if (mikk_flags_of(star, j) & MIKK_FOLLOWS) continue;
        const mikk_record *r = &star->mesh->records[star->corners[j]];
        mikk_space *space = &star->spaces[star->space[j]];
        for (int k = 0; k < 3; ++k) space->s[k] += r->sum[k];
        space->ends |= r->ends;
        opposed |= mikk_ends_oppose(space->ends);
    }
    return opposed;
}

/* The same from records. 0: some tangents may be opposed to each other, and contributions are
 * needed. */
static int core_mikk_groups_of_records(mikk_star *star) {
    norma_core_mikk_link(star->next, star->previous, star->count, star->table, &star->links);
    find_mikk_groups(star);
    if (sum_records(star)) return 0;
    for (size_t g = 0; g < star->space_count; ++g) core_mikk_finish(star, &star->spaces[g]);
    return 1;
}

/* Finds groups and sums their spaces. */
static void core_mikk_groups(mikk_star *star) {
    norma_core_mikk_link(star->next, star->previous, star->count, star->table, &star->links);
    find_mikk_groups(star);
    const size_t groups = star->space_count;
    if (sum_mikk_groups(star)) core_mikk_divide(star);
    for (size_t g = 0; g < groups; ++g) core_mikk_finish(star, &star->spaces[g]);
}

/* ---- Vertex by vertex, what its corners contribute, their groups, and what is written.
 * Small stars are taken many at a time, so that lanes are full; large ones by the calling thread,
 * with memory of their own. */

enum {
    CORNERS_IN_BATCH = 256,
    BLOCKS = (CORNERS_IN_BATCH + MIKK_SMALL_STAR) / MIKK_LANES,
    LANES_IN_BATCH = BLOCKS * MIKK_LANES,
    VERTICES_IN_TASK = 1 << 12
};

typedef struct star_work {
    const mikk_mesh *mesh;
    const tangent_output *output;
    const mikk_kernels *kernels;
    core_tally *tallies; /* one for each task */
} star_work;

/* ---- contributions */

static void load_corner(const mikk_mesh *m, uint32_t corner, size_t lane, mikk_batch *batch) {
    const uint32_t at = corner % 3, *triangle = &m->triangles[corner - at];
    for (size_t i = 0; i < 3; ++i) {
        const tangent_vertex *v = &m->vertices[triangle[i]];
        for (int k = 0; k < 3; ++k) batch->position[i][k][lane] = v->position[k];
        for (int k = 0; k < 2; ++k) batch->texcoord[i][k][lane] = v->texcoord[k];
    }
    for (int k = 0; k < 3; ++k) batch->normal[at][k][lane] = m->vertices[triangle[at]].normal[k];
    batch->turn[lane] = (float)at;
}

typedef struct star_corners {
    uint32_t *next, *previous;
    uint8_t *flags;
} star_corners;

/* Who is beside each of count corners. */
static void read_star_triangles(
    const star_work *w, const uint32_t *corners, size_t count, const star_corners *out) {
    static const uint8_t following[] = {1, 2, 0}, preceding[] = {2, 0, 1};
    const mikk_mesh *m = w->mesh;
    for (size_t j = 0; j < count; ++j) {
        const uint32_t at = corners[j] % 3, *triangle = &m->triangles[corners[j] - at];
        out->next[j] = triangle[following[at]];
        out->previous[j] = triangle[preceding[at]];
        out->flags[j] = m->flags[corners[j] / 3];
    }
}

/* Once the triangles have been read. */
static void contribute_corners(const star_work *w, const uint32_t *corners, size_t count,
    mikk_batch *batch, mikk_corners *contributions) {
    for (size_t j = 0; j < count; ++j) {
        load_corner(w->mesh, corners[j], j % MIKK_LANES, batch);
        if (j % MIKK_LANES == MIKK_LANES - 1 || j + 1 == count)
            w->kernels->contribute(batch, &contributions[j / MIKK_LANES]);
    }
}

/* ---- what is written */

static int is_of_use(const float v[3]) {
    const float square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    return square > 0.998F && square < 1.002F; /* not NaN either */
}

static int same_space(const mikk_space *a, const mikk_space *b) {
    int same = (a->length_s == b->length_s) & (a->length_t == b->length_t);
    for (int k = 0; k < 3; ++k) same &= (a->s[k] == b->s[k]) & (a->t[k] == b->t[k]);
    return same;
}

/* Where both triangles of a quad have the corner: the first space, or the direction of the sum; the
 * sign of the second. A space whose lengths are not numbers differs from itself, and is added to
 * itself. */
static mikk_space average(const mikk_space *first, const mikk_space *second) {
    mikk_space space = *first;
    space.positive = second->positive;
    if (same_space(first, second)) return space;
    for (int k = 0; k < 3; ++k) space.s[k] = first->s[k] + second->s[k];
    core_mikk_normalise(space.s);
    return space;
}

static const mikk_space *space_of(const mikk_star *star, size_t j) {
    return star->space[j] == MIKK_NONE ? NULL : &star->spaces[star->space[j]];
}

/* The corner that two triangles of a quad have, j being the second's. */
static mikk_space *join_quad(const mikk_star *star, size_t j, mikk_space *room) {
    const mikk_space *a = space_of(star, j - 1), *b = space_of(star, j);
    if (!a && !b) return NULL;
    if (!a || !b)
        *room = a ? *a : *b;
    else
        *room = star->sequence[j - 1] < star->sequence[j] ? average(a, b) : average(b, a);
    return room;
}

static int is_held_before(const mikk_star *star, size_t j) {
    return mikk_flags_of(star, j) & (MIKK_HELD << star->corners[j] % 3);
}

static int is_joined_later(const mikk_star *star, size_t j) {
    return j + 1 < star->count && is_held_before(star, j + 1) &&
           (mikk_flags_of(star, j + 1) & MIKK_SECOND) &&
           star->mesh->corners[star->corners[j]] == star->mesh->corners[star->corners[j + 1]];
}

static corner_tangent tangent_of_corner(const mikk_star *star, size_t j) {
    mikk_space room;
    const int joined = is_held_before(star, j);
    const mikk_space *space = joined ? join_quad(star, j, &room) : space_of(star, j);
    if (!space) {
        const uint8_t flags = mikk_flags_of(star, j);
        const int negative = (flags & MIKK_FOLLOWED) && !(flags & MIKK_POSITIVE);
        return (corner_tangent){.sign = negative ? -1 : 1, .reason = NORMA_REASON_DEGENERATE};
    }
    corner_tangent tangent = {.sign = space->positive ? 1 : -1};
    memcpy(tangent.direction, space->s, sizeof tangent.direction);
    if (!is_of_use(space->s)) tangent.reason = NORMA_REASON_CANCELLED;
    return tangent;
}

/* Of a quad's two triangles the second holds the corner that both have; of a polygon's the first.
 */
static int is_written(const mikk_star *star, size_t j) {
    return is_held_before(star, j) ? mikk_flags_of(star, j) & MIKK_SECOND
                                   : !is_joined_later(star, j);
}

static void write_star_corners(const star_work *w, const mikk_star *star, core_tally *tally) {
    const tangent_vertex *vertex = &w->mesh->vertices[star->vertex];
    uint32_t last = MIKK_NONE; /* whose space was written last */
    written_tangent out = {.reason = NORMA_REASON_NONE};
    for (size_t j = 0; j < star->count; ++j) {
        if (w->mesh->corners && !is_written(star, j)) continue;
        const int own = is_held_before(star, j) || star->space[j] == MIKK_NONE;
        if (own || star->space[j] != last) {
            const corner_tangent tangent = tangent_of_corner(star, j);
            out = norma_core_tangent_to_write(vertex, &tangent);
            last = own ? MIKK_NONE : star->space[j];
        }
        norma_core_put_tangent(w->output, mikk_target(w->mesh, star->corners[j]), &out, tally);
    }
}

/* The star's corner of this number. */
static size_t find_corner(const mikk_star *star, uint32_t corner) {
    size_t from = 0, to = star->count;
    while (to - from > 1) {
        const size_t middle = from + (to - from) / 2;
        if (star->corners[middle] <= corner)
            from = middle;
        else
            to = middle;
    }
    return from;
}

static void write_copies(const star_work *w, const mikk_star *star, core_tally *tally) {
    const mikk_mesh *m = w->mesh;
    if (!m->copy_starts) return;
    for (uint32_t i = m->copy_starts[star->vertex]; i < m->copy_starts[star->vertex + 1]; ++i) {
        const mikk_copy copy = m->copies[i];
        corner_tangent tangent = {.sign = 1, .reason = NORMA_REASON_DEGENERATE};
        if (star->count) {
            size_t j = copy.source == MIKK_NONE ? 0 : find_corner(star, copy.source);
            if (is_joined_later(star, j)) ++j;
            tangent = tangent_of_corner(star, j);
        }
        const uint32_t key = norma_core_tangent_key(m->input, copy.target);
        norma_core_write_tangent(w->output, copy.target, &m->vertices[key], &tangent, tally);
    }
}

static void write_star(const star_work *w, const mikk_star *star, core_tally *tally) {
    write_star_corners(w, star, tally);
    write_copies(w, star, tally);
}

/* ---- small stars */

typedef struct small_stars {
    mikk_corners contributions[BLOCKS];
    mikk_batch batch;
    uint32_t corners[LANES_IN_BATCH], next[LANES_IN_BATCH], previous[LANES_IN_BATCH];
    uint8_t flags[LANES_IN_BATCH];
    uint32_t left[MIKK_SMALL_STAR], right[MIKK_SMALL_STAR], space[MIKK_SMALL_STAR],
        sequence[MIKK_SMALL_STAR], seeds[MIKK_SMALL_STAR];
    mikk_space spaces[2 * MIKK_SMALL_STAR];
} small_stars;

static size_t mikk_star_count(const mikk_mesh *m, size_t vertex) {
    return m->around.starts[vertex + 1] - m->around.starts[vertex];
}

/* Whose corners are those from first on. */
static mikk_star small_star(const star_work *w, small_stars *s, size_t vertex, size_t first) {
    return (mikk_star){.mesh = w->mesh,
        .vertex = (uint32_t)vertex,
        .count = mikk_star_count(w->mesh, vertex),
        .corners = w->mesh->around.corners + w->mesh->around.starts[vertex],
        .next = s->next + first,
        .previous = s->previous + first,
        .flags = s->flags + first,
        .contributions = s->contributions,
        .first = first,
        .links = {s->left, s->right},
        .space = s->space,
        .sequence = s->sequence,
        .seeds = s->seeds,
        .spaces = s->spaces};
}

/* The corners of as many of the vertices as fit. Returns the first that does not. */
static size_t gather_batch(
    const mikk_mesh *m, small_stars *s, size_t begin, size_t end, size_t *filled) {
    size_t vertex = begin;
    *filled = 0;
    for (; vertex < end && *filled < CORNERS_IN_BATCH; ++vertex) {
        const size_t count = mikk_star_count(m, vertex);
        if (count > MIKK_SMALL_STAR) continue;
        memcpy(s->corners + *filled, m->around.corners + m->around.starts[vertex],
            count * sizeof *s->corners);
        *filled += count;
    }
    return vertex;
}

static size_t run_batch(
    const star_work *w, small_stars *s, size_t begin, size_t end, core_tally *tally) {
    const mikk_mesh *m = w->mesh;
    const star_corners out = {s->next, s->previous, s->flags};
    size_t filled, first = 0;
    const size_t vertex = gather_batch(m, s, begin, end, &filled);
    read_star_triangles(w, s->corners, filled, &out);
    contribute_corners(w, s->corners, filled, &s->batch, s->contributions);
    for (size_t v = begin; v < vertex; ++v) {
        if (mikk_star_count(m, v) > MIKK_SMALL_STAR) continue;
        mikk_star star = small_star(w, s, v, first);
        core_mikk_groups(&star);
        write_star(w, &star, tally);
        first += star.count;
    }
    return vertex;
}

/* ---- small stars of recorded triangles */

static void group_records(const star_work *w, small_stars *s, mikk_star *star) {
    for (size_t j = 0; j < star->count; ++j) {
        const mikk_record *r = &w->mesh->records[star->corners[j]];
        s->next[j] = r->next;
        s->previous[j] = r->previous;
        s->flags[j] = r->flags;
    }
    if (core_mikk_groups_of_records(star)) return;
    contribute_corners(w, star->corners, star->count, &s->batch, s->contributions);
    core_mikk_groups(star);
}

static void run_recorded(
    const star_work *w, small_stars *s, size_t begin, size_t end, core_tally *tally) {
    const mikk_mesh *m = w->mesh;
    for (size_t v = begin; v < end; ++v) {
        if (mikk_star_count(m, v) > MIKK_SMALL_STAR) continue;
        mikk_star star = small_star(w, s, v, 0);
        group_records(w, s, &star);
        write_star(w, &star, tally);
    }
}

static void mikk_star_task(void *context, size_t task) {
    const star_work *w = context;
    const size_t count = w->mesh->vertex_count, begin = task * VERTICES_IN_TASK,
                 end = count - begin < VERTICES_IN_TASK ? count : begin + VERTICES_IN_TASK;
    small_stars s;
    memset(&s.batch, 0, sizeof s.batch);
    if (mikk_has_records(w->mesh)) {
        run_recorded(w, &s, begin, end, &w->tallies[task]);
        return;
    }
    for (size_t v = begin; v < end;) v = run_batch(w, &s, v, end, &w->tallies[task]);
}

/* ---- large stars */

typedef struct large_stars {
    size_t most, blocks;
    mikk_corners *contributions;
    uint32_t *numbers; /* seven for each corner */
    uint8_t *flags;
    mikk_space *spaces;
    mikk_edge_table table;
} large_stars;

static void finish_large(
    const star_work *w, const large_stars *s, size_t vertex, core_tally *tally) {
    const size_t count = mikk_star_count(w->mesh, vertex), most = s->most;
    const uint32_t *corners = w->mesh->around.corners + w->mesh->around.starts[vertex];
    mikk_edge_table table = s->table;
    mikk_batch batch = {0};
    const star_corners out = {s->numbers, s->numbers + most, s->flags};
    mikk_star star = {.mesh = w->mesh,
        .vertex = (uint32_t)vertex,
        .count = count,
        .corners = corners,
        .next = out.next,
        .previous = out.previous,
        .flags = out.flags,
        .contributions = s->contributions,
        .table = &table,
        .links = {s->numbers + 2 * most, s->numbers + 3 * most},
        .space = s->numbers + 4 * most,
        .sequence = s->numbers + 5 * most,
        .seeds = s->numbers + 6 * most,
        .spaces = s->spaces};
    read_star_triangles(w, corners, count, &out);
    contribute_corners(w, corners, count, &batch, s->contributions);
    core_mikk_groups(&star);
    write_star(w, &star, tally);
}

static norma_result run_large(const star_work *w, core_tally *tally) {
    const core_call *call = w->mesh->call;
    large_stars s = {.most = w->mesh->around.most};
    if (s.most <= MIKK_SMALL_STAR) return NORMA_OK;
    s.blocks = s.most / MIKK_LANES + 1;
    s.contributions = norma_core_allocate(call, s.blocks, sizeof *s.contributions);
    s.numbers = norma_core_allocate(call, 7 * s.most, sizeof *s.numbers);
    s.spaces = norma_core_allocate(call, 2 * s.most, sizeof *s.spaces);
    s.flags = norma_core_allocate(call, s.most, 1);
    norma_result result = norma_core_mikk_table_open(call, s.most, &s.table);
    if (!s.contributions || !s.numbers || !s.spaces || !s.flags) result = NORMA_ERROR_MEMORY;
    for (size_t v = 0; v < w->mesh->vertex_count && !result; ++v)
        if (mikk_star_count(w->mesh, v) > MIKK_SMALL_STAR) finish_large(w, &s, v, tally);
    norma_core_mikk_table_close(call, s.most, &s.table);
    norma_core_release(call, s.contributions, s.blocks, sizeof *s.contributions);
    norma_core_release(call, s.numbers, 7 * s.most, sizeof *s.numbers);
    norma_core_release(call, s.spaces, 2 * s.most, sizeof *s.spaces);
    norma_core_release(call, s.flags, s.most, 1);
    return result;
}

norma_result norma_core_mikk_stars(mikk_mesh *m, const tangent_output *output, core_tally *tally) {
    const size_t tasks =
        m->vertex_count / VERTICES_IN_TASK + (m->vertex_count % VERTICES_IN_TASK != 0);
    star_work w = {.mesh = m,
        .output = output,
        .kernels = norma_core_mikk_kernels(m->call->options.isa),
        .tallies = norma_core_allocate(m->call, tasks, sizeof *w.tallies)};
    if (!w.tallies) return NORMA_ERROR_MEMORY;
    memset(w.tallies, 0, tasks * sizeof *w.tallies);
    norma_result result = norma_core_parallel(m->call, tasks, mikk_star_task, &w);
    if (!result) result = run_large(&w, tally);
    for (size_t i = 0; i < tasks && !result; ++i) norma_core_tally_add(tally, &w.tallies[i]);
    norma_core_release(m->call, w.tallies, tasks, sizeof *w.tallies);
    return result;
}
