// What goes wrong at the probe, in the servo loop on a circle, and in an artefact.

#include <cmath>
#include <numbers>

#include "tests/blind/causes.h"

namespace blind {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

std::vector<CampaignRequest> ThreeFeeds(const std::string&) {
  return {{.kind = "blocks", .three_feeds = true}, {.kind = "plate"}};
}

/// The count is latched late: the machine has gone on by v tau, so the reading falls by
/// it. Size 1: 1 ms; a little longer at high feed.
Defect TriggerLatency(const std::string& axis, const Circumstances& at) {
  const double growth = at.random->Uniform(-0.01, 0.01);
  Defect defect{.cause = "trigger_latency", .axis = axis};
  defect.parameters = {{"latency_ms", 1}};
  defect.pretravel = [=](const Instant& now) {
    return 1e-3 * now.feed_mm_s * (1 + growth * (now.feed_mm_s - 3));
  };
  return defect;
}

std::vector<CampaignRequest> RingAndBlocks(const std::string&) {
  return {{.kind = "ring"}, {.kind = "blocks"}};
}

/// Pre-travel grows by A cos(k (theta - spindle) + phase), theta the direction of the
/// normal, in the plane; with a second lobe pattern beside it.
Defect Lobes(const std::string& cause,
             const std::string& axis,
             int count,
             int other,
             const Circumstances& at) {
  const double phase_rad = at.random->Uniform(0, kTurn);
  const double beside = at.random->Uniform(0.03, 0.15);
  const double beside_rad = at.random->Uniform(0, kTurn);
  Defect defect{.cause = cause, .axis = axis};
  defect.parameters = {{"amplitude_um", 1},
                       {"phase_deg", phase_rad * 360 / kTurn, false}};
  defect.pretravel = [=](const Instant& now) {
    const double level = std::hypot(now.n[0], now.n[1]);
    if (level < 0.1) return 0.0;
    const double angle_rad = std::atan2(now.n[1], now.n[0]) - now.spindle_rad;
    return kMmPerUm * level *
           (std::cos(count * angle_rad + phase_rad) +
            beside * std::cos(other * angle_rad + beside_rad));
  };
  return defect;
}

Defect ProbeLobing(const std::string& axis, const Circumstances& at) {
  return Lobes("probe_lobing", axis, 3, 6, at);
}

Defect StylusAnisotropy(const std::string& axis, const Circumstances& at) {
  return Lobes("stylus_anisotropy", axis, 2, 4, at);
}

/// The tip stands off the spindle's axis by 1 um and turns with it.
Defect TipRunout(const std::string& axis, const Circumstances& at) {
  const double phase_rad = at.random->Uniform(0, kTurn);
  Defect defect{.cause = "tip_runout", .axis = axis};
  defect.parameters = {{"offset_um", 1}, {"phase_deg", phase_rad * 360 / kTurn, false}};
  defect.motion = [=](const Instant& now) {
    if (now.kind != Kind::kTouch) return Vector3{};
    const double angle_rad = phase_rad + now.spindle_rad;
    return kMmPerUm * Vector3{std::cos(angle_rad), std::sin(angle_rad), 0};
  };
  return defect;
}

/// The true radius is half of the one entered (the diameter was entered). Size 1: 1 mm.
Defect TipSize(const std::string& axis, const Circumstances& at) {
  const double error_mm = at.random->Chance(0.7) ? -0.5 * at.drawing.tip_radius_cfg_mm
                                                 : at.random->Uniform(0.35, 0.8);
  Defect defect{.cause = "tip_size", .axis = axis};
  defect.parameters = {{"radius_error_mm", error_mm}};
  defect.tip_radius_mm = error_mm;
  return defect;
}

std::vector<CampaignRequest> Circle(const std::string&) {
  return {{.kind = "ballbar"}, {.kind = "iso230", .axis = 0}};
}

/// Each axis follows its command late: on a circle, where the command stood tau ago.
/// tau_y - tau_x = 1 ms for size 1.
Defect ServoMismatch(const std::string& axis, const Circumstances& at) {
  const double share = at.random->Uniform(0.2, 0.8);
  const double sign = at.random->Sign();
  Defect defect{.cause = "servo_mismatch", .axis = axis};
  defect.parameters = {{"mismatch_ms", sign}};
  defect.motion = [=](const Instant& now) {
    if (!now.on_circle) return Vector3{};
    const Vector3 from = now.q_mm - now.center_mm;
    const double angle_rad = std::atan2(from[1], from[0]);
    const double rate = now.sense * now.feed_mm_s / now.radius_mm;
    const double tau_x_s = -sign * 1e-3 * share;
    const double tau_y_s = sign * 1e-3 * (1 - share);
    return now.radius_mm *
           Vector3{std::cos(angle_rad - rate * tau_x_s) - std::cos(angle_rad),
                   std::sin(angle_rad - rate * tau_y_s) - std::sin(angle_rad),
                   0};
  };
  return defect;
}

/// The circle shrinks with the square of the feed: 1 um at 50 mm/s on 100 mm.
Defect ServoLag(const std::string& axis, const Circumstances& at) {
  const double power = at.random->Uniform(1.9, 2.1);
  Defect defect{.cause = "servo_lag", .axis = axis};
  defect.parameters = {{"lag_um_at_50_mm_s", 1}};
  defect.motion = [=](const Instant& now) {
    if (!now.on_circle) return Vector3{};
    const double shrink_mm =
        kMmPerUm * std::pow(now.feed_mm_s / 50, power) * 100 / now.radius_mm;
    return -shrink_mm / now.radius_mm * (now.q_mm - now.center_mm);
  };
  return defect;
}

std::vector<CampaignRequest> TwoArtefacts(const std::string&) {
  return {{.kind = "blocks", .two_artefacts = true}};
}

/// Every size of the 1-2-3 block is 1 um larger than certified: half of it on each
/// side, all of it on top.
Defect BlockSize(const std::string& axis, const Circumstances& at) {
  const double sign = at.random->Sign();
  Defect defect{.cause = "block_size", .axis = axis};
  defect.parameters = {{"error_um", sign}};
  defect.surface = [=](const Instant& now) {
    if (now.artefact != axis) return 0.0;
    return sign * kMmPerUm * (std::abs(now.n[2]) > 0.7 ? 1.0 : 0.5);
  };
  return defect;
}

}  // namespace

std::vector<Cause> ProbeCauses() {
  return {{"trigger_latency", {""}, ThreeFeeds, TriggerLatency, 1},
          {"probe_lobing", {""}, RingAndBlocks, ProbeLobing, 5},
          {"stylus_anisotropy", {""}, RingAndBlocks, StylusAnisotropy, 5},
          {"tip_runout", {""}, RingAndBlocks, TipRunout, 10},
          {"tip_size", {""}, RingAndBlocks, TipSize, 1, 1},
          {"servo_mismatch", {""}, Circle, ServoMismatch, 0.1},
          {"servo_lag", {""}, Circle, ServoLag, 5},
          {"block_size", {"block123"}, TwoArtefacts, BlockSize, 20}};
}

}  // namespace blind
