/* findings.c: findings as they are gathered, worded and read. Each owns its texts and its samples.
 */
#include "check/findings/check_run.h"
#include "core/call/table.h"
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* ---- Messages, put together without the C library's formats, whose numbers follow the
 * locale. */

typedef struct text {
    char *out;
    size_t length;
} text;

static void put_bytes(text *t, const char *from, size_t length) {
    size_t room = CHECK_MESSAGE - 1 - t->length;
    length = length < room ? length : room;
    memcpy(t->out + t->length, from, length);
    t->length += length;
}

static void put_size(text *t, size_t value) {
    char digits[24];
    size_t at = sizeof digits;
    do {
        digits[--at] = (char)('0' + value % 10);
        value /= 10;
    } while (value);
    put_bytes(t, digits + at, sizeof digits - at);
}

/* Three digits as an integer below 1000 and the power of ten of the first. By divisions alone: the
 * C library's log10 and pow differ between systems. */
static unsigned three_digits(double value, int *power) {
    static const double tens[] = {1e1, 1e2, 1e4, 1e8, 1e16, 1e32, 1e64, 1e128, 1e256};
    *power = 0;
    for (int i = 8; i >= 0; --i)
        if (value >= tens[i]) {
            value /= tens[i];
            *power += 1 << i;
        }
    for (int i = 8; i >= 0 && value < 1; --i)
        if (value * tens[i] < 10) {
            value *= tens[i];
            *power -= 1 << i;
        }
    unsigned digits = (unsigned)(value * 100 + 0.5);
    if (digits >= 1000) {
        digits = (digits + 5) / 10;
        ++*power;
    }
    return digits < 100 ? 100 : digits;
}

/* digits with the point behind the first, zeros behind it left out: 1.02, 1.2, 1. */
static void add_digits(text *t, unsigned digits, int before_point) {
    char all[4] = {
        (char)('0' + digits / 100), (char)('0' + digits / 10 % 10), (char)('0' + digits % 10), 0};
    int last = all[2] != '0' ? 3 : all[1] != '0' ? 2 : 1;
    for (int i = 0; i < 3 && (i < last || i < before_point); ++i) {
        if (i == before_point) put_bytes(t, ".", 1);
        put_bytes(t, &all[i], 1);
    }
}

static void add_small(text *t, unsigned digits, int power) {
    put_bytes(t, "0.", 2);
    for (int i = -1; i > power; --i) put_bytes(t, "0", 1);
    while (digits % 10 == 0) digits /= 10;
    put_size(t, digits);
}

static void add_large(text *t, unsigned digits, int power) {
    add_digits(t, digits, 3);
    for (int i = 2; i < power; ++i) put_bytes(t, "0", 1);
}

static void add_double(text *t, double value) {
    int power;
    if (isnan(value) || isinf(value) || value == 0) {
        const char *word = isnan(value) ? "NaN"
                           : value == 0 ? "0"
                           : value < 0  ? "-infinity"
                                        : "infinity";
        put_bytes(t, word, strlen(word));
        return;
    }
    if (value < 0) put_bytes(t, "-", 1);
    unsigned digits = three_digits(fabs(value), &power);
    if (power >= 0 && power < 3) {
        add_digits(t, digits, power + 1);
    } else if (power >= 3 && power < 6) {
        add_large(t, digits, power);
    } else if (power < 0 && power >= -4) {
        add_small(t, digits, power);
    } else {
        add_digits(t, digits, 1);
        put_bytes(t, power < 0 ? "e-" : "e", power < 0 ? 2 : 1);
        put_size(t, (size_t)(power < 0 ? -power : power));
    }
}

static void write_message(char out[CHECK_MESSAGE], const char *format, va_list arguments) {
    text t = {out, 0};
    for (const char *at = format; *at; ++at) {
        const char *special = at[0] == '%' ? &at[1] : NULL;
        if (!special) {
            put_bytes(&t, at, 1);
            continue;
        }
        if (*special == 's') {
            const char *word = va_arg(arguments, const char *);
            put_bytes(&t, word, strlen(word));
        } else if (*special == 'z') {
            put_size(&t, va_arg(arguments, size_t));
        } else if (*special == 'g') {
            add_double(&t, va_arg(arguments, double));
        } else {
            put_bytes(&t, "%", 1);
        }
        ++at;
    }
    out[t.length] = 0;
}

