# An overlay port: the sources are those around it.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS -DCMAKE_UNITY_BUILD=ON -DRIVID_BUILD_TESTS=OFF -DRIVID_BUILD_EXAMPLES=OFF -DRIVID_BUILD_BENCHMARKS=OFF
  OPTIONS_DEBUG -DRIVID_BUILD_APPS=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/rivid)
vcpkg_fixup_pkgconfig()
vcpkg_copy_tools(TOOL_NAMES rivid AUTO_CLEAN)
file(GLOB links "${CURRENT_PACKAGES_DIR}/bin/rivid_*")
if(links)
  file(REMOVE ${links})
endif()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
