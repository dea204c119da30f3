#include "sim/link/gcode.h"

#include <clocale>
#include <cstdint>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/input_error.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

using testing::HasSubstr;

std::string FaultOf(std::string_view line) {
  try {
    ParseGcode(line);
  } catch (const InputError& error) {
    return error.faults().front();
  }
  return "";
}

TEST(Gcode, LineComesApartIntoWords) {
  const GcodeLine line = ParseGcode("g38.2 X-12.5 y+.25 Z3. F60 ; to the left face");

  ASSERT_EQ(line.commands.size(), 1);
  const GcodeCommand& command = line.commands[0];
  EXPECT_TRUE(command.Is('G', 38, 2));
  EXPECT_EQ(command.Name(), "G38.2");
  EXPECT_EQ(command.Find('X')->number, -12.5);
  EXPECT_EQ(command.Find('Y')->number, 0.25);
  EXPECT_EQ(command.Find('Z')->number, 3);
  EXPECT_EQ(command.Find('F')->number, 60);
  EXPECT_EQ(command.Find('E'), nullptr);
  EXPECT_EQ(line.text, "g38.2 X-12.5 y+.25 Z3. F60");
}

TEST(Gcode, BracketsAreCommentsInCommands) {
  const GcodeLine line = ParseGcode("(before) G1 (go * on) X1(there)Y2 (end)");

  ASSERT_EQ(line.commands.size(), 1);
  EXPECT_EQ(line.commands[0].words.size(), 2);
  EXPECT_TRUE(ParseGcode("(alone)").commands.empty());
}

TEST(Gcode, BracketsAreArithmeticInMetaCommands) {
  const GcodeLine line = ParseGcode("  if (1 + 2) * 3 > 4 ; why");

  EXPECT_TRUE(line.is_meta);
  EXPECT_EQ(line.indent, 2);
  EXPECT_EQ(line.text, "if (1 + 2) * 3 > 4");
}

TEST(Gcode, SemicolonInQuotesIsText) {
  EXPECT_EQ(ParseGcode(R"(echo "a;b" ; c)").text, R"(echo "a;b")");
  EXPECT_EQ(ParseGcode(R"(M98 P"a;""b.g" ; c)").commands[0].Find('P')->text, "a;\"b.g");
}

TEST(Gcode, ExpressionsAreKeptAsText) {
  const GcodeLine line = ParseGcode(R"(G1 X{move.axes[0].max * {2}} Y{"}"} Z1)");

  EXPECT_EQ(line.commands[0].Find('X')->text, "move.axes[0].max * {2}");
  EXPECT_EQ(line.commands[0].Find('Y')->text, R"("}")");
  EXPECT_EQ(line.commands[0].Find('Z')->number, 1);
}

TEST(Gcode, SeveralCommandsShareALine) {
  const GcodeLine line = ParseGcode("G53 G0 X1 Y2 G91");

  ASSERT_EQ(line.commands.size(), 3);
  EXPECT_TRUE(line.commands[0].Is('G', 53));
  EXPECT_EQ(line.commands[1].words.size(), 2);
  EXPECT_TRUE(line.commands[2].Is('G', 91));
}

TEST(Gcode, WordsAloneAreForTheModalMove) {
  const GcodeLine line = ParseGcode("X1 Y2");

  ASSERT_EQ(line.commands.size(), 1);
  EXPECT_EQ(line.commands[0].letter, 0);
  EXPECT_EQ(line.commands[0].words.size(), 2);
}

TEST(Gcode, NumberAndChecksumAreChecked) {
  const GcodeLine line = ParseGcode("N3 G28*16");

  EXPECT_EQ(line.number, 3);
  EXPECT_EQ(line.text, "G28");
  EXPECT_EQ(FaultOf("N3 G28*17"), "G-code:1:7: checksum 17 where the line gives 16");
  EXPECT_EQ(GcodeChecksum("N0 M110 N0"), 125);
}

TEST(Gcode, FreeTextIsKept) {
  EXPECT_EQ(ParseGcode("M118 GAUGE laser.x").commands[0].rest, "GAUGE laser.x");
  EXPECT_EQ(ParseGcode("M117 Probing (left) #1").commands[0].rest, "Probing (left) #1");
  EXPECT_EQ(ParseGcode(R"(M118 P0 S"hi")").commands[0].Find('S')->text, "hi");
}

TEST(Gcode, BareLettersAreWords) {
  const GcodeLine line = ParseGcode("G28 X Z");

  EXPECT_EQ(line.commands[0].Find('X')->kind, GcodeWord::Kind::kBare);
  EXPECT_NE(line.commands[0].Find('Z'), nullptr);
  EXPECT_TRUE(ParseGcode("   ").commands.empty());
}

TEST(Gcode, FaultsSayWhereAndWhatIsAllowed) {
  EXPECT_THAT(FaultOf("G1 X1 $"), HasSubstr("G-code:1:7: '$' begins no word"));
  EXPECT_THAT(FaultOf("G1 X\"a"), HasSubstr("no '\"' closes"));
  EXPECT_THAT(FaultOf("G1 X{1"), HasSubstr("no '}' closes"));
  EXPECT_THAT(FaultOf("G1 (X1"), HasSubstr("no ')' closes"));
  EXPECT_THAT(FaultOf("G X1"), HasSubstr("the number of a G command"));
  EXPECT_THAT(FaultOf(std::string(1001, 'X')), HasSubstr("1000 are allowed"));
}

TEST(Gcode, NoiseIsParsedOrRefusedButNeverElse) {
  Rng rng(1, 0, "noise");
  const std::string alphabet = "GMTNXYZF0123456789.-+*;(){}\"'[] \t\r\xff\x01ifecho";
  for (int i = 0; i < 5'000; ++i) {
    std::string line;
    const auto length = static_cast<int>(rng.Uniform() * 30);
    for (int k = 0; k < length; ++k) {
      line += alphabet[static_cast<std::size_t>(rng.Uniform() *
                                                static_cast<double>(alphabet.size()))];
    }
    try {
      ParseGcode(line);
    } catch (const InputError&) {
    }
  }
}

TEST(Gcode, FeedsAreConvertedBothWays) {
  EXPECT_DOUBLE_EQ(FeedFromWord_mm_s(60), 1);
  EXPECT_DOUBLE_EQ(FeedWord_mm_min(FeedFromWord_mm_s(123.4)), 123.4);
}

TEST(Gcode, NumbersAreWrittenWithoutExponentOrLocale) {
  std::setlocale(LC_ALL, "de_DE.UTF-8");
  EXPECT_EQ(GcodeNumber(12.3), "12.3");
  EXPECT_EQ(GcodeNumber(-0.05), "-0.05");
  EXPECT_EQ(GcodeNumber(1e-9), "0");
  EXPECT_EQ(GcodeNumber(-1e-9), "0");
  EXPECT_EQ(GcodeNumber(1e6), "1000000");
  EXPECT_EQ(GcodeNumber(800.12345678, 4), "800.1235");
  EXPECT_EQ(GcodeNumber(100, 0), "100");
  EXPECT_EQ(ParseGcode("G1 X1.5").commands[0].Find('X')->number, 1.5);
  std::setlocale(LC_ALL, "C");
}

TEST(Gcode, MoveIsWrittenAsItIsRead) {
  EXPECT_EQ(GcodeMove("G38.2", {{'X', 12.3}}, 1), "G38.2 X12.3 F60");
  EXPECT_EQ(GcodeMove("G0", {{'X', 1}, {'Y', -2.5}}), "G0 X1 Y-2.5");
}

}  // namespace
}  // namespace caltwin
