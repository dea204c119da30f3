#include "calibration/facts/levelling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include <Eigen/Core>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/facts/cells.h"
#include "sim/base/dense.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

constexpr double kSure = 6;

/// Heights of one session, by place, its mean taken out: what levelling is to remove.
using Tilt = std::map<std::pair<long, long>, double>;

std::vector<Tilt> TiltsOf(const std::vector<const Row*>& rows,
                          const std::set<std::int64_t>& outliers,
                          std::vector<std::string>* homes) {
  std::map<std::string, std::map<std::pair<long, long>, std::pair<double, double>>>
      sums;
  for (const Row* row : rows) {
    const bool is_height = row->kind == RowKind::kTouch && row->n[2] > 0.999 &&
                           Known(row->cmd_mm[0]) && Known(row->cmd_mm[1]);
    if (!is_height || outliers.contains(row->row)) continue;
    if (!sums.contains(row->home)) homes->push_back(row->home);
    auto& [sum_mm, num] = sums[row->home][{std::lround(10 * row->cmd_mm[0]),
                                           std::lround(10 * row->cmd_mm[1])}];
    sum_mm += row->value_mm;
    num += 1;
  }
  std::vector<Tilt> tilts;
  for (const std::string& home : *homes) {
    Tilt tilt;
    double mean_mm = 0;
    for (const auto& [place, sum] : sums[home]) {
      tilt[place] = sum.first / sum.second;
      mean_mm += tilt[place] / static_cast<double>(sums[home].size());
    }
    for (auto& [place, height_mm] : tilt) height_mm -= mean_mm;
    tilts.push_back(std::move(tilt));
  }
  return tilts;
}

// Of what an alignment prints: left less right, as heights of two places.
std::vector<Tilt> TiltsOf(const std::vector<double>& differences_mm) {
  std::vector<Tilt> tilts;
  for (const double difference_mm : differences_mm) {
    tilts.push_back({{{0, 0}, difference_mm / 2}, {{1, 0}, -difference_mm / 2}});
  }
  return tilts;
}

/// How much of one round's tilt is there in the next.
struct Response {
  double factor = 0, sd = 0;
  int rounds = 0;
};

/// Squares of what rounds were to remove, and products with what was there after.
struct RoundSums {
  double match = 0, size = 0;
  int rounds = 0;

  std::optional<Response> ToResponse(double noise_mm) const {
    if (rounds == 0) return std::nullopt;
    const double factor = match / size;
    return Response{.factor = factor,
                    .sd = noise_mm * std::sqrt((1 + factor * factor) / size),
                    .rounds = rounds};
  }
};

std::optional<Response> ResponseOf(const std::vector<Tilt>& tilts,
                                   const std::vector<bool>& is_corrected,
                                   double noise_mm) {
  constexpr std::size_t kFewestPlaces = 2;
  constexpr double kTiltSigmas = 8;
  RoundSums sums;
  for (std::size_t k = 1; k < tilts.size(); ++k) {
    if (!is_corrected[k]) continue;
    double own = 0, both = 0;
    std::size_t num = 0;
    for (const auto& [place, height_mm] : tilts[k - 1]) {
      const auto after = tilts[k].find(place);
      if (after == tilts[k].end()) continue;
      own += height_mm * height_mm;
      both += height_mm * after->second;
      ++num;
    }
    // What is level already says nothing of the correction.
    if (num < kFewestPlaces || num != tilts[k - 1].size() ||
        std::sqrt(own) < kTiltSigmas * noise_mm) {
      continue;
    }
    sums.match += both;
    sums.size += own;
    ++sums.rounds;
  }
  return sums.ToResponse(noise_mm);
}

