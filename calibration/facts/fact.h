#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/measure/data_header.h"
#include "sim/measure/import/import.h"
#include "sim/measure/row.h"

namespace caltwin {

/// A figure of a fact. The key ends in its unit: "gap_um".
struct FactFigure {
  std::string key{};
  double value = 0;
  double sd = kUnknown;  ///< kUnknown: nothing in the rows determines it.
};

/// What measured rows say by themselves, before any model of a machine is fitted: a
/// scatter, a drift, a twist, a ratio. People have 3 to 30 numbers; these need no more.
struct Fact {
  /// repeatability drift homing_scatter jump outliers plane twist form reversal
  /// cross_reversal scale known_ratio turn skew latency levelling offset contradiction
  /// agreement temperature settings wave stretch map_change tower_heights one_size
  /// constant ratio steps
  std::string id{};
  std::string axis{};  ///< x y z or ISO 230-1 ("C0Y"); empty where there is none.
  /// A further word: of known_ratio what it is ("microsteps"), of cross_reversal the
  /// axis that it is seen in, of settings the setting, of skew where the second axis
  /// leans ("+x").
  std::string word{};
  std::vector<std::string> also{};  ///< Other words that would explain it as well.
  std::vector<FactFigure> figures{};
  std::vector<std::int64_t> rows{};  ///< That it is about; empty: all.
  double sigmas = kUnknown;  ///< How far beyond noise it is, where noise is known.
  /// @name The cause that it amounts to, where it does
  std::string cause{};  ///< As in the catalogue: "motors_swapped"; empty: none.
  std::string cause_axis{};
  std::vector<FactFigure> parameters{};

  std::string sentence{};  ///< Plain English, with its figures.
  /// Whether it answers a question, or only describes the rows (a repeatability).
  bool is_answer = false;
};

/// What to measure next with what people own.
struct Advice {
  std::string
      instrument{};  ///< feeler_gauge calliper dial probe printed_part ruler ...
  std::string sentence{};
};

/// Why the numbers are as they are, where it is none of the machine's doing.
struct NotTheMachine {
  /// work_offset reference_tool probe_mount settings workpiece slicer gauge file
  /// firmware; empty: nothing says so.
  std::string reason{};
  std::string sentence{};
};

/// All facts of one file.
struct Facts {
  std::vector<Fact> all{};                    ///< Answers first.
  std::vector<std::string> not_determined{};  ///< Names: "scale.z", "uncertainty".
  std::vector<std::string> cannot{};          ///< The same as sentences.
  /// Of those, baseline lines of axes that stood at one place all the time.
  std::vector<std::string> at_one_place{};
  std::vector<Advice> next{};  ///< The cheapest first.
  NotTheMachine not_the_machine{};
  bool is_one_place = false;  ///< All rows are of one place, come upon in one sense.

  const Fact* Find(const std::string& id) const;
};

/// Facts of rows in the order measured. Never throws: rows that say nothing give
/// nothing. `levelling`: of the console that the rows are from. `has_places`: false
/// where x and y count places, as a printed grid has them.
Facts FactsOf(const RowTable& table,
              const DataHeader& header,
              const LevellingLog& levelling = {},
              bool has_places = true);

}  // namespace caltwin
