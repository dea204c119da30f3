#pragma once

#include <string>

#include <gtest/gtest.h>

#include "calibration/loop/bench.h"
#include "calibration/procedures/catalog.h"
#include "tests/calibration/toy_machine.h"

namespace caltwin::testing {

/// A toy machine with a 1-2-3 block in its middle, and the bench before it.
struct ToyBench {
  ToyMachine machine{};
  RowTable rows{};
  Bench bench{};

  ToyBench() {
    machine.artefacts = {{.id = "block", .at_mm = {150, 150, 0}}};
    bench = {.link = &machine,
             .gauge = &machine,
             .person = &machine,
             .machine = machine.machine,
             .artefacts = machine.artefacts,
             .record = &rows};
  }
  ToyBench(const ToyBench&) = delete;
  ToyBench& operator=(const ToyBench&) = delete;
};

/// Prepares a procedure from the options as a scenario writes them, and runs it.
inline ProcedureResult RunStep(const Procedure& procedure,
                               const std::string& options,
                               ToyBench* toy) {
  Faults faults;
  YamlMap map = ReadYamlText(options, "options.yaml", &faults);
  const PreparedProcedure run = procedure.prepare(map, toy->bench.machine);
  faults.ThrowIfAny();
  return run(&toy->bench);
}

}  // namespace caltwin::testing
