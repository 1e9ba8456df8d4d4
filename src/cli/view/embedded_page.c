/* embedded_page.c: the page lies in the tool as read-only data. NORMA_PAGE_FILE is its path, where
 * the build made one (-DNORMA_WEB=ON). */
#include "cli/view/embedded_page.h"

#if defined(NORMA_PAGE_FILE)
#if defined(__APPLE__)
#define SECTION    ".const_data"
#define NAME(name) "_" name
#else
#define SECTION    ".section .rodata"
#define NAME(name) name
#endif
__asm__(SECTION
    "\n"
    ".globl " NAME(
        "norma_page_begin") "\n"
                            ".globl " NAME(
                                "norma_page_end") "\n"
                                                  ".balign 16\n" NAME(
                                                      "norma_page_begin") ":\n"
                                                                          ".incbin "
                                                                          "\"" NORMA_PAGE_FILE
                                                                          "\"\n" NAME("norma_page_"
                                                                                      "end") ":\n"
                                                                                             ".byte"
                                                                                             " 0\n"
                                                                                             ".text"
                                                                                             "\n");
extern const char norma_page_begin[], norma_page_end[];

const char *view_page(size_t *size) {
    *size = (size_t)(norma_page_end - norma_page_begin);
    return norma_page_begin;
}
#else
const char *view_page(size_t *size) {
    *size = 0;
    return NULL;
}
#endif
