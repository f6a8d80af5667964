# cmake -DINCLUDE_DIR=… -DHEADER_SET=<file, one header a line> -P check_header_set.cmake
#
# A header that src/CMakeLists.txt does not list is neither installed nor compiled alone: name it.

cmake_minimum_required(VERSION 3.25)

file(STRINGS ${HEADER_SET} listed)
file(GLOB_RECURSE present ${INCLUDE_DIR}/*.hpp)
if(NOT present)
  message(FATAL_ERROR "check_header_set: no header in \"${INCLUDE_DIR}\"")
endif()
set(forgotten ${present})
list(REMOVE_ITEM forgotten ${listed})
foreach(header IN LISTS forgotten)
  message(NOTICE "${header}: is not in the FILE_SET of src/CMakeLists.txt")
endforeach()
if(forgotten)
  message(FATAL_ERROR "check_header_set: headers that are never installed nor compiled alone")
endif()
list(LENGTH present count)
message(STATUS "check_header_set: all ${count} headers are in the FILE_SET")
