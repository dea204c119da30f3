#include "renders/html.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr int kMostDecimals = 9;

/// Decimals with which `resolution` shows two significant digits; -1: unknown.
int Decimals(double resolution) {
  if (!std::isfinite(resolution) || resolution <= 0) return -1;
  const int exponent = static_cast<int>(std::floor(std::log10(resolution)));
  return std::clamp(1 - exponent, 0, kMostDecimals);
}

/// "-0.00" says a sign that the digits do not have.
std::string WithoutNegativeZero(std::string text) {
  const bool is_zero = text.find_first_of("123456789") == std::string::npos;
  if (is_zero && !text.empty() && text[0] == '-') text.erase(0, 1);
  return text;
}

}  // namespace

std::string Escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string SentenceHtml(std::string_view text) {
  constexpr std::string_view kPlusMinus = "+-";
  constexpr std::string_view kMicro = " um";
  std::string set;
  const auto is_of_word = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
  };
  for (std::size_t i = 0; i < text.size();) {
    const std::string_view rest = text.substr(i);
    const bool is_micro =
        rest.starts_with(kMicro) &&
        (rest.size() == kMicro.size() || !is_of_word(rest[kMicro.size()]));
    if (is_micro) {
      set += " µm";
      i += kMicro.size();
    } else if (rest.starts_with(kPlusMinus)) {
      set += "±";
      i += kPlusMinus.size();
    } else {
      set += text[i++];
    }
  }
  return Escaped(set);
}

std::string JsonForScript(const nlohmann::json& json) {
  const std::string text =
      json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    if (c == '<' || c == '>' || c == '&') {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out;
}

std::string Base64(std::string_view bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t start = 0; start < bytes.size(); start += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - start);
    std::uint32_t group = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto byte = i < count ? static_cast<unsigned char>(bytes[start + i]) : 0;
      group = (group << 8) | byte;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t digit = (group >> (18 - 6 * i)) & 63;
      out += i <= count ? kDigits[digit] : '=';
    }
  }
  return out;
}

std::string NumberText(double value, double resolution) {
  if (!std::isfinite(value)) return "–";
  const int decimals = Decimals(resolution);
  return WithoutNegativeZero(decimals < 0 ? fmt::format("{:.5g}", value)
                                          : fmt::format("{:.{}f}", value, decimals));
}

std::string SignedText(double value, double resolution) {
  const std::string text = NumberText(value, resolution);
  const bool is_positive = text.find_first_of("123456789") != std::string::npos;
  return is_positive && text[0] != '-' ? "+" + text : text;
}

std::string LengthText(double length_mm) {
  const double length_um = UmFromMm(length_mm);
  if (!std::isfinite(length_mm)) return "–";
  if (std::abs(length_um) >= 999.5) return fmt::format("{:.3g} mm", length_mm);
  if (std::abs(length_um) < 0.01) return "under 0.01 µm";
  return fmt::format("{:.3g} µm", length_um);
}

std::string DurationText(double seconds_s) {
  constexpr double kMinute_s = 60, kHour_s = 3600;
  if (!std::isfinite(seconds_s) || seconds_s < 0) return "–";
  if (seconds_s < kMinute_s) return fmt::format("{:.3g} s", seconds_s);
  const double whole_s = std::round(seconds_s);
  if (whole_s < kHour_s) {
    return fmt::format("{:.0f} min {:.0f} s",
                       std::floor(whole_s / kMinute_s),
                       std::fmod(whole_s, kMinute_s));
  }
  return fmt::format("{:.0f} h {:.0f} min",
                     std::floor(whole_s / kHour_s),
                     std::floor(std::fmod(whole_s, kHour_s) / kMinute_s));
}

}  // namespace caltwin
