/* norma compute: normals of the surface, written into a copy of each file; with --together those of
 * one surface that lies in many files; and norma seams, which makes the same of more files than a
 * process holds, in three steps. The plain run begins at compute_run; what is decided about the
 * normals is decided in io/format/normals.c. */
#include "cli/files/files.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct compute_work {
    norma_compute_options options;
    norma_compute_summary summary;
    int crease_given, smooth_given, flat_given;
    int tangents_given;
    norma_file_format format; /* of the file at hand */
    size_t passes;            /* over it; 0: it fits into memory */
    int together, levels;
    const char **locks;
    size_t lock_count, lock_room;
    const char *votes; /* of norma seams apply; NULL: all files are given */
} compute_work;

/* ---- One surface in many files: all are read, then all are written, or none; or, by votes of all,
 * one after the other. */

static const char *add_lock(void *settings, const char *value) {
    compute_work *work = settings;
    if (!value[0]) return "a pattern of names";
    const char **grown =
        cli_grow((void *)work->locks, work->lock_count, &work->lock_room, sizeof *grown);
    if (!grown) return "fewer; out of memory";
    work->locks = grown;
    work->locks[work->lock_count++] = value;
    return NULL;
}

static int compute_check_together(const cli_subcommand *command, const compute_work *work) {
    if (!work->together)
        return work->lock_count || work->levels
                   ? cli_usage(command, "--lock and --levels need --together")
                   : CLI_OK;
    if (work->flat_given)
        return cli_usage(command,
            "--together shares normals, but flat normals cannot be shared; leave out --flat");
    if (work->crease_given && (work->lock_count || work->levels))
        return cli_usage(command, "with --together, --lock and --levels work only for smooth "
                                  "normals; leave out --crease");
    if (work->options.weld == NORMA_WELD_NONE)
        return cli_usage(
            command, "--together joins equal positions; --weld none would join nothing");
    if (work->options.weight == NORMA_WEIGHT_VISIBLE)
        return cli_usage(command, "--together needs a weight that is summed over faces, and "
                                  "visible is not; give another --weight");
    if (work->options.only != NORMA_ONLY_ALL)
        return cli_usage(
            command, "--together computes all normals; --lock PATTERN keeps some, --only cannot");
    return CLI_OK;
}

/* Says that the tiles of a tileset do not share one frame; 0: they do. */
static int compute_refuse_moved(const cli_inputs *inputs) {
    if (inputs->moved)
        cli_error("%s: its tiles have transforms, which are not applied, so seams would be sought "
                  "at wrong places; expected tiles in one frame",
            inputs->moved);
    return inputs->moved != NULL;
}

/* ---- the run */

typedef struct joint_file {
    norma_compute_summary summary;
    uint64_t size;
    double before; /* bytes of the input and of what it names */
    char *output;
} joint_file;

typedef struct joint_run {
    const cli_all_files *all;
    norma_together_file *files;
    joint_file *own;             /* what each of them points to */
    size_t count, done, at_once; /* done: files of the calls before */
    const compute_work *work;
    size_t *lock_matches;                  /* of each --lock: names that match it */
    char (*nearest)[CLI_LONGEST_WORD + 1]; /* to each, of the names that do not */
    cli_progress progress;
} joint_run;

static void free_run(joint_run *run) {
    for (size_t i = 0; run->own && i < run->count; ++i) free(run->own[i].output);
    free(run->files);
    free(run->own);
    free(run->lock_matches);
    free(run->nearest);
}

static int make_run(joint_run *run) {
    const size_t count = run->count;
    run->files = calloc(count, sizeof *run->files);
    run->own = calloc(count, sizeof *run->own);
    run->lock_matches = calloc(run->work->lock_count + 1, sizeof *run->lock_matches);
    run->nearest = calloc(run->work->lock_count + 1, sizeof *run->nearest);
    if (!run->files || !run->own || !run->lock_matches || !run->nearest) return 0;
    for (size_t i = 0; i < count; ++i) {
        joint_file *own = &run->own[i];
        own->output = cli_output_of(run->all->files, i, NULL);
        if (!own->output) return 0;
        run->files[i] = (norma_together_file){.input = run->all->files->inputs.list[i].path,
            .output = own->output,
            .format = run->all->files->format,
            .summary = &own->summary,
            .size = &own->size};
    }
    return 1;
}

