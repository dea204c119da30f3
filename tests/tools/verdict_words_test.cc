#include <gtest/gtest.h>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/loop/outcome.h"

namespace caltwin {
namespace {

// In one program with both: they once shared a name, and the linker kept one of them.
TEST(VerdictWords, OfAStepAndOfADiagnosisAreTheirOwn) {
  EXPECT_EQ(ToString(Verdict::kMeasured), "measured");
  EXPECT_EQ(ToString(Verdict::kApplied), "applied");
  EXPECT_EQ(ToString(Verdict::kRefused), "refused");
  EXPECT_EQ(ToString(Verdict::kRolledBack), "rolled_back");
  EXPECT_EQ(ToString(DiagnosisVerdict::kNone), "none");
  EXPECT_EQ(ToString(DiagnosisVerdict::kNamed), "named");
  EXPECT_EQ(ToString(DiagnosisVerdict::kAmbiguous), "ambiguous");
  EXPECT_EQ(ToString(DiagnosisVerdict::kUnknownStructure), "unknown");
}

}  // namespace
}  // namespace caltwin
