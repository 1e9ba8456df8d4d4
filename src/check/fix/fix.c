/* fix.c: norma_fix_document: a plan for what the rules found is tried on a copy of the document,
 * step by step, until nothing more is to be done, and then carried out, if by all rules the copy is
 * no worse than the document was. Where it is, the rules' fixes are halved until those that harm
 * stand alone: they are left out, first at the meshes that suffer, then everywhere.
 * norma_document_try_fixes: the same trial, of each rule by itself, for the fixes that findings
 * offer. */
#include "check/fix/fix.h"
#include "io/format/for_fixes.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Trials end after so many checks: what is not tried by then is left out, and told. */
enum { MOST_CHECKS = 40 };
enum { MOST_OFFER_CHECKS = 20 }; /* of all that a file's findings offer */

typedef struct harm { /* why the fix of a rule was left out */
    uint8_t by[CHECK_RULE_COUNT];
    const char *shape; /* what else became worse; NULL: nothing */
    int untried;       /* there was no time to find out */
} harm;

typedef struct fixing {
    norma_document *document;
    fix_request request;
    fix_left_out *places; /* the request's */
    size_t place_room;
    harm *harms;                     /* of each rule */
    size_t judge_count;              /* of the request's */
    norma_findings *given;           /* what a check found in the document; NULL: not known */
    uint8_t again[CHECK_RULE_COUNT]; /* of which the given findings do not have every element */
    fix_measure before;
    fix_trial best; /* whose plans do no harm; count 0: none yet */
    size_t checks;  /* so far */
    norma_fix_summary *summary;
    norma_document_error *error;
} fixing;

static norma_document_result fail_memory(norma_document_error *error) {
    if (error) *error = (norma_document_error){NORMA_DOCUMENT_ERROR_MEMORY, "out of memory"};
    return NORMA_DOCUMENT_ERROR_MEMORY;
}

/* ---- progress: several passes, of which each has half of what is left; it never falls */

typedef struct fix_progress {
    norma_progress *progress;
    void *user;
    double done, last;
} fix_progress;

static int report_fix_progress(void *user, double fraction) {
    fix_progress *p = user;
    const double whole = p->done + (1 - p->done) / 2 * fraction;
    if (whole < p->last) p->done = p->last; /* the next pass has begun */
    p->last = whole > p->last ? whole : p->last;
    return p->progress(p->user, p->last);
}

/* ---- beginning and end */

/* wanted: a byte for each rule; NULL: all. progress: made by the caller. */
static norma_document_result begin_fixing(
    fixing *f, const norma_check_options *options, const uint8_t *wanted, fix_progress *progress) {
    norma_check_options *own = &f->request.options;
    const norma_result result = norma_check_take_options(options, own);
    if (result) return norma_check_fail(f->error, result);
    own->struct_size = sizeof *own;
    own->max_samples = SIZE_MAX; /* every element is wanted */
    own->rules = NULL;
    for (size_t rule = 0; rule < CHECK_RULE_COUNT; ++rule)
        f->request.wanted[rule] = !wanted || wanted[rule];
    f->request.by_rays = own->open_by_rays;
    f->request.from = own->fix_from;
    if (own->progress) {
        *progress = (fix_progress){own->progress, own->progress_user, 0, 0};
        own->progress = report_fix_progress;
        own->progress_user = progress;
    }
    f->harms = calloc(CHECK_RULE_COUNT, sizeof *f->harms);
    f->judge_count = norma_document_mesh_count(f->document);
    f->request.judges = calloc(f->judge_count + 1, sizeof *f->request.judges);
    return f->harms && f->request.judges ? NORMA_DOCUMENT_OK : fail_memory(f->error);
}

static void forget_places(fixing *f, check_rule rule) {
    size_t kept = 0;
    for (size_t i = 0; i < f->request.place_count; ++i)
        if (f->places[i].rule == rule)
            free(f->places[i].where);
        else
            f->places[kept++] = f->places[i];
    f->request.place_count = kept;
}

static void end_fixing(fixing *f) {
    for (size_t i = 0; i < f->request.place_count; ++i) free(f->places[i].where);
    free(f->places);
    free(f->harms);
    for (size_t i = 0; f->request.judges && i < f->judge_count; ++i)
        norma_check_close_judge(&f->request.judges[i]);
    free(f->request.judges);
    norma_findings_free(f->given);
    norma_fix_trial_free(&f->best);
    norma_fix_measure_free(&f->before);
}