// By the corrections themselves, where touches lie too near together to show it: of
// what each round moves its motors by the next asks for `factor` times as much again.
std::optional<Response> ResponseOfMoves(const LevellingLog& levelling,
                                        double noise_mm) {
  constexpr std::size_t kFewestMotors = 3;
  constexpr double kMoveSigmas = 8;
  RoundSums sums;
  for (std::size_t k = 1; k < levelling.rounds.size(); ++k) {
    const std::vector<double>& before = levelling.rounds[k - 1].moved_mm;
    const std::vector<double>& now = levelling.rounds[k].moved_mm;
    if (before.size() < kFewestMotors || now.size() != before.size()) continue;
    double own = 0, both = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
      own += before[i] * before[i];
      both += before[i] * now[i];
    }
    if (std::sqrt(own) < kMoveSigmas * noise_mm) continue;
    sums.match += both;
    sums.size += own;
    ++sums.rounds;
  }
  return sums.ToResponse(noise_mm);
}

bool IsNear(const Response& response, double what) {
  constexpr double kAlike = 0.12;
  return std::abs(response.factor - what) < std::max(kAlike, 3 * response.sd);
}

Fact FactOf(const Response& response) {
  return {.id = "levelling",
          .figures = {{"factor", response.factor, response.sd},
                      {"rounds", static_cast<double>(response.rounds)}},
          .sigmas = std::abs(response.factor) / std::max(response.sd, 1e-9),
          .is_answer = true};
}

// "motor 1 and motor 2" of a pair, as the catalogue writes it.
std::string PairName(std::size_t one, std::size_t other) {
  return fmt::format("z{}z{}", one + 1, other + 1);
}

/// One round as its motors and its touches show it.
struct RoundShown {
  std::vector<double> moved_mm{};
  Tilt before{}, after{};
};

// Change of the heights' tilt by a rigid bed or gantry whose motors are at `pivots`.
Eigen::VectorXd Foretold(const RoundShown& round,
                         const std::vector<Eigen::Vector2d>& pivots_mm,
                         double sense) {
  const auto num = static_cast<Eigen::Index>(pivots_mm.size());
  Eigen::MatrixXd columns(num, 3);
  Eigen::VectorXd moved_mm(num);
  for (Eigen::Index m = 0; m < num; ++m) {
    const Eigen::Vector2d& at_mm = pivots_mm[static_cast<std::size_t>(m)];
    columns.row(m) << 1, at_mm[0], at_mm[1];
    moved_mm[m] = round.moved_mm[static_cast<std::size_t>(m)];
  }
  const Eigen::VectorXd plane = LeastSquares(columns, moved_mm);
  Eigen::VectorXd change_mm(static_cast<Eigen::Index>(round.before.size()));
  Eigen::Index i = 0;
  for (const auto& [place, height_mm] : round.before) {
    change_mm[i++] = sense * (plane[1] * static_cast<double>(place.first) / 10 +
                              plane[2] * static_cast<double>(place.second) / 10);
  }
  change_mm.array() -= change_mm.mean();
  return change_mm;
}

Eigen::VectorXd Seen(const RoundShown& round) {
  Eigen::VectorXd change_mm(static_cast<Eigen::Index>(round.before.size()));
  Eigen::Index i = 0;
  for (const auto& [place, height_mm] : round.before) {
    const auto after = round.after.find(place);
    change_mm[i++] =
        (after == round.after.end() ? height_mm : after->second) - height_mm;
  }
  return change_mm;
}

double Misses2(const std::vector<RoundShown>& rounds,
               const std::vector<Eigen::Vector2d>& pivots_mm,
               double sense) {
  double sum = 0;
  for (const RoundShown& round : rounds) {
    sum += (Seen(round) - Foretold(round, pivots_mm, sense)).squaredNorm();
  }
  return sum;
}

/// What a pivot must be moved by for the rounds to fit.
struct MovedPivot {
  std::size_t motor = 0;
  int axis = 0;
  double by_mm = 0, sd_mm = 0, misses2 = HUGE_VAL;
};

