#include "tests/blind/sets.h"

#include <fmt/format.h>

namespace blind {
namespace {

constexpr double kSmall_sigma = 4, kLarge_sigma = 10;

CaseRequest Base(const std::string& kind,
                 int index,
                 int count,
                 std::uint64_t seed,
                 std::uint64_t date_seed) {
  const bool second_half = index >= (count + 1) / 2;
  Random random(second_half ? date_seed : seed, fmt::format("{} {}", kind, index));
  CaseRequest request;
  request.kind = kind;
  request.seed = static_cast<std::uint64_t>(random.Uniform(1, 2e9));
  return request;
}

}  // namespace

std::vector<CaseRequest> MakeSet(const SetSizes& sizes,
                                 std::uint64_t seed,
                                 std::uint64_t date_seed) {
  std::vector<CaseRequest> requests;
  for (int i = 0; i < sizes.nulls; ++i) {
    requests.push_back(Base("null", i, sizes.nulls, seed, date_seed));
  }
  const auto& causes = LibraryCauses();
  const int count = static_cast<int>(causes.size());
  for (int i = 0; i < sizes.singles; ++i) {
    CaseRequest request = Base("single", i, sizes.singles, seed, date_seed);
    Random random(request.seed, "set");
    request.sigma = sizes.two_sizes ? (i / count % 2 == 0 ? kSmall_sigma : kLarge_sigma)
                                    : random.LogUniform(0.5, 20);
    request.hidden = {
        {causes[static_cast<std::size_t>(i % count)].name, "any", request.sigma}};
    requests.push_back(request);
  }
  for (int i = 0; i < sizes.pairs; ++i) {
    requests.push_back(Base("pair", i, sizes.pairs, seed, date_seed));
  }
  const auto& outside = OutsideCauses();
  for (int i = 0; i < sizes.outside; ++i) {
    CaseRequest request = Base("outside", i, sizes.outside, seed, date_seed);
    Random random(request.seed, "set");
    request.sigma = random.LogUniform(3, 20);
    request.hidden = {{outside[static_cast<std::size_t>(i) % outside.size()].name,
                       "any",
                       request.sigma}};
    requests.push_back(request);
  }
  return requests;
}

std::string RerunCommand(const CaseRequest& request) {
  std::string command =
      fmt::format("blind_generate --kind {} --seed {}", request.kind, request.seed);
  for (const Hidden& hidden : request.hidden) {
    command += fmt::format(" --cause {} --axis {} --sigma {}",
                           hidden.cause,
                           hidden.axis.empty() ? "-" : hidden.axis,
                           hidden.sigma);
  }
  return command + " --out CASE";
}

}  // namespace blind
