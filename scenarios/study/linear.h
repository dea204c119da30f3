#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scenarios/study/aggregate.h"
#include "scenarios/study/run.h"

namespace caltwin {

/// How far the linear design of a plan is from what its machines do: the estimates of
/// some machines by the closed forms and by the design.
struct LinearCheck {
  std::int64_t trials = 0;
  struct Unknown {
    std::string name{}, unit{};
    double fast_mean = 0, fast_sd = 0;  ///< Of the errors.
    double linear_mean = 0, linear_sd = 0;
    bool agrees = false;
  };
  std::vector<Unknown> unknowns{};
};

/// 1000 machines, the same ones both ways, whatever part of the study is run. An
/// unknown agrees where its mean error differs by less than a tenth of its sd and its
/// sd by less than a tenth, beyond five standard deviations of chance.
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

}  // namespace caltwin
