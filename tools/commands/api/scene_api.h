#pragma once

#include <deque>
#include <filesystem>
#include <mutex>

#include "renders/kinds/still.h"
#include "tools/server/routes.h"

namespace caltwin {

/// What machines look like and where their parts stand, for a page that draws them. The
/// last few are kept built.
class SceneApi {
 public:
  void AddTo(Routes* routes);

 private:
  struct Kept {
    std::filesystem::path file{};
    double exaggerate = 1;
    Still still{};
  };
  HttpResponse Scene(const std::filesystem::path& file, const HttpRequest& request);
  HttpResponse Poses(const std::filesystem::path& file, const HttpRequest& request);
  Kept* Find(const std::filesystem::path& file, double exaggerate);

  std::mutex mutex_{};  ///< One at a time: models are shared.
  std::deque<Kept> kept_{};
};

}  // namespace caltwin
