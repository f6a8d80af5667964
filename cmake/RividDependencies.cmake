# Every package that rivid needs, found once for the build and once more by the installed package
# (rividConfig.cmake includes this file), so that the two can not drift apart.
#
#   Eigen       public: matrices are part of the interface
#   KDL         public for who includes rivid/model/kdl.hpp; LGPL, linked dynamically
#   urdfdom     private: reads URDF
#   pugixml     private: checks a URDF with line numbers before urdfdom sees it, since urdfdom takes many faults for
#               zeros
#   SUNDIALS    private: CVODE integrates the closed loop
#   Threads     private: batches of samples on several cores
#   NLopt       private: designs excitations by its method of moving asymptotes, MIT; without it RIVID_NLOPT is off
#   libmd       private: SHA-256 of the input files, for the provenance of a result
#
# A user of the static library links the private ones too, so the installed package looks for them. A user of
# the shared one does not: RIVID_PUBLIC_DEPENDENCIES_ONLY is set then. Header-only libraries that are needed
# to build rivid but never to use it (toml++, nlohmann-json, CLI11) are found where they are used and linked
# as $<BUILD_INTERFACE:…>, so that the installed package does not ask for them.

include(CMakeFindDependencyMacro)

find_dependency(Eigen3 3.4)
if(RIVID_PUBLIC_DEPENDENCIES_ONLY)
  find_package(orocos_kdl QUIET)
else()
  find_dependency(urdfdom)
  find_dependency(orocos_kdl)
  find_dependency(pugixml)
  find_dependency(Threads)
  # SUNDIALS 7 as Debian 13 has it links MPI::MPI_C without looking for it, and a project in C++ alone could
  # not.
  find_file(RIVID_SUNDIALS_7 sundials/sundials_core.hpp)
  mark_as_advanced(RIVID_SUNDIALS_7)
  if(RIVID_SUNDIALS_7 AND NOT TARGET MPI::MPI_C)
    find_package(MPI QUIET COMPONENTS CXX)
    if(MPI_CXX_FOUND)
      add_library(MPI::MPI_C INTERFACE IMPORTED)
      target_link_libraries(MPI::MPI_C INTERFACE MPI::MPI_CXX)
    endif()
  endif()
  # Other SUNDIALS ask for OpenMP, which no part that rivid links uses and clang may be without.
  if(NOT RIVID_SUNDIALS_7 AND NOT TARGET OpenMP::OpenMP_C)
    find_package(OpenMP QUIET)
    if(NOT OpenMP_FOUND)
      add_library(OpenMP::OpenMP_C INTERFACE IMPORTED)
    endif()
  endif()
  find_dependency(SUNDIALS COMPONENTS cvode nvecserial sunmatrixdense sunlinsoldense)
  # Archives of SUNDIALS 7 ask for its shared libraries, which load MPI.
  if(RIVID_SUNDIALS_7 AND TARGET SUNDIALS::core_static)
    foreach(part IN ITEMS cvode nvecserial sunmatrixdense sunlinsoldense)
      set_target_properties(SUNDIALS::${part}_static PROPERTIES INTERFACE_LINK_LIBRARIES SUNDIALS::core_static)
    endforeach()
  endif()
endif()

# The config file of orocos_kdl 1.5 only names its library and include folder.
if(orocos_kdl_FOUND AND NOT TARGET rivid::orocos_kdl)
  add_library(rivid::orocos_kdl INTERFACE IMPORTED)
  target_link_libraries(rivid::orocos_kdl INTERFACE ${orocos_kdl_LIBRARIES} Eigen3::Eigen)
  target_include_directories(rivid::orocos_kdl SYSTEM INTERFACE ${orocos_kdl_INCLUDE_DIRS})
endif()

if(RIVID_PUBLIC_DEPENDENCIES_ONLY)
  return()
endif()

# libmd comes with a pkg-config file alone.
if(NOT TARGET rivid::libmd)
  find_library(RIVID_LIBMD md REQUIRED)
  find_path(RIVID_LIBMD_INCLUDE_DIR sha2.h REQUIRED)
  mark_as_advanced(RIVID_LIBMD RIVID_LIBMD_INCLUDE_DIR)
  add_library(rivid::libmd INTERFACE IMPORTED)
  target_link_libraries(rivid::libmd INTERFACE ${RIVID_LIBMD})
  target_include_directories(rivid::libmd SYSTEM INTERFACE ${RIVID_LIBMD_INCLUDE_DIR})
endif()

# The static archives where there are any: the shared sunlinsoldense of Debian drags PETSc and a hundred
# packages into whatever links it. SUNDIALS 7 has its common parts in `core`.
if(NOT TARGET rivid::cvode)
  add_library(rivid::cvode INTERFACE IMPORTED)
  foreach(part IN ITEMS cvode nvecserial sunmatrixdense sunlinsoldense core)
    foreach(kind IN ITEMS static shared)
      if(TARGET SUNDIALS::${part}_${kind})
        target_link_libraries(rivid::cvode INTERFACE SUNDIALS::${part}_${kind})
        break()
      endif()
    endforeach()
  endforeach()
endif()

# Debian has the library in C and in C++, each with a config file of the same name; either will do.
if(RIVID_NLOPT AND NOT TARGET rivid::nlopt)
  find_dependency(NLopt)
  add_library(rivid::nlopt INTERFACE IMPORTED)
  target_link_libraries(rivid::nlopt INTERFACE ${NLOPT_LIBRARIES})
  target_include_directories(rivid::nlopt SYSTEM INTERFACE ${NLOPT_INCLUDE_DIRS})
endif()
