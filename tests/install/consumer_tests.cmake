# rivid as its users meet it: installed, moved elsewhere, found by find_package.

set(prefix ${CMAKE_CURRENT_BINARY_DIR}/install/moved)
rivid_script_test(
  install_to_a_moved_prefix ${CMAKE_CURRENT_LIST_DIR}/install_and_move.cmake package
  -DBUILD_DIR=${PROJECT_BINARY_DIR} -DSOURCE_DIR=${PROJECT_SOURCE_DIR} -DCONFIG=$<CONFIG>
  -DSTAGING=${CMAKE_CURRENT_BINARY_DIR}/install/staging -DPREFIX=${prefix})
set_tests_properties(install_to_a_moved_prefix PROPERTIES FIXTURES_SETUP moved_prefix RESOURCE_LOCK build_tree)

# rivid_consumer_test(NAME PROJECT FLAGS -DRUN_SAYS=… | -DLINK_SAYS=…): builds PROJECT with FLAGS; RUN_SAYS is
# what the program must print, LINK_SAYS what the linker must say when it refuses.
function(rivid_consumer_test name project flags)
  string(PREPEND flags "${CMAKE_CXX_FLAGS} ")
  if(RIVID_SANITIZE)
    string(APPEND flags " -fsanitize=address,undefined")
  endif()
  rivid_script_test(
    ${name} ${PROJECT_SOURCE_DIR}/tests/install/build_consumer.cmake package
    -DCONSUMER=${PROJECT_SOURCE_DIR}/tests/install/${project}
    -DWORK_DIR=${CMAKE_CURRENT_BINARY_DIR}/install/${name}
    -DPREFIX=${prefix} -DGENERATOR=${CMAKE_GENERATOR} -DCOMPILER=${CMAKE_CXX_COMPILER} "-DFLAGS=${flags}" ${ARGN})
  set_tests_properties(${name} PROPERTIES FIXTURES_REQUIRED moved_prefix)
endfunction()

rivid_consumer_test(consumer_project consumer "" "-DRUN_SAYS=rivid [0-9.]+: 13 base parameters of 28 standard ones")
rivid_consumer_test(consumer_of_the_headers headers_consumer ""
                    "-DRUN_SAYS=rivid [0-9.]+: 13 base parameters of 2 joints, dynamics agree")
# A crash at run time otherwise: see include/rivid/types.hpp. The program is linked, never run.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64" AND NOT CMAKE_CXX_FLAGS MATCHES "-m(arch|avx)")
  rivid_consumer_test(consumer_with_other_simd_flags consumer "-mavx2"
                      -DLINK_SAYS=caller_and_librivid_must_use_the_same_simd_flags)
endif()

# So does the allocator of Eigen, which is another one under AddressSanitizer, unless the program says
# otherwise.
if(NOT RIVID_SANITIZE AND NOT CMAKE_CXX_FLAGS MATCHES "-fsanitize|EIGEN_MALLOC")
  rivid_consumer_test(consumer_under_address_sanitizer consumer "-fsanitize=address"
                      -DLINK_SAYS=caller_and_librivid_must_use_the_same_simd_flags_and_EIGEN_MALLOC_ALREADY_ALIGNED)
  rivid_consumer_test(consumer_with_malloc_under_address_sanitizer consumer
                      "-fsanitize=address -DEIGEN_MALLOC_ALREADY_ALIGNED=1"
                      "-DRUN_SAYS=rivid [0-9.]+: 13 base parameters of 28 standard ones")
endif()

find_program(RIVID_PKG_CONFIG NAMES pkg-config pkgconf DOC "pkg-config, for a test")
mark_as_advanced(RIVID_PKG_CONFIG)
set(linkage --static)
if(BUILD_SHARED_LIBS)
  set(linkage --shared)
endif()
set(flags "${CMAKE_CXX_FLAGS}")
if(RIVID_SANITIZE)
  string(APPEND flags " -fsanitize=address,undefined")
endif()
rivid_script_test(
  consumer_by_pkg_config ${CMAKE_CURRENT_LIST_DIR}/build_with_pkg_config.cmake package
  -DPKG_CONFIG=${RIVID_PKG_CONFIG} -DCONSUMER=${CMAKE_CURRENT_LIST_DIR}/consumer
  -DWORK_DIR=${CMAKE_CURRENT_BINARY_DIR}/install/consumer_by_pkg_config -DPREFIX=${prefix}
  -DCOMPILER=${CMAKE_CXX_COMPILER} "-DFLAGS=${flags}" -DLINKAGE=${linkage} -DVERSION=${PROJECT_VERSION}
  "-DRUN_SAYS=rivid ${PROJECT_VERSION}: 13 base parameters of 28 standard ones")
set_tests_properties(consumer_by_pkg_config PROPERTIES FIXTURES_REQUIRED moved_prefix)
