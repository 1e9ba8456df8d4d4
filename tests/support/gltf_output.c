/* gltf_output.c: a changed GLB as it was written, for tests. */
#include "gltf_output.h"
#include "check.h"

gltf_output output_of(norma_document *document) {
    gltf_output out = {.notes = ""};
    json_error failed;
    out.bytes = bytes_of(document);
    for (size_t i = 0; i < norma_document_note_count(document); ++i)
        snprintf(out.notes + strlen(out.notes), sizeof out.notes - strlen(out.notes), "%s\n",
            norma_document_note(document, i));
    norma_document_close(document);
    out.document = bytes_open(out.bytes, "out.glb");
    const size_t length =
        out.bytes.data[12] | (size_t)out.bytes.data[13] << 8 | (size_t)out.bytes.data[14] << 16;
    assert_true(
        norma_json_parse((const char *)out.bytes.data + 20, length, NULL, &out.json, &failed));
    return out;
}

void output_free(gltf_output *output) {
    norma_json_free(&output->json);
    norma_document_close(output->document);
    bytes_free(&output->bytes);
}

gltf_output output_transformed(gltf_asset *a, const char *rest, int bake, const double *matrix) {
    norma_transform_options options = {.struct_size = sizeof options, .bake = bake};
    norma_document_error error;
    norma_document *document = asset_open(a, rest, 0);
    if (matrix) memcpy(options.matrix, matrix, sizeof options.matrix);
    if (norma_document_transform(document, &options, NULL, &error)) fail_msg("%s", error.message);
    return output_of(document);
}

void output_finish(gltf_output *output, gltf_asset *a) {
    output_free(output);
    asset_free(a);
}

const char *output_text(const gltf_output *output, const char *path) {
    static char text[4000];
    uint32_t token = 0;
    for (const char *at = path; *at && token != JSON_NONE;) {
        char part[60];
        const size_t length = strcspn(at, "/");
        snprintf(part, sizeof part, "%.*s", (int)length, at);
        token = *part >= '0' && *part <= '9'
                    ? norma_json_element(&output->json, token, (uint32_t)strtoul(part, NULL, 10))
                    : norma_json_member(&output->json, token, part);
        at += length + (at[length] == '/');
    }
    if (token == JSON_NONE) return "";
    snprintf(text, sizeof text, "%.*s",
        (int)(output->json.tokens[token].end - output->json.tokens[token].start),
        output->json.text + output->json.tokens[token].start);
    return text;
}

long output_number(const gltf_output *output, const char *path, long number) {
    char whole[200] = "";
    const char *place = strstr(path, "%ld");
    if (place)
        snprintf(whole, sizeof whole, "%.*s%ld%s", (int)(place - path), path, number, place + 3);
    const char *text = output_text(output, place ? whole : path);
    return *text ? strtol(text, NULL, 10) : -1;
}

const unsigned char *output_bytes(const gltf_output *output, long accessor) {
    const unsigned char *file = output->bytes.data,
                        *bin =
                            file + 28 + (file[12] | (size_t)file[13] << 8 | (size_t)file[14] << 16);
    const long view = output_number(output, "accessors/%ld/bufferView", accessor),
               offset = output_number(output, "bufferViews/%ld/byteOffset", view);
    return bin + (offset < 0 ? 0 : offset);
}

norma_mesh_data output_mesh(const gltf_output *output, size_t mesh) {
    norma_mesh_data data;
    norma_document_error error;
    if (norma_document_mesh_data(output->document, mesh, &data, &error))
        fail_msg("%s", error.message);
    return data;
}

void assert_vector(
    const norma_vec3_view *view, size_t index, const double expected[3], double tolerance) {
    const double same[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    static const size_t sizes[] = {12, 24, 3, 3, 6, 6};
    double is[3];
    norma_vec3_view one = *view;
    assert_true(index < view->count);
    one.data = (const unsigned char *)view->data +
               index * (view->stride ? view->stride : sizes[view->format]);
    one.count = 1;
    assert_ok(norma_transform_positions_double(same, one, is, 0, 1));
    for (int k = 0; k < 3; ++k)
        if (!(fabs(is[k] - expected[k]) <= tolerance))
            fail_msg("vector %zu is %g %g %g, expected %g %g %g", index, is[0], is[1], is[2],
                expected[0], expected[1], expected[2]);
}

void assert_corners(
    const gltf_output *output, size_t mesh, const uint32_t *expected, size_t count) {
    norma_mesh_data data = output_mesh(output, mesh);
    assert_int_equal(data.mesh.corner_count, count);
    for (size_t i = 0; i < count; ++i)
        assert_int_equal(((const uint32_t *)data.mesh.corners)[i], expected[i]);
}
