# cmake -DSOURCE_DIR=… -P check_format.cmake
#
# Every tracked .hpp and .cpp is as clang-format-19 would write it. Other versions format differently, so
# without that one nothing is checked, and the last line says so.

cmake_minimum_required(VERSION 3.25)

find_program(CLANG_FORMAT NAMES clang-format-19)
if(NOT CLANG_FORMAT)
  message(STATUS "skipped: clang-format-19 is not installed")
  return()
endif()

find_program(GIT NAMES git)
set(tracked 1)
if(GIT)
  execute_process(
    COMMAND ${GIT} ls-files -- *.hpp *.cpp
    WORKING_DIRECTORY ${SOURCE_DIR}
    OUTPUT_VARIABLE names
    ERROR_QUIET
    RESULT_VARIABLE tracked)
endif()
if(tracked EQUAL 0 AND names)
  string(REGEX REPLACE "\n$" "" names "${names}")
  string(REPLACE "\n" ";" names "${names}")
else()
  # An unpacked archive of the sources: all of it counts.
  file(GLOB_RECURSE names RELATIVE ${SOURCE_DIR} ${SOURCE_DIR}/*.hpp ${SOURCE_DIR}/*.cpp)
  list(FILTER names EXCLUDE REGEX "^build/")
endif()
set(files "")
foreach(name IN LISTS names)
  if(EXISTS ${SOURCE_DIR}/${name})
    list(APPEND files ${name})
  endif()
endforeach()
if(NOT files)
  message(FATAL_ERROR "check_format: no .hpp or .cpp found in ${SOURCE_DIR}")
endif()

execute_process(
  COMMAND ${CLANG_FORMAT} --dry-run -Werror ${files}
  WORKING_DIRECTORY ${SOURCE_DIR}
  RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "check_format: run  git ls-files '*.hpp' '*.cpp' | xargs clang-format-19 -i")
endif()
list(LENGTH files count)
message(STATUS "check_format: ${count} files are formatted")
