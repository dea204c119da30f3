#include "sim/controllers/klipper/microcontroller.h"
#include "tests/fuzz/fuzz.h"
#include "tests/klipper/host.h"

// Each piece of the input is a byte n and n bytes: even n are the payload of a sound
// block, odd ones go over the line as they are. Ten milliseconds pass behind each.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace caltwin::klipper;
  constexpr Clock kStep = kTicksPerSecond / 100;
  ToyBoard board;
  Microcontroller chip(&board);
  chip.Advance(10 * kTicksPerSecond);
  ByteView rest(data, size);
  int sequence = 1;
  while (!rest.empty()) {
    const std::size_t asked = rest[0];
    rest = rest.subspan(1);
    const ByteView piece = rest.first(std::min(asked % kMostPayload, rest.size()));
    rest = rest.subspan(piece.size());
    chip.Receive(asked % 2 == 0 ? BlockOf(sequence++, piece)
                                : Bytes(piece.begin(), piece.end()));
    chip.Advance(chip.now() + kStep);
    BlockReader reader;
    reader.Feed(chip.TakeOutput());
    while (const auto said = reader.Take()) {
      if (!said->is_sound) std::abort();
    }
  }
  return 0;
}
