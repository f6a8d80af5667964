# cmake -DPACKAGE=….deb -DBUILD_DIR=… -DSOURCE_DIR=… -DWORK_DIR=… -P package.cmake
#
# The Debian package that BUILD_DIR made of SOURCE_DIR, laid out in WORK_DIR: its tools run, and a consumer is built with it.

cmake_minimum_required(VERSION 3.25)

file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR})
execute_process(COMMAND dpkg -x ${PACKAGE} ${WORK_DIR} COMMAND_ERROR_IS_FATAL ANY)
set(PREFIX ${WORK_DIR}/usr)
set(STAGING ${WORK_DIR})
include(${CMAKE_CURRENT_LIST_DIR}/check_prefix.cmake)

set(CONSUMER ${CMAKE_CURRENT_LIST_DIR}/consumer)
string(APPEND WORK_DIR /consumer)
set(GENERATOR Ninja)
set(COMPILER c++)
set(RUN_SAYS "rivid [0-9.]+: 13 base parameters of 28 standard ones")
include(${CMAKE_CURRENT_LIST_DIR}/build_consumer.cmake)
