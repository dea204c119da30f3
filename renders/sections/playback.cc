#include <string>

#include "renders/sections/sections.h"

namespace caltwin {

std::string PlaybackSection(const RunResult& /*result*/,
                            const ReportPictures& pictures) {
  return pictures.playback;
}

}  // namespace caltwin
