/* fix.c: norma_fix_document: a plan for what the rules found is tried on a copy of the document,
 * step by step, until nothing more is to be done, and then carried out, if by all rules the copy is
 * no worse than the document was. Where it is, each rule's fix is tried in turn with those that did
 * no harm before it: the ones that harm are left out, first at the meshes that suffer, then
 * everywhere. */
#include "check/fix/fix_trial.h"
#include "io/format/for_fixes.h"
#include <stdlib.h>
#include <string.h>

typedef struct harm { /* why the fix of a rule was left out */
    uint8_t by[CHECK_RULE_COUNT];
    int loose; /* edges came open */
} harm;

typedef struct fixing {
    norma_document *document;
    fix_request request;
    fix_left_out *places; /* the request's */
    size_t place_room;
    harm *harms; /* of each rule */
    fix_measure before;
    fix_trial best; /* whose plans do no harm; count 0: none yet */
    norma_fix_summary *summary;
    norma_document_error *error;
} fixing;

static norma_document_result fail_memory(const fixing *f) {
    if (f->error) *f->error = (norma_document_error){NORMA_DOCUMENT_ERROR_MEMORY, "out of memory"};
    return NORMA_DOCUMENT_ERROR_MEMORY;
}

/* ---- progress: several passes, of which each has half of what is left; it never falls */

typedef struct fix_progress {
    norma_progress *progress;
    void *user;
    double done, last;
} fix_progress;

static int report_progress(void *user, double fraction) {
    fix_progress *p = user;
    const double whole = p->done + (1 - p->done) / 2 * fraction;
    if (whole < p->last) p->done = p->last; /* the next pass has begun */
    p->last = whole > p->last ? whole : p->last;
    return p->progress(p->user, p->last);
}

/* ---- trials */

/* trial: to be freed in any case. harmful: by what it is worse, if it is. */
static norma_document_result try_request(
    fixing *f, fix_trial *trial, harm *harmful, int *is_worse) {
    fix_plan plan;
    *trial = (fix_trial){0};
    *harmful = (harm){0};
    *is_worse = 0;
    norma_document_result result = norma_fix_make_plan(f->document, &f->request, &plan, f->error);
    if (result) return result;
    if (norma_fix_plan_is_empty(&plan)) {
        trial->plans[trial->count++] = plan;
        return result;
    }
    f->request.changes_maps |= plan.greens != NULL;
    if (!f->before.findings)
        result = norma_fix_measure(f->document, &f->request, &f->before, f->error);
    if (result) {
        norma_fix_plan_free(&plan);
        return result;
    }
    result = norma_fix_try(f->document, &f->request, &plan, trial, f->error);
    if (!result) *is_worse = norma_fix_find_worse(&f->before, &trial->after, harmful->by);
    harmful->loose = !result && trial->after.loose > f->before.loose;
    return result;
}

static void keep_trial(fixing *f, fix_trial *trial) {
    norma_fix_trial_free(&f->best);
    f->best = *trial;
    *trial = (fix_trial){0};
}

/* ---- what harms is left out */

static size_t count_at(const norma_findings *findings, const norma_rule *rule, const char *where) {
    size_t sum = 0;
    for (size_t i = 0; i < norma_findings_count(findings); i++) {
        const norma_finding *finding = norma_findings_get(findings, i);
        if (finding->rule == rule && finding->severity >= NORMA_SEVERITY_WARNING &&
            strcmp(finding->where, where) == 0)
            sum += finding->count;
    }
    return sum;
}

static int leave_out_at(fixing *f, check_rule rule, const char *where) {
    for (size_t i = 0; i < f->request.place_count; i++)
        if (f->places[i].rule == rule && strcmp(f->places[i].where, where) == 0) return 1;
    if (f->request.place_count == f->place_room) {
        const size_t room = 2 * f->place_room + 8;
        fix_left_out *grown = realloc(f->places, room * sizeof *grown);
        if (!grown) return 0;
        f->places = grown;
        f->place_room = room;
        f->request.places = grown;
    }
    const size_t size = strlen(where) + 1;
    char *copy = malloc(size);
    if (!copy) return 0;
    memcpy(copy, where, size);
    f->places[f->request.place_count++] = (fix_left_out){rule, copy};
    return 1;
}

