// What BedApi says of what it knows and found.

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "calibration/kinds/triple_z/troubles.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "tools/commands/kinds/bed_api.h"
#include "tools/commands/kinds/bed_report.h"
#include "tools/server/json_keys.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kWellLevelled_mm = 0.1;  // The published target of a validation.

}  // namespace

HttpResponse BedApi::Current(const HttpRequest& /*request*/) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!current_.empty()) return {.body = current_};
  return Problem(404,
                 "no bed was measured yet",
                 {{.detail = "nothing is stored",
                   .hint = "POST /api/calibration/bed-tilt/calibrate measures it"}})
      .Response();
}

HttpResponse BedApi::History(const HttpRequest& /*request*/) {
  Json tree{{"calibrations", Json::array()}};
  const BedStore kept = store();
  for (auto one = kept.found.rbegin(); one != kept.found.rend(); ++one) {
    tree["calibrations"].push_back(ToJson(*one));
  }
  return JsonResponse(tree);
}

HttpResponse BedApi::Status(const HttpRequest& /*request*/) {
  const TripleZBench& bench = printer_->bench();
  Json screws = Json::array();
  const BedStore kept = store();
  Vec3<double> raised_mm;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    raised_mm = raised_mm_;
  }
  for (int i = 0; i < kNumScrews; ++i) {
    const auto& at_mm = bench.drawn_mm[static_cast<std::size_t>(i)];
    screws.push_back({{"name", ScrewName(i)},
                      {"at_mm", {at_mm[0], at_mm[1]}},
                      {"raised_mm", raised_mm[i]},
                      {"applied_mm", kept.applied_mm ? (*kept.applied_mm)[i] : 0.0}});
  }
  Json tree{{"machine", options_.machine},
            {"travel_mm", {bench.most_mm[0], bench.most_mm[1]}},
            {"top_mm", bench.top_mm},
            {"screws", std::move(screws)},
            {"is_measured", !kept.found.empty()},
            {"is_applied", kept.applied_mm.has_value()}};
  const auto sitter = seat_->sitter();
  tree["held_by"] = sitter ? Json(sitter->name) : Json();
  tree["doing"] = sitter ? Json(sitter->doing) : Json();
  return JsonResponse(tree);
}

// In words what the numbers mean, and whether another round helps.
std::vector<std::string> BedApi::NotesOf(BedFound* kept) const {
  const BedFound& found = *kept;
  const double sigma_mm = printer_->bench().sigma_mm;
  std::vector<std::string> notes = PlaneVerdicts(found.plane);
  if (const auto off = WhyOffPlane(found.touches, Unsuspected_mm(printer_->bench()))) {
    notes.push_back(found.is_by_printer ? TouchAgain(printer_, *off, found.touches)
                                        : off->words());
  }
  if (const std::string why = WhyAppliedFailed(found); !why.empty())
    notes.push_back(why);
  const double most_mm = found.offsets_mm.maxCoeff();
  const double noise_mm = std::max(Residual_mm(found), sigma_mm);
  kept->is_level = most_mm < std::max(2 * noise_mm, kLevelEnough_mm);
  if (found.is_level) {
    notes.push_back(
        fmt::format("the bed is level: over the screws it differs by {:.3f} mm, where "
                    "the touches scatter by {:.3f} and {:.2f} is good; another round "
                    "would gain nothing",
                    most_mm,
                    noise_mm,
                    kLevelEnough_mm));
  } else {
    notes.push_back(
        fmt::format("raise the screws by {:.3f}, {:.3f} and {:.3f} mm: the lowest "
                    "corner comes up to "
                    "the highest, {:.3f} mm of tilt between the screws go",
                    found.offsets_mm[0],
                    found.offsets_mm[1],
                    found.offsets_mm[2],
                    most_mm));
  }
  return notes;
}

// The bed over each screw now against where it was when what was applied was worked
// out.
std::string BedApi::WhyAppliedFailed(const BedFound& found) const {
  const BedStore before = store();
  const bool is_comparable = found.is_by_printer && before.applied_mm.has_value() &&
                             !before.found.empty() && before.found.back().is_by_printer;
  if (!is_comparable) return "";
  return WhyNotLevel(
      *before.applied_mm, before.found.back().plane, found.plane, printer_->bench());
}

HttpResponse BedApi::Validate(const HttpRequest& request) {
  const Json body = JsonBody(request);
  JsonKeys keys(body);
  const auto points = keys.Tuples("test_points", 3, 1, kMostPoints);
  keys.Done();
  const BedStore kept = store();
  if (kept.found.empty()) {
    throw Problem(409,
                  "there is no plane to hold points against",
                  {{.detail = "no bed was measured yet",
                    .hint = "POST /api/calibration/bed-tilt/calibrate measures it"}});
  }
  const BedPlane plane = PlaneNow(kept, printer_->bench().drawn_mm);
  std::vector<BedTouch> off;
  double common_mm = 0;
  for (const auto& point : points) {
    const Eigen::Vector2d at_mm(point[0], point[1]);
    off.push_back({at_mm, point[2] - plane.At_mm(at_mm)});
    common_mm += off.back().height_mm / static_cast<double>(points.size());
  }
  const LevelReport level = ReportLevel(off, /*level_mm=*/0);
  const LevelReport about_common = ReportLevel(off, common_mm);
  Json notes = Json::array();
  if (std::abs(common_mm) > kWellLevelled_mm &&
      about_common.mean_mm < std::abs(common_mm) / 4) {
    notes.push_back(fmt::format(
        "all points lie {:.3f} mm {} the plane: they are heights over another zero, "
        "not "
        "tilt; without that common part they are off by {:.3f} mm in the mean",
        std::abs(common_mm),
        common_mm > 0 ? "above" : "below",
        about_common.mean_mm));
  }
  return JsonResponse(
      {{"status", "success"},
       {"mean_error_mm", level.mean_mm},
       {"max_error_mm", level.max_mm},
       {"std_error_mm", level.std_mm},
       {"num_points", level.count},
       {"mean_signed_error_mm", common_mm},
       {"mean_error_about_common_mm", about_common.mean_mm},
       {"is_within_target", level.mean_mm < kWellLevelled_mm},
       {"plane_equation", {{"a", plane.a()}, {"b", plane.b()}, {"c", plane.c_mm()}}},
       {"notes", std::move(notes)}});
}

HttpResponse BedApi::Report(const HttpRequest& request) {
  const BedStore kept = store();
  if (request.Prefers("application/json", "text/html")) {
    Json tree{{"machine", options_.machine},
              {"intrinsics", ToJson(kept.camera)},
              {"calibrations", Json::array()}};
    for (const BedFound& found : kept.found)
      tree["calibrations"].push_back(ToJson(found));
    tree["applied"] = kept.applied_mm ? ScrewsToJson(*kept.applied_mm) : Json();
    return JsonResponse(tree);
  }
  return PageResponse(
      BedReportHtml(options_.machine, kept, printer_->bench().drawn_mm));
}

}  // namespace caltwin
