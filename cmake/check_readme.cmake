# cmake -DSOURCE_DIR=… -DPROGRAM=<rivid_identify> -DOUTPUT=<folder> -P check_readme.cmake
#
# docs/api.md shows examples/01_identify.cpp as it is, docs/first_steps.md its parameters as they are printed,
# and README.md lines of its first screen. The README has 120 lines at most.

cmake_minimum_required(VERSION 3.25)

file(READ ${SOURCE_DIR}/docs/api.md api)
file(READ ${SOURCE_DIR}/examples/01_identify.cpp example)
string(FIND "${api}" "```cpp\n${example}```" at)
if(at EQUAL -1)
  message(FATAL_ERROR "check_readme: docs/api.md has no ```cpp block that is examples/01_identify.cpp to the letter")
endif()

file(READ ${SOURCE_DIR}/docs/first_steps.md page)
foreach(how IN ITEMS --verbose --threads=1)
  execute_process(
    COMMAND ${PROGRAM} data/scara/scara.toml ${how} --output ${OUTPUT}
    WORKING_DIRECTORY ${SOURCE_DIR}
    OUTPUT_VARIABLE table
    ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
  string(FIND "${page}" "${table}" at)
  if(how STREQUAL --verbose AND at EQUAL -1)
    message(NOTICE "${table}")
    message(FATAL_ERROR "check_readme: docs/first_steps.md does not show the table above, which the demo prints")
  endif()
endforeach()

# Brackets and semicolons mean something in a CMake list.
file(READ ${SOURCE_DIR}/README.md readme)
foreach(text IN ITEMS readme table)
  string(REGEX REPLACE "[][;]" "_" ${text} "${${text}}")
endforeach()
string(REGEX MATCH "```text\n([^`]+)```" shown "${readme}")
string(REGEX MATCHALL "[^\n]+" shown "${CMAKE_MATCH_1}")
if(NOT shown)
  message(FATAL_ERROR "check_readme: README.md shows no line of the table")
endif()
foreach(line IN LISTS shown)
  string(FIND "\n${table}" "\n${line}\n" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "check_readme: README.md shows a line that the demo does not print:\n${line}")
  endif()
endforeach()
string(REGEX MATCHALL "\n" lines "${readme}")
list(LENGTH lines count)
if(count GREATER 120)
  message(FATAL_ERROR "check_readme: README.md has ${count} lines, more than 120")
endif()
message(STATUS "check_readme: sample and tables agree")
