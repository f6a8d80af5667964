# cmake -DSOURCE_DIR=… -P check_named_tests.cmake
#
# Tests and examples that a page or the list of slow tests names exist: `Suite.Name`, `Suite.*` and
# `example_name`.

cmake_minimum_required(VERSION 3.25)

set(code "")
file(GLOB_RECURSE tests ${SOURCE_DIR}/tests/*_test.cpp)
foreach(file IN LISTS tests)
  file(READ ${file} text)
  string(APPEND code "${text}")
endforeach()

set(faults 0)
set(found 0)
file(GLOB pages RELATIVE ${SOURCE_DIR} ${SOURCE_DIR}/docs/*.md ${SOURCE_DIR}/*.md ${SOURCE_DIR}/tests/paper/*.md
     ${SOURCE_DIR}/tests/slow_tests.cmake)
foreach(page IN LISTS pages)
  file(READ ${SOURCE_DIR}/${page} text)
  if(page MATCHES "[.]cmake$")
    string(REGEX REPLACE "\n +([A-Za-z.]+)" " `\\1`" text "${text}")
  endif()
  # These mean something in a CMake list.
  string(REGEX REPLACE "[][;]" " " text "${text}")
  string(REGEX MATCHALL "`([A-Z][A-Za-z0-9]+\\.([A-Z][A-Za-z0-9]+|\\*)|example_[0-9a-z_]+)`" names "${text}")
  list(REMOVE_DUPLICATES names)
  foreach(name IN LISTS names)
    string(REPLACE "`" "" name "${name}")
    math(EXPR found "${found} + 1")
    if(name MATCHES "^example_(.+)")
      set(there FALSE)
      if(EXISTS ${SOURCE_DIR}/examples/${CMAKE_MATCH_1}.cpp)
        set(there TRUE)
      endif()
    else()
      string(REPLACE "." ", " pattern "${name}\\)")
      string(REPLACE "*\\)" "[A-Z]" pattern "${pattern}")
      string(REGEX MATCH "TEST(_P|_F)?\\(${pattern}" there "${code}")
    endif()
    if(NOT there)
      math(EXPR faults "${faults} + 1")
      message(NOTICE "${page}: there is no ${name}")
    endif()
  endforeach()
endforeach()

if(faults OR found EQUAL 0)
  message(FATAL_ERROR "check_named_tests: ${faults} faults in ${found} names")
endif()
message(STATUS "check_named_tests: all ${found} names are there")
