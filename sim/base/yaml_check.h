#pragma once

#include <string>

#include <yaml-cpp/yaml.h>

#include "sim/base/input_error.h"

namespace caltwin {

/// Refuses flow nesting beyond 64 brackets and lines beyond 10 000 characters, by which
/// yaml-cpp takes time beyond reason: before it sees the text. Comments do not count.
void CheckYamlShape(const std::string& text, const std::string& name);

/// Refuses, before a tree is built of it, what this project's files may not hold and
/// yaml-cpp would take in silence: anchors and aliases (which unfold to any size),
/// tags, a second document, nesting beyond 32 levels. The first such fault is thrown
/// as InputError with its place; a syntax error as YAML::Exception.
void CheckYamlEvents(const std::string& text, const std::string& name);

/// Adds a fault for each key that stands twice in one mapping, or is itself a list or a
/// mapping.
void CheckYamlKeys(const YAML::Node& node, const std::string& name, Faults* faults);

/// Where a node stands; line and column from 1.
Place YamlPlace(const std::string& name, const YAML::Mark& mark);

}  // namespace caltwin
