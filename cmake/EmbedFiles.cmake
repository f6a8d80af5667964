# cmake -DOUTPUT=… -DHEADER=… -DFILES=name=path|name=path -P EmbedFiles.cmake
#
# Writes a .cpp with one function a file that returns its content, rivid::detail::<name>(), declared in
# HEADER.

cmake_minimum_required(VERSION 3.25)

set(functions "")
string(REPLACE "|" ";" FILES "${FILES}")
foreach(entry IN LISTS FILES)
  string(REGEX MATCH "^([^=]+)=(.+)$" found "${entry}")
  set(name ${CMAKE_MATCH_1})
  file(READ "${CMAKE_MATCH_2}" bytes HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${bytes}")
  string(APPEND functions "\nstd::string_view ${name}() {\n  static constexpr char bytes[] = {${bytes}};\n"
                          "  return {bytes, sizeof bytes};\n}\n")
endforeach()
file(WRITE ${OUTPUT} "// Made by cmake/EmbedFiles.cmake.\n#include \"${HEADER}\"\n\nnamespace rivid::detail {\n"
                     "${functions}\n}  // namespace rivid::detail\n")
