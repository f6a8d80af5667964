# cmake -DFIRST=… -DSECOND=… -P check_same_output.cmake
#
# Two programs print the same, and something.

cmake_minimum_required(VERSION 3.25)

foreach(program IN ITEMS FIRST SECOND)
  execute_process(COMMAND ${${program}} OUTPUT_VARIABLE said_${program} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
if(said_FIRST STREQUAL "" OR NOT said_FIRST STREQUAL said_SECOND)
  message(FATAL_ERROR "${FIRST} and ${SECOND} do not print the same")
endif()
