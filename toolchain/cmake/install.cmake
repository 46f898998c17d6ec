# SPDX-License-Identifier: MIT
# The library, shared and static, and what `cmake --install` puts under a prefix: bin/plumb, the libraries with their headers, CMake package and pkg-config
# file, man page, completions, licences. Nothing installed refers to the source or build tree. The command itself is linked of the rooms, without the shared
# library, which would have to be found and relocated at every start.
include(CMakePackageConfigHelpers)

set(rooms plumb_host plumb_transform plumb_choices plumb_scene plumb_passes plumb_recorders plumb_render plumb_image plumb_library)
set(libraries fmt::fmt tomlplusplus::tomlplusplus PNG::PNG ZLIB::ZLIB OpenEXR::OpenEXR Threads::Threads ${CMAKE_DL_LIBS})
add_library(plumbline SHARED)
add_library(plumbline_static STATIC)
foreach(library plumbline plumbline_static)
  foreach(room ${rooms})
    target_sources(${library} PRIVATE $<TARGET_OBJECTS:${room}>)
  endforeach()
  set_target_properties(${library} PROPERTIES LINKER_LANGUAGE CXX OUTPUT_NAME plumbline)
  target_compile_features(${library} PUBLIC cxx_std_20)
  target_link_libraries(${library} PUBLIC glm::glm PRIVATE ${libraries})
  target_include_directories(${library} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
endforeach()
set_target_properties(plumbline_static PROPERTIES EXPORT_NAME static)
# Before 1.0 a minor version may change the interface, so it is part of the name that a program asks for.
set(map ${CMAKE_CURRENT_LIST_DIR}/plumbline.map)
set_target_properties(plumbline PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} LINK_DEPENDS ${map})
target_link_options(plumbline PRIVATE LINKER:--version-script=${map})
if(NOT PLUMB_SANITIZE)
  target_link_options(plumbline PRIVATE LINKER:--no-undefined)
endif()

# Public headers: plumbline.hpp and all that it includes. They keep their rooms below include/plumbline/, and name each other from there.
function(plumb_public_headers found header)
  if(header IN_LIST ${found})
    return()
  endif()
  list(APPEND ${found} ${header})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${header})
  file(STRINGS ${CMAKE_SOURCE_DIR}/${header} lines REGEX "^#include \"(host|pipeline)/")
  foreach(line ${lines})
    string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included "${line}")
    plumb_public_headers(${found} ${included})
  endforeach()
  set(${found} ${${found}} PARENT_SCOPE)
endfunction()
plumb_public_headers(headers pipeline/plumbline.hpp)
set(staged ${CMAKE_BINARY_DIR}/generated/include/plumbline)
set(outputs "")
foreach(header ${headers})
  string(REPLACE pipeline/plumbline.hpp plumbline.hpp inside ${header})
  add_custom_command(OUTPUT ${staged}/${inside} DEPENDS ${CMAKE_SOURCE_DIR}/${header} VERBATIM
    COMMAND ${CMAKE_COMMAND} -DIN=${CMAKE_SOURCE_DIR}/${header} -DOUT=${staged}/${inside} -P ${CMAKE_CURRENT_LIST_DIR}/public_header.cmake)
  list(APPEND outputs ${staged}/${inside})
  get_filename_component(folder ${inside} DIRECTORY)
  install(FILES ${staged}/${inside} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/plumbline/${folder})
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

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/plumbline)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/plumbline-config.cmake.in ${CMAKE_BINARY_DIR}/generated/plumbline-config.cmake INSTALL_DESTINATION ${package})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/generated/plumbline-config-version.cmake COMPATIBILITY SameMinorVersion)
file(RELATIVE_PATH prefix_from_pc /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(${CMAKE_CURRENT_LIST_DIR}/plumbline.pc.in ${CMAKE_BINARY_DIR}/generated/plumbline.pc @ONLY)

install(TARGETS plumb RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS plumbline plumbline_static EXPORT plumbline LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT plumbline FILE plumbline-targets.cmake NAMESPACE plumbline:: DESTINATION ${package})
install(FILES ${CMAKE_BINARY_DIR}/generated/plumbline-config.cmake ${CMAKE_BINARY_DIR}/generated/plumbline-config-version.cmake DESTINATION ${package})
install(FILES ${CMAKE_BINARY_DIR}/generated/plumbline.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
install(FILES ${manual}/plumb.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${manual}/plumb.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME plumb)
install(FILES ${manual}/_plumb DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)
install(FILES ${manual}/plumb.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE ${CMAKE_SOURCE_DIR}/THIRD-PARTY.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
