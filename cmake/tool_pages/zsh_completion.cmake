# cmake -DPROGRAM=<tool> -DOUTPUT=<file> -P zsh_completion.cmake
#
# A completion for zsh from what the tool says with --help.

cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/help_text.cmake)
read_whole_help()

# Text within the brackets of _arguments and within single quotes.
function(quoted out text)
  string(REPLACE "\\" "\\\\" text "${text}")
  string(REPLACE "${stands_for_opening}" "\\${stands_for_opening}" text "${text}")
  string(REPLACE "${stands_for_closing}" "\\${stands_for_closing}" text "${text}")
  string(REPLACE "'" "'\\''" text "${text}")
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

# The arguments of _arguments.
macro(add_specifications prefix first)
  set(specifications "")
  foreach(k IN LISTS ${prefix}_entries)
    list(GET ${prefix}_${k}_names -1 name)
    set(value "${${prefix}_${k}_value}")
    quoted(text "${${prefix}_${k}_text}")
    completion_of(action ${prefix}_${k} "(@)" "_files -/" "_files -g \"*.@\"" "_files" " ")
    list(LENGTH ${prefix}_${k}_names count)
    if(NOT name MATCHES "^-")
      if(NOT "${first}" STREQUAL "")
        set(action "${first}")
      endif()
      set(specification "'1:${name}:${action}'")
    elseif(count EQUAL 2)
      list(GET ${prefix}_${k}_names 0 short)
      set(specification "'(${short} ${name})'{${short},${name}}'${stands_for_opening}${text}${stands_for_closing}'")
    elseif(value STREQUAL "")
      set(specification "'${name}${stands_for_opening}${text}${stands_for_closing}'")
    else()
      set(specification "'${name}=${stands_for_opening}${text}${stands_for_closing}:${value}:${action}'")
      if(${prefix}_${k}_repeats)
        string(PREPEND specification "'*'")
      endif()
    endif()
    string(APPEND specifications " \\\n    ${specification}")
  endforeach()
endmacro()

set(subcommands "")
set(first "")
set(first_function "")
if(help_commands)
  set(first "_${tool}_first")
  list(JOIN help_commands " " words)
  set(first_function "_${tool}_first() {
  _alternative 'commands:command:(${words})' 'files:experiment:_files -g \"*.toml\"'
}

")
  foreach(command IN LISTS help_commands)
    add_specifications(help_of_${command} "")
    string(APPEND subcommands "  if ((CURRENT > 2)) && [${stands_for_opening} $words[2] == ${command} ]]; then
    shift words
    ((--CURRENT))
    _arguments${specifications}
    return
  fi
")
  endforeach()
endif()
add_specifications(help "${first}")

set(script
    "#compdef ${tool}
# Completion of ${tool} for zsh, made from the output of ${tool} --help.

${first_function}_${tool}() {
${subcommands}  _arguments${specifications}
}

_${tool} \"$@\"
")
plain(script)
file(WRITE ${OUTPUT} "${script}")
