# cmake -DPACKAGES=<folder of .deb> -DSOURCE_DIR=… -DWORK_DIR=… -P package.cmake
#
# The Debian packages that packaging/debian.sh made of SOURCE_DIR, laid out in WORK_DIR: the tools run, and a
# consumer is built with them.

cmake_minimum_required(VERSION 3.25)

file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR})
foreach(name IN ITEMS librivid0 librivid-dev rivid python3-rivid)
  file(GLOB package ${PACKAGES}/${name}_*.deb)
  if(NOT package)
    message(FATAL_ERROR "there is no package ${name} in ${PACKAGES}")
  endif()
  execute_process(COMMAND dpkg -x ${package} ${WORK_DIR} COMMAND_ERROR_IS_FATAL ANY)
  # Licences of what is built in.
  file(READ ${WORK_DIR}/usr/share/doc/${name}/copyright text)
  foreach(part IN ITEMS "The rivid authors" SUNDIALS "toml\\+\\+" "JSON for Modern C\\+\\+" CLI11 nanobind)
    if(NOT text MATCHES "${part}")
      message(FATAL_ERROR "copyright of ${name} does not mention ${part}")
    endif()
  endforeach()
endforeach()
set(PREFIX ${WORK_DIR}/usr)
set(STAGING ${WORK_DIR})
set(BUILD_DIR ${PACKAGES})
file(GLOB library ${PREFIX}/lib/*/librivid.so)
cmake_path(GET library PARENT_PATH folder)
set(ENV{LD_LIBRARY_PATH} ${folder})
include(${CMAKE_CURRENT_LIST_DIR}/check_prefix.cmake)

set(CONSUMER ${CMAKE_CURRENT_LIST_DIR}/consumer)
string(APPEND WORK_DIR /consumer)
set(GENERATOR Ninja)
set(COMPILER c++)
set(RUN_SAYS "rivid [0-9.]+: 13 base parameters of 28 standard ones")
include(${CMAKE_CURRENT_LIST_DIR}/build_consumer.cmake)
