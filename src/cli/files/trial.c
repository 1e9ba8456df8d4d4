/* trial.c: one triangle in each format of a batch is changed first. What the format as such refuses
 * (creases in an STL) is then refused before any file is written. */
#include "cli/files/trial.h"
#include "cli/process/errors.h"
#include <string.h>

static const char *triangle_in(norma_file_format format) {
    switch (format) {
    case NORMA_FILE_OBJ:
        return "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    case NORMA_FILE_PLY:
        return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
               "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
               "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    case NORMA_FILE_STL:
        return "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
               "endloop\nendfacet\nendsolid\n";
    default:
        return "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
               "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
               "\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
               "\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}],\"bufferViews\":[{"
               "\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,\"uri\":\"data:"
               "application/octet-stream;base64,"
               "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}";
    }
}

static int try_format(const cli_changer *changer, const char *input, norma_file_format kind) {
    const norma_document_options options = {.struct_size = sizeof options, .format = kind};
    const char *text = triangle_in(kind);
    norma_document *document;
    norma_document_error error = {0};
    norma_document_result result =
        norma_document_open_memory(text, strlen(text), input, &options, &document, &error);
    if (!result) {
        result = changer->change(changer->work, document, NULL, NULL, &error);
        norma_document_close(document);
    }
    if (result != NORMA_DOCUMENT_ERROR_ARGUMENT) return CLI_OK; /* told of the file itself */
    cli_print_error(&error);
    return CLI_USAGE;
}

int cli_try_formats(const cli_files *files, const cli_changer *changer) {
    int tried = 0, status = CLI_OK;
    for (size_t i = 0; files->inputs.count > 1 && i < files->inputs.count && !status; ++i) {
        const char *input = files->inputs.paths[i];
        norma_file_format kind = files->format ? files->format : norma_file_format_of_path(input);
        if (kind == NORMA_FILE_UNKNOWN) continue;
        if (kind == NORMA_FILE_GLB) kind = NORMA_FILE_GLTF;
        if (!(tried & 1 << kind)) status = try_format(changer, input, kind);
        tried |= 1 << kind;
    }
    return status;
}
