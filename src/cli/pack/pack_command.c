/* pack_command.c: norma pack: normals and tangents of a glTF in fewer bytes, within an angle. */
#include "cli/files/files.h"
#include "cli/text/text.h"

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
