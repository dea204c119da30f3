#include "scenarios/kinds/triple_z_words.h"

#include <array>

namespace caltwin {

std::span<const Word> TripleZProcedureWords() {
  static constexpr std::array kWords = {
      Word{
          "bed_tilt",
          "Levels a bed on three screws: touches a grid, fits z = a x + b y + c, "
          "raises "
          "each screw, touches again. Options: grid ([3, 3]; 2 to 5 are usual), at "
          "(grid "
          "or screws, the manual way), margin_mm, reference_mm, largest_mm, variant. "
          "corrected raises by reference - z, and undoes what validates worse. "
          "as_published takes offsets: example (z less the smallest, which doubles the "
          "tilt) or formula (reference - z less the smallest: level, at another "
          "height). hold_out: true touches the middles of the grid's cells afterwards, "
          "which were not fitted."},
      Word{"move_triple_z",
           "A step: the nozzle to at_mm [x, y], the screws to heights_mm [z1, z2, z3], "
           "0 "
           "to the top each; homes if needed, waits. What lies outside is refused and "
           "nothing moves."},
      Word{"bed_tilt_iterated",
           "bed_tilt again until the mean error is below target_mm, at most rounds "
           "times. "
           "corrected first raises each screw alone by test_mm, tells by what each "
           "round "
           "will multiply the tilt, and refuses a loop that would diverge."},
      Word{
          "rrf_levelling",
          "The firmware levels by its drivers: G30 P0 .. S3 with the screws of M671. "
          "Options: grid, at, rounds, target_mm, test_mm, variant. corrected foretells "
          "the factor of each round as bed_tilt_iterated does."},
      Word{
          "pivots_and_wiring",
          "Where the screws stand and which driver turns which: raises each alone by "
          "test_mm and touches a grid, or (from: rounds) watches two levelling rounds. "
          "Names swapped motors and pivots that are off; corrected writes M671 as "
          "found."}};
  return kWords;
}

}  // namespace caltwin
