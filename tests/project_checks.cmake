# Tests of the project itself: its layers, its headers, its format, and the package that users install.

# A test that is a CMake script: rivid_script_test(NAME SCRIPT LABEL -DVARIABLE=value…)
function(rivid_script_test name script label)
  add_test(NAME ${name} COMMAND ${CMAKE_COMMAND} ${ARGN} -P ${script})
  # A script that cannot check anything says "skipped: why", and ctest shows it.
  set_tests_properties(${name} PROPERTIES LABELS ${label} SKIP_REGULAR_EXPRESSION "skipped: ")
endfunction()

rivid_script_test(layering ${PROJECT_SOURCE_DIR}/cmake/check_layering.cmake unit -DSOURCE_DIR=${PROJECT_SOURCE_DIR})
rivid_script_test(
  layering_finds_violations ${CMAKE_CURRENT_SOURCE_DIR}/layering/violations.cmake unit
  -DCHECK=${PROJECT_SOURCE_DIR}/cmake/check_layering.cmake -DWORK_DIR=${CMAKE_CURRENT_BINARY_DIR}/layering)

rivid_script_test(machines ${CMAKE_CURRENT_SOURCE_DIR}/install/machines.cmake unit -DCHECK=${PROJECT_SOURCE_DIR}/cmake/RividMachine.cmake)
rivid_script_test(public_face ${PROJECT_SOURCE_DIR}/cmake/check_public_face.cmake unit
                  -DINCLUDE_DIR=${PROJECT_SOURCE_DIR}/include)

rivid_script_test(
  experiment_page ${PROJECT_SOURCE_DIR}/cmake/check_experiment_page.cmake unit
  -DREADERS=${PROJECT_SOURCE_DIR}/src/experiment -DDOCS=${PROJECT_SOURCE_DIR}/docs)
