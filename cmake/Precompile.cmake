# Half of a compilation is reading headers. The two lists below are read once for each kind
# of target and reused by all of that kind, which halves a build from nothing.
#
# A header of the second list that changes has everything compiled again: with
# -DCALTWIN_PCH=OFF only what includes it. A file must not compile only because of them:
# tools/lint.sh, which does without, sees to it.
option(CALTWIN_PCH "Precompile the headers that most files include" ON)
# g++ 12, once they are precompiled: more of the false alarms of GCC bug 105651.
if(CALTWIN_PCH AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options(-Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread)
endif()

if(CALTWIN_PCH AND CMAKE_CXX_COMPILER_LAUNCHER MATCHES "ccache$")
  # Else ccache does not keep what was compiled with a precompiled header.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
    CCACHE_SLOPPINESS=pch_defines,time_macros ${CMAKE_CXX_COMPILER_LAUNCHER})
  add_compile_options($<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
endif()

set(caltwin_precompiled_libraries
  <algorithm> <array> <charconv> <chrono> <cmath> <cstdint> <filesystem> <functional>
  <limits> <map> <memory> <numbers> <optional> <set> <span> <string> <string_view>
  <utility> <variant> <vector> <Eigen/Dense> <fmt/format.h> <fmt/ranges.h>
  <nlohmann/json.hpp> <yaml-cpp/yaml.h>)
set(caltwin_precompiled_own
  calibration/diagnosis/candidates.h calibration/diagnosis/evidence.h
  calibration/estimate/observability.h calibration/procedures/catalog.h
  sim/kinds/delta/effects.h scenarios/result.h sim/machine/screw_levelling.h
  sim/measure/plan.h sim/measure/rows.h sim/twin/twin.h)
list(TRANSFORM caltwin_precompiled_own PREPEND "${PROJECT_SOURCE_DIR}/")

# caltwin_precompile(TARGET KIND): reuses the headers of its kind, which is `layers`,
# `once` (layers that are compiled with -O1), `readers` (those that are fuzzed) or `tests`.
function(caltwin_precompile target kind)
  if(NOT CALTWIN_PCH)
    return()
  endif()
  set(owner caltwin_precompiled_${kind})
  if(NOT TARGET ${owner})
    set(nothing ${PROJECT_BINARY_DIR}/${owner}.cc)
    file(CONFIGURE OUTPUT ${nothing} CONTENT "")
    add_library(${owner} OBJECT ${nothing})
    target_include_directories(${owner} PRIVATE ${PROJECT_SOURCE_DIR})
    target_link_libraries(${owner} PRIVATE Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json
      tl::expected mujoco::mujoco yaml-cpp "$<$<STREQUAL:${kind},tests>:GTest::gtest;GTest::gmock>")
    target_compile_options(${owner} PRIVATE ${caltwin_warnings}
      $<$<STREQUAL:${kind},once>:${caltwin_optimise_once}>
      $<$<STREQUAL:${kind},tests>:${caltwin_optimise_tests}>
      $<$<STREQUAL:${kind},readers>:${caltwin_optimise_readers}>
      # ccache: what it kept is older than the headers.
      "$<$<CXX_COMPILER_ID:Clang>:SHELL:-Xclang -fno-pch-timestamp>")
    target_precompile_headers(${owner} PRIVATE ${caltwin_precompiled_libraries}
      "$<$<STREQUAL:${kind},tests>:<gmock/gmock.h$<ANGLE-R>;<gtest/gtest.h$<ANGLE-R>>"
      "$<$<STREQUAL:${kind},once>:<CLI/CLI.hpp$<ANGLE-R>>"
      ${caltwin_precompiled_own})
    set_target_properties(${owner} PROPERTIES PCH_INSTANTIATE_TEMPLATES ON)
  endif()
  target_precompile_headers(${target} REUSE_FROM ${owner})
endfunction()
