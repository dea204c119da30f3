#include "calibration/procedures/plan_model.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace caltwin {
namespace {

constexpr double kTypicalTravel_mm = 100;  // To scale the columns to like units.

Axis MainAxis(const Face& face) {
  Eigen::Index i = 0;
  face.n.cwiseAbs().maxCoeff(&i);
  return kAxes[static_cast<std::size_t>(i)];
}

}  // namespace

double PlanModel::Sd_mm(const Face& face, int count) const {
  return MeanSd_mm(session_->probing().Noise(MainAxis(face)), count);
}

void PlanModel::AddRow(const Terms& terms, double sd) {
  Terms whitened;
  for (const auto& [name, value] : terms) whitened[name] = value / sd;
  rows_.push_back(whitened);
}

PlanModel::Terms PlanModel::TouchTerms(const Face& face,
                                       const std::string& setup) const {
  const Axis axis = MainAxis(face);
  const double n = face.n[Index(axis)];
  const double from_home_mm =
      face.at_mm[Index(axis)] - session_->bench().machine.axis(axis).home_mm();
  const double steps_per_mm = session_->Believed(Setting::kStepsPerMm, axis);
  return {{NameOf(Setting::kStepsPerMm, axis), from_home_mm * n / steps_per_mm},
          {"placement." + setup + "." + Name(axis), n},
          {NameOf(Setting::kDeflection, axis), -1},
          {NameOf(Setting::kBacklash, axis), -0.5},
          {"tip_size", 1}};
}

void PlanModel::AddTouch(const Face& face, int count, const std::string& setup) {
  AddRow(TouchTerms(face, setup), Sd_mm(face, count));
}

void PlanModel::AddTouchAt(const Face& face,
                           int count,
                           const std::string& setup,
                           double v_mm_s) {
  Terms terms = TouchTerms(face, setup);
  terms["trigger_latency"] = -v_mm_s;
  AddRow(terms, Sd_mm(face, count));
}

void PlanModel::AddRelease(const Face& face,
                           int count,
                           const std::string& setup,
                           double v_mm_s) {
  Terms terms = TouchTerms(face, setup);
  terms[NameOf(Setting::kBacklash, MainAxis(face))] = 0.5;
  terms["probe_hysteresis"] = 1;
  terms["trigger_latency"] = v_mm_s;
  AddRow(terms, Sd_mm(face, count));
}

void PlanModel::AddReading(Axis axis, double q_mm, int sense, double sd_mm) {
  const double from_home_mm = q_mm - session_->bench().machine.axis(axis).home_mm();
  const double steps_per_mm = session_->Believed(Setting::kStepsPerMm, axis);
  AddRow({{NameOf(Setting::kStepsPerMm, axis), -from_home_mm / steps_per_mm},
          {"placement.gauge." + Name(axis), 1},
          {NameOf(Setting::kBacklash, axis), -0.5 * sense}},
         sd_mm);
}

void PlanModel::AddKnown(const std::string& name, double sd) {
  AddRow({{name, 1}}, sd);
}

ObservabilityReport PlanModel::Report() const {
  std::set<std::string> names;
  for (const Terms& row : rows_) {
    for (const auto& [name, value] : row) names.insert(name);
  }
  std::vector<UnknownColumn> columns;
  for (const std::string& name : names) {
    UnknownColumn column{.name = name};
    if (name.starts_with("steps_per_mm.")) {
      const Axis axis = AxisNamed(name.substr(name.size() - 1)).value();
      column.mm_per_unit =
          kTypicalTravel_mm / session_->Believed(Setting::kStepsPerMm, axis);
    }
    columns.push_back(column);
  }
  Eigen::MatrixXd jacobian =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows_.size()),
                            static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    for (std::size_t j = 0; j < columns.size(); ++j) {
      const auto term = rows_[i].find(columns[j].name);
      if (term == rows_[i].end()) continue;
      jacobian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          term->second;
    }
  }
  return Observe(jacobian, columns);
}

namespace {

// "a + b only" and "a not at all", as Observe states them, as a sentence.
std::string BlindInWords(const std::string& statement) {
  constexpr std::string_view kOnly = " only";
  constexpr std::string_view kNotAtAll = " not at all";
  if (statement.ends_with(kNotAtAll)) {
    return fmt::format("It does not determine {}.",
                       statement.substr(0, statement.size() - kNotAtAll.size()));
  }
  if (!statement.ends_with(kOnly)) return statement + ".";
  const std::string sums = statement.substr(0, statement.size() - kOnly.size());
  return sums.find(" and ") == std::string::npos
             ? fmt::format("It determines {} as a whole, not its parts.", sums)
             : fmt::format("It determines {}, each as a whole, not their parts.", sums);
}

}  // namespace

std::string InWords(const ObservabilityReport& report) {
  std::vector<std::string> told;
  for (const std::string& name : report.determined) {
    if (!name.starts_with("placement.")) told.push_back(name);
  }
  std::vector<std::string> blind;
  for (const Observability& one : report.blind) {
    if (std::ranges::find(blind, one.statement) == blind.end()) {
      blind.push_back(one.statement);
    }
  }
  const std::string first =
      told.empty() ? "The plan determines nothing by itself"
                   : fmt::format("The plan determines {}", fmt::join(told, ", "));
  std::string text = first + ".";
  for (const std::string& statement : blind) text += " " + BlindInWords(statement);
  return text;
}

}  // namespace caltwin
