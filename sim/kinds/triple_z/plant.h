#pragma once

#include <memory>
#include <vector>

#include "sim/base/rng.h"
#include "sim/firmware/dialects/rrf_triple_z.h"
#include "sim/kinds/triple_z/machine.h"

namespace caltwin {

/// A triple-Z printer as it is built: what its firmware cannot know.
struct BuiltTripleZ {
  Machine machine{};
  std::vector<Injected> effects{};
  double scatter_mm = 0;  ///< Of the trigger, beside `trigger_scatter`.
};

/// A simulated triple-Z printer whose bed can be raised to its nozzle: closed form or
/// MuJoCo.
class TripleZTwinPlant : public TripleZPlant {
 public:
  /// @param is_physics  MuJoCo finds the trigger
  TripleZTwinPlant(const BuiltTripleZ& built,
                   bool is_physics,
                   std::uint64_t seed,
                   std::uint64_t sample);

  std::optional<double> Touch(const Vec3<double>& raised_mm,
                              double x_mm,
                              double y_mm) override;

  const BuiltTripleZ& built() const { return built_; }

 private:
  BuiltTripleZ built_;
  std::unique_ptr<TripleZMachine> machine_{};
  Rng scatter_;
};

/// Where the bed is truly touched over (x, y) with the screws raised so, noise apart:
/// what the closed forms say.
double TrueBedHeight_mm(const BuiltTripleZ& built,
                        const Vec3<double>& raised_mm,
                        const Eigen::Vector2d& at_mm);

}  // namespace caltwin
