#include "sim/measure/csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::StrEq;

std::vector<std::vector<std::string>> Split(const std::string& text) {
  Faults faults;
  CsvReader reader(text, "f.csv", &faults);
  std::vector<std::vector<std::string>> records;
  while (const auto record = reader.Next()) {
    auto& fields = records.emplace_back();
    for (const CsvField& field : *record) fields.push_back(field.text);
  }
  faults.ThrowIfAny();
  return records;
}

std::string MessagesOf(const std::string& text) {
  try {
    Split(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Csv, SplitsAtCommasAndLineEnds) {
  const auto expected =
      ElementsAre(ElementsAre("a", "b", ""), ElementsAre("", "c", "d"));

  EXPECT_THAT(Split("a,b,\n,c,d\n"), expected);
  EXPECT_THAT(Split("a,b,\n,c,d"), expected);
  EXPECT_THAT(Split("a,b,\r\n,c,d\r\n"), expected);
  EXPECT_THAT(Split("\xEF\xBB\xBF a ,\tb,\n , c,d "), expected);
  EXPECT_THAT(Split("\n\na,b,\n   \n,c,d\n\n"), expected);
}

TEST(Csv, QuotedFieldsHoldAnything) {
  EXPECT_THAT(
      Split("\"a,\"\"b\"\"\", \" c \" ,\"\"\n\"two\nlines\",\"#\"\n"),
      ElementsAre(ElementsAre("a,\"b\"", " c ", ""), ElementsAre("two\nlines", "#")));
}

TEST(Csv, CommentsAreKeptApart) {
  Faults faults;
  CsvReader reader("# one\na,b\n  #two \n#\nc,#d\n", "f.csv", &faults);

  EXPECT_EQ(reader.Next()->at(1).text, "b");
  EXPECT_EQ(reader.Next()->at(1).text, "#d");
  EXPECT_FALSE(reader.Next().has_value());
  EXPECT_THAT(reader.comments(), ElementsAre("one", "two", ""));
}

TEST(Csv, EveryFieldKnowsItsPlace) {
  Faults faults;
  CsvReader reader("a,\"two\nlines\", c\n# x\nd", "f.csv", &faults);

  const auto first = *reader.Next();
  const auto second = *reader.Next();

  EXPECT_EQ(first[1].line, 1);
  EXPECT_EQ(first[1].column, 3);
  EXPECT_EQ(first[2].line, 2);
  EXPECT_EQ(first[2].column, 9);
  EXPECT_EQ(second[0].line, 4);
  EXPECT_EQ(second[0].column, 1);
}

TEST(Csv, AQuoteGoneWrongIsAFaultAtItsPlace) {
  EXPECT_THAT(MessagesOf("a,b\nc,\"d\n"),
              StrEq("f.csv:2:3: a quote that is never closed"));
  EXPECT_THAT(MessagesOf("a,\"b\"c\nd\n"),
              StrEq("f.csv:1:6: text after the closing quote\n"
                    "  a quote inside a quoted field is written twice"));
}

TEST(Csv, WhatIsQuotedIsReadBack) {
  for (const std::string text : {"plain",
                                 "",
                                 "a,b",
                                 "\"",
                                 "a\"b",
                                 " blank",
                                 "tab\t",
                                 "#5",
                                 "two\nlines",
                                 "a\rb"}) {
    EXPECT_THAT(Split(CsvQuoted(text) + ",end\n"),
                ElementsAre(ElementsAre(text, "end")))
        << text;
  }
}

}  // namespace
}  // namespace caltwin
