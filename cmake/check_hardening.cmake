# A tool binds all symbols when it starts, may not write to its tables of them, and checks its stack.
#
# cmake -DREADELF=… -DPROGRAM=… -P check_hardening.cmake

execute_process(COMMAND ${READELF} --dynamic --segments --wide ${PROGRAM} OUTPUT_VARIABLE parts COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${READELF} --dyn-syms --wide ${PROGRAM} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
foreach(mark IN ITEMS "BIND_NOW|Flags: NOW" GNU_RELRO "Flags:.*PIE")
  if(NOT parts MATCHES "${mark}")
    message(FATAL_ERROR "${PROGRAM}: readelf shows no ${mark}")
  endif()
endforeach()
if(NOT symbols MATCHES "__stack_chk_fail")
  message(FATAL_ERROR "${PROGRAM}: built without stack protector")
endif()
