/* info_report.c: what is in a file, as JSON and for people. */
#include "cli/info/info.h"
#include "cli/files/files.h"
#include <math.h>
#include <norma/check.h>
#include <string.h>

/* ---- meshes: the primitives of one glTF mesh follow each other */

static size_t mesh_end(const contents *found, size_t first) {
    size_t end = first + 1;
    while (end < found->part_count && found->parts[end].info.mesh == found->parts[first].info.mesh)
        ++end;
    return end;
}

static const char *const storage_names[] = {"none", "vertex", "corner", "facet"};

/* What a mesh has is what every part of it with faces has. */
static norma_normal_storage storage_of(
    const contents *found, size_t first, size_t end, const char **encoding) {
    norma_normal_storage storage = NORMA_NORMALS_NONE;
    *encoding = "";
    for (size_t i = first; i < end; ++i) {
        const norma_mesh_info *info = &found->parts[i].info;
        if (info->faces == 0 && end - first > 1) continue;
        if (info->normals == NORMA_NORMALS_NONE) {
            *encoding = "";
            return NORMA_NORMALS_NONE;
        }
        storage = info->normals;
        *encoding =
            **encoding == '\0' || strcmp(*encoding, info->encoding) == 0 ? info->encoding : "mixed";
    }
    return storage;
}

static void kind_of(const norma_node_info *node, norma_matrix_info *matrix) {
    double normal_matrix[9];
    *matrix = (norma_matrix_info){.kind = NORMA_KIND_SINGULAR, .anisotropy = INFINITY};
    norma_normal_matrix_double(node->world, NORMA_WINDING_REVERSED, normal_matrix, matrix);
}

/* ---- for programs */

/* Ends the object that is open. */
static void write_off(cli_json *json, const off_by *off) {
    cli_json_print(
        json, "p50_deg: %g, p99_deg: %g, max_deg: %g}", off->p50_deg, off->p99_deg, off->max_deg);
}

static void write_explained(cli_json *json, const cli_explained *explained) {
    cli_json_print(json, "explained_by: {shading: %s, weight: %s, crease_deg: %g",
        explained->flat                ? "flat"
        : isnan(explained->crease_deg) ? "smooth"
                                       : "crease",
        explained->flat ? NULL : norma_weight_name(explained->weight),
        explained->flat ? NAN : explained->crease_deg);
    write_off(json, &explained->off);
}

static const char *way_word(norma_tangent_source source) {
    static const char *const words[] = {
        [NORMA_TANGENTS_BY_MIKK] = "mikktspace-triangles",
        [NORMA_TANGENTS_BY_MIKK_ON_QUADS] = "mikktspace-quads",
        [NORMA_TANGENTS_BY_VERTEX_SUMS] = "vertex-sums",
        [NORMA_TANGENTS_BY_MESHOPT] = "meshoptimizer",
        [NORMA_TANGENTS_BY_STEADY] = "steady",
    };
    return words[source];
}

/* Under the tangents that a renderer makes in this way. */
static void write_map_error(
    cli_json *json, norma_tangent_source renderer, const norma_map_error *error) {
    const off_by off = off_in_degrees(error->p50_rad, error->p99_rad, error->max_rad);
    cli_json_open(json, way_word(renderer), '{');
    write_off(json, &off);
}

static void write_explained_tangents(cli_json *json, const cli_explained_tangents *explained) {
    const norma_tangent_deviation *deviation = &explained->deviation;
    cli_json_print(json,
        "tangents_explained_by: {way: %s, texture_transform: %d, sign: %s, signs_other: %zu, "
        "corners: %zu, explained: %zu, p50_deg: %g, p99_deg: %g, max_deg: %g, map_error: {",
        way_word(deviation->source), deviation->transformed,
        deviation->negated ? "negated" : "as-is", deviation->signs_other, deviation->corners,
        deviation->explained, explained->off.p50_deg, explained->off.p99_deg,
        explained->off.max_deg);
    write_map_error(json, NORMA_TANGENTS_BY_MIKK, &deviation->under_mikk);
    write_map_error(json, NORMA_TANGENTS_BY_MESHOPT, &deviation->under_meshopt);
    write_map_error(json, NORMA_TANGENTS_BY_VERTEX_SUMS, &deviation->under_vertex_sums);
    cli_json_print(json, "}}");
}

static void write_info_part(cli_json *json, const mesh_part *part) {
    const norma_mesh_info *info = &part->info;
    cli_json_print(json,
        "{where: %s, vertices: %zu, faces: %zu, triangles: %zu, normals: %s, encoding: %s, "
        "tangents: %d, smoothing_groups: %d, morph_targets: %zu, compression: %s, not_read: %s",
        info->where, info->vertices, info->faces, info->triangles, storage_names[info->normals],
        info->encoding, info->has_tangents, info->has_smoothing_groups, info->morph_targets,
        info->compression, info->not_read);
    if (part->closed >= 0) cli_json_bool(json, "closed", part->closed);
    if (part->is_explained) write_explained(json, &part->explained);
    if (part->has_explained_tangents) write_explained_tangents(json, &part->tangents);
    cli_json_close(json, '}');
}

