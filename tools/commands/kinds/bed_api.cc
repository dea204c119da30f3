#include "tools/commands/kinds/bed_api.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "calibration/kinds/triple_z/missed_touch.h"
#include "calibration/kinds/triple_z/procedures.h"
#include "sim/base/input_error.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "tools/commands/api/utc.h"
#include "tools/server/json_keys.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostFound = 4;  // This and the three before.
constexpr double kMargin_mm = 20;      // Of a grid from the ends of the travel.
constexpr double kClear_mm = 10;       // Nozzle over the bed where screws move.
constexpr double kHighest_mm = 1000;   // Of a height that somebody gives.

// What the machine would not do, in its own words.
Problem ProblemOf(const MachineFault& fault, const std::string& why = "") {
  const bool is_lost = fault.kind == MachineFault::Kind::kLinkLost;
  const bool is_late = fault.kind == MachineFault::Kind::kTimeout;
  const bool has_no_trigger = fault.kind == MachineFault::Kind::kNoTrigger;
  std::string hint;
  if (is_lost) hint = "look at the cable, and whether the controller runs";
  if (!why.empty()) hint = why;
  if (has_no_trigger && why.empty())
    hint = "look at the probe: is it plugged in, does it trigger by hand?";
  const int status = is_late ? 504 : is_lost ? 502 : 409;
  return Problem(status,
                 "the machine did not do it: " + fault.reply,
                 {{.detail = fault.reply, .hint = hint}},
                 {{"machine_said", fault.reply}});
}

std::vector<BedTouch> Flat(const std::vector<Eigen::Vector2d>& at_mm) {
  std::vector<BedTouch> flat;
  for (const Eigen::Vector2d& place_mm : at_mm) flat.push_back({.at_mm = place_mm});
  return flat;
}

// Points that lie closer together than this tell no tilt of a bed.
constexpr double kLeastSpan_mm = 5;

void RequireASpan(const std::vector<BedTouch>& touches, double sigma_mm) {
  Eigen::Vector2d middle_mm = Eigen::Vector2d::Zero();
  const auto count = static_cast<double>(touches.size());
  for (const BedTouch& touch : touches) middle_mm += touch.at_mm / count;
  Eigen::Matrix2d spread_mm2 = Eigen::Matrix2d::Zero();
  for (const BedTouch& touch : touches) {
    spread_mm2 += (touch.at_mm - middle_mm) * (touch.at_mm - middle_mm).transpose();
  }
  // The lesser of its two eigenvalues: how far they spread across their own line.
  const double half = spread_mm2.trace() / 2;
  const double least_mm2 =
      half - std::sqrt(std::max(0.0, half * half - spread_mm2.determinant()));
  const bool spans = least_mm2 > kLeastSpan_mm * kLeastSpan_mm;
  if (spans && FitBedPlane(touches, sigma_mm, false).is_told()) return;
  throw Problem(422,
                "these points span no plane",
                {{.detail = "all points lie on one line, or within 5 mm",
                  .hint = "three points that are not on a line",
                  .pointer = "/probe_points"}});
}

}  // namespace

BedApi::BedApi(TripleZPrinter* printer,
               const Options& options,
               OperatorSeat* seat,
               EventTopic* events)
    : printer_(printer), options_(options), seat_(seat), events_(events) {
  BedStore kept = ReadBedStore(options_.store, printer->bench().sigma_mm, &note_);
  if (kept.applied_mm) {
    kept.applied_mm.reset();
    kept.found.back().notes.emplace_back(
        "the server was started anew since: nobody knows whether what was applied "
        "still is, measure again");
  }
  Show(std::move(kept));
}

