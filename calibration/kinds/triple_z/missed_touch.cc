#include "calibration/kinds/triple_z/missed_touch.h"

#include <optional>

#include <fmt/format.h>

#include "calibration/kinds/triple_z/plane.h"

namespace caltwin {
namespace {

constexpr double kReach_mm = 5;  // Of a touch, over and under z = 0 (M558 H).

// What the plane of the touches before foretells there; none where they span none.
std::optional<double> Foretold_mm(const MissedTouch& missed) {
  constexpr double kTouch_mm = 0.01;
  constexpr std::size_t kFewest = 3;
  if (missed.before.size() < kFewest) return std::nullopt;
  const BedPlane plane =
      FitBedPlane(missed.before, kTouch_mm, /*is_sigma_stated=*/false);
  if (!plane.is_told()) return std::nullopt;
  return plane.At_mm(missed.at_mm);
}

std::string WordsOfForetold(const MissedTouch& missed) {
  const auto foretold_mm = Foretold_mm(missed);
  if (!foretold_mm) return "";
  return fmt::format("; the plane of the {} touches before foretells {:+.1f} mm there",
                     missed.before.size(),
                     *foretold_mm);
}

std::string WhyTooSoon(const MissedTouch& missed, const std::string& place) {
  if (missed.clear == ProbeReading::kTriggered) {
    return "the probe reads triggered with the bed lowered out of its reach: its wire "
           "is shorted or its pin inverted (M558 C), not the bed";
  }
  if (missed.clear == ProbeReading::kUnknown) {
    return "the probe read triggered before the move; whether it still does with the "
           "bed lowered tells a stuck probe from a bed that stands too high";
  }
  return fmt::format(
      "the bed stands too high at {} for the trigger distance: touches begin {:g} mm "
      "over z = 0 (M558 H), and the probe reads triggered there, free with the bed "
      "lowered{}. Lower that corner by hand, or raise the dive height",
      place,
      kReach_mm,
      WordsOfForetold(missed));
}

std::string WhyNotAtAll(const MissedTouch& missed, const std::string& place) {
  if (missed.before.empty()) {
    return fmt::format(
        "the probe has not triggered once, and reads free: its wire is broken, or the "
        "bed lies more than {:g} mm too low at {}. Push the probe by hand: if "
        "sensors.probes[0].value stays 0 it is the wire",
        kReach_mm,
        place);
  }
  const auto foretold_mm = Foretold_mm(missed);
  const bool is_too_low = foretold_mm && *foretold_mm < -0.9 * kReach_mm;
  if (is_too_low) {
    return fmt::format(
        "the bed lies too low at {} for the trigger distance: touches end {:g} mm "
        "under "
        "z = 0, and the probe works{}. Raise that corner by hand",
        place,
        kReach_mm,
        WordsOfForetold(missed));
  }
  return fmt::format(
      "the probe triggered {} times and then not at {}{}: nothing lies there to be "
      "touched, or its wire breaks as the head goes there. Touch that place again from "
      "another side",
      missed.before.size(),
      place,
      WordsOfForetold(missed));
}

}  // namespace

std::string WhyNoHeight(const MissedTouch& missed) {
  const auto says = [&](std::string_view words) {
    return missed.reply.find(words) != std::string::npos;
  };
  const std::string place =
      fmt::format("({:.0f}, {:.0f})", missed.at_mm[0], missed.at_mm[1]);
  if (missed.clear == ProbeReading::kMissing) {
    return "the firmware has no probe configured (sensors.probes is empty): set it up "
           "by M558 and G31, and touch again";
  }
  if (says("already triggered")) return WhyTooSoon(missed, place);
  if (says("was not triggered")) return WhyNotAtAll(missed, place);
  return "";
}

std::string AskWhyNoHeight(TripleZPrinter* printer,
                           const Eigen::Vector2d& at_mm,
                           std::span<const BedTouch> before,
                           const MachineFault& fault) {
  const bool may_ask = fault.kind == MachineFault::Kind::kRefused ||
                       fault.kind == MachineFault::Kind::kNoTrigger;
  if (!may_ask) return "";
  return WhyNoHeight({.reply = fault.reply,
                      .at_mm = at_mm,
                      .clear = printer->ReadProbeClear(),
                      .before = before});
}

}  // namespace caltwin
