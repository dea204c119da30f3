#include "calibration/diagnosis/free_form.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "sim/effects/drive.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr int kCosines = 10;
// Orders below 0: cosines are flat at both ends; what is not (a growth, a screw that
// runs away) they follow only far inside. A line and a bow carry the slopes there.
constexpr int kLine = -1, kBow = -2;

bool IsSense(const std::string& word) {
  return word.starts_with("dir_");
}

// One covariate's term of an order; order 0 is the constant.
double TermAt(const Covariate& covariate, double value, int order) {
  if (order == 0) return 1;
  if (IsSense(covariate.word)) return value;
  if (covariate.is_periodic) {
    const int turns = (order + 1) / 2;
    return order % 2 == 1 ? std::cos(turns * value) : std::sin(turns * value);
  }
  const double u = covariate.Scaled(value);
  if (order == kLine) return u;
  if (order == kBow) return 2 * u * u - 1;
  return std::cos(order * std::numbers::pi * (u + 1) / 2);
}

// The orders of a covariate that stands alone, but for a sense.
std::vector<int> OrdersOf(const Covariate& covariate) {
  std::vector<int> orders;
  if (!covariate.is_periodic && covariate.num_distinct > 2) orders.push_back(kLine);
  if (!covariate.is_periodic && covariate.num_distinct > 3) orders.push_back(kBow);
  const int most = std::clamp(covariate.num_distinct - 1, 1, kCosines);
  for (int order = 1; order <= most; ++order) orders.push_back(order);
  return orders;
}

// Of one of two, coarser. Products take a line, a bow and what a few places tell beside
// them; what also stands for each alone, the constant and cosines: a bed's plane is in
// the baseline, and a dent is no bow.
std::vector<int> OrdersBeside(const Covariate& covariate, TermsOfTwo which) {
  const auto most = static_cast<std::size_t>(std::max(covariate.num_distinct - 1, 1));
  if (which == TermsOfTwo::kAll) {
    std::vector<int> orders = {0, 1, 2, 3, 4};
    orders.resize(std::min(orders.size(), most + 1));
    return orders;
  }
  std::vector<int> orders =
      covariate.is_periodic ? std::vector{1, 2, 3, 4} : std::vector{kLine, kBow, 3, 4};
  orders.resize(std::min(orders.size(), most));
  return orders;
}

// Whether the first word makes, where the second does not vary, the axis' lost motion:
// that is the baseline's, and no form's.
bool IsLostMotion(const Observed& observed,
                  const std::string& channel,
                  const std::vector<std::string>& words) {
  return observed.machine().kind->axes_are_drives() && words.size() == 2 &&
         AxisNamed(channel) && words[0] == "dir_" + channel;
}

}  // namespace

std::vector<FreeTerm> TermsOf(const std::vector<Covariate>& covariates,
                              TermsOfTwo which) {
  std::vector<FreeTerm> terms;
  if (covariates.size() == 1) {
    if (IsSense(covariates[0].word)) return {{1, 0}};
    for (const int order : OrdersOf(covariates[0])) terms.push_back({order, 0});
    return terms;
  }
  // A sense multiplies the other's terms, the constant among them.
  if (IsSense(covariates[0].word)) {
    terms.push_back({1, 0});
    for (const int order : OrdersOf(covariates[1])) terms.push_back({1, order});
    return terms;
  }
  constexpr int kFinest = 5;  // Of both orders together.
  for (const int first : OrdersBeside(covariates[0], which)) {
    for (const int second : OrdersBeside(covariates[1], which)) {
      const int both = std::abs(first) + std::abs(second);
      if (both > 0 && both <= kFinest) terms.push_back({first, second});
    }
  }
  return terms;
}

double ProductAt(const FreeTerm& term,
                 const std::vector<Covariate>& covariates,
                 const std::vector<double>& values) {
  double product = TermAt(covariates[0], values[0], term.first);
  if (covariates.size() > 1) product *= TermAt(covariates[1], values[1], term.second);
  return product;
}

