/* check_mesh.c: the geometry that rules share: which positions are one, the direction and height of
 * each face, the corners around each position; and which faces are turned. */
#include "check/findings/check_run.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- loops in blocks */

typedef struct block_loop {
    check_block *task;
    void *context;
    size_t count, size;
} block_loop;

static void run_block(void *context, size_t block) {
    const block_loop *loop = context;
    size_t begin = block * loop->size,
           end = loop->count - begin < loop->size ? loop->count : begin + loop->size;
    loop->task(loop->context, block, begin, end);
}

norma_result norma_check_blocks(
    core_call *call, size_t count, size_t size, check_block *task, void *context) {
    block_loop loop = {task, context, count, size};
    return norma_core_parallel(call, norma_check_block_count(count, size), run_block, &loop);
}

typedef struct gathering {
    check_look *look;
    const void *pass;
    check_sum *parts;
} gathering;

static void look_at_block(void *context, size_t block, size_t begin, size_t end) {
    const gathering *g = context;
    g->look(g->pass, &g->parts[block], begin, end);
}

void norma_check_sum_merge(const check_run *run, check_sum *sum, check_sum *part) {
    for (size_t i = 0; i < CHECK_SUM_HITS; ++i)
        norma_check_hits_merge(run, &sum->hits[i], &part->hits[i]);
    for (size_t i = 0; i < CHECK_SUM_COUNTS; ++i) sum->counts[i] += part->counts[i];
    sum->twice_area += part->twice_area;
}

norma_result norma_check_gather(
    check_run *run, size_t count, size_t size, check_look *look, const void *pass, check_sum *sum) {
    const size_t blocks = norma_check_block_count(count, size);
    if (!blocks) return NORMA_OK;
    gathering g = {look, pass, norma_core_allocate(&run->call, blocks, sizeof *g.parts)};
    if (!g.parts) return NORMA_ERROR_MEMORY;
    memset(g.parts, 0, blocks * sizeof *g.parts);
    for (size_t i = 0; i < blocks * CHECK_SUM_HITS; ++i)
        g.parts[i / CHECK_SUM_HITS].hits[i % CHECK_SUM_HITS].least =
            sum->hits[i % CHECK_SUM_HITS].least;
    const norma_result result = norma_check_blocks(&run->call, count, size, look_at_block, &g);
    for (size_t i = 0; i < blocks; ++i) norma_check_sum_merge(run, sum, &g.parts[i]);
    norma_core_release(&run->call, g.parts, blocks, sizeof *g.parts);
    return result;
}

void norma_check_sum_free(check_sum *sum) {
    for (size_t i = 0; i < CHECK_SUM_HITS; ++i) norma_check_hits_free(&sum->hits[i]);
}

/* ---- shared geometry */

norma_result norma_check_weld(check_mesh *m) {
    if (m->has_topology) return NORMA_OK;
    norma_result result = norma_core_topology_open(&m->run->call, &m->mesh, &m->topology);
    m->has_topology = !result;
    return result;
}

norma_result norma_check_around(check_mesh *m) {
    norma_result result = norma_check_weld(m);
    return result || m->topology.corners_of.starts
               ? result
               : norma_core_corners_of_position_build(
                     &m->run->call, &m->topology.mesh, &m->topology.corners_of);
}

static double larger_square(double a, double b) { return a > b ? a : b; }

static double square_of(const double a[3], const double b[3]) {
    double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + y * y + z * z;
}

static double longest_of_triangle(const core_mesh *mesh, size_t face) {
    double p[3][3];
    for (size_t k = 0; k < 3; ++k)
        norma_core_position(mesh, norma_core_corner(mesh, 3 * face + k), p[k]);
    return larger_square(
        larger_square(square_of(p[0], p[1]), square_of(p[1], p[2])), square_of(p[2], p[0]));
}

/* The square of a polygon's longest edge, or of the distance of any corner from the first, so that
 * one with many short edges is not taken for thick. */
