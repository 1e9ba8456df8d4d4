# An overlay port: vcpkg install norma --overlay-ports=packaging/vcpkg. It builds the tree that it lies in.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

vcpkg_check_features(OUT_FEATURE_OPTIONS options
  FEATURES
    files NORMA_FILES
    tool NORMA_TOOL
    tool NORMA_WITH_IMAGES
    tool NORMA_WITH_RENDER
    meshopt NORMA_WITH_MESHOPTIMIZER
    meshopt NORMA_MESHOPTIMIZER_PACKAGE)
string(COMPARE EQUAL "${VCPKG_LIBRARY_LINKAGE}" "dynamic" shared)

vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS
    ${options}
    -DNORMA_SHARED=${shared}
    -DNORMA_TESTS=OFF
    -DNORMA_BITS=OFF
    -DNORMA_EXAMPLES=OFF
    -DNORMA_WEB=OFF
    -DNORMA_WITH_DRACO=OFF
    -DNORMA_INSTALL=ON)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(PACKAGE_NAME norma CONFIG_PATH lib/cmake/norma)
vcpkg_fixup_pkgconfig()
if("tool" IN_LIST FEATURES)
  vcpkg_copy_tools(TOOL_NAMES norma AUTO_CLEAN)
endif()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
file(INSTALL "${CMAKE_CURRENT_LIST_DIR}/usage" DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