FreeForm FreeFormOf(const Observed& observed,
                    const std::string& channel,
                    const std::vector<std::string>& words,
                    int most_terms,
                    TermsOfTwo which) {
  FreeForm form{.channel = channel, .words = words};
  const Eigen::VectorXd shows = ChannelOf(observed, channel);
  if (shows.cwiseAbs().maxCoeff() < 0.1 || words.empty() || words.size() > 2) {
    return form;
  }
  std::vector<Covariate> covariates;
  for (const std::string& word : words) {
    auto covariate = CovariateOf(observed, word);
    if (!covariate) return form;
    covariates.push_back(std::move(*covariate));
  }
  std::vector<FreeTerm> terms = TermsOf(covariates, which);
  if (IsLostMotion(observed, channel, words)) {
    std::erase_if(terms, [](const FreeTerm& term) { return term.second == 0; });
  }
  if (static_cast<int>(terms.size()) > most_terms) {
    terms.resize(static_cast<std::size_t>(most_terms));
  }
  const auto num = static_cast<Eigen::Index>(terms.size());
  form.columns_mm.resize(observed.num_rows(), num);
  form.prior.resize(num);
  std::vector<double> at(covariates.size());
  for (Eigen::Index k = 0; k < num; ++k) {
    const FreeTerm& term = terms[static_cast<std::size_t>(k)];
    for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
      form.columns_mm(i, k) = 0;
      if (shows[i] == 0) continue;
      for (std::size_t c = 0; c < at.size(); ++c) at[c] = covariates[c].values[i];
      form.columns_mm(i, k) = shows[i] * ProductAt(term, covariates, at);
    }
    const double order = std::max(0, std::abs(term.first) + std::abs(term.second) - 1);
    form.prior[k] = 1 / (1 + order * order);
  }
  form.prior /= form.prior.sum();
  form.covariates = std::move(covariates);
  form.terms = std::move(terms);
  return form;
}

bool IsSliver(const Observed& observed, const std::string& word) {
  constexpr double kLeast_mm = 1;
  const auto axis = AxisNamed(word);
  if (!axis || !observed.machine().kind->axes_are_drives()) return false;
  double low_mm = HUGE_VAL, high_mm = -HUGE_VAL;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const double command_mm =
        observed.row(i).cmd_mm[static_cast<std::size_t>(Index(*axis))];
    if (!Known(command_mm)) continue;
    low_mm = std::min(low_mm, command_mm);
    high_mm = std::max(high_mm, command_mm);
  }
  return high_mm - low_mm < kLeast_mm;
}

namespace {

/// A channel, and the covariates of a form in it.
using ChannelAndWords = std::pair<std::string, std::vector<std::string>>;

// Of motors that are no axes: towers of a delta, screws under a bed.
std::vector<ChannelAndWords> BlocksOfMotors(const Machine& machine) {
  std::vector<ChannelAndWords> blocks;
  const auto add =
      [&](const std::string& name, const std::string& sense, const std::string& motor) {
        for (const std::string& word :
             {motor, sense, std::string("t"), std::string("temp")}) {
          blocks.push_back({name, {word}});
        }
        blocks.push_back({name, {sense, motor}});
      };
  for (const std::string_view motor : machine.kind->motors()) {
    add(std::string(motor), SenseCovariate(motor), DriveCovariate(motor));
  }
  return blocks;
}

}  // namespace

std::vector<FreeForm> AllFreeForms(const Observed& observed) {
  constexpr int kMostTerms = 20;
  std::vector<FreeForm> forms;
  const bool is_printer = observed.machine().kind->touches_with_nozzle();
  const std::vector<std::string> place = {"x", "y"};
  std::vector<std::string> slivers = {"x", "y", "z"};
  std::erase_if(slivers, [&](const auto& word) { return !IsSliver(observed, word); });
  const auto add = [&](const std::string& channel,
                       const std::vector<std::string>& words) {
    const bool is_height = channel == "bed" || channel == "z";
    const TermsOfTwo which = is_printer && is_height && words == place
                                 ? TermsOfTwo::kAll
                                 : TermsOfTwo::kProducts;
    const bool is_sliver = std::ranges::any_of(words, [&](const std::string& word) {
      return std::ranges::find(slivers, word) != slivers.end();
    });
    if (is_sliver) return;
    FreeForm form = FreeFormOf(observed, channel, words, kMostTerms, which);
    if (form.columns_mm.cols() > 0) forms.push_back(std::move(form));
  };
  const auto own = DiagnosedAs(observed.machine()).FreeForms();
  for (const auto& [channel, word] : own) add(channel, {word});
  if (!own.empty()) return forms;
  const std::array<std::string, 3> letters = {"x", "y", "z"};
  for (const std::string& channel : letters) {
    for (const std::string& other : letters) add(channel, {other});
    add(channel, {"x", "y"});
    add(channel, {"x", "z"});
    add(channel, {"y", "z"});
    const std::string sense = "dir_" + channel;
    for (const char* word : {"t", "temp", "feed", "load", "theta", "since_rev"}) {
      add(channel, {word});
      add(channel, {sense, word});
    }
    add(channel, {sense, channel});
    add(channel, {channel, "t"});
    add(channel, {channel, "temp"});
  }
  for (const auto& [motor, words] : BlocksOfMotors(observed.machine())) {
    add(motor, words);
  }
  for (const char* word : {"theta", "feed", "temp", "t", "x", "y", "z"}) {
    add("probe", {word});
  }
  add("probe", {"feed", "theta"});
  for (const char* word : {"x", "y", "t", "temp"}) add("bed", {word});
  add("bed", {"x", "y"});
  return forms;
}

}  // namespace caltwin
