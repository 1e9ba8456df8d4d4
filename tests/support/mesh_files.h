/* mesh_files.h: the positions and polygons of OBJ, PLY and STL files, read as plainly as can be, so
 * that tests of the core need nothing of the library's own readers; and the list of what the data
 * set holds. */
#ifndef NORMA_TESTS_MESH_FILES_H
#define NORMA_TESTS_MESH_FILES_H
#include <norma/norma.h>

typedef struct mesh_file {
    double (*positions)[3];
    size_t position_count, position_room;
    uint32_t *corners;
    size_t corner_count, corner_room;
    uint32_t *starts; /* face_count + 1 */
    size_t face_count, face_room;
} mesh_file;

/* 0, or -1 where the file is not there or is not what its extension says; then the mesh is empty.
 * Every corner names a position. */
int mesh_file_load(const char *path, mesh_file *mesh);
void mesh_file_free(mesh_file *mesh);

/* Views of it: without face_starts where all faces are triangles; with them always; the third one
 * as the first, over floats (position_count * 3) rounded from the doubles. */
norma_mesh mesh_file_view(const mesh_file *mesh);
norma_mesh mesh_file_view_polygons(const mesh_file *mesh);
norma_mesh mesh_file_view_float(const mesh_file *mesh, float *floats);

/* Builds a mesh by hand. */
void mesh_file_add_position(mesh_file *mesh, double x, double y, double z);
void mesh_file_add_face(mesh_file *mesh, const uint32_t *corners, size_t count);

/* The data set's folder: NORMA_DATA, else ../shared/data beside the source tree; NULL where it is
 * not there. */
const char *data_folder(void);
/* The committed meshes. */
const char *assets_folder(void);

/* Calls visit with the path of every file that DATA/INDEX.tsv names, in its order; returns how
 * many. */
size_t data_for_each(
    const char *folder, void (*visit)(void *user, const char *path, const char *name), void *user);
#endif
