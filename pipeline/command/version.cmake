# SPDX-License-Identifier: MIT
# cmake -DSOURCE=dir -DOUT=file.cpp -P version.cmake: writes gitRevision(), touching the file only when it changed.
set(revision unknown)
find_program(GIT git)
if(GIT AND EXISTS ${SOURCE}/.git)
  # Only the product counts as changed: a note or an output in the tree does not make another program.
  execute_process(COMMAND ${GIT} --no-optional-locks -C ${SOURCE} rev-parse --short=12 HEAD OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE
                  ERROR_QUIET RESULT_VARIABLE rc)
  if(rc EQUAL 0)
    set(revision ${commit})
    execute_process(COMMAND ${GIT} --no-optional-locks -C ${SOURCE} status --porcelain -- host pipeline shaders CMakeLists.txt OUTPUT_VARIABLE changes ERROR_QUIET)
    if(changes)
      string(APPEND revision "-modified")
    endif()
  endif()
endif()
set(text "#include \"pipeline/command/version.h\"\nconst char* plumb::gitRevision() { return \"${revision}\"; }\n")
if(EXISTS ${OUT})
  file(READ ${OUT} before)
endif()
if(NOT "${before}" STREQUAL "${text}")
  file(WRITE ${OUT} "${text}")
endif()
