# cmake -DSOURCE_DIR=… -DWORK_DIR=… [-DWHOLE=ON] -P reproducible.cmake
#
# Builds copies of the sources in two folders, the files of the second one years older, and compares what
# comes out bit by bit: some objects of the package, or with WHOLE all that is installed.

cmake_minimum_required(VERSION 3.25)

set(objects data/dialect report/json report/markup signal/filter)
set(ENV{SOURCE_DATE_EPOCH} 1700000000)

function(run folder)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${folder} RESULT_VARIABLE failed OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(failed)
    message(FATAL_ERROR "${ARGN} failed in ${folder}:\n${out}")
  endif()
endfunction()

# Files of a folder by their hashes, into a variable.
function(build folder result)
  file(REMOVE_RECURSE ${folder})
  file(GLOB parts ${SOURCE_DIR}/*)
  list(FILTER parts EXCLUDE REGEX "/build[^/]*$")
  file(COPY ${parts} DESTINATION ${folder})
  if(ARGN)
    file(GLOB_RECURSE files ${folder}/src/*.* ${folder}/include/*.*)
    run(${folder} touch -d 2001-01-01 ${files})
  endif()
  # Whatever reads the clock is an error.
  run(${folder} ${CMAKE_COMMAND} --preset package -DCMAKE_UNITY_BUILD=${WHOLE} -DCMAKE_CXX_FLAGS=-Werror=date-time)
  set(built ${folder}/build/package)
  if(WHOLE)
    run(${folder} ${CMAKE_COMMAND} --build --preset package)
    run(${folder} ${CMAKE_COMMAND} --install ${built} --strip --prefix ${built}/prefix)
    file(GLOB_RECURSE made ${built}/prefix/*)
  else()
    list(TRANSFORM objects REPLACE "(.+)" "src/CMakeFiles/rivid.dir/\\1.cpp.o" OUTPUT_VARIABLE targets)
    run(${folder} ${CMAKE_COMMAND} --build ${built} --target ${targets})
    list(TRANSFORM targets PREPEND ${built}/ OUTPUT_VARIABLE made)
  endif()
  set(hashes "")
  foreach(file IN LISTS made)
    file(SHA256 ${file} hash)
    cmake_path(GET file FILENAME name)
    list(APPEND hashes "${hash} ${name}")
  endforeach()
  set(${result} ${hashes} PARENT_SCOPE)
endfunction()

if(NOT WHOLE)
  set(WHOLE OFF)
endif()
build(${WORK_DIR}/a first)
build(${WORK_DIR}/another/much/longer/path second older)
if(NOT first OR NOT first STREQUAL second)
  message(FATAL_ERROR "Two builds differ:\n${first}\n${second}")
endif()
list(JOIN first "\n" first)
message(STATUS "two builds, one hash:\n${first}")
