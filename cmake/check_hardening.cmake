# A tool binds all symbols when it starts and may not write to its tables of them; functions of the library
# that it is linked with, parsers among them, check their stack.
#
# cmake -DREADELF=… -DOBJDUMP=… -DPROGRAM=… -P check_hardening.cmake

execute_process(COMMAND ${READELF} --dynamic --segments --wide ${PROGRAM} OUTPUT_VARIABLE parts COMMAND_ERROR_IS_FATAL ANY)
foreach(mark IN ITEMS "BIND_NOW|Flags: NOW" GNU_RELRO)
  if(NOT parts MATCHES "${mark}")
    message(FATAL_ERROR "${PROGRAM}: readelf shows no ${mark}")
  endif()
endforeach()
if(NOT PROGRAM MATCHES "[.]so$" AND NOT parts MATCHES "Flags:.*PIE")
  message(FATAL_ERROR "${PROGRAM}: readelf shows no PIE")
endif()
# Functions of rivid::, those of the tool itself aside, that end in a call where their stack was overwritten.
# Each of these parsers has an array on its stack.
execute_process(
  COMMAND ${OBJDUMP} --disassemble --no-show-raw-insn --section=.text ${PROGRAM}
  COMMAND awk "/^[0-9a-f]+ </ { name = $2 } /__stack_chk_fail/ && name ~ /_ZNK?5rivid/ && name !~ /5rivid4apps/ { print name }"
  COMMAND sort -u
  OUTPUT_VARIABLE protected)
string(REGEX MATCHALL "\n" lines "${protected}")
list(LENGTH lines count)
message(STATUS "${PROGRAM}: ${count} functions of the library check their stack")
foreach(parser IN ITEMS parse_urdf read_csv read_experiment)
  if(NOT protected MATCHES "${parser}")
    message(FATAL_ERROR "${PROGRAM}: no function ${parser} with a stack protector")
  endif()
endforeach()
