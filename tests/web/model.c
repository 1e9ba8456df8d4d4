/* model.c: what the page makes of files, natively and under the address sanitizer: packed, opened,
 * computed, held against what is stored; and packs with bytes changed at random, which must be
 * refused or drawn, never read beyond.   model FILE... */
#include "../../web/page/model/model.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

norma_result model_compute(
    model *m, uint32_t index, int wanted, norma_weight weight, norma_weld weld, double crease_deg);
double model_errors(model *m, uint32_t index);
int model_pick(const model *m, uint32_t index, const double numbers[6], double found[5]);

uint32_t model_finding_count(const model *m);
void model_finding_numbers(const model *m, uint32_t index, double numbers[5]);
const char *model_finding_text(const model *m, uint32_t index, uint32_t which);
const uint8_t *model_marks(model *m, uint32_t index, uint32_t which);
int model_finding_place(const model *m, uint32_t index, uint32_t which, double out[7]);

static unsigned char *copy_of(const view_pack *pack) {
    unsigned char *copy = malloc(pack->size ? pack->size : 1);
    if (!copy) exit(3);
    memcpy(copy, pack->bytes, pack->size);
    return copy;
}

/* The texts end, the places are numbers, and a finding with faces colours some. */
static void use_findings(model *m, int undamaged) {
    for (uint32_t i = 0; i < model_finding_count(m) && model_finding_count(m) != VIEW_PACK_NONE;
         ++i) {
        double numbers[5], place[7];
        model_finding_numbers(m, i, numbers);
        for (uint32_t which = 0; which < 5; ++which)
            if (strlen(model_finding_text(m, i, which)) > 10000) exit(7);
        for (uint32_t which = 0; which < 5; ++which)
            if (model_finding_place(m, i, which, place) && undamaged &&
                !(fabs(place[0]) <= 1.01 && place[6] >= 0))
                exit(8);
        for (uint32_t mesh = 0; mesh < m->head->mesh_count; ++mesh)
            if (!model_marks(m, mesh, i)) exit(9);
    }
    for (uint32_t mesh = 0; mesh < m->head->mesh_count; ++mesh)
        if (!model_marks(m, mesh, VIEW_PACK_NONE)) exit(9);
}

static void use(model *m) {
    use_findings(m, 1);
    for (uint32_t i = 0; i < m->head->mesh_count; ++i) {
        double found[5], worst = 0;
        for (int wanted = 0; wanted < 3; ++wanted)
            if (model_compute(m, i, wanted, NORMA_WEIGHT_ANGLE, NORMA_WELD_EXACT, 60)) exit(4);
        worst = model_errors(m, i);
        if (isnan(worst) || worst > 180.001) exit(5);
        const double ray[6] = {0.01, 0.02, 3, 0, 0, -1};
        model_pick(m, i, ray, found);
        for (size_t k = 0; k < 9 * m->meshes[i].triangle_count; ++k)
            if (!(fabsf(m->meshes[i].draw_positions[k]) <= 1.0001f)) exit(6);
    }
}

static uint32_t next_random(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

static void damage(const view_pack *pack, uint32_t *state) {
    unsigned char *bytes = copy_of(pack);
    for (int i = 0; i < 4; ++i)
        bytes[next_random(state) % (i < 2                 ? pack->size
                                       : pack->size < 400 ? pack->size
                                                          : 400)] =
            (unsigned char)next_random(state);
    for (int i = 0; i < 2; ++i)
        bytes[pack->size - 1 - next_random(state) % (pack->size < 200 ? pack->size : 200)] =
            (unsigned char)next_random(state);
    model *m = model_open(bytes, pack->size);
    if (m) {
        use_findings(m, 0);
        model_close(m);
    }
}

int main(int count, char **files) {
    uint32_t state = 1;
    int opened = 0;
    for (int i = 1; i < count; ++i) {
        norma_document *document = NULL;
        norma_document_error error = {0};
        const norma_document_options options = {.struct_size = sizeof options, .lenient = 1};
        view_pack pack = {0};
        if (norma_document_open(files[i], &options, &document, &error) == NORMA_DOCUMENT_OK &&
            view_pack_document(document, &(view_pack_options){.threads = 1}, &pack, &error) ==
                NORMA_DOCUMENT_OK) {
            model *m = model_open(copy_of(&pack), pack.size);
            if (!m) {
                fprintf(stderr, "%s: its own pack is refused\n", files[i]);
                return 1;
            }
            use(m);
            model_close(m);
            ++opened;
            for (int k = 0; k < (pack.size < 100000 ? 300 : 10); ++k) damage(&pack, &state);
        }
        free(pack.bytes);
        norma_document_close(document);
    }
    printf("%d of %d files\n", opened, count - 1);
    return opened ? 0 : 1;
}
