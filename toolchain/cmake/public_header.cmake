# SPDX-License-Identifier: MIT
# cmake -DIN=header -DOUT=header -P public_header.cmake: includes of the project's own headers get the prefix plumbline/.
file(READ ${IN} text)
string(REGEX REPLACE "#include \"(host|pipeline)/" "#include \"plumbline/\\1/" text "${text}")
file(WRITE ${OUT} "${text}")
