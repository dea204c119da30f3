#include "calibration/loop/user_vars.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "sim/link/gcode.h"

namespace caltwin {
namespace {

constexpr int kDecimals = 4;
constexpr double kPrinted = 0.00051;  // Controllers print three decimals.

std::string AxisWords(const char* command, const std::array<double, 3>& values) {
  return fmt::format("{} X{} Y{} Z{}",
                     command,
                     GcodeNumber(values[0], kDecimals),
                     GcodeNumber(values[1], kDecimals),
                     GcodeNumber(values[2], kDecimals));
}

void AddGlobal(const std::string& name,
               const std::string& value,
               std::vector<std::string>* lines) {
  lines->push_back(fmt::format("if !exists(global.{})", name));
  lines->push_back(fmt::format("  global {} = {}", name, value));
  lines->push_back("else");
  lines->push_back(fmt::format("  set global.{} = {}", name, value));
}

Expected<void> WriteFile(Session* session,
                         const std::string& file,
                         const std::vector<std::string>& lines) {
  const char* redirect = ">";
  for (const std::string& line : lines) {
    const auto sent = session->controller().Send(
        fmt::format("echo {}\"{}\" \"{}\"", redirect, file, line));
    if (!sent) return tl::unexpected(sent.error());
    redirect = ">>";
  }
  return {};
}

bool Near(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::ranges::equal(
      a, b, [](double x, double y) { return std::abs(x - y) < kPrinted; });
}

}  // namespace

std::vector<std::string> UserVarsLines(const Settings& settings,
                                       const std::string& date) {
  std::vector<std::string> lines = {"; Machine calibration data"};
  if (!date.empty()) lines.push_back("; Last calibrated: " + date);
  lines.push_back(AxisWords("M92", settings.steps_per_mm));
  lines.push_back(AxisWords("M425", settings.backlash_mm));
  const auto& deflection_mm = settings.probe_deflection_mm;
  AddGlobal("nxtProbeDeflection",
            fmt::format("{{{}, {}, {}}}",
                        GcodeNumber(deflection_mm[0], kDecimals),
                        GcodeNumber(deflection_mm[1], kDecimals),
                        GcodeNumber(deflection_mm[2], kDecimals)),
            &lines);
  AddGlobal(
      "nxtProbeTipRadius", GcodeNumber(settings.tip_radius_mm, kDecimals), &lines);
  return lines;
}

Expected<void> Persist(Session* session, const std::string& date) {
  const Settings wanted = session->believed();
  const auto backed_up = WriteFile(
      session, kUserVarsBackup, UserVarsLines(session->backup(), "before " + date));
  if (!backed_up) return backed_up;
  const auto written = WriteFile(session, kUserVarsFile, UserVarsLines(wanted, date));
  if (!written) return written;
  for (int i = 0; i < 2; ++i) {
    const auto run =
        session->controller().Send(fmt::format("M98 P\"{}\"", kUserVarsFile));
    if (!run) return tl::unexpected(run.error());
  }
  if (const auto read = session->controller().ReadSettings(); !read) return read;
  const Settings now = session->believed();
  if (!Near(now.steps_per_mm, wanted.steps_per_mm) ||
      !Near(now.backlash_mm, wanted.backlash_mm) ||
      !Near(now.probe_deflection_mm, wanted.probe_deflection_mm)) {
    return tl::unexpected(MachineFault{
        .kind = MachineFault::Kind::kRefused,
        .reply =
            fmt::format("{} does not read back as it was written", kUserVarsFile)});
  }
  session->controller().Remember(wanted);
  session->Tell({fmt::format("Kept in {}; it loads twice without error. The values "
                             "before stand in {}.",
                             kUserVarsFile,
                             kUserVarsBackup),
                 Message::Kind::kLog});
  return {};
}

}  // namespace caltwin
