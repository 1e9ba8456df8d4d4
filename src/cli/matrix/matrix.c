/* norma matrix: what a matrix does to normals, in numbers that a reader can check by hand; and
 * norma transform: a file under one matrix, its normals with it. */
#include "cli/files/files.h"
#include <math.h>
#include <string.h>

/* ---- norma matrix */

static const char matrix_help[] =
    "norma matrix MATRIX: shows what a matrix does to normals, and which matrix is correct for "
    "them\n"
    "\n"
    "Examples\n"
    "  norma matrix --scale 2,0.5,1                    multiplied by M itself, normals err by "
    "61.93 degrees\n"
    "  norma matrix --rotate 0,0,1,30 --scale 2,1,1    first turned, then stretched: a shear\n"
    "  norma matrix --scale -1,1,1                     a mirror\n"
    "  norma matrix --scale 1,1,0                      flattened: rank 2, and still one correct "
    "normal\n"
    "  norma matrix --matrix \"1 0 0 5  0 1 0 0  0 0 1 0  0 0 0 1\" --json\n"
    "\n" CLI_MATRIX_HELP "\n"
    "  --json                prints one object; matrices are nine numbers, row by row\n"
    "\n"
    "Exit status: 0 fine, 2 wrong usage.\n";

typedef struct matrix_answer {
    const double *model; /* column-major, like the others */
    norma_matrix_info info;
    double normal[9], cofactor[9], inverse_transpose[9], axis_scale[9];
    int has_inverse;
    norma_shortcut shortcut;
} matrix_answer;

static const char *const shortcut_names[] = {"none", "rotation", "uniform-scale", "axis-scale"};

static int answer(const cli_subcommand *command, const double model[16], matrix_answer *found) {
    norma_result result =
        norma_normal_matrix_double(model, NORMA_WINDING_REVERSED, found->normal, &found->info);
    if (!result) result = norma_cofactor_matrix(model, found->cofactor);
    if (result) return cli_usage(command, "%s", norma_result_text(result));
    found->model = model;
    found->has_inverse = !norma_inverse_transpose(model, found->inverse_transpose);
    for (int i = 0; i < 9 && found->has_inverse; ++i)
        found->has_inverse = isfinite(found->inverse_transpose[i]);
    found->shortcut = norma_matrix_shortcut(&found->info);
    return CLI_OK;
}

/* ---- for programs */

static void write_rows(cli_json *json, const char *key, const double columns[9]) {
    cli_json_open(json, key, '[');
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            cli_json_number(json, NULL, columns[3 * column + row]);
    cli_json_close(json, ']');
}

static void write_matrix_json(const matrix_answer *found) {
    const norma_matrix_info *info = &found->info;
    const float *worst = info->worst_normal;
    cli_json json = {.out = stdout};
    cli_json_print(&json,
        "{kind: %s, mirrored: %d, rank: %zu, determinant: %g, anisotropy: %g, "
        "worst_error_deg: %g, worst_normal: [%g, %g, %g]",
        cli_kind_name(info->kind), info->mirrored, (size_t)info->rank, info->determinant,
        info->anisotropy, cli_to_degrees(info->worst_error_rad), (double)worst[0], (double)worst[1],
        (double)worst[2]);
    write_rows(&json, "normal_matrix", found->normal);
    write_rows(&json, "cofactor", found->cofactor);
    if (found->has_inverse)
        write_rows(&json, "inverse_transpose", found->inverse_transpose);
    else
        cli_json_null(&json, "inverse_transpose");
    cli_json_print(&json, "shortcut: %s}\n", shortcut_names[found->shortcut]);
}

/* ---- for people */

static double tidy(double number) { return number + 0.0; /* no "-0" */ }

static void print_rows(const double *columns, int size) {
    for (int row = 0; row < size; ++row) {
        for (int column = 0; column < size; ++column)
            printf("  %10.6g", tidy(columns[size * column + row]));
        printf("\n");
    }
}

static int is_zero(const double columns[9]) {
    for (int i = 0; i < 9; ++i)
        if (columns[i] != 0) return 0;
    return 1;
}

/* Rank and kind are judged with a tolerance; what is left of normals is not. */
static const char *what_is_left(const matrix_answer *found) {
    if (found->info.determinant != 0)
        return "nearly flat (within 1e-6 of its largest stretch): every face keeps its direction";
    if (!is_zero(found->cofactor))
        return "space is flattened to a plane, whose normal is the only one left";
    if (found->info.rank == 1)
        return "space is flattened to a line: no face keeps a direction, no normal exists";
    return "space is flattened to a point: no face keeps a direction, no normal exists";
}

static const char *meaning(const matrix_answer *found) {
    const norma_matrix_info *info = &found->info;
    switch (info->kind) {
    case NORMA_KIND_IDENTITY:
        return "normals stay as they are";
    case NORMA_KIND_TRANSLATION:
        return "normals stay as they are: a translation never acts on them";
    case NORMA_KIND_ROTATION:
        return info->mirrored
                   ? "a mirror; if faces are reversed, M itself transforms normals correctly"
                   : "M itself transforms normals correctly";
    case NORMA_KIND_UNIFORM_SCALE:
        return "M itself transforms normals correctly; renormalise after it";
    case NORMA_KIND_NON_UNIFORM_SCALE:
        return "the columns are perpendicular, but differ in length: plain M is wrong";
    case NORMA_KIND_SHEAR:
        return "the columns are not perpendicular: plain M is wrong";
    case NORMA_KIND_SINGULAR:
        break;
    }
    return what_is_left(found);
}

