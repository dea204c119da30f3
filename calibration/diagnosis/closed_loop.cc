#include "calibration/diagnosis/closed_loop.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/diagnosis/atlas.h"
#include "sim/base/require.h"
#include "sim/machine/machine_kind.h"
#include "sim/measure/plan_kinds.h"

namespace caltwin {
namespace {

constexpr double kPause_s = 600;
constexpr double kSecondsPerMinute = 60;
constexpr std::string_view kSettings = "closed_loop";

std::vector<std::string> CandidatesOf(const Diagnosis& diagnosis) {
  std::vector<std::string> names;
  for (const Finding& finding : diagnosis.findings) {
    for (const FindingCandidate& one : finding.candidates) {
      const bool matters = one.structural || one.probability > 0.05 ||
                           &one == &finding.candidates.front();
      const std::string name =
          one.axis.empty() ? one.cause : one.cause + "." + one.axis;
      if (matters && std::ranges::find(names, name) == names.end())
        names.push_back(name);
    }
  }
  return names;
}

// The campaign as the list of choices has it.
PlannedCampaign CampaignOf(const std::string& kind,
                           const std::map<std::string, std::string>& options) {
  for (const CampaignChoice& choice : CampaignChoices()) {
    if (choice.campaign.id == kind && choice.changed == options) return choice.campaign;
  }
  Require(false, "a diagnosis asks for a campaign that is on the list");
  return {};
}

bool IsOpen(const Diagnosis& diagnosis) {
  return diagnosis.next_campaign &&
         (diagnosis.verdict == DiagnosisVerdict::kAmbiguous ||
          diagnosis.verdict == DiagnosisVerdict::kUnknownStructure);
}

class Loop {
 public:
  Loop(const Machine& machine,
       const std::vector<Injected>& effects,
       const Measurer& measure,
       const ClosedLoopOptions& options)
      : machine_(machine), effects_(effects), measure_(measure), options_(options) {}

  // Measures one campaign more; its minutes, none if it could not be finished.
  std::optional<double> Measure(const LoopRound& round,
                                MeasuredSession* session) const {
    Plan plan{.seed = options_.seed + static_cast<std::uint64_t>(round.round),
              .instruments = session->header.instruments,
              .artefacts = session->header.artefacts,
              .campaigns = {CampaignOf(round.campaign, round.options)}};
    PlannedSession planned = PlanSession(plan, machine_, plan.seed);
    for (Row& row : planned.rows) row.settings = kSettings;
    planned.header.settings[std::string(kSettings)] = options_.settings;
    const double minutes = planned.duration_s / kSecondsPerMinute;
    const std::size_t already_read = session->table.rows.size();
    MeasuredSession longer = Continued(*session, std::move(planned), round.round);
    const std::size_t wanted = longer.table.rows.size();
    RowTable read = measure_(longer, already_read);
    if (read.rows.size() < wanted) return std::nullopt;
    longer.table.rows = std::move(read.rows);
    *session = std::move(longer);
    return minutes;
  }

  ClosedLoop Judge(LoopRound round,
                   MeasuredSession session,
                   std::vector<LoopRound> rounds) const {
    Observed observed(session.table, session.header, machine_, effects_);
    Diagnosis diagnosis = Diagnose(observed, options_.diagnose);
    round.rows = session.table.rows.size();
    round.verdict = diagnosis.verdict;
    round.candidates = CandidatesOf(diagnosis);
    if (options_.told) options_.told(round);
    rounds.push_back(std::move(round));
    return {.session = std::move(session),
            .rounds = std::move(rounds),
            .observed = std::move(observed),
            .diagnosis = std::move(diagnosis)};
  }