static void write_mesh(cli_json *json, const contents *found, size_t first, size_t end) {
    size_t vertices = 0, faces = 0;
    const char *encoding;
    norma_normal_storage storage = storage_of(found, first, end, &encoding);
    for (size_t i = first; i < end; ++i) {
        vertices += found->parts[i].info.vertices;
        faces += found->parts[i].info.faces;
    }
    cli_json_print(json,
        "{name: %s, vertices: %zu, faces: %zu, normals: %s, encoding: %s, primitives: [",
        found->parts[first].info.name, vertices, faces, storage_names[storage], encoding);
    for (size_t i = first; i < end; ++i) write_info_part(json, &found->parts[i]);
    cli_json_print(json, "]}");
}

static void write_nodes(cli_json *json, const contents *found) {
    norma_matrix_info matrix;
    cli_json_open(json, "nodes", '[');
    for (size_t i = 0; i < found->node_count; ++i) {
        const norma_node_info *node = &found->nodes[i];
        kind_of(node, &matrix);
        cli_json_print(json,
            "{name: %s, kind: %s, mirrored: %d, anisotropy: %g, node: %zu, mesh: %zu, "
            "instances: %zu}",
            node->name, cli_kind_name(matrix.kind), matrix.mirrored, matrix.anisotropy, node->node,
            node->mesh, node->instances);
    }
    cli_json_close(json, ']');
}

static void write_bounds(cli_json *json, const info_bounds *bounds) {
    const double *least = bounds->least, *most = bounds->most;
    if (bounds->known)
        cli_json_print(json, "bounds: [[%g, %g, %g], [%g, %g, %g]]", least[0], least[1], least[2],
            most[0], most[1], most[2]);
    else
        cli_json_null(json, "bounds");
}

static void write_model(cli_json *json, const contents *found) {
    cli_json_string(json, "format", norma_file_format_name(found->format));
    write_bounds(json, &found->bounds);
    cli_json_print(json, "vertices: %zu, faces: %zu, triangles: %zu, skins: %zu, meshes: [",
        found->vertices, found->faces, found->triangles, found->skin_count);
    for (size_t first = 0; first < found->part_count; first = mesh_end(found, first))
        write_mesh(json, found, first, mesh_end(found, first));
    cli_json_close(json, ']');
    write_nodes(json, found);
    cli_json_notes(json, found->document);
}

void info_write_json(const contents *found, size_t count) {
    cli_json json = {.out = stdout};
    cli_json_print(&json, "{path: %s", found->path);
    if (count == 1) {
        write_model(&json, found);
    } else {
        cli_json_print(&json, "format: %s, tiles: [", norma_file_format_name(found->format));
        for (size_t i = 0; i < count; ++i) {
            cli_json_open(&json, NULL, '{');
            write_model(&json, &found[i]);
            cli_json_close(&json, '}');
        }
        cli_json_close(&json, ']');
    }
    cli_json_print(&json, "}\n");
}

void info_write_failure(const char *path, const norma_document_error *error) {
    cli_json json = {.out = stdout};
    cli_json_print(&json, "{path: %s, error: %s}\n", path, error->message);
}

/* ---- for people */

static void print_name(const char *name) {
    if (!name[0]) return;
    fputs(" \"", stdout);
    cli_write_outside(stdout, name);
    fputc('"', stdout);
}

static void print_off(const off_by *off) {
    char p50[32], p99[32], most[32];
    printf(": off by %s\302\260 at p50, %s\302\260 at p99, %s\302\260 at most",
        cli_decimals(p50, off->p50_deg, 3), cli_decimals(p99, off->p99_deg, 3),
        cli_decimals(most, off->max_deg, 3));
}

static void print_explained(const cli_explained *explained) {
    char crease[32];
    fputs("      stored normals are best explained by ", stdout);
    if (explained->flat)
        fputs("flat shading", stdout);
    else if (isnan(explained->crease_deg))
        printf("%s weights, smooth", norma_weight_name(explained->weight));
    else
        printf("%s weights, crease %s\302\260", norma_weight_name(explained->weight),
            cli_decimals(crease, explained->crease_deg, 3));
    print_off(&explained->off);
    putchar('\n');
}

static void print_map_error(norma_tangent_source renderer, const norma_map_error *error) {
    const off_by off = off_in_degrees(error->p50_rad, error->p99_rad, error->max_rad);
    printf("      a normal map baked for these, if a renderer makes tangents by %s",
        norma_tangent_source_name(renderer));
    print_off(&off);
    putchar('\n');
}