static int check_names(const joint_run *run) {
    for (size_t i = 0; i < run->count; ++i)
        if (strcmp(run->files[i].input, "-") == 0 || strcmp(run->files[i].output, "-") == 0)
            return cli_usage(run->all->command,
                run->work->votes
                    ? "standard input and output cannot be among the files"
                    : "--together reads its files twice and writes them all at once; standard "
                      "input and output cannot be among them");
    return CLI_OK;
}

/* ---- a --lock that nothing matches */

static void compare_name(joint_run *run, const char *name) {
    for (size_t i = 0; name && strlen(name) <= CLI_LONGEST_WORD && i < run->work->lock_count; ++i) {
        const char *both[] = {name, run->nearest[i]};
        const char *nearest =
            cli_suggest(run->work->locks[i], both, both[1][0] ? 2 : 1, sizeof *both);
        if (nearest == name) strcpy(run->nearest[i], name);
    }
}

static void compare_document_names(joint_run *run, const norma_document *given) {
    norma_document *document = (norma_document *)(uintptr_t)given;
    norma_mesh_info mesh;
    norma_material_info material;
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i)
        if (!norma_document_mesh_info(document, i, &mesh)) compare_name(run, mesh.name);
    for (size_t i = 0; i < norma_document_material_count(document); ++i)
        if (!norma_document_material_info(document, i, &material)) compare_name(run, material.name);
}

static void report_locks(const joint_run *run) {
    for (size_t i = 0; i < run->work->lock_count; ++i) {
        const char *nearest = run->nearest[i];
        if (run->lock_matches[i]) continue;
        cli_error("--lock '%s' matches no mesh, material or group, and locks nothing%s%s%s",
            run->work->locks[i], nearest[0] ? "; did you mean " : "", nearest,
            nearest[0] ? "?" : "");
    }
}

static void note_done(void *user, size_t file, const norma_document *document) {
    joint_run *run = user;
    file += run->done;
    if (run->work->lock_count) compare_document_names(run, document);
    run->own[file].before = 1e6 * cli_megabytes(run->files[file].input);
    cli_progress_hide(&run->progress);
    if (!run->all->common->quiet && !run->all->common->json)
        cli_print_notes(run->files[file].input, document);
}

/* Of the files that are computed at once, as a share of all. */
static int report_share(void *user, double fraction) {
    joint_run *run = user;
    return cli_progress_report(
        &run->progress, ((double)run->done + fraction * (double)run->at_once) / (double)run->count);
}

/* Those from run->done on. */
static norma_document_result compute_some(
    joint_run *run, compute_work *work, norma_document_error *error) {
    norma_compute_options options = work->options;
    const uint64_t allowed = cli_memory_for_data();
    options.progress = report_share;
    options.progress_user = run;
    const norma_together_options together = {.struct_size = sizeof together,
        .lock = work->locks,
        .lock_count = work->lock_count,
        .lock_matches = run->lock_matches,
        .levels = work->levels,
        .in_place = run->all->files->in_place,
        .threads = options.threads,
        .max_memory = allowed < (uint64_t)1 << 29 ? allowed : 0,
        .temporary_folder = getenv("TMPDIR"),
        .votes = work->votes,
        .weight = &work->options.weight,
        .file_done = note_done,
        .file_done_user = run};
    return norma_together_compute(run->files + run->done, run->at_once, &together, &options, error);
}

