# Names the packages of packages.txt that are not installed, where dpkg can tell: what a build without them
# stops at is a name of CMake's. Their like may come from elsewhere, so that this is no error.

find_program(RIVID_DPKG_QUERY dpkg-query)
mark_as_advanced(RIVID_DPKG_QUERY)
if(NOT RIVID_DPKG_QUERY)
  return()
endif()

# Of the tests alone.
set(not_for_users libgtest-dev libfcl-dev libbenchmark-dev python3-venv)
set(missing "")
file(STRINGS ${PROJECT_SOURCE_DIR}/packages.txt packages)
foreach(package IN LISTS packages)
  execute_process(
    COMMAND ${RIVID_DPKG_QUERY} -W "-f=\${db:Status-Status}" ${package}
    OUTPUT_VARIABLE status
    ERROR_QUIET)
  if(NOT status STREQUAL "installed" AND NOT package IN_LIST not_for_users)
    list(APPEND missing ${package})
  endif()
endforeach()
if(missing)
  list(JOIN missing " " missing)
  message(WARNING "These packages are not installed: ${missing}\n./install-packages.sh installs them.")
endif()