/* ---- trials */

/* Every element that any rule finds, once: plans are made of it, and trials compared with it. */
static norma_document_result look_once(fixing *f) {
    const check_known known = {f->document, f->given, f->again, f->request.judges, 0};
    if (f->before.findings) return NORMA_DOCUMENT_OK;
    ++f->checks;
    return norma_fix_find(f->document, &f->request, f->request.reads_maps, f->given ? &known : NULL,
        &f->before.findings, f->error);
}

/* trial: to be freed in any case. harmful: by what it is worse, if it is. */
static norma_document_result try_request(
    fixing *f, fix_trial *trial, harm *harmful, int *is_worse) {
    fix_plan plan;
    *trial = (fix_trial){0};
    *harmful = (harm){0};
    *is_worse = 0;
    norma_document_result result = look_once(f);
    if (!result)
        result = norma_fix_make_plan(f->document, &f->request, f->before.findings, &plan, f->error);
    if (result) return result;
    if (norma_fix_plan_is_empty(&plan)) {
        trial->plans[trial->count++] = plan;
        return result;
    }
    f->request.changes_maps |= plan.greens != NULL;
    if (!f->before.has_shape)
        result = norma_fix_measure_shape(f->document, &f->request, &f->before, f->error);
    if (result) {
        norma_fix_plan_free(&plan);
        return result;
    }
    const check_known known = {f->document, f->before.findings, NULL, f->request.judges, 1};
    result = norma_fix_try(&known, &f->request, &plan, trial, f->error);
    f->checks += trial->count;
    if (!result) *is_worse = norma_fix_find_worse(&f->before, &trial->after, harmful->by);
    if (!result) harmful->shape = norma_fix_worse_shape(&f->before, &trial->after);
    return result;
}

static void keep_trial(fixing *f, fix_trial *trial) {
    norma_fix_trial_free(&f->best);
    f->best = *trial;
    *trial = (fix_trial){0};
}

/* ---- what harms is left out */

/* What one rule finds at one mesh or node: sums of its findings. */
typedef struct place_count {
    size_t all, fixable, serious;
} place_count;

static place_count count_at(const check_places *places, const norma_finding *like) {
    place_count sum = {0};
    size_t count;
    const norma_finding **found = norma_places_find(places, like->where, &count);
    for (size_t i = 0; i < count; ++i) {
        if (found[i]->rule != like->rule) continue;
        sum.all += found[i]->count;
        sum.fixable += found[i]->fix != NORMA_FIX_NONE ? found[i]->count : 0;
        sum.serious += found[i]->severity >= NORMA_SEVERITY_WARNING ? found[i]->count : 0;
    }
    return sum;
}

static int add_place(fixing *f, check_rule rule, const char *where) {
    fix_left_out *grown =
        norma_check_grow(f->places, f->request.place_count, &f->place_room, sizeof *grown);
    if (!grown) return 0;
    f->places = grown;
    f->request.places = grown;
    const size_t size = strlen(where) + 1;
    char *copy = malloc(size);
    if (!copy) return 0;
    memcpy(copy, where, size);
    f->places[f->request.place_count++] = (fix_left_out){rule, copy};
    return 1;
}

/* Those at which others report more than before. 0: out of memory, or there is none. */
static int add_worse_places(fixing *f, check_rule rule, const check_places *before,
    const check_places *after, const harm *harmful) {
    const size_t places = f->request.place_count;
    for (size_t i = 0; i < after->count; ++i) {
        const norma_finding *finding = after->findings[i];
        if (harmful->by[finding->rule - norma_rules(NULL)] && finding->where[0] &&
            count_at(after, finding).serious > count_at(before, finding).serious &&
            !add_place(f, rule, finding->where))
            return 0;
    }
    return f->request.place_count > places;
}

/* Leaves the rule, which is left out nowhere, out at the places where others report more. 0: out of
 * memory, or the harm has no place of its own. */
static int leave_out_where_worse(
    fixing *f, check_rule rule, const fix_trial *trial, const harm *harmful) {
    check_places before = {0}, after = {0};
    int is_done = norma_places_gather(&before, f->before.findings, NULL, NULL) &&
                  norma_places_gather(&after, trial->after.findings, NULL, NULL) &&
                  add_worse_places(f, rule, &before, &after, harmful);
    free((void *)before.findings);
    free((void *)after.findings);
    f->request.place_count = norma_fix_sort_left_out(f->places, f->request.place_count);
    if (!is_done) forget_places(f, rule);
    return is_done;
}

