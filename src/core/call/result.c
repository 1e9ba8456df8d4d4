/* result.c: the text of every result, in one place, the names of weights, and the version. */
#include "core/call/weight.h"

#define TEXT_OF(number)              #number
#define VERSION(major, minor, patch) TEXT_OF(major) "." TEXT_OF(minor) "." TEXT_OF(patch)

const char *norma_result_text(norma_result result) {
    switch (result) {
    case NORMA_OK:
        return "Done.";
    case NORMA_CANCELLED:
        return "Cancelled by the progress callback.";
    case NORMA_ERROR_ARGUMENT:
        return "An argument is missing, not a number, out of its range, or contradicts another.";
    case NORMA_ERROR_CAPACITY:
        return "An output buffer is too small for what would be written.";
    case NORMA_ERROR_INDEX:
        return "A corner names a position that does not exist.";
    case NORMA_ERROR_MEMORY:
        return "Memory could not be allocated.";
    case NORMA_ERROR_OVERFLOW:
        return "Counts times strides exceed the range of size_t.";
    }
    return "Unknown result code.";
}

#define NAME_OF(constant, name, by, formula, unused)                                               \
    case NORMA_WEIGHT_##constant:                                                                  \
        return name;

const char *norma_weight_name(norma_weight weight) {
    switch (weight) { CORE_WEIGHTS(NAME_OF, ) }
    return NULL;
}

const char *norma_version(void) {
    return VERSION(NORMA_VERSION_MAJOR, NORMA_VERSION_MINOR, NORMA_VERSION_PATCH);
}

uint32_t norma_version_number(void) { return NORMA_VERSION; }
