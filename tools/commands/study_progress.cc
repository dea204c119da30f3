#include "tools/commands/study_progress.h"

#include <fmt/format.h>

namespace caltwin {

std::string ProgressText(const StudyProgress& progress) {
  constexpr int kWidth = 24;
  const double part = progress.all > 0 ? static_cast<double>(progress.done) /
                                             static_cast<double>(progress.all)
                                       : 1;
  const auto filled = static_cast<std::size_t>(kWidth * part);
  const double left_s =
      progress.per_s > 0
          ? static_cast<double>(progress.all - progress.done) / progress.per_s
          : 0;
  return fmt::format("[{}{}] {} of {}, {:.0f}/s, {:.0f} s left",
                     std::string(filled, '#'),
                     std::string(kWidth - filled, '.'),
                     progress.done,
                     progress.all,
                     progress.per_s,
                     left_s);
}

std::string ProgressJson(const StudyProgress& progress) {
  return fmt::format(R"({{"done":{},"all":{}}})", progress.done, progress.all);
}

}  // namespace caltwin
