# Every package that rivid needs, found once for the build and once more by the installed package
# (rividConfig.cmake includes this file), so that the two can not drift apart.
#
#   Eigen       public: matrices are part of the interface
#   KDL         public for who includes rivid/model/kdl.hpp; LGPL, linked dynamically
#   urdfdom     private: reads URDF
#   pugixml     private: checks a URDF with line numbers before urdfdom sees it, since urdfdom takes many faults for
#               zeros; a user of a static librivid links it too, so the installed package looks for it
# Header-only, and needed to build rivid but never to use it, hence absent from the installed package:
#   toml++, nlohmann-json, CLI11

include(CMakeFindDependencyMacro)

find_dependency(Eigen3 3.4)
find_dependency(urdfdom)
find_dependency(orocos_kdl)
find_dependency(pugixml)

# The config file of orocos_kdl 1.5 only names its library and include folder.
if(NOT TARGET rivid_orocos_kdl)
  add_library(rivid_orocos_kdl INTERFACE IMPORTED)
  target_link_libraries(rivid_orocos_kdl INTERFACE ${orocos_kdl_LIBRARIES} Eigen3::Eigen)
  target_include_directories(rivid_orocos_kdl SYSTEM INTERFACE ${orocos_kdl_INCLUDE_DIRS})
endif()