// Along one axis of one pivot at a time, the others as written; golden section.
MovedPivot BestPivot(const std::vector<RoundShown>& rounds,
                     const std::vector<Eigen::Vector2d>& pivots_mm,
                     double sense,
                     double noise_mm) {
  constexpr int kFarthest = 200;
  constexpr double kStep_mm = 1;
  MovedPivot best;
  for (std::size_t motor = 0; motor < pivots_mm.size(); ++motor) {
    for (int axis = 0; axis < 2; ++axis) {
      const auto misses2 = [&](double by_mm) {
        std::vector<Eigen::Vector2d> tried = pivots_mm;
        tried[motor][axis] += by_mm;
        return Misses2(rounds, tried, sense);
      };
      for (int step = -kFarthest; step <= kFarthest; ++step) {
        const double by_mm = step * kStep_mm;
        const double here2 = misses2(by_mm);
        if (here2 >= best.misses2) continue;
        const double bend =
            misses2(by_mm + kStep_mm) + misses2(by_mm - kStep_mm) - 2 * here2;
        best = {motor,
                axis,
                by_mm,
                noise_mm * std::sqrt(2.0) * std::sqrt(2 / std::max(bend, 1e-12)),
                here2};
      }
    }
  }
  return best;
}

class LevellingReader {
 public:
  LevellingReader(std::vector<RoundShown> rounds,
                  const LevellingLog& levelling,
                  double noise_mm,
                  Facts* facts)
      : rounds_(std::move(rounds)), noise_mm_(noise_mm), facts_(facts) {
    for (const auto& at_mm : levelling.pivots_mm)
      pivots_mm_.emplace_back(at_mm[0], at_mm[1]);
  }

  // Which of written, swapped and moved pivots the rounds fit; false: none is needed or
  // none fits.
  bool Name(const Response& response) {
    if (rounds_.empty() || pivots_mm_.size() < 2) return false;
    const double sense = Sense();
    const double noise2 = noise_mm_ * noise_mm_;
    const double written2 = Misses2(rounds_, pivots_mm_, sense);
    const double enough2 = kSure * kSure * noise2;
    if (written2 < enough2) return false;
    if (NameSwap(response, written2)) return true;
    const MovedPivot moved = BestPivot(rounds_, pivots_mm_, sense, noise_mm_);
    if (moved.misses2 > 0.25 * written2) return false;
    AddPivot(response, moved);
    return true;
  }

 private:
  // Whether a motor's + raises the reading or lowers it: what its corrections suppose.
  // Firmware corrects towards level, so a round's moves oppose the tilt it saw.
  double Sense() const {
    double match = 0;
    for (const RoundShown& round : rounds_) {
      Eigen::VectorXd tilt(static_cast<Eigen::Index>(round.before.size()));
      Eigen::Index i = 0;
      for (const auto& [place, height_mm] : round.before) tilt[i++] = height_mm;
      match += tilt.dot(Foretold(round, pivots_mm_, 1));
    }
    return match > 0 ? -1 : 1;
  }

  bool NameSwap(const Response& response, double written2) {
    for (std::size_t one = 0; one < pivots_mm_.size(); ++one) {
      for (std::size_t other = one + 1; other < pivots_mm_.size(); ++other) {
        std::vector<Eigen::Vector2d> swapped = pivots_mm_;
        std::swap(swapped[one], swapped[other]);
        constexpr double kFits = 0.1;
        if (Misses2(rounds_, swapped, Sense()) > kFits * written2) continue;
        Fact fact = FactOf(response);
        fact.cause = "motors_swapped";
        fact.cause_axis = PairName(one, other);
        fact.sentence = fmt::format(
            "Motors {} and {} are swapped: with their places exchanged the moves "
            "explain "
            "what the touches show ({} round{}), and as written each correction makes "
            "the "
            "tilt {:.2g} times as large. Exchange the two plugs, or their two lines in "
            "z_positions or M671",
            one + 1,
            other + 1,
            rounds_.size(),
            rounds_.size() == 1 ? "" : "s",
            response.factor);
        facts_->all.push_back(std::move(fact));
        return true;
      }
    }
    return false;
  }

