#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "calibration/kinds/triple_z/printer.h"
#include "calibration/loop/bench.h"
#include "tools/commands/api/seat.h"
#include "tools/commands/kinds/bed_store.h"
#include "tools/server/events.h"
#include "tools/server/routes.h"

namespace caltwin {

/// The bed of a triple-Z printer over REST: the published calibration routes of a
/// scanner with three Z motors (`/api/calibration/...`; docs/rest.md says where its
/// samples contradict its formulas). Routes that move the printer are slow and take its
/// seat; what was found is kept in a file.
class BedApi {
 public:
  struct Options {
    std::filesystem::path store{};  ///< Where it keeps what it finds; empty: nowhere.
    std::string machine{};          ///< Its name.
  };

  /// All but the options are borrowed.
  BedApi(TripleZPrinter* printer,
         const Options& options,
         OperatorSeat* seat,
         EventTopic* events);

  void AddTo(Routes* routes);
  /// The same routes where there is no such bed, all answered by `refusal`.
  static void Refuse(Routes* routes, const Handler& refusal);
  /// What was read at the start and is no store of ours; empty: nothing.
  const std::string& note() const { return note_; }

 private:
  struct Asked {
    std::vector<Eigen::Vector2d> at_mm{};
    std::vector<BedTouch> given{};  ///< Heights that the client knows.
    double reference_mm = 10;
    bool uses_printer = true;
  };

  struct Served {
    const char* method;
    const char* path;
    Route::Pace pace;
    HttpResponse (BedApi::*answer)(const HttpRequest& request);
  };
  static constexpr std::size_t kMostPoints = 400;  ///< Of one request.

  static std::span<const Served> AllServed();
  static Route RouteOf(const Served& served, Handler handler);
  void ForgetWhatHomingUndid();
  HttpResponse Intrinsics(const HttpRequest& request);
  HttpResponse SetIntrinsics(const HttpRequest& request);
  HttpResponse Probe(const HttpRequest& request);
  HttpResponse Calibrate(const HttpRequest& request);
  HttpResponse Current(const HttpRequest& request);
  HttpResponse History(const HttpRequest& request);
  HttpResponse Status(const HttpRequest& request);
  HttpResponse Apply(const HttpRequest& request);
  HttpResponse Abort(const HttpRequest& request);
  HttpResponse Validate(const HttpRequest& request);
  HttpResponse Report(const HttpRequest& request);

  /// Touches where asked, fits, keeps, answers.
  HttpResponse Find(const HttpRequest& request, const Asked& asked);
  std::vector<BedTouch> TouchAll(const std::vector<Eigen::Vector2d>& at_mm);
  void RequireReachable(const Vec3<double>& raised_mm) const;
  /// In words what the numbers mean; notes whether the bed is level.
  std::vector<std::string> NotesOf(BedFound* found) const;
  std::string WhyAppliedFailed(const BedFound& found) const;
  /// Puts a change into the store and onto the disk, one after another.
  void Change(const std::function<void(BedStore*)>& change);
  void Show(BedStore store);
  BedStore store() const;

  static constexpr double kLevelEnough_mm = 0.02;  ///< Between screws.

  TripleZPrinter* printer_;
  Options options_;
  OperatorSeat* seat_;
  EventTopic* events_;
  std::string note_{};
  std::mutex writing_{};
  mutable std::mutex mutex_{};  ///< Of what follows.
  int homings_ = 0;             ///< At the last look, or when something was applied.
  Vec3<double> raised_mm_ = Vec3<double>::Zero();  ///< At the last look.
  BedStore store_{};
  std::string current_{};  ///< As `current` answers.
};

/// The bed of the machine on that bench; null where it stands on no three screws.
std::unique_ptr<BedApi> BedApiOn(Bench* bench,
                                 const BedApi::Options& options,
                                 OperatorSeat* seat,
                                 EventTopic* events);

}  // namespace caltwin
