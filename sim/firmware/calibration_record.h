#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace caltwin {

/// What a motor controller keeps of one axis: the nine fields of the published record.
/// Units: mm, of a rotary axis deg; pulses of the motor's own counter.
///
/// Two fields differ in type from the published ones, which cannot hold what is
/// measured (see PublishedCalibration): pulses per mm and backlash are fractional here,
/// and a backlash may be negative.
struct AxisCalibration {
  double pulses_per_unit = 1000;         ///< Pulses per mm or deg; 0.001 to 1e7.
  std::uint32_t pulses_per_rev = 10000;  ///< Per motor turn; 0 only without index.
  std::int32_t home_offset_pulses = 0;   ///< From where the switch acts to zero.
  std::int32_t min_position_pulses = 0;  ///< Software limit, counted from zero.
  std::int32_t max_position_pulses = 1'000'000;  ///< Likewise; above the other.
  double backlash_pulses = 0;                    ///< Compensated; -1e6 to 1e6.
  bool index_enabled = true;                     ///< The published z_signal_enabled.
  double max_velocity_pulses_s = 200'000;        ///< 1e-3 to 1e9.
  double max_acceleration_pulses_s2 = 1e6;       ///< 1e-3 to 1e12.

  friend bool operator==(const AxisCalibration&, const AxisCalibration&) = default;
};

/// Every field that is out of its range, a sentence each: what it is, what is allowed.
std::vector<std::string> RangeFaults(const AxisCalibration& record);

/// The record as published: whole pulses per mm, whole and unsigned backlash. Kept to
/// show what that costs.
struct PublishedCalibration {
  std::uint32_t pulses_per_mm = 0;
  std::uint16_t backlash_pulses = 0;
};
/// What C's conversions make of the values: the fraction is dropped, a backlash wraps
/// modulo 65536.
PublishedCalibration AsPublished(const AxisCalibration& record);

/// CRC-32 of IEEE 802.3 (reflected 0xEDB88320, as in zip and PNG); of "123456789" it is
/// 0xCBF43926.
std::uint32_t Crc32(std::span<const std::uint8_t> bytes);

inline constexpr std::size_t kRecordBytes = 49;
using RecordBytes = std::array<std::uint8_t, kRecordBytes>;
/// Little-endian, doubles as IEEE 754, in the order of the fields.
RecordBytes Encode(const AxisCalibration& record);
/// nullopt where a field is out of its range.
std::optional<AxisCalibration> Decode(std::span<const std::uint8_t, kRecordBytes> from);

}  // namespace caltwin
