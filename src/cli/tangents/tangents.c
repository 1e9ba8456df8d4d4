/* norma tangents: tangents for normal maps, written into a copy of each glTF; and norma pack: its
 * normals and tangents in fewer bytes, within an angle. */
#include "cli/files/files.h"
#include <string.h>

/* ---- norma tangents */

static const char tangents_help[] =
    "norma tangents IN -o OUT: computes tangents and writes them into a copy of a glTF\n"
    "\n"
    "Examples\n"
    "  norma tangents chair.glb -o out.glb             the tangents of MikkTSpace, which bakers "
    "and\n"
    "                                                  engines use\n"
    "  norma tangents *.glb --out-dir out --only missing\n"
    "                                                  only meshes without tangents\n"
    "\n"
    "How they are made\n"
    "  --mode mikk|meshopt|steady\n"
    "                        mikk: the tangents of MikkTSpace, bit for bit, for normal maps that "
    "were\n"
    "                        baked with them (mikk). meshopt: those of meshoptimizer 1.3 with its\n"
    "                        default weights, bit for bit, which Godot makes. steady: tangents "
    "that\n"
    "                        do not depend on the order of faces and corners\n"
    "  --texcoord N          uses the texture coordinates TEXCOORD_N. The default is the set of "
    "the\n"
    "                        normal map, with its KHR_texture_transform, or 0 without a normal "
    "map\n"
    "  --weight angle|area|uniform|max|angle-area|visible|angle-lengths\n"
    "                        the weight of each face in an average, with --mode steady (angle)\n"
    "\n"
    "What is computed\n"
    "  --only all|missing|broken\n"
    "                        all: every tangent (all). missing: tangents of meshes that have "
    "none.\n"
    "                        broken: also those that are not finite or not of unit length, or "
    "whose\n"
    "                        sign is neither 1 nor -1\n"
    "\n" CLI_FILES_HELP "\n"
    "All triangles with normals and texture coordinates get tangents. A vertex "
    "is split if its corners have\n"
    "different tangents: where mirrored charts meet, and where the direction of the normal map "
    "changes.\n"
    "Morph targets with normals get tangent deltas. OBJ, PLY and STL cannot store tangents.\n"
    "Exit status: 0 fine, 2 wrong usage, 3 a file could not be read or written, 130 interrupted.\n";

typedef struct tangents_work {
    norma_tangent_options options;
    norma_tangent_summary summary;
    int mode, weight_given;
} tangents_work;

enum { STEADY_MODE, MIKK_MODE, MESHOPT_MODE };

/* ---- options */

static const cli_option tangents_options[] = {
    {"mode", CLI_TO(CLI_CHOICE, tangents_work, mode), .words = "steady,mikk,meshopt",
        .expected = "mikk, meshopt or steady"},
    {"texcoord", CLI_TO(CLI_INT, tangents_work, options.texcoord), .most = 65535,
        .expected = "the number of a set of texture coordinates, 0, 1, ...",
        CLI_GIVEN(tangents_work, options.texcoord_given, 1)},
    {"weight", CLI_TO(CLI_WEIGHT, tangents_work, options.weight),
        CLI_GIVEN(tangents_work, weight_given, 1)},
    {"only", CLI_ONLY(tangents_work, options.only)},
};

/* ---- one file */

static norma_document_result tangents_change(void *user, norma_document *document,
    norma_progress *progress, void *progress_user, norma_document_error *error) {
    tangents_work *work = user;
    work->options.progress = progress;
    work->options.progress_user = progress_user;
    return norma_document_tangents(document, &work->options, &work->summary, error);
}

static const char *mode_name(const tangents_work *work) {
    return work->mode == MESHOPT_MODE ? "meshopt" : work->mode == MIKK_MODE ? "mikk" : "steady";
}

