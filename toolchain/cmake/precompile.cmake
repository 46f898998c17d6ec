# SPDX-License-Identifier: MIT
# The standard library, fmt, GLM and GoogleTest, parsed once a tree instead of once a unit, for trees that build the tests: most units are parsed longer
# than they are compiled (docs/tests.md). The preset `release` goes without, so that a unit that forgets an include of its own is found there.
option(PLUMB_PRECOMPILE "Precompile the headers of libraries" OFF)

# Little but what nearly every unit needs: a unit pays for loading all of it.
set(plumb_common <algorithm> <array> <cmath> <cstdint> <cstring> <functional> <optional> <span> <string> <string_view> <utility> <vector> <fmt/core.h> <glm/glm.hpp>)

# plumb_parsed(NAME LIBRARIES ... HEADERS ... OPTIONS ...): what targets compiled with the same options may share.
function(plumb_parsed name)
  cmake_parse_arguments(P "" "" "LIBRARIES;HEADERS;OPTIONS" ${ARGN})
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/generated/${name}.cpp CONTENT "")
  add_library(${name} OBJECT ${CMAKE_BINARY_DIR}/generated/${name}.cpp)
  target_link_libraries(${name} PRIVATE ${P_LIBRARIES})
  target_compile_options(${name} PRIVATE ${P_OPTIONS})
  list(TRANSFORM P_HEADERS REPLACE "(.+)" "$<$<COMPILE_LANGUAGE:CXX>:\\1>")
  target_precompile_headers(${name} PRIVATE ${P_HEADERS})
endfunction()

# plumb_precompile(FOLDER): for every target in it and below, after all of them were made.
function(plumb_precompile folder)
  get_property(folders DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(below ${folders})
    plumb_precompile(${below})
  endforeach()
  get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target ${targets})
    get_target_property(type ${target} TYPE)
    get_target_property(libraries ${target} LINK_LIBRARIES)
    if(target STREQUAL plumb)
      target_precompile_headers(plumb PRIVATE ${plumb_common} <nlohmann/json.hpp>)
    elseif(type STREQUAL EXECUTABLE AND libraries MATCHES "GTest::")
      target_precompile_headers(${target} REUSE_FROM plumb_parsed_tests)
    elseif(type STREQUAL STATIC_LIBRARY AND libraries MATCHES "fmt::")
      target_precompile_headers(${target} REUSE_FROM plumb_parsed_rooms)
    endif()
  endforeach()
endfunction()

if(PLUMB_PRECOMPILE)
  add_compile_options(-fpch-preprocess)  # for ccache
  plumb_parsed(plumb_parsed_rooms LIBRARIES fmt::fmt glm::glm HEADERS ${plumb_common})
  if(PLUMB_TESTS)
    find_package(GTest REQUIRED)
    plumb_parsed(plumb_parsed_tests LIBRARIES fmt::fmt glm::glm GTest::gtest HEADERS ${plumb_common} <gtest/gtest.h> OPTIONS ${PLUMB_TEST_OPTIONS})
    set_target_properties(plumb_parsed_tests PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(plumb_parsed_tests PRIVATE -fPIE)  # as programs are
  endif()
endif()
