#include "calibration/diagnosis/changes_json.h"

#include <cmath>

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

Json NumberOrNull(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

}  // namespace

Json ChangesJson(const std::vector<Change>& changes) {
  Json list = Json::array();
  for (const Change& change : changes) {
    list.push_back({{"name", change.name},
                    {"unit", change.unit},
                    {"before", NumberOrNull(change.before)},
                    {"before_sd", NumberOrNull(change.before_sd)},
                    {"now", NumberOrNull(change.now)},
                    {"now_sd", NumberOrNull(change.now_sd)},
                    {"sigmas", NumberOrNull(change.sigmas)},
                    {"more_than_noise", change.is_more_than_noise}});
  }
  return list;
}

}  // namespace caltwin