static void write_tangents_json(const void *user, cli_json *json) {
    const tangents_work *work = user;
    const norma_tangent_summary *summary = &work->summary;
    cli_json_print(json, "mode: %s, texcoord: %zd, vertices: {before: %zu, after: %zu}",
        mode_name(work), work->options.texcoord_given ? (size_t)work->options.texcoord : SIZE_MAX,
        summary->vertices_before, summary->vertices_after);
    cli_json_print(json,
        "report: {degenerate: %zu, non_finite: %zu, cancelled: %zu}, primitives: %zu, "
        "left_out: %zu, changed: %d",
        summary->degenerate, summary->non_finite, summary->cancelled, summary->primitives,
        summary->left_out, summary->changed);
}

/* Corners that have no tangent of their own, and why. */
static void write_tangent_reasons(const norma_tangent_summary *summary, FILE *out) {
    int written = 0;
    const size_t count = summary->degenerate + summary->non_finite + summary->cancelled;
    if (!count) return;
    cli_part(out, "; ", count, "corner had no tangent", "corners had no tangent");
    cli_cause(out, &written, summary->degenerate, "without texture area", "without texture area");
    cli_cause(out, &written, summary->non_finite, "not finite", "not finite");
    cli_cause(out, &written, summary->cancelled, "cancelled", "cancelled");
    fputs(") and got one perpendicular to the normal", out);
}

static void write_tangents_text(const void *user, const norma_document *document, FILE *out) {
    const tangents_work *work = user;
    const norma_tangent_summary *summary = &work->summary;
    (void)document;
    fputs("tangents of ", out);
    cli_counted(out, summary->primitives, "primitive", "primitives");
    fprintf(out, " (%s)", mode_name(work));
    if (!summary->changed) {
        fputs(", nothing to do: the output is the input, byte for byte", out);
    } else {
        cli_vertices(out, summary->vertices_before, summary->vertices_after);
        if (summary->vertices_after != summary->vertices_before)
            fputs(", split where corners have different tangents", out);
    }
    write_tangent_reasons(summary, out);
    cli_part(out, "; left out: ", summary->left_out,
        "primitive without normals or without that set of texture coordinates",
        "primitives without normals or without that set of texture coordinates");
}

/* ---- the command */

static int tangents_prepare(const cli_subcommand *command, void *user, uint32_t threads) {
    tangents_work *work = user;
    work->options.threads = threads;
    work->options.mode = work->mode == STEADY_MODE ? NORMA_TANGENTS_STEADY : NORMA_TANGENTS_MIKK;
    work->options.meshopt = work->mode == MESHOPT_MODE;
    if (work->weight_given && work->mode != STEADY_MODE)
        return cli_usage(
            command, work->mode == MIKK_MODE
                         ? "--weight needs --mode steady; MikkTSpace weighs by angle"
                         : "--weight needs --mode steady; meshoptimizer weighs by angle and edges");
    return CLI_OK;
}

static int tangents_run(const cli_subcommand *command, int count, char **arguments) {
    tangents_work work = {.options = {.struct_size = sizeof work.options}, .mode = MIKK_MODE};
    const cli_table table = {tangents_options, CLI_COUNT(tangents_options), &work};
    const cli_changer changer = {.work = &work,
        .change = tangents_change,
        .write_json = write_tangents_json,
        .write_text = write_tangents_text,
        .prepare = tangents_prepare};
    return cli_run_changer(command, &changer, &table, 1, count, arguments);
}

const cli_subcommand cli_subcommand_tangents = {"tangents",
    "computes tangents and writes them into a copy of a glTF", tangents_help, tangents_run};

/* ---- norma pack */

static const char pack_help[] =
    "norma pack IN -o OUT: stores the normals and tangents of a glTF in fewer bytes\n"
    "\n"
    "Examples\n"
    "  norma pack chair.glb -o small.glb               directions within 0.5 degrees\n"
    "  norma pack car.glb -o small.glb --max-error 0.01\n"
    "                                                  for surfaces like mirrors\n"
    "\n"
    "What is packed\n"
    "  --max-error DEG       how far a normal or tangent may turn, in degrees (0.5). 0: only\n"
    "                        where nothing turns\n"
    "\n" CLI_FILES_HELP "\n"
    "Each accessor gets the smallest encoding of KHR_mesh_quantization that stays within the "
    "angle: signed\n"
    "bytes (at worst 0.391 degrees) or 16-bit integers (0.00151 degrees), normalised. Targets of "
    "morphs are\n"
    "judged by the directions that each gives alone at full weight. Meshes that Draco compressed "
    "stay as they are.\n"
    "OBJ, PLY, STL and 3MF have nothing to choose.\n"
    "Exit status: 0 fine, 2 wrong usage, 3 a file could not be read or written, 130 interrupted.\n";