static void forget_places(fixing *f, size_t count) {
    while (f->request.place_count > count) free(f->places[--f->request.place_count].where);
}

/* Leaves the rule out at the places where others report more. Returns how many those are; 0: out of
 * memory, or the harm has no place of its own. */
static size_t leave_out_where_worse(
    fixing *f, check_rule rule, const fix_trial *trial, const harm *harmful) {
    const size_t places = f->request.place_count;
    size_t count;
    for (size_t i = 0; i < norma_findings_count(trial->after.findings); i++) {
        const norma_finding *finding = norma_findings_get(trial->after.findings, i);
        if (!harmful->by[finding->rule - norma_rules(&count)] || !finding->where[0] ||
            count_at(trial->after.findings, finding->rule, finding->where) <=
                count_at(f->before.findings, finding->rule, finding->where))
            continue;
        if (!leave_out_at(f, rule, finding->where)) {
            forget_places(f, places);
            return 0;
        }
    }
    return f->request.place_count - places;
}

/* With the fixes that did no harm, and this one. */
static norma_document_result try_rule(fixing *f, check_rule rule) {
    fix_trial trial;
    harm harmful;
    int worse;
    const size_t places = f->request.place_count;
    f->request.left_out[rule] = 0;
    norma_document_result result = try_request(f, &trial, &harmful, &worse);
    if (!result && worse) {
        f->harms[rule] = harmful;
        if (leave_out_where_worse(f, rule, &trial, &harmful)) {
            norma_fix_trial_free(&trial);
            result = try_request(f, &trial, &harmful, &worse);
        }
    }
    if (!result && !worse) {
        keep_trial(f, &trial);
    } else {
        f->request.left_out[rule] = 1;
        forget_places(f, places);
    }
    norma_fix_trial_free(&trial);
    return result;
}

static norma_document_result leave_out_harmful(fixing *f, const uint8_t *asked) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t rule = 0; rule < CHECK_RULE_COUNT; rule++) f->request.left_out[rule] = asked[rule];
    for (size_t rule = 0; rule < CHECK_RULE_COUNT && !result; rule++)
        if (asked[rule]) result = try_rule(f, (check_rule)rule);
    return result;
}

/* All fixes at once first: they seldom harm. */
static norma_document_result find_fixes(fixing *f) {
    fix_trial trial;
    harm harmful;
    int worse;
    uint8_t asked[CHECK_RULE_COUNT] = {0};
    norma_document_result result = try_request(f, &trial, &harmful, &worse);
    for (size_t i = 0; i < trial.count; i++)
        for (size_t rule = 0; rule < CHECK_RULE_COUNT; rule++)
            asked[rule] |= trial.plans[i].asked[rule];
    if (!result && !worse) keep_trial(f, &trial);
    norma_fix_trial_free(&trial);
    return !result && worse ? leave_out_harmful(f, asked) : result;
}

/* ---- what was found is done, and said */

static void note_harm(fixing *f, check_rule rule, const char *where) {
    char text[CHECK_MESSAGE], by[CHECK_MESSAGE] = "";
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    for (size_t i = 0; i < CHECK_RULE_COUNT; i++)
        if (f->harms[rule].by[i]) {
            norma_check_message(
                text, "%s%s%s %s", by, by[0] ? ", " : "", rules[i].id, rules[i].name);
            memcpy(by, text, sizeof by);
        }
    if (f->harms[rule].loose && !by[0])
        norma_check_message(by, "closed edges would become open");
    else if (by[0]) {
        norma_check_message(text, "%s would report more than before", by);
        memcpy(by, text, sizeof by);
    }
    norma_check_message(text, where ? "%s %s is not fixed at %s: %s" : "%s %s is not fixed%s: %s",
        rules[rule].id, rules[rule].name, where ? where : "", by);
    norma_document_add_note(f->document, "%s", text);
    f->summary->left_out++;
}

static void note_left_out(fixing *f) {
    for (size_t i = 0; i < f->request.place_count; i++)
        note_harm(f, f->places[i].rule, f->places[i].where);
    for (size_t rule = 0; rule < CHECK_RULE_COUNT; rule++)
        if (f->request.left_out[rule]) note_harm(f, (check_rule)rule, NULL);
}

/* ---- fixes that changed nothing */

