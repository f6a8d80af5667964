# Target `doxygen`, where that program is: pages of the public headers in doxygen/html of the build folder.
# Warnings are errors.

find_program(RIVID_DOXYGEN doxygen DOC "Doxygen, for the pages of the headers")
mark_as_advanced(RIVID_DOXYGEN)
if(RIVID_DOXYGEN AND PROJECT_IS_TOP_LEVEL)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/Doxyfile.in ${PROJECT_BINARY_DIR}/Doxyfile @ONLY)
  add_custom_target(
    doxygen
    COMMAND ${RIVID_DOXYGEN} ${PROJECT_BINARY_DIR}/Doxyfile
    COMMENT "Pages of the public headers"
    VERBATIM)
endif()
