#pragma once

#include <string_view>

#include "sim/link/link.h"

namespace caltwin {

/// Instruments of a machine that has none, and a person who says yes and does nothing:
/// acts that an external program asks for are answered with a fault.
class NoGauges : public Gauge {
 public:
  Expected<double> Read_mm(std::string_view id) override;
  Expected<void> Zero(std::string_view id) override;
};
class NoHands : public Operator {
 public:
  Expected<void> Do(const Act& act) override;
};

}  // namespace caltwin