static double longest_of_polygon(const core_mesh *mesh, size_t face) {
    size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    double first[3], before[3], longest = 0;
    norma_core_position(mesh, norma_core_corner(mesh, begin), first);
    norma_core_position(mesh, norma_core_corner(mesh, end - 1), before);
    for (size_t c = begin; c < end; ++c) {
        double p[3];
        norma_core_position(mesh, norma_core_corner(mesh, c), p);
        longest = larger_square(longest, larger_square(square_of(p, before), square_of(p, first)));
        memcpy(before, p, sizeof before);
    }
    return longest;
}

static const double CHECK_DEGENERATE = 1e-6;

/* How far a polygon's corners lie from the line through its first corner and the one farthest from
 * that, over its longest edge: where its area cancels, as in a bow tie, it may be broad all the
 * same. */
static double breadth_of_polygon(const core_mesh *mesh, size_t face) {
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    double first[3], line[3] = {0}, most = 0, breadth = 0;
    norma_core_position(mesh, norma_core_corner(mesh, begin), first);
    for (int pass = 0; pass < 2; ++pass)
        for (size_t c = begin + 1; c < end; ++c) {
            double p[3], cross[3];
            norma_core_position(mesh, norma_core_corner(mesh, c), p);
            norma_core_subtract(p, first, p);
            const double square = norma_core_dot(p, p);
            if (pass == 0 && square > most) {
                most = square;
                memcpy(line, p, sizeof line);
            }
            if (pass == 0) continue;
            norma_core_cross(line, p, cross);
            breadth = larger_square(breadth, norma_core_length(cross));
        }
    return most > 0x1p-900 && most < 0x1p900 ? breadth / longest_of_polygon(mesh, face) : 0;
}

static void judge_cancelled_area(const core_mesh *mesh, size_t f, check_face *judged) {
    if (!((double)judged->height < CHECK_DEGENERATE) || !mesh->face_starts ||
        norma_core_face_end(mesh, f) - norma_core_face_begin(mesh, f) < 4)
        return;
    const double breadth = breadth_of_polygon(mesh, f);
    judged->height = breadth < 1 ? (float)breadth : 1;
}

static check_face judge_face(const core_mesh *mesh, size_t f, const core_face *face) {
    check_face judged = {.height = 1};
    if (!(face->flags & CORE_FACE_FINITE)) return judged;
    judged.height = 0;
    if (!(face->flags & CORE_FACE_DIRECTED)) return judged;
    double longest = mesh->face_starts ? longest_of_polygon(mesh, f) : longest_of_triangle(mesh, f),
           height = face->twice_area / longest;
    if (!(longest > 0x1p-900 && longest < 0x1p900)) /* squares of doubles at the end of their range:
                                                       judged by the area alone */
        height = 1;
    judged.height = height < 1 ? (float)height : 1;
    for (int k = 0; k < 3 && height >= CHECK_DEGENERATE; ++k)
        judged.normal[k] = (float)face->normal[k];
    return judged;
}

enum { FACES_IN_BLOCK = 1 << 13 };

static void judge_faces(void *context, size_t block, size_t begin, size_t end) {
    const check_mesh *m = context;
    const core_mesh *mesh = &m->topology.mesh;
    (void)block;
    core_face faces[CORE_FACES_AT_ONCE];
    for (size_t f = begin, count; f < end; f += count) {
        count = end - f < CORE_FACES_AT_ONCE ? end - f : CORE_FACES_AT_ONCE;
        norma_core_faces_geometry(&m->run->call, mesh, f, count, faces);
        for (size_t i = 0; i < count; ++i) {
            m->faces[f + i] = judge_face(mesh, f + i, &faces[i]);
            judge_cancelled_area(mesh, f + i, &m->faces[f + i]);
        }
    }
}

norma_result norma_check_faces(check_mesh *m) {
    const norma_result result = m->faces ? NORMA_OK : norma_check_weld(m);
    if (result || m->faces || !m->mesh.face_count) return result;
    m->faces = norma_core_allocate(&m->run->call, m->mesh.face_count, sizeof *m->faces);
    return m->faces ? norma_check_blocks(
                          &m->run->call, m->mesh.face_count, FACES_IN_BLOCK, judge_faces, m)
                    : NORMA_ERROR_MEMORY;
}

/* ---- several meshes as one */

