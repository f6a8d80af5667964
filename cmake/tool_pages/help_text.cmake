# What a tool says with --help, as variables. Man pages and completions are made from it, so that no list is
# kept by hand.
#
# read_help(PREFIX COMMAND…) runs COMMAND… --help and sets
#
#   PREFIX_description, PREFIX_usage    text
#   PREFIX_footer                       list of lines
#   PREFIX_commands                     words that may stand first: those of a section "Subcommands:", and those that
#                                       the footer shows as "tool word OPERAND"
#   PREFIX_entries                      numbers of the positionals and options, and of entry k:
#   PREFIX_<k>_names                    list: a positional's name, or the option with its short form first
#   PREFIX_<k>_value                    what stands for the value, as FILE; empty for a flag
#   PREFIX_<k>_choices                  list of the words that the value may be, or empty
#   PREFIX_<k>_repeats                  whether more than one value may follow
#   PREFIX_<k>_text                     the description
#
# Brackets and semicolons mean something in a CMake list: three control characters stand for them, which
# plain(VARIABLE) turns back.

string(ASCII 28 stands_for_semicolon)
string(ASCII 29 stands_for_opening)
string(ASCII 30 stands_for_closing)

# What help calls a link of an old name: rivid_excite is "rivid excite"; subcommands of rivid_identify are
# rivid's own.
function(name_in_help out tool)
  string(REGEX REPLACE "^rivid_identify$" "rivid" tool "${tool}")
  string(REGEX REPLACE "^rivid_montecarlo$" "rivid study" tool "${tool}")
  string(REPLACE "_" " " tool "${tool}")
  set(${out} "${tool}" PARENT_SCOPE)
endfunction()

macro(plain variable)
  string(REPLACE "${stands_for_semicolon}" ";" ${variable} "${${variable}}")
  string(REPLACE "${stands_for_opening}" "[" ${variable} "${${variable}}")
  string(REPLACE "${stands_for_closing}" "]" ${variable} "${${variable}}")
endmacro()

# The words between the names of an option and its description: "FILE ... Needs: --other", "N:POSITIVE",
# "mujoco|drake:{mujoco,drake}".
function(read_specification specification out)
  string(REGEX REPLACE " *(REQUIRED|Needs:|Excludes:).*" "" specification "${specification}")
  set(repeats FALSE)
  if(specification MATCHES "\\.\\.\\.")
    set(repeats TRUE)
    string(REGEX REPLACE " *\\.\\.\\." "" specification "${specification}")
  endif()
  set(choices "")
  if(specification MATCHES "{(.*)}")
    string(REPLACE "," ";" choices "${CMAKE_MATCH_1}")
    list(JOIN choices "|" value)
  else()
    string(REGEX REPLACE ":.*" "" value "${specification}")
    if(value MATCHES "[|]")
      string(REPLACE "|" ";" choices "${value}")
    endif()
  endif()
  set(${out}_value "${value}" PARENT_SCOPE)
  set(${out}_choices "${choices}" PARENT_SCOPE)
  set(${out}_repeats ${repeats} PARENT_SCOPE)
endfunction()

# A line that begins an entry: names, one blank and the specification, two blanks or more and the description.
function(read_entry line out)
  string(STRIP "${line}" line)
  if(line MATCHES "^((-[A-Za-z]), *)?(--?[A-Za-z][-A-Za-z_0-9]*)(.*)$")
    set(names ${CMAKE_MATCH_2} ${CMAKE_MATCH_3})
    set(rest "${CMAKE_MATCH_4}")
  elseif(line MATCHES "^([A-Za-z_]+)(.*)$")
    set(names ${CMAKE_MATCH_1})
    set(rest "${CMAKE_MATCH_2}")
  else()
    message(FATAL_ERROR "--help has a line that is no option: ${line}")
  endif()
  set(text "")
  if(rest MATCHES "^(.*[^ ])?  +(.*)$")
    set(rest "${CMAKE_MATCH_1}")
    set(text "${CMAKE_MATCH_2}")
  elseif(rest MATCHES "^( [^ ]+[|][^ ]+) (.*)$")
    # Choices that leave room for one blank alone.
    set(rest "${CMAKE_MATCH_1}")
    set(text "${CMAKE_MATCH_2}")
  endif()
  string(STRIP "${rest}" rest)
  read_specification("${rest}" read)
  foreach(part IN ITEMS value choices repeats)
    set(${out}_${part} "${read_${part}}" PARENT_SCOPE)
  endforeach()
  set(${out}_names "${names}" PARENT_SCOPE)
  set(${out}_text "${text}" PARENT_SCOPE)
