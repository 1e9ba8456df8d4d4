/* compute_command.c: norma compute: normals of the surface, written into a copy of each file. */
#include "cli/compute/compute_together.h"
#include "cli/files/files.h"
#include "cli/text/text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char compute_help[] =
    "norma compute IN -o OUT: computes normals and writes them into a copy of IN\n"
    "\n"
    "Examples\n"
    "  norma compute chair.obj -o out.obj              normals by angle, creases at 60 degrees\n"
    "  norma compute scan.ply -o out.ply               one smooth normal per vertex (the default "
    "for PLY)\n"
    "  norma compute chair.glb -o out.glb --crease 30  sharper: edges that bend by more than 30 "
    "degrees are hard\n"
    "  norma compute rock.glb -o out.glb --smooth      one normal per position; no vertex is "
    "added\n"
    "  norma compute part.stl -o out.stl               facet normals from the winding (STL holds "
    "no others)\n"
    "  norma compute *.glb --in-place --only missing   only meshes without normals; the others "
    "keep theirs\n"
    "  norma compute *.ply --together --out-dir out    treats the files as one surface, without "
    "seams\n"
    "  cat a.obj | norma compute - --input-format obj -o - > b.obj\n"
    "\n"
    "Which edges are hard\n"
    "  --crease DEG          edges that bend by more than DEG degrees, 0 to 180 (60)\n"
    "  --smooth              no edge: one normal per position\n"
    "  --flat                every edge: each face is flat\n"
    "  --groups auto|ignore  auto: if an OBJ has smoothing groups, they alone make edges hard, or\n"
    "                        together with the angle if --crease is given (auto)\n"
    "  --non-manifold hard|smooth\n"
    "                        edges of three or more faces (hard)\n"
    "\n"
    "How faces are averaged\n"
    "  --weight angle|area|uniform|max|angle-area|visible|angle-lengths\n"
    "                        how much each face counts at a vertex (angle). max suits smooth "
    "scans;\n"
    "                        area and uniform match files that were computed with them\n"
    "  --weld exact|none|DISTANCE\n"
    "                        which vertices share a normal: those at exactly equal positions, so "
    "that no\n"
    "                        seam shows (exact); none; or those within DISTANCE of each other, in "
    "the\n"
    "                        file's unit\n"
    "\n"
    "What is computed\n"
    "  --only all|missing|broken\n"
    "                        all: every normal (all). missing: normals of meshes or faces that "
    "have\n"
    "                        none. broken: also those that are not finite, zero or not of unit "
    "length\n"
    "  --morphs              also computes normal deltas of glTF morph targets that have none\n"
    "  --tangents keep|orthogonalise|regenerate\n"
    "                        what happens to tangents of a glTF. keep: nothing. orthogonalise: "
    "they are\n"
    "                        made perpendicular to new normals (the default). regenerate: "
    "MikkTSpace\n"
    "                        computes them again\n"
    "\n"
    "One surface in many files\n"
    "  --together            treats all inputs as one surface: equal world positions share a "
    "smooth\n"
    "                        normal across meshes, nodes and files. Writes all outputs or none. "
    "--crease\n"
    "                        keeps edges sharp\n"
    "  --lock PATTERN        keeps the normals of meshes, materials and groups (PLY: files) with\n"
    "                        matching names; surfaces that meet them take these normals. "
    "Repeatable\n"
    "  --levels              treats the files as levels of detail, the finest first. The default\n"
    "                        is to go by names such as rock_LOD1 and the extension MSFT_lod\n"
    "\n" CLI_FILES_HELP "\n"
    "Degenerate faces (almost no area) are ignored. Vertices left without a "
    "normal get the nearest one,\n"
    "and the summary counts them.\n"
    "Exit status: 0 fine, 2 wrong usage, 3 a file could not be read or written, 130 interrupted.\n";

/* ---- options */