/* The rule alone, of which harmful is known: at the places where it does no harm, or nowhere. */
static norma_document_result leave_out(
    fixing *f, check_rule rule, const fix_trial *failed, harm harmful) {
    fix_trial trial = {0};
    int worse = 1;
    norma_document_result result = NORMA_DOCUMENT_OK;
    f->harms[rule] = harmful;
    if (leave_out_where_worse(f, rule, failed, &harmful))
        result = try_request(f, &trial, &harmful, &worse);
    if (!result && !worse) {
        keep_trial(f, &trial);
    } else {
        f->request.left_out[rule] = 1;
        forget_places(f, rule);
    }
    norma_fix_trial_free(&trial);
    return result;
}

static void leave_out_untried(fixing *f, const check_rule *rules, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        f->request.left_out[rules[i]] = 1;
        f->harms[rules[i]].untried = 1;
    }
}

/* Those whose fixes its plans are; how many. */
static size_t list_asked(const fix_trial *trial, check_rule *rules) {
    size_t count = 0;
    for (size_t rule = 0; rule < CHECK_RULE_COUNT; ++rule) {
        int is_asked = 0;
        for (size_t i = 0; i < trial->count; ++i) is_asked |= trial->plans[i].asked[rule];
        if (is_asked) rules[count++] = (check_rule)rule;
    }
    return count;
}

/* These rules' fixes, which are left out at present, with those that did no harm. given NULL: all
 * at once, first: they seldom harm. */
static norma_document_result try_rules(fixing *f, const check_rule *given, size_t count) {
    fix_trial trial;
    harm harmful;
    int worse;
    check_rule rules[CHECK_RULE_COUNT];
    if (given && f->checks >= MOST_CHECKS)
        return leave_out_untried(f, given, count), NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < count; ++i) f->request.left_out[rules[i] = given[i]] = 0;
    norma_document_result result = try_request(f, &trial, &harmful, &worse);
    if (!given) count = list_asked(&trial, rules);
    if (!result && !worse)
        keep_trial(f, &trial);
    else if (!result && count == 1)
        result = leave_out(f, rules[0], &trial, harmful);
    norma_fix_trial_free(&trial);
    if (result || !worse || count < 2) return result;
    for (size_t i = 0; i < count; ++i) f->request.left_out[rules[i]] = 1;
    result = try_rules(f, rules, count / 2);
    return result ? result : try_rules(f, rules + count / 2, count - count / 2);
}

/* ---- why a fix was left out, or changed nothing */

static void describe_harm(const harm *h, char by[CHECK_MESSAGE]) {
    char text[CHECK_MESSAGE];
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    by[0] = '\0';
    if (h->untried) {
        norma_check_message(
            by, "to find out whether it does harm takes too long with all the others; select it");
        return;
    }
    for (size_t i = 0; i < CHECK_RULE_COUNT; ++i)
        if (h->by[i]) {
            norma_check_message(
                text, "%s%s%s %s", by, by[0] ? ", " : "", rules[i].id, rules[i].name);
            memcpy(by, text, sizeof text);
        }
    if (h->shape && !by[0])
        norma_check_message(by, "%s", h->shape);
    else if (by[0]) {
        norma_check_message(text, "%s would report more than before", by);
        memcpy(by, text, sizeof text);
    }
}

static const char *why_idle(check_rule rule) {
    return rule == RULE_N502 ? "no two of its corners are equal in all attributes"
           : rule == RULE_N701
               ? "the mesh is as large as its distance from the origin, so moving it does not help"
           : rule == RULE_N201 || rule == RULE_N202 || rule == RULE_N206
               ? "no normal at these vertices would fix it: the faces at them face opposite ways, "
                 "are degenerate or occur twice, or faces that are right use the same normal"
           : rule == RULE_N207 ? "its vertices belong to other primitives as well, which are "
                                 "shaded as they should be"
           : rule == RULE_N404 || rule == RULE_N405
               ? "a polygon that crosses itself has no inside that could be cut into triangles"
               : "no change that this fix can make would help";
}