/* Files that were computed at once have one error: then none of them was written. */
static void report_some(joint_run *run, compute_work *work, norma_document_error *error) {
    cli_progress_hide(&run->progress);
    if (error->result) {
        cli_name_error(error, run->at_once == 1 ? run->files[run->done].input : "");
        cli_print_error(error);
    } else
        report_locks(run);
    for (size_t i = run->done; i < run->done + run->at_once; ++i) {
        const norma_together_file *file = &run->files[i];
        const joint_file *own = &run->own[i];
        const double bytes[2] = {own->before, (double)own->size};
        work->summary = own->summary;
        work->format = file->format ? file->format : norma_file_format_of_path(file->input);
        cli_report_changed(run->all, file->input, own->output, bytes, error);
    }
}

/* All files at once, or by votes one after the other: then one that fails does not stop the others.
 * The worst status. */
static int compute_files(joint_run *run, compute_work *work) {
    double megabytes = 0;
    int status = CLI_OK;
    for (size_t i = 0; i < run->count; ++i) megabytes += cli_megabytes(run->files[i].input);
    cli_progress_start(
        &run->progress, "computing", "all files", run->all->common->quiet, megabytes);
    run->at_once = work->votes ? 1 : run->count;
    for (; run->done < run->count && !cli_interrupted(); run->done += run->at_once) {
        norma_document_error error = {0};
        cli_writing_begin();
        error.result = compute_some(run, work, &error);
        if (cli_interrupted()) cli_progress_stop(&run->progress);
        if (!error.result || !cli_interrupted()) report_some(run, work, &error);
        cli_writing_end(); /* ends the process if it was interrupted */
        status = cli_worse(status, cli_status_of(error.result));
    }
    cli_progress_stop(&run->progress);
    return status;
}

/* All files, as cli_changer.all. */
static int compute_all_together(const cli_all_files *all) {
    joint_run run = {.all = all, .count = all->files->inputs.count, .work = all->changer->work};
    if (compute_refuse_moved(&all->files->inputs)) return CLI_FILE;
    int status = make_run(&run) ? check_names(&run) : cli_out_of_memory();
    for (size_t i = 0; i < run.count && !status; ++i)
        status = cli_make_folders(all->files, run.own[i].output);
    if (!status) status = compute_files(&run, all->changer->work);
    free_run(&run);
    return status;
}

/* ---- norma compute */

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
    {"together", CLI_SETS(compute_work, together, 1)},
    {"lock", CLI_SET(add_lock)},
    {"levels", CLI_SETS(compute_work, levels, 1)},
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

static int run_changer(const cli_subcommand *command, compute_work *work, const cli_table *table,
    int count, char **arguments) {
    const cli_changer changer = {.work = work,
        .change = compute_change,
        .write_json = write_computed_json,
        .write_text = write_computed_text,
        .in_passes = in_passes,
        .prepare = compute_prepare,
        .all = compute_all_together,
        .takes_all = takes_all};
    return cli_run_changer(command, &changer, table, 1, count, arguments);
}

static int compute_run(const cli_subcommand *command, int count, char **arguments) {
    compute_work work = {.options = {.struct_size = sizeof work.options}};
    const cli_table table = {compute_options, CLI_COUNT(compute_options), &work};
    const int status = run_changer(command, &work, &table, count, arguments);
    free((void *)work.locks);
    return status;
}

const cli_subcommand cli_subcommand_compute = {
    "compute", "computes normals and writes them into a copy of a file", compute_help, compute_run};

/* ---- norma seams */

