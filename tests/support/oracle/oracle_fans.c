/* oracle_fans.c: who shares an edge, which shared edges are smooth, which corners they join. All
 * half-edges of the mesh are sorted by the pair of positions they join; fans are found by flooding.
 * See oracle.h and DESIGN.md, "Who shares an edge". */
#include "oracle/exact.h"
#include "oracle/oracle.h"
#include <math.h>
#include <stdlib.h>

typedef struct half_edge {
    size_t low, high, corner; /* the welded positions, and the corner it begins at */
    int upwards;              /* from low to high */
} half_edge;

typedef struct link {
    size_t from,
        to; /* corners of one position that a smooth edge joins, or whose doubtful edge might */
    int doubtful;
} link;

typedef struct pair {
    const half_edge *a, *b;
} pair;

typedef enum edge_class { EDGE_NON_MANIFOLD, EDGE_CONFLICT, EDGE_OPEN, EDGE_SHARED } edge_class;

typedef struct finder {
    const oracle *o;
    oracle_fans *fans;
    half_edge *edges;
    size_t edge_count;
    edge_class *classes; /* of each distinct edge, in the order of edges */
    size_t class_count;
    pair *pairs; /* who shares an edge with whom, each pair once */
    size_t pair_count, pair_room;
    size_t *lenders; /* of each face without a direction: the face it borrows from, or NONE */
    link *links;
    size_t link_count;
    long double crease, doubt;
    norma_non_manifold non_manifold;
} finder;

static int compare_half_edges(const void *left, const void *right) {
    const half_edge *a = left, *b = right;
    if (a->low != b->low) return a->low < b->low ? -1 : 1;
    if (a->high != b->high) return a->high < b->high ? -1 : 1;
    return a->corner < b->corner ? -1 : a->corner > b->corner;
}

static void sort_half_edges(finder *s) {
    const oracle *o = s->o;
    s->edges = oracle_allocate(o->corner_count, sizeof *s->edges);
    for (size_t c = 0; c < o->corner_count; ++c) {
        if (o->kept[c] != c) continue;
        const size_t from = o->shared[o->corners[c]], to = o->shared[o->corners[o->next[c]]];
        s->edges[s->edge_count++] = (half_edge){.low = from < to ? from : to,
            .high = from < to ? to : from,
            .corner = c,
            .upwards = from < to};
    }
    qsort(s->edges, s->edge_count, sizeof *s->edges, compare_half_edges);
}

/* Whether a's face, read from a on, has the positions that b's face has read backwards from b. */
static int read_backwards(const oracle *o, size_t a, size_t b) {
    size_t i = a, j = b;
    do {
        if (o->shared[o->corners[i]] != o->shared[o->corners[j]]) return 0;
        i = o->next[i];
        j = o->previous[j];
    } while (i != a && j != b);
    return i == a && j == b;
}

/* Whether the faces of two corners have the same positions in opposite order. */
static int are_twins(const oracle *o, size_t a, size_t b) {
    for (size_t j = o->next[b]; j != b; j = o->next[j])
        if (read_backwards(o, a, j)) return 1;
    return read_backwards(o, a, b);
}

/* A face that runs twice along the edge is two there. One that reads the same backwards (a, b, c,
 * b) is its own reversed twin, so that its two runs are no partners of one another, but of the
 * faces beside it. */
static int are_partners(const oracle *o, const half_edge *a, const half_edge *b) {
    return a->upwards != b->upwards && !are_twins(o, a->corner, b->corner);
}

static void add_pair(finder *s, const half_edge *a, const half_edge *b) {
    if (s->pair_count == s->pair_room) {
        s->pair_room = s->pair_room ? 2 * s->pair_room : 1024;
        s->pairs = realloc(s->pairs, s->pair_room * sizeof *s->pairs);
        if (!s->pairs) abort();
    }
    s->pairs[s->pair_count++] = (pair){a, b};
}

