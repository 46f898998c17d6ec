# SPDX-License-Identifier: MIT
# The library `plumbline` and what `cmake --install` puts under a prefix: bin/plumb, the library with its headers and CMake package,
# man page, completions, licences. Nothing installed refers to the source or build tree.
include(CMakePackageConfigHelpers)

set(rooms plumb_host plumb_transform plumb_choices plumb_scene plumb_passes plumb_recorders plumb_render plumb_image)
add_library(plumbline STATIC)
set_target_properties(plumbline PROPERTIES LINKER_LANGUAGE CXX)
foreach(room ${rooms})
  target_sources(plumbline PRIVATE $<TARGET_OBJECTS:${room}>)
endforeach()
target_compile_features(plumbline PUBLIC cxx_std_20)
target_link_libraries(plumbline PUBLIC glm::glm Threads::Threads PRIVATE fmt::fmt tomlplusplus::tomlplusplus PNG::PNG ZLIB::ZLIB OpenEXR::OpenEXR
                      ${CMAKE_DL_LIBS})
target_include_directories(plumbline INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)

# Public headers keep their rooms below include/plumbline/, and name each other from there.
set(headers host/device.h host/error.h host/buffer.h host/module.h host/program.h host/recorder.h pipeline/transform/step.h pipeline/scene/scene.h pipeline/scene/mesh.h pipeline/scene/positions.h
    pipeline/scene/load.h pipeline/scene/sha256.h pipeline/choices/choice.h pipeline/choices/choices.h pipeline/choices/planes.h pipeline/choices/trade.h pipeline/render/frame.h pipeline/render/plan.h pipeline/render/render.h pipeline/image/image.h)
set(staged ${CMAKE_BINARY_DIR}/generated/include/plumbline)
set(outputs "")
foreach(header ${headers} pipeline/plumbline.hpp)
  if(header STREQUAL pipeline/plumbline.hpp)
    set(out ${staged}/plumbline.hpp)
  else()
    set(out ${staged}/${header})
  endif()
  add_custom_command(OUTPUT ${out} DEPENDS ${CMAKE_SOURCE_DIR}/${header} VERBATIM
    COMMAND ${CMAKE_COMMAND} -DIN=${CMAKE_SOURCE_DIR}/${header} -DOUT=${out} -P ${CMAKE_CURRENT_LIST_DIR}/public_header.cmake)
  list(APPEND outputs ${out})
endforeach()
add_custom_target(plumb_headers ALL DEPENDS ${outputs})

# Man page and completions are printed by the command itself, from its table of flags.
set(manual ${CMAKE_BINARY_DIR}/generated/manual)
file(MAKE_DIRECTORY ${manual})
add_custom_command(OUTPUT ${manual}/plumb.1 ${manual}/plumb.bash ${manual}/_plumb ${manual}/plumb.fish DEPENDS plumb VERBATIM
  COMMAND plumb help --man > ${manual}/plumb.1
  COMMAND plumb help --completion bash > ${manual}/plumb.bash
  COMMAND plumb help --completion zsh > ${manual}/_plumb
  COMMAND plumb help --completion fish > ${manual}/plumb.fish)
add_custom_target(plumb_manual ALL DEPENDS ${manual}/plumb.1)

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/plumbline-config.cmake.in ${CMAKE_BINARY_DIR}/generated/plumbline-config.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/plumbline)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/generated/plumbline-config-version.cmake COMPATIBILITY SameMinorVersion)

install(TARGETS plumb RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS plumbline EXPORT plumbline ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT plumbline FILE plumbline-targets.cmake NAMESPACE plumbline:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/plumbline)
install(FILES ${CMAKE_BINARY_DIR}/generated/plumbline-config.cmake ${CMAKE_BINARY_DIR}/generated/plumbline-config-version.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/plumbline)
install(DIRECTORY ${staged} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES ${manual}/plumb.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${manual}/plumb.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME plumb)
install(FILES ${manual}/_plumb DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)
install(FILES ${manual}/plumb.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE ${CMAKE_SOURCE_DIR}/THIRD-PARTY.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
