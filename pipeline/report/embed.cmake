# SPDX-License-Identifier: MIT
# cmake -DPAGE=page.html -DNAME=kReportPage -DOUT=page.cpp -P embed.cmake: the text as bytes, since a string literal has a greatest length.
file(READ ${PAGE} bytes HEX)
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
