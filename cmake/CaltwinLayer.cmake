# caltwin_layer(NAME DIR folder [ONCE] USES layers NEEDS libraries)
#
# One layer is one library of all sources in its folder (a folder that is itself a layer
# excepted), and USES is the whole of what it may include: the layers below it. A layer
# that reaches upwards fails to link, or fails layers_test where the leak is header-only.
# ONCE: what reads, writes and directs runs once a run; at -O3 it costs seconds a file.
function(caltwin_layer name)
  cmake_parse_arguments(ARG "ONCE" "DIR" "USES;NEEDS" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/${ARG_DIR}/*.cc")
  list(FILTER sources EXCLUDE REGEX "_main\\.cc$")
  foreach(inner sim/effects/acts calibration/diagnosis)
    if(NOT ARG_DIR STREQUAL inner)
      list(FILTER sources EXCLUDE REGEX "/${inner}/")
    endif()
  endforeach()
  list(TRANSFORM ARG_USES PREPEND caltwin_)
  if(sources)
    add_library(caltwin_${name} STATIC ${sources})
    set(scope PUBLIC)
    target_compile_options(caltwin_${name} PRIVATE ${caltwin_warnings})
    target_compile_definitions(caltwin_${name} PRIVATE
      CALTWIN_SOURCE_DIR="${PROJECT_SOURCE_DIR}" CALTWIN_VERSION="${PROJECT_VERSION}"
      $<$<BOOL:${CALTWIN_MUTANTS}>:CALTWIN_MUTANTS>)
    if(ARG_ONCE)
      target_compile_options(caltwin_${name} PRIVATE ${caltwin_optimise_once})
      caltwin_precompile(caltwin_${name} once)
    else()
      caltwin_precompile(caltwin_${name} layers)
    endif()
    caltwin_unity(caltwin_${name})
  else()
    add_library(caltwin_${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  target_include_directories(caltwin_${name} ${scope} ${PROJECT_SOURCE_DIR})
  target_link_libraries(caltwin_${name} ${scope} ${ARG_USES} ${ARG_NEEDS})
endfunction()
