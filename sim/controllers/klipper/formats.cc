#include "sim/controllers/klipper/formats.h"

#include <algorithm>
#include <array>

#include "sim/base/require.h"

namespace caltwin {
namespace klipper {
namespace {

// The first of each list has a number that the host knows before it has the dictionary.
constexpr int kIdentifyResponse = 0, kIdentify = 1, kFirstFree = 2;

constexpr std::array kCommandTexts = {
    std::string_view("identify offset=%u count=%c"),
    std::string_view("get_uptime"),
    std::string_view("get_clock"),
    std::string_view("get_config"),
    std::string_view("allocate_oids count=%c"),
    std::string_view("finalize_config crc=%u"),
    std::string_view("emergency_stop"),
    std::string_view("clear_shutdown"),
    std::string_view("config_reset"),
    std::string_view("config_stepper oid=%c step_pin=%c dir_pin=%c invert_step=%c "
                     "step_pulse_ticks=%u"),
    std::string_view("queue_step oid=%c interval=%u count=%hu add=%hi"),
    std::string_view("set_next_step_dir oid=%c dir=%c"),
    std::string_view("reset_step_clock oid=%c clock=%u"),
    std::string_view("stepper_get_position oid=%c"),
    std::string_view("stepper_stop_on_trigger oid=%c trsync_oid=%c"),
    std::string_view("config_trsync oid=%c"),
    std::string_view("trsync_start oid=%c report_clock=%u report_ticks=%u "
                     "expire_reason=%c"),
    std::string_view("trsync_set_timeout oid=%c clock=%u"),
    std::string_view("trsync_trigger oid=%c reason=%c"),
    std::string_view("config_endstop oid=%c pin=%c pull_up=%c"),
    std::string_view("endstop_home oid=%c clock=%u sample_ticks=%u sample_count=%c "
                     "rest_ticks=%u pin_value=%c trsync_oid=%c trigger_reason=%c"),
    std::string_view("endstop_query_state oid=%c"),
    std::string_view("config_digital_out oid=%c pin=%u value=%c default_value=%c "
                     "max_duration=%u"),
    std::string_view("set_digital_out_pwm_cycle oid=%c cycle_ticks=%u"),
    std::string_view("queue_digital_out oid=%c clock=%u on_ticks=%u"),
    std::string_view("update_digital_out oid=%c value=%c"),
    std::string_view("set_digital_out pin=%u value=%c"),
    std::string_view("config_pwm_out oid=%c pin=%u cycle_ticks=%u value=%hu "
                     "default_value=%hu max_duration=%u"),
    std::string_view("queue_pwm_out oid=%c clock=%u value=%hu"),
    std::string_view("config_analog_in oid=%c pin=%u"),
    std::string_view("query_analog_in oid=%c clock=%u sample_ticks=%u sample_count=%c "
                     "rest_ticks=%u min_value=%hu max_value=%hu range_check_count=%c"),
    std::string_view("config_buttons oid=%c button_count=%c"),
    std::string_view("buttons_add oid=%c pos=%c pin=%u pull_up=%c"),
    std::string_view("buttons_query oid=%c clock=%u rest_ticks=%u retransmit_count=%c "
                     "invert=%c"),
    std::string_view("buttons_ack oid=%c count=%c"),
};

constexpr std::array kResponseTexts = {
    std::string_view("identify_response offset=%u data=%.*s"),
    std::string_view("uptime high=%u clock=%u"),
    std::string_view("clock clock=%u"),
    std::string_view("config is_config=%c crc=%u is_shutdown=%c move_count=%hu"),
    std::string_view("stepper_position oid=%c pos=%i"),
    std::string_view("trsync_state oid=%c can_trigger=%c trigger_reason=%c clock=%u"),
    std::string_view("endstop_state oid=%c homing=%c next_clock=%u pin_value=%c"),
    std::string_view("analog_in_state oid=%c next_clock=%u value=%hu"),
    std::string_view("buttons_state oid=%c ack_count=%c state=%*s"),
    std::string_view("stats count=%u sum=%u sumsq=%u"),
    std::string_view("shutdown clock=%u static_string_id=%hu"),
    std::string_view("is_shutdown static_string_id=%hu"),
    std::string_view("starting"),
};

Parameter ParameterOf(std::string_view word) {
  const std::size_t equals = word.find('=');
  const std::string_view kind = word.substr(equals + 2);
  Parameter parameter{.name = word.substr(0, equals),
                      .is_bytes = kind.ends_with('s'),
                      .is_signed = kind.ends_with('i')};
  if (kind == "c") parameter.bits = 8;
  if (kind.starts_with('h')) parameter.bits = 16;
  return parameter;
}

MessageFormat FormatOf(std::string_view text, int id) {
  MessageFormat format{.id = id, .text = text, .name = text.substr(0, text.find(' '))};
  for (std::size_t at = text.find(' '); at != std::string_view::npos;) {
    const std::size_t end = text.find(' ', at + 1);
    format.parameters.push_back(ParameterOf(text.substr(at + 1, end - at - 1)));
    at = end;
  }
  return format;
}

std::vector<MessageFormat> FormatsOf(std::span<const std::string_view> texts,
                                     int first,
                                     int others) {
  std::vector<MessageFormat> formats;
  for (const std::string_view text : texts) {
    formats.push_back(FormatOf(text, formats.empty() ? first : others++));
  }
  return formats;
}

std::int64_t NumberOf(const Parameter& parameter, std::int32_t taken) {
  const auto bits = static_cast<std::uint32_t>(taken);
  switch (parameter.bits) {
    case 8:
      return static_cast<std::uint8_t>(bits);
    case 16:
      return parameter.is_signed ? static_cast<std::int16_t>(bits)
                                 : static_cast<std::int64_t>(bits & 0xFFFFU);
    default:
      return parameter.is_signed ? taken : static_cast<std::int64_t>(bits);
  }
}

std::optional<Argument> TakeArgument(const Parameter& parameter, ByteView* payload) {
  if (!parameter.is_bytes) {
    const auto number = TakeVlq(payload);
    if (!number) return std::nullopt;
    return Argument(NumberOf(parameter, *number));
  }
  if (payload->empty()) return std::nullopt;
  const std::size_t length = payload->front();
  if (payload->size() < 1 + length) return std::nullopt;
  const ByteView bytes = payload->subspan(1, length);
  *payload = payload->subspan(1 + length);
  return Argument(Bytes(bytes.begin(), bytes.end()));
}

}  // namespace

std::span<const MessageFormat> Commands() {
  static const std::vector<MessageFormat> formats =
      FormatsOf(kCommandTexts, kIdentify, kFirstFree);
  return formats;
}

std::span<const MessageFormat> Responses() {
  static const std::vector<MessageFormat> formats =
      FormatsOf(kResponseTexts,
                kIdentifyResponse,
                kFirstFree + static_cast<int>(kCommandTexts.size()));
  return formats;
}

const MessageFormat* CommandOf(int id) {
  const auto all = Commands();
  const auto found = std::ranges::find(all, id, &MessageFormat::id);
  return found == all.end() ? nullptr : &*found;
}

std::int64_t Message::operator[](std::string_view name) const {
  const auto& parameters = format->parameters;
  const auto found = std::ranges::find(parameters, name, &Parameter::name);
  Require(found != parameters.end(), "a message has the parameter asked for");
  return arguments[static_cast<std::size_t>(found - parameters.begin())].number;
}

std::optional<Message> TakeCommand(ByteView* payload) {
  const auto id = TakeVlq(payload);
  const MessageFormat* const format = id ? CommandOf(*id) : nullptr;
  if (format == nullptr) return std::nullopt;
  Message message{.format = format};
  for (const Parameter& parameter : format->parameters) {
    auto argument = TakeArgument(parameter, payload);
    if (!argument) return std::nullopt;
    message.arguments.push_back(std::move(*argument));
  }
  return message;
}

void AppendMessage(const MessageFormat& format,
                   const std::vector<Argument>& arguments,
                   Bytes* payload) {
  Require(arguments.size() == format.parameters.size(),
          "a message has an argument for each parameter");
  AppendVlq(format.id, payload);
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const Argument& argument = arguments[i];
    if (format.parameters[i].is_bytes) {
      payload->push_back(static_cast<std::uint8_t>(argument.bytes.size()));
      payload->insert(payload->end(), argument.bytes.begin(), argument.bytes.end());
    } else {
      AppendVlq(static_cast<std::int32_t>(argument.number), payload);
    }
  }
}

Bytes EncodeResponse(std::string_view name, const std::vector<Argument>& arguments) {
  const auto all = Responses();
  const auto found = std::ranges::find(all, name, &MessageFormat::name);
  Require(found != all.end(), "a response of that name is in the dictionary");
  Bytes payload;
  AppendMessage(*found, arguments, &payload);
  return payload;
}

}  // namespace klipper
}  // namespace caltwin
