#include "sim/firmware/plant.h"

#include <algorithm>
#include <cmath>

namespace caltwin {
namespace {

/// The three parts of a profile: durations, and where the middle one begins and ends.
struct Parts {
  double up_s, along_s, down_s;
  double up_mm, along_mm;
};

Parts PartsOf(const Profile& p) {
  const double up_s = (p.feed_top_mm_s - p.feed_in_mm_s) / p.acceleration_mm_s2;
  const double down_s = (p.feed_top_mm_s - p.feed_out_mm_s) / p.acceleration_mm_s2;
  const double up_mm = up_s * (p.feed_top_mm_s + p.feed_in_mm_s) / 2;
  const double down_mm = down_s * (p.feed_top_mm_s + p.feed_out_mm_s) / 2;
  const double along_mm = std::max(0.0, p.length_mm - up_mm - down_mm);
  return {.up_s = up_s,
          .along_s = along_mm / p.feed_top_mm_s,
          .down_s = down_s,
          .up_mm = up_mm,
          .along_mm = along_mm};
}

}  // namespace

double Profile::Duration_s() const {
  if (length_mm <= 0) return 0;
  const Parts parts = PartsOf(*this);
  return parts.up_s + parts.along_s + parts.down_s;
}

double Profile::Distance_mm(double t_s) const {
  if (t_s <= 0) return 0;
  const Parts parts = PartsOf(*this);
  const double left_s = parts.up_s + parts.along_s + parts.down_s - t_s;
  if (left_s <= 0) return length_mm;
  double gone_mm = 0;
  if (t_s < parts.up_s) {
    gone_mm = (feed_in_mm_s + acceleration_mm_s2 * t_s / 2) * t_s;
  } else if (t_s < parts.up_s + parts.along_s) {
    gone_mm = parts.up_mm + feed_top_mm_s * (t_s - parts.up_s);
  } else {
    gone_mm = length_mm - (feed_out_mm_s + acceleration_mm_s2 * left_s / 2) * left_s;
  }
  return std::clamp(gone_mm, 0.0, length_mm);
}

double Profile::Feed_mm_s(double t_s) const {
  const Parts parts = PartsOf(*this);
  const double left_s = parts.up_s + parts.along_s + parts.down_s - t_s;
  if (t_s <= 0) return feed_in_mm_s;
  if (left_s <= 0) return feed_out_mm_s;
  return std::min({feed_top_mm_s,
                   feed_in_mm_s + acceleration_mm_s2 * t_s,
                   feed_out_mm_s + acceleration_mm_s2 * left_s});
}

double Profile::Time_s(double distance_mm) const {
  const double a = acceleration_mm_s2;
  const double top = feed_top_mm_s;
  const double up_mm = (top * top - feed_in_mm_s * feed_in_mm_s) / (2 * a);
  const double down_mm = (top * top - feed_out_mm_s * feed_out_mm_s) / (2 * a);
  const double s_mm = std::clamp(distance_mm, 0.0, length_mm);
  if (s_mm < up_mm) {
    return (std::sqrt(feed_in_mm_s * feed_in_mm_s + 2 * a * s_mm) - feed_in_mm_s) / a;
  }
  const double up_s = (top - feed_in_mm_s) / a;
  const double along_mm = length_mm - up_mm - down_mm;
  if (s_mm <= up_mm + along_mm) return up_s + (s_mm - up_mm) / top;
  const double left_mm = length_mm - s_mm;
  const double feed =
      std::sqrt(feed_out_mm_s * feed_out_mm_s + 2 * a * std::max(0.0, left_mm));
  return up_s + std::max(0.0, along_mm) / top + (top - feed) / a;
}

Motors Segment::Steps(double t_s) const {
  if (profile.length_mm <= 0) return to_steps;
  const double gone_mm = profile.Distance_mm(t_s);
  const double share = gone_mm / profile.length_mm;
  if (share >= 1) return to_steps;
  if (curve) return curve(gone_mm);
  return from_steps + share * (to_steps - from_steps);
}

}  // namespace caltwin