endfunction()

macro(read_help prefix)
  execute_process(
    COMMAND ${ARGN} --help
    OUTPUT_VARIABLE help_text
    COMMAND_ERROR_IS_FATAL ANY)
  string(REPLACE ";" "${stands_for_semicolon}" help_text "${help_text}")
  string(REPLACE "[" "${stands_for_opening}" help_text "${help_text}")
  string(REPLACE "]" "${stands_for_closing}" help_text "${help_text}")
  string(REPLACE "\n" ";" help_text "${help_text}")
  set(part description)
  set(count 0)
  foreach(name IN ITEMS description usage footer commands entries)
    set(${prefix}_${name} "")
  endforeach()
  foreach(line IN LISTS help_text)
    if(line MATCHES "^ *Usage: +(.*)$")
      set(${prefix}_usage "${CMAKE_MATCH_1}")
      set(part usage)
    elseif(line MATCHES "^[A-Za-z]+:$")
      string(TOLOWER "${line}" part)
    elseif(part STREQUAL "description")
      string(APPEND ${prefix}_description " ${line}")
    elseif(line MATCHES "^[^ ]")
      list(APPEND ${prefix}_footer "${line}")
      set(part footer)
    elseif(part STREQUAL "footer" AND line MATCHES "^ +(.*)$")
      string(APPEND ${prefix}_footer " ${CMAKE_MATCH_1}")
    elseif(part STREQUAL "subcommands:" AND line MATCHES "^  ([a-z_]+)")
      list(APPEND ${prefix}_commands ${CMAKE_MATCH_1})
    elseif(part MATCHES "options:|positionals:" AND line MATCHES "^  ?[^ ]")
      math(EXPR count "${count} + 1")
      list(APPEND ${prefix}_entries ${count})
      read_entry("${line}" ${prefix}_${count})
    elseif(part MATCHES "options:|positionals:" AND line MATCHES "^ +([^ ].*)$")
      string(APPEND ${prefix}_${count}_text " ${CMAKE_MATCH_1}")
    endif()
  endforeach()
  string(STRIP "${${prefix}_description}" ${prefix}_description)
  foreach(k IN LISTS ${prefix}_entries)
    string(STRIP "${${prefix}_${k}_text}" ${prefix}_${k}_text)
  endforeach()
  cmake_path(GET PROGRAM FILENAME tool)
  name_in_help(called ${tool})
  string(REGEX MATCHALL "${called} [a-z_]+ [A-Z][A-Za-z_.]*" shown "${${prefix}_footer}")
  foreach(example IN LISTS shown)
    string(REGEX REPLACE "^${called} ([^ ]+) .*" "\\1" word "${example}")
    list(APPEND ${prefix}_commands ${word})
  endforeach()
  list(REMOVE_DUPLICATES ${prefix}_commands)
endmacro()

# The tool and its subcommands: help_<…> and, of subcommand s, help_of_<s>_<…>.
macro(read_whole_help)
  read_help(help ${PROGRAM})
  foreach(command IN LISTS help_commands)
    read_help(help_of_${command} ${PROGRAM} ${command})
  endforeach()
endmacro()

# completion_of(OUT ENTRY WORDS FOLDERS ENDING FILES NOTHING): which of these completes the value of an entry;
# @ in it becomes the words, or the ending.
function(completion_of out entry words folders ending files nothing)
  set(value "${${entry}_value}")
  set(what "")
  if(${entry}_choices)
    list(JOIN ${entry}_choices " " what)
    set(action "${words}")
  elseif(value STREQUAL "CODE")
    # The first word of each line of the list.
    execute_process(COMMAND ${PROGRAM} explain OUTPUT_VARIABLE list COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX MATCHALL "(^|\n)[a-z_]+" codes "${list}")
    list(JOIN codes " " what)
    string(REPLACE "\n" "" what "${what}")
    set(action "${words}")
  elseif(value MATCHES "^DIR$")
    set(action "${folders}")
  elseif(value MATCHES "[.]([a-z]+)$")
    set(what ${CMAKE_MATCH_1})
    set(action "${ending}")
  elseif(value MATCHES "^FILE")
    set(action "${files}")
  else()
    set(action "${nothing}")
  endif()
  string(REPLACE "@" "${what}" action "${action}")
  set(${out} "${action}" PARENT_SCOPE)
endfunction()
