#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace caltwin {

/// `text` as HTML shows it, in an element or in a quoted attribute: & < > " ' become
/// entities, so that nothing a scenario says is taken for markup.
std::string Escaped(std::string_view text);

/// A sentence as HTML: escaped, and set as people write it: "+-" becomes a plus-minus
/// sign, "um" after a number or a space its Greek letter.
std::string SentenceHtml(std::string_view text);

/// JSON that may stand between <script> tags: every <, > and & is written as \u00xx,
/// so that no string in it can end the element. Bytes that are no UTF-8 are replaced.
std::string JsonForScript(const nlohmann::json& json);

/// RFC 4648 base64, with padding.
std::string Base64(std::string_view bytes);

/// `value` with as many decimals as `resolution` needs to show two digits: 800.0123
/// with 0.02 is "800.012". Resolution 0 or unknown: five significant digits. Not a
/// number: a dash.
std::string NumberText(double value, double resolution);
/// The same with its sign, + included.
std::string SignedText(double value, double resolution);

/// A small length in the unit that suits its size: "1.43 mm", "4.1 µm", "0.02 µm".
std::string LengthText(double length_mm);

/// A duration for people: "42 s", "8 min 32 s", "2 h 5 min".
std::string DurationText(double seconds_s);

}  // namespace caltwin
