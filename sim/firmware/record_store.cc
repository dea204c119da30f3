#include "sim/firmware/record_store.h"

#include <algorithm>
#include <array>

#include "sim/base/require.h"
#include "sim/firmware/little_endian.h"

namespace caltwin {
namespace {

using Kind = HistoryEntry::Kind;

constexpr std::size_t kSlotBytes = 128;
constexpr std::size_t kSlots = Flash::kSectorBytes / kSlotBytes;
constexpr std::size_t kMostNoteBytes = 100;
constexpr std::size_t kKept = 24;                   // Of the history, when it moves.
constexpr std::uint32_t kEntryMagic = 0x4C414331;   // "1CAL"
constexpr std::uint32_t kHeaderMagic = 0x44414548;  // "HEAD"

// Where each field stands in a slot.
constexpr std::size_t kMagicAt = 0, kKindAt = 4, kAxisAt = 5, kSizeAt = 6,
                      kSequenceAt = 8, kTimeAt = 12, kPayloadAt = 20, kCrcAt = 124;

using Slot = std::array<std::uint8_t, kSlotBytes>;

void Put(Slot* slot, std::size_t at, std::size_t size, std::uint64_t value) {
  PutLittle(value, std::span(*slot).subspan(at, size));
}

std::uint64_t Get(std::span<const std::uint8_t> slot, std::size_t at, std::size_t n) {
  return GetLittle(slot.subspan(at, n));
}

void Seal(Slot* slot) {
  Put(slot, kCrcAt, 4, Crc32(std::span(*slot).first(kCrcAt)));
}

bool IsWhole(std::span<const std::uint8_t> slot, std::uint32_t magic) {
  if (Get(slot, kMagicAt, 4) != magic) return false;
  const bool is_right = Get(slot, kCrcAt, 4) == Crc32(slot.first(kCrcAt));
  return is_right;
}

bool IsBlank(std::span<const std::uint8_t> slot) {
  return std::ranges::all_of(slot,
                             [](std::uint8_t byte) { return byte == Flash::kErased; });
}

std::optional<HistoryEntry> EntryOf(std::span<const std::uint8_t> slot) {
  if (!IsWhole(slot, kEntryMagic)) return std::nullopt;
  HistoryEntry entry{.kind = static_cast<Kind>(Get(slot, kKindAt, 1)),
                     .axis = static_cast<std::uint8_t>(Get(slot, kAxisAt, 1)),
                     .sequence = static_cast<std::uint32_t>(Get(slot, kSequenceAt, 4)),
                     .unix_s = static_cast<std::int64_t>(Get(slot, kTimeAt, 8))};
  if (entry.kind == Kind::kCalibrated) {
    entry.record = Decode(slot.subspan<kPayloadAt, kRecordBytes>());
    if (!entry.record) return std::nullopt;
  }
  if (entry.kind == Kind::kNote) {
    const auto size = std::min<std::size_t>(Get(slot, kSizeAt, 2), kMostNoteBytes);
    const auto text = slot.subspan(kPayloadAt, size);
    entry.note.assign(text.begin(), text.end());
  }
  return entry;
}

Slot SlotOf(const HistoryEntry& entry) {
  Slot slot{};
  Put(&slot, kMagicAt, 4, kEntryMagic);
  Put(&slot, kKindAt, 1, static_cast<std::uint8_t>(entry.kind));
  Put(&slot, kAxisAt, 1, entry.axis);
  Put(&slot, kSequenceAt, 4, entry.sequence);
  Put(&slot, kTimeAt, 8, static_cast<std::uint64_t>(entry.unix_s));
  if (entry.record) {
    std::ranges::copy(Encode(*entry.record), slot.begin() + kPayloadAt);
  }
  Put(&slot, kSizeAt, 2, entry.note.size());
  std::ranges::copy(entry.note, slot.begin() + kPayloadAt);
  Seal(&slot);
  return slot;
}

std::uint32_t GenerationOf(const Flash& flash, std::size_t sector) {
  const auto header = flash.Read(sector * Flash::kSectorBytes, kSlotBytes);
  if (!IsWhole(header, kHeaderMagic)) return 0;
  return static_cast<std::uint32_t>(Get(header, kSequenceAt, 4));
}

bool WriteHeader(Flash* flash, std::size_t sector, std::uint32_t generation) {
  Slot header{};
  Put(&header, kMagicAt, 4, kHeaderMagic);
  Put(&header, kSequenceAt, 4, generation);
  Seal(&header);
  return flash->Program(sector * Flash::kSectorBytes, header);
}

}  // namespace

RecordStore::RecordStore(Flash* flash) : flash_(flash) {
  for (std::size_t sector = 0; sector < Flash::kSectors; ++sector) {
    const std::uint32_t generation = GenerationOf(*flash, sector);
    if (generation <= generation_) continue;
    generation_ = generation;
    sector_ = sector;
  }
  if (generation_ > 0) ReadSector();
}

void RecordStore::ReadSector() {
  for (std::size_t i = 1; i < kSlots; ++i) {
    const auto slot =
        flash_->Read(sector_ * Flash::kSectorBytes + i * kSlotBytes, kSlotBytes);
    if (!IsBlank(slot)) next_slot_ = i + 1;
    auto entry = EntryOf(slot);
    if (!entry) continue;
    sequence_ = std::max(sequence_, entry->sequence);
    history_.push_back(*std::move(entry));
  }
}

std::optional<AxisCalibration> RecordStore::Record(std::uint8_t axis) const {
  for (auto entry = history_.rbegin(); entry != history_.rend(); ++entry) {
    const bool is_mine = entry->axis == axis || entry->axis == kAllAxes;
    if (is_mine && entry->kind == Kind::kCalibrated) return entry->record;
    if (is_mine && entry->kind == Kind::kFactoryReset) return std::nullopt;
  }
  return std::nullopt;
}

bool RecordStore::IsInForce(const HistoryEntry& entry) const {
  if (entry.kind != Kind::kCalibrated) return false;
  return std::ranges::none_of(history_, [&](const HistoryEntry& later) {
    return later.sequence > entry.sequence && later.kind != Kind::kNote &&
           (later.axis == entry.axis || later.axis == kAllAxes);
  });
}

bool RecordStore::Write(const HistoryEntry& entry) {
  const std::size_t at = sector_ * Flash::kSectorBytes + next_slot_ * kSlotBytes;
  ++next_slot_;
  return flash_->Program(at, SlotOf(entry));
}

bool RecordStore::MoveToOtherSector() {
  std::vector<HistoryEntry> kept;
  for (std::size_t i = 0; i < history_.size(); ++i) {
    const bool is_new = i + kKept >= history_.size();
    if (is_new || IsInForce(history_[i])) kept.push_back(history_[i]);
  }
  const std::size_t other = generation_ == 0 ? 0 : 1 - sector_;
  if (!flash_->Erase(other)) return false;
  sector_ = other;
  next_slot_ = 1;
  ++generation_;
  for (const HistoryEntry& entry : kept) {
    if (!Write(entry)) return false;
  }
  history_ = std::move(kept);
  return WriteHeader(flash_, sector_, generation_);
}

bool RecordStore::Append(HistoryEntry entry) {
  if (generation_ == 0 || next_slot_ >= kSlots) {
    if (!MoveToOtherSector()) return false;
  }
  entry.sequence = ++sequence_;
  if (!Write(entry)) return false;
  history_.push_back(std::move(entry));
  return true;
}

bool RecordStore::Store(std::uint8_t axis,
                        const AxisCalibration& record,
                        std::int64_t unix_s) {
  Require(axis < kMostAxes, "the store has that axis");
  Require(RangeFaults(record).empty(), "a record is checked before it is stored");
  return Append(
      {.kind = Kind::kCalibrated, .axis = axis, .unix_s = unix_s, .record = record});
}

bool RecordStore::FactoryReset(std::uint8_t axis, std::int64_t unix_s) {
  return Append({.kind = Kind::kFactoryReset, .axis = axis, .unix_s = unix_s});
}

bool RecordStore::Note(std::uint8_t axis,
                       const std::string& text,
                       std::int64_t unix_s) {
  return Append({.kind = Kind::kNote,
                 .axis = axis,
                 .unix_s = unix_s,
                 .note = text.substr(0, kMostNoteBytes)});
}

}  // namespace caltwin
