# `cmake --install`: the library, its headers, and what find_package(rivid) and pkg-config find wherever the
# prefix is moved to. Debian packages are made of it by `debian/`.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(RIVID_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/rivid)

install(
  TARGETS rivid_headers
  EXPORT rividHeadersTargets
  FILE_SET HEADERS
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  # CMake 3.22 of a user knows no file sets.
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(
  TARGETS rivid
  EXPORT rividTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  FILE_SET HEADERS
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(
  TARGETS rivid_runtime
  EXPORT rividRuntimeTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
foreach(export IN ITEMS rividHeadersTargets rividRuntimeTargets rividTargets)
  install(
    EXPORT ${export}
    NAMESPACE rivid::
    DESTINATION ${RIVID_INSTALL_CMAKEDIR})
endforeach()

set(RIVID_PUBLIC_DEPENDENCIES_ONLY OFF)
if(BUILD_SHARED_LIBS)
  set(RIVID_PUBLIC_DEPENDENCIES_ONLY ON)
endif()
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

# pkg-config: who links the archive says --static, and gets what it was built on.
cmake_path(RELATIVE_PATH CMAKE_INSTALL_PREFIX BASE_DIRECTORY ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig OUTPUT_VARIABLE
           RIVID_PC_PREFIX)
set(RIVID_PC_REQUIRES_PRIVATE "")
set(RIVID_PC_LIBS_PRIVATE "")
if(NOT BUILD_SHARED_LIBS)
  set(RIVID_PC_REQUIRES_PRIVATE "orocos-kdl urdfdom pugixml libmd")
  if(RIVID_NLOPT)
    string(APPEND RIVID_PC_REQUIRES_PRIVATE " nlopt")
  endif()
  # SUNDIALS comes without pkg-config files.
  get_target_property(parts rivid::cvode INTERFACE_LINK_LIBRARIES)
  foreach(part IN LISTS parts)
    get_target_property(configuration ${part} IMPORTED_CONFIGURATIONS)
    list(GET configuration 0 configuration)
    get_target_property(file ${part} IMPORTED_LOCATION_${configuration})
    cmake_path(GET file PARENT_PATH folder)
    cmake_path(GET file FILENAME file)
    if(NOT folder IN_LIST CMAKE_CXX_IMPLICIT_LINK_DIRECTORIES)
      string(APPEND RIVID_PC_LIBS_PRIVATE "-L${folder} ")
    endif()
    string(APPEND RIVID_PC_LIBS_PRIVATE "-l:${file} ")
  endforeach()
  if(RIVID_SUNDIALS_7)
    list(JOIN MPI_CXX_LIBRARIES " " libraries)
    string(APPEND RIVID_PC_LIBS_PRIVATE "${libraries} ")
  endif()
  string(APPEND RIVID_PC_LIBS_PRIVATE "-pthread -lm")
endif()
foreach(file IN ITEMS rivid.pc rivid-headers.pc)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/${file}.in ${PROJECT_BINARY_DIR}/${file} @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${file} DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()

# Robots to try the tools on; the first is that of the demo.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/data/scara ${PROJECT_SOURCE_DIR}/data/six_axis
        DESTINATION ${CMAKE_INSTALL_DATADIR}/rivid PATTERN made EXCLUDE)
# Tools of ROS know an installed package by this file.
install(FILES ${PROJECT_SOURCE_DIR}/package.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/rivid)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md
        DESTINATION ${CMAKE_INSTALL_DOCDIR})
# What is compiled or linked into the library and the tools asks for its licence beside the binaries.
foreach(part IN ITEMS SUNDIALS toml++ nlohmann-json CLI11)
  install(
    FILES ${PROJECT_SOURCE_DIR}/third_party/notices/${part}
    DESTINATION ${CMAKE_INSTALL_DOCDIR}
    RENAME LICENSE.${part})
endforeach()
# What is in the package, for tools that look for known faults: SPDX 2.3.
foreach(part IN ITEMS CLI11 nlohmann_json tomlplusplus urdfdom)
  find_package(${part} QUIET)
endforeach()
foreach(part IN ITEMS SUNDIALS tomlplusplus nlohmann_json CLI11 Eigen3 orocos_kdl urdfdom pugixml NLopt)
  if(NOT ${part}_VERSION)
    set(${part}_VERSION NOASSERTION)
  endif()
endforeach()
set(RIVID_SPDX_CREATED 1970-01-01T00:00:00Z)
if(DEFINED ENV{SOURCE_DATE_EPOCH})
  string(TIMESTAMP RIVID_SPDX_CREATED "%Y-%m-%dT%H:%M:%SZ" UTC)
endif()
configure_file(${CMAKE_CURRENT_LIST_DIR}/rivid.spdx.in ${PROJECT_BINARY_DIR}/rivid.spdx @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/rivid.spdx DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs FILES_MATCHING PATTERN "*.md" PATTERN "*.png" PATTERN site EXCLUDE PATTERN paper EXCLUDE)
