#include "calibration/diagnosis/free_form.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sim/effects/drive.h"

namespace caltwin {
namespace {

constexpr int kTermsAlone = 10;
constexpr int kTermsOfTwo = 4;

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
  const double u = (covariate.Scaled(value) + 1) / 2;
  return std::cos(order * std::numbers::pi * u);
}

int NumTerms(const Covariate& covariate, int most) {
  if (IsSense(covariate.word)) return 1;
  return std::clamp(covariate.num_distinct - 1, 1, most);
}

}  // namespace

std::vector<FreeTerm> TermsOf(const std::vector<Covariate>& covariates,
                              TermsOfTwo which) {
  std::vector<FreeTerm> terms;
  if (covariates.size() == 1) {
    for (int k = 1; k <= NumTerms(covariates[0], kTermsAlone); ++k) {
      terms.push_back({k, 0});
    }
    return terms;
  }
  // A sense multiplies the other's terms, the constant among them.
  const bool has_sense = IsSense(covariates[0].word);
  const bool has_all = !has_sense && which == TermsOfTwo::kAll;
  const int most = has_sense ? kTermsAlone : kTermsOfTwo;
  for (int k = has_all ? 0 : 1; k <= NumTerms(covariates[0], most); ++k) {
    for (int l = has_sense || has_all ? 0 : 1; l <= NumTerms(covariates[1], most);
         ++l) {
      if (k + l > 0 && k + l <= most + 1) terms.push_back({k, l});
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
  if (static_cast<int>(terms.size()) > most_terms) {
    terms.resize(static_cast<std::size_t>(most_terms));
  }
  const auto num = static_cast<Eigen::Index>(terms.size());
  form.columns_mm.resize(observed.num_rows(), num);
  form.prior.resize(num);
  for (Eigen::Index k = 0; k < num; ++k) {
    const FreeTerm& term = terms[static_cast<std::size_t>(k)];
    for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
      std::vector<double> at;
      for (const Covariate& covariate : covariates) at.push_back(covariate.values[i]);
      form.columns_mm(i, k) = shows[i] * ProductAt(term, covariates, at);
    }
    const double order = std::max(0, term.first + term.second - 1);
    form.prior[k] = 1 / (1 + order * order);
  }
  form.prior /= form.prior.sum();
  form.covariates = std::move(covariates);
  form.terms = std::move(terms);
  return form;
}

std::vector<FreeForm> AllFreeForms(const Observed& observed) {
  constexpr int kMostTerms = 20;
  std::vector<FreeForm> forms;
  const bool is_printer = observed.machine().kinematics != Kinematics::kCartesian;
  const std::vector<std::string> place = {"x", "y"};
  const auto add = [&](const std::string& channel,
                       const std::vector<std::string>& words) {
    const bool is_height = channel == "bed" || channel == "z";
    const TermsOfTwo which = is_printer && is_height && words == place
                                 ? TermsOfTwo::kAll
                                 : TermsOfTwo::kProducts;
    FreeForm form = FreeFormOf(observed, channel, words, kMostTerms, which);
    if (form.columns_mm.cols() > 0) forms.push_back(std::move(form));
  };
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
  if (observed.machine().delta) {
    for (const std::string tower : {"a", "b", "c"}) {
      const std::string sense = "dir_" + tower;
      for (const std::string& word :
           {"motor_" + tower, sense, std::string("t"), std::string("temp")}) {
        add(tower, {word});
      }
      add(tower, {sense, "motor_" + tower});
    }
  }
  if (observed.machine().triple_z) {
    for (const std::string_view screw : kScrewAxes) {
      const std::string name(screw), sense = SenseCovariate(screw);
      const std::string motor = DriveCovariate(screw);
      for (const std::string& word :
           {motor, sense, std::string("t"), std::string("temp")}) {
        add(name, {word});
      }
      add(name, {sense, motor});
    }
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
