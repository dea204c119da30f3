#pragma once

#include <exception>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "sim/base/input_error.h"
#include "tools/server/http.h"

namespace caltwin {

/// One thing wrong with what was sent, as the command line says it.
struct ProblemFault {
  std::string detail{};
  std::string hint{};
  /// Into a JSON body (RFC 6901): "/probe_points/2"; "" is the whole body.
  std::optional<std::string> pointer{};
  std::string file{};  ///< Of an uploaded file, with line and column from 1.
  int line = 0;
  int column = 0;
};

/// Why a request was not done, as RFC 9457 has it (`application/problem+json`): thrown
/// by handlers.
class Problem : public std::exception {
 public:
  explicit Problem(int status,
                   std::string detail,
                   std::vector<ProblemFault> faults = {},
                   nlohmann::ordered_json more = nlohmann::ordered_json::object())
      : status_(status),
        detail_(std::move(detail)),
        faults_(std::move(faults)),
        more_(std::move(more)) {}

  const char* what() const noexcept override { return detail_.c_str(); }
  int status() const { return status_; }
  const std::vector<ProblemFault>& faults() const { return faults_; }

  /// `type`, `title`, `status`, `detail`, and where there are any `errors`, and what
  /// else belongs to it (`held_by`).
  HttpResponse Response() const;

 private:
  int status_;
  std::string detail_;
  std::vector<ProblemFault> faults_;
  nlohmann::ordered_json more_;
};

/// Each message of what was refused, taken apart: "x.csv:3:7: what, allowed\n  hint".
std::vector<ProblemFault> FaultsOf(const std::vector<std::string>& messages);

/// 422, with the places.
Problem ProblemOf(const InputError& error);

/// One line of JSON; bytes that are no UTF-8, which a machine may say, are replaced.
std::string JsonLine(const nlohmann::ordered_json& tree);

/// 200 with a body of JSON; numbers that are not finite become null.
HttpResponse JsonResponse(const nlohmann::ordered_json& tree, int status = 200);

/// The body as JSON; 415 where it is said to be something else, 400 where it is none or
/// is nested deeper than 64.
nlohmann::ordered_json JsonBody(const HttpRequest& request);

}  // namespace caltwin
