#include "sim/base/input_error.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace caltwin {
namespace {

constexpr std::size_t kMostFaultsShown = 20;

std::string InputMessage(const Place& place,
                         const std::string& text,
                         const std::string& hint) {
  const std::string where = ToString(place);
  std::string message = where.empty() ? text : where + ": " + text;
  if (!hint.empty()) message += "\n  " + hint;
  return message;
}

std::size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

}  // namespace

std::string ToString(const Place& place) {
  std::string text = place.file;
  if (place.line > 0) text += fmt::format(":{}", place.line);
  if (place.line > 0 && place.column > 0) text += fmt::format(":{}", place.column);
  return text;
}

InputError::InputError(std::vector<std::string> faults)
    : std::runtime_error(fmt::format("{}", fmt::join(faults, "\n"))),
      faults_(std::move(faults)) {}

InputError::InputError(const Place& place,
                       const std::string& text,
                       const std::string& hint)
    : InputError(std::vector{InputMessage(place, text, hint)}) {}

void Faults::Add(const Place& place, const std::string& text, const std::string& hint) {
  faults_.push_back(InputMessage(place, text, hint));
}

void Faults::Add(const InputError& error) {
  faults_.insert(faults_.end(), error.faults().begin(), error.faults().end());
}

void Faults::Note(const Place& place, const std::string& text) {
  const std::string note = InputMessage(place, text, "");
  if (std::ranges::find(notes_, note) == notes_.end()) notes_.push_back(note);
}

void Faults::ThrowIfAny() const {
  if (!faults_.empty()) throw InputError(faults_);
}

std::string FaultsText(const InputError& error) {
  const auto& faults = error.faults();
  const std::size_t shown = std::min(faults.size(), kMostFaultsShown);
  std::string text;
  for (std::size_t i = 0; i < shown; ++i) text += faults[i] + "\n";
  if (faults.size() > shown)
    text += fmt::format("and {} more\n", faults.size() - shown);
  return text;
}

std::string NearestWord(const std::string& word,
                        const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : known) {
    const std::size_t distance = EditDistance(word, candidate);
    const bool shares_a_letter = distance < std::max(word.size(), candidate.size());
    if (distance < least && shares_a_letter) {
      least = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

}  // namespace caltwin