static void append_mesh(check_joined *joined, const core_mesh *mesh) {
    norma_mesh *whole = &joined->mesh;
    for (size_t v = 0; v < mesh->positions.count; ++v)
        norma_view_read(&mesh->positions, v, joined->positions + 3 * (whole->positions.count + v));
    for (size_t f = 0; joined->starts && f < mesh->face_count; ++f)
        joined->starts[whole->face_count + f] =
            (uint32_t)(whole->corner_count + norma_core_face_begin(mesh, f));
    for (size_t c = 0; c < mesh->corner_count; ++c)
        joined->corners[whole->corner_count + c] =
            (uint32_t)whole->positions.count + norma_core_corner(mesh, c);
    whole->positions.count += mesh->positions.count;
    whole->corner_count += mesh->corner_count;
    whole->face_count += mesh->face_count;
}

norma_result norma_check_join(const core_mesh *meshes, size_t count, check_joined *joined) {
    size_t vertices = 0, corners = 0, faces = 0;
    int polygons = 0;
    *joined = (check_joined){.positions = NULL};
    for (size_t i = 0; i < count; ++i) {
        if (meshes[i].positions.count >= UINT32_MAX - 1 - vertices ||
            meshes[i].corner_count >= UINT32_MAX - 1 - corners)
            return NORMA_ERROR_OVERFLOW;
        vertices += meshes[i].positions.count;
        corners += meshes[i].corner_count;
        faces += meshes[i].face_count;
        polygons |= meshes[i].face_starts != NULL;
    }
    joined->positions = malloc((vertices + 1) * 3 * sizeof *joined->positions);
    joined->corners = malloc((corners + 1) * sizeof *joined->corners);
    joined->starts = polygons ? malloc((faces + 1) * sizeof *joined->starts) : NULL;
    if (!joined->positions || !joined->corners || (polygons && !joined->starts)) {
        norma_check_unjoin(joined);
        return NORMA_ERROR_MEMORY;
    }
    for (size_t i = 0; i < count; ++i) append_mesh(joined, &meshes[i]);
    if (polygons) joined->starts[faces] = (uint32_t)corners;
    joined->mesh.positions = (norma_vec3_view){joined->positions, vertices, 0, NORMA_FORMAT_DOUBLE};
    joined->mesh.corners = joined->corners;
    joined->mesh.face_starts = joined->starts;
    return NORMA_OK;
}

norma_result norma_check_join_held(check_mesh *const *held, size_t count, check_joined *joined) {
    core_mesh *meshes = calloc(count + 1, sizeof *meshes);
    for (size_t i = 0; meshes && i < count; ++i) meshes[i] = held[i]->mesh;
    const norma_result result =
        meshes ? norma_check_join(meshes, count, joined) : NORMA_ERROR_MEMORY;
    free(meshes);
    return result;
}

void norma_check_unjoin(check_joined *joined) {
    free(joined->positions);
    free(joined->corners);
    free(joined->starts);
    *joined = (check_joined){.positions = NULL};
}

/* ---- normals */

norma_result norma_check_users(check_mesh *m) {
    size_t count = norma_check_normal_count(m);
    const uint32_t *numbers = m->given->data.corner_normals;
    if (m->users || !numbers || !count) return NORMA_OK;
    m->users = norma_core_allocate(&m->run->call, count, sizeof *m->users);
    if (!m->users) return NORMA_ERROR_MEMORY;
    memset(m->users, 0xff, count * sizeof *m->users);
    for (size_t c = m->mesh.corner_count; c-- > 0;)
        if (numbers[c] < count) m->users[numbers[c]] = (uint32_t)c;
    return NORMA_OK;
}

