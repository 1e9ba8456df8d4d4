/* message.h: error messages as tests expect them: whole, or the part before what was found, which
 * is a piece of the file. */
#ifndef NORMA_TEST_MESSAGE_H
#define NORMA_TEST_MESSAGE_H
#include <string.h>

static inline int is_message(const char *message, const char *expected) {
    const size_t length = strlen(expected);
    const int cut = length > 8 && strcmp(expected + length - 8, "; found ") == 0;
    return cut ? strncmp(message, expected, length) == 0 && message[length] != '\0'
               : strcmp(message, expected) == 0;
}
#define assert_message(message, expected)                                                          \
    do {                                                                                           \
        if (!is_message(message, expected))                                                        \
            fail_msg("\"%s\"\n   expected \"%s\"", message, expected);                             \
    } while (0)
#endif
