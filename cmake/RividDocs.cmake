# The documentation site: target `docs`, in docs_site of the build folder, and target `figures`, which draws
# docs/figures anew. RIVID_DOCS_ABSENT says what is missing for them, empty where nothing is.
#
# The interpreter is RIVID_DOCS_PYTHON, else that of build/venv where install-packages.sh has made it, else
# the first in PATH.

set(RIVID_DOCS_ABSENT "")
if(NOT RIVID_BUILD_TESTS OR NOT RIVID_BUILD_APPS OR RIVID_SANITIZE)
  set(RIVID_DOCS_ABSENT "tests or tools are not built, or by sanitizers")
  return()
endif()
if(NOT RIVID_DOCS_PYTHON AND EXISTS ${PROJECT_SOURCE_DIR}/build/venv/bin/python)
  set(RIVID_DOCS_PYTHON ${PROJECT_SOURCE_DIR}/build/venv/bin/python)
endif()
find_program(RIVID_DOCS_PYTHON python3 DOC "Python with MkDocs Material and Matplotlib, for the documentation")
mark_as_advanced(RIVID_DOCS_PYTHON)
set(import_failed TRUE)
if(RIVID_DOCS_PYTHON)
  execute_process(
    COMMAND ${RIVID_DOCS_PYTHON} -c "import material, matplotlib, mkdocs, numpy"
    OUTPUT_QUIET ERROR_QUIET
    RESULT_VARIABLE import_failed)
endif()
if(import_failed)
  set(RIVID_DOCS_ABSENT "MkDocs Material or Matplotlib is missing; install-packages.sh puts them into build/venv")
  # Builds without the Python package ask for nothing that pip installs.
  if(DEFINED ENV{CI} AND RIVID_PYTHON)
    message(FATAL_ERROR "The documentation can not be built: ${RIVID_DOCS_ABSENT}")
  endif()
  message(STATUS "No documentation site: ${RIVID_DOCS_ABSENT}")
  return()
endif()

set(RIVID_DOCS_FIGURES ${RIVID_DOCS_PYTHON} ${PROJECT_SOURCE_DIR}/docs/site/figures.py --tools ${PROJECT_BINARY_DIR}/apps)
set(RIVID_DOCS_SITE ${RIVID_DOCS_PYTHON} ${PROJECT_SOURCE_DIR}/docs/site/build.py --out ${PROJECT_BINARY_DIR}/docs_site --api
                    ${PROJECT_BINARY_DIR}/doxygen/html --tools ${PROJECT_BINARY_DIR}/apps)

add_custom_target(
  docs
  COMMAND ${RIVID_DOCS_SITE}
  COMMENT "Building the documentation site"
  VERBATIM)
add_dependencies(docs rivid_identify rivid_simulate)
if(TARGET doxygen)
  add_dependencies(docs doxygen)
endif()
add_custom_target(
  figures
  COMMAND ${RIVID_DOCS_FIGURES} --out ${PROJECT_SOURCE_DIR}/docs/figures --work ${PROJECT_BINARY_DIR}/figures_work
          "$<$<BOOL:${RIVID_REAL_DATA}>:--data;${RIVID_REAL_DATA}>"
  COMMENT "Drawing the figures of the documentation"
  COMMAND_EXPAND_LISTS VERBATIM)
add_dependencies(figures rivid_excite rivid_identify rivid_montecarlo rivid_simulate)