size_t norma_check_last_at(const uint32_t *sorted, size_t count, size_t number) {
    size_t low = 0, high = count;
    while (low + 1 < high) {
        size_t middle = low + (high - low) / 2;
        if (sorted[middle] <= number)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* The last face that begins at or before it and is not empty. */
size_t norma_check_face_of(const check_mesh *m, size_t corner) {
    return m->mesh.face_starts
               ? norma_check_last_at(m->mesh.face_starts, m->mesh.face_count, corner)
               : corner / 3;
}

check_spot norma_check_normal_spot(const check_mesh *m, size_t number) {
    if (m->given->info.normals == NORMA_NORMALS_PER_FACET) return norma_check_face(number);
    if (m->users && m->users[number] < m->mesh.corner_count)
        return (check_spot){norma_core_corner(&m->mesh, m->users[number]),
            norma_check_face_of(m, m->users[number]), number};
    if (m->given->data.corner_normals) return (check_spot){SIZE_MAX, SIZE_MAX, number};
    if (m->given->info.normals == NORMA_NORMALS_PER_CORNER)
        return (check_spot){
            norma_core_corner(&m->mesh, number), norma_check_face_of(m, number), number};
    return norma_check_vertex(number);
}

double norma_check_encoding_bound(const char *encoding) {
    static const struct {
        const char *name;
        double degrees;
    } bounds[] = {{"snorm8", .3907}, {"int8", .3907}, {"snorm10", .0971}, {"snorm16", .00151},
        {"int16", .00151}, {"oct8", .9570}, {"oct10", .2379}, {"oct12", .0594}, {"oct16", .00371},
        {"float16", .0229}};
    for (size_t i = 0; encoding && i < sizeof bounds / sizeof *bounds; ++i)
        if (!strcmp(encoding, bounds[i].name)) return bounds[i].degrees * (3.141592653589793 / 180);
    return 0;
}

double norma_check_diagonal(const core_mesh *mesh) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY},
           squares = 0;
    for (size_t i = 0; i < mesh->positions.count; ++i) {
        double p[3];
        norma_core_position(mesh, (uint32_t)i, p);
        for (int k = 0; k < 3 && norma_core_finite(p); ++k) {
            low[k] = fmin(low[k], p[k]);
            high[k] = fmax(high[k], p[k]);
        }
    }
    for (int k = 0; k < 3; ++k) squares += (high[k] - low[k]) * (high[k] - low[k]);
    return isfinite(squares) ? sqrt(squares) : 0;
}

double norma_check_twice_area(const check_mesh *m, size_t face) {
    core_face geometry;
    norma_core_face_geometry(&m->mesh, face, &geometry);
    return geometry.flags & CORE_FACE_FINITE ? geometry.twice_area : 0;
}

double norma_check_add_areas(const check_mesh *m, double sum) {
    core_face faces[CORE_FACES_AT_ONCE];
    for (size_t f = 0, count; f < m->mesh.face_count; f += count) {
        count = m->mesh.face_count - f;
        count = count < CORE_FACES_AT_ONCE ? count : CORE_FACES_AT_ONCE;
        norma_core_faces_geometry(&m->run->call, &m->mesh, f, count, faces);
        for (size_t i = 0; i < count; ++i)
            sum += faces[i].flags & CORE_FACE_FINITE ? faces[i].twice_area : 0;
    }
    return sum;
}

/* ---- Which of the faces that somebody doubts are turned (core/topology/orient.c), with the
 * primitives of a glTF mesh looked at together. Rays say nothing of a material that is seen from
 * both sides. Where neither volume nor rays say anything, the stored normals of facets do: a
 * program that turns a facet seldom turns its normal. */

/* A judge that is kept has positions of its own. */
norma_result norma_check_open_judge(
    const core_mesh *meshes, size_t count, uint32_t threads, check_judge *judge) {
    const norma_options options = {.struct_size = sizeof options, .threads = threads};
    norma_result result = norma_check_join(meshes, count, &judge->whole);
    if (!result) result = norma_core_side_judge_open(&judge->whole.mesh, &options, &judge->sides);
    judge->is_open = !result;
    return result;
}

void norma_check_close_judge(check_judge *judge) {
    if (judge->is_open) norma_core_side_judge_close(&judge->sides);
    norma_check_unjoin(&judge->whole);
    judge->is_open = 0;
}

static norma_result open_group_judge(check_run *run) {
    const check_group *g = run->group;
    norma_result result = NORMA_OK;
    if (g->judge->is_open) return result;
    core_mesh *meshes = calloc(g->count, sizeof *meshes);
    if (!meshes) return NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < g->count && !result; ++i)
        result = norma_core_mesh_shape(&g->meshes[i].data.mesh, &meshes[i]);
    if (!result) result = norma_check_open_judge(meshes, g->count, run->options.threads, g->judge);
    free(meshes);
    return result;
}

