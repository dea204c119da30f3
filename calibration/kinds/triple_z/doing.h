#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/kinds/triple_z/procedures.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {

/// A procedure on its way: what it said and did.
class Doing {
 public:
  Doing(std::string name, const TripleZOptions& options, TripleZPrinter* printer)
      : name_(std::move(name)),
        variant_(options.is_as_published ? "as_published" : "corrected"),
        printer_(printer),
        touches_before_(printer->touches()) {}

  void Say(Message message) { done_.result.messages.push_back(std::move(message)); }
  void SayAll(const std::vector<std::string>& lines) {
    for (const std::string& line : lines) Say(line);
  }
  void Step(const std::string& quantity,
            double before,
            double after,
            Verdict verdict,
            const std::string& message,
            int iteration = 1) {
    done_.result.steps.push_back({.procedure = name_,
                                  .variant = variant_,
                                  .iteration = iteration,
                                  .name = quantity,
                                  .before = before,
                                  .after = after,
                                  .verdict = verdict,
                                  .message = message});
  }
  void StepScrews(const Vec3<double>& before_mm,
                  const Vec3<double>& after_mm,
                  Verdict verdict,
                  const std::string& message,
                  int iteration) {
    for (int i = 0; i < kNumScrews; ++i) {
      Step("screw_offset." + ScrewName(i),
           before_mm[i],
           after_mm[i],
           verdict,
           message,
           iteration);
    }
  }
  void Refuse(const std::string& why) {
    Say({why, Message::Kind::kCause});
    done_.result.ending = Ending::kRefused;
  }
  void Confess(const std::string& statement, std::map<std::string, double> direction) {
    done_.result.observability.push_back({statement, std::move(direction)});
    done_.result.ending = Ending::kConfounded;
  }
  void Correlate(std::vector<std::string> names, const Eigen::MatrixXd& covariance) {
    done_.result.correlations.push_back(
        CorrelationsOf(name_, std::move(names), covariance));
  }
  void Fail(const MachineFault& fault) {
    done_.result.fault = fault.reply;
    done_.result.ending = EndingOfFault(fault);
    Say(MachineSaid(fault.reply));
  }
  /// The value, or nullopt and the fault noted.
  template <typename T>
  std::optional<T> Got(Expected<T> value) {
    if (value) return *std::move(value);
    Fail(value.error());
    return std::nullopt;
  }
  bool Did(const Expected<void>& done) {
    if (!done) Fail(done.error());
    return done.has_value();
  }

  TripleZResult& done() { return done_; }
  TripleZResult Take() {
    done_.result.touches = printer_->touches() - touches_before_;
    return std::move(done_);
  }

 private:
  std::string name_;
  std::string variant_;
  TripleZPrinter* printer_;
  int touches_before_;
  TripleZResult done_{};
};

/// The places that the options ask for.
std::vector<Eigen::Vector2d> PointsOf(const TripleZPrinter& printer,
                                      const TripleZOptions& options);

/// The plane of the bed as it stands, reported where it is the first; nullopt: a fault.
std::optional<BedPlane> ProbePlane(TripleZPrinter* printer,
                                   const TripleZOptions& options,
                                   Doing* doing,
                                   std::vector<BedTouch>* touches);

/// Whether no screw would be moved by more than `largest_mm`; else it is refused.
bool IsSmallEnough(const Vec3<double>& raise_mm,
                   const TripleZOptions& options,
                   Doing* doing);

/// Touches at every stand of single screws, each back where it was; nullopt: a fault.
std::optional<std::vector<RaisedTouches>> TryScrews(TripleZPrinter* printer,
                                                    const TripleZOptions& options,
                                                    Doing* doing);

std::string WordsOfLevel(const LevelReport& report);

/// Where the options ask for it: touches the middles of the grid's cells, none of which
/// was fitted, and reports how far they are from `expected`. false: a fault.
bool HoldOut(TripleZPrinter* printer,
             const TripleZOptions& options,
             const BedPlane& expected,
             Doing* doing);

/// The plane z = level.
BedPlane LevelPlane(double level_mm);

/// A direction half of one and half of the other.
std::map<std::string, double> AlongBoth(const std::string& one, const std::string& two);

}  // namespace caltwin
