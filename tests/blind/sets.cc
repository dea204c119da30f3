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

void Hide(const Cause& cause, CaseRequest* request) {
  request->hidden = {{cause.name, "any", request->sigma}};
}

/// Causes that one campaign shows and another one settles.
std::vector<Cause> LoopCauses() {
  std::vector<Cause> causes;
  for (const char* name : {"cyclic_lead",
                           "microstep",
                           "pulley_eccentric",
                           "pitch_progressive",
                           "squareness",
                           "straightness",
                           "angular",
                           "gantry_sag",
                           "bed_bowl",
                           "bed_cylinder",
                           "bed_twist"}) {
    causes.push_back(*FindCause(name, /*physics=*/true));
  }
  return causes;
}

/// Of these causes in a model of MuJoCo, each half of a set takes its own, none twice.
CaseRequest PhysicsSingle(const std::string& kind,
                          std::vector<Cause> causes,
                          int index,
                          int count,
                          std::uint64_t seed,
                          std::uint64_t date_seed) {
  CaseRequest request = Base("physics " + kind, index, count, seed, date_seed);
  request.kind = kind;
  request.physics = true;
  request.sigma = index % 2 == 0 ? kSmall_sigma : kLarge_sigma;
  const int first_half = (count + 1) / 2;
  const bool is_second = index >= first_half;
  Random order(is_second ? date_seed : seed, "order of physics");
  order.Shuffle(&causes);
  const int place = is_second ? index - first_half : index;
  Hide(causes[static_cast<std::size_t>(place) % causes.size()], &request);
  return request;
}

}  // namespace

std::vector<CaseRequest> MakeSet(const SetSizes& sizes,
                                 std::uint64_t seed,
                                 std::uint64_t date_seed) {
  std::vector<CaseRequest> requests;
  const auto add = [&](const std::string& kind, int count) {
    for (int i = 0; i < count; ++i) {
      requests.push_back(Base(kind, i, count, seed, date_seed));
      requests.back().physics = sizes.half_physics && i % 3 != 2;
    }
  };
  add("null", sizes.nulls);
  for (int i = 0; i < sizes.singles; ++i) {
    CaseRequest request = Base("single", i, sizes.singles, seed, date_seed);
    Random random(request.seed, "set");
    request.physics = sizes.half_physics && i % 2 == 0;
    const auto& causes = request.physics ? PhysicsCauses() : LibraryCauses();
    const int turn = sizes.half_physics ? i / 2 : i;
    const int count = static_cast<int>(causes.size());
    request.sigma = sizes.two_sizes
                        ? (turn / count % 2 == 0 ? kSmall_sigma : kLarge_sigma)
                        : random.LogUniform(0.5, 20);
    Hide(causes[static_cast<std::size_t>(turn % count)], &request);
    requests.push_back(request);
  }
  for (int i = 0; i < sizes.physics; ++i) {
    requests.push_back(
        PhysicsSingle("single", PhysicsCauses(), i, sizes.physics, seed, date_seed));
  }
  for (int i = 0; i < sizes.loops; ++i) {
    requests.push_back(
        PhysicsSingle("loop", LoopCauses(), i, sizes.loops, seed, date_seed));
    requests.back().clean = true;
    // A lone standing square shows nothing: the table's tilt takes it all.
    if (requests.back().hidden[0].cause == "squareness") {
      requests.back().hidden[0].axis = "C0Y";
    }
    requests.back().sigma = requests.back().hidden[0].sigma = kLarge_sigma;
  }
  add("pair", sizes.pairs);
  const auto& outside = OutsideCauses();
  for (int i = 0; i < sizes.outside; ++i) {
    CaseRequest request = Base("outside", i, sizes.outside, seed, date_seed);
    Random random(request.seed, "set");
    request.sigma = random.LogUniform(3, 20);
    Hide(outside[static_cast<std::size_t>(i) % outside.size()], &request);
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
  if (request.clean) command += " --clean";
  if (request.kind == "loop") command += " --keep-built";
  if (request.physics) command += " --physics --binary CALTWIN";
  return command + " --out CASE";
}

}  // namespace blind