void norma_check_message(char out[CHECK_MESSAGE], const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    write_message(out, format, arguments);
    va_end(arguments);
}

/* ---- How a place in the file is named, and which rules its owner switched off there. */

void norma_check_silence(uint8_t mask[CHECK_RULE_COUNT], const char *ignore) {
    uint8_t silenced[CHECK_RULE_COUNT] = {0};
    char word[64];
    while (ignore && *ignore) {
        size_t length = strcspn(ignore, ",");
        if (length < sizeof word) {
            memcpy(word, ignore, length);
            word[length] = 0;
            (void)norma_rules_select(word, silenced, NULL);
        }
        ignore += length + (ignore[length] != 0);
    }
    for (size_t i = 0; i < CHECK_RULE_COUNT; ++i)
        if (silenced[i]) mask[i] = 0;
}

void norma_check_label(const norma_mesh_info *info, char label[CHECK_MESSAGE]) {
    const char *name = info->name ? info->name : "";
    label[0] = 0;
    if (info->where && *info->where)
        norma_check_message(label, *name ? "mesh %z primitive %z \"%s\"" : "mesh %z primitive %z",
            info->mesh, info->primitive, name);
}

int norma_check_siblings(const norma_mesh_info *first, const norma_mesh_info *second) {
    return first->mesh == second->mesh && second->primitive > first->primitive;
}

void *norma_check_grow(void *block, size_t count, size_t *room, size_t size) {
    if (count < *room) return block;
    const size_t more = *room ? 2 * *room : 8;
    void *grown = more > SIZE_MAX / size ? NULL : realloc(block, more * size);
    if (grown) *room = more;
    return grown;
}

/* ---- gathering */

static int is_worse(const check_hits *hits, double value) {
    return hits->least ? value < hits->worst : value > hits->worst;
}

static void keep_sample(const check_run *run, check_hits *hits, check_spot spot) {
    if (hits->sample_count >= run->options.max_samples ||
        (spot.vertex == SIZE_MAX && spot.face == SIZE_MAX && spot.normal == SIZE_MAX))
        return;
    check_spot *samples =
        norma_check_grow(hits->samples, hits->sample_count, &hits->sample_room, sizeof *samples);
    if (!samples) {
        hits->failed = 1;
        return;
    }
    hits->samples = samples;
    hits->samples[hits->sample_count++] = spot;
}

static void keep_worst(check_hits *hits, double value, check_spot spot) {
    if (hits->count == 0 || is_worse(hits, value) || (isnan(hits->worst) && !isnan(value))) {
        hits->worst = value;
        hits->worst_spot = spot;
    }
}

static check_spot spot_in_file(const check_part *part, check_spot spot) {
    if (spot.vertex != SIZE_MAX)
        spot.vertex =
            part->vertices ? part->vertices[spot.vertex] : part->first_vertex + spot.vertex;
    if (spot.face != SIZE_MAX) spot.face += part->first_face;
    return spot;
}

void norma_check_hit(const check_run *run, check_hits *hits, double value, check_spot spot) {
    if (run->part) spot = spot_in_file(run->part, spot);
    keep_worst(hits, value, spot);
    ++hits->count;
    keep_sample(run, hits, spot);
}

void norma_check_hit_greatest(
    const check_mesh *m, check_hits *hits, double degrees, size_t corner) {
    const double least_shown = 0.01;
    norma_check_hit(m->run, hits, degrees,
        corner < m->mesh.corner_count && degrees >= least_shown
            ? norma_check_vertex(norma_core_corner(&m->mesh, corner))
            : CHECK_NOWHERE);
}

void norma_check_also(const check_run *run, check_hits *hits, check_spot spot) {
    keep_sample(run, hits, run->part ? spot_in_file(run->part, spot) : spot);
}

