#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace blind {

/// What is to be hidden in a printer's data. Kind: null, single, pair (any two) or
/// outside.
struct PrinterRequest {
  std::string kind = "null";
  std::string cause{}, axis{};      ///< Empty: drawn.
  double sigma = 5;                 ///< Near-peak over the noise of a reading.
  double wander_um_per_sqrt_h = 0;  ///< Of the nozzle along z: nobody's finding.
  std::uint64_t seed = 1;
};

/// A kind of printer with a truth of its own.
struct PrinterKind {
  std::string name{};  ///< "delta", as its program is called.
  /// Names of the causes that may be hidden: of the catalogue, or outside it.
  std::function<std::vector<std::string>(bool is_outside)> causes{};
  /// Makes a case, writes DATA.csv, machine.yaml and TRUTH.json; returns the truth.
  std::function<nlohmann::json(const PrinterRequest& request,
                               const std::string& folder)>
      write{};
  bool has_pairs = false;  ///< Whether `write` knows pairs and wander.
};

/// Hides causes, has them diagnosed, and only here opens the truth. With --out it
/// writes one case and stops.
int PrinterMain(int argc, char** argv, const PrinterKind& printer);

}  // namespace blind