static const char seams_help[] =
    "norma seams votes|merge|apply: one seamless surface in more files than a process holds\n"
    "\n"
    "The normals have the same bits as those of norma compute --together for all files.\n"
    "\n"
    "Examples\n"
    "  norma seams votes a.ply b.ply -o ab.votes        what tiles add along their borders\n"
    "  norma seams merge ab.votes cd.votes -o all.votes\n"
    "  norma seams apply a.ply --votes all.votes -o out/a.ply\n"
    "\n"
    "votes TILE... -o FILE\n"
    "  --weight angle|area|uniform|max|angle-area|angle-lengths\n"
    "                        how much each face counts at a vertex (angle)\n"
    "  --everywhere          votes at all positions, not only on edges of one face: needed if\n"
    "                        tiles touch elsewhere (closed bodies, levels of detail)\n"
    "  --rounded             rounds positions to floats, as for a glTF: needed for OBJ and PLY\n"
    "                        tiles of a surface that has glTF tiles too\n"
    "\n"
    "merge VOTES... -o FILE  joins files of votes, also merged ones: in any order, by any tree\n"
    "  --tiles N             refuses to join votes of fewer or more than N tiles\n"
    "\n"
    "apply TILE... --votes FILE\n"
    "  -o, --out-dir, --in-place\n"
    "                        as norma compute; one tile is in memory at a time\n"
    "\n"
    "Files\n" CLI_INPUT_FORMAT_HELP
    "  --threads N           uses at most N threads (all processors), with the same result\n"
    "  --max-memory SIZE     uses at most SIZE (512M, 2G)\n"
    "  --json                prints a summary as JSON\n"
    "  --quiet               prints only errors\n"
    "\n"
    "Files of votes name their tiles by hashes: a tile that is there twice, is missing or has\n"
    "changed since is an error, and so is a damaged file.\n"
    "Exit status: 0 fine, 2 wrong usage, 3 a file could not be read or written, 130 interrupted.\n";

typedef struct seams_work {
    norma_seams_options options;
    cli_common common;
    cli_files files;
    const char *output;
    norma_seams_summary summary;
} seams_work;

static const cli_option votes_options[] = {
    {"weight", CLI_TO(CLI_WEIGHT, seams_work, options.weight)},
    {"everywhere", CLI_SETS(seams_work, options.everywhere, 1)},
    {"rounded", CLI_SETS(seams_work, options.rounded, 1)},
    {"output", 'o', CLI_TO(CLI_TEXT, seams_work, output), .expected = "the name of a file"},
};
static const cli_option merge_options[] = {
    {"tiles", CLI_TO(CLI_SIZE, seams_work, options.tiles), .least = 1, .most = 1e9,
        .expected = CLI_WHOLE_FROM_1},
    {"output", 'o', CLI_TO(CLI_TEXT, seams_work, output), .expected = "the name of a file"},
};

/* ---- votes and merge */

static void report_written(const seams_work *work) {
    const norma_seams_summary *summary = &work->summary;
    cli_json json = {.out = stdout};
    if (work->common.json) {
        cli_json_print(&json, "{output: %s, tiles: %zu, positions: %zu, bytes: %zu}\n",
            work->output, summary->tiles, (size_t)summary->positions, (size_t)summary->bytes);
    } else if (!work->common.quiet) {
        cli_say(stderr, "%s: votes of ", work->output);
        cli_counted(stderr, summary->tiles, "tile", "tiles");
        fputs(" at ", stderr);
        cli_counted(stderr, (size_t)summary->positions, "position", "positions");
        fputc('\n', stderr);
    }
}

static int write_seams(seams_work *work, int merges) {
    const cli_inputs *inputs = &work->files.inputs;
    const size_t count = merges ? work->files.words.count : inputs->count;
    const char **paths = calloc(count + 1, sizeof *paths);
    norma_document_error error = {0};
    cli_progress progress;
    if (!paths) return cli_out_of_memory();
    for (size_t i = 0; i < count; ++i)
        paths[i] = merges ? work->files.words.words[i] : inputs->list[i].path;
    cli_progress_start(
        &progress, merges ? "merging" : "taking votes", work->output, work->common.quiet, 0);
    work->options.progress = cli_progress_report;
    work->options.progress_user = &progress;
    cli_writing_begin();
    const norma_document_result result =
        merges
            ? norma_seams_merge(paths, count, work->output, &work->options, &work->summary, &error)
            : norma_seams_votes(paths, count, work->output, &work->options, &work->summary, &error);
    cli_progress_stop(&progress);
    cli_writing_end();
    free((void *)paths);
    if (!result) {
        report_written(work);
        return cli_finish(CLI_OK);
    }
    cli_name_error(&error, work->output);
    cli_print_error(&error);
    return cli_status_of(result);
}

