#pragma once

#include "sim/firmware/record_store.h"

namespace caltwin {

inline AxisCalibration OldRecord() {
  return {.pulses_per_unit = 409.6,
          .pulses_per_rev = 4096,
          .home_offset_pulses = -1234,
          .min_position_pulses = -100,
          .max_position_pulses = 122'880,
          .backlash_pulses = 20.48,
          .index_enabled = true,
          .max_velocity_pulses_s = 81'920,
          .max_acceleration_pulses_s2 = 409'600};
}

inline AxisCalibration NewerRecord() {
  AxisCalibration record = OldRecord();
  record.pulses_per_unit = 409.725;
  record.backlash_pulses = -0.75;
  return record;
}

/// What cuts of the power left.
struct CutsTried {
  int cuts = 0;
  int kept_old = 0;
  int lost = 0;  ///< Neither old nor new, another axis harmed, or no writing again.
};

/// Cuts the power after every byte of storing a newer record of axis 0 where `before`
/// records of three axes were stored.
inline CutsTried TryEveryCut(int before) {
  Flash full;
  RecordStore filled(&full);
  for (int i = 0; i < before; ++i) {
    filled.Store(static_cast<std::uint8_t>(i % 3), OldRecord(), i);
  }
  Flash trial = full;
  RecordStore(&trial).Store(0, NewerRecord(), 9);
  const std::uint64_t bytes = trial.bytes_done() - full.bytes_done();
  CutsTried tried;
  for (std::uint64_t cut = 0; cut <= bytes; ++cut) {
    Flash flash = full;
    Rng rng(1, cut, "cut");
    flash.CutAfter(cut, &rng);
    const bool is_done = RecordStore(&flash).Store(0, NewerRecord(), 9);
    flash.PowerUp();
    const RecordStore after(&flash);
    const auto record = after.Record(0);
    const bool is_new = record == NewerRecord();
    const bool is_old = record == OldRecord() && !is_done;
    const bool others_stand = after.Record(1) == OldRecord();
    const bool goes_on = RecordStore(&flash).Store(0, NewerRecord(), 10) &&
                         RecordStore(&flash).Record(0) == NewerRecord();
    ++tried.cuts;
    tried.kept_old += is_old ? 1 : 0;
    tried.lost += (is_new || is_old) && others_stand && goes_on ? 0 : 1;
  }
  return tried;
}

}  // namespace caltwin
