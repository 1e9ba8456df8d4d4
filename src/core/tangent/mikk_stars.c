/* mikk_stars.c: vertex by vertex, what its corners contribute, their groups, and what is written.
 * Small stars are taken many at a time, so that lanes are full; large ones by the calling thread,
 * with memory of their own. */
#include "core/tangent/mikk_star.h"

enum {
    CORNERS_IN_BATCH = 256,
    BLOCKS = (CORNERS_IN_BATCH + MIKK_SMALL_STAR) / MIKK_LANES,
    LANES_IN_BATCH = BLOCKS * MIKK_LANES,
    VERTICES_IN_TASK = 1 << 12,
    RECORDS_AHEAD = 48 /* corners */
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
    for (size_t i = 0; i < 3; i++) {
        const tangent_vertex *v = &m->vertices[triangle[i]];
        for (int k = 0; k < 3; k++) batch->position[i][k][lane] = v->position[k];
        for (int k = 0; k < 2; k++) batch->texcoord[i][k][lane] = v->texcoord[k];
    }
    for (int k = 0; k < 3; k++) batch->normal[at][k][lane] = m->vertices[triangle[at]].normal[k];
    batch->turn[lane] = (float)at;
}

typedef struct star_corners {
    uint32_t *next, *previous;
    uint8_t *flags;
} star_corners;

/* Asks for the triangles at this vertex and those that come after it in the next batch. */
static void await_triangles(const mikk_mesh *m, size_t vertex) {
    const size_t begin = m->around.starts[vertex], rest = m->around.starts[m->vertex_count] - begin,
                 count = rest < CORNERS_IN_BATCH ? rest : CORNERS_IN_BATCH;
    const uint32_t *corners = m->around.corners + begin;
    for (size_t j = 0; j < count; j++) {
        TANGENT_PREFETCH(&m->triangles[corners[j] - corners[j] % 3]);
        TANGENT_PREFETCH(&m->flags[corners[j] / 3]);
    }
}

/* Who is beside each of count corners; asks for their vertices, and for where tangents go. */
static void read_triangles(
    const star_work *w, const uint32_t *corners, size_t count, const star_corners *out) {
    static const uint8_t following[] = {1, 2, 0}, preceding[] = {2, 0, 1};
    const mikk_mesh *m = w->mesh;
    for (size_t j = 0; j < count; j++) {
        const uint32_t at = corners[j] % 3, *triangle = &m->triangles[corners[j] - at];
        out->next[j] = triangle[following[at]];
        out->previous[j] = triangle[preceding[at]];
        out->flags[j] = m->flags[corners[j] / 3];
        TANGENT_PREFETCH(&m->vertices[out->next[j]]);
        TANGENT_PREFETCH(&m->vertices[out->previous[j]]);
        TANGENT_PREFETCH(w->output->tangents + mikk_target(m, corners[j]) * w->output->stride);
    }
}