/* The output replaces no tile and no votes that are read. */
static int guard_seams(const seams_work *work, int merges) {
    const cli_words *words = &work->files.words;
    for (size_t i = 0; merges && i < words->count; ++i)
        cli_guard_read(work->files.guard, words->words[i]);
    if (!merges) cli_guard_look_ahead(work->files.guard, &work->files.inputs, work->files.format);
    return cli_guard_output(work->files.guard, work->output, NULL);
}

static int read_seams(const cli_subcommand *command, seams_work *work, int merges) {
    const char *const *words = work->files.words.words;
    int standard = 0;
    for (size_t i = 0; i < work->files.words.count; ++i) standard |= cli_is_standard(words[i]);
    if (!work->output) return cli_usage(command, "no output was given; expected -o FILE");
    if (standard || cli_is_standard(work->output))
        return cli_usage(command, "standard input and output cannot be among the files");
    if (!work->files.words.count)
        return cli_usage(command, merges ? "no votes were given" : "no tile was given");
    if (work->options.weight == NORMA_WEIGHT_VISIBLE)
        return cli_usage(command, "votes need a weight that is summed over faces, and visible is "
                                  "not; give another --weight");
    work->options.format = work->files.format;
    work->options.threads = work->common.threads;
    work->options.temporary_folder = getenv("TMPDIR");
    work->options.max_memory = cli_memory_for_data() / 4;
    int status = merges ? CLI_OK : cli_find_inputs(command, &work->files);
    if (!status && compute_refuse_moved(&work->files.inputs)) status = CLI_FILE;
    if (!status) status = guard_seams(work, merges);
    return status ? status : write_seams(work, merges);
}

static int run_votes(const cli_subcommand *command, int merges, int count, char **arguments) {
    seams_work work = {
        .options = {.struct_size = sizeof work.options}, .common.threads = NORMA_ALL_THREADS};
    const cli_table tables[] = {
        {merges ? merge_options : votes_options,
            merges ? CLI_COUNT(merge_options) : CLI_COUNT(votes_options), &work},
        {cli_input_options, cli_input_option_count, &work.files},
        {cli_common_options, cli_common_option_count, &work.common},
    };
    int status = cli_read_files(command, &work.files, tables, CLI_COUNT(tables), count, arguments);
    if (status) return status;
    status = read_seams(command, &work, merges);
    cli_remove_empty_folders(&work.files);
    cli_files_end(&work.files);
    return status;
}

/* ---- apply: smooth normals by votes of all tiles */

static int compute_with_votes(const cli_subcommand *command, int count, char **arguments) {
    static const cli_option options[] = {
        {"votes", CLI_TO(CLI_TEXT, compute_work, votes), .expected = "a file of votes"}};
    compute_work work = {.options = {.struct_size = sizeof work.options}, .together = 1};
    const cli_table table = {options, CLI_COUNT(options), &work};
    return run_changer(command, &work, &table, count, arguments);
}

/* ---- the command */

static int seams_run(const cli_subcommand *command, int count, char **arguments) {
    const char *step = count ? arguments[0] : "";
    if (strcmp(step, "votes") == 0) return run_votes(command, 0, count - 1, arguments + 1);
    if (strcmp(step, "merge") == 0) return run_votes(command, 1, count - 1, arguments + 1);
    if (strcmp(step, "apply") == 0) return compute_with_votes(command, count - 1, arguments + 1);
    return count ? cli_usage(command, "unknown step '%s'; expected votes, merge or apply", step)
                 : cli_usage(command, "expected votes, merge or apply");
}

const cli_subcommand cli_subcommand_seams = {"seams",
    "makes one seamless surface of more files than a process holds, in three steps", seams_help,
    seams_run};
