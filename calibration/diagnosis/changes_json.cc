#include "calibration/diagnosis/changes_json.h"

#include <cmath>

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

Json NumberOrNull(double value, bool is_determined) {
  return std::isfinite(value) && is_determined ? Json(value) : Json(nullptr);
}

}  // namespace

Json ChangesJson(const std::vector<Change>& changes) {
  Json list = Json::array();
  for (const Change& change : changes) {
    list.push_back(
        {{"name", change.name},
         {"unit", change.unit},
         {"before", NumberOrNull(change.before, change.before_is_determined)},
         {"before_sd", NumberOrNull(change.before_sd, change.before_is_determined)},
         {"now", NumberOrNull(change.now, change.now_is_determined)},
         {"now_sd", NumberOrNull(change.now_sd, change.now_is_determined)},
         {"sigmas", NumberOrNull(change.sigmas, change.IsCompared())},
         {"more_than_noise", change.is_more_than_noise}});
  }
  return list;
}

}  // namespace caltwin
