# SPDX-License-Identifier: MIT
# plumb_shader(TARGET stem [VARIANT suffix] [DEFINES -DX ...] [FOLDER shaders] [LOOSE]): FOLDER/<stem>.comp -> SPIR-V (glslang,
# dependency file) -> functions inlined and variables made values (spirv-opt) -> every float operation decorated NoContraction and embedded by plumb_spirv_embed: declared in
# <spirv/<stem><suffix>.h>, defined in a source of TARGET. Who links TARGET finds both; TARGET may be an INTERFACE library.
# Drivers do the same at every start, on the sides of branches too that constants rule out later (decisions 72 and 69). None of these passes evaluates, moves
# or joins an operation on floats, and NoContraction is set after them. LOOSE leaves it out: a module that asks what the device does then.
set(PLUMB_SPIRV_PASSES --inline-entry-points-exhaustive --eliminate-dead-functions --private-to-local --scalar-replacement=0
    --eliminate-local-single-block --eliminate-local-single-store --eliminate-dead-code-aggressive --preserve-bindings --preserve-spec-constants)
function(plumb_shader target stem)
  cmake_parse_arguments(S "LOOSE" "VARIANT;FOLDER" "DEFINES" ${ARGN})
  set(name ${stem}${S_VARIANT})
  if(NOT S_FOLDER)
    set(S_FOLDER shaders)
  endif()
  set(source ${CMAKE_SOURCE_DIR}/${S_FOLDER}/${stem}.comp)
  if(NOT EXISTS ${source})
    message(FATAL_ERROR "shader '${stem}' lacks ${source}")
  endif()
  set(dir ${CMAKE_BINARY_DIR}/generated/spirv)
  file(MAKE_DIRECTORY ${dir})
  add_custom_command(
    OUTPUT ${dir}/${name}.glslang.spv
    COMMAND ${GLSLANG} -V --quiet --target-env vulkan1.2 -I${CMAKE_SOURCE_DIR}/shaders ${S_DEFINES}
            --depfile ${dir}/${name}.d -o ${dir}/${name}.glslang.spv ${source}
    DEPENDS ${source} DEPFILE ${dir}/${name}.d VERBATIM COMMENT "glslang ${name}")
  add_custom_command(
    OUTPUT ${dir}/${name}.raw.spv
    COMMAND ${SPIRV_OPT} --target-env=vulkan1.2 --scalar-block-layout ${PLUMB_SPIRV_PASSES} -o ${dir}/${name}.raw.spv ${dir}/${name}.glslang.spv
    DEPENDS ${dir}/${name}.glslang.spv VERBATIM COMMENT "spirv-opt ${name}")
  add_custom_command(
    OUTPUT ${dir}/${name}.h ${dir}/${name}.cpp ${dir}/${name}.spv ${dir}/${name}.judged.spv
    COMMAND plumb_spirv_embed ${name} ${dir}/${name}.raw.spv ${dir}/${name}.spv ${dir}/${name}.h ${dir}/${name}.cpp
            ${dir}/${name}.glslang.spv ${dir}/${name}.judged.spv $<$<BOOL:${S_LOOSE}>:--loose>
    DEPENDS plumb_spirv_embed ${dir}/${name}.raw.spv COMMAND_EXPAND_LISTS VERBATIM COMMENT "embed ${name}")
  set_source_files_properties(${dir}/${name}.cpp PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
  target_sources(${target} PRIVATE ${dir}/${name}.h)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "INTERFACE_LIBRARY")
    target_sources(${target} INTERFACE ${dir}/${name}.cpp)
    target_include_directories(${target} INTERFACE ${CMAKE_BINARY_DIR}/generated)
  else()
    target_sources(${target} PRIVATE ${dir}/${name}.cpp)
    target_include_directories(${target} PUBLIC ${CMAKE_BINARY_DIR}/generated)
  endif()
  set_property(GLOBAL APPEND PROPERTY PLUMB_SPIRV_FILES ${dir}/${name}.spv)
  set_property(GLOBAL APPEND PROPERTY PLUMB_SPIRV_JUDGED ${dir}/${name}.judged.spv)  # the same with its functions, for the lint
endfunction()
