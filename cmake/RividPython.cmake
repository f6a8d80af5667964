# Whether the Python package is built, and what for it: RIVID_PYTHON is ON, OFF, or AUTO, which builds it
# where Python's headers and nanobind are there, and for its tests NumPy and pytest. RIVID_PYTHON_ABSENT says
# what is missing, empty where nothing is.
#
# The interpreter is that of build/venv where install-packages.sh has made it, else the first in PATH.

set(RIVID_PYTHON_INSTALL_DIR "" CACHE PATH "Folder of modules that `cmake --install` puts the Python package into, or empty")
mark_as_advanced(RIVID_PYTHON_INSTALL_DIR)
set(RIVID_PYTHON_ABSENT "RIVID_PYTHON is OFF")
if(NOT RIVID_PYTHON)
  return()
endif()

set(RIVID_PYTHON_ABSENT "")
if(NOT Python_EXECUTABLE AND EXISTS ${PROJECT_SOURCE_DIR}/build/venv/bin/python)
  set(Python_EXECUTABLE ${PROJECT_SOURCE_DIR}/build/venv/bin/python)
endif()
find_package(Python 3.10 QUIET COMPONENTS Interpreter Development.Module OPTIONAL_COMPONENTS Development.SABIModule)
if(NOT Python_FOUND)
  set(RIVID_PYTHON_ABSENT "Python 3.10 or later with its headers (python3-dev) is missing")
else()
  set(needed nanobind)
  if(RIVID_BUILD_TESTS)
    set(needed "nanobind, numpy, pytest")
  endif()
  execute_process(
    COMMAND ${Python_EXECUTABLE} -c "import ${needed}; print(nanobind.cmake_dir())"
    OUTPUT_VARIABLE nanobind_ROOT
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET
    RESULT_VARIABLE import_failed)
  if(import_failed)
    set(RIVID_PYTHON_ABSENT "${Python_EXECUTABLE} lacks one of ${needed}; install-packages.sh puts them into build/venv")
  else()
    find_package(nanobind CONFIG REQUIRED)
  endif()
endif()

if(RIVID_PYTHON_ABSENT AND (NOT RIVID_PYTHON STREQUAL "AUTO" OR DEFINED ENV{CI}))
  message(FATAL_ERROR "The Python package can not be built: ${RIVID_PYTHON_ABSENT}")
elseif(RIVID_PYTHON_ABSENT)
  message(STATUS "No Python package: ${RIVID_PYTHON_ABSENT}")
endif()
