# SPDX-License-Identifier: MIT
# cmake -DPAGE=page.html -DCOMMON=common.css -DNAME=kReportPage -DOUT=page.cpp -P embed.cmake: the text as bytes, since a string literal has a greatest
# length. The line {{common}} of the page is what is in COMMON.
file(READ ${PAGE} bytes HEX)
file(READ ${COMMON} common HEX)
string(HEX "{{common}}\n" mark)
string(FIND "${bytes}" "${mark}" at)
if(at EQUAL -1)
  message(FATAL_ERROR "${PAGE} has no line {{common}}")
endif()
string(REPLACE "${mark}" "${common}" bytes "${bytes}")
string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
string(REPLACE "0x0a," "0x0a,\n" bytes "${bytes}")
file(WRITE ${OUT} "namespace plumb {
namespace {
const unsigned char page[] = {${bytes}0};
}
extern const char* const ${NAME};
const char* const ${NAME} = reinterpret_cast<const char*>(page);
}
")
