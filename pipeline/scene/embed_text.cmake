# SPDX-License-Identifier: MIT
# cmake -DIN=patches.txt -DNAME=kTeapotPatches -DOUT=patches.cpp -P embed_text.cmake: the text as bytes, since a string literal has a greatest length.
file(READ ${IN} bytes HEX)
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
