/* draco_calls.cpp: src/io/gltf/draco_decoder.cpp as a module of its own. Nothing here throws:
 * where libdraco would, the module traps, and JavaScript drops it. A damaged stream can so harm
 * nothing else. */
#include "io/gltf/draco_decoder.h"
#include "../wasm/exports.h"
#include <cstdlib>
#include <new>

static int is_out_of_memory;

void *operator new(size_t size) {
    void *block = std::malloc(size ? size : 1);
    if (block) return block;
    is_out_of_memory = 1;
    __builtin_trap();
}
void *operator new[](size_t size) { return operator new(size); }
void operator delete(void *block) noexcept { std::free(block); }
void operator delete[](void *block) noexcept { std::free(block); }
void operator delete(void *block, size_t) noexcept { std::free(block); }
void operator delete[](void *block, size_t) noexcept { std::free(block); }

extern "C" {
void *WEB_EXPORT(draco_allocate)(size_t size) { return std::malloc(size); }
void WEB_EXPORT(draco_release)(void *block) { std::free(block); }
draco_result WEB_EXPORT(draco_decode)(const draco_stream *stream, size_t *found) {
    return norma_draco_decode(stream, found);
}
/* After a trap: whether memory was the reason. */
int WEB_EXPORT(draco_is_out_of_memory)(void) { return is_out_of_memory; }
}
