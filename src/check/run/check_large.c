/* check_large.c: A file larger than memory, by the rules that need no neighbours. Its vertices are
 * gone through, then its faces, part by part; what each rule sums up over the parts is what it sums
 * up over the whole. Rules that need neighbours are named as not looked at. */
#include "check/rules/rules.h"
#include "core/face/unit_length.h"
#include "io/large/large.h"
#include <stdlib.h>
#include <string.h>

enum { LEVELS = 10, LENGTHS = (1 << LEVELS) - 1 };

typedef struct large_check {
    check_run run;
    large_walk *walk;
    norma_document_error *error;
    norma_check_mesh given; /* of the whole file: counts alone */
    check_mesh whole;
    check_hits unplaced;
    check_sum lengths, facets, shapes, polygons;
    double facet_area; /* twice, of all faces */
    check_largest largest;
    uint8_t *zeros;  /* two bits for each vertex whose normal has no length: no face with a
                        direction, and no face at all, was seen to use it; NULL: none has */
    check_idle idle; /* how many */
    /* Edges by length, for N701: counts has one more. */
    double ranges[LENGTHS];
    size_t range_count, counts[LENGTHS + 1];
} large_check;

/* ---- parts as meshes */

typedef norma_result look_at_mesh(large_check *c, check_mesh *m, const void *part);

static norma_document_result with_part(large_check *c, const norma_mesh_data *data,
    const check_part *place, look_at_mesh *look, const void *part) {
    norma_check_mesh given = c->given;
    check_mesh m;
    given.data = *data;
    norma_result result = norma_check_open_mesh(&c->run, &given, &m);
    if (result) return norma_check_fail(c->error, result);
    m.order = c->whole.order;
    c->run.part = place;
    result = look(c, &m, part);
    c->run.part = NULL;
    norma_check_close_mesh(&m);
    return norma_check_fail(c->error, result);
}

/* ---- vertices: N101 to N103, the largest coordinate */

static int is_zero_normal(const norma_vec3_view *normals, size_t i) {
    double n[3], length;
    norma_view_read(normals, i, n);
    return norma_core_judge_length(n, 0, &length) == CORE_LENGTH_ZERO;
}

enum { NOT_BUSY = 1, NOT_USED = 2 }; /* by a face with a direction; by any */

static norma_result note_zeros(large_check *c, const large_vertices *part) {
    if (!c->zeros) c->zeros = calloc(c->given.info.vertices / 4 + 1, 1);
    if (!c->zeros) return NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < part->normals.count; ++i)
        if (is_zero_normal(&part->normals, i)) {
            c->zeros[(part->first + i) / 4] |=
                (uint8_t)((NOT_BUSY | NOT_USED) << 2 * ((part->first + i) % 4));
            ++c->idle.unused;
        }
    return NORMA_OK;
}

static norma_result look_at_points(large_check *c, check_mesh *m, const void *context) {
    const large_vertices *part = context;
    const size_t zeros = c->lengths.hits[CHECK_LENGTH_NONE].count;
    norma_check_find_largest(&m->mesh, part->first, &c->largest);
    const norma_result result =
        part->normals.count ? norma_check_lengths_look(m, &c->lengths) : NORMA_OK;
    return !result && c->lengths.hits[CHECK_LENGTH_NONE].count > zeros ? note_zeros(c, part)
                                                                       : result;
}

static norma_document_result look_at_vertices(void *context, const large_vertices *part) {
    large_check *c = context;
    /* Unlike those of the whole, positions have a format in their parts only. */
    c->whole.mesh.positions.format = part->positions.format;
    return with_part(c,
        &(norma_mesh_data){.mesh.positions = part->positions, .normals = part->normals},
        &(check_part){.first_vertex = part->first}, look_at_points, part);
}

/* ---- faces */

static void use_normal(large_check *c, uint32_t v, int directed) {
    const unsigned shift = 2 * (v % 4), is = c->zeros[v / 4] >> shift & (NOT_BUSY | NOT_USED);
    if (is & NOT_USED) {
        --c->idle.unused;
        ++c->idle.degenerate;
    }
    if (is && directed) --c->idle.degenerate;
    c->zeros[v / 4] &= (uint8_t) ~((directed ? NOT_BUSY | NOT_USED : NOT_USED) << shift);
}

static void use_normals(large_check *c, const check_mesh *m, const uint32_t *vertices) {
    for (size_t f = 0; f < m->mesh.face_count; ++f)
        for (size_t k = norma_core_face_begin(&m->mesh, f); k < norma_core_face_end(&m->mesh, f);
             ++k)
            use_normal(c, vertices[norma_core_corner(&m->mesh, k)],
                norma_check_directed(&m->faces[f]) != 0);
}