static const char *set_weld(void *settings, const char *value) {
    norma_compute_options *options = &((compute_work *)settings)->options;
    double distance = 0;
    options->weld = NORMA_WELD_DISTANCE;
    if (strcmp(value, "exact") == 0)
        options->weld = NORMA_WELD_EXACT;
    else if (strcmp(value, "none") == 0)
        options->weld = NORMA_WELD_NONE;
    else if (!cli_number(value, &distance) || distance < 0)
        return "exact, none or a distance from 0 up in the file's unit";
    options->weld_distance = distance;
    return NULL;
}

static const cli_option compute_options[] = {
    {"weight", CLI_TO(CLI_WEIGHT, compute_work, options.weight)},
    {"crease", CLI_CREASE(compute_work, options.crease_angle_rad),
        CLI_GIVEN(compute_work, crease_given, 1)},
    {"smooth", CLI_SETS(compute_work, smooth_given, 1)},
    {"flat", CLI_SETS(compute_work, flat_given, 1)},
    {"groups", CLI_TO(CLI_CHOICE, compute_work, options.groups), .words = "auto,ignore",
        .expected = "auto or ignore"},
    {"weld", CLI_SET(set_weld)},
    {"non-manifold", CLI_TO(CLI_CHOICE, compute_work, options.non_manifold), .words = "hard,smooth",
        .expected = "hard or smooth"},
    {"only", CLI_ONLY(compute_work, options.only)},
    {"morphs", CLI_SETS(compute_work, options.morphs, 1)},
    {"tangents", CLI_TO(CLI_CHOICE, compute_work, options.tangents),
        .words = "orthogonalise,keep,regenerate", .expected = "keep, orthogonalise or regenerate",
        CLI_GIVEN(compute_work, tangents_given, 1)},
};

/* ---- one file */

/* As norma tangents does: an option that this format cannot follow is no silent success. */
static norma_document_result refuse_tangents(
    const compute_work *work, norma_document_error *error) {
    if (!work->tangents_given || work->options.tangents == NORMA_STORED_TANGENTS_KEEP ||
        norma_file_format_is_gltf(work->format))
        return NORMA_DOCUMENT_OK;
    snprintf(error->message, sizeof error->message,
        ": --tangents: this format cannot store tangents; glTF can");
    return error->result = NORMA_DOCUMENT_ERROR_ARGUMENT;
}

static norma_document_result compute_change(void *user, norma_document *document,
    norma_progress *progress, void *progress_user, norma_document_error *error) {
    compute_work *work = user;
    work->options.progress = progress;
    work->options.progress_user = progress_user;
    work->format = norma_document_format(document);
    work->passes = 0;
    if (refuse_tangents(work, error)) return error->result;
    return norma_document_compute(document, &work->options, &work->summary, error);
}

static norma_document_result in_passes(void *user, const char *input, const char *output,
    const norma_large_options *large, norma_progress *progress, void *progress_user,
    norma_document_error *error) {
    compute_work *work = user;
    work->options.progress = progress;
    work->options.progress_user = progress_user;
    work->format = large->format ? large->format : norma_file_format_of_path(input);
    if (refuse_tangents(work, error)) return error->result;
    norma_large_options counting = *large;
    counting.passes = &work->passes;
    return norma_large_compute(input, output, &counting, &work->options, &work->summary, error);
}

/* If edges were not looked at, zero would claim that none are hard. */
static size_t counted_edges(const norma_compute_summary *summary, size_t count) {
    return summary->edges_counted ? count : SIZE_MAX;
}

