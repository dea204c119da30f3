#include "calibration/diagnosis/stories.h"

#include <algorithm>
#include <set>
#include <string>

#include "sim/effects/drive.h"

namespace caltwin {
namespace {

constexpr double kClock_nats = 12;
constexpr double kOneAxis_nats = 16;

bool IsTower(const std::string& channel) {
  const auto drive = DriveNamed(channel);
  return drive && drive->is_motor && channel.size() == 1;
}

// In any order, time and temperature alike. A tower's carriage stands where the place
// wants it.
std::set<std::string> Variables(const Shown& shown) {
  std::set<std::string> words;
  for (const std::string& word : shown.covariates) {
    words.insert(word == "temp" ? "t" : word);
    if (IsTower(shown.channel) && word.starts_with("motor_")) {
      words.insert({"x", "y", "z"});
    }
  }
  return words;
}

bool HasWord(const Shown& shown, const std::string& word) {
  return std::ranges::find(shown.covariates, word) != shown.covariates.end();
}

bool ShareRows(const std::string& one, const std::string& other) {
  const auto is_either = [&](const char* channel) {
    return one == channel || other == channel;
  };
  return one == other || is_either("probe") || (is_either("bed") && is_either("z")) ||
         IsTower(one) || IsTower(other);
}

}  // namespace

double MarginOver(const Candidate& named, const Candidate& free) {
  if (named.shown.channel == "probe" && AxisNamed(free.shown.channel)) {
    return kOneAxis_nats;
  }
  const bool is_by_the_clock =
      named.shown.channel == free.shown.channel && named.shown.covariates.size() > 1 &&
      HasWord(named.shown, "temp") && HasWord(free.shown, "t") &&
      Variables(named.shown) == Variables(free.shown);
  return is_by_the_clock ? kClock_nats : kOwnShape_nats;
}

bool ShareRowsAndVariable(const Shown& one, const Shown& other) {
  if (!ShareRows(one.channel, other.channel)) return false;
  const std::set<std::string> words = Variables(other);
  return std::ranges::any_of(Variables(one), [&](const std::string& word) {
    return !word.starts_with("dir_") && words.contains(word);
  });
}

}  // namespace caltwin