  void AddPivot(const Response& response, const MovedPivot& moved) {
    Fact fact = FactOf(response);
    fact.cause = "pivot_position";
    fact.cause_axis = fmt::format("z{}", moved.motor + 1);
    fact.parameters = {{"dx_mm", moved.axis == 0 ? moved.by_mm : 0, moved.sd_mm},
                       {"dy_mm", moved.axis == 1 ? moved.by_mm : 0, moved.sd_mm}};
    const double written_mm = pivots_mm_[moved.motor][moved.axis];
    fact.sentence = fmt::format(
        "The pivot of motor {} is at {} {:.0f} mm, not at {:g} as it is written ({} mm "
        "off): "
        "so each round leaves {:.2g} of the tilt that it was to remove. With the true "
        "place "
        "one round is enough",
        moved.motor + 1,
        moved.axis == 0 ? "X" : "Y",
        written_mm + moved.by_mm,
        written_mm,
        WithSd(moved.by_mm, moved.sd_mm, ""),
        response.factor);
    facts_->all.push_back(std::move(fact));
  }

  std::vector<RoundShown> rounds_;
  std::vector<Eigen::Vector2d> pivots_mm_{};
  double noise_mm_;
  Facts* facts_;
};

std::vector<RoundShown> RoundsOf(const LevellingLog& levelling,
                                 const std::vector<Tilt>& tilts,
                                 const std::vector<std::string>& homes) {
  std::vector<RoundShown> rounds;
  for (const LevellingRound& round : levelling.rounds) {
    const auto at = std::ranges::find(homes, round.home);
    if (at == homes.end() || at == homes.begin()) continue;
    const auto k = static_cast<std::size_t>(at - homes.begin());
    const bool is_whole = tilts[k].size() == tilts[k - 1].size() &&
                          (levelling.pivots_mm.empty() ||
                           round.moved_mm.size() == levelling.pivots_mm.size());
    if (is_whole) rounds.push_back({round.moved_mm, tilts[k - 1], tilts[k]});
  }
  return rounds;
}

std::string RoundsInWords(const Response& response) {
  return fmt::format("{} round{}", response.rounds, response.rounds == 1 ? "" : "s");
}

// Each correction doubles the tilt.
void TellDoubled(const Response& response,
                 const LevellingLog& levelling,
                 Fact* fact,
                 Facts* facts) {
  fact->word = "doubles";
  const bool are_two = std::ranges::all_of(
      levelling.rounds,
      [](const LevellingRound& one) { return one.moved_mm.size() == 2; });
  if (are_two && !levelling.rounds.empty() && !levelling.is_by_hand) {
    fact->cause = "motors_swapped";
    fact->cause_axis = PairName(0, 1);
  }
  fact->sentence = fmt::format(
      "Each correction doubles the tilt ({}): right in size, wrong in sense. Two "
      "motors "
      "are swapped, or each moves the other way, or (screws turned by hand) the sense "
      "of "
      "the thread is set wrong",
      RoundsInWords(response));
  if (!levelling.is_by_hand) return;
  fact->sentence = fmt::format(
      "Each screw was turned as told, by the right amount and in the wrong sense: "
      "every "
      "deviation doubled ({}). The sense of the thread is set wrong: choose the other "
      "one "
      "(screw_thread: CCW-M4 in place of CW-M4); bed and probe are right",
      RoundsInWords(response));
  facts->not_the_machine = {"settings", fact->sentence};
  facts->all.push_back({.id = "settings",
                        .word = "screw_thread",
                        .sentence = fact->sentence,
                        .is_answer = false});
}

// Which of the sessions came after a correction.
std::vector<bool> CorrectedOf(const LevellingLog& levelling,
                              const std::vector<std::string>& homes,
                              std::size_t num) {
  if (!levelling.differences_mm.empty()) return std::vector<bool>(num, true);
  std::vector<bool> is_corrected(num, false);
  for (std::size_t k = 0; k < homes.size() && k < num; ++k) {
    is_corrected[k] =
        std::ranges::find(levelling.rounds, homes[k], &LevellingRound::home) !=
        levelling.rounds.end();
  }
  return is_corrected;
}

