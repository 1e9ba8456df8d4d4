/* decimate.h: fewer triangles of a mesh, for a page that would be too large with all of them. */
#ifndef NORMA_CLI_VIEW_DECIMATE_H
#define NORMA_CLI_VIEW_DECIMATE_H
#include "web/page/model/model_pack.h"

/* As view_pack_options.decimate. Without meshoptimizer the mesh is left as it is. */
int view_decimate(const norma_mesh *mesh, size_t most_triangles, view_decimated *decimated);
#endif
