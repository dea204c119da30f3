#include "sim/measure/import/printer_cfg.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

constexpr std::string_view kBlanks = " \t\r\f\v";
constexpr std::string_view kSaved = "#*#";
constexpr std::size_t kMostSections = 4000;

std::string_view WithoutBlanks(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// Column, from 1, of the first letter that is no blank.
int ColumnOf(std::string_view text, int column) {
  return column +
         static_cast<int>(std::min(text.size(), text.find_first_not_of(kBlanks)));
}

bool IsKey(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           c == '_' || c == '-';
  });
}

}  // namespace

std::optional<bool> PrinterCfg::Flag(std::string_view section,
                                     std::string_view key) const {
  const CfgSetting* const setting = Find(section, key);
  if (setting == nullptr) return std::nullopt;
  const std::string word = Lowered(setting->value.text);
  if (word == "yes" || word == "true" || word == "on" || word == "1") return true;
  if (word == "no" || word == "false" || word == "off" || word == "0") return false;
  return std::nullopt;
}

PrinterCfg::PrinterCfg(const std::string& text, std::string name)
    : name_(std::move(name)) {
  std::string_view rest = text;
  for (int number = 1; !rest.empty(); ++number) {
    std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
    const bool is_saved = line.starts_with(kSaved);
    if (is_saved) line.remove_prefix(kSaved.size());
    ReadLine(
        line, number, is_saved ? 1 + static_cast<int>(kSaved.size()) : 1, is_saved);
  }
}

void PrinterCfg::ReadLine(std::string_view line,
                          int number,
                          int column,
                          bool is_saved) {
  SectionsByName& sections = is_saved ? saved_ : written_;
  Section*& section = section_[is_saved ? 1 : 0];
  CfgSetting*& setting = setting_[is_saved ? 1 : 0];
  line = line.substr(0, line.find_first_of("#;"));
  const std::string_view words = WithoutBlanks(line);
  if (words.empty()) return;
  const CsvField field{
      .text = std::string(words), .line = number, .column = ColumnOf(line, column)};
  if (words.front() == '[') {
    const std::size_t end = words.find(']');
    if (end == std::string_view::npos) return;
    const std::string title(WithoutBlanks(words.substr(1, end - 1)));
    if (!sections.contains(title) && sections.size() >= kMostSections) {
      throw InputError({.file = name_, .line = number, .column = field.column},
                       fmt::format("more than {} sections", kMostSections),
                       "this is no printer's configuration");
    }
    section = &sections[title];
    section->place = {.file = name_, .line = number, .column = field.column};
    setting = nullptr;
    return;
  }
  if (section == nullptr) return;
  // In the saved block a blank stands behind every #*#, a tab before what goes on.
  const bool goes_on = is_saved ? line.starts_with(" \t") || line.starts_with("   ")
                                : kBlanks.find(line.front()) != std::string_view::npos;
  if (goes_on) {
    if (setting != nullptr) setting->more.push_back(field);
    return;
  }
  const std::size_t mark = words.find_first_of(":=");
  const std::string_view key = WithoutBlanks(words.substr(0, mark));
  if (mark == std::string_view::npos || !IsKey(key)) {
    setting = nullptr;
    return;
  }
  const std::string_view behind = words.substr(mark + 1);
  setting = &section->settings[Lowered(key)];
  *setting = {
      .value = {.text = std::string(WithoutBlanks(behind)),
                .line = number,
                .column = ColumnOf(behind, field.column + static_cast<int>(mark) + 1)}};
}

const CfgSetting* PrinterCfg::Find(std::string_view section,
                                   std::string_view key) const& {
  for (const SectionsByName* sections : {&saved_, &written_}) {
    const auto found = sections->find(section);
    if (found == sections->end()) continue;
    const auto setting = found->second.settings.find(key);
    if (setting != found->second.settings.end()) return &setting->second;
  }
  return nullptr;
}

std::vector<PrinterCfg::Saved> PrinterCfg::AllSaved() const {
  std::vector<Saved> all;
  for (const auto& [title, section] : saved_) {
    for (const auto& [key, setting] : section.settings) {
      Saved one{.section = title, .key = key, .value = setting.value.text};
      for (const CsvField& line : setting.more) {
        one.value += (one.value.empty() ? "" : "\n") + line.text;
      }
      all.push_back(one);
    }
  }
  return all;
}

bool PrinterCfg::IsSaved(std::string_view section, std::string_view key) const {
  const auto found = saved_.find(section);
  return found != saved_.end() && found->second.settings.contains(key);
}

std::optional<double> PrinterCfg::Number(std::string_view section,
                                         std::string_view key,
                                         double min,
                                         double max,
                                         Faults* faults) const {
  const CfgSetting* setting = Find(section, key);
  if (setting == nullptr) return std::nullopt;
  const auto value = NumberOf(setting->value.text);
  if (value && *value >= min && *value <= max) return value;
  faults->Add(PlaceOf(setting->value, name_),
              fmt::format("[{}] {} = '{}' is no number from {:g} to {:g}",
                          section,
                          key,
                          setting->value.text,
                          min,
                          max));
  return std::nullopt;
}

std::optional<std::vector<double>> PrinterCfg::Numbers(std::string_view section,
                                                       std::string_view key,
                                                       std::size_t count,
                                                       Faults* faults) const {
  const CfgSetting* setting = Find(section, key);
  if (setting == nullptr) return std::nullopt;
  const std::size_t before = faults->size();
  std::vector<double> numbers =
      NumbersIn(setting->value, fmt::format("[{}] {}", section, key), name_, faults);
  if (faults->size() == before && numbers.size() != count) {
    faults->Add(
        PlaceOf(setting->value, name_),
        fmt::format(
            "[{}] {} has {} numbers, not {}", section, key, numbers.size(), count));
  }
  if (faults->size() != before) return std::nullopt;
  return numbers;
}

std::vector<std::string> PrinterCfg::Sections(std::string_view first_word) const {
  std::vector<std::string> names;
  for (const SectionsByName* sections : {&saved_, &written_}) {
    for (const auto& [title, section] : *sections) {
      const bool begins = title.substr(0, title.find_first_of(kBlanks)) == first_word;
      if (begins && std::ranges::find(names, title) == names.end()) {
        names.push_back(title);
      }
    }
  }
  return names;
}

Place PrinterCfg::PlaceOfSection(std::string_view section) const {
  for (const SectionsByName* sections : {&saved_, &written_}) {
    const auto found = sections->find(section);
    if (found != sections->end()) return found->second.place;
  }
  return {.file = name_, .line = 1, .column = 1};
}

std::vector<double> NumbersIn(const CsvField& list,
                              const std::string& what,
                              const std::string& name,
                              Faults* faults) {
  std::vector<double> numbers;
  std::string_view rest = list.text;
  int column = list.column;
  while (true) {
    const std::size_t comma = std::min(rest.size(), rest.find(','));
    const std::string_view one = rest.substr(0, comma);
    numbers.push_back(NumberIn({.text = std::string(WithoutBlanks(one)),
                                .line = list.line,
                                .column = ColumnOf(one, column)},
                               fmt::format("{}, number {}", what, numbers.size() + 1),
                               name,
                               faults));
    if (comma == rest.size()) return numbers;
    rest.remove_prefix(comma + 1);
    column += static_cast<int>(comma) + 1;
  }
}

}  // namespace caltwin