void norma_check_hits_merge(const check_run *run, check_hits *into, check_hits *from) {
    if (from->count) {
        keep_worst(into, from->worst, from->worst_spot);
        into->count += from->count;
        for (size_t i = 0; i < from->sample_count; ++i) keep_sample(run, into, from->samples[i]);
    }
    into->failed |= from->failed;
    norma_check_hits_free(from);
}

void norma_check_hits_free(check_hits *hits) {
    int least = hits->least;
    free(hits->samples);
    *hits = (check_hits){.least = least};
}

/* ---- adding */

static char *copy_text(const char *from) {
    size_t size = strlen(from) + 1;
    char *copy = malloc(size);
    return copy ? memcpy(copy, from, size) : NULL;
}

static findings_entry *new_entry(norma_findings *findings) {
    findings_entry *entries =
        norma_check_grow(findings->entries, findings->count, &findings->room, sizeof *entries);
    if (!entries) return NULL;
    findings->entries = entries;
    findings->entries[findings->count] = (findings_entry){.number = findings->count};
    return &findings->entries[findings->count];
}

static void free_finding(norma_finding *finding) {
    free((void *)(uintptr_t)finding->where);
    free((void *)(uintptr_t)finding->label);
    free((void *)(uintptr_t)finding->message);
    free((void *)(uintptr_t)finding->samples);
    free((void *)(uintptr_t)finding->deviation);
}

static int position_of_face(const core_mesh *mesh, size_t face, double position[3]) {
    size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    for (int k = 0; k < 3; ++k) position[k] = 0;
    for (size_t c = begin; c < end; ++c) {
        double p[3];
        norma_view_read(&mesh->positions, norma_core_corner(mesh, c), p);
        for (int k = 0; k < 3; ++k) position[k] += p[k] / (double)(end - begin);
    }
    return end > begin;
}

static norma_sample sample_of(const check_mesh *m, check_spot spot) {
    norma_sample sample = {.vertex = spot.vertex, .face = spot.face, .normal = spot.normal};
    if (!m || m->in_parts) return sample;
    if (spot.vertex < m->mesh.positions.count) {
        norma_view_read(&m->mesh.positions, spot.vertex, sample.position);
        sample.has_position = 1;
    } else if (spot.face < m->mesh.face_count) {
        sample.has_position = position_of_face(&m->mesh, spot.face, sample.position);
    }
    sample.has_position = sample.has_position && norma_core_finite(sample.position);
    if (!sample.has_position) memset(sample.position, 0, sizeof sample.position);
    return sample;
}

static const norma_deviation *copy_deviation(const norma_deviation *deviation) {
    norma_deviation *copy = malloc(sizeof *copy);
    if (copy) *copy = *deviation;
    return copy;
}

/* What may be meant (information) stays what it is. */
static norma_severity raised_severity(const check_run *run, const check_finding *report) {
    const int raised = run->findings->profile == NORMA_CHECK_PROFILE_GENERATED &&
                       report->severity == NORMA_SEVERITY_WARNING &&
                       norma_check_is_required(&norma_rules(NULL)[report->rule]);
    return raised ? NORMA_SEVERITY_ERROR : report->severity;
}

int norma_findings_copy(norma_findings *findings, const norma_finding *finding, size_t order) {
    findings_entry *entry = new_entry(findings);
    norma_sample *samples = malloc((finding->sample_count + 1) * sizeof *samples);
    if (!entry || !samples) {
        free(samples);
        return 0;
    }
    if (finding->sample_count)
        memcpy(samples, finding->samples, finding->sample_count * sizeof *samples);
    norma_finding *copy = &entry->finding;
    *copy = *finding;
    copy->where = copy_text(finding->where);
    copy->label = copy_text(finding->label);
    copy->message = copy_text(finding->message);
    copy->samples = samples;
    copy->deviation = finding->deviation ? copy_deviation(finding->deviation) : NULL;
    const int complete =
        copy->where && copy->label && copy->message && !finding->deviation == !copy->deviation;
    if (!complete) free_finding(copy);
    entry->order = order;
    findings->count += (size_t)complete;
    return complete;
}

