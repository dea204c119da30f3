#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/input_error.h"
#include "sim/measure/csv.h"

namespace caltwin {

/// One setting of a printer.cfg: what stands behind its key, and the lines indented
/// below it (the points of a mesh), each with its place.
struct CfgSetting {
  CsvField value{};
  std::vector<CsvField> more{};
};

/// Sections of a Klipper configuration: `[name]`, `key: value` or `key = value`, `#`
/// and `;` comments. The block that SAVE_CONFIG writes stands in comments that begin
/// with `#*#`; what it says wins over what the person wrote.
///
/// Keys are in small letters, as Klipper reads them. A key given twice counts where it
/// stands last, as Klipper takes it. At most 4000 sections.
class PrinterCfg {
 public:
  PrinterCfg(const std::string& text, std::string name);

  const std::string& name() const { return name_; }
  /// The setting; null where there is none. `section` in the words of the file.
  const CfgSetting* Find(std::string_view section, std::string_view key) const&;
  /// Of one that is gone at the end of the line nothing is to be found.
  const CfgSetting* Find(std::string_view section,
                         std::string_view key) const&& = delete;
  /// All that SAVE_CONFIG has written, by section and key.
  struct Saved {
    std::string section{};  ///< "stepper_a"
    std::string key{};      ///< "position_endstop"
    std::string value{};    ///< "300.3107"; a mesh's points a line each.
  };
  std::vector<Saved> AllSaved() const;
  /// Whether the setting in force is a saved one.
  bool IsSaved(std::string_view section, std::string_view key) const;
  /// A number, in force or saved; nullopt where there is none. A setting that is no
  /// finite number within the bounds is a fault (and nullopt).
  std::optional<double> Number(std::string_view section,
                               std::string_view key,
                               double min,
                               double max,
                               Faults* faults) const;
  /// yes, true, on, 1 or no, false, off, 0 in any case; nullopt: neither.
  std::optional<bool> Flag(std::string_view section, std::string_view key) const;
  /// Exactly `count` numbers apart by commas, as above.
  std::optional<std::vector<double>> Numbers(std::string_view section,
                                             std::string_view key,
                                             std::size_t count,
                                             Faults* faults) const;
  /// Names of the sections that begin with that word, saved ones first, each once.
  std::vector<std::string> Sections(std::string_view first_word) const;
  /// Line of a section's heading, or of 1 where it has none.
  Place PlaceOfSection(std::string_view section) const;

 private:
  using Settings = std::map<std::string, CfgSetting, std::less<>>;
  struct Section {
    Settings settings{};
    Place place{};
  };
  using SectionsByName = std::map<std::string, Section, std::less<>>;

  void ReadLine(std::string_view line, int number, int column, bool is_saved);

  std::string name_;
  SectionsByName written_, saved_;
  Section* section_[2] = {nullptr, nullptr};     ///< Being read: written, saved.
  CfgSetting* setting_[2] = {nullptr, nullptr};  ///< That may go on below.
};

/// Numbers apart by commas, with the place of each; a fault for what is none.
std::vector<double> NumbersIn(const CsvField& list,
                              const std::string& what,
                              const std::string& name,
                              Faults* faults);

}  // namespace caltwin
