#include "tools/commands/closed_loop.h"

#include <memory>
#include <string_view>

#include <fmt/format.h>

#include "scenarios/interrupt.h"
#include "sim/base/input_error.h"
#include "sim/measure/in_force.h"
#include "sim/measure/plan_kinds.h"
#include "sim/measure/rows.h"
#include "tools/commands/kinds/performer.h"
#include "tools/commands/twin_options.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kTwin = "twin:";

void RequireTwin(const std::string& url) {
  if (url.starts_with(kTwin)) return;
  for (const std::string_view scheme : {"serial:", "tcp:", "transcript:"}) {
    if (!url.starts_with(scheme)) continue;
    throw InputError(
        {.file = "--closed-loop"},
        fmt::format("'{}' cannot measure campaigns: over a link nobody lays plates and "
                    "rings on its table or sets up a laser",
                    url),
        "diagnose the rows at hand; `next_campaign` says what to measure next, and "
        "`caltwin plan` how. A twin does all that: twin:M.yaml?truth=T.yaml");
  }
  throw InputError({.file = "--closed-loop"},
                   fmt::format("'{}' is no machine", url),
                   "give twin:M.yaml?truth=T.yaml, with &fidelity=fast and &seed=7 if "
                   "need be");
}

}  // namespace

MachineUnderTest MachineAt(const std::string& url) {
  RequireTwin(url);
  const TwinOptions options = TwinOptionsOf(url);
  const MachineFile file =
      ReadMachineWithTip(FindMachine(options.machine, "", {.file = options.machine}));
  const Performer performer = PerformerOf(file, options);
  const Machine& machine = performer.machine;
  const Measurer measure = [perform = performer.perform](const MeasuredSession& session,
                                                         std::size_t already_read) {
    return perform({.header = session.header,
                    .already_read = already_read,
                    .interrupted = InterruptRequested},
                   session.table.rows);
  };
  return {.machine = options.machine,
          .settings = AsHeader(machine.settings, *machine.kind),
          .measure = measure};
}

void CheckLoop(const std::string& data,
               const std::string& url,
               const std::string& record) {
  if (data.empty() && url.empty()) {
    throw InputError({.file = "DATA"},
                     "no rows to diagnose",
                     "give a file of rows, or --closed-loop 'twin:M.yaml?truth=T.yaml' "
                     "to measure them");
  }
  if (!url.empty()) RequireTwin(url);
  if (record.empty()) return;
  if (fs::path(record).extension() != ".csv") {
    throw InputError({.file = "--record"},
                     fmt::format("'{}' does not end in .csv", record),
                     "rows are written there, and what explains them beside it, in a "
                     ".yaml of the same name");
  }
}

DataHeader WithUsualInstruments(DataHeader header) {
  const Instrument laser{.kind = "laser", .sigma_um = 1, .resolution_um = 0.1};
  header.instruments.try_emplace("laser", laser);
  for (const CampaignKind& kind : AllCampaignKinds()) {
    const std::string id(kind.instrument);
    header.instruments.try_emplace(id, Instrument{.kind = id, .sigma_um = 1});
  }
  return header;
}

void Record(const fs::path& file,
            const fs::path& machine,
            const MeasuredSession& session) {
  const fs::path header_file = fs::path(file).replace_extension(".yaml");
  DataHeader header = session.header;
  header.machine =
      fs::proximate(fs::absolute(machine), fs::absolute(header_file).parent_path())
          .generic_string();
  WriteRows(file, session.table);
  WriteDataHeader(header_file, header);
}

}  // namespace caltwin
