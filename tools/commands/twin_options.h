#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenarios/machine_file.h"
#include "sim/machine/artefact.h"
#include "sim/twin/twin.h"

namespace caltwin {

/// A twin as the command line names it: a machine and, perhaps, a truth file.
struct TwinOptions {
  std::string machine = "gantry_router";  ///< A name or a path.
  std::string truth{};                    ///< A file; empty: built as drawn.
  std::string fidelity = "physics";
  std::uint64_t seed = 1;
  std::vector<Artefact> artefacts{};
  Instruments instruments{};
};

/// Reads the files. Throws InputError, of printers too: those that measure rows but
/// speak no G-code here only `only_measures` takes.
TwinConfig MakeTwinConfig(const TwinOptions& options, bool only_measures = false);

/// By how much one touch of the probe scatters [mm]; 0 where nobody stated it.
double ProbeSigma_mm(const Instruments& instruments);

/// Reads `twin:M.yaml?truth=T.yaml&fidelity=fast&seed=7`. Throws InputError.
TwinOptions TwinOptionsOf(const std::string& url);

/// Reads a file with `artefacts` and `instruments` of a scenario, nothing else.
void ReadBenchFile(const std::string& file, TwinOptions* options);

/// What lies on the table where nobody says: the 1-2-3 block in the middle, 76.2 mm
/// along x.
std::vector<Artefact> UsualArtefacts(const Machine& machine);

}  // namespace caltwin
