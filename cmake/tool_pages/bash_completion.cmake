# cmake -DPROGRAM=<tool> -DOUTPUT=<file> -P bash_completion.cmake
#
# A completion for bash from what the tool says with --help. It needs nothing of the package bash-completion.

cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/help_text.cmake)
read_whole_help()

# Cases of options with values, the words of all options, and what the positional is completed with.
macro(add_command prefix command)
  set(pattern "${command}")
  if(pattern STREQUAL "")
    set(pattern "''")
  endif()
  set(options "")
  set(positional "")
  foreach(k IN LISTS ${prefix}_entries)
    list(GET ${prefix}_${k}_names -1 name)
    completion_of(action ${prefix}_${k} "_${tool}_words @" "_${tool}_files -d" "_${tool}_files -f -X '!*.@'"
                  "_${tool}_files -f" ":")
    if(NOT name MATCHES "^-")
      # The words before the cursor do not say which of several positionals is meant.
      string(APPEND positional "${action}; ")
      continue()
    endif()
    list(APPEND options ${${prefix}_${k}_names})
    if(${prefix}_${k}_repeats)
      string(APPEND values "    ${command}:${name}:*) ${action}; return ;;\n")
    elseif(NOT "${${prefix}_${k}_value}" STREQUAL "")
      string(APPEND values "    ${command}:${name}:1) ${action}; return ;;\n")
    endif()
  endforeach()
  list(JOIN options " " options)
  string(APPEND words "      ${pattern}) _${tool}_words ${options} ;;\n")
  if(positional STREQUAL "")
    set(positional ":; ")
  endif()
  string(APPEND positionals "    ${pattern}) ${positional};;\n")
endmacro()

set(values "")
set(words "")
set(positionals "")
add_command(help "")
foreach(command IN LISTS help_commands)
  add_command(help_of_${command} ${command})
endforeach()
list(JOIN help_commands "|" patterns)
list(JOIN help_commands " " commands)
set(find_command "")
set(offer_commands "")
if(help_commands)
  set(find_command "  if ((COMP_CWORD > 1)); then
    case \${COMP_WORDS[1]} in ${patterns}) command=\${COMP_WORDS[1]} ;; esac
  fi
")
  set(offer_commands "  if ((COMP_CWORD == 1)); then _${tool}_words ${commands}; fi
")
endif()

set(script
    "# Completion of ${tool} for bash, made from the output of ${tool} --help.

_${tool}_words() {
  local found
  while IFS= read -r found; do COMPREPLY+=(\"$found\"); done < <(compgen -W \"$*\" -- \"$word\")
}

# Files as compgen is told, and the folders on the way to them.
_${tool}_files() {
  local found
  compopt -o filenames 2>/dev/null
  while IFS= read -r found; do COMPREPLY+=(\"$found\"); done < <(
    { compgen \"$@\" -- \"$word\"; compgen -d -- \"$word\"; } | sort -u
  )
}

_${tool}() {
  local word=\${COMP_WORDS[COMP_CWORD]} command= option= distance=0 k
  COMPREPLY=()
${find_command}  # --option=value comes as three words.
  if [[ $word == = ]]; then word=; fi
  for ((k = COMP_CWORD - 1; k > 0; --k)); do
    if [[ \${COMP_WORDS[k]} != = ]]; then ((++distance)); fi
    if [[ \${COMP_WORDS[k]} == -* ]]; then
      option=\${COMP_WORDS[k]}
      break
    fi
  done
  if [[ $word == -* ]]; then
    case $command in
${words}    esac
    return
  fi
  case $command:$option:$distance in
${values}  esac
${offer_commands}  case $command in
${positionals}  esac
}

complete -F _${tool} ${tool}
")
plain(script)
file(WRITE ${OUTPUT} "${script}")