/* What the plans say of it; NULL: nothing. */
static const fix_note *find_note(const fix_trial *trial, check_rule rule) {
    for (size_t i = 0; i < trial->count; ++i)
        for (size_t k = 0; k < trial->plans[i].note_count; ++k)
            if (trial->plans[i].notes[k].rules & FIX_RULE(rule)) return &trial->plans[i].notes[k];
    return NULL;
}

static int is_left_out(const fixing *f, check_rule rule) {
    int left_out = f->request.left_out[rule];
    for (size_t i = 0; i < f->request.place_count; ++i) left_out |= f->places[i].rule == rule;
    return left_out;
}

/* ---- what was found is done, and said */

static void note_harm(fixing *f, check_rule rule, const char *where) {
    char text[CHECK_MESSAGE], by[CHECK_MESSAGE];
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    describe_harm(&f->harms[rule], by);
    norma_check_message(text, where ? "%s %s is not fixed at %s: %s" : "%s %s is not fixed%s: %s",
        rules[rule].id, rules[rule].name, where ? where : "", by);
    norma_document_add_note(f->document, "%s", text);
    ++f->summary->left_out;
}

static void note_left_out(fixing *f) {
    for (size_t i = 0; i < f->request.place_count; ++i)
        note_harm(f, f->places[i].rule, f->places[i].where);
    for (size_t rule = 0; rule < CHECK_RULE_COUNT; ++rule)
        if (f->request.left_out[rule]) note_harm(f, (check_rule)rule, NULL);
}

static size_t count_fixable(const norma_findings *findings, const norma_rule *rule) {
    size_t sum = 0;
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        if (finding->rule == rule && finding->fix != NORMA_FIX_NONE) sum += finding->count;
    }
    return sum;
}

/* told: rules of which the document's format has said why. */
static void note_idle(fixing *f, const uint8_t *asked, uint64_t told) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    for (size_t rule = 0; rule < CHECK_RULE_COUNT; ++rule) {
        char text[CHECK_MESSAGE];
        const size_t after = count_fixable(f->best.after.findings, &rules[rule]);
        if (!asked[rule] || rule == RULE_N304 || /* of it by_rays tells */
            is_left_out(f, (check_rule)rule) || find_note(&f->best, (check_rule)rule) ||
            told & FIX_RULE(rule) ||
            (f->best.after.findings && after < count_fixable(f->before.findings, &rules[rule])))
            continue;
        norma_check_message(text, "%s %s is not fixed: %s", rules[rule].id, rules[rule].name,
            why_idle((check_rule)rule));
        norma_document_add_note(f->document, "%s", text);
        ++f->summary->left_out;
    }
}

static norma_document_result carry_out(fixing *f) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    const fix_trial *best = &f->best;
    uint64_t told = 0;
    for (size_t i = 0; i < best->count && !result; ++i) {
        const size_t notes = norma_document_note_count(f->document);
        result = norma_fix_apply(f->document, &best->plans[i], f->request.options.threads,
            &f->summary->changed, f->error);
        if (best->plans[i].greens && norma_document_note_count(f->document) > notes)
            told |= FIX_RULE(RULE_N812);
    }
    if (result) return result;
    if (best->count) {
        const fix_plan *last = &best->plans[best->count - 1], *first = &best->plans[0];
        for (size_t i = 0; i < last->note_count; ++i)
            norma_document_add_note(f->document, "%s", last->notes[i].text);
        if (first->by_rays &&
            (!f->summary->by_rays || first->least_confidence < f->summary->least_confidence))
            f->summary->least_confidence = first->least_confidence;
        f->summary->by_rays += first->by_rays;
        f->summary->undecided += first->undecided;
    }
    note_left_out(f);
    if (best->count) note_idle(f, best->plans[0].asked, told);
    return result;
}

static norma_document_result fix_one(fixing *f, const norma_check_options *options) {
    fix_progress progress;
    norma_document_result result =
        begin_fixing(f, options, options ? options->rules : NULL, &progress);
    f->request.reads_maps = f->request.unsafe && f->request.wanted[RULE_N812];
    if (!result) result = try_rules(f, NULL, 0);
    if (!result) result = carry_out(f);
    end_fixing(f);
    return result;
}

