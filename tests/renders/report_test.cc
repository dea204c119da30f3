#include "renders/report.h"

#include <cstddef>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "renders/html.h"
#include "renders/sections/sections.h"
#include "sim/base/text_file.h"
#include "tests/renders/sample_result.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::size_t Count(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + 1)) {
    ++count;
  }
  return count;
}

TEST(Report, NamesEveryParameterWithItsNumbers) {
  const RunResult result = SampleResult();

  const std::string html = ReportHtml(result, {});

  for (const ParameterResult& parameter : result.parameters) {
    EXPECT_THAT(html, HasSubstr("<code>" + parameter.name + "</code>"));
  }
  EXPECT_THAT(html, HasSubstr("<td class=\"number\">800.011</td>"));
  EXPECT_THAT(html, HasSubstr("<td class=\"number\">+0.011</td>"));
}

TEST(Report, ShowsErrorsOfMillimetresInMicrometres) {
  const std::string html = VerdictSection(SampleResult(), {});

  EXPECT_THAT(html, HasSubstr("<td class=\"number\">-0.30&nbsp;µm</td>"));
}

TEST(Report, SaysTheExpandedUncertaintyAndWhatItIsMadeOf) {
  RunResult result = SampleResult();
  result.parameters.at(1).budget = {{.input = "hysteresis", .u = 3e-4, .dof = 10},
                                    {.input = "readings", .u = 4e-4}};
  const std::string html = UncertaintySection(result, {});

  // Welch and Satterthwaite: 5^4 / (3^4 / 10) = 77, whose t is 1.99.
  EXPECT_THAT(html,
              AllOf(HasSubstr("readings 64 %, hysteresis 36 %"),
                    HasSubstr("<td class=\"number\">1.99</td>"),
                    HasSubstr("<td class=\"number\">77</td>"),
                    HasSubstr("not taken apart")));
  EXPECT_THAT(html, Not(HasSubstr("probe_pretravel.z")));  // Cannot be told.
  EXPECT_EQ(UncertaintySection({}, {}), "");
}

TEST(Report, SaysWhatCannotBeTold) {
  EXPECT_THAT(VerdictSection(SampleResult(), {}), HasSubstr("cannot be told"));
}

TEST(Report, SaysARepeatedMessageOnce) {
  const RunResult result{.messages = {"a", "b", "a"}};

  EXPECT_THAT(MeaningSection(result, {}),
              HasSubstr("<ul>\n<li>a (2 times)</li>\n<li>b</li>\n</ul>\n"));
}

// What a message is for decides where it stands, not its words.
TEST(Report, GroupsMessagesByWhatTheyAreFor) {
  using enum Message::Kind;
  const RunResult result{.messages = {{"tighten it", kToDo},
                                      {"x: 2. reversal", kCheck},
                                      {"the gap reads 0.05 mm", kFound},
                                      MachineSaid("ok")}};

  const std::string html = MeaningSection(result, {});

  const auto found = html.find("<h3>What was found</h3>\n<ul>\n<li>the gap");
  const auto to_do = html.find("<h3>What to do</h3>\n<ul>\n<li>tighten it");
  const auto check = html.find("<summary>What was verified (1)</summary>");
  EXPECT_THAT(html, HasSubstr("<h3>What the machine said</h3>\n<ul>\n<li>ok</li>"));
  EXPECT_LT(found, to_do);
  EXPECT_LT(to_do, check);
  EXPECT_NE(check, std::string::npos);
  EXPECT_EQ(MeaningSection({}, {}), "");
}

TEST(Report, SaysItsVerdictInASentenceFirst) {
  const std::string html = ReportHtml(SampleResult(), {});

  const auto verdict = html.find("<strong>Passed. The calibration recovered what was");
  EXPECT_LT(verdict, html.find("<section"));
}

TEST(Report, HasEverySectionAndItsAnchor) {
  const std::string html =
      ReportHtml(SampleResult(),
                 {.pictures = {{.title = "Before", .caption = "c", .png = "x"}},
                  .playback = "<p>Played.</p>"});

  for (const Section& section : AllSections()) {
    EXPECT_THAT(html, HasSubstr("<section id=\"" + std::string(section.id) + "\""));
    EXPECT_THAT(html, HasSubstr("href=\"#" + std::string(section.id) + "\""));
  }
}

