# SPDX-License-Identifier: MIT
# cmake -DIN=page.html -DNAME=kReportPage -DOUT=page.cpp [-DCOMMON=common.css] -P embed_text.cmake: the text as bytes, since a string literal has a
# greatest length. With COMMON the line {{common}} of the text is what is in that file.
file(READ ${IN} bytes HEX)
if(COMMON)
  file(READ ${COMMON} common HEX)
  string(HEX "{{common}}\n" mark)
  string(FIND "${bytes}" "${mark}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "${IN} has no line {{common}}")
  endif()
  string(REPLACE "${mark}" "${common}" bytes "${bytes}")
endif()
string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
string(REPLACE "0x0a," "0x0a,\n" bytes "${bytes}")
file(WRITE ${OUT} "namespace plumb {
namespace {
const unsigned char text[] = {${bytes}0};
}
extern const char* const ${NAME};
const char* const ${NAME} = reinterpret_cast<const char*>(text);
}
")