/* Of the mesh's faces among all of the group. */
static size_t first_face(const check_mesh *m) {
    size_t first = 0;
    for (size_t i = 0; i < m->number; ++i)
        first += m->run->group->meshes[i].data.mesh.corner_count / 3;
    return first;
}

/* ---- stored normals of facets as evidence */

/* 1: the stored normal is the winding's, nearly; -1: its opposite; 0: neither, or unknown. */
static signed char lean_of_facet(
    const core_mesh *mesh, size_t facet, const norma_vec3_view *normals) {
    core_face geometry;
    double n[3];
    norma_core_face_geometry(mesh, facet, &geometry);
    norma_view_read(normals, facet, n);
    const double square = norma_core_dot(n, n);
    if (!(geometry.flags & CORE_FACE_DIRECTED) || !(square > 1e-12 && square < INFINITY)) return 0;
    const double cosine = norma_core_dot(geometry.normal, n) / sqrt(square);
    return cosine >= CHECK_LEAN_COSINE ? 1 : cosine <= -CHECK_LEAN_COSINE ? -1 : 0;
}

/* Above zero: the stored normals of more of its neighbours point to the same side of the surface as
 * its own does than to the other; below: of fewer. */
static int agreement_of_facet(const core_topology *t, size_t facet, const signed char *leans) {
    int sum = 0;
    const size_t end = norma_core_face_end(&t->mesh, facet);
    for (size_t c = norma_core_face_begin(&t->mesh, facet); c < end; ++c) {
        const uint32_t partner = t->partners[c];
        if (partner < CORE_EDGE_SPECIAL)
            sum += leans[facet] * leans[norma_core_topology_face(t, partner)];
        else if (partner == CORE_EDGE_CONFLICT)
            sum -= leans[facet] * leans[norma_core_topology_face(t, t->others[c])];
    }
    return sum;
}

/* A normal that its neighbours contradict is wrong itself, if it is the opposite of its winding. */
static uint8_t side_by_facets(
    const core_topology *t, size_t facet, const signed char *leans, uint8_t side) {
    const int sum = agreement_of_facet(t, facet, leans);
    if (sum > 0) return leans[facet] < 0 ? CORE_SIDE_TURNED : 0;
    return sum < 0 && leans[facet] < 0 ? 0 : side;
}

/* Of a facet that nobody asked about, rays might say something still. */
static int was_asked(const core_side_judge *j, size_t facet) {
    const uint32_t piece = j->pieces.of[facet], part = j->parts.of[facet];
    return piece != UINT32_MAX && part != UINT32_MAX &&
           (j->known[piece] || j->parts.each[part].flags == 0);
}

norma_result norma_check_sides_by_facets(
    const core_side_judge *j, const norma_vec3_view *normals, uint8_t *sides) {
    const core_topology *t = &j->topology;
    const size_t count = t->mesh.face_count < normals->count ? t->mesh.face_count : normals->count;
    size_t undecided = 0;
    for (size_t f = 0; f < count; ++f)
        undecided += sides[f] & CORE_SIDE_UNDECIDED && was_asked(j, f);
    if (!undecided) return NORMA_OK;
    signed char *leans = norma_core_allocate(&j->call, t->mesh.face_count, sizeof *leans);
    if (!leans) return NORMA_ERROR_MEMORY;
    memset(leans, 0, t->mesh.face_count * sizeof *leans);
    for (size_t f = 0; f < count; ++f) leans[f] = lean_of_facet(&t->mesh, f, normals);
    for (size_t f = 0; f < count; ++f)
        if (sides[f] & CORE_SIDE_UNDECIDED && was_asked(j, f))
            sides[f] = side_by_facets(t, f, leans, sides[f]);
    norma_core_release(&j->call, leans, t->mesh.face_count, sizeof *leans);
    return NORMA_OK;
}

/* ---- faces that lie folded over their neighbours: volume takes them for turned, since they are
 * wound against the rest of their part, and turned they would be as wrong */

static const double FOLD_COSINE = .5; /* of 60 degrees */

