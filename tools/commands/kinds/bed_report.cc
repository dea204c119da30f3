#include "tools/commands/kinds/bed_report.h"

#include <fmt/format.h>

#include "renders/html.h"

namespace caltwin {
namespace {

constexpr const char* kHead =
    "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" "
    "content=\"width=device-width\"><title>Bed of "
    "{0}</title><style>body{{font:16px/1.5 "
    "system-ui,sans-serif;max-width:48rem;margin:2rem auto;padding:0 1rem;color-scheme:"
    "light dark}}table{{border-collapse:collapse;margin:1rem 0}}th,td{{padding:.2rem "
    ".8rem;text-align:right;border-bottom:1px solid "
    "#8886}}th:first-child,td:first-child"
    "{{text-align:left}}</style><h1>Bed of {0}</h1>";

std::string Row(const std::string& what, const std::string& value) {
  return fmt::format("<tr><td>{}</td><td>{}</td></tr>", what, value);
}

std::string Touches(const BedFound& found) {
  std::string rows =
      "<h3>Touches</h3><table><tr><th>x</th><th>y</th><th>z</th>"
      "<th>beside the plane</th></tr>";
  for (std::size_t i = 0; i < found.touches.size(); ++i) {
    const BedTouch& touch = found.touches[i];
    rows += fmt::format(
        "<tr><td>{:.1f}</td><td>{:.1f}</td><td>{:.4f}</td><td>{:+.4f} mm</td></tr>",
        touch.at_mm[0],
        touch.at_mm[1],
        touch.height_mm,
        touch.height_mm - found.plane.At_mm(touch.at_mm));
  }
  return rows + "</table>";
}

std::string Section(const BedFound& found) {
  const BedPlane& plane = found.plane;
  std::string html =
      fmt::format("<h2>{}, {} touches</h2>", Escaped(found.at), plane.points);
  for (const std::string& note : found.notes) html += "<p>" + Escaped(note) + "</p>";
  html +=
      "<table>" +
      Row("z = a x + b y + c",
          fmt::format(
              "{:.6f} x {:+.6f} y {:+.4f} mm", plane.a(), plane.b(), plane.c_mm())) +
      Row("tilt along x, along y, in all",
          fmt::format("{:.4f}, {:.4f}, {:.4f} deg",
                      plane.TiltX_deg(),
                      plane.TiltY_deg(),
                      plane.Tilt_deg())) +
      Row("raise z1, z2, z3 by",
          fmt::format("{:.4f}, {:.4f}, {:.4f} mm",
                      found.offsets_mm[0],
                      found.offsets_mm[1],
                      found.offsets_mm[2])) +
      Row("residual",
          plane.fit.dof > 0 ? fmt::format("{:.4f} mm rms", Residual_mm(found))
                            : std::string("not known: three points fit any plane")) +
      "</table>";
  return html + Touches(found);
}

}  // namespace

std::string BedReportHtml(const std::string& machine,
                          const BedStore& store,
                          const Pivots<double>& pivots_mm) {
  std::string html = fmt::format(fmt::runtime(kHead), Escaped(machine));
  if (store.found.empty()) return html + "<p>No bed was measured yet.</p></html>\n";
  const BedPlane now = PlaneNow(store, pivots_mm);
  if (store.applied_mm) {
    html += fmt::format(
        "<p>The screws were raised by {:.4f}, {:.4f} and {:.4f} mm since; the bed then "
        "stands {:.4f} deg off level, as far as the touches tell.</p>",
        (*store.applied_mm)[0],
        (*store.applied_mm)[1],
        (*store.applied_mm)[2],
        now.Tilt_deg());
  } else {
    html += "<p>Nothing was applied since the last calibration.</p>";
  }
  for (auto one = store.found.rbegin(); one != store.found.rend(); ++one) {
    html += Section(*one);
  }
  return html + "</html>\n";
}

}  // namespace caltwin
