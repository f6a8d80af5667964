# Configures, builds and runs the project CONSUMER against the rivid in PREFIX. RUN_SAYS: what the program
# must print; LINK_SAYS instead: the link must fail with these words.

file(REMOVE_RECURSE ${WORK_DIR})
execute_process(
  COMMAND ${CMAKE_COMMAND} -S ${CONSUMER} -B ${WORK_DIR} -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER}
          -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS=${FLAGS}" -DCMAKE_PREFIX_PATH=${PREFIX}
          -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF
  COMMAND_ERROR_IS_FATAL ANY)
file(STRINGS ${WORK_DIR}/CMakeCache.txt found REGEX "^rivid_DIR:PATH=")
if(NOT found MATCHES "=${PREFIX}/")
  message(FATAL_ERROR "the consumer found another rivid: ${found}")
endif()

execute_process(
  COMMAND ${CMAKE_COMMAND} --build ${WORK_DIR} --config Release
  OUTPUT_VARIABLE output
  ERROR_VARIABLE output
  ECHO_OUTPUT_VARIABLE ECHO_ERROR_VARIABLE
  RESULT_VARIABLE failed)
if(LINK_SAYS)
  if(NOT failed)
    message(FATAL_ERROR "the consumer was linked, but should not have been")
  elseif(NOT output MATCHES "undefined reference[^\n]*${LINK_SAYS}")
    message(FATAL_ERROR "the build failed without saying ${LINK_SAYS}")
  endif()
  message(STATUS "the link failed as it should")
  return()
elseif(failed)
  message(FATAL_ERROR "the consumer did not build")
endif()

execute_process(
  COMMAND ${WORK_DIR}/consumer
  OUTPUT_VARIABLE output
  ECHO_OUTPUT_VARIABLE
  COMMAND_ERROR_IS_FATAL ANY)
if(NOT output MATCHES "${RUN_SAYS}")
  message(FATAL_ERROR "the consumer should have said: ${RUN_SAYS}")
endif()
