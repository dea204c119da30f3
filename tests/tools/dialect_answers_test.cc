#include <algorithm>
#include <array>
#include <chrono>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sim/base/rng.h"
#include "sim/base/text_file.h"
#include "tools/commands/kinds/served.h"

// What a served controller answers, whatever it is told: a terminal, a client or a web
// page shows it.

namespace caltwin {
namespace {

constexpr std::array kMachines = {"gantry_router",
                                  "corexy_printer",
                                  "delta_printer",
                                  "triple_z_printer",
                                  "z_station",
                                  "motor_stage"};

/// What lines are put together from: of every dialect something, and what is none.
constexpr std::array<std::string_view, 72> kPieces = {
    "G0",
    "G1",
    "G4",
    "G28",
    "G30",
    "G33",
    "G38.2",
    "G53",
    "G54",
    "G90",
    "G91",
    "G92",
    "M17",
    "M18",
    "M92",
    "M112",
    "M114",
    "M115",
    "M119",
    "M201",
    "M203",
    "M206",
    "M208",
    "M400",
    "M409",
    "M420",
    "M421",
    "M425",
    "M500",
    "M501",
    "M503",
    "M504",
    "M505",
    "M584",
    "M665",
    "M666",
    "M671",
    "M812",
    "M814",
    "M818",
    "M851",
    "M999",
    "X10",
    "Y-3.5",
    "Z1e9",
    "A0",
    "Xnan",
    "P99999",
    "S\"a b\"",
    "K\"move\"",
    "F6000",
    "{1/0}",
    "{\"a\"}",
    "var x = 3",
    "echo \"\\t\"",
    "if true",
    "PROBE",
    "Z=0.1",
    "SET_GCODE_OFFSET",
    "GET_POSITION",
    "CALIBRATE_Z",
    "SAMPLES=2",
    "PROBE_ACCURACY",
    "BED_MESH_CALIBRATE",
    ";",
    "(",
    ")",
    "*12",
    "N5",
    "=",
    "foo",
    "\"",
};

std::string Bytes(Rng* rng, std::size_t most) {
  std::string bytes;
  const auto count =
      static_cast<std::size_t>(rng->Uniform() * static_cast<double>(most));
  while (bytes.size() < count) {
    const auto byte = static_cast<char>(rng->Next() & 0xff);
    if (byte != '\n' && byte != '\r') bytes += byte;
  }
  return bytes;
}

std::string Line(Rng* rng) {
  std::string line;
  const auto words = static_cast<int>(1 + 5 * rng->Uniform());
  for (int i = 0; i < words; ++i) {
    const auto piece =
        static_cast<std::size_t>(rng->Uniform() * static_cast<double>(kPieces.size()));
    line += kPieces.at(piece);
    if (rng->Uniform() < 0.8) line += ' ';
    if (rng->Uniform() < 0.1) line += Bytes(rng, 8);
  }
  if (rng->Uniform() < 0.01) line += Bytes(rng, 3000);
  return line;
}

std::string Escaped(std::string_view text) {
  std::string escaped;
  for (const char byte : text) {
    const auto code = static_cast<unsigned char>(byte);
    escaped += code < 0x20 || code > 0x7e ? fmt::format("\\x{:02x}", code)
                                          : std::string(1, byte);
  }
  return escaped;
}

/// Why a terminal should not be shown it; empty: it may be.
std::string WrongWith(const std::string& answer) {
  const bool has_control = std::ranges::any_of(answer, [](char byte) {
    const auto code = static_cast<unsigned char>(byte);
    return (code < 0x20 && code != '\t') || code == 0x7f;
  });
  if (has_control) return "a control character";
  try {
    RequireText(answer, "answer");
  } catch (const std::exception& fault) {
    return fault.what();
  }
  return "";
}

class EveryDialect : public ::testing::TestWithParam<const char*> {};

TEST_P(EveryDialect, AnswersInTextWhateverItIsTold) {
  TwinOptions options{.machine = GetParam(), .fidelity = "fast"};
  const auto file = FindMachine(options.machine, "", {.file = options.machine});
  const Served served = DialectOf(ServedKindOf(file), "").make(file, {.twin = options});
  Rng rng(20261125, 0, GetParam());
  constexpr int kLines = 1500;
  int answered = 0;
  for (int i = 0; i < kLines; ++i) {
    const std::string line = Line(&rng);
    const auto reply = served.link->Send(line, std::chrono::milliseconds(1000));
    std::vector<std::string> said;
    if (reply) {
      said = *reply;
    } else {
      // A fault's lines are joined.
      std::size_t from = 0;
      const std::string& text = reply.error().reply;
      while (from <= text.size()) {
        const std::size_t end = std::min(text.find('\n', from), text.size());
        said.push_back(text.substr(from, end - from));
        from = end + 1;
      }
      served.link->Send("M999", std::chrono::milliseconds(1000));
    }
    for (const std::string& answer : said) {
      ++answered;
      EXPECT_EQ(WrongWith(answer), "")
          << "told " << Escaped(line) << "\nanswered " << Escaped(answer);
    }
    if (HasFailure()) return;
  }
  EXPECT_GT(answered, kLines / 10);
}

/// What a port says, as it comes.
struct Heard {
  std::mutex mutex{};
  std::string bytes{};
  Say Into() {
    return [this](std::string_view said) {
      const std::lock_guard<std::mutex> lock(mutex);
      bytes += said;
    };
  }
  std::string Take() {
    const std::lock_guard<std::mutex> lock(mutex);
    return std::exchange(bytes, {});
  }
};

// Whatever it was told, it answers each line once, and after a reset it is there.
TEST(GrblDialect, AnswersInTextAndOnceALine) {
  TwinOptions options{.machine = "gantry_router", .fidelity = "fast"};
  const auto file = FindMachine(options.machine, "", {.file = options.machine});
  const Served served =
      DialectOf(ServedKindOf(file), "grbl").make(file, {.twin = options});
  Heard heard;
  const auto port = served.open_port(heard.Into());
  Rng rng(20261128, 0, "grbl");
  const auto told = [&](const std::string& bytes, const std::string& until) {
    port->Hear(bytes);
    std::string said;
    for (int i = 0; i < 2000 && said.find(until) == std::string::npos; ++i) {
      said += heard.Take();
      if (said.find(until) == std::string::npos)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return said;
  };
  constexpr int kLines = 1500;
  for (int i = 0; i < kLines; ++i) {
    std::string line = Line(&rng);
    if (rng.Uniform() < 0.3) line = "$" + line;
    // What acts at once is told apart below; a sleep or a pause lasts until a reset.
    std::erase_if(line, [](char byte) {
      return byte == '?' || byte == '!' || byte == '~' || byte == 0x18 || byte < 0;
    });
    port->Hear(line + "\n");
    const std::string said = told("\x18", "Grbl 1.1h");
    EXPECT_NE(said.find("Grbl 1.1h"), std::string::npos) << Escaped(line);
    EXPECT_NE(told("?", ">").find("MPos:"), std::string::npos) << Escaped(line);
    std::string text = said;
    std::erase(text, '\r');
    std::ranges::replace(text, '\n', ' ');
    EXPECT_EQ(WrongWith(text), "")
        << "told " << Escaped(line) << "\nsaid " << Escaped(said);
    if (HasFailure()) return;
  }
  told("$X\n", "ok");
  std::string many;
  for (int i = 0; i < 6; ++i) many += i % 2 == 0 ? "G91 G0 X-0.1\n" : "foo\n";
  const std::string said = told(many + "$I\n", "128]\r\nok");
  const auto count = [&](const std::string& word) {
    int found = 0;
    for (std::size_t at = said.find(word); at != std::string::npos;
         at = said.find(word, at + 1)) {
      ++found;
    }
    return found;
  };
  EXPECT_EQ(count("ok\r\n") + count("error:"), 7) << said;
}

INSTANTIATE_TEST_SUITE_P(AsServed, EveryDialect, ::testing::ValuesIn(kMachines));

}  // namespace
}  // namespace caltwin