/* Once the triangles have been read. */
static void contribute_corners(const star_work *w, const uint32_t *corners, size_t count,
    mikk_batch *batch, mikk_corners *contributions) {
    for (size_t j = 0; j < count; j++) {
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
    for (int k = 0; k < 3; k++) same &= (a->s[k] == b->s[k]) & (a->t[k] == b->t[k]);
    return same;
}

/* Where both triangles of a quad have the corner: the first space, or the direction of the sum; the
 * sign of the second. A space whose lengths are not numbers differs from itself, and is added to
 * itself. */
static mikk_space average(const mikk_space *first, const mikk_space *second) {
    mikk_space space = *first;
    space.positive = second->positive;
    if (same_space(first, second)) return space;
    for (int k = 0; k < 3; k++) space.s[k] = first->s[k] + second->s[k];
    norma_core_mikk_normalise(space.s);
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

static corner_tangent tangent_of(const mikk_star *star, size_t j) {
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

static void write_corners(const star_work *w, const mikk_star *star, core_tally *tally) {
    const tangent_vertex *vertex = &w->mesh->vertices[star->vertex];
    uint32_t last = MIKK_NONE; /* whose space was written last */
    written_tangent out = {.reason = NORMA_REASON_NONE};
    for (size_t j = 0; j < star->count; j++) {
        if (w->mesh->corners && !is_written(star, j)) continue;
        const int own = is_held_before(star, j) || star->space[j] == MIKK_NONE;
        if (own || star->space[j] != last) {
            const corner_tangent tangent = tangent_of(star, j);
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
    for (uint32_t i = m->copy_starts[star->vertex]; i < m->copy_starts[star->vertex + 1]; i++) {
        const mikk_copy copy = m->copies[i];
        corner_tangent tangent = {.sign = 1, .reason = NORMA_REASON_DEGENERATE};
        if (star->count) {
            size_t j = copy.source == MIKK_NONE ? 0 : find_corner(star, copy.source);
            if (is_joined_later(star, j)) j++;
            tangent = tangent_of(star, j);
        }
        const uint32_t key = norma_core_tangent_key(m->input, copy.target);
        norma_core_write_tangent(w->output, copy.target, &m->vertices[key], &tangent, tally);
    }
}

static void write_star(const star_work *w, const mikk_star *star, core_tally *tally) {
    write_corners(w, star, tally);
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

static size_t star_count(const mikk_mesh *m, size_t vertex) {
    return m->around.starts[vertex + 1] - m->around.starts[vertex];
}

/* Whose corners are those from first on. */
static mikk_star small_star(const star_work *w, small_stars *s, size_t vertex, size_t first) {
    return (mikk_star){.mesh = w->mesh,
        .vertex = (uint32_t)vertex,
        .count = star_count(w->mesh, vertex),
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
    for (; vertex < end && *filled < CORNERS_IN_BATCH; vertex++) {
        const size_t count = star_count(m, vertex);
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
    read_triangles(w, s->corners, filled, &out);
    await_triangles(m, vertex);
    contribute_corners(w, s->corners, filled, &s->batch, s->contributions);
    for (size_t v = begin; v < vertex; v++) {
        if (star_count(m, v) > MIKK_SMALL_STAR) continue;
        mikk_star star = small_star(w, s, v, first);
        norma_core_mikk_groups(&star);
        write_star(w, &star, tally);
        first += star.count;
    }
    return vertex;
}

/* ---- small stars of recorded triangles */

/* Asks for the records of the corners that come some after these, and for where tangents go. */
static void await_records(const star_work *w, size_t begin, size_t end) {
    const mikk_mesh *m = w->mesh;
    const size_t count = m->around.starts[m->vertex_count];
    for (size_t i = begin; i < end; i++) {
        if (i + RECORDS_AHEAD >= count) return;
        const uint32_t corner = m->around.corners[i + RECORDS_AHEAD];
        TANGENT_PREFETCH(&m->records[corner]);
        TANGENT_PREFETCH(&m->records[corner].previous);
        TANGENT_PREFETCH(w->output->tangents + mikk_target(m, corner) * w->output->stride);
    }
}

static void group_records(const star_work *w, small_stars *s, mikk_star *star) {
    for (size_t j = 0; j < star->count; j++) {
        const mikk_record *r = &w->mesh->records[star->corners[j]];
        s->next[j] = r->next;
        s->previous[j] = r->previous;
        s->flags[j] = r->flags;
    }
    if (norma_core_mikk_groups_of_records(star)) return;
    contribute_corners(w, star->corners, star->count, &s->batch, s->contributions);
    norma_core_mikk_groups(star);
}

static void run_recorded(
    const star_work *w, small_stars *s, size_t begin, size_t end, core_tally *tally) {
    const mikk_mesh *m = w->mesh;
    for (size_t v = begin; v < end; v++) {
        if (star_count(m, v) > MIKK_SMALL_STAR) continue;
        mikk_star star = small_star(w, s, v, 0);
        await_records(w, m->around.starts[v], m->around.starts[v + 1]);
        if (norma_core_mikk_fan(m->records, star.corners, star.count, s->spaces)) {
            memset(s->space, 0, star.count * sizeof *s->space);
            memset(s->flags, 0, star.count);
            norma_core_mikk_finish(&star, s->spaces);
        } else
            group_records(w, s, &star);
        write_star(w, &star, tally);
    }
}

static void star_task(void *context, size_t task) {
    const star_work *w = context;
    const size_t count = w->mesh->vertex_count, begin = task * VERTICES_IN_TASK,
                 end = count - begin < VERTICES_IN_TASK ? count : begin + VERTICES_IN_TASK;
    small_stars s;
    memset(&s.batch, 0, sizeof s.batch);
    if (w->mesh->records) {
        run_recorded(w, &s, begin, end, &w->tallies[task]);
        return;
    }
    await_triangles(w->mesh, begin);
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
    const size_t count = star_count(w->mesh, vertex), most = s->most;
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
    read_triangles(w, corners, count, &out);
    contribute_corners(w, corners, count, &batch, s->contributions);
    norma_core_mikk_groups(&star);
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
    for (size_t v = 0; v < w->mesh->vertex_count && result == NORMA_OK; v++)
        if (star_count(w->mesh, v) > MIKK_SMALL_STAR) finish_large(w, &s, v, tally);
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
    norma_result result = norma_core_parallel(m->call, tasks, star_task, &w);
    if (result == NORMA_OK) result = run_large(&w, tally);
    for (size_t i = 0; i < tasks && result == NORMA_OK; i++)
        norma_core_tally_add(tally, &w.tallies[i]);
    norma_core_release(m->call, w.tallies, tasks, sizeof *w.tallies);
    return result;
}
