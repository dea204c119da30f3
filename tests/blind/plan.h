#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/blind/gantry.h"
#include "tests/blind/random.h"

namespace blind {

/// Where an artefact stands by its drawing, and the room it has to stand wrongly.
struct Placement {
  std::string artefact{};
  Vector3 center_mm{};  ///< Of its base; it is turned about the vertical through it.
  double offset_sd_mm = 0.1;
  double turn_sd_rad = 1e-3;
  bool on_table = true;  ///< Leans with the table.
};

/// One reading to be taken.
struct Stop {
  std::string campaign{};
  Kind kind = Kind::kPosition;
  std::string setup{};    ///< Key of Plan::placements.
  std::string feature{};  ///< `artefact.face`.
  int rep = 1;
  bool rehome = false;  ///< Home before it.
  Vector3 at_mm{};      ///< What is written as cmd_: pose, or nominal touched point.
  Vector3 n{};
  /// Commanded points passed on the way (of the tip, like at_mm).
  std::vector<Vector3> via{};
  double feed_mm_s = 2;
  double load_n = -1;  ///< Below 0: the rail's own friction, and not logged.
  double turn_deg = 0;
  double spindle_deg = 0;
  Vector3 offset_mm{};
  double ring_radius_mm = 0;  ///< Above 0: touched from inside a bore of this radius.
  /// On a ball-bar's circle about the placement's centre.
  double circle_radius_mm = 0;
  double sense = 1;
  double pause_s = 0;  ///< Waited before it, beside what the reading takes.
};

/// A campaign of the plan as the header names it.
struct Campaign {
  std::string name{};
  std::string kind{};     ///< iso230, dense ...
  std::string options{};  ///< YAML flow text under the kind.
  std::string instrument{};
};

/// What an artefact is by its certificate.
struct Certificate {
  std::string type{};
  std::vector<double> sizes_mm{};
  double u_um = 0.5;
};

/// A measuring session: all that is decided before the machine moves.
struct Plan {
  std::vector<Stop> stops{};
  std::vector<Campaign> campaigns{};
  std::map<std::string, Placement> placements{};
  std::map<std::string, Certificate> artefacts{};
  bool from_cold = false;
};

/// What one campaign is asked for.
struct CampaignRequest {
  std::string kind{};
  int axis = 0;   ///< Along which it runs, where it has one.
  int lever = 2;  ///< abbe: the axis at two positions of which it runs.
  bool two_loads = false;
  bool three_feeds = false;
  bool two_offsets = false;
  bool two_artefacts = false;
  bool vertical = false;  ///< square: one leg along z.
};

/// Adds the campaign to the plan; its name is the kind, numbered from the second on.
void AddCampaign(const CampaignRequest& request,
                 const Drawing& drawing,
                 Random* random,
                 Plan* plan);

/// Of one family of campaigns; AddCampaign chooses.
void AddGaugeCampaign(const CampaignRequest& request,
                      const std::string& name,
                      const Drawing& drawing,
                      Random* random,
                      Plan* plan);
void AddTouchCampaign(const CampaignRequest& request,
                      const std::string& name,
                      const Drawing& drawing,
                      Random* random,
                      Plan* plan);
void AddTimeCampaign(const CampaignRequest& request,
                     const std::string& name,
                     const Drawing& drawing,
                     Random* random,
                     Plan* plan);

/// A touch of a plane at `point` with outward normal `n`, approached along -n from 4
/// mm.
Stop Touch(const std::string& campaign,
           const std::string& setup,
           const std::string& feature,
           const Vector3& point,
           const Vector3& n);

}  // namespace blind