static norma_result look_at_part(large_check *c, check_mesh *m, const void *context) {
    const large_surface *part = context;
    norma_result result = norma_check_faces(m);
    norma_check_unplaced_look(m, &c->unplaced);
    if (!result && part->normals.count) result = norma_check_lengths_look(m, &c->lengths);
    if (!result && part->normals.count && norma_check_wants(m, RULE_N205)) {
        result = norma_check_facets_look(m, &c->facets, NULL);
        c->facet_area = norma_check_add_areas(m, c->facet_area);
    }
    if (!result) result = norma_check_shapes_look(m, &c->shapes);
    if (!result) result = norma_check_polygons_look(m, &c->polygons);
    if (!result && c->zeros) use_normals(c, m, part->vertices);
    if (!result && c->range_count)
        result = norma_check_sort_edges(m, c->ranges, c->range_count, SIZE_MAX, c->counts);
    return result;
}

static norma_document_result with_surface(void *c, const large_surface *part, look_at_mesh *look) {
    return with_part(c, &(norma_mesh_data){.mesh = part->mesh, .normals = part->normals},
        &(check_part){part->first_face, part->first_vertex, part->vertices}, look, part);
}

static norma_document_result look_at_surface(void *context, const large_surface *part) {
    return with_surface(context, part, look_at_part);
}

/* ---- N701: the median edge, found by halving. One reading answers all that the next halvings may
 * ask. */

static norma_result sort_part(large_check *c, check_mesh *m, const void *part) {
    (void)part;
    const norma_result result = norma_check_weld(m);
    return result ? result
                  : norma_check_sort_edges(m, c->ranges, c->range_count, SIZE_MAX, c->counts);
}

static norma_document_result sort_surface(void *context, const large_surface *part) {
    return with_surface(context, part, sort_part);
}

/* The middles that may come up, ascending. */
static void fill_ranges(large_check *c, double low, double high, int levels) {
    const double middle = low + (high - low) / 2;
    if (!levels) return;
    fill_ranges(c, low, middle, levels - 1);
    c->ranges[c->range_count++] = middle;
    fill_ranges(c, middle, high, levels - 1);
}

static norma_result ask_shorter(
    void *context, double low, double high, size_t *shorter, size_t *all) {
    large_check *c = context;
    const double middle = low + (high - low) / 2;
    size_t at = 0;
    while (at < c->range_count && c->ranges[at] < middle) ++at;
    if (at == c->range_count || c->ranges[at] > middle) {
        c->range_count = 0;
        memset(c->counts, 0, sizeof c->counts);
        fill_ranges(c, low, high, LEVELS);
        if (norma_large_walk_surface(c->walk, 0.9, 1, sort_surface, c)) return NORMA_CANCELLED;
        at = LENGTHS / 2;
    }
    *shorter = *all = 0;
    for (size_t i = 0; i <= c->range_count; ++i) {
        *shorter += i <= at ? c->counts[i] : 0;
        *all += c->counts[i];
    }
    return NORMA_OK;
}

static norma_document_result judge_distance(large_check *c) {
    double median;
    if (!c->range_count || c->counts[0] <= c->counts[1]) return NORMA_DOCUMENT_OK;
    const double coarse = c->ranges[0];
    c->range_count = 0;
    norma_result result = norma_check_median_edge(coarse, ask_shorter, c, &median);
    if (result) return c->error->result;
    result = norma_check_distance_add(&c->whole, &c->largest, median);
    return norma_check_fail(c->error, result);
}

/* ---- N002: what was not looked at */

static int needs_neighbours(const large_check *c, check_rule rule) {
    static const check_rule both[] = {RULE_N301, RULE_N302, RULE_N303, RULE_N304, RULE_N305,
        RULE_N306, RULE_N307, RULE_N503},
                            of_vertices[] = {RULE_N201, RULE_N202, RULE_N203, RULE_N204, RULE_N206,
                                RULE_N207, RULE_N403, RULE_N501, RULE_N502};
    int needs = 0;
    for (size_t i = 0; i < sizeof both / sizeof *both; ++i) needs |= rule == both[i];
    for (size_t i = 0; i < sizeof of_vertices / sizeof *of_vertices; ++i)
        needs |= rule == of_vertices[i] && c->run.format != NORMA_FILE_STL;
    return needs;
}