static size_t count_of(const norma_findings *findings, const norma_rule *rule) {
    size_t sum = 0;
    for (size_t i = 0; i < norma_findings_count(findings); i++) {
        const norma_finding *finding = norma_findings_get(findings, i);
        if (finding->rule == rule && finding->fix != NORMA_FIX_NONE) sum += finding->count;
    }
    return sum;
}

/* Whether some note tells already why. */
static int is_told(const fixing *f, const norma_rule *rule) {
    for (size_t i = 0; i < f->request.place_count; i++)
        if (&norma_rules(NULL)[f->places[i].rule] == rule) return 1;
    for (size_t i = 0; i < f->best.count; i++)
        for (size_t k = 0; k < f->best.plans[i].note_count; k++)
            if (strstr(f->best.plans[i].notes[k], rule->id)) return 1;
    for (size_t i = 0; i < norma_document_note_count(f->document); i++)
        if (strstr(norma_document_note(f->document, i), rule->id)) return 1;
    return 0;
}

static const char *why_idle(check_rule rule) {
    return rule == RULE_N502 ? "no two of its corners are equal in all attributes"
           : rule == RULE_N701
               ? "the mesh is as large as its distance from the origin, so moving it does not help"
           : rule == RULE_N201 || rule == RULE_N202 || rule == RULE_N206
               ? "no normal at these vertices would fix it: the faces at them face opposite ways, "
                 "are degenerate, or occur twice"
               : "no change that this fix can make would help";
}

static void note_idle(fixing *f, const uint8_t *asked) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    for (size_t rule = 0; rule < CHECK_RULE_COUNT; rule++) {
        char text[CHECK_MESSAGE];
        const size_t after = count_of(f->best.after.findings, &rules[rule]);
        if (!asked[rule] || rule == RULE_N304 || /* of it by_rays tells */
            f->request.left_out[rule] || is_told(f, &rules[rule]) ||
            (f->best.after.findings && after < count_of(f->before.findings, &rules[rule])))
            continue;
        norma_check_message(text, "%s %s is not fixed: %s", rules[rule].id, rules[rule].name,
            why_idle((check_rule)rule));
        norma_document_add_note(f->document, "%s", text);
        f->summary->left_out++;
    }
}

static norma_document_result carry_out(fixing *f) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    const fix_trial *best = &f->best;
    for (size_t i = 0; i < best->count && !result; i++)
        result = norma_fix_apply(f->document, &best->plans[i], f->request.options.threads,
            &f->summary->changed, f->error);
    if (result) return result;
    if (best->count) {
        const fix_plan *last = &best->plans[best->count - 1], *first = &best->plans[0];
        for (size_t i = 0; i < last->note_count; i++)
            norma_document_add_note(f->document, "%s", last->notes[i]);
        f->summary->by_rays = first->by_rays;
        f->summary->undecided = first->undecided;
        f->summary->least_confidence = first->least_confidence;
    }
    note_left_out(f);
    if (best->count) note_idle(f, best->plans[0].asked);
    return result;
}

norma_document_result norma_fix_document(norma_document *document,
    const norma_check_options *options, int unsafe, norma_fix_summary *summary,
    norma_document_error *error) {
    norma_fix_summary unwanted;
    fix_progress progress = {0};
    fixing f = {.document = document,
        .request.unsafe = unsafe,
        .summary = summary ? summary : &unwanted,
        .error = error};
    *f.summary = (norma_fix_summary){0};
    if (options) f.request.options = *options;
    f.request.options.struct_size = sizeof f.request.options;
    f.request.options.max_samples = SIZE_MAX; /* every element is wanted */
    f.request.by_rays = f.request.options.open_by_rays;
    if (f.request.options.progress) {
        progress =
            (fix_progress){f.request.options.progress, f.request.options.progress_user, 0, 0};
        f.request.options.progress = report_progress;
        f.request.options.progress_user = &progress;
    }
    f.harms = calloc(CHECK_RULE_COUNT, sizeof *f.harms);
    norma_document_result result = f.harms ? find_fixes(&f) : fail_memory(&f);
    if (!result) result = carry_out(&f);
    forget_places(&f, 0);
    free(f.places);
    free(f.harms);
    norma_fix_trial_free(&f.best);
    norma_fix_measure_free(&f.before);
    return result;
}
