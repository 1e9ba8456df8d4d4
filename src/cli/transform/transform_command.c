/* transform_command.c: norma transform: a file under one matrix, its normals with it. */
#include "cli/files/files.h"
#include "cli/options/options.h"
#include "cli/process/process.h"
#include "cli/text/text.h"
#include <string.h>

static const char transform_help[] =
    "norma transform IN -o OUT MATRIX: applies one matrix to positions, normals, tangents and "
    "winding\n"
    "\n"
    "Examples\n"
    "  norma transform chair.obj -o out.obj --scale 2,0.5,1     stretched; the normals stay "
    "perpendicular\n"
    "  norma transform chair.ply -o out.ply --rotate 0,1,0,90   a quarter turn about the y axis\n"
    "  norma transform part.stl -o out.stl --scale -1,1,1       mirrored: the winding is reversed\n"
    "  norma transform a.glb -o b.glb --scale 2 --translate 0,0,1\n"
    "                                                           first doubled, then moved\n"
    "  norma transform a.glb -o b.glb --bake                    moves node transforms into the "
    "meshes\n"
    "\n" CLI_MATRIX_HELP "\n"
    "glTF\n"
    "  (without --bake)      the matrix becomes a new node above the scene's roots; meshes stay as "
    "they are\n"
    "  --bake                applies the world matrix of every node that draws a mesh to the mesh "
    "itself,\n"
    "                        at any depth, including shear and mirrors. Skinned and animated "
    "meshes stay\n"
    "                        as they are and are listed\n"
    "\n" CLI_FILES_HELP "\n"
    "'norma matrix' with the same options shows what a matrix does to normals.\n"
    "Exit status: 0 fine, 2 wrong usage, 3 a file could not be read or written, 130 interrupted.\n";

typedef struct transform_work {
    norma_transform_options options;
    norma_transform_summary summary;
    cli_matrix matrix;      /* as it was given */
    norma_matrix_info info; /* of it */
    int leaves_normals;     /* its normal matrix is not zero */
} transform_work;

static const cli_option transform_options[] = {{"bake", CLI_SETS(transform_work, options.bake, 1)}};

static norma_document_result transform_change(void *user, norma_document *document,
    norma_progress *progress, void *progress_user, norma_document_error *error) {
    transform_work *work = user;
    work->options.progress = progress;
    work->options.progress_user = progress_user;
    return norma_document_transform(document, &work->options, &work->summary, error);
}

static void write_transformed_json(const void *user, cli_json *json) {
    const transform_work *work = user;
    const norma_transform_summary *summary = &work->summary;
    cli_json_print(json,
        "vertices: %zu, mirrored: %d, meshes: %zu, nodes_baked: %zu, changed: %d, kind: %s",
        summary->vertices, summary->mirrored, summary->meshes, summary->nodes_baked,
        summary->changed, cli_kind_name(work->info.kind));
}

/* The rank is judged with a tolerance; what is left of normals is not. */
static const char *what_flattening_does(const transform_work *work) {
    if (work->info.determinant != 0)
        return "; nearly flat (within 1e-6 of its largest stretch): each face keeps its normal";
    if (work->leaves_normals)
        return "; flattened to a plane (rank 2): faces get the plane's normal, which is right; "
               "collapsed faces have none";
    if (work->info.rank == 1)
        return "; flattened to a line (rank 1): no face keeps a direction, so no normal is right";
    return "; flattened to a point (rank 0): no face keeps a direction, so no normal is right";
}

static void write_transformed_text(const void *user, const norma_document *document, FILE *out) {
    const transform_work *work = user;
    const norma_transform_summary *summary = &work->summary;
    const int on_a_node =
        norma_file_format_is_gltf(norma_document_format(document)) && !work->options.bake;
    if (!summary->changed) {
        fputs("nothing to do: the output is the input, byte for byte", out);
        return;
    }
    cli_counted(out, summary->vertices, "vertex in ", "vertices in ");
    cli_counted(out, summary->meshes, "mesh", "meshes");
    if (!work->matrix.given)
        fputs(work->summary.nodes_baked ? "" : ", no node baked", out);
    else if (work->info.mirrored && work->info.kind == NORMA_KIND_ROTATION)
        fputs(", matrix: mirror", out);
    else
        fprintf(out, ", matrix: %s%s", cli_kind_name(work->info.kind),
            work->info.mirrored ? " with a mirror" : "");
    cli_part(out, ", ", summary->nodes_baked, "node baked", "nodes baked");
    if (summary->mirrored && on_a_node)
        fputs("; mirrored by a new node above the meshes: their winding stays, and the renderer "
              "reverses it",
            out);
    else if (summary->mirrored)
        fputs("; mirrored: winding reversed to keep faces pointing outward", out);
    if (work->info.rank < 3 && on_a_node)
        fprintf(out,
            "; flattened (rank %d) by a new node: the normals then depend on the renderer; --bake "
            "writes them into the file",
            work->info.rank);
    else if (work->info.rank < 3)
        fputs(what_flattening_does(work), out);
}

static int transform_prepare(const cli_subcommand *command, void *user, uint32_t threads) {
    transform_work *work = user;
    double normal_matrix[9];
    const double *m = work->matrix.matrix;
    if (!work->matrix.given && !work->options.bake)
        return cli_usage(command, "no matrix was given; expected --scale, --rotate, --translate, "
                                  "--matrix, or --bake for glTF");
    if (!cli_is_affine(&work->matrix))
        return cli_usage(command,
            "the last row of the matrix must be 0 0 0 1; a perspective cannot "
            "be applied to a file");
    memcpy(work->options.matrix, m, sizeof work->options.matrix);
    work->options.threads = threads;
    norma_normal_matrix_double(m, NORMA_WINDING_REVERSED, normal_matrix, &work->info);
    work->leaves_normals = 0;
    for (int i = 0; i < 9; ++i) work->leaves_normals |= normal_matrix[i] != 0;
    return CLI_OK;
}

static int transform_run(const cli_subcommand *command, int count, char **arguments) {
    transform_work work = {
        .options = {.struct_size = sizeof work.options}, .matrix = cli_matrix_identity};
    const cli_table tables[] = {{transform_options, CLI_COUNT(transform_options), &work},
        {cli_matrix_options, cli_matrix_option_count, &work.matrix}};
    const cli_changer changer = {.work = &work,
        .change = transform_change,
        .write_json = write_transformed_json,
        .write_text = write_transformed_text,
        .prepare = transform_prepare};
    return cli_run_changer(command, &changer, tables, CLI_COUNT(tables), count, arguments);
}

const cli_subcommand cli_subcommand_transform = {"transform",
    "moves, turns, scales or mirrors a file, normals included", transform_help, transform_run};
