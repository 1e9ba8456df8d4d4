# What `cmake --install` gives: headers, both libraries, the tool, a CMake package, a pkg-config file, manual pages, shell completions.
include(CMakePackageConfigHelpers)

install(TARGETS ${norma_libraries} norma-cli EXPORT norma-targets)
install(DIRECTORY include/norma DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/norma)
configure_package_config_file(cmake/norma-config.cmake.in norma-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(norma-config-version.cmake COMPATIBILITY SameMinorVersion)
install(EXPORT norma-targets NAMESPACE norma:: DESTINATION ${package_dir})
install(FILES ${CMAKE_BINARY_DIR}/norma-config.cmake ${CMAKE_BINARY_DIR}/norma-config-version.cmake DESTINATION ${package_dir})

# Relative to the file itself, so that an installed tree can be moved.
file(RELATIVE_PATH pc_prefix /root/${CMAKE_INSTALL_LIBDIR}/pkgconfig /root)
configure_file(cmake/norma.pc.in norma.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/norma.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

foreach(section 1 3 5 7)
  file(GLOB pages CONFIGURE_DEPENDS docs/man/*.${section})
  if(pages)
    install(FILES ${pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man${section})
  endif()
endforeach()
# Each function that a page of section 3 names is found by its own name too.
file(GLOB library_pages docs/man/*.3)
foreach(page ${library_pages})
  get_filename_component(page_name ${page} NAME_WE)
  file(STRINGS ${page} names REGEX "^\\.Nm norma_")
  foreach(name ${names})
    string(REGEX REPLACE "^\\.Nm ([a-z0-9_]+).*" "\\1" name ${name})
    if(NOT name STREQUAL page_name)
      file(WRITE ${CMAKE_BINARY_DIR}/man/${name}.3 ".so man3/${page_name}.3\n")
      install(FILES ${CMAKE_BINARY_DIR}/man/${name}.3 DESTINATION ${CMAKE_INSTALL_MANDIR}/man3)
    endif()
  endforeach()
endforeach()
install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
