#include "renders/assets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Assets, HoldThePinnedPlotLibraryWhole) {
  EXPECT_EQ(PlotLibrary().size(), 51081);
  EXPECT_THAT(std::string(PlotLibrary()), HasSubstr("uPlot (v1.6.32)"));
  EXPECT_EQ(PlotLibraryCss().size(), 1857);
}

TEST(Assets, CanStandBetweenScriptTags) {
  EXPECT_THAT(std::string(PlotLibrary()), Not(HasSubstr("</script")));
  EXPECT_THAT(std::string(ReportScript()), Not(HasSubstr("</script")));
  EXPECT_THAT(std::string(ReportCss()), Not(HasSubstr("</style")));
}

}  // namespace
}  // namespace caltwin
