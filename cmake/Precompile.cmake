# With clang, half of an unoptimised compilation is reading the headers of the standard
# library and of a few large ones. Each of the two lists below is read once and reused by
# every target of its kind: the sanitizers' build costs half. Not with g++ 12: there it
# gains less, and warns of the libraries' own code, once precompiled.
#
# A file must not compile only because of them; the g++ build and tools/lint.sh see to it.
option(CALTWIN_PCH "Precompile the headers of the libraries (clang only)" ON)
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  set(CALTWIN_PCH OFF)
endif()

if(CALTWIN_PCH AND CMAKE_CXX_COMPILER_LAUNCHER MATCHES "ccache$")
  # Else ccache does not keep what was compiled with a precompiled header.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
    CCACHE_SLOPPINESS=pch_defines,time_macros ${CMAKE_CXX_COMPILER_LAUNCHER})
endif()

set(caltwin_precompiled_layers
  <algorithm> <array> <charconv> <chrono> <cmath> <cstdint> <filesystem> <functional>
  <limits> <map> <memory> <numbers> <optional> <set> <span> <string> <string_view>
  <utility> <variant> <vector> <Eigen/Core> <fmt/format.h> <fmt/ranges.h>
  <nlohmann/json.hpp>)
set(caltwin_precompiled_tests ${caltwin_precompiled_layers} <gmock/gmock.h> <gtest/gtest.h>)

# caltwin_precompile(TARGET KIND): reuses the headers of `layers` or `tests`.
function(caltwin_precompile target kind)
  if(NOT CALTWIN_PCH)
    return()
  endif()
  set(owner caltwin_precompiled_${kind})
  if(NOT TARGET ${owner})
    set(nothing ${PROJECT_BINARY_DIR}/${owner}.cc)
    file(CONFIGURE OUTPUT ${nothing} CONTENT "")
    add_library(${owner} OBJECT ${nothing})
    target_link_libraries(${owner} PRIVATE Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json
      "$<$<STREQUAL:${kind},tests>:GTest::gtest;GTest::gmock>")
    target_compile_options(${owner} PRIVATE ${caltwin_warnings}
      "SHELL:-Xclang -fno-pch-timestamp") # ccache: what it kept is older than the headers.
    target_precompile_headers(${owner} PRIVATE ${${owner}})
    set_target_properties(${owner} PROPERTIES PCH_INSTANTIATE_TEMPLATES ON)
  endif()
  target_precompile_headers(${target} REUSE_FROM ${owner})
endfunction()
