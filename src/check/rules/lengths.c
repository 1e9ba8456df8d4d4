/* lengths.c: N101 to N103: normals that are no unit vectors, by what their encoding can hold. */
#include "check/rules/local_rules.h"
#include "check/rules/mesh_rules.h"
#include "core/face/unit_length.h"
#include <math.h>
#include <string.h>

enum { NORMALS_IN_BLOCK = 1 << 14 };

typedef struct length_pass {
    const check_mesh *m;
    double tolerance;
    check_lengths *parts;
} length_pass;

static double length_tolerance(const check_mesh *m) {
    const char *encoding = m->given->info.encoding ? m->given->info.encoding : "";
    const int bits = !strcmp(encoding, "snorm8") || !strcmp(encoding, "int8") ? 8
                     : !strcmp(encoding, "snorm10")                           ? 10
                                                                              : 32;
    return norma_core_unit_tolerance(bits, m->run->options.strict);
}

static void judge_normal(const length_pass *pass, check_lengths *part, size_t number) {
    const check_mesh *m = pass->m;
    double n[3], length;
    norma_check_normal(m, number, n);
    const core_length is = norma_core_judge_length(n, pass->tolerance, &length);
    if (is == CORE_LENGTH_UNIT || (m->users && m->users[number] == UINT32_MAX)) return;
    const check_spot spot = norma_check_normal_spot(m, number);
    if (is == CORE_LENGTH_NON_FINITE)
        norma_check_hit(m->run, &part->non_finite, 0, spot);
    else if (is == CORE_LENGTH_ZERO)
        norma_check_hit(m->run, &part->zero, length, spot);
    else
        norma_check_hit(m->run, &part->non_unit, fabs(length - 1), spot);
}

static void judge_normals(void *context, size_t block, size_t begin, size_t end) {
    const length_pass *pass = context;
    pass->parts[block].zero.least = 1;
    for (size_t i = begin; i < end; i++) judge_normal(pass, &pass->parts[block], i);
}

/* ---- how many normals of no length belong to degenerate faces only: a word of comfort in the
 * message, since recomputing takes the nearest normal for them */

static norma_result count_idle(check_mesh *m, size_t zeros, size_t *idle) {
    size_t count = norma_check_normal_count(m), busy_zeros = 0;
    *idle = 0;
    norma_result result = norma_check_faces(m);
    uint8_t *busy = result ? NULL : norma_core_allocate(&m->run->call, count, 1);
    if (result || !busy) return result ? result : NORMA_ERROR_MEMORY;
    memset(busy, 0, count);
    for (size_t f = 0; f < m->mesh.face_count; f++) {
        if (!norma_check_directed(&m->faces[f])) continue;
        for (size_t c = norma_core_face_begin(&m->mesh, f); c < norma_core_face_end(&m->mesh, f);
             c++) {
            size_t number = norma_check_normal_of(m, f, c);
            double n[3], length;
            if (number == SIZE_MAX || busy[number]) continue;
            norma_check_normal(m, number, n);
            busy[number] = 1;
            busy_zeros += norma_core_judge_length(n, 0, &length) == CORE_LENGTH_ZERO;
        }
    }
    norma_core_release(&m->run->call, busy, count, 1);
    *idle = zeros - busy_zeros;
    return NORMA_OK;
}

static norma_result add_zero(check_mesh *m, check_hits *hits, size_t idle) {
    char message[CHECK_MESSAGE];
    if (idle)
        norma_check_message(message,
            "%z zero-length normal%s; %z used only by degenerate faces (N401)", hits->count,
            norma_check_plural(hits->count), idle);
    else
        norma_check_message(message, "%z zero-length normal%s; normalising one divides by zero",
            hits->count, norma_check_plural(hits->count));
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N102,
            .severity = NORMA_SEVERITY_ERROR,
            .unit = "length",
            .hits = hits,
            .message = message});
}

/* The lengths of facet normals are N205's. */
static int wants_lengths(const check_mesh *m, check_rule rule) {
    return m->given->info.normals != NORMA_NORMALS_PER_FACET && norma_check_wants(m, rule);
}

static norma_result add_findings(check_mesh *m, check_lengths *sum, size_t idle) {
    norma_result result = NORMA_OK;
    if (norma_check_wants(m, RULE_N101) && sum->non_finite.count)
        result = norma_check_report(m,
            &(check_report){.rule = RULE_N101,
                .severity = NORMA_SEVERITY_ERROR,
                .no_value = 1,
                .hits = &sum->non_finite},
            "%z normal%s with a component that is NaN or infinite", sum->non_finite.count,
            norma_check_plural(sum->non_finite.count));
    if (!result && wants_lengths(m, RULE_N102) && sum->zero.count)
        result = add_zero(m, &sum->zero, idle);
    if (!result && wants_lengths(m, RULE_N103) && sum->non_unit.count)
        result = norma_check_report(m,
            &(check_report){.rule = RULE_N103,
                .severity = NORMA_SEVERITY_ERROR,
                .unit = "length",
                .hits = &sum->non_unit},
            "%z normal%s whose length differs from 1, by up to %g; if a shader does not "
            "renormalise, diffuse light is multiplied by the length",
            sum->non_unit.count, norma_check_plural(sum->non_unit.count), sum->non_unit.worst);
    return result;
}

void norma_check_lengths_drop(check_lengths *sum) {
    norma_check_hits_free(&sum->non_finite);
    norma_check_hits_free(&sum->zero);
    norma_check_hits_free(&sum->non_unit);
}

norma_result norma_check_lengths_add(check_mesh *m, check_lengths *sum, size_t idle) {
    const norma_result result = add_findings(m, sum, idle);
    norma_check_lengths_drop(sum);
    return result;
}

norma_result norma_check_lengths_look(check_mesh *m, check_lengths *sum) {
    size_t count = norma_check_normal_count(m),
           blocks = norma_check_block_count(count, NORMALS_IN_BLOCK);
    sum->zero.least = 1;
    if (!count || !norma_check_wants_any(m, RULE_N101, RULE_N103)) return NORMA_OK;
    length_pass pass = {
        m, length_tolerance(m), norma_core_allocate(&m->run->call, blocks, sizeof *pass.parts)};
    norma_result result = pass.parts ? norma_check_users(m) : NORMA_ERROR_MEMORY;
    if (pass.parts) memset(pass.parts, 0, blocks * sizeof *pass.parts);
    if (!result) result = norma_check_blocks(m->run, count, NORMALS_IN_BLOCK, judge_normals, &pass);
    for (size_t i = 0; pass.parts && i < blocks; i++) {
        norma_check_hits_merge(m->run, &sum->non_finite, &pass.parts[i].non_finite);
        norma_check_hits_merge(m->run, &sum->zero, &pass.parts[i].zero);
        norma_check_hits_merge(m->run, &sum->non_unit, &pass.parts[i].non_unit);
    }
    norma_core_release(&m->run->call, pass.parts, blocks, sizeof *pass.parts);
    return result;
}

norma_result norma_check_lengths(check_mesh *m) {
    check_lengths sum = {.zero.least = 1};
    size_t idle = 0;
    norma_result result = norma_check_lengths_look(m, &sum);
    if (!result && sum.zero.count && wants_lengths(m, RULE_N102))
        result = count_idle(m, sum.zero.count, &idle);
    if (!result) result = norma_check_lengths_add(m, &sum, idle);
    norma_check_lengths_drop(&sum);
    return result;
}