/* mesh may be NULL: samples then have no positions. */
static int copy_finding(const check_run *run, const check_place *place, const check_mesh *mesh,
    const check_finding *report) {
    const check_hits *hits = report->hits;
    const norma_rule *rule = &norma_rules(NULL)[report->rule];
    norma_sample *samples = malloc((hits->sample_count + 1) * sizeof *samples);
    for (size_t i = 0; samples && i < hits->sample_count; ++i)
        samples[i] = sample_of(mesh, hits->samples[i]);
    const norma_finding finding = {
        .rule = rule,
        .severity = raised_severity(run, report),
        .where = place->where,
        .label = place->label,
        .count = hits->count,
        .worst_value = report->no_value ? NAN : hits->worst,
        .unit = report->unit ? report->unit : "",
        .worst = sample_of(mesh, hits->worst_spot),
        .samples = samples,
        .sample_count = hits->sample_count,
        .message = report->message,
        .fix = report->no_fix          ? NORMA_FIX_NONE
               : report->fix_is_unsafe ? NORMA_FIX_UNSAFE
                                       : rule->fix,
        .deviation = report->deviation,
    };
    const int is_copied = samples && norma_findings_copy(run->findings, &finding, place->order);
    free(samples);
    return is_copied;
}

static norma_result add_finding(
    check_run *run, const check_place *place, const check_mesh *mesh, check_finding *report) {
    const check_hits *hits = report->hits;
    const int is_added = !hits->failed && hits->count && copy_finding(run, place, mesh, report);
    const norma_result result =
        is_added || (!hits->failed && !hits->count) ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (is_added && report->rule == RULE_N002) norma_check_partly(run);
    norma_check_hits_free(report->hits);
    return result;
}

norma_result norma_check_add(check_run *run, const check_place *place, check_finding *report) {
    return add_finding(run, place, NULL, report);
}

static norma_result add_to_mesh(
    check_mesh *m, check_finding *report, const char *format, va_list arguments) {
    char message[CHECK_MESSAGE], label[CHECK_MESSAGE];
    const norma_mesh_info *info = &m->given->info;
    write_message(message, format, arguments);
    norma_check_label(info, label);
    report->message = message;
    const check_place place = {m->order, info->where ? info->where : "", label};
    return add_finding(m->run, &place, m, report);
}

norma_result norma_check_report(check_mesh *m, check_finding *report, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const norma_result result = add_to_mesh(m, report, format, arguments);
    va_end(arguments);
    return result;
}

static check_hits one_hit(const check_run *run, double value) {
    check_hits hits = {0};
    norma_check_hit(run, &hits, value, CHECK_NOWHERE);
    return hits;
}

norma_result norma_check_report_one(check_mesh *m, check_rule rule, norma_severity severity,
    double degrees, const char *format, ...) {
    check_hits hits = one_hit(m->run, degrees);
    check_finding report = {.rule = rule,
        .severity = severity,
        .unit = isnan(degrees) ? "" : "deg",
        .no_value = isnan(degrees),
        .hits = &hits};
    va_list arguments;
    va_start(arguments, format);
    const norma_result result = add_to_mesh(m, &report, format, arguments);
    va_end(arguments);
    return result;
}

norma_result norma_check_add_one(check_run *run, const check_place *place, check_rule rule,
    norma_severity severity, const char *message) {
    check_hits hits = one_hit(run, 0);
    return norma_check_add(run, place,
        &(check_finding){
            .rule = rule, .severity = severity, .no_value = 1, .hits = &hits, .message = message});
}

void norma_check_partly(check_run *run) { run->findings->partly = 1; }

/* ---- the whole */

norma_findings *norma_findings_new(norma_check_profile profile) {
    norma_findings *findings = malloc(sizeof *findings);
    if (findings) *findings = (norma_findings){.profile = profile};
    return findings;
}

static int by_place(const void *first, const void *second) {
    const findings_entry *a = first, *b = second;
    if (a->order != b->order) return a->order < b->order ? -1 : 1;
    if (a->finding.rule != b->finding.rule) return a->finding.rule < b->finding.rule ? -1 : 1;
    if (a->finding.severity != b->finding.severity)
        return a->finding.severity > b->finding.severity ? -1 : 1;
    return a->number < b->number ? -1 : a->number > b->number;
}

