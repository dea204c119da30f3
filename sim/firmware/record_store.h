#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/firmware/calibration_record.h"
#include "sim/firmware/flash.h"

namespace caltwin {

/// One thing that happened to the stored calibration.
struct HistoryEntry {
  enum class Kind : std::uint8_t {
    kCalibrated = 1,    ///< A record was stored.
    kFactoryReset = 2,  ///< What was stored before counts no more.
    kNote = 3           ///< A line of the error log.
  };
  Kind kind = Kind::kNote;
  std::uint8_t axis = 0;                    ///< kAllAxes: every one.
  std::uint32_t sequence = 0;               ///< Running number over the store's life.
  std::int64_t unix_s = 0;                  ///< When, seconds since 1970 (UTC).
  std::optional<AxisCalibration> record{};  ///< Of kCalibrated.
  std::string note{};                       ///< Of kNote, at most 100 bytes.
};
inline constexpr std::uint8_t kAllAxes = 0xFF;
inline constexpr std::uint8_t kMostAxes = 16;

/// Calibration records of a controller's axes in flash, and their history.
///
/// Entries of 128 bytes, each with a CRC-32, are appended to one of two sectors; the
/// newest valid one of an axis is in force. A cut of the power leaves at most one torn
/// entry, which fails its checksum and is skipped: the older stays in force. Where a
/// sector is full, what is in force and the newest of the history go to the other one,
/// which counts only once its header, written last, is whole.
class RecordStore {
 public:
  /// @param flash  borrowed; read as it is
  explicit RecordStore(Flash* flash);

  /// The record in force; nullopt: none since it was new, or since a factory reset.
  std::optional<AxisCalibration> Record(std::uint8_t axis) const;
  /// What is still kept, oldest first. Entries moved to another sector keep their time.
  const std::vector<HistoryEntry>& history() const { return history_; }

  /// @name Each: false where the power went; then the store is to be read anew
  /// Stores what has no RangeFaults (required).
  bool Store(std::uint8_t axis, const AxisCalibration& record, std::int64_t unix_s);
  bool FactoryReset(std::uint8_t axis, std::int64_t unix_s);
  bool Note(std::uint8_t axis, const std::string& text, std::int64_t unix_s);

 private:
  void ReadSector();
  bool Append(HistoryEntry entry);
  bool Write(const HistoryEntry& entry);
  bool MoveToOtherSector();
  bool IsInForce(const HistoryEntry& entry) const;

  Flash* flash_;
  std::size_t sector_ = 0;
  std::uint32_t generation_ = 0;  ///< Of the sector's header; 0: none yet.
  std::size_t next_slot_ = 1;
  std::uint32_t sequence_ = 0;
  std::vector<HistoryEntry> history_{};
};

}  // namespace caltwin
