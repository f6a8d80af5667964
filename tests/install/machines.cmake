# cmake -DCHECK=<RividMachine.cmake> -P machines.cmake
#
# 32 bit and big-endian machines are refused in words, others not.

foreach(machine IN ITEMS "8 LITTLE_ENDIAN 0" "4 LITTLE_ENDIAN one.of.32" "8 BIG_ENDIAN big-endian.one")
  separate_arguments(machine UNIX_COMMAND "${machine}")
  list(GET machine 0 pointer)
  list(GET machine 1 order)
  list(GET machine 2 words)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -DCMAKE_SIZEOF_VOID_P=${pointer} -DCMAKE_CXX_BYTE_ORDER=${order} -DCMAKE_CXX_COMPILER=c++ -P ${CHECK}
    ERROR_VARIABLE said
    RESULT_VARIABLE failed)
  if(words STREQUAL "0" AND failed)
    message(FATAL_ERROR "refused, but should not have been:\n${said}")
  elseif(NOT words STREQUAL "0" AND (NOT failed OR NOT said MATCHES "${words}"))
    message(FATAL_ERROR "should have been refused with ${words}:\n${said}")
  endif()
endforeach()
