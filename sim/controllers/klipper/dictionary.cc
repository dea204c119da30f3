#include "sim/controllers/klipper/dictionary.h"

#include <array>

#include <nlohmann/json.hpp>

#include "sim/base/deflate.h"
#include "sim/controllers/klipper/formats.h"

namespace caltwin {
namespace klipper {
namespace {

constexpr std::array kShutdownWords = {
    std::string_view("Command request"),
    std::string_view("Timer too close"),
    std::string_view("Stepper too far in past"),
    std::string_view("Missed scheduling of next digital out event"),
    std::string_view("Missed scheduling of next hard pwm event"),
    std::string_view("ADC out of range"),
    std::string_view("Move queue overflow"),
    std::string_view("Can't reset time when stepper active"),
    std::string_view("Invalid count parameter"),
    std::string_view("Can't assign oid"),
    std::string_view("Invalid oid type"),
    std::string_view("Not a valid input pin"),
    std::string_view("Already finalized"),
    std::string_view("config_reset only available when shutdown"),
    std::string_view("Command parser error"),
};

nlohmann::json NumbersOf(std::span<const MessageFormat> formats) {
  nlohmann::json numbers = nlohmann::json::object();
  for (const MessageFormat& format : formats) {
    numbers[std::string(format.text)] = format.id;
  }
  return numbers;
}

template <typename Names>
nlohmann::json Enumerated(const Names& names) {
  nlohmann::json numbers = nlohmann::json::object();
  int next = 0;
  for (const auto& name : names) numbers[std::string(name)] = next++;
  return numbers;
}

}  // namespace

std::span<const std::string_view> ShutdownWords() {
  return kShutdownWords;
}

std::string DictionaryJson(const Board& board) {
  const nlohmann::json dictionary = {
      {"version", "caltwin-" CALTWIN_VERSION},
      {"build_versions", "caltwin"},
      {"app", "caltwin"},
      {"license", ""},
      {"config",
       {{"MCU", "caltwin"},
        {"CLOCK_FREQ", kTicksPerSecond},
        {"ADC_MAX", kAdcMax},
        {"PWM_MAX", kPwmMax},
        {"STATS_SUMSQ_BASE", 256}}},
      {"enumerations",
       {{"pin", Enumerated(board.pins())},
        {"static_string_id", Enumerated(kShutdownWords)}}},
      {"commands", NumbersOf(Commands())},
      {"responses", NumbersOf(Responses())}};
  return dictionary.dump();
}

Bytes CompressedDictionary(const Board& board) {
  const std::string packed = Deflated(DictionaryJson(board));
  return {packed.begin(), packed.end()};
}

}  // namespace klipper
}  // namespace caltwin