std::span<const BedApi::Served> BedApi::AllServed() {
  using enum Route::Pace;
  static constexpr std::array kServed = {
      Served{"GET", "/intrinsics", kQuick, &BedApi::Intrinsics},
      Served{"POST", "/intrinsics", kSlow, &BedApi::SetIntrinsics},
      Served{"POST", "/bed-tilt/probe", kSlow, &BedApi::Probe},
      Served{"POST", "/bed-tilt/calibrate", kSlow, &BedApi::Calibrate},
      Served{"GET", "/bed-tilt/current", kQuick, &BedApi::Current},
      Served{"GET", "/bed-tilt/history", kQuick, &BedApi::History},
      Served{"GET", "/bed-tilt/status", kQuick, &BedApi::Status},
      Served{"POST", "/bed-tilt/apply-triple-z", kSlow, &BedApi::Apply},
      Served{"POST", "/bed-tilt/abort", kQuick, &BedApi::Abort},
      Served{"POST", "/validate", kQuick, &BedApi::Validate},
      Served{"GET", "/report", kQuick, &BedApi::Report}};
  return kServed;
}

Route BedApi::RouteOf(const Served& served, Handler handler) {
  return {.method = served.method,
          .pattern = std::string("/api/calibration") + served.path,
          .handler = std::move(handler),
          .pace = served.pace};
}

void BedApi::AddTo(Routes* routes) {
  for (const Served& served : AllServed()) {
    routes->Add(RouteOf(served, [this, answer = served.answer](const HttpRequest& r) {
      ForgetWhatHomingUndid();
      return (this->*answer)(r);
    }));
  }
}

void BedApi::Refuse(Routes* routes, const Handler& refusal) {
  for (const Served& served : AllServed()) routes->Add(RouteOf(served, refusal));
}

HttpResponse BedApi::Abort(const HttpRequest& /*request*/) {
  return JsonResponse({{"aborted", seat_->Abort()}}, 202);
}

// Homing squares the screws: what was applied is gone with it. So it is after a start,
// where nobody knows what became of it.
void BedApi::ForgetWhatHomingUndid() {
  bool is_undone = false;
  seat_->IfFree([&] {
    const std::lock_guard<std::mutex> lock(mutex_);
    raised_mm_ = printer_->raised_mm();
    is_undone = printer_->homings() != homings_ && store_.applied_mm.has_value();
    homings_ = printer_->homings();
  });
  if (!is_undone) return;
  Change([](BedStore* kept) {
    kept->applied_mm.reset();
    kept->found.back().notes.emplace_back(
        "the printer was homed since: what was applied is undone, measure again");
  });
}

BedStore BedApi::store() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return store_;
}

void BedApi::Change(const std::function<void(BedStore*)>& change) {
  const std::lock_guard<std::mutex> writing(writing_);
  BedStore store = this->store();
  change(&store);
  try {
    WriteBedStore(options_.store, store);
  } catch (const InputError& error) {
    throw Problem(500, error.what());  // The disk's fault, not the client's.
  }
  Show(std::move(store));
}

void BedApi::Show(BedStore store) {
  const std::lock_guard<std::mutex> lock(mutex_);
  store_ = std::move(store);
  current_.clear();
  if (store_.found.empty()) return;
  Json tree = ToJson(store_.found.back());
  const BedPlane now = PlaneNow(store_, printer_->bench().drawn_mm);
  if (store_.applied_mm)
    tree["applied"] = ScrewsToJson(*store_.applied_mm);
  else
    tree["applied"] = nullptr;
  tree["plane_now"] = {{"a", now.a()}, {"b", now.b()}, {"c", now.c_mm()}};
  current_ = JsonResponse(tree).body;
}

HttpResponse BedApi::Intrinsics(const HttpRequest& /*request*/) {
  return JsonResponse(ToJson(store().camera));
}

