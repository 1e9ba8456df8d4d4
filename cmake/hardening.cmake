# Flags against exploits, in every build without a sanitizer: stack protector, checked string functions (optimised builds), control-flow protection where the processor has
# it, position-independent code, relocations read-only and resolved at once, no executable stack. tests/repo/hygiene.sh reads them from what was built.
include(CheckCCompilerFlag)
if(NOT WIN32) # there they need a library of their own
  add_compile_options(-fstack-protector-strong $<$<CONFIG:Release,RelWithDebInfo>:-U_FORTIFY_SOURCE> $<$<CONFIG:Release,RelWithDebInfo>:-D_FORTIFY_SOURCE=2>)
endif()
check_c_compiler_flag(-fcf-protection=full NORMA_HAS_CF_PROTECTION)
if(NORMA_HAS_CF_PROTECTION AND NOT WIN32)
  add_compile_options(-fcf-protection=full)
endif()
if(NOT WIN32 AND NOT APPLE)
  add_link_options(-Wl,-z,relro -Wl,-z,now -Wl,-z,noexecstack)
endif()