norma_document_result norma_fix_document(norma_document *document,
    const norma_check_options *options, int unsafe, norma_fix_summary *summary,
    norma_document_error *error) {
    norma_fix_summary unwanted;
    norma_document *tile;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!summary) summary = &unwanted;
    *summary = (norma_fix_summary){0};
    for (size_t i = 0; !result && (i == 0 || norma_document_tile(document, i)); ++i) {
        tile = norma_document_tile(document, i);
        fixing f = {.document = tile, .request.unsafe = unsafe, .summary = summary, .error = error};
        result = fix_one(&f, options);
    }
    norma_document_tiles_changed(document);
    return result;
}

/* ---- fixes that findings offer, tried */

static void describe_left(const fixing *f, check_rule rule, char why[CHECK_MESSAGE]) {
    const fix_note *note = find_note(&f->best, rule);
    if (is_left_out(f, rule))
        describe_harm(&f->harms[rule], why);
    else
        norma_check_message(why, "%s",
            note              ? note->why
            : f->best.said[0] ? f->best.said
                              : why_idle(rule));
}

/* What is not offered any more says why. 0: out of memory. */
static int judge_offer(const fixing *f, const check_places *before, const check_places *after,
    norma_finding *finding, check_rule rule) {
    const place_count was = count_at(before, finding);
    const size_t fixable = was.fixable, left = count_at(after, finding).all,
                 stays = fixable + left > was.all ? fixable + left - was.all : 0;
    char why[CHECK_MESSAGE], text[CHECK_MESSAGE];
    if (!stays) return 1;
    describe_left(f, rule, why);
    if (stays < fixable)
        norma_check_message(
            text, "%s; a fix leaves %z of %z: %s", finding->message, stays, fixable, why);
    else
        norma_check_message(text, "%s; no fix: %s", finding->message, why);
    return norma_finding_withdraw(finding, text);
}

static int judge_offers(const fixing *f, check_rule rule, norma_fix fix, norma_severity from,
    norma_findings *findings) {
    const norma_findings *left =
        f->best.after.findings ? f->best.after.findings : f->before.findings;
    check_places before = {0}, after = {0};
    int is_done = norma_places_gather(&before, f->before.findings, NULL, NULL) &&
                  norma_places_gather(&after, left, NULL, NULL);
    for (size_t i = 0; i < norma_findings_count(findings) && is_done; ++i) {
        norma_finding *finding = norma_findings_change(findings, i);
        if (norma_fix_is_rule(finding, rule) && finding->fix == fix && finding->severity >= from)
            is_done = judge_offer(f, &before, &after, finding, rule);
    }
    free((void *)before.findings);
    free((void *)after.findings);
    return is_done;
}

static norma_document_result try_offer(
    fixing *f, check_rule rule, norma_fix fix, norma_severity from, norma_findings *findings) {
    f->request.unsafe = fix == NORMA_FIX_UNSAFE;
    memset(f->request.wanted, 0, sizeof f->request.wanted);
    f->request.wanted[rule] = 1;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (f->checks < MOST_OFFER_CHECKS)
        result = try_rules(f, NULL, 0);
    else
        leave_out_untried(f, &rule, 1);
    if (result && result != NORMA_DOCUMENT_CANCELLED && result != NORMA_DOCUMENT_ERROR_MEMORY &&
        f->before.findings) {
        /* The command would fail in the same way. */
        norma_check_message(f->best.said, "it fails: %s", f->error->message);
        result = NORMA_DOCUMENT_OK;
    }
    if (!result && !judge_offers(f, rule, fix, from, findings)) result = fail_memory(f->error);
    forget_places(f, rule);
    f->request.left_out[rule] = 0;
    f->harms[rule].untried = 0;
    norma_fix_trial_free(&f->best);
    return result;
}

static int is_offered(
    const norma_findings *findings, check_rule rule, norma_fix fix, norma_severity from) {
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        if (norma_fix_is_rule(finding, rule) && finding->fix == fix && finding->severity >= from)
            return 1;
    }
    return 0;
}

/* Whether the check that made these findings asked for all that matters, as is asked now. */
static int is_known(const fixing *f, const norma_findings *findings) {
    const norma_check_options *now = &f->request.options, *then = &findings->options;
    int is_known = now->profile == then->profile && !now->strict == !then->strict;
    for (size_t rule = 0; rule < CHECK_RULE_COUNT; ++rule)
        is_known &= findings->rules[rule] || rule == RULE_N811 || rule == RULE_N812 ||
                    !norma_fix_is_weighed(&f->request, (check_rule)rule);
    return is_known;
}

/* What was found is not looked for again, but by rules that found more than they tell of and offer
 * a fix. */