static void carry(const double columns[9], const float n[3], double carried[3]) {
    double length = 0, largest = 0;
    for (int row = 0; row < 3; ++row) {
        carried[row] = columns[row] * (double)n[0] + columns[3 + row] * (double)n[1] +
                       columns[6 + row] * (double)n[2];
        largest = fmax(largest, fabs(carried[row]));
    }
    for (int i = 0; i < 3 && largest > 0; ++i)
        length += (carried[i] / largest) * (carried[i] / largest);
    for (int i = 0; i < 3; ++i) carried[i] = largest > 0 ? carried[i] / largest / sqrt(length) : 0;
}

static void print_direction(const char *name, const double v[3]) {
    char text[3][32];
    printf("%s(%s, %s, %s)", name, cli_decimals(text[0], v[0], 4), cli_decimals(text[1], v[1], 4),
        cli_decimals(text[2], v[2], 4));
}

static void print_worst(const matrix_answer *found) {
    const norma_matrix_info *info = &found->info;
    const double *m = found->model,
                 upper[9] = {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
    double worst[3], plain[3], right[3];
    char degrees[32];
    if (is_zero(found->normal)) {
        printf("plain M       leaves no normal, and neither does any other matrix\n");
        return;
    }
    if (info->worst_error_rad > 1e-7 && cli_to_degrees(info->worst_error_rad) < 0.005) {
        printf("plain M       errs by less than 0.01 degrees for every normal%s\n",
            info->mirrored ? ", once faces are reversed" : "");
        return;
    }
    if (info->worst_error_rad <= 1e-7) {
        printf("plain M       is right in direction for every normal%s\n",
            info->mirrored ? ", once faces are reversed" : "");
        return;
    }
    for (int i = 0; i < 3; ++i) worst[i] = (double)info->worst_normal[i];
    carry(upper, info->worst_normal, plain);
    carry(found->normal, info->worst_normal, right);
    printf("plain M       errs by up to %s degrees",
        cli_decimals(degrees, cli_to_degrees(info->worst_error_rad), 2));
    print_direction(", for n = ", worst);
    print_direction(":\n              M n is along ", plain);
    print_direction(", right is ", right);
    printf("\n");
}

static void print_shortcut(matrix_answer *found) {
    printf("\nShortcut: ");
    switch (found->shortcut) {
    case NORMA_SHORTCUT_ROTATION:
        printf("M itself, nothing to renormalise\n");
        return;
    case NORMA_SHORTCUT_UNIFORM_SCALE:
        printf("M itself, renormalised\n");
        return;
    case NORMA_SHORTCUT_NONE:
        printf(is_zero(found->normal) ? "none\n" : "none; use the normal matrix\n");
        return;
    case NORMA_SHORTCUT_AXIS_SCALE:
        break;
    }
    printf("M (n / s^2), s the lengths of M's columns: no inverse needed\n");
    if (!norma_axis_scale_matrix(found->model, found->axis_scale)) print_rows(found->axis_scale, 3);
}

static void print_matrix(matrix_answer *found) {
    const norma_matrix_info *info = &found->info;
    printf("M, row by row\n");
    print_rows(found->model, 4);
    printf("\nkind          %s: %s\n", cli_kind_name(info->kind), meaning(found));
    printf("mirrored      %s\n",
        info->mirrored ? "yes: reverse the winding of faces, or they face inward" : "no");
    printf("rank          %d\n", info->rank);
    printf("determinant   %.7g\n", tidy(info->determinant));
    if (isfinite(info->anisotropy))
        printf("anisotropy    %.7g (largest stretch over smallest)\n", info->anisotropy);
    else
        printf(
            "anisotropy    %s\n", info->determinant != 0 ? "beyond 1e6" : "infinite (flattened)");
    print_worst(found);
    printf("\nNormal matrix: %s\n",
        is_zero(found->normal) ? "all zeros, because no normal exists"
        : info->mirrored
            ? "transforms normals correctly if faces are reversed; renormalise after it"
            : "transforms normals correctly; renormalise after it");
    print_rows(found->normal, 3);
    printf("\nCofactor matrix: the area vectors of faces, cof(M)(a x b) = Ma x Mb\n");
    print_rows(found->cofactor, 3);
    if (found->has_inverse) {
        printf("\nInverse transpose: cof(M) / det(M)\n");
        print_rows(found->inverse_transpose, 3);
    } else {
        printf("\nInverse transpose: (singular)\n");
    }
    print_shortcut(found);
}

/* ---- the command */

static int matrix_run(const cli_subcommand *command, int count, char **arguments) {
    cli_matrix matrix = cli_matrix_identity;
    cli_common common = {0};
    cli_words words = {0};
    const cli_table tables[] = {
        {cli_matrix_options, cli_matrix_option_count, &matrix},
        {cli_common_options, cli_common_option_count, &common},
    };
    matrix_answer found;
    int status = cli_parse(command, tables, CLI_COUNT(tables), count, arguments, &words);
    if (status) return status;
    if (!matrix.given)
        return cli_usage(command, "no matrix was given; expected --scale, --rotate, --translate or "
                                  "--matrix, as in: " NORMA_PROGRAM " matrix --scale 2,0.5,1");
    status = answer(command, matrix.matrix, &found);
    if (status) return status;
    if (common.json)
        write_matrix_json(&found);
    else
        print_matrix(&found);
    return cli_finish(CLI_OK);
}

const cli_subcommand cli_subcommand_matrix = {"matrix",
    "shows what a matrix does to normals, and which matrix is correct", matrix_help, matrix_run};

/* ---- norma transform */

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
    work->leaves_normals = !is_zero(normal_matrix);
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