// Two motors on one line remove the tilt along that line, and no other.
void TellAcross(const LevellingLog& levelling, Facts* facts) {
  constexpr double kOnLine_mm = 1, kLeast_mrad = 0.3, kSigmas = 4;
  if (levelling.pivots_mm.size() != 2) return;
  const auto& [one_mm, other_mm] =
      std::pair(levelling.pivots_mm[0], levelling.pivots_mm[1]);
  for (std::size_t across = 0; across < 2; ++across) {
    if (std::abs(one_mm[across] - other_mm[across]) > kOnLine_mm) continue;
    const std::string key = across == 0 ? "slope_x_mrad" : "slope_y_mrad";
    const Fact* plane = facts->Find("plane");
    if (plane == nullptr) return;
    const auto slope = std::ranges::find(plane->figures, key, &FactFigure::key);
    if (slope == plane->figures.end() || std::abs(slope->value) < kLeast_mrad ||
        std::abs(slope->value) < kSigmas * slope->sd) {
      return;
    }
    const char along = across == 0 ? 'Y' : 'X', over = across == 0 ? 'X' : 'Y';
    facts->all.push_back(
        {.id = "levelling",
         .axis = kAxisNames[across],
         .word = "across",
         .figures = {*slope},
         .sigmas = std::abs(slope->value) / std::max(slope->sd, 1e-12),
         .sentence = fmt::format(
             "The two Z motors stand on one line along {0}: together they remove the "
             "tilt along {0}, and nothing of that along {1}, which is {2:.2f} mm over "
             "100 mm and stays however often they level. Take it out at the bed's own "
             "screws or spacers, or at the rails; probe and motors are in order",
             along,
             over,
             std::abs(slope->value) / 10),
         .is_answer = true});
    return;
  }
}

}  // namespace

void FactsOfLevelling(const std::vector<const Row*>& rows,
                      const Repeats& repeats,
                      const LevellingLog& levelling,
                      Facts* facts) {
  constexpr double kUsualNoise_mm = 0.01;
  TellAcross(levelling, facts);
  std::vector<std::string> homes;
  std::vector<Tilt> tilts = TiltsOf(rows, repeats.outliers, &homes);
  if (!levelling.differences_mm.empty()) tilts = TiltsOf(levelling.differences_mm);
  const bool is_levelling =
      !levelling.rounds.empty() || !levelling.differences_mm.empty();
  if (tilts.size() < 2 || !is_levelling) return;
  const double noise_mm =
      Known(repeats.noise.sd_mm) ? std::max(repeats.noise.sd_mm, 1e-3) : kUsualNoise_mm;
  auto response =
      ResponseOf(tilts, CorrectedOf(levelling, homes, tilts.size()), noise_mm);
  if (!response) response = ResponseOfMoves(levelling, noise_mm);
  if (!response) return;
  LevellingReader reader(RoundsOf(levelling, tilts, homes), levelling, noise_mm, facts);
  if (reader.Name(*response)) return;
  Fact fact = FactOf(*response);
  if (IsNear(*response, 1)) {
    fact.word = "no_effect";
    fact.sentence = fmt::format(
        "The tilt stays as it was after every correction ({}): the correction does not "
        "reach "
        "the motors one by one. Not the probe, not swapped motors (it would double), "
        "not "
        "wrong positions (it would change by a factor). Move each motor by itself and "
        "watch: a plug in the wrong socket, two motors on one driver, a driver that is "
        "off",
        RoundsInWords(*response));
  } else if (IsNear(*response, 2)) {
    TellDoubled(*response, levelling, &fact, facts);
  } else if (std::abs(response->factor) > 1) {
    fact.word = "diverges";
    fact.sentence = fmt::format(
        "Each correction makes the tilt {:.2g} times as large ({}): the places of the "
        "motors, as they are written, are wrong, or two are swapped",
        response->factor,
        RoundsInWords(*response));
  } else if (std::abs(response->factor) > std::max(0.05, kSure * response->sd)) {
    fact.word = "slow";
    fact.sentence = fmt::format(
        "Each round leaves {} of the tilt that it was to remove ({}): a pivot is {} "
        "than it "
        "is written. It still ends level, in more rounds",
        WithSd(response->factor, response->sd, ""),
        RoundsInWords(*response),
        response->factor < 0 ? "nearer to the others" : "further from the others");
  } else {
    fact.word = "right";
    fact.is_answer = false;
    fact.sentence = fmt::format("Levelling removes the tilt in one round ({})",
                                RoundsInWords(*response));
  }
  facts->all.push_back(std::move(fact));
}

}  // namespace caltwin
