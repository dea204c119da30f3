#pragma once

#include <array>
#include <string_view>

#include "sim/measure/plan.h"

/// Options that several kinds of campaigns share.
namespace caltwin::plan_options {

using enum OptionType;

inline constexpr std::array<std::string_view, 3> kAxisWords = {"x", "y", "z"};
inline constexpr std::array<std::string_view, 3> kPlaneWords = {"xy", "xz", "yz"};
inline constexpr std::array<std::string_view, 2> kLevelWords = {"x", "y"};

/// @name Options by what they hold; numbers, counts and each of a list within bounds.
constexpr PlanOption Number(std::string_view name,
                            std::string_view otherwise,
                            Bounds bounds,
                            std::string_view doc) {
  return {.name = name, .otherwise = otherwise, .doc = doc, .bounds = bounds};
}
constexpr PlanOption Count(std::string_view name,
                           std::string_view otherwise,
                           Bounds bounds,
                           std::string_view doc) {
  return {.name = name,
          .type = kCount,
          .otherwise = otherwise,
          .doc = doc,
          .bounds = bounds};
}
constexpr PlanOption Numbers(std::string_view name,
                             std::string_view otherwise,
                             Bounds bounds,
                             std::string_view doc) {
  return {.name = name,
          .type = kNumbers,
          .otherwise = otherwise,
          .doc = doc,
          .bounds = bounds};
}
constexpr PlanOption Flag(std::string_view name,
                          std::string_view otherwise,
                          std::string_view doc) {
  return {.name = name, .type = kFlag, .otherwise = otherwise, .doc = doc};
}
constexpr PlanOption Word(std::string_view name,
                          std::string_view otherwise,
                          std::span<const std::string_view> words,
                          std::string_view doc) {
  return {
      .name = name, .type = kWord, .otherwise = otherwise, .doc = doc, .words = words};
}
constexpr PlanOption Text(std::string_view name, std::string_view doc) {
  return {.name = name, .type = kText, .otherwise = "''", .doc = doc};
}

// What every campaign has.
inline constexpr PlanOption kName =
    Text("name", "Name in the rows; else the kind, numbered from the second on.");
inline constexpr PlanOption kInstrument =
    Text("instrument", "Id in `instruments` of what reads; else the kind's usual one.");
inline constexpr PlanOption kPause =
    Number("pause_s", "60", {0, 1e6}, "Time before it begins [s]: setting up.");
inline constexpr PlanOption kAxis =
    Word("axis", "x", kAxisWords, "The axis that moves.");
inline constexpr PlanOption kRepeats =
    Count("repeats", "2", {1, 1000}, "How often each point is read.");
inline constexpr PlanOption kDwell =
    Number("dwell_s", "2", {0, 1e5}, "Standstill before a reading [s].");
inline constexpr PlanOption kMargin =
    Number("margin_mm", "8", {0, 1e4}, "Left free at both ends of the travel [mm].");
inline constexpr PlanOption kFeeds =
    Numbers("feeds_mm_s",
            "[1]",
            {0.01, 50},
            "Feeds of the touch that counts [mm/s]; three "
            "show a trigger latency.");
inline constexpr PlanOption kAt =
    Numbers("at_mm",
            "[]",
            {-1e5, 1e5},
            "Where [x, y] (a block's base) or [x, y, z] (a "
            "line); empty: the middle of the travel [mm].");
inline constexpr PlanOption kRegular =
    Flag("regular",
         "false",
         "Equal spacing; else each target is moved by chance, so that no screw, "
         "pulley or motor wave can hide in the spacing.");
inline constexpr PlanOption kPositions =
    Count("positions", "21", {2, 10'000}, "Targets along the axis.");
inline constexpr PlanOption kSpindle =
    Numbers("spindle_deg",
            "[0]",
            {-360, 360},
            "Spindle orientations, counter-clockwise from "
            "above [deg]; four show a tip's run-out, "
            "several its lobes.");
inline constexpr PlanOption kArtefact =
    Text("artefact", "Id of what is touched; else the usual one.");

}  // namespace caltwin::plan_options
