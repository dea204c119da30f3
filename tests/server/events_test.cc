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

// However large single events are, what is kept is bounded.
TEST(Events, WhatIsKeptIsBoundedInBytes) {
  EventTopic topic(/*most_kept=*/1000, /*most_kept_bytes=*/100);
  std::size_t heard = 0;
  for (int i = 0; i < 50; ++i) topic.Publish("a", std::string(30, 'x'));

  topic.Listen(0, [&](const std::string& text) { heard += text.size(); });

  EXPECT_GT(heard, 0u);
  EXPECT_LE(heard, 100u);
}

}  // namespace
}  // namespace caltwin
