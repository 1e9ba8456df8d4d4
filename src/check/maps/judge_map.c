/* judge_map.c: what the texels that a mesh uses say of its normal map: N811, N812. */
#include "check/maps/maps.h"
#include <stdlib.h>

static const double MOST_BAD = .05;
enum { FEW_TEXELS = 16 };

static norma_result add(check_mesh *m, check_rule rule, double value, const char *message) {
    check_hits one = {0};
    norma_check_hit(m->run, &one, value, CHECK_NOWHERE);
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = rule,
            .severity = NORMA_SEVERITY_WARNING,
            .unit = rule == RULE_N811 ? "%" : "",
            .hits = &one,
            .message = message});
}

/* ---- N811 */

/* An exporter's placeholder that says nothing wrong, also as JPEG gives it back. */
static int is_flat(const uint8_t c[3]) {
    return (c[0] == 127 || c[0] == 128) && (c[1] == 127 || c[1] == 128) && c[2] >= 254;
}

static double bad_share(const map_lengths *l) {
    return l->used ? (double)l->bad / (double)l->used : 0;
}

static norma_result tell_lengths(check_mesh *m, const map_texels *texels, const map_lengths *l) {
    char message[CHECK_MESSAGE];
    const size_t all = texels->columns * texels->rows;
    const double percent = 100 * bad_share(l);
    if (l->used && l->one_value && (l->used >= FEW_TEXELS || l->used == all)) {
        if (is_flat(l->first)) return NORMA_OK;
        norma_check_message(message,
            "all texels of the normal map that faces use are (%z, %z, %z); one value throughout "
            "turns every normal by the same angle",
            (size_t)l->first[0], (size_t)l->first[1], (size_t)l->first[2]);
    } else if (bad_share(l) > MOST_BAD) {
        norma_check_message(message,
            "%g %% of the normal map's texels that faces use are not unit vectors above the "
            "surface; the map may be a bump map, or stored in another way than glTF asks",
            percent);
    } else {
        return NORMA_OK;
    }
    return add(m, RULE_N811, percent, message);
}

/* ---- N812 */

/* Agreement is positive if the slopes of the map fit one height field, and negative if they would
 * fit with green inverted. Measured on maps known to be right: .35 to .65 between neighbouring
 * texels, .2 to .35 between blocks of texels; the same maps with green inverted give the same
 * numbers below zero. Maps that come from no height field stay within .1, except that compression
 * can shift one level. So a map counts as inverted if two consecutive levels are negative and no
 * level is positive beyond .1. */
static const double TURNED = -.2, CONFIRMED = -.1, AS_IS = .1;
enum { FEW_VOTES = 256, FEW_TO_CONFIRM = 64, LAST_LEVEL = 4 };

static int is_turned(const map_curl *curl, double *agreement) {
    *agreement = 0;
    for (size_t level = 0; level <= LAST_LEVEL; ++level) {
        const double here = curl->agreement[level], coarser = curl->agreement[level + 1];
        if (curl->votes[level] < FEW_VOTES) continue;
        if (here > AS_IS) return 0;
        if (curl->votes[level + 1] < FEW_TO_CONFIRM || coarser > CONFIRMED) continue;
        if (here < *agreement) *agreement = here;
    }
    return *agreement < TURNED;
}

static norma_result judge_curl(check_mesh *m, const map_texels *texels, const map_mask *mask) {
    map_curl curl;
    double agreement;
    if (!norma_map_curl(texels, mask, &curl)) return NORMA_ERROR_MEMORY;
    if (!is_turned(&curl, &agreement)) return NORMA_OK;
    return add(m, RULE_N812, -agreement,
        "the normal map fits a surface only with its green channel inverted; it was made for the "
        "other convention (DirectX), so light from above makes bumps look like dents");
}

norma_result norma_check_map(
    check_mesh *m, const norma_texture_info *map, const map_texels *texels) {
    map_mask mask;
    map_lengths lengths;
    norma_result result = NORMA_OK;
    if (!norma_check_wants_any(m, RULE_N811, RULE_N812)) return NORMA_OK;
    if (!norma_map_mask(m, map, texels, &mask)) return NORMA_ERROR_MEMORY;
    norma_map_lengths(texels, &mask, &lengths);
    if (norma_check_wants(m, RULE_N811)) result = tell_lengths(m, texels, &lengths);
    const int are_normals = bad_share(&lengths) <= MOST_BAD; /* else they decide nothing */
    if (!result && are_normals && norma_check_wants(m, RULE_N812))
        result = judge_curl(m, texels, &mask);
    free(mask.bits);
    return result;
}
