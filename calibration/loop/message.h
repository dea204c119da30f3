#pragma once

#include <string>
#include <utility>

namespace caltwin {

/// One sentence that a procedure says to a person, and what it is for them. Any text is
/// a message of what was found; what is meant otherwise says so.
struct Message {
  enum class Kind {
    kFound,    ///< What was seen or done.
    kCause,    ///< What went wrong, and why: a run leads with it.
    kCheck,    ///< One of a list of checks, and how it ended.
    kOpen,     ///< What a plan determines, and what would determine more.
    kToDo,     ///< What a person should do.
    kMachine,  ///< The controller's own words.
    kLog       ///< What was written where.
  };

  std::string text{};
  Kind kind = Kind::kFound;

  Message() = default;
  // NOLINTBEGIN(google-explicit-constructor): a text is a message.
  Message(std::string said, Kind meant = Kind::kFound)
      : text(std::move(said)), kind(meant) {}
  Message(const char* said, Kind meant = Kind::kFound) : text(said), kind(meant) {}
  // NOLINTEND(google-explicit-constructor)

  explicit operator std::string() const { return text; }

  friend bool operator==(const Message&, const Message&) = default;
};

/// What the machine answered where it stopped a run.
inline Message MachineSaid(const std::string& reply) {
  return {"the machine said: " + reply, Message::Kind::kMachine};
}

/// As JSON its text alone.
template <typename Json>
// NOLINTNEXTLINE(readability-identifier-naming): the JSON library looks for this name.
void to_json(Json& json, const Message& message) {
  json = message.text;
}

}  // namespace caltwin
