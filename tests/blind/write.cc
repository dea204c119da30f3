// The four files of a case: what the diagnosis gets, and what only the scorer reads.

#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "tests/blind/case.h"
#include "tests/blind/text_file.h"

namespace blind {
namespace {

constexpr double kUmPerMm = 1e3;

/// One column: its name, the group by which it may be missing, its text in a row.
struct CsvColumn {
  std::string name{}, group{};
  std::function<std::string(std::size_t row)> text{};
};

std::string Number(double value, int decimals) {
  return fmt::format("{:.{}f}", value == 0 ? 0.0 : value, decimals);
}

const char* KindWord(Kind kind) {
  return kind == Kind::kTouch ? "touch" : kind == Kind::kRadial ? "radial" : "position";
}

using Columns = std::vector<CsvColumn>;

void AddNames(const Case& made, Columns* columns) {
  const auto* rows = &made.readings;
  const auto add = [&](const std::string& name, const std::string& group, auto text) {
    columns->push_back({name, group, [rows, text](std::size_t i) {
                          return text((*rows)[i]);
                        }});
  };
  columns->push_back({"row", "row", [](std::size_t i) {
                        return fmt::format("{}", i + 1);
                      }});
  add("campaign", "", [](const Reading& r) { return r.stop->campaign; });
  add("kind", "", [](const Reading& r) { return std::string(KindWord(r.stop->kind)); });
  add("setup", "", [](const Reading& r) { return r.stop->setup; });
  add("home", "home", [](const Reading& r) {
    return fmt::format("h{}", r.instant.home + 1);
  });
  add("rep", "rep", [](const Reading& r) { return fmt::format("{}", r.stop->rep); });
  add("settings", "settings", [](const Reading&) { return std::string("s1"); });
  add("t_s", "t_s", [](const Reading& r) { return Number(r.instant.t_s, 1); });
}

void AddTemperatures(const Case& made, Columns* columns) {
  const char* const names[] = {"screw", "frame", "bed", "chamber", "ambient"};
  for (std::size_t k = 0; k < kThermometers; ++k) {
    columns->push_back(
        {fmt::format("temp_{}_c", names[k]), "temp", [&made, k](std::size_t i) {
           return Number(made.temps_c[i][k], 2);
         }});
  }
}

void AddPose(const Case& made, Columns* columns) {
  const auto* rows = &made.readings;
  const auto add = [&](const std::string& name, const std::string& group, auto text) {
    columns->push_back({name, group, [rows, text](std::size_t i) {
                          return text((*rows)[i]);
                        }});
  };
  for (std::size_t k = 0; k < 3; ++k) {
    add(fmt::format("cmd_{}_mm", "xyz"[k]), "", [k](const Reading& r) {
      return Number(r.stop->at_mm[k], 4);
    });
  }
  for (std::size_t k = 0; k < 3; ++k) {
    add(fmt::format("dir_{}", "xyz"[k]), "", [k](const Reading& r) {
      return Number(r.dir[k], 0);
    });
  }
  for (std::size_t k = 0; k < 3; ++k) {
    // Nobody knows it before the axis has turned round for the first time.
    const bool commanded = made.blemishes.logs_commanded_travel;
    const auto travelled = [k, commanded](const Reading& r) {
      double travel_mm = r.instant.since_rev_mm[k];
      // A touch that ends further out has travelled less.
      if (commanded) travel_mm += r.trigger_mm * std::abs(r.stop->n[k]);
      return travel_mm > 900 ? std::string() : Number(travel_mm, 4);
    };
    add(fmt::format("since_rev_{}_mm", "xyz"[k]), "since_rev", travelled);
  }
  add("feed_mm_s", "", [](const Reading& r) { return Number(r.stop->feed_mm_s, 3); });
  add("load_n", "load", [](const Reading& r) {
    return r.stop->load_n < 0 ? std::string() : Number(r.stop->load_n, 2);
  });
  for (std::size_t k = 0; k < 3; ++k) {
    add(fmt::format("n{}", "xyz"[k]), "", [k](const Reading& r) {
      return Number(r.stop->n[k], 7);
    });
  }
}

void AddArtefact(const Case& made, Columns* columns) {
  const auto* rows = &made.readings;
  const auto touched = [&](const std::string& name, auto text) {
    columns->push_back({name, "", [rows, text](std::size_t i) {
                          const Reading& r = (*rows)[i];
                          return r.stop->kind == Kind::kTouch ? text(r) : std::string();
                        }});
  };
  columns->push_back({"feature", "", [rows](std::size_t i) {
                        return (*rows)[i].stop->feature;
                      }});
  touched("artefact_turn_deg",
          [](const Reading& r) { return Number(r.stop->turn_deg, 2); });
  touched("probe_angle_deg",
          [](const Reading& r) { return Number(r.stop->spindle_deg, 2); });
  for (std::size_t k = 0; k < 3; ++k) {
    touched(fmt::format("probe_off_{}_mm", "xyz"[k]),
            [k](const Reading& r) { return Number(r.stop->offset_mm[k], 3); });
  }
}

Columns AllColumns(const Case& made) {
  Columns columns;
  AddNames(made, &columns);
  AddTemperatures(made, &columns);
  AddPose(made, &columns);
  AddArtefact(made, &columns);
  columns.push_back({"value_mm", "", [&made](std::size_t i) {
                       return Number(made.readings[i].value_mm, 6);
                     }});
  if (made.blemishes.states_sigma) {
    columns.push_back({"sigma_mm", "", [&made](std::size_t i) {
                         return Number(made.blemishes.sigma_factor *
                                           Sigma_mm(made, made.readings[i]),
                                       6);
                       }});
  }
  std::erase_if(columns, [&](const CsvColumn& column) {
    return made.blemishes.missing.contains(column.group);
  });
  return columns;
}

std::string DataCsv(const Case& made) {
  const Columns columns = AllColumns(made);
  std::string text;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    text += (k > 0 ? "," : "") + columns[k].name;
  }
  text += "\n";
  for (std::size_t i = 0; i < made.readings.size(); ++i) {
    for (std::size_t k = 0; k < columns.size(); ++k) {
      text += (k > 0 ? "," : "") + columns[k].text(i);
    }
    text += "\n";
  }
  return text;
}

std::string DataYaml(const Case& made) {
  const auto& axes = made.drawing.axes;
  std::string text = "format: 1\nmachine: machine.yaml\n";
  text += fmt::format(
      "settings: {{s1: {{steps_per_mm: {{x: {}, y: {}, z: {}}}, "
      "backlash_mm: {{x: 0, y: 0, z: 0}}, tip_radius_mm: {}}}}}\n",
      axes[0].StepsPerMm(),
      axes[1].StepsPerMm(),
      axes[2].StepsPerMm(),
      made.drawing.tip_radius_cfg_mm);
  text += "instruments:\n";
  for (const auto& [name, noise] : made.instruments) {
    text += fmt::format("  {0}: {{kind: {0}, resolution_um: {1:.4g}",
                        name,
                        noise.resolution_mm * kUmPerMm);
    if (made.blemishes.states_sigma) {
      text += fmt::format(", sigma_um: {:.3g}",
                          noise.sigma_mm * kUmPerMm * made.blemishes.sigma_factor);
    }
    text += "}\n";
  }
  text += "campaigns:\n";
  for (const Campaign& campaign : made.plan.campaigns) {
    text += fmt::format("  {}: {{instrument: {}, plan: {{{}: {}}}}}\n",
                        campaign.name,
                        campaign.instrument,
                        campaign.kind,
                        campaign.options);
  }
  if (!made.plan.artefacts.empty()) text += "artefacts:\n";
  for (const auto& [name, certificate] : made.plan.artefacts) {
    text += fmt::format("  {}: {{type: {}, sizes_mm: [{}], u_um: {}}}\n",
                        name,
                        certificate.type,
                        fmt::join(certificate.sizes_mm, ", "),
                        certificate.u_um);
  }
  text += "transmission:\n";
  for (std::size_t i = 0; i < 3; ++i) {
    text += fmt::format("  {}: {{{}: {}, full_steps_per_mm: {}}}\n",
                        "xyz"[i],
                        axes[i].is_belt ? "pulley_mm_per_rev" : "lead_mm",
                        axes[i].lead_mm,
                        axes[i].full_steps_per_rev / axes[i].lead_mm);
  }
  text += fmt::format("tip_radius_mm: {}\n", made.drawing.tip_radius_cfg_mm);
  return text;
}

}  // namespace

