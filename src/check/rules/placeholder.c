/* placeholder.c: N203: one and the same normal nearly everywhere, on a mesh that is curved. */
#include "check/rules/mesh_rules.h"
#include <math.h>
#include <string.h>

static const double MOST_ALIKE = .95; /* of the normals */
static const double MOST_FLAT = .95;  /* of the faces: more of them within the angle of one
                                         direction, or against it, make a flat mesh */
static const double FLAT_COSINE = 0.9961946980917455; /* of 5 degrees */

static int is_used(const check_mesh *m, size_t number) {
    return !m->users || m->users[number] != UINT32_MAX;
}

static int same(const double a[3], const double b[3]) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* The one that more than half of them are, if there is one (Boyer and Moore 1981). */
static void find_majority(const check_mesh *m, double majority[3]) {
    size_t count = norma_check_normal_count(m), lead = 0;
    for (size_t i = 0; i < count; i++) {
        double n[3];
        if (!is_used(m, i)) continue;
        norma_check_normal(m, i, n);
        if (!lead) memcpy(majority, n, sizeof n);
        lead = !lead || same(n, majority) ? lead + 1 : lead - 1;
    }
}

static size_t count_alike(const check_mesh *m, const double normal[3], size_t *used) {
    size_t count = norma_check_normal_count(m), alike = 0;
    *used = 0;
    for (size_t i = 0; i < count; i++) {
        double n[3];
        if (!is_used(m, i)) continue;
        norma_check_normal(m, i, n);
        ++*used;
        alike += same(n, normal) != 0;
    }
    return alike;
}

/* Flat: nearly all faces that have a direction look along one line. Whether it is that of most of
 * them is tried with each of a few. */
static int is_curved(const check_mesh *m) {
    enum { TRIES = 16 };
    size_t directed = 0, best = 0, faces = m->mesh.face_count;
    for (size_t f = 0; f < faces; f++) directed += norma_check_directed(&m->faces[f]) != 0;
    for (size_t i = 0; i < TRIES && i < faces; i++) {
        size_t try = i * (faces / (faces < TRIES ? faces : TRIES)), alike = 0;
        const double n[3] = {(double)m->faces[try].normal[0], (double)m->faces[try].normal[1],
            (double)m->faces[try].normal[2]};
        for (size_t f = 0; f < faces; f++)
            alike += fabs(norma_check_dot(m->faces[f].normal, n)) > FLAT_COSINE;
        best = alike > best ? alike : best;
    }
    return directed > 1 && (double)best < MOST_FLAT * (double)directed;
}

typedef struct placeholder {
    double normal[3];
    size_t alike, used;
} placeholder;

static norma_result find_placeholder(check_mesh *m, placeholder *p) {
    const int known = m->placeholder;
    *p = (placeholder){.used = 0};
    m->placeholder = CHECK_NO;
    if (known == CHECK_NO || !norma_check_normal_count(m) ||
        m->given->info.normals == NORMA_NORMALS_PER_FACET || !m->mesh.face_count)
        return NORMA_OK;
    norma_result result = norma_check_users(m);
    if (result) return result;
    find_majority(m, p->normal);
    p->alike = count_alike(m, p->normal, &p->used);
    if (!p->used || (double)p->alike <= MOST_ALIKE * (double)p->used ||
        !norma_core_finite(p->normal) ||
        (p->normal[0] == 0 && p->normal[1] == 0 && p->normal[2] == 0))
        return NORMA_OK;
    result = norma_check_faces(m);
    if (!result && is_curved(m)) m->placeholder = CHECK_YES;
    return result;
}

norma_result norma_check_is_placeholder(check_mesh *m, int *is) {
    placeholder p;
    const norma_result result = m->placeholder ? NORMA_OK : find_placeholder(m, &p);
    *is = m->placeholder == CHECK_YES;
    return result;
}

norma_result norma_check_placeholder(check_mesh *m) {
    placeholder p;
    char message[CHECK_MESSAGE];
    if (!norma_check_wants(m, RULE_N203)) return NORMA_OK;
    const norma_result result = find_placeholder(m, &p);
    if (result || m->placeholder != CHECK_YES) return result;
    norma_check_message(message,
        "%z of %z normals are (%g, %g, %g), although the mesh is curved; it is lit like a flat "
        "plate",
        p.alike, p.used, p.normal[0], p.normal[1], p.normal[2]);
    return norma_check_add_one(m->run, &m->place, m, RULE_N203,
        m->on_purpose ? NORMA_SEVERITY_INFO : NORMA_SEVERITY_WARNING, CHECK_NOWHERE, message);
}
