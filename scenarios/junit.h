#pragma once

#include <span>
#include <string>

#include "scenarios/result.h"

namespace caltwin {

/// The runs as a JUnit XML file, as CI servers read it: a test suite a run, in it a
/// test case for each expectation. A run whose process was lost has an `error`, a
/// failed expectation a `failure` that says what was expected and found.
std::string JUnitText(std::span<const RunResult> results);

/// Text as XML wants it: & < > " ' escaped, control characters (which no XML 1.0 can
/// carry) replaced by a question mark.
std::string XmlEscaped(const std::string& text);

}  // namespace caltwin
