#pragma once

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace caltwin {

/// Fisher information of phases 2 to 4 on one axis, from the touches alone: unknowns
/// are steps (as scale error), gap, pre-travel, tip, hysteresis, latency and the places
/// of the block as it is laid. First principles, not the estimators' formulas.
class FisherOfTouches {
 public:
  enum Unknown { kScale, kGap, kPretravel, kTip, kHysteresis, kLatency, kPlaces };
  static constexpr int kNumUnknowns = kPlaces + 3;

  void AddTouches(int count, int place, double sense, double size_mm, double v_mm_s) {
    Eigen::VectorXd row = Row(place, sense, size_mm);
    row[kGap] = -0.5;
    row[kLatency] = -v_mm_s;
    Add(row, count);
  }
  void AddReleases(int count, int place, double sense, double size_mm, double v_mm_s) {
    Eigen::VectorXd row = Row(place, sense, size_mm);
    row[kGap] = 0.5;
    row[kLatency] = v_mm_s;
    row[kHysteresis] = 1;
    Add(row, count);
  }
  void AddKnown(int unknown, double sd) {
    information_(unknown, unknown) += 1 / (sd * sd);
  }

  double Bound(int unknown) const {
    const Eigen::MatrixXd covariance = information_.ldlt().solve(
        Eigen::MatrixXd::Identity(kNumUnknowns, kNumUnknowns));
    return std::sqrt(covariance(unknown, unknown));
  }

 private:
  static Eigen::VectorXd Row(int place, double sense, double size_mm) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(kNumUnknowns);
    row[kScale] = -size_mm / 2;  // Faces `size` apart, each moving by half.
    row[kPretravel] = -1;
    row[kTip] = 1;
    row[kPlaces + place] = sense;
    return row;
  }
  void Add(const Eigen::VectorXd& row, int count) {
    constexpr double kSigma_mm = 0.001, kStep_mm = 0.00125;
    const double variance_mm2 = kSigma_mm * kSigma_mm + kStep_mm * kStep_mm / 12;
    information_ += count / variance_mm2 * row * row.transpose();
  }

  Eigen::MatrixXd information_ = Eigen::MatrixXd::Zero(kNumUnknowns, kNumUnknowns);
};

inline constexpr int kRepeats = 10;
inline constexpr double kSmall_mm = 27.4,
                        kLarge_mm = 78.2;  // With the ball's diameter.

/// Phase 2, of which steps/mm are made. Those of the verifications are kept apart, and
/// later phases find the steps set: all touches together would tell them better.
inline void AddPhase2(FisherOfTouches* fisher) {
  for (const double sense : {-1.0, 1.0}) {
    fisher->AddTouches(kRepeats, 0, sense, kSmall_mm, 1);
    fisher->AddTouches(kRepeats, 1, sense, kLarge_mm, 1);
  }
}

/// Phases 2 to 4, of which backlash and pre-travel are made.
inline void AddPhases(FisherOfTouches* fisher) {
  AddPhase2(fisher);
  for (const double sense : {-1.0, 1.0}) {
    for (const double v_mm_s : {1.0, 5.0}) {
      fisher->AddTouches(kRepeats, 2, sense, kLarge_mm, v_mm_s);
      fisher->AddReleases(kRepeats, 2, sense, kLarge_mm, v_mm_s);
    }
    fisher->AddTouches(kRepeats, 0, sense, kSmall_mm, 1);
  }
}

inline void AddKnown(FisherOfTouches* fisher) {
  fisher->AddKnown(FisherOfTouches::kTip, 0.001);
  fisher->AddKnown(FisherOfTouches::kHysteresis, 0.0005);
  // Not told, and not needed, by one feed and no release.
  for (const int unknown : {+FisherOfTouches::kGap,
                            +FisherOfTouches::kLatency,
                            FisherOfTouches::kPlaces + 2}) {
    fisher->AddKnown(unknown, 1);
  }
}

}  // namespace caltwin
