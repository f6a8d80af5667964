# Man pages and completions of the tools, made from their --help when they are built. A cross-compiled tool
# can not be asked, and gets none.

include(GNUInstallDirs)

set(RIVID_BASH_COMPLETIONS ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
    CACHE STRING "Folder for completions of bash, below the prefix")
set(RIVID_ZSH_COMPLETIONS ${CMAKE_INSTALL_DATADIR}/zsh/site-functions
    CACHE STRING "Folder for completions of zsh, below the prefix")
mark_as_advanced(RIVID_BASH_COMPLETIONS RIVID_ZSH_COMPLETIONS)

# rivid_tool_pages(TOOLS…): TOOL.1, completions/TOOL for bash and completions/_TOOL for zsh, in the current
# binary folder.
function(rivid_tool_pages)
  if(CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR)
    return()
  endif()
  list(JOIN ARGN "," tools)
  set(scripts ${PROJECT_SOURCE_DIR}/cmake/tool_pages)
  set(folder ${CMAKE_CURRENT_BINARY_DIR})
  file(MAKE_DIRECTORY ${folder}/completions)
  set(pages "")
  foreach(tool IN LISTS ARGN)
    set(made ${folder}/${tool}.1 ${folder}/completions/${tool} ${folder}/completions/_${tool})
    set(ask ${CMAKE_COMMAND} -DPROGRAM=${folder}/${tool})
    add_custom_command(
      OUTPUT ${made}
      COMMAND ${ask} -DVERSION=${PROJECT_VERSION} -DTOOLS=${tools} -DOUTPUT=${folder}/${tool}.1 -P
              ${scripts}/man_page.cmake
      COMMAND ${ask} -DOUTPUT=${folder}/completions/${tool} -P ${scripts}/bash_completion.cmake
      COMMAND ${ask} -DOUTPUT=${folder}/completions/_${tool} -P ${scripts}/zsh_completion.cmake
      DEPENDS rivid_program ${scripts}/help_text.cmake ${scripts}/man_page.cmake ${scripts}/bash_completion.cmake
              ${scripts}/zsh_completion.cmake
      COMMENT "Man page and completions of ${tool}"
      VERBATIM)
    list(APPEND pages ${made})
    if(RIVID_INSTALL)
      install(FILES ${folder}/${tool}.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
      install(FILES ${folder}/completions/${tool} DESTINATION ${RIVID_BASH_COMPLETIONS})
      install(FILES ${folder}/completions/_${tool} DESTINATION ${RIVID_ZSH_COMPLETIONS})
    endif()
  endforeach()
  add_custom_target(tool_pages ALL DEPENDS ${pages})
endfunction()