std::string MachineYaml(const Drawing& drawing, const MachineWords& words) {
  std::string text = "format: 1\nname: blind_gantry\nkinematics: cartesian\n";
  if (!words.model.empty()) text += "model: " + words.model + "\n";
  text += "axes:\n";
  for (std::size_t i = 0; i < 3; ++i) {
    const AxisDrawing& axis = drawing.axes[i];
    text += fmt::format(
        "  {}: {{min_mm: {}, max_mm: {}, home: {}, {}: {}, full_steps_per_rev: {}, "
        "microsteps: {}, rail_friction_n: {:.2f}}}\n",
        "xyz"[i],
        axis.min_mm,
        axis.max_mm,
        i == 2 ? "max" : "min",
        axis.is_belt ? "pulley_mm_per_rev" : "lead_mm",
        axis.lead_mm,
        axis.full_steps_per_rev,
        words.microsteps > 0 ? words.microsteps : axis.microsteps,
        axis.friction_n);
  }
  text += fmt::format("probe: {{tip_radius_mm: {}, pretravel_mm: {}}}\n",
                      drawing.tip_radius_cfg_mm + words.tip_growth_mm,
                      words.pretravel_mm);
  text += fmt::format("settings: {{tip_radius_mm: {}}}\n", drawing.tip_radius_cfg_mm);
  return text;
}

void WriteCase(const Case& made, const std::string& folder) {
  const std::filesystem::path path(folder);
  std::filesystem::create_directories(path);
  WriteText(path / "DATA.csv", DataCsv(made));
  if (!made.blemishes.missing.contains("header")) {
    WriteText(path / "DATA.yaml", DataYaml(made));
  }
  const MachineWords words{.model = made.request.physics ? "model.xml" : ""};
  WriteText(path / "machine.yaml", MachineYaml(made.drawing, words));
}

void WriteTruth(const Case& made, const std::string& folder) {
  WriteText(std::filesystem::path(folder) / "TRUTH.json", TruthJson(made));
}

}  // namespace blind
