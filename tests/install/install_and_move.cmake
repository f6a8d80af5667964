# Installs into STAGING and moves that to PREFIX: a package that remembers where it was is found out.

file(REMOVE_RECURSE ${STAGING} ${PREFIX})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${STAGING} --config "${CONFIG}"
                COMMAND_ERROR_IS_FATAL ANY)
file(RENAME ${STAGING} ${PREFIX})

file(GLOB_RECURSE package_files ${PREFIX}/*.cmake)
if(NOT package_files)
  message(FATAL_ERROR "nothing for find_package was installed")
endif()
foreach(file IN LISTS package_files)
  file(READ ${file} text)
  foreach(path IN ITEMS ${STAGING} ${BUILD_DIR} ${SOURCE_DIR})
    string(FIND "${text}" "${path}/" at)
    if(NOT at EQUAL -1)
      message(FATAL_ERROR "${file} names ${path}, which a user does not have")
    endif()
  endforeach()
endforeach()
