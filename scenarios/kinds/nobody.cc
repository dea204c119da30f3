#include "scenarios/kinds/nobody.h"

#include <fmt/format.h>

namespace caltwin {
namespace {

MachineFault HasNone(std::string_view what) {
  return {.reply = fmt::format("Error: this machine has no {}", what)};
}

}  // namespace

Expected<double> NoGauges::Read_mm(std::string_view id) {
  return tl::unexpected(HasNone(id));
}

Expected<void> NoGauges::Zero(std::string_view id) {
  return tl::unexpected(HasNone(id));
}

Expected<void> NoHands::Do(const Act& act) {
  if (act.kind == Act::Kind::kConfirm) return {};
  return tl::unexpected(HasNone("operator"));
}

}  // namespace caltwin
