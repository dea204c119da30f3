#include <map>
#include <set>

#include <fmt/format.h>

#include "calibration/diagnosis/kinds/kinds.h"
#include "calibration/diagnosis/kinds/z_station_correction.h"
#include "sim/machine/kinds/z_station/drawing.h"

namespace caltwin {
namespace {

// What was touched, and where: a bed has another height at each place of a mesh.
std::map<std::string, std::set<Eigen::Index>> HeightsOf(const Observed& o) {
  std::map<std::string, std::set<Eigen::Index>> heights;
  const Eigen::Vector2d usual_mm =
      ZStationOf(o.machine()).PlaceOf_mm(ZReading::kProbeOnBed);
  for (Eigen::Index i = 0; i < o.num_rows(); ++i) {
    if (o.at(i).kind != RowKind::kTouch || !o.at(i).station) continue;
    std::string name(FeatureOf(*o.at(i).station));
    const Eigen::Vector2d at_mm = o.at(i).q_mm.head<2>();
    const bool is_elsewhere =
        o.at(i).station == ZReading::kProbeOnBed && (at_mm - usual_mm).norm() > 1;
    if (is_elsewhere) name += fmt::format(".{:.0f}_{:.0f}", at_mm[0], at_mm[1]);
    heights[name].insert(i);
  }
  return heights;
}

// Z counts from where it was homed, and of what is touched the heights are known only
// roughly. A gap is what it is.
void AddStation(const Observed& o, NuisanceList* builder) {
  const std::vector<std::string> homes = HomesOf(o, /*only_touches=*/true);
  const auto heights = HeightsOf(o);
  for (const auto& height : heights) {
    const std::set<Eigen::Index>& rows = height.second;
    builder->Add(
        "height." + height.first, "mm", kPlacementSd_mm, [&](Eigen::Index row) {
          return rows.contains(row);
        });
  }
  // The first one's is in those heights.
  for (std::size_t h = 1; h < homes.size(); ++h) {
    builder->Add(
        "homed." + homes[h],
        "mm",
        kPlacementSd_mm,
        [&](Eigen::Index row) {
          return o.at(row).kind == RowKind::kTouch && o.row(row).home == homes[h];
        },
        /*offset=*/0,
        /*reported=*/false);
  }
}

class Station final : public DiagnosedKind {
 public:
  void AddKinematics(const Observed& o, NuisanceList* list) const override {
    AddStation(o, list);
  }
  bool StandsAnewWhenHomed() const override { return true; }
  void AddPlaces(const Observed&, NuisanceList*) const override {}

  std::vector<ChannelAndWord> FreeForms() const override {
    std::vector<ChannelAndWord> forms;
    for (const char* channel : {"z", "nozzle", "bed"}) {
      for (const char* word : {"t", "temp"}) forms.emplace_back(channel, word);
    }
    return forms;
  }

  // Homing turns what one touch shows into what the two others do.
  int FewRows() const override { return 2; }

  // No switch of a printer repeats to better.
  std::optional<double> LeastCounted_mm() const override { return 1e-4; }

  void RequireSettings(ControllerKind controller) const override {
    RequireZCalibration(controller);
  }
  std::vector<CorrectionFile> Correction(ControllerKind controller,
                                         const Diagnosis& diagnosis,
                                         const Observed& observed,
                                         const std::string&) const override {
    return {{.text = ZStationCorrectionText(controller, diagnosis, observed)}};
  }
};

}  // namespace

const DiagnosedKind& DiagnosedZStation() {
  static const Station kind;
  return kind;
}

}  // namespace caltwin