rivid_script_test(equations ${PROJECT_SOURCE_DIR}/cmake/check_equations.cmake unit -DSOURCE_DIR=${PROJECT_SOURCE_DIR})
rivid_script_test(named_tests ${PROJECT_SOURCE_DIR}/cmake/check_named_tests.cmake unit -DSOURCE_DIR=${PROJECT_SOURCE_DIR})
if(RIVID_BUILD_APPS)
  rivid_script_test(
    readme ${PROJECT_SOURCE_DIR}/cmake/check_readme.cmake unit -DSOURCE_DIR=${PROJECT_SOURCE_DIR}
    -DPROGRAM=${PROJECT_BINARY_DIR}/apps/rivid_identify -DOUTPUT=${CMAKE_CURRENT_BINARY_DIR}/readme)
  if(RIVID_SIMULATORS_PYTHON)
    add_test(NAME first_steps COMMAND ${RIVID_SIMULATORS_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/docs/transcript.py
                                      ${PROJECT_SOURCE_DIR}/docs/first_steps.md $<TARGET_FILE_DIR:rivid_program>)
    set_tests_properties(first_steps PROPERTIES LABELS cli)
  endif()
  rivid_script_test(
    guide ${PROJECT_SOURCE_DIR}/cmake/check_guide.cmake real -DSOURCE_DIR=${PROJECT_SOURCE_DIR}
    -DPROGRAM=$<TARGET_FILE:rivid_program> -DDATA=${RIVID_REAL_DATA}
    -DC_COMPILER=$<$<BOOL:${RIVID_C_COMPILER}>:${RIVID_C_COMPILER}> -DOUTPUT=${CMAKE_CURRENT_BINARY_DIR}/guide)
endif()

# A controller with rivid::runtime: small, and no shared library but those of the compiler.
find_program(RIVID_READELF readelf DOC "readelf, for the test of rivid::runtime")
mark_as_advanced(RIVID_READELF)
if(RIVID_READELF AND NOT CMAKE_BUILD_TYPE STREQUAL "Debug" AND NOT CMAKE_CXX_FLAGS MATCHES "sanitize|coverage")
  add_executable(runtime_consumer install/runtime_consumer.cpp)
  target_link_libraries(runtime_consumer PRIVATE rivid::runtime)
  target_link_options(runtime_consumer PRIVATE LINKER:-s)
  rivid_developer_flags(runtime_consumer)
  rivid_script_test(runtime ${CMAKE_CURRENT_SOURCE_DIR}/install/check_runtime.cmake package
                    -DPROGRAM=$<TARGET_FILE:runtime_consumer> -DREADELF=${RIVID_READELF})
endif()

# For aarch64.sh.
add_executable(machine_figures EXCLUDE_FROM_ALL install/machine_figures.cpp)
target_link_libraries(machine_figures PRIVATE rivid::rivid)
rivid_developer_flags(machine_figures)

rivid_script_test(
  version ${PROJECT_SOURCE_DIR}/cmake/check_version.cmake unit -DSOURCE_DIR=${PROJECT_SOURCE_DIR}
  -DVERSION=${PROJECT_VERSION})
if(TARGET doxygen)
  add_test(NAME doxygen COMMAND ${RIVID_DOXYGEN} ${PROJECT_BINARY_DIR}/Doxyfile)
  set_tests_properties(doxygen PROPERTIES LABELS package)
endif()
# The documentation: its figures are drawn, with fewer simulations, and the site is built with them, links
# checked.
if(RIVID_DOCS_ABSENT)
  add_test(NAME docs COMMAND ${CMAKE_COMMAND} -E echo "skipped: ${RIVID_DOCS_ABSENT}")
  set_tests_properties(docs PROPERTIES LABELS docs SKIP_REGULAR_EXPRESSION "^skipped")
else()
  set(figures ${CMAKE_CURRENT_BINARY_DIR}/docs/figures)
  add_test(NAME docs_figures COMMAND ${RIVID_DOCS_FIGURES} --quick --out ${figures})
  add_test(NAME docs_site COMMAND ${RIVID_DOCS_SITE} --figures ${figures})
  set_tests_properties(docs_figures PROPERTIES FIXTURES_SETUP docs_figures)
  set_tests_properties(docs_site PROPERTIES FIXTURES_REQUIRED docs_figures FIXTURES_SETUP docs_site)
  if(RIVID_CHROMIUM)
    add_test(NAME docs_site_on_disk COMMAND ${RIVID_DOCS_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/docs/site.py
                                            ${PROJECT_BINARY_DIR}/docs_site ${RIVID_CHROMIUM})
    set_tests_properties(docs_site_on_disk PROPERTIES LABELS "docs;page" FIXTURES_REQUIRED docs_site
                                                      SKIP_REGULAR_EXPRESSION "skipped: ")
  endif()
  if(TARGET doxygen)
    set_tests_properties(doxygen PROPERTIES FIXTURES_SETUP docs_figures)
  endif()
  set_tests_properties(docs_figures docs_site PROPERTIES LABELS docs)
endif()
if(TARGET tool_pages)
  find_program(RIVID_BASH bash DOC "bash, for the test of its completions")
  find_program(RIVID_ZSH zsh DOC "zsh, for the test of its completions")
  mark_as_advanced(RIVID_BASH RIVID_ZSH)
  foreach(tool IN ITEMS rivid rivid_excite rivid_identify rivid_montecarlo rivid_online rivid_simulate)
    set(pages ${PROJECT_BINARY_DIR}/apps)
    rivid_script_test(man_page_of_${tool} ${PROJECT_SOURCE_DIR}/cmake/tool_pages/check_man_page.cmake cli
                      -DPROGRAM=${pages}/${tool} -DPAGE=${pages}/${tool}.1)
    if(RIVID_BASH)
      add_test(NAME bash_completes_${tool} COMMAND ${RIVID_BASH} ${CMAKE_CURRENT_SOURCE_DIR}/completion/bash.sh
                                                   ${pages}/${tool} ${pages}/completions/${tool})
      set_tests_properties(bash_completes_${tool} PROPERTIES LABELS cli)
    endif()
    if(RIVID_ZSH)
      add_test(NAME zsh_completes_${tool} COMMAND ${RIVID_ZSH} -f ${CMAKE_CURRENT_SOURCE_DIR}/completion/zsh.zsh
                                                  ${pages}/${tool} ${pages}/completions/_${tool})
      set_tests_properties(zsh_completes_${tool} PROPERTIES LABELS cli SKIP_REGULAR_EXPRESSION "skipped: ")
    endif()
  endforeach()
endif()

if(RIVID_BUILD_APPS AND RIVID_HARDEN AND NOT RIVID_SANITIZE AND CMAKE_READELF)
  rivid_script_test(hardening_of_rivid ${PROJECT_SOURCE_DIR}/cmake/check_hardening.cmake package
                    -DREADELF=${CMAKE_READELF} -DOBJDUMP=${CMAKE_OBJDUMP} -DPROGRAM=$<TARGET_FILE:rivid_program>)
  if(TARGET _rivid)
    rivid_script_test(hardening_of_the_python_package ${PROJECT_SOURCE_DIR}/cmake/check_hardening.cmake package
                      -DREADELF=${CMAKE_READELF} -DOBJDUMP=${CMAKE_OBJDUMP} -DPROGRAM=$<TARGET_FILE:_rivid>)
  endif()
endif()

rivid_script_test(format ${PROJECT_SOURCE_DIR}/cmake/check_format.cmake format -DSOURCE_DIR=${PROJECT_SOURCE_DIR})

add_test(NAME headers_stand_alone COMMAND ${CMAKE_COMMAND} --build ${PROJECT_BINARY_DIR} --config $<CONFIG> --target
                                          all_verify_interface_header_sets)
set_tests_properties(headers_stand_alone PROPERTIES LABELS "package;slow" RESOURCE_LOCK build_tree)

# A few objects of the package; with -DWHOLE=ON the script builds and compares the package.
rivid_script_test(reproducible ${CMAKE_CURRENT_SOURCE_DIR}/install/reproducible.cmake reproducible
                  -DSOURCE_DIR=${PROJECT_SOURCE_DIR} -DWORK_DIR=${CMAKE_CURRENT_BINARY_DIR}/reproducible)

if(RIVID_INSTALL)
  include(install/consumer_tests.cmake)
endif()
