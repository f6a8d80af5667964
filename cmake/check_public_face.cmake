# cmake -DINCLUDE_DIR=… -P check_public_face.cmake
#
# Who includes rivid/rivid.hpp has all of the library: every public header is reached from there, or stands
# here with its reason.

cmake_minimum_required(VERSION 3.25)

set(left_out
    rivid/model/kdl.hpp # asks its users to link KDL
    rivid/simulate/kdl_solver.hpp # the same
)

file(GLOB_RECURSE present RELATIVE ${INCLUDE_DIR} ${INCLUDE_DIR}/rivid/*.hpp)
if(NOT present)
  message(FATAL_ERROR "check_public_face: no header in \"${INCLUDE_DIR}\"")
endif()

set(reached "")
set(to_follow rivid/rivid.hpp)
while(to_follow)
  list(POP_FRONT to_follow header)
  # Headers that the build makes are not in the source tree.
  if(header IN_LIST reached OR NOT EXISTS ${INCLUDE_DIR}/${header})
    continue()
  endif()
  list(APPEND reached ${header})
  file(STRINGS ${INCLUDE_DIR}/${header} lines REGEX "^#include \"rivid/")
  foreach(line IN LISTS lines)
    string(REGEX REPLACE "^#include \"(.*)\".*" "\\1" included "${line}")
    list(APPEND to_follow ${included})
  endforeach()
endwhile()

foreach(header IN LISTS left_out)
  if(header IN_LIST reached OR NOT header IN_LIST present)
    message(FATAL_ERROR "check_public_face: ${header} is listed as left out of rivid/rivid.hpp, which it is not")
  endif()
endforeach()
set(forgotten ${present})
list(REMOVE_ITEM forgotten ${reached} ${left_out})
foreach(header IN LISTS forgotten)
  message(NOTICE "${header}: is not reached from rivid/rivid.hpp")
endforeach()
if(forgotten)
  message(FATAL_ERROR "check_public_face: who includes rivid/rivid.hpp does not have all of the library")
endif()
list(LENGTH reached count)
message(STATUS "check_public_face: ${count} headers are reached from rivid/rivid.hpp")
