/* check_calls.c: norma check on the bytes of a file as WebAssembly exports. A checked_file holds
 * what was found; JavaScript asks for it by numbers and texts and builds the objects that
 * `norma check --format json` prints. */
#include "../wasm/exports.h"
#include <math.h>
#include <norma/check.h>
#include <stdlib.h>

typedef struct checked_file {
    norma_document *document;
    norma_findings *findings;
    norma_document_error error;
    norma_check_profile asked; /* which commands name, so that they judge alike */
} checked_file;

void *WEB_EXPORT(check_allocate)(size_t bytes) { return malloc(bytes ? bytes : 1); }
void WEB_EXPORT(check_release)(void *block) { free(block); }

static norma_document_result open_and_check(checked_file *file, const void *bytes, size_t size,
    const char *name, norma_file_format format, const norma_check_options *options) {
    const norma_document_options opening = {
        .struct_size = sizeof opening, .format = format, .lenient = 1};
    const norma_document_result result =
        norma_document_open_memory(bytes, size, name, &opening, &file->document, &file->error);
    if (result != NORMA_DOCUMENT_OK) return result;
    return norma_check_document(file->document, options, &file->findings, &file->error);
}

/* As the tool does: what a fix would leave is not offered, and the finding says why. */
static void try_offers(checked_file *file, const norma_check_options *options) {
    if (norma_document_try_fixes(file->document, options, NORMA_SEVERITY_INFO, file->findings,
            &file->error) == NORMA_DOCUMENT_OK)
        return;
    norma_findings_free(file->findings);
    file->findings = NULL;
}

norma_file_format WEB_EXPORT(check_format_of)(const char *name) {
    return norma_file_format_of_path(name);
}

/* bytes must outlive the result. NULL: out of memory. */
checked_file *WEB_EXPORT(check_file)(const void *bytes, size_t size, const char *name,
    norma_file_format format, norma_check_profile profile) {
    const norma_check_options options = {
        .struct_size = sizeof options, .profile = profile, .fix_from = NORMA_SEVERITY_WARNING};
    checked_file *file = calloc(1, sizeof *file);
    if (!file) return NULL;
    file->asked = profile;
    if (open_and_check(file, bytes, size, name, format, &options) == NORMA_DOCUMENT_OK)
        try_offers(file, &options);
    return file;
}

/* Not empty: the file could not be read, and this says why. */
const char *WEB_EXPORT(check_error)(const checked_file *file) { return file->error.message; }
int WEB_EXPORT(check_failed)(const checked_file *file) { return file->findings == NULL; }

/* Takes the message that JavaScript made of the error as the one finding. 0: out of memory. */
int WEB_EXPORT(check_report_error)(checked_file *file, const char *message,
    norma_file_format format, norma_check_profile profile) {
    const norma_check_options options = {.struct_size = sizeof options, .profile = profile};
    size_t length = 0;
    for (; message[length] && length + 1 < sizeof file->error.message; ++length)
        file->error.message[length] = message[length];
    file->error.message[length] = '\0';
    file->findings = norma_check_unreadable(&file->error, format, &options);
    return file->findings != NULL;
}

void WEB_EXPORT(check_close)(checked_file *file) {
    if (!file) return;
    norma_findings_free(file->findings);
    norma_document_close(file->document);
    free(file);
}

int WEB_EXPORT(check_profile)(const checked_file *file) {
    return (int)norma_findings_profile(file->findings);
}
int WEB_EXPORT(check_is_partly)(const checked_file *file) {
    return norma_findings_partly(file->findings);
}
size_t WEB_EXPORT(check_count)(const checked_file *file) {
    return norma_findings_count(file->findings);
}

/* ---- one finding */

enum { TEXT_RULE, TEXT_NAME, TEXT_WHERE, TEXT_UNIT, TEXT_MESSAGE };

const char *WEB_EXPORT(check_text)(const checked_file *file, size_t index, int which) {
    const norma_finding *finding = norma_findings_get(file->findings, index);
    const norma_rule *rule = finding->rule;
    const char *const texts[] = {rule->id, rule->name, finding->where, finding->unit,
        finding->message, rule->cause, rule->why};
    return texts[which];
}

/* The command that fixes it; its length, 0 without a fix. */
size_t WEB_EXPORT(check_command)(
    const checked_file *file, size_t index, const char *path, char *command, size_t capacity) {
    static const char *const names[] = {"auto", "render", "print", "generated"};
    const char *const options[] = {"--profile", names[file->asked], NULL};
    return norma_finding_command(norma_findings_get(file->findings, index), path,
        file->asked ? options : NULL, command, capacity);
}

/* Numbers that do not apply are NaN. */
static double number_of(size_t number) { return number == SIZE_MAX ? (double)NAN : (double)number; }

enum { SAMPLE_NUMBERS = 6 };

/* vertex, face, normal, position */
static void write_sample(const norma_sample *sample, double numbers[SAMPLE_NUMBERS]) {
    numbers[0] = number_of(sample->vertex);
    numbers[1] = number_of(sample->face);
    numbers[2] = number_of(sample->normal);
    for (int i = 0; i < 3; ++i)
        numbers[3 + i] = sample->has_position ? sample->position[i] : (double)NAN;
}

/* severity, count, worst value, fix, samples, whether there is a deviation; the mesh in two halves;
 * then the worst sample and whether it and each sample has a position. */
void WEB_EXPORT(check_numbers)(const checked_file *file, size_t index, double numbers[15]) {
    const norma_finding *finding = norma_findings_get(file->findings, index);
    numbers[0] = finding->severity;
    numbers[1] = (double)finding->count;
    numbers[2] = finding->worst_value;
    numbers[3] = finding->fix;
    numbers[4] = (double)finding->sample_count;
    numbers[5] = finding->deviation != NULL;
    numbers[6] = (double)(finding->mesh >> 32);
    numbers[7] = (double)(finding->mesh & UINT32_MAX);
    write_sample(&finding->worst, numbers + 8);
    numbers[14] = finding->worst.has_position;
}

void WEB_EXPORT(check_sample)(
    const checked_file *file, size_t index, size_t sample, double numbers[7]) {
    const norma_finding *finding = norma_findings_get(file->findings, index);
    write_sample(&finding->samples[sample], numbers);
    numbers[6] = finding->samples[sample].has_position;
}

/* shading, weight, crease, mean, median, 99th percentile and largest angle (radians), then bound
 * and corners of each bin. */
size_t WEB_EXPORT(check_deviation_numbers)(void) { return 7 + 2 * NORMA_DEVIATION_BINS; }
void WEB_EXPORT(check_deviation)(const checked_file *file, size_t index, double *numbers) {
    const norma_deviation *deviation = norma_findings_get(file->findings, index)->deviation;
    const double head[] = {deviation->shading, deviation->weight, deviation->crease_angle_rad,
        deviation->mean_rad, deviation->p50_rad, deviation->p99_rad, deviation->max_rad};
    for (size_t i = 0; i < 7; ++i) numbers[i] = head[i];
    for (size_t bin = 0; bin < NORMA_DEVIATION_BINS; ++bin) {
        numbers[7 + 2 * bin] = norma_deviation_bound_rad(bin);
        numbers[8 + 2 * bin] = (double)deviation->histogram[bin];
    }
}