static void print_explained_tangents(const cli_explained_tangents *explained) {
    const norma_tangent_deviation *deviation = &explained->deviation;
    printf("      stored tangents are best explained by %s%s, sign %s",
        norma_tangent_source_name(deviation->source),
        deviation->transformed ? " through the texture transform" : "",
        deviation->negated ? "negated" : "as it is");
    print_off(&explained->off);
    fputs("; ", stdout);
    cli_count(stdout, deviation->explained);
    fputs(" of ", stdout);
    cli_counted(stdout, deviation->corners, "corner", "corners");
    fputs(" explained\n", stdout);
    print_map_error(NORMA_TANGENTS_BY_MIKK, &deviation->under_mikk);
    print_map_error(NORMA_TANGENTS_BY_MESHOPT, &deviation->under_meshopt);
    print_map_error(NORMA_TANGENTS_BY_VERTEX_SUMS, &deviation->under_vertex_sums);
}

static void print_part(const mesh_part *part) {
    const norma_mesh_info *info = &part->info;
    cli_counted(stdout, info->vertices, "vertex", "vertices");
    fputs(", ", stdout);
    cli_counted(stdout, info->faces, "face", "faces");
    if (info->triangles != info->faces) {
        fputs(" (", stdout);
        cli_counted(stdout, info->triangles, "triangle", "triangles");
        fputs(")", stdout);
    }
    if (info->normals == NORMA_NORMALS_NONE)
        fputs(", no normals", stdout);
    else
        printf(", normals per %s (%s)", storage_names[info->normals], info->encoding);
    fputs(info->has_tangents ? ", tangents" : "", stdout);
    fputs(info->has_smoothing_groups ? ", smoothing groups" : "", stdout);
    cli_part(stdout, ", ", info->morph_targets, "morph target", "morph targets");
    if (info->compression) printf(", compressed with %s", info->compression);
    if (part->closed >= 0) fputs(part->closed ? ", closed" : ", open", stdout);
    fputs("\n", stdout);
    if (info->not_read) {
        cli_say(stdout, "      cannot be computed or transformed: %s", info->not_read);
        fputs("\n", stdout);
    }
    if (part->is_explained) print_explained(&part->explained);
    if (part->has_explained_tangents) print_explained_tangents(&part->tangents);
}

/* Of a glTF file. */
static void print_mesh(const contents *found, size_t first, size_t end) {
    const norma_mesh_info *info = &found->parts[first].info;
    for (size_t i = first; i < end; ++i) {
        printf("  mesh %zu", info->mesh);
        print_name(info->name);
        if (end - first > 1) printf(" primitive %zu", found->parts[i].info.primitive);
        fputs(": ", stdout);
        print_part(&found->parts[i]);
    }
}

static void print_nodes(const contents *found) {
    norma_matrix_info matrix;
    for (size_t i = 0; i < found->node_count; ++i) {
        const norma_node_info *node = &found->nodes[i];
        kind_of(node, &matrix);
        printf("  node %zu", node->node);
        print_name(node->name);
        printf(" draws mesh %zu", node->mesh);
        if (node->instances != 1) {
            fputs(" in ", stdout);
            cli_counted(stdout, node->instances, "instance", "instances");
        }
        printf(": %s", cli_kind_name(matrix.kind));
        if (!isfinite(matrix.anisotropy))
            fputs(", flattened", stdout);
        else if (matrix.kind == NORMA_KIND_NON_UNIFORM_SCALE || matrix.kind == NORMA_KIND_SHEAR)
            printf(", anisotropy %.4g", matrix.anisotropy);
        fputs(matrix.mirrored ? ", mirrored\n" : "\n", stdout);
    }
}

static void print_bounds(const info_bounds *bounds) {
    char from[3][32], to[3][32];
    if (!bounds->known) return;
    for (int axis = 0; axis < 3; ++axis) {
        snprintf(from[axis], sizeof from[axis], "%.6g", bounds->least[axis] + 0.0);
        snprintf(to[axis], sizeof to[axis], "%.6g", bounds->most[axis] + 0.0);
    }
    printf("  from (%s, %s, %s) to (%s, %s, %s)\n", from[0], from[1], from[2], to[0], to[1], to[2]);
}

void info_print(const contents *found) {
    size_t meshes = 0;
    cli_say(stdout, "%s: ", cli_input_name(found->path));
    if (found->tile != SIZE_MAX) printf("tile %zu: ", found->tile);
    fputs(norma_file_format_name(found->format), stdout);
    if (found->part_count == 1 && !found->parts[0].info.where[0]) {
        print_name(found->parts[0].info.name);
        fputs(", ", stdout);
        print_part(&found->parts[0]);
        print_bounds(&found->bounds);
        return;
    }
    for (size_t first = 0; first < found->part_count; first = mesh_end(found, first)) ++meshes;
    fputs(", ", stdout);
    cli_counted(stdout, meshes, "mesh", "meshes");
    fputs(", ", stdout);
    cli_counted(stdout, found->vertices, "vertex", "vertices");
    fputs(", ", stdout);
    cli_counted(stdout, found->faces, "face", "faces");
    cli_part(stdout, ", ", found->skin_count, "skin", "skins");
    fputs("\n", stdout);
    print_bounds(&found->bounds);
    for (size_t first = 0; first < found->part_count; first = mesh_end(found, first))
        print_mesh(found, first, mesh_end(found, first));
    print_nodes(found);
}
