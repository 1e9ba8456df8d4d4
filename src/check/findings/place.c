/* place.c: how a place in the file is named, and which rules its owner switched off there. */
#include "check/findings/check_run.h"
#include <string.h>

void norma_check_silence(uint8_t mask[CHECK_RULE_COUNT], const char *ignore) {
    uint8_t silenced[CHECK_RULE_COUNT] = {0};
    char word[64];
    while (ignore && *ignore) {
        size_t length = strcspn(ignore, ",");
        if (length < sizeof word) {
            memcpy(word, ignore, length);
            word[length] = 0;
            (void)norma_rules_select(word, silenced, NULL);
        }
        ignore += length + (ignore[length] != 0);
    }
    for (size_t i = 0; i < CHECK_RULE_COUNT; i++)
        if (silenced[i]) mask[i] = 0;
}

void norma_check_label(const norma_mesh_info *info, char label[CHECK_MESSAGE]) {
    const char *name = info->name ? info->name : "";
    label[0] = 0;
    if (info->where && *info->where)
        norma_check_message(label, *name ? "mesh %z primitive %z \"%s\"" : "mesh %z primitive %z",
            info->mesh, info->primitive, name);
}

int norma_check_siblings(const norma_mesh_info *first, const norma_mesh_info *second) {
    return first->mesh == second->mesh && second->primitive > first->primitive;
}
