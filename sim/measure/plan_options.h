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

// What every campaign has.
inline constexpr PlanOption kName = {
    .name = "name",
    .type = kText,
    .otherwise = "''",
    .doc = "Name in the rows; else the kind, numbered from the second on."};
inline constexpr PlanOption kInstrument = {
    .name = "instrument",
    .type = kText,
    .otherwise = "''",
    .doc = "Id in `instruments` of what reads; else the kind's usual one."};
inline constexpr PlanOption kPause = {.name = "pause_s",
                                      .otherwise = "60",
                                      .doc = "Time before it begins [s]: setting up.",
                                      .bounds = {0, 1e6}};
inline constexpr PlanOption kAxis = {.name = "axis",
                                     .type = kWord,
                                     .otherwise = "x",
                                     .doc = "The axis that moves.",
                                     .words = kAxisWords};
inline constexpr PlanOption kRepeats = {.name = "repeats",
                                        .type = kCount,
                                        .otherwise = "2",
                                        .doc = "How often each point is read.",
                                        .bounds = {1, 1000}};
inline constexpr PlanOption kDwell = {.name = "dwell_s",
                                      .otherwise = "2",
                                      .doc = "Standstill before a reading [s].",
                                      .bounds = {0, 1e5}};
inline constexpr PlanOption kMargin = {
    .name = "margin_mm",
    .otherwise = "8",
    .doc = "Left free at both ends of the travel [mm].",
    .bounds = {0, 1e4}};
inline constexpr PlanOption kFeeds = {
    .name = "feeds_mm_s",
    .type = kNumbers,
    .otherwise = "[1]",
    .doc =
        "Feeds of the touch that counts [mm/s]; three "
        "show a trigger latency.",
    .bounds = {0.01, 50}};
inline constexpr PlanOption kAt = {.name = "at_mm",
                                   .type = kNumbers,
                                   .otherwise = "[]",
                                   .doc =
                                       "Where [x, y] (a block's base) or [x, y, z] (a "
                                       "line); empty: the middle of the travel [mm].",
                                   .bounds = {-1e5, 1e5}};
inline constexpr PlanOption kRegular = {
    .name = "regular",
    .type = kFlag,
    .otherwise = "false",
    .doc =
        "Equal spacing; else each target is moved by chance, so that no screw, "
        "pulley or motor wave can hide in the spacing."};
inline constexpr PlanOption kPositions = {.name = "positions",
                                          .type = kCount,
                                          .otherwise = "21",
                                          .doc = "Targets along the axis.",
                                          .bounds = {2, 10'000}};
inline constexpr PlanOption kSpindle = {
    .name = "spindle_deg",
    .type = kNumbers,
    .otherwise = "[0]",
    .doc =
        "Spindle orientations, counter-clockwise from "
        "above [deg]; four show a tip's run-out, "
        "several its lobes.",
    .bounds = {-360, 360}};
inline constexpr PlanOption kArtefact = {
    .name = "artefact",
    .type = kText,
    .otherwise = "''",
    .doc = "Id of what is touched; else the usual one."};

}  // namespace caltwin::plan_options