HttpResponse BedApi::SetIntrinsics(const HttpRequest& request) {
  const Json body = JsonBody(request);
  JsonKeys keys(body);
  constexpr double kMost_pixel = 1e6;
  const NumberRange focal{.least = 1, .most = kMost_pixel, .unit = "pixels"};
  const NumberRange place{.least = -kMost_pixel, .most = kMost_pixel, .unit = "pixels"};
  const NumberRange bend{.least = -10, .most = 10};
  CameraIntrinsics camera{.fx = keys.Number("fx", focal),
                          .fy = keys.Number("fy", focal),
                          .cx = keys.Number("cx", place),
                          .cy = keys.Number("cy", place),
                          .k1 = keys.Number("k1", bend, 0),
                          .k2 = keys.Number("k2", bend, 0),
                          .p1 = keys.Number("p1", bend, 0),
                          .p2 = keys.Number("p2", bend, 0),
                          .is_stored = true};
  keys.Text("source", "");  // As GET answers it.
  const double baseline_mm =
      keys.Number("baseline_mm", {.least = 0.1, .most = 10'000, .unit = "mm"}, -1);
  if (baseline_mm > 0) camera.baseline_mm = baseline_mm;
  keys.Done();
  Change([&](BedStore* store) { store->camera = camera; });
  return JsonResponse(ToJson(camera));
}

HttpResponse BedApi::Probe(const HttpRequest& request) {
  const Json body = JsonBody(request);
  JsonKeys keys(body);
  Asked asked{.reference_mm = keys.Number("reference_height", {-1000, 1000, "mm"}, 10),
              .uses_printer = keys.Bool("use_printer", true)};
  const auto points =
      keys.Tuples("probe_points", asked.uses_printer ? 2 : 3, 3, kMostPoints);
  const Eigen::Vector2d& most_mm = printer_->bench().most_mm;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d at_mm(points[i][0], points[i][1]);
    const bool is_outside =
        (at_mm.array() < 0).any() || (at_mm.array() > most_mm.array()).any();
    if (asked.uses_printer && is_outside) {
      keys.Add(
          fmt::format("/probe_points/{}", i),
          fmt::format("({:g}, {:g}) is out of the travel", at_mm[0], at_mm[1]),
          fmt::format("x from 0 to {:g}, y from 0 to {:g} mm", most_mm[0], most_mm[1]));
    }
    asked.at_mm.push_back(at_mm);
    if (!asked.uses_printer) asked.given.push_back({at_mm, points[i][2]});
    if (!asked.uses_printer && std::abs(points[i][2]) > kHighest_mm) {
      keys.Add(fmt::format("/probe_points/{}/2", i),
               fmt::format("{:g} is no height of a bed", points[i][2]),
               fmt::format("allowed: -{0:g} to {0:g} mm", kHighest_mm));
    }
  }
  keys.Done();
  return Find(request, asked);
}

HttpResponse BedApi::Calibrate(const HttpRequest& request) {
  const Json body = JsonBody(request);
  JsonKeys keys(body);
  constexpr int kMostLines = 15;
  const int rows = keys.Integer("grid_rows", 2, kMostLines, 3);
  const int columns = keys.Integer("grid_cols", 2, kMostLines, 3);
  Asked asked{.reference_mm = keys.Number("reference_height", {-1000, 1000, "mm"}, 10)};
  keys.Done();
  asked.at_mm = ProbeGrid(printer_->bench(), columns, rows, kMargin_mm);
  return Find(request, asked);
}

std::vector<BedTouch> BedApi::TouchAll(const std::vector<Eigen::Vector2d>& at_mm) {
  std::vector<BedTouch> touches;
  events_->Publish("begin", JsonLine(Json{{"points", at_mm.size()}}));
  for (const Eigen::Vector2d& place_mm : at_mm) {
    const auto height_mm = printer_->Probe(place_mm);
    if (!height_mm) {
      events_->Publish("end", JsonLine(Json{{"fault", height_mm.error().reply}}));
      throw ProblemOf(height_mm.error(),
                      AskWhyNoHeight(printer_, place_mm, touches, height_mm.error()));
    }
    touches.push_back({place_mm, *height_mm});
    events_->Publish("touch",
                     JsonLine(Json{{"number", touches.size()},
                                   {"of", at_mm.size()},
                                   {"x", place_mm[0]},
                                   {"y", place_mm[1]},
                                   {"z", *height_mm}}));
  }
  return touches;
}

HttpResponse BedApi::Find(const HttpRequest& request, const Asked& asked) {
  const double sigma_mm = printer_->bench().sigma_mm;
  RequireASpan(Flat(asked.at_mm), sigma_mm);
  BedFound found{.reference_mm = asked.reference_mm,
                 .is_by_printer = asked.uses_printer,
                 .at = UtcNow()};
  const auto seat = seat_->Take(request, "probing the bed");
  if (asked.uses_printer) {
    if (const auto homed = printer_->HomeIfNeeded(); !homed)
      throw ProblemOf(homed.error());
    found.touches = TouchAll(asked.at_mm);
  } else {
    found.touches = asked.given;
  }
  found.raised_before_mm = printer_->raised_mm();
  found.plane = FitBedPlane(found.touches, sigma_mm, printer_->bench().is_sigma_stated);
  found.offsets_mm = ScrewOffsets_mm(found.plane,
                                     printer_->bench().drawn_mm,
                                     asked.reference_mm,
                                     OffsetRule::kFormula);
  found.notes = NotesOf(&found);
  Change([&](BedStore* store) {
    store->applied_mm.reset();
    store->found.push_back(found);
    if (store->found.size() > kMostFound) store->found.erase(store->found.begin());
  });
  events_->Publish("found", JsonLine(ToJson(found)));
  return JsonResponse(ToJson(found));
}

void BedApi::RequireReachable(const Vec3<double>& raised_mm) const {
  const double top_mm = printer_->bench().top_mm;
  std::vector<ProblemFault> faults;
  for (int i = 0; i < kNumScrews; ++i) {
    const double height_mm = top_mm - kClear_mm + raised_mm[i];
    if (height_mm >= 0 && height_mm <= top_mm) continue;
    faults.push_back(
        {.detail = fmt::format("{} would stand at {:g} mm", ScrewName(i), height_mm),
         .hint = fmt::format("it goes from 0 to {:g} mm", top_mm),
         .pointer = fmt::format("/{}_mm", ScrewName(i))});
  }
  if (!faults.empty()) {
    throw Problem(422, faults.front().detail + ", nothing moved", faults);
  }
}

HttpResponse BedApi::Apply(const HttpRequest& request) {
  const Json body = JsonBody(request);
  JsonKeys keys(body);
  // More is no correction: something is loose, or a screw was counted wrong.
  const double most_mm = TripleZOptions{}.largest_mm;
  const NumberRange range{-most_mm, most_mm, "mm"};
  const Vec3<double> offsets_mm(keys.Number("z1_mm", range),
                                keys.Number("z2_mm", range),
                                keys.Number("z3_mm", range));
  keys.Done();
  const auto seat = seat_->Take(request, "raising the screws");
  const BedStore store = this->store();
  const Vec3<double> before_mm =
      store.found.empty() ? Vec3<double>::Zero() : store.found.back().raised_before_mm;
  const Vec3<double> target_mm = before_mm + offsets_mm;
  RequireReachable(target_mm);
  // The same offsets again move nothing: they are counted from where the bed was
  // touched.
  if (const auto homed = printer_->HomeIfNeeded(); !homed)
    throw ProblemOf(homed.error());
  const Vec3<double> move_mm = target_mm - printer_->raised_mm();
  if (const auto moved = printer_->Raise(move_mm); !moved)
    throw ProblemOf(moved.error());
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    homings_ = printer_->homings();
  }
  Change([&](BedStore* now) { now->applied_mm = offsets_mm; });
  const Eigen::Vector2d middle_mm = printer_->bench().most_mm / 2;
  const Vec3<double> weights =
      ScrewWeights(printer_->bench().drawn_mm, middle_mm[0], middle_mm[1]);
  const double risen_mm = weights.dot(move_mm);
  Json answer{{"status", "success"},
              {"z_offsets", ScrewsToJson(offsets_mm)},
              {"moved", ScrewsToJson(move_mm)},
              {"notes", Json::array()}};
  if (std::abs(risen_mm) > kLevelEnough_mm) {
    answer["notes"].push_back(
        fmt::format("the middle of the bed stands {:.3f} mm {} than before: set the "
                    "nozzle's height "
                    "(Z offset) anew before you print",
                    std::abs(risen_mm),
                    risen_mm > 0 ? "higher" : "lower"));
  }
  events_->Publish("applied", JsonLine(answer));
  return JsonResponse(answer);
}

std::unique_ptr<BedApi> BedApiOn(Bench* bench,
                                 const BedApi::Options& options,
                                 OperatorSeat* seat,
                                 EventTopic* events) {
  auto* const printer = bench->kept.Find<TripleZPrinter>();
  if (printer == nullptr) return nullptr;
  return std::make_unique<BedApi>(printer, options, seat, events);
}

}  // namespace caltwin