static norma_result tell_rules_left_out(large_check *c) {
    char names[CHECK_MESSAGE] = "", message[CHECK_MESSAGE];
    const check_place place = {.order = 0, .where = "", .label = ""};
    size_t length = 0;
    for (size_t rule = 0; rule < CHECK_RULE_COUNT; ++rule)
        if (c->run.rules[rule] && needs_neighbours(c, (check_rule)rule)) {
            const char *id = norma_rules(NULL)[rule].id;
            if (length) memcpy(names + length, ", ", 3), length += 2;
            memcpy(names + length, id, strlen(id) + 1);
            length += strlen(id);
        }
    if (!length) return NORMA_OK;
    norma_check_partly(&c->run);
    if (!c->run.rules[RULE_N002]) return NORMA_OK;
    norma_check_message(message,
        "not checked: the file is larger than the memory allowed and was read in parts, and these "
        "rules need all of it: %s; allow more memory",
        names);
    return norma_check_add_one(&c->run, &place, RULE_N002, NORMA_SEVERITY_WARNING, message);
}

/* ---- the whole */

static norma_result add_large_findings(large_check *c) {
    check_mesh *m = &c->whole;
    const int is_nothing =
        c->given.info.normals == NORMA_NORMALS_NONE && c->unplaced.count == c->given.info.faces;
    norma_result result = tell_rules_left_out(c);
    if (!result)
        result = norma_check_unplaced_add(
            m, &c->unplaced, is_nothing ? NORMA_SEVERITY_ERROR : NORMA_SEVERITY_WARNING);
    if (!result) result = norma_check_lengths_add(m, &c->lengths, &c->idle);
    if (!result) result = norma_check_facets_add(m, &c->facets, c->facet_area);
    if (!result) result = norma_check_shapes_add(m, &c->shapes);
    if (!result) result = norma_check_polygons_add(m, &c->polygons);
    if (!result && m->mesh.face_count && norma_check_wants(m, RULE_N702))
        result = norma_check_encoding_add(m);
    return result ? result : norma_check_missing_normals(m);
}

static norma_document_result locate(void *context, norma_sample *sample) {
    return norma_large_walk_locate(context, sample->vertex, sample->face, sample->position);
}

static void describe_whole(large_check *c, const norma_mesh_info *info) {
    c->given.info = *info;
    c->given.data.normals.count = info->normals == NORMA_NORMALS_NONE        ? 0
                                  : info->normals == NORMA_NORMALS_PER_FACET ? info->faces
                                                                             : info->vertices;
    c->whole = (check_mesh){.run = &c->run, .given = &c->given, .in_parts = 1, .order = 1};
    memcpy(c->whole.rules, c->run.rules, sizeof c->whole.rules);
    c->whole.mesh.face_count = info->faces;
}

static norma_document_result judge_parts(large_check *c) {
    const int is_stl = c->run.format == NORMA_FILE_STL;
    const double share = is_stl ? 0.3 : 0.2;
    norma_document_result result =
        norma_large_walk_vertices(c->walk, 0, share, look_at_vertices, c);
    c->ranges[0] = norma_check_coarse_length(&c->whole, &c->largest);
    c->range_count = norma_check_wants(&c->whole, RULE_N701) && c->ranges[0] > 0;
    if (!result) result = norma_large_walk_surface(c->walk, share, 0.9, look_at_surface, c);
    if (!result) result = judge_distance(c);
    const norma_result added = result ? NORMA_OK : add_large_findings(c);
    if (added) return norma_check_fail(c->error, added);
    return result ? result : norma_findings_locate(c->run.findings, locate, c->walk);
}

static void drop(large_check *c) {
    norma_check_hits_free(&c->unplaced);
    check_sum *const sums[] = {&c->lengths, &c->facets, &c->shapes, &c->polygons};
    for (size_t i = 0; i < sizeof sums / sizeof *sums; ++i) norma_check_sum_free(sums[i]);
    free(c->zeros);
}

norma_document_result norma_check_large(const char *path, const norma_large_options *large,
    const norma_check_options *options, norma_findings **findings, norma_document_error *error) {
    norma_document_error unwanted;
    norma_mesh_info info;
    large_check *c = calloc(1, sizeof *c);
    error = error ? error : &unwanted;
    *error = (norma_document_error){0};
    if (!c) return norma_check_fail(error, NORMA_ERROR_MEMORY);
    c->error = error;
    const norma_result begun =
        path && findings ? norma_check_begin(&c->run, options, norma_large_format(path, large))
                         : NORMA_ERROR_ARGUMENT;
    if (begun) {
        free(c);
        return norma_check_fail(error, begun);
    }
    c->run.call.options.progress = NULL; /* the parts are told of, not what is done with each */
    norma_document_result result = norma_large_walk_open(
        path, large, c->run.options.progress, c->run.options.progress_user, &c->walk, &info, error);
    if (!result) describe_whole(c, &info);
    if (!result) result = judge_parts(c);
    result = norma_large_walk_close(c->walk, result);
    drop(c);
    if (result)
        norma_check_abandon(&c->run);
    else
        *findings = norma_check_finish(&c->run);
    free(c);
    return result;
}
