# caltwin_layer(NAME DIR folder USES layers NEEDS libraries)
#
# One layer is one library of all sources in its folder (a folder that is itself a layer
# excepted), and USES is the whole of what it may include: the layers below it. A layer
# that reaches upwards fails to link, or fails layers_test where the leak is header-only.
function(caltwin_layer name)
  cmake_parse_arguments(ARG "" "DIR" "USES;NEEDS" ${ARGN})
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
    target_compile_options(caltwin_${name} PRIVATE
      -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
      $<$<BOOL:${CALTWIN_WERROR}>:-Werror>)
    target_compile_definitions(caltwin_${name} PRIVATE
      CALTWIN_SOURCE_DIR="${PROJECT_SOURCE_DIR}" CALTWIN_VERSION="${PROJECT_VERSION}"
      $<$<BOOL:${CALTWIN_MUTANTS}>:CALTWIN_MUTANTS>)
  else()
    add_library(caltwin_${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  target_include_directories(caltwin_${name} ${scope} ${PROJECT_SOURCE_DIR})
  target_link_libraries(caltwin_${name} ${scope} ${ARG_USES} ${ARG_NEEDS})
endfunction()

# caltwin_test(NAME [LABEL label] USES layers): tests/NAME_test.cc as one program of
# GoogleTest cases. Label `unit` (the default: each case under 0.1 s), `slow`, `physics`.
function(caltwin_test name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT" "USES;NEEDS" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 60)
  endif()
  string(REPLACE "/" "_" target ${name})
  list(TRANSFORM ARG_USES PREPEND caltwin_)
  add_executable(${target}_test ${PROJECT_SOURCE_DIR}/tests/${name}_test.cc)
  target_link_libraries(${target}_test PRIVATE ${ARG_USES} ${ARG_NEEDS} GTest::gtest GTest::gmock GTest::gtest_main)
  target_compile_options(${target}_test PRIVATE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
    $<$<BOOL:${CALTWIN_WERROR}>:-Werror>)
  target_compile_definitions(${target}_test PRIVATE CALTWIN_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
    $<$<BOOL:${CALTWIN_MUTANTS}>:CALTWIN_MUTANTS>)
  gtest_discover_tests(${target}_test NO_PRETTY_VALUES DISCOVERY_TIMEOUT 60
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
    PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT})
endfunction()
