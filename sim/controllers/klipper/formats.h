#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/controllers/klipper/wire.h"

namespace caltwin {
namespace klipper {

/// One parameter of a message, as its format writes it: `%c` a byte, `%hu` and `%hi` 16
/// bits, `%u` and `%i` 32 bits (all of them VLQ), `%*s` and `%.*s` a length and bytes.
struct Parameter {
  std::string_view name;
  bool is_bytes = false;
  bool is_signed = false;
  int bits = 32;
};

/// A message in the words of the dictionary: "queue_step oid=%c interval=%u ...". The
/// host compares them letter by letter.
struct MessageFormat {
  int id = 0;
  std::string_view text;
  std::string_view name;
  std::vector<Parameter> parameters{};
};

/// What the host may send, and what the microcontroller may say.
std::span<const MessageFormat> Commands();
std::span<const MessageFormat> Responses();
/// Null: there is none of that number.
const MessageFormat* CommandOf(int id);

/// The argument of one parameter: a number within its bits, or bytes.
struct Argument {
  std::int64_t number = 0;
  Bytes bytes{};

  Argument() = default;
  // NOLINTBEGIN(google-explicit-constructor): a number or bytes are an argument.
  Argument(std::int64_t value) : number(value) {}
  Argument(Bytes value) : bytes(std::move(value)) {}
  // NOLINTEND(google-explicit-constructor)
};

struct Message {
  const MessageFormat* format = nullptr;
  std::vector<Argument> arguments{};

  /// The argument of that name, which the format must have.
  std::int64_t operator[](std::string_view name) const;
};

/// Takes a command from the front of a block's payload. nullopt: no command has its
/// number, or the payload ends within it; what follows cannot be read either.
std::optional<Message> TakeCommand(ByteView* payload);

/// The payload of the response of that name; as many arguments as it has.
Bytes EncodeResponse(std::string_view name, const std::vector<Argument>& arguments);

/// Appends number and arguments of a message.
void AppendMessage(const MessageFormat& format,
                   const std::vector<Argument>& arguments,
                   Bytes* payload);

}  // namespace klipper
}  // namespace caltwin