static void write_computed_json(const void *user, cli_json *json) {
    const compute_work *work = user;
    const norma_compute_summary *summary = &work->summary;
    const norma_report *counts = &summary->report;
    cli_json_print(json,
        "faces: %zu, vertices: {before: %zu, after: %zu}, weight: %s, crease_deg: %g, "
        "hard_edges: %zd",
        summary->faces, summary->vertices_before, summary->vertices_after,
        norma_weight_name(work->options.weight),
        summary->shading == NORMA_SHADING_CREASE ? cli_given_degrees(summary->crease_angle_rad)
                                                 : NAN,
        counted_edges(summary, summary->hard_edges));
    cli_json_print(json,
        "report: {degenerate_faces: %zu, cancelled: %zu, unreferenced: %zu, non_finite: %zu, "
        "non_manifold_edges: %zd, winding_conflicts: %zd}",
        counts->degenerate_faces.count, counts->cancelled.count, counts->unreferenced.count,
        counts->non_finite.count, counted_edges(summary, counts->non_manifold_edges.count),
        counted_edges(summary, counts->winding_conflicts.count));
    cli_json_print(json,
        "shading: %s, by_groups: %d, changed: %d, filled: %zu, tangents: {kept: %zu, "
        "orthogonalised: %zu, regenerated: %zu}",
        cli_shading_names[summary->shading], summary->by_groups, summary->changed, summary->filled,
        summary->tangents_kept, summary->tangents_orthogonalised, summary->tangents_regenerated);
    if (work->passes) cli_json_size(json, "passes", work->passes);
}

static void write_choices(const compute_work *work, norma_file_format format, FILE *out) {
    const norma_compute_summary *summary = &work->summary;
    char degrees[32], distance[32];
    cli_decimals(degrees, cli_given_degrees(summary->crease_angle_rad), 6);
    if (format == NORMA_FILE_STL) {
        fputs(", facet normals", out);
        return;
    }
    if (summary->shading == NORMA_SHADING_FLAT)
        fputs(", flat normals", out);
    else
        fprintf(out, ", normals by %s", norma_weight_name(work->options.weight));
    if (summary->shading == NORMA_SHADING_SMOOTH) fputs(", smooth", out);
    if (summary->by_groups) fputs(", smoothing groups", out);
    if (summary->shading == NORMA_SHADING_CREASE && !(summary->by_groups && !work->crease_given))
        fprintf(out, ", crease %s\302\260", degrees);
    if (work->options.weld == NORMA_WELD_NONE) fputs(", equal positions apart", out);
    if (work->options.weld == NORMA_WELD_DISTANCE)
        fprintf(out, ", welded within %s", cli_shortest(distance, work->options.weld_distance));
    if (work->options.only != NORMA_ONLY_ALL)
        fprintf(out, ", only %s ones",
            work->options.only == NORMA_ONLY_MISSING ? "missing" : "missing and broken");
}

static void write_edge_counts(const compute_work *work, FILE *out) {
    const norma_compute_summary *summary = &work->summary;
    if (!summary->edges_counted) return;
    fputs(", ", out);
    cli_counted(out, summary->hard_edges, "hard edge", "hard edges");
    cli_part(out, ", ", summary->report.non_manifold_edges.count, "non-manifold edge",
        "non-manifold edges");
    if (summary->report.non_manifold_edges.count)
        fputs(work->options.non_manifold == NORMA_NON_MANIFOLD_SMOOTH ? " smooth within the crease"
                                                                      : " hard",
            out);
    cli_part(out, ", ", summary->report.winding_conflicts.count,
        "edge whose faces are wound against each other",
        "edges whose faces are wound against each other");
}

/* What has a normal of its own in each format: a vertex, a corner of a face, a face, a facet. */
static void write_elements(
    const norma_compute_summary *summary, norma_file_format format, size_t count, FILE *out) {
    if (format == NORMA_FILE_STL)
        cli_counted(out, count, "facet", "facets");
    else if (format == NORMA_FILE_OBJ && summary->shading == NORMA_SHADING_FLAT)
        cli_counted(out, count, "face", "faces");
    else if (format == NORMA_FILE_OBJ && summary->shading == NORMA_SHADING_CREASE)
        cli_counted(out, count, "corner", "corners");
    else
        cli_counted(out, count, "vertex", "vertices");
}

