// Words that are explained, and truth files of every kind of machine.
#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/base/temp_folder.h"
#include "tests/tools/run_command.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;

// What a reader lists as known when it refuses a key.
std::vector<std::string> KeysThatAreKnown(const std::string& scenario) {
  const TempFolder folder;
  const auto file = folder / "keys.yaml";
  std::ofstream(file) << scenario;
  const std::string said = RunCommand(DeclareRun, {file.string()}).fault;
  constexpr std::string_view kLists = "It knows: ";
  const std::size_t at = said.find(kLists);
  if (at == std::string::npos) return {};
  std::string list = said.substr(at + kLists.size());
  list = list.substr(0, list.find('\n'));
  std::ranges::replace(list, ',', ' ');
  std::istringstream words(list);
  return {std::istream_iterator<std::string>(words), {}};
}

TEST(Explain, KnowsEveryKeyOfANozzlesHeight) {
  const std::string machine = "machine: triple_z_printer\ncalibrate: [z_calibration]\n";
  for (const std::string part : {"station: {nonsense: 1}",
                                 "station: {}\nsettings: {nonsense: 1}",
                                 "station: {}\nsettings: {bed_mesh: {nonsense: 1}}"}) {
    const auto keys = KeysThatAreKnown(machine + part + "\n");
    EXPECT_THAT(keys.size(), ::testing::Ge(4u)) << part;
    for (const std::string& key : keys) {
      EXPECT_THAT(Printed(DeclareExplain, {key}), HasSubstr("printer's station)"))
          << key;
    }
  }
}

// As it does not say whose it is, of any kind of machine.
TEST(Validate, KnowsATruthFileOfEveryKindOfMachine) {
  for (const char* effect : {"backlash.x: {gap_mm: 0.05}",
                             "tower_radius.a: {error_mm: 0.1}",
                             "screw_pitch.z2: {error_ppm: 300}",
                             "ooze: {thickness_um: 80}",
                             "switch_scatter.x: {sd_um: 10}"}) {
    const TempFolder folder;
    const auto file = folder / "t.yaml";
    std::ofstream(file) << fmt::format("effects:\n  {}\n", effect);
    EXPECT_THAT(Printed(DeclareValidate, {file.string()}),
                HasSubstr("t.yaml: truth, no faults"))
        << effect;
  }
}

}  // namespace
}  // namespace caltwin
