#include "renders/assets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Assets, CanStandBetweenStyleTags) {
  EXPECT_THAT(std::string(PaletteCss()), Not(HasSubstr("</style")));
  EXPECT_THAT(std::string(ReportCss()), Not(HasSubstr("</style")));
}

}  // namespace
}  // namespace caltwin