void norma_findings_sort(norma_findings *findings) {
    if (findings->count)
        qsort(findings->entries, findings->count, sizeof *findings->entries, by_place);
}

/* ---- found again by their places */

static int compare_places(const void *a, const void *b) {
    const norma_finding *const *p = a, *const *q = b;
    const int order = strcmp((*p)->where, (*q)->where);
    return order ? order : (*p > *q) - (*p < *q);
}

int norma_places_gather(check_places *places, const norma_findings *findings,
    check_is_place *is_place, const void *context) {
    const size_t count = norma_findings_count(findings);
    *places = (check_places){calloc(count + 1, sizeof *places->findings), 0};
    for (size_t i = 0; places->findings && i < count; ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        if (!is_place || is_place(context, finding)) places->findings[places->count++] = finding;
    }
    if (places->count)
        qsort(places->findings, places->count, sizeof *places->findings, compare_places);
    return places->findings != NULL;
}

typedef struct wanted_place {
    const check_places *places;
    const char *where;
} wanted_place;

static int stands_before(const void *context, size_t i) {
    const wanted_place *wanted = context;
    return strcmp(wanted->places->findings[i]->where, wanted->where) < 0;
}

const norma_finding **norma_places_find(
    const check_places *places, const char *where, size_t *count) {
    const size_t begin =
        norma_core_bisect(places->count, stands_before, &(wanted_place){places, where});
    size_t end = begin;
    while (end < places->count && strcmp(places->findings[end]->where, where) == 0) ++end;
    *count = end - begin;
    return places->findings + begin;
}

const norma_deviation *norma_places_deviation(const check_places *places, const char *where) {
    size_t count = 0;
    const norma_finding **found = places ? norma_places_find(places, where, &count) : NULL;
    for (size_t i = 0; i < count; ++i)
        if (found[i]->deviation) return found[i]->deviation;
    return NULL;
}

static norma_document_result locate_sample(
    norma_sample *sample, check_locate *locate, void *context) {
    if (sample->vertex == SIZE_MAX && sample->face == SIZE_MAX) return NORMA_DOCUMENT_OK;
    const norma_document_result result = locate(context, sample);
    sample->has_position = !result && norma_core_finite(sample->position);
    if (!sample->has_position) memset(sample->position, 0, sizeof sample->position);
    return result;
}

norma_document_result norma_findings_locate(
    norma_findings *findings, check_locate *locate, void *context) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < findings->count && !result; ++i) {
        norma_finding *finding = &findings->entries[i].finding;
        norma_sample *samples = (norma_sample *)(uintptr_t)finding->samples;
        result = locate_sample(&finding->worst, locate, context);
        for (size_t k = 0; k < finding->sample_count && !result; ++k)
            result = locate_sample(&samples[k], locate, context);
    }
    return result;
}

size_t norma_findings_count(const norma_findings *findings) {
    return findings ? findings->count : 0;
}
const norma_finding *norma_findings_get(const norma_findings *findings, size_t index) {
    return findings && index < findings->count ? &findings->entries[index].finding : NULL;
}
norma_finding *norma_findings_change(norma_findings *findings, size_t index) {
    return &findings->entries[index].finding;
}
int norma_finding_withdraw(norma_finding *finding, const char *message) {
    char *copy = copy_text(message);
    if (!copy) return 0;
    free((void *)(uintptr_t)finding->message);
    finding->message = copy;
    finding->fix = NORMA_FIX_NONE;
    return 1;
}
norma_check_profile norma_findings_profile(const norma_findings *findings) {
    return findings ? findings->profile : NORMA_CHECK_PROFILE_AUTO;
}
int norma_findings_partly(const norma_findings *findings) { return findings && findings->partly; }

void norma_findings_free(norma_findings *findings) {
    if (!findings) return;
    for (size_t i = 0; i < findings->count; ++i) free_finding(&findings->entries[i].finding);
    free(findings->entries);
    free(findings);
}
