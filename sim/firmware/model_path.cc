#include "sim/firmware/model_path.h"

#include <algorithm>
#include <charconv>
#include <string>

#include <nlohmann/json.hpp>

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

Json FindInArray(const Json& array, std::string_view key);

}  // namespace

Json FindInModel(const Json& model, std::string_view key) {
  if (key.empty()) return model;
  if (key.front() == '[') return FindInArray(model, key);
  if (key.front() == '.') key.remove_prefix(1);
  const std::size_t end = std::min(key.find_first_of(".["), key.size());
  const std::string name(key.substr(0, end));
  if (!model.is_object() || !model.contains(name)) return nullptr;
  return FindInModel(model.at(name), key.substr(end));
}

namespace {

Json FindInArray(const Json& array, std::string_view key) {
  const std::size_t close = key.find(']');
  if (!array.is_array() || close == std::string_view::npos) return nullptr;
  const std::string_view inside = key.substr(1, close - 1);
  const std::string_view rest = key.substr(close + 1);
  if (inside.empty()) {
    Json each = Json::array();
    for (const Json& element : array) each.push_back(FindInModel(element, rest));
    return each;
  }
  std::size_t index = 0;
  const auto [stop, error] =
      std::from_chars(inside.data(), inside.data() + inside.size(), index);
  if (error != std::errc() || stop != inside.data() + inside.size() ||
      index >= array.size()) {
    return nullptr;
  }
  return FindInModel(array[index], rest);
}

}  // namespace
}  // namespace caltwin
