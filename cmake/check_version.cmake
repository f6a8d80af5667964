# cmake -DSOURCE_DIR=… -DVERSION=<project version> -P check_version.cmake
#
# The version of the project, of CITATION.cff and of the newest section of CHANGELOG.md are one, and so is
# what README.md calls the package.

cmake_minimum_required(VERSION 3.25)

file(READ ${SOURCE_DIR}/CITATION.cff citation)
if(NOT citation MATCHES "\nversion: ([0-9.]+)\n" OR NOT CMAKE_MATCH_1 STREQUAL VERSION)
  message(FATAL_ERROR "CITATION.cff has version ${CMAKE_MATCH_1}, the project ${VERSION}")
endif()

file(READ ${SOURCE_DIR}/CHANGELOG.md changes)
string(REGEX REPLACE "\n## \\[Unreleased\\][^\n]*\n" "\n" changes "${changes}")
if(NOT changes MATCHES "\n## \\[([0-9.]+)\\] - (unreleased|20[0-9][0-9]-[01][0-9]-[0-3][0-9])\n")
  message(FATAL_ERROR "CHANGELOG.md has no section ## [x.y.z] - date, nor - unreleased")
endif()
# A greedy match of the rest of the page would give the oldest.
string(REGEX MATCH "\n## \\[[0-9.]+\\]" newest "${changes}")
if(NOT newest STREQUAL "\n## [${VERSION}]")
  message(FATAL_ERROR "the newest version of CHANGELOG.md is${newest}, that of the project ${VERSION}")
endif()

file(READ ${SOURCE_DIR}/README.md readme)
string(REGEX MATCHALL "rivid_[0-9][0-9.]*_amd64" packages "${readme}")
foreach(package IN LISTS packages)
  if(NOT package STREQUAL "rivid_${VERSION}_amd64")
    message(FATAL_ERROR "README.md names ${package}.deb, the project has version ${VERSION}")
  endif()
endforeach()
message(STATUS "check_version: ${VERSION} everywhere")
