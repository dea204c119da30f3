#pragma once

#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace caltwin {

/// The part of an object model that a key of M409 names: "move.axes[0].homed",
/// "move.axes[].letter" (an array of every axis's), "" (all of it). Null where there is
/// no such part.
nlohmann::ordered_json FindInModel(const nlohmann::ordered_json& model,
                                   std::string_view key);

}  // namespace caltwin
