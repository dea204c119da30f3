#include "sim/measure/data_header.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/text_file.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::StrEq;

constexpr const char* kWhole =
    "format: 1\n"
    "machine: gantry_router\n"
    "settings:\n"
    "  s1: {steps_per_mm: {x: 808, z1: 400}, backlash_mm: {x: 0.05},\n"
    "       probe_deflection_mm: {y: -0.01}, tip_radius_mm: 1}\n"
    "instruments: {laser: {sigma_um: 0.5, resolution_um: 0.1, u_um: 0.3}}\n"
    "campaigns: {c1: {instrument: laser, plan: {iso230: {axis: x, runs: 5}}}}\n"
    "artefacts:\n"
    "  block25: {type: block, sizes_mm: [25.4, 50.8, 76.2], u_um: 0.5,\n"
    "            expansion_per_k: 1.15e-5}\n"
    "transmission: {x: {lead_mm: 4, full_steps_per_mm: 50}, a: {pulley_mm_per_rev: "
    "40}}\n"
    "tip_radius_mm: 1.5\n";

std::string MessagesOf(const std::string& text) {
  try {
    ParseDataHeader(text, "d.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(DataHeader, EveryKeyIsRead) {
  const DataHeader header = ParseDataHeader(kWhole, "d.yaml");

  EXPECT_EQ(header.machine, "gantry_router");
  const SettingsInForce& settings = header.settings.at("s1");
  EXPECT_THAT(settings.steps_per_mm, ElementsAre(Pair("x", 808), Pair("z1", 400)));
  EXPECT_EQ(settings.backlash_mm.at("x"), 0.05);
  EXPECT_EQ(settings.probe_deflection_mm.at("y"), -0.01);
  EXPECT_EQ(settings.tip_radius_mm, 1);
  EXPECT_EQ(header.instruments.at("laser").kind, "laser");
  EXPECT_EQ(header.instruments.at("laser").u_um, 0.3);
  EXPECT_EQ(header.campaigns.at("c1").instrument, "laser");
  EXPECT_EQ(header.campaigns.at("c1").plan, "iso230");
  EXPECT_EQ(header.campaigns.at("c1").options.at("runs"), "5");
  EXPECT_THAT(header.artefacts.at("block25").sizes_mm, ElementsAre(25.4, 50.8, 76.2));
  EXPECT_EQ(header.artefacts.at("block25").expansion_per_k, 1.15e-5);
  EXPECT_EQ(header.transmission.at("x").full_steps_per_mm, 50);
  EXPECT_EQ(header.transmission.at("a").pulley_mm_per_rev, 40);
  EXPECT_EQ(header.tip_radius_mm, 1.5);
  EXPECT_THAT(header.remarks, IsEmpty());
}

TEST(DataHeader, WhatWasWrittenReadsTheSame) {
  const std::string text = DataHeaderText(ParseDataHeader(kWhole, "d.yaml"));

  EXPECT_EQ(DataHeaderText(ParseDataHeader(text, "d.yaml")), text);
  for (const char* kept : {"gantry_router",
                           "808",
                           "0.3",
                           "runs",
                           "76.2",
                           "1.15e-05",
                           "pulley_mm_per_rev",
                           "1.5"}) {
    EXPECT_THAT(text, ::testing::HasSubstr(kept));
  }
}

TEST(DataHeader, EveryKeyIsOptional) {
  EXPECT_THAT(MessagesOf("format: 1\n"), IsEmpty());
}

TEST(DataHeader, FreeWordsAreReportedAndKept) {
  const DataHeader header = ParseDataHeader(
      "instruments: {t: {kind: lazer}}\n"
      "campaigns: {c: {plan: {figure_of_eight: {}}}}\n"
      "artefacts: {g: {type: granite, sizes_mm: [1, 2, 3, 4]}}\n",
      "d.yaml");

  EXPECT_THAT(header.remarks,
              ElementsAre("instrument 't': the kind 'lazer' is not known; did you mean "
                          "'laser'?",
                          "campaign 'c': the plan 'figure_of_eight' is not known",
                          "artefact 'g': the type 'granite' is not known"));
  EXPECT_EQ(header.campaigns.at("c").plan, "figure_of_eight");
  EXPECT_EQ(header.artefacts.at("g").sizes_mm.size(), 4u);
}

TEST(DataHeader, EverythingElseIsStrict) {
  EXPECT_THAT(
      MessagesOf("instrumets: {}\nartefacts: {p: {type: plate, sizes_mm: [1]}}\n"
                 "transmission: {q: {}, x: {lead_mm: 4, pulley_mm_per_rev: 4}}\n"
                 "campaigns: {c: {plan: {iso230: {}, ring: {}}}}\n"),
      StrEq("d.yaml:4:23: campaigns.c.plan does not name one kind of plan\n"
            "  for example {iso230: {axis: x}}\n"
            "d.yaml:2:40: artefacts.p.sizes_mm has 1 sizes\n"
            "  plate has [x y]\n"
            "d.yaml:3:19: transmission.q is no axis, tower or screw\n"
            "  it may be: x, y, z, a, b, c, z1, z2, z3\n"
            "d.yaml:3:26: transmission.x has both lead_mm and pulley_mm_per_rev\n"
            "  a screw has a lead, a belt a pulley: keep one\n"
            "d.yaml:1:1: this file has no key 'instrumets'\n"
            "  did you mean 'instruments'? It knows: artefacts, campaigns, "
            "format, instruments, machine, settings, tip_radius_mm, "
            "transmission"));
}

TEST(HeaderOf, StandsBesideTheRows) {
  const auto folder = std::filesystem::path(::testing::TempDir());
  WriteTextFile(folder / "caltwin_h.yaml", "machine: m\n");

  EXPECT_EQ(HeaderOf(folder / "caltwin_h.csv").machine, "m");
  EXPECT_EQ(HeaderOf(folder / "caltwin_none.csv").machine, "");
  EXPECT_EQ(HeaderOf(folder / "caltwin_h.yaml").machine, "");
  std::filesystem::remove(folder / "caltwin_h.yaml");
}

TEST(Unexplained, NamesWhatTheRowsNameAndTheHeaderDoesNot) {
  const DataHeader header = ParseDataHeader(kWhole, "d.yaml");
  RowTable table;
  table.rows.push_back({.campaign = "c1", .settings = "s1", .feature = "block25.left"});
  EXPECT_THAT(Unexplained(table, header), IsEmpty());

  table.rows.push_back({.campaign = "c2", .settings = "s2", .feature = "bed.top"});
  table.rows.push_back(table.rows.back());
  EXPECT_THAT(Unexplained(table, header),
              ElementsAre("the header does not explain the artefact 'bed'",
                          "the header does not explain the campaign 'c2'",
                          "the header does not explain the settings 's2'"));
  EXPECT_THAT(Unexplained(table, {}), IsEmpty());
}

}  // namespace
}  // namespace caltwin
