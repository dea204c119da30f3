#include "sim/firmware/calibration_record.h"

#include <bit>
#include <cmath>

#include <fmt/format.h>

#include "sim/firmware/little_endian.h"

namespace caltwin {
namespace {

constexpr std::array<std::uint32_t, 256> MakeTable() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    std::uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
    }
    table[i] = crc;
  }
  return table;
}

struct Range {
  double least = 0, most = 0;
  bool Holds(double value) const {
    return std::isfinite(value) && value >= least && value <= most;
  }
};
constexpr Range kPulsesPerUnit{1e-3, 1e7};
constexpr Range kBacklash{-1e6, 1e6};
constexpr Range kVelocity{1e-3, 1e9};
constexpr Range kAcceleration{1e-3, 1e12};
constexpr std::uint32_t kMostPulsesPerRev = 100'000'000;

// Where each field stands in the bytes.
constexpr std::size_t kPulsesPerUnitAt = 0, kPulsesPerRevAt = 8, kHomeOffsetAt = 12,
                      kMinAt = 16, kMaxAt = 20, kBacklashAt = 24, kIndexAt = 32,
                      kVelocityAt = 33, kAccelerationAt = 41;

std::int32_t Signed(std::uint64_t bits) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(bits));
}

}  // namespace

std::vector<std::string> RangeFaults(const AxisCalibration& record) {
  std::vector<std::string> faults;
  const auto check = [&](const char* name, double value, const Range& range) {
    if (range.Holds(value)) return;
    faults.push_back(fmt::format(
        "{} = {:g}, allowed {:g} to {:g}", name, value, range.least, range.most));
  };
  check("pulses_per_unit", record.pulses_per_unit, kPulsesPerUnit);
  check("backlash_pulses", record.backlash_pulses, kBacklash);
  check("max_velocity_pulses_s", record.max_velocity_pulses_s, kVelocity);
  check("max_acceleration_pulses_s2", record.max_acceleration_pulses_s2, kAcceleration);
  if (record.pulses_per_rev > kMostPulsesPerRev) {
    faults.push_back(fmt::format("pulses_per_rev = {}, allowed 0 to {}",
                                 record.pulses_per_rev,
                                 kMostPulsesPerRev));
  }
  if (record.index_enabled && record.pulses_per_rev == 0) {
    faults.emplace_back("pulses_per_rev = 0, allowed only where no index is enabled");
  }
  if (record.min_position_pulses >= record.max_position_pulses) {
    faults.push_back(
        fmt::format("min_position_pulses = {}, allowed below max_position_pulses = {}",
                    record.min_position_pulses,
                    record.max_position_pulses));
  }
  return faults;
}

PublishedCalibration AsPublished(const AxisCalibration& record) {
  // Out of a uint16's range C leaves the cast open; what compilers do is this.
  const auto whole = static_cast<std::int64_t>(record.backlash_pulses);
  return {.pulses_per_mm = static_cast<std::uint32_t>(record.pulses_per_unit),
          .backlash_pulses = static_cast<std::uint16_t>(whole)};
}

std::uint32_t Crc32(std::span<const std::uint8_t> bytes) {
  static constexpr auto kTable = MakeTable();
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::uint8_t byte : bytes)
    crc = (crc >> 8U) ^ kTable[(crc ^ byte) & 0xFFU];
  return crc ^ 0xFFFFFFFFU;
}

RecordBytes Encode(const AxisCalibration& record) {
  RecordBytes bytes{};
  const std::span to(bytes);
  const auto put = [&](std::size_t at, std::size_t size, std::uint64_t value) {
    PutLittle(value, to.subspan(at, size));
  };
  const auto number = [&](std::size_t at, double value) {
    put(at, 8, std::bit_cast<std::uint64_t>(value));
  };
  number(kPulsesPerUnitAt, record.pulses_per_unit);
  put(kPulsesPerRevAt, 4, record.pulses_per_rev);
  put(kHomeOffsetAt, 4, static_cast<std::uint32_t>(record.home_offset_pulses));
  put(kMinAt, 4, static_cast<std::uint32_t>(record.min_position_pulses));
  put(kMaxAt, 4, static_cast<std::uint32_t>(record.max_position_pulses));
  number(kBacklashAt, record.backlash_pulses);
  put(kIndexAt, 1, record.index_enabled ? 1 : 0);
  number(kVelocityAt, record.max_velocity_pulses_s);
  number(kAccelerationAt, record.max_acceleration_pulses_s2);
  return bytes;
}

std::optional<AxisCalibration> Decode(
    std::span<const std::uint8_t, kRecordBytes> from) {
  const auto get = [&](std::size_t at, std::size_t size) {
    return GetLittle(from.subspan(at, size));
  };
  const auto number = [&](std::size_t at) {
    return std::bit_cast<double>(get(at, 8));
  };
  const AxisCalibration record{
      .pulses_per_unit = number(kPulsesPerUnitAt),
      .pulses_per_rev = static_cast<std::uint32_t>(get(kPulsesPerRevAt, 4)),
      .home_offset_pulses = Signed(get(kHomeOffsetAt, 4)),
      .min_position_pulses = Signed(get(kMinAt, 4)),
      .max_position_pulses = Signed(get(kMaxAt, 4)),
      .backlash_pulses = number(kBacklashAt),
      .index_enabled = get(kIndexAt, 1) != 0,
      .max_velocity_pulses_s = number(kVelocityAt),
      .max_acceleration_pulses_s2 = number(kAccelerationAt)};
  if (!RangeFaults(record).empty()) return std::nullopt;
  return record;
}

}  // namespace caltwin
