# Finds MuJoCo 4 as an unpacked `mujoco-core` wheel or any folder with include/ and the
# library. Looks in -DMUJOCO_ROOT=, then third_party/mujoco (tools/setup.sh puts it there).
# Defines mujoco::mujoco.
if(NOT MUJOCO_ROOT)
  set(MUJOCO_ROOT "${PROJECT_SOURCE_DIR}/third_party/mujoco")
endif()
file(GLOB MUJOCO_LIBRARY "${MUJOCO_ROOT}/libmujoco.so.*" "${MUJOCO_ROOT}/lib/libmujoco.so.*")
list(LENGTH MUJOCO_LIBRARY _mujoco_libraries)
if(_mujoco_libraries GREATER 1)
  list(GET MUJOCO_LIBRARY 0 MUJOCO_LIBRARY)
endif()
find_path(MUJOCO_INCLUDE_DIR mujoco/mujoco.h HINTS "${MUJOCO_ROOT}/include" NO_DEFAULT_PATH)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(
  MuJoCo
  REQUIRED_VARS MUJOCO_LIBRARY MUJOCO_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "run tools/setup.sh once, or give -DMUJOCO_ROOT= the folder of your own MuJoCo 4")
if(MuJoCo_FOUND AND NOT TARGET mujoco::mujoco)
  add_library(mujoco::mujoco SHARED IMPORTED)
  set_target_properties(mujoco::mujoco PROPERTIES IMPORTED_LOCATION "${MUJOCO_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${MUJOCO_INCLUDE_DIR}")
endif()