static void count_first(norma_count *count, size_t corner) {
    if (count->count == 0 || corner < count->first) count->first = corner;
    ++count->count;
}

/* The half-edges along one edge, ascending by corner. */
static void match_edge(finder *s, const half_edge *run, size_t count) {
    size_t *partners = oracle_allocate(count, sizeof *partners), odd = 0;
    for (size_t i = 0; i < count; ++i)
        for (size_t j = 0; j < count; ++j)
            partners[i] += (size_t)are_partners(s->o, &run[i], &run[j]);
    for (size_t i = 0; i < count; ++i) {
        odd += partners[i] != 1;
        for (size_t j = i + 1; j < count; ++j)
            if (are_partners(s->o, &run[i], &run[j]) &&
                (s->non_manifold == NORMA_NON_MANIFOLD_SMOOTH ||
                    (partners[i] == 1 && partners[j] == 1)))
                add_pair(s, &run[i], &run[j]);
    }
    s->classes[s->class_count++] = count > 2 && odd ? EDGE_NON_MANIFOLD
                                   : count == 2 && run[0].upwards == run[1].upwards ? EDGE_CONFLICT
                                   : count == 1                                     ? EDGE_OPEN
                                                                                    : EDGE_SHARED;
    if (count > 2 && odd) count_first(&s->fans->non_manifold, run[0].corner);
    if (count == 2 && run[0].upwards == run[1].upwards)
        count_first(&s->fans->conflicts, run[0].corner);
    free(partners);
}

static void match_edges(finder *s) {
    s->classes = oracle_allocate(s->edge_count, sizeof *s->classes);
    for (size_t begin = 0, end; begin < s->edge_count; begin = end) {
        for (end = begin + 1; end < s->edge_count && s->edges[end].low == s->edges[begin].low &&
                              s->edges[end].high == s->edges[begin].high;)
            ++end;
        match_edge(s, s->edges + begin, end - begin);
    }
}

/* ---- borrowing */

/* Whether the edge from corner a is longer than that from corner b. */
static int is_longer(const oracle *o, size_t a, size_t b) {
    exact_vec3 p, q;
    mpz_t length[2];
    mpz_inits(length[0], length[1], NULL);
    exact_init(&p);
    exact_init(&q);
    for (int i = 0; i < 2; ++i) {
        const size_t corner = i ? b : a;
        exact_set(&p, o->positions[o->corners[corner]], EXACT_LEAST);
        exact_set(&q, o->positions[o->corners[o->next[corner]]], EXACT_LEAST);
        exact_sub(&p, &p, &q);
        exact_dot(length[i], &p, &p);
    }
    const int result = mpz_cmp(length[0], length[1]) > 0;
    exact_clear(&p);
    exact_clear(&q);
    mpz_clears(length[0], length[1], NULL);
    return result;
}

static size_t longest_edge(const oracle *o, size_t face) {
    size_t best = ORACLE_NONE;
    for (size_t c = o->starts[face]; c < o->starts[face + 1]; ++c)
        if (o->kept[c] == c && (best == ORACLE_NONE || is_longer(o, c, best))) best = c;
    return best;
}

/* A face shares its longest edge with one other face, or borrows from none. */
static void find_lenders(finder *s) {
    const oracle *o = s->o;
    size_t *sharers = oracle_allocate(o->corner_count, sizeof *sharers),
           *sharer = oracle_allocate(o->corner_count, sizeof *sharer);
    for (size_t i = 0; i < s->pair_count; ++i) {
        const size_t a = s->pairs[i].a->corner, b = s->pairs[i].b->corner;
        ++sharers[a], ++sharers[b];
        sharer[a] = o->faces[b];
        sharer[b] = o->faces[a];
    }
    s->lenders = oracle_allocate(o->face_count, sizeof *s->lenders);
    for (size_t f = 0; f < o->face_count; ++f) {
        s->lenders[f] = ORACLE_NONE;
        if (o->kinds[f] != ORACLE_NO_AREA) continue;
        const size_t corner = longest_edge(o, f);
        if (sharers[corner] == 1 && o->kinds[sharer[corner]] == ORACLE_DIRECTED)
            s->lenders[f] = sharer[corner];
    }
    free(sharers);
    free(sharer);
}

