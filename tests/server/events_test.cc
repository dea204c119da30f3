#include "tools/server/events.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using testing::ElementsAre;

TEST(Events, ANewcomerIsToldWhatItMissed) {
  EventTopic topic(/*most_kept=*/2);
  std::vector<std::string> heard;
  topic.Publish("a", "1");
  topic.Publish("a", "2");
  topic.Publish("b", "3");

  const int listener =
      topic.Listen(1, [&](const std::string& text) { heard.push_back(text); });
  topic.Publish("b", "4");
  topic.Leave(listener);
  topic.Publish("b", "5");

  EXPECT_THAT(heard,
              ElementsAre("id: 2\nevent: a\ndata: 2\n\n",
                          "id: 3\nevent: b\ndata: 3\n\n",
                          "id: 4\nevent: b\ndata: 4\n\n"));
  EXPECT_EQ(topic.listeners(), 0u);
}

}  // namespace
}  // namespace caltwin
