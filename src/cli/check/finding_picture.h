/* finding_picture.h: a small drawing of a finding's place, as SVG. */
#ifndef NORMA_CLI_CHECK_PICTURE_H
#define NORMA_CLI_CHECK_PICTURE_H
#include "cli/check/check_command.h"
/* Writes an <svg> of the surface round the worst place of a finding, the faces that it names in
 * red; nothing where it names no place. */
void check_draw_finding(FILE *out, norma_document *document, const norma_finding *finding);
#endif
