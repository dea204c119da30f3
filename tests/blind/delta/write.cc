// A case as files: rows, drawing, truth.

#include <filesystem>

#include <fmt/format.h>

#include "tests/blind/delta/case.h"
#include "tests/blind/text_file.h"

namespace blind {
namespace {

std::string DataCsv(const DeltaCase& made) {
  std::string text =
      "row,campaign,kind,setup,home,t_s,temp_screw_c,temp_frame_c,temp_bed_c,cmd_x_mm,"
      "cmd_y_mm,cmd_z_mm,motor_a_mm,motor_b_mm,motor_c_mm,dir_a,dir_b,dir_c,feed_mm_s,"
      "nx,ny,nz,feature,value_mm,sigma_mm\n";
  for (std::size_t i = 0; i < made.stops.size(); ++i) {
    const DeltaStop& stop = made.stops[i];
    const Vec travel = TravelFor(made.paper, stop.at_mm);
    const ByTower sense = SensesOf(made.paper, stop);
    text += fmt::format(
        "{},{},{},{},h1,{:.1f},{:.2f},{:.2f},{:.2f},{:.4f},{:.4f},{:.4f},{:.5f},{:.5f},"
        "{:.5f},{:.0f},{:.0f},{:.0f},{:.1f},{:.6f},{:.6f},{:.6f},{},{:.6f},{:.6f}\n",
        i + 1,
        stop.campaign,
        stop.is_touch ? "touch" : "position",
        stop.setup,
        stop.t_s,
        22 + stop.screw_k,
        22 + stop.frame_k,
        22 + stop.bed_k,
        stop.at_mm.x(),
        stop.at_mm.y(),
        stop.at_mm.z(),
        travel[0],
        travel[1],
        travel[2],
        sense[0],
        sense[1],
        sense[2],
        stop.feed_mm_s,
        stop.n.x(),
        stop.n.y(),
        stop.n.z(),
        stop.feature,
        made.values_mm[i],
        made.stated * made.sigma_mm);
  }
  return text;
}

std::string MachineYaml(const DeltaPaper& paper) {
  std::string text = fmt::format(
      "format: 1\nname: blind_delta\nkinematics: delta\n"
      "towers: {{a: {{angle_deg: 210}}, b: {{angle_deg: 330}}, c: {{angle_deg: 90}}}}\n"
      "delta_radius_mm: {}\narm_length_mm: {}\nendstop_mm: {}\nrod_spacing_mm: {}\n"
      "effector_radius_mm: {}\njoint_height_mm: {}\nprint_radius_mm: {}\naxes:\n",
      paper.radius_mm,
      paper.arm_mm,
      paper.endstop_mm,
      paper.rod_spacing_mm,
      paper.effector_radius_mm,
      paper.joint_height_mm,
      paper.bed_radius_mm);
  for (const char tower : {'a', 'b', 'c'}) {
    text += fmt::format("  {}: {{min_mm: 0, max_mm: {:.1f}, pulley_mm_per_rev: {}}}\n",
                        tower,
                        paper.endstop_mm + 100,
                        paper.pulley_mm);
  }
  return text;
}

}  // namespace

void WriteDeltaCase(const DeltaCase& made, const std::string& folder) {
  const std::filesystem::path path(folder);
  std::filesystem::create_directories(path);
  WriteText(path / "DATA.csv", DataCsv(made));
  WriteText(path / "machine.yaml", MachineYaml(made.paper));
  WriteText(path / "TRUTH.json", made.truth.dump(1) + "\n");
}

}  // namespace blind
