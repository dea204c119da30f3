#include "calibration/diagnosis/candidates.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/diagnosis/drawn.h"
#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "sim/base/units.h"
#include "sim/effects/predict.h"

namespace caltwin {
namespace {

// Small against every unit, so that forms with a sine are still straight.
constexpr double kSmall = 1e-3;
constexpr double kNothing_mm = 1e-12;
constexpr const char* kHoming = "homing_scatter";

struct Roles {
  std::vector<std::size_t> sizes{};  ///< All of one unit.
  std::optional<std::size_t> phase{};
  std::vector<std::size_t> forms{};
};

Roles RolesOf(const Effect& effect) {
  Roles roles;
  for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
    switch (effect.parameters[i].role) {
      case Role::kSize:
        roles.sizes.push_back(i);
        break;
      case Role::kPhase:
        roles.phase = i;
        break;
      case Role::kForm:
        roles.forms.push_back(i);
    }
  }
  return roles;
}

Injected UnitOf(const Observed& o,
                int effect,
                const std::string& axis,
                const std::vector<double>& forms,
                double phase_deg,
                std::size_t which_size = 0) {
  const Roles roles = RolesOf(EffectAt(effect));
  Injected unit = NeutralEffect(effect, axis, o.machine());
  for (std::size_t i = 0; i < roles.forms.size(); ++i) {
    unit.values[roles.forms[i]] = forms[i];
  }
  if (roles.phase) unit.values[*roles.phase] = phase_deg;
  if (!roles.sizes.empty()) unit.values[roles.sizes[which_size]] = kSmall;
  return unit;
}

// One column for every homing session.
Eigen::MatrixXd HomingColumns(const Observed& o, const std::string& axis) {
  std::vector<std::string> homes;
  for (const Row& row : o.table().rows) {
    if (std::ranges::find(homes, row.home) == homes.end()) homes.push_back(row.home);
  }
  const Eigen::VectorXd shows = ChannelOf(o, axis);
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(o.num_rows(), static_cast<Eigen::Index>(homes.size()));
  if (homes.size() < 3) return {};
  for (Eigen::Index i = 0; i < o.num_rows(); ++i) {
    const auto home = std::ranges::find(homes, o.row(i).home) - homes.begin();
    columns(i, home) = shows[i];
  }
  return columns;
}

// The middle of a size's prior, whichever sign it has, in its own unit.
double UsualSize(const Effect& effect, const Roles& roles) {
  struct Size {
    double operator()(double value) const { return std::abs(value); }
    double operator()(const Normal& n) const { return std::hypot(n.mean, n.sd); }
    double operator()(const Uniform& u) const {
      return std::max(std::abs(u.min), std::abs(u.max)) / 2;
    }
    double operator()(const LogNormal& l) const { return l.median; }
  };
  return std::visit(Size{}, effect.parameters[roles.sizes[0]].prior);
}

double PeakOf(const Eigen::MatrixXd& columns) {
  return columns.cols() == 0 ? 0 : Peak_mm(columns.rowwise().norm());
}

std::vector<std::string> AxesOf(const Observed& o, const Effect& effect) {
  const auto axes = AxesOn(effect, o.machine().kind);
  if (axes.empty() || axes[0] != kAnyAxis) return {axes.begin(), axes.end()};
  std::set<std::string> ids;
  for (Eigen::Index i = 0; i < o.num_rows(); ++i) {
    // Only what has a size can have another.
    const std::string id(o.at(i).artefact);
    if (!id.empty() && id != "bed" && IsDrawn(o.header(), id)) {
      ids.emplace(o.at(i).artefact);
    }
  }
  return {ids.begin(), ids.end()};
}

// Time causes need times, waves more positions than a wave has ways to fit them.
bool CanTell(const Observed& o, const Effect& effect, const Shown& shown) {
  constexpr int kPositionsOfWave = 8;
  for (const std::string& word : shown.covariates) {
    if (word == "t" && !o.has_times() && effect.name != kHoming) return false;
    if (effect.sight->harmonics == 0 || word.starts_with("dir_")) continue;
    const auto covariate = CovariateOf(o, word);
    if (!covariate || covariate->num_distinct < kPositionsOfWave) return false;
  }
  return true;
}

// What shows in three rows or fewer cannot be told from outliers.
bool ReachesFew(const Observed& o, const Variant& variant) {
  const Eigen::Index few = DiagnosedAs(o.machine()).FewRows();
  const Eigen::VectorXd size = variant.columns_mm.rowwise().norm();
  return (size.array() > 0.3 * size.maxCoeff()).count() <= few;
}

// All forms of a grid are alike likely, but the period of a wave: a screw or pulley has
// the lead it was drawn with, unless the drawing is wrong. Heights at few places fit
// other periods as well.
void WeighForms(const Machine& machine, Candidate* candidate) {
  constexpr double kAsDrawn = 0.8;
  const Effect& effect = EffectAt(candidate->effect);
  std::vector<double> values(effect.parameters.size(), 0), drawn;
  effect.neutral(machine, candidate->axis, values);
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (effect.parameters[k].role == Role::kForm) drawn.push_back(values[k]);
  }
  std::vector<Variant>& variants = candidate->variants;
  const auto as_drawn = std::ranges::find(variants, drawn, &Variant::forms);
  if (effect.sight->harmonics == 0 || as_drawn == variants.end()) return;
  const auto num_others = static_cast<double>(variants.size() - 1);
  if (num_others > 0) as_drawn->weight = kAsDrawn / (1 - kAsDrawn) * num_others;
}

