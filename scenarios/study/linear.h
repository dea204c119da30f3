#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "scenarios/study/aggregate.h"
#include "scenarios/study/run.h"

namespace caltwin {

/// How far the linear design of a plan is from what its machines do: the estimates of
/// some machines by the closed forms and by the design, which has noise of its own and,
/// beside it, is given the very readings that the closed forms had.
struct LinearCheck {
  std::int64_t trials = 0;
  struct Unknown {
    std::string name{}, unit{};
    double fast_mean = 0, fast_sd = 0;  ///< Of the errors.
    double linear_mean = 0, linear_sd = 0;
    /// Of the same readings, closed forms - design: what is not straight.
    double difference_mean = 0, difference_sd = 0;
    /// Of the noise that its readings have, as it acts on this unknown, over what the
    /// design is told: 1 where that is all there is.
    double noise_ratio = 1;
    bool agrees = false;
  };
  std::vector<Unknown> unknowns{};
};

/// 1000 machines, the same ones both ways, whatever part of the study is run. An
/// unknown agrees where its mean error differs by less than a tenth of its sd, its sd
/// by less than a tenth and its readings' noise by less than a tenth, beyond five
/// standard deviations of chance. That is 0.22 and 0.16 of the sd between noises of
/// their own, a fiftieth of it for the same readings and for their noise.
LinearCheck CheckLinear(const Study& study, const StudyOptions& options);

/// Throws InputError where an unknown does not agree: linear is not good enough there.
void RequireLinear(const Study& study, const LinearCheck& check);

/// Goes on with the shard's trials of a study with the fidelity linear, in blocks, none
/// kept. The same for any number of workers and however often it was stopped. Calls
/// `save` with what is done once a second; what that throws ends it.
void RunLinear(const Study& study,
               const StudyOptions& options,
               const std::function<void(const HalfDone&)>& save,
               HalfDone* half);

/// What the terminal shows of the check.
std::string CheckText(const LinearCheck& check);
/// `linear_check.json`.
nlohmann::ordered_json ToJson(const LinearCheck& check);

}  // namespace caltwin
