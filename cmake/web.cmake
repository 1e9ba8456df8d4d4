# The core as WebAssembly, the npm package and the page. clang with wasi-libc compiles; node, puts the files together; esbuild makes one script of the page's modules.
# Six modules: norma.wasm is the core; skin.wasm skins alone, for norma-mesh/skin; normals.wasm the calls of norma-mesh/normals, made small instead of fast; check.wasm the core with the readers of io and the rules, which the package loads when it first checks a
# file; tool.wasm the command line; page.wasm all that the page draws of; three.js draws it. All that the latter three import beside WASI are decoders: npm's draco3dgltf and meshoptimizer for
# compressed glTF, fflate for 3MF (web/package/decoders.js).
find_program(NORMA_WASM_CC NAMES clang)
find_program(NORMA_WASM_LD NAMES wasm-ld)
find_program(NORMA_NODE NAMES node nodejs)
find_program(NORMA_ESBUILD NAMES esbuild)
find_path(NORMA_WASI_INCLUDE NAMES wasm32-wasi/stdlib.h)
# Packages of npm: what scripts/install-deps.sh web puts there.
set(NORMA_WEB_MODULES ${PROJECT_SOURCE_DIR}/build/npm-bundled/node_modules CACHE PATH "The folder with the npm packages of web/package-lock.json")
find_file(NORMA_THREE NAMES three.module.js PATHS ${NORMA_WEB_MODULES}/three/build NO_DEFAULT_PATH)
if(NORMA_WASM_CC AND NOT NORMA_WASM_BUILTINS)
  execute_process(COMMAND ${NORMA_WASM_CC} --target=wasm32-wasi -print-libgcc-file-name OUTPUT_VARIABLE builtins OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(builtins AND EXISTS "${builtins}")
    set(NORMA_WASM_BUILTINS ${builtins} CACHE FILEPATH "clang's run-time library for WebAssembly")
  endif()
endif()
set(norma_why_page "")
foreach(tool NORMA_WASM_CC NORMA_WASM_LD NORMA_WASM_BUILTINS NORMA_NODE NORMA_ESBUILD NORMA_WASI_INCLUDE NORMA_THREE)
  if(NOT ${tool} AND NORMA_WEB STREQUAL "AUTO")
    set(norma_why_page "${tool} was not found (Debian: clang lld wasi-libc libclang-rt-dev-wasm32 nodejs esbuild; npm: three; scripts/install-deps.sh web)")
    return()
  elseif(NOT ${tool})
    message(FATAL_ERROR "The page needs clang, lld, wasi-libc, libclang-rt-dev-wasm32, nodejs, esbuild and npm's three (${tool}); scripts/install-deps.sh web installs what is missing, "
                        "-DNORMA_WEB=OFF builds without")
  endif()
endforeach()

set(norma_has_page ON)
set(web_dir ${PROJECT_BINARY_DIR}/web)
set(web_objects_dir ${web_dir}/objects)
file(MAKE_DIRECTORY ${web_objects_dir} ${web_dir}/npm)
# No SLP vectoriser: clang 14's, for WebAssembly, stores a product into its own factor before that is read (norma_gltf_matrix_multiply in place, nodes at wrong places).
set(web_flags --target=wasm32-wasi -std=c11 -DNDEBUG -msimd128 -fno-slp-vectorize -mbulk-memory -ftls-model=local-exec -ffp-contract=off -fno-math-errno -fno-trapping-math "-DNORMA_PROGRAM=\"npx norma-mesh\""
              -Wall -Wextra -Wpedantic -Wshadow -Wconversion -I${PROJECT_SOURCE_DIR}/include -I${PROJECT_SOURCE_DIR}/src)
if(NORMA_WERROR)
  list(APPEND web_flags -Werror)
endif()

# Files of the core that run seldom, or once for a mesh that moves: they are made small as well.
set(web_seldom "call_|topology_|mesh_nearest|plan_(plan_build|morph)")
string(APPEND web_seldom "|tangent_(steady|tangent_plan|tangent_vertices)|matrix_(matrix_info|encode|normal_matrix)|vertex_open_sum")
string(APPEND web_seldom "|corner_(star_fans|star.c|index_corners|normal_cone)|face_(face_exact|cut)")

# Compressed glTF.
set(web_has_meshopt OFF)
set(web_has_draco OFF)
if(NORMA_WITH_MESHOPTIMIZER AND EXISTS ${NORMA_WEB_MODULES}/meshoptimizer/meshopt_decoder.module.js)
  set(web_has_meshopt ON)
endif()
if(NORMA_WITH_DRACO AND EXISTS ${NORMA_WEB_MODULES}/draco3dgltf/draco_decoder_gltf.wasm)
  set(web_has_draco ON)
endif()
set(web_has_3mf OFF)
if(NORMA_WITH_3MF AND EXISTS ${NORMA_WEB_MODULES}/fflate/esm/browser.js)
  set(web_has_3mf ON)
  norma_part("page, npm: 3MF (fflate)" ON)
else()
  norma_part("page, npm: 3MF (fflate)" OFF "it is off, or its npm package was not found (scripts/install-deps.sh web)")
endif()
foreach(part meshopt draco)
  if(web_has_${part})
    norma_part("page, npm: compressed glTF (${part})" ON)
  else()
    norma_part("page, npm: compressed glTF (${part})" OFF "it is off, or its npm package was not found (scripts/install-deps.sh web)")
  endif()
endforeach()

# web_objects(LIST SOURCES...): one object file for each source, with the headers it was seen to include.
function(web_objects list)
  set(objects "")
  foreach(source ${ARGN})
    file(RELATIVE_PATH name ${PROJECT_SOURCE_DIR} ${source})
    string(REPLACE "/" "_" name ${name})
    set(object ${web_objects_dir}/${web_prefix_here}${name}.o)
    # Pages and packages are downloaded: kernels are made fast, where more code is faster; the readers and the rules small.
    if(web_prefix_here STREQUAL small_)
      set(optimise -Oz -fno-unroll-loops -DNORMA_SMALL)
      if(NOT name MATCHES "small_heap") # what the linker calls by itself
        list(APPEND optimise -flto)
      endif()
    elseif(name MATCHES "^src_core_(${web_seldom})")
      set(optimise -Os)
    elseif(name MATCHES "^(src_core|web_package_wasm_(keep|merge)_)")
      set(optimise -O2)
    else()
      set(optimise -Os)
    endif()
    add_custom_command(OUTPUT ${object}
      COMMAND ${NORMA_WASM_CC} ${web_flags} ${optimise} ${web_flags_here} -MD -MF ${object}.d -c ${source} -o ${object}
      DEPENDS ${source} DEPFILE ${object}.d COMMENT "WebAssembly ${name}" VERBATIM)
    list(APPEND objects ${object})
  endforeach()
  set(${list} ${objects} PARENT_SCOPE)
endfunction()

# No -O: with one, clang runs the wasm-opt that it finds on the path, which may know neither SIMD nor bulk memory.
function(web_module name)
  # Numbers take no more bytes than they need: a part in sixty of the small module. In modules with files of the C library wasm-ld 14 crashes by it.
  set(link_flags "")
  if(name STREQUAL normals.wasm)
    set(link_flags -Wl,--compress-relocations)
  endif()
  add_custom_command(OUTPUT ${web_dir}/${name}
    COMMAND ${NORMA_WASM_CC} --target=wasm32-wasi -nostartfiles -Wl,--no-entry -Wl,--strip-all -Wl,--gc-sections -Wl,--stack-first -Wl,-z,stack-size=1048576
            ${link_flags} ${ARGN} -o ${web_dir}/${name}
    DEPENDS ${ARGN} COMMENT "WebAssembly ${name}" VERBATIM)
endfunction()

set(web_core_sources ${core_sources})
list(TRANSFORM web_core_sources REPLACE "^src/" "${PROJECT_SOURCE_DIR}/src/")
file(GLOB web_call_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/web/package/wasm/*.c)
web_objects(web_core_objects ${web_core_sources})
web_objects(web_call_objects ${web_call_sources})
web_module(norma.wasm ${web_core_objects} ${web_call_objects})
web_objects(web_skin_objects ${PROJECT_SOURCE_DIR}/web/package/skin/skin_calls.c)
web_module(skin.wasm ${web_core_objects} ${web_skin_objects})
set(web_prefix_here small_)
web_objects(web_small_objects ${web_core_sources} ${PROJECT_SOURCE_DIR}/web/package/wasm/calls.c ${PROJECT_SOURCE_DIR}/web/package/normals/small_heap.c)
unset(web_prefix_here)
web_module(normals.wasm ${web_small_objects})

# The readers and the rules, without what a browser lacks.
set(web_file_sources ${io_sources})
list(FILTER web_file_sources EXCLUDE REGEX "/image/image(_left_out)?\\.c$") # in a browser no image is read
list(FILTER web_file_sources EXCLUDE REGEX "/(file/file_read|file/file_write|large/[a-z_]+|together/[a-z_]+|meshopt_[a-z_]+|draco_left_out)\\.c$")
list(FILTER web_file_sources EXCLUDE REGEX "/3mf/")
list(APPEND web_file_sources src/io/image/image_left_out.c)
if(web_has_3mf)
  list(APPEND web_file_sources src/io/3mf/3mf.c src/io/3mf/model.c src/io/3mf/package.c src/io/3mf/xml.c src/io/3mf/zip.c web/package/host/deflate_elsewhere.c)
else()
  list(APPEND web_file_sources src/io/3mf/3mf_left_out.c)
endif()
if(web_has_meshopt)
  list(APPEND web_file_sources src/io/gltf/meshopt_views.c)
else()
  list(APPEND web_file_sources src/io/gltf/meshopt_left_out.c)
endif()
if(web_has_draco)
  list(APPEND web_file_sources web/package/host/draco_elsewhere.c)
else()
  list(APPEND web_file_sources src/io/gltf/draco_left_out.c)
endif()
list(APPEND web_file_sources ${check_sources})
list(TRANSFORM web_file_sources REPLACE "^(src|web)/" "${PROJECT_SOURCE_DIR}/\\1/")
list(FILTER web_file_sources EXCLUDE REGEX "/check/run/check_large\\.c$")
set(web_fix_sources ${web_file_sources})
list(FILTER web_fix_sources INCLUDE REGEX "/check/fix/")
list(FILTER web_file_sources EXCLUDE REGEX "/check/fix/")
list(APPEND web_file_sources ${PROJECT_SOURCE_DIR}/web/page/model/no_system.c)
file(GLOB web_check_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/web/package/check/*.c)
file(GLOB web_model_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/web/page/model/*.c)
list(REMOVE_ITEM web_model_sources ${PROJECT_SOURCE_DIR}/web/page/model/no_system.c ${PROJECT_SOURCE_DIR}/web/page/model/no_files.c)
set(web_flags_here -I${PROJECT_SOURCE_DIR}/web/package/host -isystem ${PROJECT_SOURCE_DIR}/web/page/model/posix -include ${PROJECT_SOURCE_DIR}/web/page/model/missing.h)
web_objects(web_file_objects ${web_file_sources})
web_objects(web_fix_objects ${web_fix_sources})
web_objects(web_check_objects ${web_check_sources} ${PROJECT_SOURCE_DIR}/web/page/model/no_files.c)
web_objects(web_compare_objects ${PROJECT_SOURCE_DIR}/src/compare/compare_scene.c)
set(web_acid_sources cells mesh)
list(TRANSFORM web_acid_sources REPLACE "(.+)" "${PROJECT_SOURCE_DIR}/src/acid/\\1.c")
set(web_flags_here ${web_flags_here} -I${PROJECT_BINARY_DIR}/generated)
web_objects(web_acid_objects ${web_acid_sources})
web_objects(web_model_objects ${web_model_sources} ${PROJECT_SOURCE_DIR}/src/render/camera.c)
web_module(check.wasm ${web_core_objects} ${web_file_objects} ${web_fix_objects} ${web_check_objects})
web_module(page.wasm ${web_core_objects} ${web_call_objects} ${web_file_objects} ${web_fix_objects} ${web_compare_objects} ${web_acid_objects} ${web_model_objects})

# The tool under node's WASI (npx norma-mesh): the objects of the modules above, and with files what they do without.
set(web_tool_dir ${PROJECT_SOURCE_DIR}/web/package/tool)
file(GLOB web_tool_sources CONFIGURE_DEPENDS ${web_tool_dir}/*.c ${PROJECT_SOURCE_DIR}/src/cli/*.c ${PROJECT_SOURCE_DIR}/src/cli/*/*.c ${PROJECT_SOURCE_DIR}/src/io/large/*.c ${PROJECT_SOURCE_DIR}/src/io/together/*.c)
list(FILTER web_tool_sources EXCLUDE REGEX "/cli/(render|view|acid|mcp)/")
list(APPEND web_tool_sources ${PROJECT_SOURCE_DIR}/src/io/file/file_read.c ${PROJECT_SOURCE_DIR}/src/io/file/file_write.c ${PROJECT_SOURCE_DIR}/src/check/run/check_large.c)
set(web_flags_here -D_WASI_EMULATED_MMAN -D_WASI_EMULATED_GETPID -I${PROJECT_SOURCE_DIR} -I${PROJECT_SOURCE_DIR}/web/package/host
                   -isystem ${web_tool_dir}/posix -isystem ${PROJECT_SOURCE_DIR}/web/page/model/posix -include ${web_tool_dir}/missing.h)
web_objects(web_tool_objects ${web_tool_sources})
set(web_tool_shared ${web_core_objects} ${web_file_objects} ${web_fix_objects} ${web_compare_objects})
list(FILTER web_tool_shared EXCLUDE REGEX "_no_system\\.c\\.o$")
add_custom_command(OUTPUT ${web_dir}/tool.wasm
  COMMAND ${NORMA_WASM_CC} --target=wasm32-wasi -Wl,--strip-all -Wl,--gc-sections -Wl,--stack-first -Wl,-z,stack-size=8388608 ${web_tool_shared} ${web_tool_objects} -lm -lwasi-emulated-mman -o ${web_dir}/tool.wasm
  DEPENDS ${web_tool_shared} ${web_tool_objects} COMMENT "WebAssembly tool.wasm" VERBATIM)

file(GLOB web_inputs CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/web/package/* ${PROJECT_SOURCE_DIR}/web/*.mjs ${PROJECT_SOURCE_DIR}/web/package-lock.json ${PROJECT_SOURCE_DIR}/web/licences/* ${PROJECT_SOURCE_DIR}/include/norma/shaders/*)
list(FILTER web_inputs EXCLUDE REGEX "/(check|host|normals|skin|tool|wasm)$")
add_custom_command(OUTPUT ${web_dir}/npm/norma.wasm
  COMMAND ${CMAKE_COMMAND} -E env ESBUILD=${NORMA_ESBUILD} ${NORMA_NODE} ${PROJECT_SOURCE_DIR}/web/build.mjs package ${web_dir} ${NORMA_WEB_MODULES}
  DEPENDS ${web_inputs} ${web_dir}/norma.wasm ${web_dir}/check.wasm ${web_dir}/skin.wasm ${web_dir}/normals.wasm ${web_dir}/tool.wasm COMMENT "npm package" VERBATIM)
file(GLOB web_page_inputs CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/web/page/* ${PROJECT_SOURCE_DIR}/web/page/shaders/* ${PROJECT_SOURCE_DIR}/src/render/shaders/* ${PROJECT_SOURCE_DIR}/assets/goathead.obj)
add_custom_command(OUTPUT ${web_dir}/norma.html ${web_dir}/page.html
  COMMAND ${CMAKE_COMMAND} -E env ESBUILD=${NORMA_ESBUILD} ${NORMA_NODE} ${PROJECT_SOURCE_DIR}/web/build.mjs page ${web_dir} ${NORMA_WEB_MODULES}
  DEPENDS ${web_page_inputs} ${web_inputs} ${web_dir}/page.wasm COMMENT "The page" VERBATIM)
add_custom_target(web ALL DEPENDS ${web_dir}/npm/norma.wasm ${web_dir}/norma.html)

# norma view: the page lies in the tool.
set_source_files_properties(src/cli/view/view.c PROPERTIES COMPILE_DEFINITIONS "NORMA_PAGE_FILE=\"${web_dir}/page.html\"" OBJECT_DEPENDS ${web_dir}/page.html)
add_dependencies(norma-cli-objects web)
