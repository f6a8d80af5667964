# cmake -DPROGRAM=<tool> -DPAGE=<tool.1> -P check_man_page.cmake
#
# The man page has a NAME, a SYNOPSIS, and every option that the tool names with --help, subcommands included.

cmake_minimum_required(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/help_text.cmake)
cmake_path(GET PROGRAM FILENAME tool)
name_in_help(called ${tool})
file(READ ${PAGE} page)
string(REPLACE "\\-" "-" page "${page}")

if(NOT page MATCHES "\n.SH NAME\n${tool} - [^\n]+\n.SH SYNOPSIS\n${called} ")
  message(FATAL_ERROR "${PAGE} does not begin as a man page does")
endif()
execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "${called} [a-z]+ [A-Z]" commands "${help}")
foreach(command IN LISTS commands)
  string(REGEX REPLACE "^${called} ([^ ]+) .*" "\\1" command "${command}")
  execute_process(COMMAND ${PROGRAM} ${command} --help OUTPUT_VARIABLE more COMMAND_ERROR_IS_FATAL ANY)
  string(APPEND help "${more}")
endforeach()
string(REGEX MATCHALL "--[a-z][a-z-]+" options "${help}")
list(REMOVE_DUPLICATES options)
list(LENGTH options count)
if(count LESS 3)
  message(FATAL_ERROR "only ${count} options found in --help")
endif()
foreach(option IN LISTS options)
  if(NOT page MATCHES "\\\\fB(-[a-z], )?${option}\\\\fR")
    message(FATAL_ERROR "${PAGE} has no entry for ${option}")
  endif()
endforeach()
message(STATUS "check_man_page: ${count} options")