static void write_filled(
    const norma_compute_summary *summary, norma_file_format format, FILE *out) {
    const norma_report *counts = &summary->report;
    int written = 0;
    if (!summary->filled && !counts->degenerate_faces.count) return;
    fputs("; ", out);
    write_elements(summary, format, summary->filled, out);
    fputs(" had no normal", out);
    cli_cause(out, &written, counts->degenerate_faces.count, "degenerate face", "degenerate faces");
    cli_cause(out, &written, counts->unreferenced.count, "in no face with a direction",
        "in no face with a direction");
    cli_cause(out, &written, counts->cancelled.count, "cancelled", "cancelled");
    cli_cause(out, &written, counts->non_finite.count, "not finite", "not finite");
    fputs(written ? ")" : "", out);
    fputs(summary->filled ? " and got the nearest" : "", out);
}

static void write_fate(FILE *out, int *written, size_t count, const char *fate) {
    if (!count) return;
    fputs(*written ? ", " : "; tangents: ", out);
    cli_count(out, count);
    fprintf(out, " %s", fate);
    *written = 1;
}

static void write_tangents(const norma_compute_summary *summary, FILE *out) {
    int written = 0;
    write_fate(out, &written, summary->tangents_kept, "kept");
    write_fate(
        out, &written, summary->tangents_orthogonalised, "made perpendicular to new normals");
    write_fate(out, &written, summary->tangents_regenerated, "computed anew");
}

static void write_computed_text(const void *user, const norma_document *document, FILE *out) {
    const compute_work *work = user;
    (void)document;
    const norma_compute_summary *summary = &work->summary;
    cli_counted(out, summary->faces, "face", "faces");
    if (!summary->changed) {
        fputs(", nothing to do: the output is the input, byte for byte", out);
        return;
    }
    write_choices(work, work->format, out);
    write_edge_counts(work, out);
    cli_vertices(out, summary->vertices_before, summary->vertices_after);
    write_filled(summary, work->format, out);
    write_tangents(summary, out);
    cli_part(out, "; in ", work->passes, "pass", "passes");
}

/* ---- the command */

static int compute_prepare(const cli_subcommand *command, void *user, uint32_t threads) {
    compute_work *work = user;
    work->options.threads = threads;
    if (work->crease_given + work->smooth_given + work->flat_given > 1)
        return cli_usage(command, "--crease, --smooth and --flat exclude each other");
    work->options.shading = work->crease_given   ? NORMA_SHADING_CREASE
                            : work->smooth_given ? NORMA_SHADING_SMOOTH
                            : work->flat_given   ? NORMA_SHADING_FLAT
                                                 : NORMA_SHADING_DEFAULT;
    return work->together && !work->votes && command != &cli_subcommand_compute
               ? cli_usage(command, "apply needs --votes FILE")
               : compute_check_together(command, work);
}

static int takes_all(const void *work) { return ((const compute_work *)work)->together; }

static int run_changer(const cli_subcommand *command, compute_work *work, const cli_table *tables,
    size_t table_count, int count, char **arguments) {
    const cli_changer changer = {.work = work,
        .change = compute_change,
        .write_json = write_computed_json,
        .write_text = write_computed_text,
        .in_passes = in_passes,
        .prepare = compute_prepare,
        .all = compute_all_together,
        .takes_all = takes_all};
    return cli_run_changer(command, &changer, tables, table_count, count, arguments);
}

static int compute_run(const cli_subcommand *command, int count, char **arguments) {
    compute_work work = {.options = {.struct_size = sizeof work.options}};
    const cli_table tables[] = {{compute_options, CLI_COUNT(compute_options), &work},
        {compute_together_options, compute_together_option_count, &work}};
    const int status = run_changer(command, &work, tables, CLI_COUNT(tables), count, arguments);
    free((void *)work.locks);
    return status;
}

int compute_with_votes(const cli_subcommand *command, int count, char **arguments) {
    static const cli_option options[] = {
        {"votes", CLI_TO(CLI_TEXT, compute_work, votes), .expected = "a file of votes"}};
    compute_work work = {.options = {.struct_size = sizeof work.options}, .together = 1};
    const cli_table table = {options, CLI_COUNT(options), &work};
    return run_changer(command, &work, &table, 1, count, arguments);
}

const cli_subcommand cli_subcommand_compute = {
    "compute", "computes normals and writes them into a copy of a file", compute_help, compute_run};