typedef struct pack_work {
    norma_pack_options options;
    norma_pack_summary summary;
} pack_work;

static const double RADIANS = 3.141592653589793 / 180;

static const cli_option pack_options[] = {
    {"max-error", CLI_TO(CLI_RADIANS, pack_work, options.max_error_rad), .most = 180,
        .expected = "degrees from 0 to 180"},
};

static norma_document_result pack_change(void *user, norma_document *document,
    norma_progress *progress, void *progress_user, norma_document_error *error) {
    pack_work *work = user;
    work->options.progress = progress;
    work->options.progress_user = progress_user;
    return norma_document_pack(document, &work->options, &work->summary, error);
}

static void write_part_json(cli_json *json, const char *key, const norma_pack_part *part) {
    cli_json_open(json, key, '{');
    cli_json_print(json,
        "accessors: %zu, packed: %zu, bytes: {before: %zu, after: %zu}, error_deg: %g}",
        part->accessors, part->packed, part->bytes_before, part->bytes_after,
        part->max_error_rad / RADIANS);
}

static void write_pack_json(const void *user, cli_json *json) {
    const pack_work *work = user;
    const norma_pack_summary *summary = &work->summary;
    cli_json_number(json, "max_error_deg", work->options.max_error_rad / RADIANS);
    write_part_json(json, "normals", &summary->normals);
    write_part_json(json, "tangents", &summary->tangents);
    cli_json_print(json, "made_unit: %zu, changed: %d", summary->made_unit, summary->changed);
}

static void write_part_text(FILE *out, const char *name, const norma_pack_part *part) {
    if (!part->accessors) return;
    fprintf(out, "%s ", name);
    cli_counted(out, part->bytes_before, "byte", "bytes");
    fputs(" -> ", out);
    cli_counted(out, part->bytes_after, "byte", "bytes");
    fprintf(out, ", at most %.3g degrees off", part->max_error_rad / RADIANS);
    if (part->packed < part->accessors)
        fprintf(out, " (%zu of %zu accessors as they were)", part->accessors - part->packed,
            part->accessors);
}

static void write_pack_text(const void *user, const norma_document *document, FILE *out) {
    const pack_work *work = user;
    const norma_pack_summary *summary = &work->summary;
    (void)document;
    write_part_text(out, "normals", &summary->normals);
    if (summary->normals.accessors && summary->tangents.accessors) fputs("; ", out);
    write_part_text(out, "tangents", &summary->tangents);
    if (!summary->normals.accessors && !summary->tangents.accessors)
        fputs("no normals or tangents to pack", out);
    if (!summary->changed) fputs(", nothing to do: the output is the input, byte for byte", out);
    cli_part(out, "; ", summary->made_unit, "vector was not of unit length, and now is",
        "vectors were not of unit length, and now are");
}

static int pack_run(const cli_subcommand *command, int count, char **arguments) {
    pack_work work = {
        .options = {.struct_size = sizeof work.options, .max_error_rad = 0.5 * RADIANS}};
    const cli_table table = {pack_options, CLI_COUNT(pack_options), &work};
    const cli_changer changer = {.work = &work,
        .change = pack_change,
        .write_json = write_pack_json,
        .write_text = write_pack_text};
    return cli_run_changer(command, &changer, &table, 1, count, arguments);
}

const cli_subcommand cli_subcommand_pack = {
    "pack", "stores the normals and tangents of a glTF in fewer bytes", pack_help, pack_run};