int norma_check_is_fold(const core_topology *t, size_t first, size_t second) {
    core_face a, b;
    norma_core_face_geometry(&t->mesh, norma_core_topology_face(t, first), &a);
    norma_core_face_geometry(&t->mesh, norma_core_topology_face(t, second), &b);
    return a.flags & b.flags & CORE_FACE_DIRECTED &&
           norma_core_dot(a.normal, b.normal) > FOLD_COSINE;
}

/* Whether more than folds part a piece from others, or it is most of its part. */
static int is_plain_piece(const core_side_judge *j, uint32_t piece) {
    const core_topology *t = &j->topology;
    const size_t begin = j->pieces.starts[piece], end = j->pieces.starts[piece + 1];
    const uint32_t *part = j->parts.starts + j->parts.of[j->pieces.faces[begin]];
    if (2 * (end - begin) > part[1] - (size_t)part[0]) return 1;
    for (size_t i = begin; i < end; ++i)
        for (size_t c = norma_core_face_begin(&t->mesh, j->pieces.faces[i]);
             c < norma_core_face_end(&t->mesh, j->pieces.faces[i]); ++c)
            if (t->partners[c] == CORE_EDGE_CONFLICT && !norma_check_is_fold(t, c, t->others[c]))
                return 1;
    return 0;
}

/* Each piece is looked at once, and only where it has faces that are called turned. */
norma_result norma_check_sides_at_folds(
    const core_side_judge *j, size_t first, size_t count, uint8_t *sides) {
    enum { NOT_LOOKED_AT, PLAIN, FOLDED };
    uint8_t *pieces = NULL;
    for (size_t f = 0; f < count; ++f) {
        const uint32_t piece = j->pieces.of[first + f];
        if (!norma_check_is_turned(sides[f]) || sides[f] & CORE_SIDE_BY_RAYS || piece == UINT32_MAX)
            continue;
        if (!pieces) {
            pieces = norma_core_allocate(&j->call, j->pieces.count, 1);
            if (!pieces) return NORMA_ERROR_MEMORY;
            memset(pieces, NOT_LOOKED_AT, j->pieces.count);
        }
        if (pieces[piece] == NOT_LOOKED_AT)
            pieces[piece] = is_plain_piece(j, piece) ? PLAIN : FOLDED;
        if (pieces[piece] == FOLDED) sides[f] |= CORE_SIDE_UNDECIDED;
    }
    norma_core_release(&j->call, pieces, j->pieces.count, 1);
    return NORMA_OK;
}

/* ---- asking */

int norma_check_is_turned(uint8_t side) {
    return (side & (CORE_SIDE_TURNED | CORE_SIDE_UNDECIDED)) == CORE_SIDE_TURNED;
}

size_t norma_check_count_turned(
    const check_mesh *m, const uint8_t *asked, const uint8_t *sides, double *twice_area) {
    const core_components *parts = &m->run->group->judge->sides.parts;
    const size_t first = first_face(m);
    size_t count = 0;
    *twice_area = 0;
    for (size_t f = 0; f < m->mesh.face_count; ++f) {
        if (!norma_check_is_turned(sides[f]) || parts->of[first + f] == UINT32_MAX ||
            !(asked[f] || parts->each[parts->of[first + f]].flags & COMPONENT_CONFLICT))
            continue;
        ++count;
        *twice_area += norma_check_twice_area(m, f);
    }
    return count;
}

norma_result norma_check_sides(check_mesh *m, const uint8_t *asked, uint8_t *sides) {
    const size_t first = first_face(m);
    norma_result result = open_group_judge(m->run);
    if (!result && m->on_purpose) { /* nothing asks rays, which would say nothing */
        memset(sides, 0, m->mesh.face_count);
        asked = sides;
    }
    if (!result)
        result = norma_core_side_judge_ask(
            &m->run->group->judge->sides, first, m->mesh.face_count, asked, sides);
    if (!result)
        result = norma_check_sides_at_folds(
            &m->run->group->judge->sides, first, m->mesh.face_count, sides);
    return result || m->given->info.normals != NORMA_NORMALS_PER_FACET
               ? result
               : norma_check_sides_by_facets(
                     &m->run->group->judge->sides, &m->given->data.normals, sides);
}
