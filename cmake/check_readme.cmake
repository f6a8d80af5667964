# cmake -DSOURCE_DIR=… -DPROGRAM=<rivid_identify> -DOUTPUT=<folder> -P check_readme.cmake
#
# README.md shows examples/01_identify.cpp as it is, and the table of the demo as it is printed.

cmake_minimum_required(VERSION 3.25)

file(READ ${SOURCE_DIR}/README.md readme)

file(READ ${SOURCE_DIR}/examples/01_identify.cpp example)
string(FIND "${readme}" "```cpp\n${example}```" at)
if(at EQUAL -1)
  message(FATAL_ERROR "check_readme: README.md has no ```cpp block that is examples/01_identify.cpp to the letter")
endif()

execute_process(
  COMMAND ${PROGRAM} data/scara/scara.toml --output ${OUTPUT}
  WORKING_DIRECTORY ${SOURCE_DIR}
  OUTPUT_VARIABLE table
  ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
string(FIND "${readme}" "${table}" at)
if(at EQUAL -1)
  message(NOTICE "${table}")
  message(FATAL_ERROR "check_readme: README.md does not show the table above, which the demo prints")
endif()
message(STATUS "check_readme: sample and table agree")