static norma_document_result keep_given(
    fixing *f, norma_severity from, const norma_findings *findings) {
    if (!findings || !is_known(f, findings)) return NORMA_DOCUMENT_OK;
    norma_findings *given = norma_findings_new(findings->profile);
    uint8_t offered[CHECK_RULE_COUNT];
    f->given = given;
    for (size_t rule = 0; rule < CHECK_RULE_COUNT; ++rule)
        offered[rule] = (uint8_t)(is_offered(findings, (check_rule)rule, NORMA_FIX_SAFE, from) ||
                                  is_offered(findings, (check_rule)rule, NORMA_FIX_UNSAFE, from));
    for (size_t i = 0; given && i < findings->count; ++i) {
        const norma_finding *finding = &findings->entries[i].finding;
        const check_rule rule = (check_rule)(finding->rule - norma_rules(NULL));
        f->again[rule] |= finding->sample_count >= findings->options.max_samples && offered[rule];
        if (!norma_findings_copy(given, finding, findings->entries[i].order))
            return fail_memory(f->error);
    }
    return given ? NORMA_DOCUMENT_OK : fail_memory(f->error);
}

static norma_document_result try_fixes_of_one(norma_document *document,
    const norma_check_options *options, norma_severity from, norma_findings *findings,
    norma_document_error *error) {
    fix_progress progress;
    norma_fix_summary summary = {0};
    norma_document_error unwanted;
    fixing f = {.document = document, .summary = &summary, .error = error ? error : &unwanted};
    norma_document_result result = begin_fixing(&f, options, NULL, &progress);
    if (!result) result = keep_given(&f, from, findings);
    f.request.from = NORMA_SEVERITY_NONE; /* as if they were selected */
    f.request.reads_maps = is_offered(findings, RULE_N812, NORMA_FIX_UNSAFE, from);
    for (size_t rule = 0; rule < CHECK_RULE_COUNT; ++rule)
        for (int fix = NORMA_FIX_SAFE; fix <= NORMA_FIX_UNSAFE && !result; ++fix)
            if (is_offered(findings, (check_rule)rule, (norma_fix)fix, from))
                result = try_offer(&f, (check_rule)rule, (norma_fix)fix, from, findings);
    end_fixing(&f);
    return result;
}

/* Those of one model of a composite, as it says them itself; at: their numbers among all. */
static norma_findings *findings_of_tile(
    const norma_findings *findings, size_t tile, size_t *at, norma_document_error *error) {
    char begin[40];
    norma_findings *own = norma_findings_new(findings->profile);
    const int length = snprintf(begin, sizeof begin, "/tiles/%zu/", tile);
    size_t count = 0;
    if (own) {
        own->options = findings->options;
        memcpy(own->rules, findings->rules, sizeof own->rules);
    }
    for (size_t i = 0; own && i < findings->count; ++i) {
        norma_finding finding = findings->entries[i].finding;
        if (strncmp(finding.where, begin, (size_t)length) != 0) continue;
        finding.where += length - 1;
        at[count++] = i;
        if (norma_findings_copy(own, &finding, findings->entries[i].order)) continue;
        norma_findings_free(own);
        own = NULL;
    }
    if (!own) (void)fail_memory(error);
    return own;
}

norma_document_result norma_document_try_fixes(norma_document *document,
    const norma_check_options *options, norma_severity from, norma_findings *findings,
    norma_document_error *error) {
    norma_document *tile;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!findings || !norma_document_tile(document, 1))
        return try_fixes_of_one(document, options, from, findings, error);
    size_t *at = calloc(findings->count + 1, sizeof *at);
    if (!at) return fail_memory(error);
    for (size_t i = 0; !result && (tile = norma_document_tile(document, i)) != NULL; ++i) {
        norma_findings *own = findings_of_tile(findings, i, at, error);
        result =
            own ? try_fixes_of_one(tile, options, from, own, error) : NORMA_DOCUMENT_ERROR_MEMORY;
        for (size_t k = 0; !result && k < norma_findings_count(own); ++k) {
            const norma_finding *tried = norma_findings_get(own, k);
            norma_finding *finding = norma_findings_change(findings, at[k]);
            if (finding->fix != tried->fix && !norma_finding_withdraw(finding, tried->message))
                result = fail_memory(error);
        }
        norma_findings_free(own);
    }
    free(at);
    return result;
}
