/* embedded_page.h: the page as it was built into the tool, the model's place in it empty. */
#ifndef NORMA_CLI_VIEW_PAGE_H
#define NORMA_CLI_VIEW_PAGE_H
#include <stddef.h>

/* NULL where the tool was built without it. Where a model goes in stand, once each, the three
 * marks.
 */
const char *view_page(size_t *size);
#define VIEW_PAGE_NAME  "/*NAME*/"
#define VIEW_PAGE_MODEL "/*MODEL*/"
#define VIEW_PAGE_FILES "/*FILES*/"
#endif
