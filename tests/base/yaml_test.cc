#include "sim/base/yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::StrEq;

/// What a person reads after `read` has gone over `text` as the file "f.yaml".
template <typename Read>
std::string MessagesOf(const std::string& text, Read read) {
  Faults faults;
  try {
    YamlMap map = ReadYamlText(text, "f.yaml", &faults);
    read(&map);
    faults.ThrowIfAny();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}
std::string MessagesOf(const std::string& text) {
  return MessagesOf(text, [](YamlMap*) {});
}

TEST(YamlValue, NumberOutOfBoundsNamesPlaceValueBoundsAndHint) {
  const auto read = [](YamlMap* map) {
    map->Required("axes")->Map().Number("gap_mm", {0, 2}, "a gap has no sign");
  };

  EXPECT_THAT(MessagesOf("axes:\n  gap_mm: -0.05\n", read),
              StrEq("f.yaml:2:11: axes.gap_mm = -0.05 is outside 0 .. 2\n"
                    "  a gap has no sign"));
}

TEST(YamlValue, NumberTakesWhatPeopleWriteAndNothingElse) {
  const auto read = [](YamlMap* map) {
    for (const auto& [key, value] : map->Entries()) value.Number();
  };

  EXPECT_THAT(MessagesOf("{a: 1, b: -2.5, c: +3e-2, d: .5, e: '7'}", read), IsEmpty());
  EXPECT_THAT(MessagesOf("a: 0,12", read),
              StrEq("f.yaml:1:4: a = '0,12' is not a number"));
  EXPECT_THAT(MessagesOf("a: .nan", read),
              StrEq("f.yaml:1:4: a = '.nan' is not a number"));
  EXPECT_THAT(MessagesOf("a: inf", read),
              StrEq("f.yaml:1:4: a = 'inf' is not a number"));
  EXPECT_THAT(MessagesOf("a: +-3", read),
              StrEq("f.yaml:1:4: a = '+-3' is not a number"));
  EXPECT_THAT(MessagesOf("a: 0x10", read),
              StrEq("f.yaml:1:4: a = '0x10' is not a number"));
  EXPECT_THAT(MessagesOf("a: 1e999", read),
              StrEq("f.yaml:1:4: a = '1e999' is not a number"));
  EXPECT_THAT(MessagesOf("a: [1]", read),
              StrEq("f.yaml:1:4: a is a list, where a number is wanted"));
  EXPECT_THAT(MessagesOf("a:\nb: 1", read),
              StrEq("f.yaml:1:1: a is empty, where a number is wanted"));
}

TEST(YamlValue, PositiveAndNotNegativeSaySoInWords) {
  const auto read = [](YamlMap* map) {
    map->NumberOr("a", 1, kPositive);
    map->NumberOr("b", 1, kNotNegative);
  };

  EXPECT_THAT(MessagesOf("{a: 0, b: -1}", read),
              StrEq("f.yaml:1:5: a = 0 is not above 0\n"
                    "f.yaml:1:11: b = -1 is below 0"));
}

TEST(YamlValue, IntegerFlagAndWordSayWhatIsAllowed) {
  const auto read = [](YamlMap* map) {
    map->IntegerOr("n", 1, 1, 9);
    map->IntegerOr("m", 1, 1, 9);
    map->FlagOr("on", false);
    map->WordOr("fidelity", "fast", {"physics", "fast"});
  };

  EXPECT_THAT(MessagesOf("n: 10\nm: 1.5\non: yes\nfidelity: fats\n", read),
              StrEq("f.yaml:1:4: n = 10 is outside 1 .. 9\n"
                    "f.yaml:2:4: m = '1.5' is not a whole number\n"
                    "f.yaml:3:5: on = 'yes' is neither true nor false\n"
                    "f.yaml:4:11: fidelity = 'fats' is not known\n"
                    "  did you mean 'fast'? It may be: physics, fast"));
}

TEST(YamlValue, DistributionsAreReadAndChecked) {
  Faults faults;
  YamlMap map = ReadYamlText(
      "a: 2\nb: {normal: {mean: 1, sd: 0.5}}\n"
      "c: {uniform: {min: -1, max: 3}}\nd: {lognormal: {median: 0.05, factor: 2}}\n",
      "f.yaml",
      &faults);

  EXPECT_EQ(std::get<double>(map.Required("a")->NumberOrDistribution()), 2);
  EXPECT_EQ(std::get<Normal>(map.Required("b")->NumberOrDistribution()).sd, 0.5);
  EXPECT_EQ(std::get<Uniform>(map.Required("c")->NumberOrDistribution()).min, -1);
  EXPECT_EQ(std::get<LogNormal>(map.Required("d")->NumberOrDistribution()).factor, 2);
  EXPECT_TRUE(faults.empty());
}

TEST(YamlValue, WhatIsDrawnBeyondTheBoundsIsNoted) {
  Faults faults;
  YamlMap map = ReadYamlText(
      "a: {normal: {mean: 1, sd: 0.5}}\nb: {normal: {mean: 1, sd: 0.2}}\n"
      "c: {uniform: {min: 8, max: 10}}\nd: {lognormal: {median: 9, factor: 1.1}}\n",
      "f.yaml",
      &faults);
  for (const auto& [key, value] : map.Entries()) {
    value.NumberOrDistribution({0, 10});
    value.NumberOrDistribution({0, 10});
  }

  EXPECT_TRUE(faults.empty());
  EXPECT_THAT(
      faults.notes(),
      ElementsAre("f.yaml:1:4: a: 2.3 % of what this draws is below 0 and becomes 0",
                  "f.yaml:4:4: d: 13 % of what this draws is above 10 and becomes 10"));
}

TEST(YamlValue, AWrongDistributionIsExplained) {
  const auto read = [](YamlMap* map) {
    for (const auto& [key, value] : map->Entries()) value.NumberOrDistribution({0, 10});
  };

  EXPECT_THAT(MessagesOf("a: {gauss: {}}", read),
              StrEq("f.yaml:1:4: a is neither a number nor a distribution\n"
                    "  a distribution is one of {normal: {mean: , sd: }}, "
                    "{uniform: {min: , max: }}, {lognormal: {median: , factor: }}"));
  EXPECT_THAT(MessagesOf("a: {uniform: {min: 2, max: 1}}", read),
              StrEq("f.yaml:1:4: a has min 2 above max 1"));
  EXPECT_THAT(MessagesOf("a: {normal: {mean: 1, sigma: 1}}", read),
              StrEq("f.yaml:1:13: a.normal lacks the key 'sd'\n"
                    "f.yaml:1:23: a.normal has no key 'sigma'\n"
                    "  It knows: mean, sd"));
}

TEST(YamlValue, NumbersWantExactlyTheirCount) {
  const auto read = [](YamlMap* map) {
    map->Required("at_mm")->Numbers(3);
  };

  EXPECT_THAT(MessagesOf("at_mm: [1, 2]", read),
              StrEq("f.yaml:1:8: at_mm is not a list of 3 numbers"));
  EXPECT_THAT(MessagesOf("at_mm: [1, 2, x]", read),
              StrEq("f.yaml:1:15: at_mm[2] = 'x' is not a number"));
}

TEST(YamlMap, AnUnknownKeyIsAFaultWithTheNearestKnownOne) {
  const auto read = [](YamlMap* map) {
    map->NumberOr("friction_n", 0);
    map->NumberOr("gap_mm", 0);
    map->NoMoreKeys();
  };

  EXPECT_THAT(MessagesOf("fricton_n: 5", read),
              StrEq("f.yaml:1:1: this file has no key 'fricton_n'\n"
                    "  did you mean 'friction_n'? It knows: friction_n, gap_mm"));
  EXPECT_THAT(MessagesOf("zebra: 5", read),
              StrEq("f.yaml:1:1: this file has no key 'zebra'\n"
                    "  It knows: friction_n, gap_mm"));
}

TEST(YamlMap, OneMisspeltRequiredKeyIsOneFault) {
  const auto read = [](YamlMap* map) {
    map->Number("max_mm");
    map->NoMoreKeys();
  };

  EXPECT_THAT(MessagesOf("mx_mm: 300", read),
              StrEq("f.yaml:1:1: this file has no key 'mx_mm'\n"
                    "  did you mean 'max_mm'? It knows: max_mm"));
  EXPECT_THAT(MessagesOf("{}", read), StrEq("f.yaml:1:1: the key 'max_mm' is missing"));
}

// The key y is no misspelling of the missing x: it is asked for too.
TEST(YamlMap, AMissingKeyIsMissedBesideASimilarOne) {
  const auto read = [](YamlMap* map) {
    YamlMap axes = map->Required("axes")->Map();
    for (const char* axis : {"x1", "x2"}) axes.Number(axis);
    axes.NoMoreKeys();
  };

  EXPECT_THAT(MessagesOf("axes: {x2: 1}", read),
              StrEq("f.yaml:1:7: axes lacks the key 'x1'"));
}

TEST(YamlMap, EntriesKeepTheOrderOfTheFile) {
  Faults faults;
  YamlMap map = ReadYamlText("{z: 1, a: 2, m: 3}", "f.yaml", &faults);

  std::vector<std::string> keys;
  for (const auto& [key, value] : map.Entries()) keys.push_back(key);

  EXPECT_THAT(keys, ElementsAre("z", "a", "m"));
}

TEST(ReadYaml, AKeyTwiceIsAFault) {
  EXPECT_THAT(MessagesOf("a: 1\nb: {c: 1, c: 2}\n"),
              StrEq("f.yaml:2:11: the key 'c' stands twice"));
}

TEST(ReadYaml, QuotedTextIsPlainYaml) {
  EXPECT_THAT(MessagesOf("a: 'single'\nb: \"double\"\nc: |\n  block\n"), IsEmpty());
}

TEST(ReadYaml, AnchorsAliasesTagsAndSecondDocumentsAreRefused) {
  EXPECT_THAT(MessagesOf("a: &big [1, 2]\nb: *big\n"),
              StrEq("f.yaml:1:4: an anchor (&name) is not allowed: plain YAML only"));
  EXPECT_THAT(MessagesOf("a: !!str 1\n"),
              StrEq("f.yaml:1:4: the tag 'tag:yaml.org,2002:str' is not allowed: plain "
                    "YAML only"));
  EXPECT_THAT(MessagesOf("a: !mine {b: 1}\n"),
              StrEq("f.yaml:1:4: the tag '!mine' is not allowed: plain YAML only"));
  EXPECT_THAT(MessagesOf("a: 1\n---\nb: 2\n"),
              StrEq("f.yaml:2:1: a second document: one file holds one tree"));
}

TEST(ReadYaml, DeepNestingIsRefusedWhateverItsStyle) {
  std::string block;
  for (int depth = 0; depth < 40; ++depth) block += std::string(depth, ' ') + "a:\n";
  block += std::string(40, ' ') + "b: 1\n";

  EXPECT_THAT(MessagesOf("a: " + std::string(40, '[') + std::string(40, ']')),
              StrEq("f.yaml:1:35: nested deeper than 32 levels"));
  EXPECT_THAT(MessagesOf(block), StrEq("f.yaml:33:33: nested deeper than 32 levels"));
  EXPECT_THAT(MessagesOf("a: " + std::string(5000, '[')),
              StrEq("f.yaml:1:68: more than 64 brackets open at once"));
}

TEST(ReadYaml, BracketsInCommentsAreNoNesting) {
  std::string text = "a: 1\n";
  for (int line = 0; line < 100; ++line) text += "# the interval [0, 1)\n";

  EXPECT_THAT(MessagesOf(text), IsEmpty());
}

TEST(ReadYaml, WhatIsNoMappingIsRefused) {
  EXPECT_THAT(MessagesOf(""), StrEq("f.yaml:1:1: the file is empty"));
  EXPECT_THAT(MessagesOf("# only a comment\n"), StrEq("f.yaml:1:1: the file is empty"));
  EXPECT_THAT(MessagesOf("- a\n"),
              StrEq("f.yaml:1:1: the file is not a mapping of keys to values"));
  EXPECT_THAT(MessagesOf("a: [1, 2\n"),
              StrEq("f.yaml:2:1: this is not YAML: end of sequence flow not found"));
}

TEST(ReadYaml, NoiseIsRefused) {
  EXPECT_THAT(MessagesOf(std::string("a: 1\nb\0", 7)),
              StrEq("f.yaml:2:2: a zero byte: this is not a text file"));
  EXPECT_THAT(MessagesOf("a: \xff\n"),
              StrEq("f.yaml:1:4: this is not UTF-8 text\n  save the file as UTF-8"));
  EXPECT_THAT(MessagesOf(std::string(1'000'001, 'a')),
              StrEq("f.yaml: 1000001 bytes: larger than any file of this kind (at most "
                    "1000000)"));
  EXPECT_THAT(MessagesOf("a: " + std::string(20'000, 'b')),
              StrEq("f.yaml:1:10002: a line longer than 10000 characters"));
}

}  // namespace
}  // namespace caltwin
