#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/measure/import/spreadsheet.h"
#include "sim/measure/import/unit.h"
#include "sim/measure/row.h"

namespace caltwin {

/// What a column of a table holds.
enum class Part {
  kNone,
  kAxis,
  kPosition,
  kCommanded,
  kActual,
  kDeviation,
  kHeight,
  kSense,
  kRun,
  kFeed,
  kTemperature,
  kTime,
  kSetup,  ///< A word that tells rows apart.
  kSteps,  ///< Steps/mm that were set.
  kHome,
  kEvent  ///< Yes or no: whether something had happened before.
};

/// A column and what it is.
struct TableColumn {
  std::size_t index = 0;
  Part part = Part::kNone;
  int axis = -1;  ///< Where the heading has a letter x, y or z.
  const NamedUnit* unit = nullptr;
  double Row::*temperature = nullptr;
  std::string side{};  ///< "outside", "inside": a wall measured by that column.
  /// +1 of "forward", -1 of "backward" beside it: the sense in which it was read.
  double sense = kUnknown;
  double sign = 1;  ///< -1 of "too short": what is off counts the other way.
};

/// Words of letters and digits, in small letters.
std::vector<std::string> TokensOf(const std::string& heading);
Quantity QuantityOf(Part part);
/// Whether a word says on which side of a wall something was measured: "inside".
bool IsSideWord(const std::string& token);
/// The measuring instrument that a heading or a label names ("laser" of "Laser (um)");
/// empty: none.
std::string InstrumentIn(const std::string& label);

/// Cells that hold two things become columns of their own: "X+1" is an axis, a move and
/// its sense, "12.3 mm" a number whose unit stands in the heading.
void PartCells(Spreadsheet* sheet);

/// What the columns of a sheet are: by their headings, then by what stands in them. A
/// number beside a command was read, one beside a reading was told; of columns whose
/// headings say nothing the roundest was told. `taken` gets a sentence for each guess.
std::vector<TableColumn> ColumnsOf(const Spreadsheet& sheet,
                                   std::vector<std::string>* taken);

/// Whether each line has a number there, or nothing, and one has.
bool AreNumbers(const Spreadsheet& sheet, std::size_t column);
/// The numbers of a column, without its empty cells.
std::vector<double> NumbersOf(const Spreadsheet& sheet, std::size_t column);

}  // namespace caltwin
