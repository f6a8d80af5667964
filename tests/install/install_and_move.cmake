# Installs into STAGING and moves that to PREFIX: a package that remembers where it was is found out.

file(REMOVE_RECURSE ${STAGING} ${PREFIX})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${STAGING} --config "${CONFIG}"
                COMMAND_ERROR_IS_FATAL ANY)
file(RENAME ${STAGING} ${PREFIX})

include(${CMAKE_CURRENT_LIST_DIR}/check_prefix.cmake)
