# rivid::headers: what a controller needs, for who links nothing but Eigen. These headers define all that they
# declare, and include each other alone, as cmake/check_layering.cmake checks; rivid::rivid has what they
# define in its archive.
set(rivid_header_names
    error
    fields
    finding
    model/chain
    model/kinds
    model/linkage
    model/mdh
    model/parameters
    model/robot
    model/robot_inline
    online/contact_observer
    online/friction_monitor
    online/information_triangle
    online/row_triangle
    online/model
    online/momentum
    online/payload_estimator
    online/plausible
    online/recursive_identifier
    online/robot_state
    online/row_noise
    online/row_stream
    online/saved_state
    online/tick_gate
    regressor/base
    regressor/base_inline
    regressor/kernel
    regressor/pack
    regressor/regressor
    regressor/vec3
    simulate/control
    simulate/control_laws
    simulate/design_inertia
    simulate/dynamic_model
    simulate/dynamic_model_inline
    simulate/dynamics
    simulate/dynamics_kernel
    simulate/inverse_dynamics
    text
    types)
list(TRANSFORM rivid_header_names REPLACE "(.+)" "${CMAKE_CURRENT_LIST_DIR}/../include/rivid/\\1.hpp" OUTPUT_VARIABLE
                                                                                              RIVID_HEADERS)
list(TRANSFORM RIVID_HEADERS REPLACE "/cmake/\\.\\./" "/")
if(CMAKE_SCRIPT_MODE_FILE)
  return()
endif()

add_library(rivid_headers INTERFACE)
add_library(rivid::headers ALIAS rivid_headers)
set_target_properties(rivid_headers PROPERTIES EXPORT_NAME headers VERIFY_INTERFACE_HEADER_SETS ON)
target_sources(
  rivid_headers
  INTERFACE FILE_SET
            HEADERS
            BASE_DIRS
            ${PROJECT_SOURCE_DIR}/include
            FILES
            ${RIVID_HEADERS})
target_compile_features(rivid_headers INTERFACE cxx_std_20)
target_link_libraries(rivid_headers INTERFACE Eigen3::Eigen)