TEST(Report, LeavesOutSectionsWithNothingToShow) {
  const std::string html = ReportHtml({}, {});

  EXPECT_THAT(html, Not(HasSubstr("id=\"pictures\"")));
  EXPECT_THAT(html, Not(HasSubstr("id=\"readings\"")));
  EXPECT_THAT(html, Not(HasSubstr("id=\"meaning\"")));
}

/// A result whose every text tries to become markup.
RunResult Hostile() {
  const std::string attack = "</script></pre><script>alert(1)</script>\"'><img src=x>";
  RunResult result = SampleResult();
  result.scenario = result.about = result.verbatim = result.machine = attack;
  result.outcome = result.fidelity = attack;
  result.messages = {attack};
  for (ParameterResult& parameter : result.parameters) {
    parameter.name = parameter.unit = attack;
  }
  for (Step& step : result.steps) {
    step.procedure = step.variant = step.name = step.message = attack;
  }
  for (CheckResult& check : result.checks) {
    check.name = check.expected = check.found = attack;
  }
  result.observability = {{.statement = attack, .blind_direction = {{attack, 1.0}}}};
  for (Row& row : result.rows.rows) row.feature = row.settings = attack;
  return result;
}

TEST(Report, LetsNoTextOfAScenarioBecomeMarkup) {
  const RunResult hostile = Hostile();
  const ReportPictures pictures{{{.title = hostile.about, .caption = hostile.about}}};

  const std::string html = ReportHtml(hostile, pictures);

  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(html, Not(HasSubstr("<img src=x")));
  EXPECT_EQ(Count(html, "<script"), 0);
  EXPECT_EQ(Count(html, "</script"), 0);
}

TEST(Report, KeepsDataInItsScriptElement) {
  const nlohmann::json json = {{"label", "</script><!--"}, {"bad", "\xff"}};

  const std::string text = JsonForScript(json);

  EXPECT_THAT(text, Not(HasSubstr("<")));
  EXPECT_THAT(text, Not(HasSubstr(">")));
  EXPECT_EQ(nlohmann::json::parse(text)["label"], "</script><!--");
}

TEST(Report, LoadsNothingFromElsewhere) {
  const std::string html =
      ReportHtml(SampleResult(), {{{.title = "Before", .caption = "c", .png = "x"}}});

  EXPECT_THAT(html, HasSubstr("default-src 'none'"));
  EXPECT_THAT(html, Not(HasSubstr("<link")));
  EXPECT_THAT(html, Not(HasSubstr("@import")));
  EXPECT_THAT(html, Not(HasSubstr("url(")));
  EXPECT_EQ(Count(html, " src=\""), Count(html, " src=\"data:image/png;base64,"));
  EXPECT_EQ(Count(html, " href=\""), Count(html, " href=\"#"));
}

TEST(Report, IsTheSameForTheSameResult) {
  EXPECT_EQ(ReportHtml(SampleResult(), {}), ReportHtml(SampleResult(), {}));
}

TEST(Report, DoesNotDependOnHowLongTheComputerTook) {
  RunResult slow = SampleResult();
  slow.cpu_s = 99;

  EXPECT_EQ(ReportHtml(slow, {}), ReportHtml(SampleResult(), {}));
}

TEST(Report, SaysTheCommandThatMakesItAgain) {
  RunResult result = SampleResult();
  result.scenario = "my tests/it's.yaml";
  result.seed = 12;

  EXPECT_THAT(ProvenanceSection(result, {}),
              HasSubstr(Escaped("caltwin run 'my tests/it'\\''s.yaml' "
                                "--fidelity physics --seed 12")));
}

TEST(Report, IsWrittenAsIndexHtml) {
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / "caltwin_report_test";

  WriteReport(SampleResult(), {}, folder);

  EXPECT_EQ(ReadTextFile(folder / "index.html", 1 << 20),
            ReportHtml(SampleResult(), {}));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace caltwin
