#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/measure/data_header.h"
#include "sim/measure/row.h"

namespace caltwin {

/// What a person knows of a file beyond what stands in it.
struct ImportOptions {
  std::string axis{};  ///< x, y or z, where the file does not say which was measured.
  std::string unit{};  ///< Of the readings, where the file does not say.
  std::string campaign{};  ///< A name; empty: the reader's.
  std::optional<double>
      step_mm{};                   ///< True length of a motor step; wins over the file.
  std::vector<std::string> map{};  ///< `value_mm=dev[um]` (sim/measure/import/map.h).
  /// Known blunders of people and firmware become notes, and no refusal.
  bool tells_blunders = false;
  bool has_machine = false;  ///< One is named: the text need not say what it is.
};

/// A figure of a note. The key ends in its unit: "change_um".
struct NoteFigure {
  std::string key{};
  double value = 0;
  double sd = kUnknown;  ///< kUnknown: nothing in the file determines it.
};

/// What a file says beyond its readings.
struct FileNote {
  enum class Kind {
    kSetting,    ///< A value in a configuration that cannot be right. what: the key.
    kOpen,       ///< What these figures do not determine. what: its name.
    kElsewhere,  ///< Why it is not the machine. what: firmware, file ...
    kFact,       ///< What its figures show.
  };
  Kind kind = Kind::kSetting;
  std::string what{};
  std::string
      sentence{};  ///< Plain English: what is so, and what is right. No full stop.
  Place place{};
  /// @name Where the note rests on figures: the fact that they are, as a fact has it
  std::string fact{};  ///< "offset", "known_ratio"; empty: no figures.
  std::string axis{}, word{};
  std::vector<NoteFigure> figures{};
  std::string cause{};  ///< That they amount to, as in the catalogue; empty: none.
  std::vector<NoteFigure> parameters{};  ///< Of the cause.
};

/// One round of a levelling command: what each motor was moved by before the touches of
/// a session.
struct LevellingRound {
  std::string home{};              ///< Row::home of the touches after it.
  std::vector<double> moved_mm{};  ///< By motor, in the order of the firmware.
};

/// Levelling as a console shows it.
struct LevellingLog {
  std::vector<std::array<double, 2>> pivots_mm{};  ///< As configured; may be empty.
  std::vector<LevellingRound> rounds{};
  /// Left less right as an alignment of two motors printed it, a round each.
  std::vector<double> differences_mm{};
  bool is_by_hand = false;  ///< A person turned the screws as told.
};

/// A stranger's file as measured rows, and what a person should know of the way there.
struct Imported {
  RowTable table{};
  DataHeader header{};
  std::string machine_yaml{};  ///< A machine file's text; empty: nothing known.
  std::vector<std::string> recognised{};  ///< What the file was found to be.
  std::vector<std::string> assumed{};     ///< Units, signs, senses nobody stated.
  std::vector<std::string> warnings{};    ///< What is odd and was kept as it stands.
  std::vector<FileNote> notes{};          ///< Of the configuration or story in it.
  LevellingLog levelling{};
  std::string next_instrument{};  ///< What would tell the open ones; empty: not said.
  std::string next_sentence{};    ///< How to use it; empty: "measure that with a ...".
  /// The kind of machine that the text speaks of without its geometry; empty: none.
  /// What is assumed of a gantry does not hold of it.
  std::string told_kind{};
  bool has_places =
      true;  ///< False: positions are indices, of use among themselves only.
  bool has_unit = false;  ///< The format, or a person, says the unit of the readings.
  /// The value was made here, as position read less position commanded.
  bool is_deviation = false;
};

/// One kind of file that can be read. `read` throws InputError, with file:line:column,
/// for what it does not take; `name` stands in messages.
struct Importer {
  std::string_view kind{};
  std::string_view about{};
  Imported (*read)(const std::string& text,
                   const std::string& name,
                   const ImportOptions& options) = nullptr;
  bool has_unit = false;  ///< The format fixes the unit of the readings.
};

/// The kind of a file that somebody names or leaves open (empty: found by its text).
/// Throws InputError where the name is none.
std::string KindOrFound(const std::string& kind,
                        const std::string& text,
                        const std::string& name);

/// Every kind there is (catalog.cc).
std::span<const Importer> AllImporters();

/// Reads a file as that kind. Known blunders (blunders.h) are told before anything
/// else; the rows are numbered in file order. Files up to 64 MB.
Imported Import(const std::string& kind,
                const std::filesystem::path& file,
                const ImportOptions& options);
/// The same from text.
Imported ImportText(const std::string& kind,
                    const std::string& text,
                    const std::string& name,
                    const ImportOptions& options);

}  // namespace caltwin