static const long double *direction_of(const finder *s, size_t face) {
    if (s->o->kinds[face] == ORACLE_DIRECTED) return s->o->directions[face];
    return s->lenders[face] == ORACLE_NONE ? NULL : s->o->directions[s->lenders[face]];
}

/* ---- smooth edges and fans */

static int is_smooth(const finder *s, const pair *p, int *doubtful) {
    const oracle *o = s->o;
    const size_t a = p->a->corner, b = p->b->corner;
    const long double *m = direction_of(s, o->faces[a]), *n = direction_of(s, o->faces[b]);
    *doubtful = 0;
    if (o->hard_edges && (o->hard_edges[a] || o->hard_edges[b])) return 0;
    if (o->smoothing_groups &&
        !(o->smoothing_groups[o->faces[a]] & o->smoothing_groups[o->faces[b]]))
        return 0;
    if (!m || !n) return 0;
    if (s->crease >= 3.14159265358979323846L) return 1;
    const long double dihedral = oracle_angle(m, n);
    *doubtful |= fabsl(dihedral - (s->crease + 1e-6L)) <= s->doubt;
    return dihedral <= s->crease + 1e-6L;
}

static void add_link(finder *s, size_t a, size_t b, int doubtful) {
    s->links[s->link_count++] = (link){a, b, doubtful};
    s->links[s->link_count++] = (link){b, a, doubtful};
}

static int compare_links(const void *left, const void *right) {
    const link *a = left, *b = right;
    return a->from < b->from ? -1 : a->from > b->from;
}

static void link_corners(finder *s) {
    const oracle *o = s->o;
    s->links = oracle_allocate(4 * s->pair_count, sizeof *s->links);
    for (size_t i = 0; i < s->pair_count; ++i) {
        int doubtful;
        const size_t a = s->pairs[i].a->corner, b = s->pairs[i].b->corner;
        const int smooth = is_smooth(s, &s->pairs[i], &doubtful);
        if (!smooth && !doubtful) continue;
        add_link(s, a, o->next[b], doubtful ? (smooth ? 1 : 2) : 0);
        add_link(s, o->next[a], b, doubtful ? (smooth ? 1 : 2) : 0);
    }
    qsort(s->links, s->link_count, sizeof *s->links, compare_links);
}

/* Each distinct edge is counted once, as the first of non-manifold, conflict, open, hard, smooth.
 */
static void count_edges(finder *s) {
    norma_edges *edges = &s->fans->edges;
    size_t pair_at = 0;
    for (size_t begin = 0, end; begin < s->edge_count; begin = end) {
        const edge_class class = s->classes[edges->count++];
        int doubtful, smooth = 0, hard = 0;
        for (end = begin + 1; end < s->edge_count && s->edges[end].low == s->edges[begin].low &&
                              s->edges[end].high == s->edges[begin].high;)
            ++end;
        for (; pair_at < s->pair_count && s->pairs[pair_at].a >= s->edges + begin &&
               s->pairs[pair_at].a < s->edges + end;
             ++pair_at)
            *(is_smooth(s, &s->pairs[pair_at], &doubtful) ? &smooth : &hard) = 1;
        edges->open += class == EDGE_OPEN;
        edges->hard += class == EDGE_SHARED && (hard || !smooth);
        edges->smooth += class == EDGE_SHARED && !hard && smooth;
    }
}

/* Bits of flood's answer. */
enum { REACHED_DOUBT = 1 };

