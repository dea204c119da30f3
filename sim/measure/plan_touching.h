#pragma once

#include <string>
#include <utility>
#include <vector>

#include "sim/measure/plan_session.h"

namespace caltwin {

// What campaigns that touch have in common.

/// Keeps the tip clear of an artefact's edges.
inline constexpr double kInset_mm = 10;

/// To micrometres, as a plan's author would write points.
double Rounded(double mm);
/// A touch of a nominal point with that outward normal; feed and the rest to follow.
Row TouchOf(const std::string& setup,
            const std::string& feature,
            const Vec3<double>& at_mm,
            const Vec3<double>& n);
/// Its `grid: [COLUMNS, ROWS]`, two whole numbers.
std::pair<int, int> GridOf(const PlannedCampaign& campaign,
                           const MeasuringSession& session);
/// The artefact that the campaign names, else its usual one.
std::string ArtefactId(const PlannedCampaign& campaign, const std::string& usual);
/// Touches every row at every feed, in random order.
void TouchAll(const std::vector<Row>& rows,
              const std::vector<double>& feeds_mm_s,
              MeasuringSession* session);
/// Turned counter-clockwise from above; quarters exactly, so that a face's normal stays
/// a unit vector of an axis.
Vec3<double> TurnedAboutZ(const Vec3<double>& v, double turn_deg);

}  // namespace caltwin