std::optional<Candidate> CandidateOf(const Observed& o,
                                     int index,
                                     const std::string& axis,
                                     const Extent& extent) {
  const Effect& effect = EffectAt(index);
  Candidate candidate{.effect = index,
                      .cause = std::string(effect.name),
                      .axis = axis,
                      .shown = ShownOn(effect, axis, o.machine().kind)};
  if (!CanTell(o, effect, candidate.shown)) return std::nullopt;
  const Roles roles = RolesOf(effect);
  candidate.must_be_positive = roles.sizes.size() == 1 && !roles.phase &&
                               effect.parameters[roles.sizes[0]].min >= 0 &&
                               effect.name != kHoming;
  std::vector<std::vector<double>> grid = {{}};
  if (effect.sight->forms != nullptr) {
    grid = effect.sight->forms(o.machine(), axis, extent);
  }
  for (const std::vector<double>& forms : grid) {
    Variant variant = VariantOf(o, index, axis, forms);
    if (variant.columns_mm.cols() == 0 || ReachesFew(o, variant)) continue;
    candidate.variants.push_back(std::move(variant));
  }
  if (candidate.variants.empty()) return std::nullopt;
  WeighForms(o.machine(), &candidate);
  return candidate;
}

Candidate FreeCandidate(FreeForm form) {
  Candidate candidate{.cause = "unknown",
                      .axis = form.channel,
                      .shown = {form.channel, form.words},
                      .free_prior = form.prior,
                      .free_terms = form.terms};
  candidate.variants.push_back({.columns_mm = std::move(form.columns_mm)});
  return candidate;
}

// Whether nothing but senses and axes that stood still could show it.
bool VariesWithSlivers(const Observed& observed, const Candidate& candidate) {
  if (EffectAt(candidate.effect).sight->shows_at_rest) return false;
  const auto& words = candidate.shown.covariates;
  const auto is_still = [&](const std::string& word) {
    return word.starts_with("dir_") || IsSliver(observed, word);
  };
  const auto is_sliver = [&](const std::string& word) {
    return IsSliver(observed, word);
  };
  return std::ranges::any_of(words, is_sliver) && std::ranges::all_of(words, is_still);
}

}  // namespace

std::string Candidate::Name() const {
  if (is_free())
    return fmt::format("unknown.{}{{{}}}", axis, fmt::join(shown.covariates, ","));
  return axis.empty() ? cause : cause + "." + axis;
}

bool IsRigid(const Candidate& candidate) {
  if (candidate.is_free()) return false;
  const std::vector<double> any(EffectAt(candidate.effect).parameters.size(), 1);
  return !TurnsOf({.effect = candidate.effect, .axis = candidate.axis, .values = any})
              .empty();
}

double Peak_mm(const Eigen::VectorXd& change_mm) {
  const double most = change_mm.cwiseAbs().maxCoeff();
  if (most < kNothing_mm) return 0;
  std::vector<double> reached;
  for (const double value : change_mm) {
    if (std::abs(value) > 1e-3 * most) reached.push_back(std::abs(value));
  }
  const auto at =
      static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(reached.size() - 1));
  std::nth_element(reached.begin(), reached.begin() + at, reached.end());
  return reached[static_cast<std::size_t>(at)];
}

