# SPDX-License-Identifier: MIT
# plumb_shader(TARGET stem [VARIANT suffix -DX ...]): shaders/<stem>.comp -> SPIR-V (glslang, dependency file) -> every float operation decorated
# NoContraction and embedded as <spirv/<stem><suffix>.h> by plumb_spirv_embed.
function(plumb_shader target stem)
  cmake_parse_arguments(S "" "VARIANT" "DEFINES" ${ARGN})
  set(name ${stem}${S_VARIANT})
  set(source ${CMAKE_SOURCE_DIR}/shaders/${stem}.comp)
  if(NOT EXISTS ${source})
    message(FATAL_ERROR "shader '${stem}' lacks ${source}")
  endif()
  set(dir ${CMAKE_BINARY_DIR}/generated/spirv)
  file(MAKE_DIRECTORY ${dir})
  add_custom_command(
    OUTPUT ${dir}/${name}.raw.spv
    COMMAND ${GLSLANG} -V --quiet --target-env vulkan1.2 -I${CMAKE_SOURCE_DIR}/shaders ${S_DEFINES}
            --depfile ${dir}/${name}.d -o ${dir}/${name}.raw.spv ${source}
    DEPENDS ${source} DEPFILE ${dir}/${name}.d VERBATIM COMMENT "glslang ${name}")
  add_custom_command(
    OUTPUT ${dir}/${name}.h ${dir}/${name}.spv
    COMMAND plumb_spirv_embed ${name} ${dir}/${name}.raw.spv ${dir}/${name}.spv ${dir}/${name}.h
    DEPENDS plumb_spirv_embed ${dir}/${name}.raw.spv VERBATIM COMMENT "embed ${name}")
  target_sources(${target} PRIVATE ${dir}/${name}.h)
  set_property(GLOBAL APPEND PROPERTY PLUMB_SPIRV_FILES ${dir}/${name}.spv)
endfunction()
