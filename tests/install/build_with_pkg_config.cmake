# Builds and runs consumer/main.cpp with nothing but the compiler and what pkg-config says of the rivid in
# PREFIX. LINKAGE: --static for the archive, --shared for the library; RUN_SAYS: what the program must print.

if(NOT PKG_CONFIG)
  message(STATUS "skipped: there is no pkg-config")
  return()
endif()
file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR})
file(GLOB_RECURSE pc ${PREFIX}/*/rivid.pc)
cmake_path(GET pc PARENT_PATH folder)
set(ENV{PKG_CONFIG_PATH} ${folder})

# ask(VARIABLE FLAGS…)
macro(ask variable)
  execute_process(
    COMMAND ${PKG_CONFIG} ${ARGN} rivid
    OUTPUT_VARIABLE ${variable}
    OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
endmacro()
ask(version --modversion)
if(NOT version STREQUAL VERSION)
  message(FATAL_ERROR "rivid.pc has version ${version}, the project ${VERSION}")
endif()
ask(cflags --cflags)
set(static "")
if(LINKAGE STREQUAL "--static")
  set(static --static)
endif()
ask(libs --libs ${static})
message(STATUS "${cflags}")
message(STATUS "${libs}")
separate_arguments(arguments UNIX_COMMAND "${FLAGS} ${cflags} ${CONSUMER}/main.cpp ${libs}")
execute_process(COMMAND ${COMPILER} -std=c++20 -DRIVID_VERSION="${version}" -o ${WORK_DIR}/consumer ${arguments}
                COMMAND_ERROR_IS_FATAL ANY)

if(LINKAGE STREQUAL "--shared")
  cmake_path(GET folder PARENT_PATH library_folder)
  set(ENV{LD_LIBRARY_PATH} ${library_folder})
endif()
execute_process(
  COMMAND ${WORK_DIR}/consumer
  OUTPUT_VARIABLE output
  ECHO_OUTPUT_VARIABLE COMMAND_ERROR_IS_FATAL ANY)
if(NOT output MATCHES "${RUN_SAYS}")
  message(FATAL_ERROR "the consumer should have said: ${RUN_SAYS}")
endif()