Variant VariantOf(const Observed& observed,
                  int effect,
                  const std::string& axis,
                  const std::vector<double>& forms) {
  Variant variant{.forms = forms};
  if (EffectAt(effect).name == kHoming) {
    variant.columns_mm = HomingColumns(observed, axis);
    variant.size_per_mm = UmFromMm(1.0);
    return PeakOf(variant.columns_mm) > kNothing_mm ? variant : Variant{};
  }
  const Roles roles = RolesOf(EffectAt(effect));
  const std::size_t num = roles.phase ? 2 : roles.sizes.size();
  Eigen::MatrixXd columns(observed.num_rows(), static_cast<Eigen::Index>(num));
  for (std::size_t k = 0; k < num; ++k) {
    const Injected unit =
        roles.phase ? UnitOf(observed, effect, axis, forms, k == 0 ? 0.0 : 90.0)
                    : UnitOf(observed, effect, axis, forms, /*phase_deg=*/0, k);
    columns.col(static_cast<Eigen::Index>(k)) = observed.Change_mm(unit);
  }
  const double peak_mm = PeakOf(columns);
  if (peak_mm < kNothing_mm) return {};
  variant.columns_mm = columns / peak_mm;
  variant.size_per_mm = kSmall / peak_mm;
  variant.usual_mm = UsualSize(EffectAt(effect), roles) / variant.size_per_mm;
  return variant;
}

std::vector<Candidate> AllCandidates(const Observed& observed) {
  // All free forms together weigh half a family, and three nats less.
  constexpr double kHandicap_nats = 3;
  const Extent extent = observed.ExtentOf();
  std::vector<Candidate> candidates;
  int num_families = 0;
  for (int index = 0; index < static_cast<int>(kNumEffects); ++index) {
    const Effect& effect = EffectAt(index);
    if (!effect.sight) continue;
    std::vector<Candidate> family;
    for (const std::string& axis : AxesOf(observed, effect)) {
      auto candidate = CandidateOf(observed, index, axis, extent);
      if (!candidate || VariesWithSlivers(observed, *candidate)) continue;
      family.push_back(std::move(*candidate));
    }
    if (family.empty()) continue;
    ++num_families;
    for (Candidate& candidate : family) {
      candidate.log_prior = -std::log(static_cast<double>(family.size()));
      candidates.push_back(std::move(candidate));
    }
  }
  std::vector<FreeForm> forms = AllFreeForms(observed);
  for (FreeForm& form : forms) {
    candidates.push_back(FreeCandidate(std::move(form)));
    candidates.back().log_prior =
        std::log(0.5 / static_cast<double>(forms.size())) - kHandicap_nats;
  }
  for (Candidate& candidate : candidates) {
    candidate.log_prior -= std::log(num_families + 0.5);
  }
  return candidates;
}

Injected ValuesOf(const Observed& observed,
                  const Candidate& candidate,
                  const Variant& variant,
                  const Eigen::VectorXd& sizes_mm) {
  const Effect& effect = EffectAt(candidate.effect);
  const Roles roles = RolesOf(effect);
  Injected values =
      UnitOf(observed, candidate.effect, candidate.axis, variant.forms, 0);
  double size = sizes_mm[0] * variant.size_per_mm;
  if (effect.name == kHoming) {
    size = std::sqrt(sizes_mm.squaredNorm() / static_cast<double>(sizes_mm.size())) *
           variant.size_per_mm;
  } else if (roles.phase) {
    size = sizes_mm.norm() * variant.size_per_mm;
    double phase_deg = DegFromRad(std::atan2(sizes_mm[1], sizes_mm[0]));
    if (phase_deg < 0) phase_deg += 360;
    values.values[*roles.phase] = phase_deg;
  }
  for (std::size_t k = 0; k < roles.sizes.size(); ++k) {
    if (k > 0) size = sizes_mm[static_cast<Eigen::Index>(k)] * variant.size_per_mm;
    const Parameter& parameter = effect.parameters[roles.sizes[k]];
    values.values[roles.sizes[k]] = std::clamp(size, parameter.min, parameter.max);
  }
  return values;
}

}  // namespace caltwin
