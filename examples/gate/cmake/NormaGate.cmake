# norma_gate(TARGET MESH...): a target that checks meshes, each again only if it, or a file that it names, changed. include() this file; CMake 3.20 or newer.
# NORMA_GATE_PROFILE: generated, unless set before.
find_program(NORMA norma REQUIRED)
set(NORMA_GATE_DEPS "${CMAKE_CURRENT_LIST_DIR}/../deps.sh")
function(norma_gate target)
  if(NOT NORMA_GATE_PROFILE)
    set(NORMA_GATE_PROFILE generated)
  endif()
  set(stamps)
  foreach(mesh IN LISTS ARGN)
    get_filename_component(path "${mesh}" ABSOLUTE)
    file(RELATIVE_PATH name "${CMAKE_CURRENT_SOURCE_DIR}" "${path}")
    set(stamp "${CMAKE_CURRENT_BINARY_DIR}/${name}.checked")
    get_filename_component(folder "${stamp}" DIRECTORY)
    file(MAKE_DIRECTORY "${folder}")
    add_custom_command(OUTPUT "${stamp}"
      COMMAND "${NORMA}" check --profile ${NORMA_GATE_PROFILE} -- "${path}"
      COMMAND "${NORMA_GATE_DEPS}" "${stamp}" "${path}" > "${stamp}.d"
      COMMAND "${CMAKE_COMMAND}" -E touch "${stamp}"
      DEPENDS "${path}" DEPFILE "${stamp}.d" COMMENT "Checking ${name}" VERBATIM)
    list(APPEND stamps "${stamp}")
  endforeach()
  add_custom_target(${target} ALL DEPENDS ${stamps})
endfunction()