 private:
  const Machine& machine_;
  const std::vector<Injected>& effects_;
  const Measurer& measure_;
  const ClosedLoopOptions& options_;
};

}  // namespace

MeasuredSession Continued(MeasuredSession session, PlannedSession planned, int round) {
  std::vector<Row>& rows = session.table.rows;
  const bool has_times =
      std::ranges::all_of(rows, [](const Row& row) { return Known(row.t_s); });
  double start_s = 0;
  std::int64_t last_row = 0;
  for (const Row& row : rows) {
    if (Known(row.t_s)) start_s = std::max(start_s, row.t_s + kPause_s);
    last_row = std::max(last_row, row.row);
  }
  const std::string prefix = fmt::format("r{}.", round);
  for (Row row : planned.rows) {
    row.row = ++last_row;
    row.campaign = prefix + row.campaign;
    if (row.kind == RowKind::kTouch || !row.setup.empty()) {
      row.setup = row.setup.empty() ? row.campaign : prefix + row.setup;
    }
    row.home = prefix + row.home;
    row.t_s = has_times ? row.t_s + start_s : kUnknown;
    row.extra.resize(session.table.extra_columns.size());
    rows.push_back(std::move(row));
  }
  DataHeader& header = session.header;
  if (header.machine.empty()) header.machine = planned.header.machine;
  header.settings.merge(planned.header.settings);
  header.instruments.merge(planned.header.instruments);
  header.artefacts.merge(planned.header.artefacts);
  header.transmission.merge(planned.header.transmission);
  if (!header.tip_radius_mm) header.tip_radius_mm = planned.header.tip_radius_mm;
  for (const auto& [name, campaign] : planned.header.campaigns) {
    header.campaigns[prefix + name] = campaign;
  }
  return session;
}

namespace {

// The first kind that is made for such a machine.
std::string FirstCampaign(const Machine& machine) {
  const auto kinds = AllCampaignKinds();
  const auto first = std::ranges::find_if(kinds, [&](const CampaignKind& kind) {
    return kind.PlanOn(machine.kind) != nullptr &&
           (machine.kind->axes_are_drives() || kind.PlanOn(CartesianKind()) == nullptr);
  });
  Require(first != kinds.end(), "every machine can perform a campaign");
  return std::string(first->id);
}

}  // namespace

ClosedLoop MeasureUntilSettled(MeasuredSession session,
                               const Machine& machine,
                               const std::vector<Injected>& effects,
                               const Measurer& measure,
                               const ClosedLoopOptions& options) {
  const Loop loop(machine, effects, measure, options);
  LoopRound first;
  if (session.table.rows.empty()) {
    first = {.round = 1, .campaign = FirstCampaign(machine)};
    const auto minutes = loop.Measure(first, &session);
    if (minutes) first.minutes = *minutes;
  }
  ClosedLoop closed = loop.Judge(first, std::move(session), {});
  while (IsOpen(closed.diagnosis) &&
         closed.rounds.back().round < options.most_campaigns) {
    const NextCampaign& next = *closed.diagnosis.next_campaign;
    LoopRound round{.round = closed.rounds.back().round + 1,
                    .campaign = next.kind,
                    .options = next.options};
    const auto minutes = loop.Measure(round, &closed.session);
    if (!minutes) break;
    round.minutes = *minutes;
    closed = loop.Judge(
        std::move(round), std::move(closed.session), std::move(closed.rounds));
  }
  return closed;
}

std::string RoundText(const LoopRound& round) {
  std::vector<std::string> campaign = {round.campaign};
  for (const auto& [option, word] : round.options) {
    campaign.push_back(option + " " + word);
  }
  const std::string measured =
      round.campaign.empty()
          ? "the rows given"
          : fmt::format("{}, {:.0f} min", fmt::join(campaign, " "), round.minutes);
  const std::string candidates =
      round.candidates.empty()
          ? ""
          : fmt::format(" ({})", fmt::join(round.candidates, ", "));
  return fmt::format("Round {}: {}, {} rows in all: {}{}",
                     round.round,
                     measured,
                     round.rows,
                     ToString(round.verdict),
                     candidates);
}

nlohmann::ordered_json RoundsJson(const std::vector<LoopRound>& rounds) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const LoopRound& round : rounds) {
    list.push_back({{"round", round.round},
                    {"campaign",
                     round.campaign.empty() ? nlohmann::ordered_json(nullptr)
                                            : nlohmann::ordered_json(round.campaign)},
                    {"options", round.options},
                    {"minutes", round.minutes},
                    {"rows", round.rows},
                    {"verdict", ToString(round.verdict)},
                    {"candidates", round.candidates}});
  }
  return list;
}

}  // namespace caltwin
