/* file_roundtrip.c: opens a mesh file of any format, says what is in it, computes its normals and
 * saves a copy.
 *
 *     file_roundtrip IN OUT */
#include <norma/document.h>
#include <stdio.h>

static int failed(const norma_document_error *error) {
    fprintf(stderr, "%s\n", error->message);
    return 3;
}

int main(int argc, char **argv) {
    if (argc != 3) {
        fprintf(stderr, "usage: %s IN OUT\n", argv[0]);
        return 2;
    }
    norma_document *document;
    norma_document_error error;
    if (norma_document_open(argv[1], NULL, &document, &error) != NORMA_DOCUMENT_OK)
        return failed(&error);

    for (size_t i = 0; i < norma_document_mesh_count(document); ++i) {
        norma_mesh_info info;
        if (norma_document_mesh_info(document, i, &info) != NORMA_DOCUMENT_OK) continue;
        printf("mesh %zu \"%s\": %zu vertices, %zu faces%s%s\n", i, info.name, info.vertices,
            info.faces, info.not_read ? ", not read: " : "", info.not_read ? info.not_read : "");
    }

    const norma_compute_options options = {
        .struct_size = sizeof options, .threads = NORMA_ALL_THREADS};
    norma_compute_summary summary;
    int status = 0;
    if (norma_document_compute(document, &options, &summary, &error) != NORMA_DOCUMENT_OK ||
        norma_document_save(document, argv[2], NULL, &error) != NORMA_DOCUMENT_OK)
        status = failed(&error);
    else
        printf("%zu vertices became %zu; %zu had no normal of their own\n", summary.vertices_before,
            summary.vertices_after, summary.filled);
    for (size_t i = 0; i < norma_document_note_count(document); ++i)
        printf("note: %s\n", norma_document_note(document, i));
    norma_document_close(document);
    return status;
}