static void flood(finder *s) {
    const oracle *o = s->o;
    oracle_fans *fans = s->fans;
    size_t *queue = oracle_allocate(o->corner_count, sizeof *queue),
           *first = oracle_allocate(o->corner_count + 1, sizeof *first), at = 0;
    for (size_t c = 0; c <= o->corner_count; ++c) {
        while (at < s->link_count && s->links[at].from < c) ++at;
        first[c] = at;
    }
    for (size_t c = 0; c < o->corner_count; ++c) fans->fan[c] = ORACLE_NONE;
    for (size_t c = 0; c < o->corner_count; ++c) {
        if (fans->fan[c] != ORACLE_NONE || (o->kept[c] != ORACLE_NONE && o->kept[c] != c)) continue;
        size_t begin = 0, end = 0;
        const size_t fan = fans->fan_count++;
        queue[end++] = c;
        fans->fan[c] = fan;
        while (begin < end) {
            const size_t here = queue[begin++];
            for (size_t l = first[here]; l < first[here + 1]; ++l) {
                if (s->links[l].doubtful) fans->doubtful[fan] |= REACHED_DOUBT;
                if (s->links[l].doubtful == 2 || fans->fan[s->links[l].to] != ORACLE_NONE) continue;
                fans->fan[s->links[l].to] = fan;
                queue[end++] = s->links[l].to;
            }
        }
    }
    for (size_t c = 0; c < o->corner_count; ++c)
        if (fans->fan[c] == ORACLE_NONE) fans->fan[c] = fans->fan[o->kept[c]];
    free(first);
    free(queue);
}

static void list_corners_by_fan(oracle_fans *fans, const oracle *o) {
    fans->start = oracle_allocate(fans->fan_count + 2, sizeof *fans->start);
    fans->corners = oracle_allocate(o->corner_count, sizeof *fans->corners);
    for (size_t c = 0; c < o->corner_count; ++c)
        if (o->kept[c] == c) ++fans->start[fans->fan[c] + 2];
    for (size_t f = 2; f < fans->fan_count + 2; ++f) fans->start[f] += fans->start[f - 1];
    for (size_t c = 0; c < o->corner_count; ++c)
        if (o->kept[c] == c) fans->corners[fans->start[fans->fan[c] + 1]++] = c;
}

void oracle_fans_create(oracle_fans *fans, const oracle *o, float crease_rad,
    norma_non_manifold non_manifold, long double doubt_rad) {
    finder s = {.o = o,
        .fans = fans,
        .crease = (long double)crease_rad,
        .doubt = doubt_rad,
        .non_manifold = non_manifold};
    *fans = (oracle_fans){
        .non_manifold = {0, SIZE_MAX}, .conflicts = {0, SIZE_MAX}, .crease_rad = crease_rad};
    fans->fan = oracle_allocate(o->corner_count, sizeof *fans->fan);
    fans->doubtful = oracle_allocate(o->corner_count, sizeof *fans->doubtful);
    sort_half_edges(&s);
    match_edges(&s);
    find_lenders(&s);
    link_corners(&s);
    count_edges(&s);
    flood(&s);
    list_corners_by_fan(fans, o);
    free(s.edges);
    free(s.pairs);
    free(s.lenders);
    free(s.classes);
    free(s.links);
}

size_t oracle_fans_of(
    const oracle *o, const oracle_fans *fans, size_t vertex, size_t *corners, int *doubtful) {
    unsigned char *taken = oracle_allocate(fans->fan_count, 1);
    size_t count = 0;
    *doubtful = 0;
    for (size_t c = 0; c < o->corner_count; ++c) {
        const size_t fan = fans->fan[c];
        if (o->corners[c] != vertex || taken[fan]) continue;
        taken[fan] = 1;
        *doubtful |= fans->doubtful[fan];
        for (size_t i = fans->start[fan]; i < fans->start[fan + 1]; ++i)
            corners[count++] = fans->corners[i];
    }
    free(taken);
    return count;
}

void oracle_fans_destroy(oracle_fans *fans) {
    free(fans->fan);
    free(fans->start);
    free(fans->corners);
    free(fans->doubtful);
    *fans = (oracle_fans){0};
}
