# `cmake --install`: the archive, its headers, and a package that find_package(rivid) finds wherever the
# prefix is moved to.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(RIVID_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/rivid)

install(
  TARGETS rivid
  EXPORT rividTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  FILE_SET HEADERS
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(
  EXPORT rividTargets
  NAMESPACE rivid::
  DESTINATION ${RIVID_INSTALL_CMAKEDIR})

configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/rividConfig.cmake.in ${PROJECT_BINARY_DIR}/rividConfig.cmake
  INSTALL_DESTINATION ${RIVID_INSTALL_CMAKEDIR}
  NO_SET_AND_CHECK_MACRO)
# Before 1.0 a minor version may break what was: 0.1.3 serves who asked for 0.1, 0.2.0 does not.
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/rividConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(
  FILES ${PROJECT_BINARY_DIR}/rividConfig.cmake ${PROJECT_BINARY_DIR}/rividConfigVersion.cmake
        ${CMAKE_CURRENT_LIST_DIR}/RividDependencies.cmake
  DESTINATION ${RIVID_INSTALL_CMAKEDIR})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
# The library holds what the reports bring along.
install(
  FILES ${PROJECT_SOURCE_DIR}/third_party/uplot/LICENSE
  DESTINATION ${CMAKE_INSTALL_DOCDIR}
  RENAME LICENSE.uPlot)
