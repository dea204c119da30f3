#pragma once

#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "renders/kinds/still.h"
#include "tools/server/routes.h"

namespace caltwin {

/// What machines look like and where their parts stand, for a page that draws them. The
/// last few are kept built.
class SceneApi {
 public:
  /// `bench`: the twin on the bench; nullopt: a real machine is there, whose errors
  /// nobody knows.
  void AddTo(Routes* routes, const std::optional<TwinFiles>& bench);

 private:
  struct Shown {
    std::string key{};
    std::function<Still(double exaggerate)> make{};
  };
  struct Kept {
    std::string key{};
    double exaggerate = 1;
    Still still{};
  };
  void Add(Routes* routes,
           const std::string& below,
           const std::function<Shown(const HttpRequest&)>& shown);
  HttpResponse Scene(const Shown& shown, const HttpRequest& request);
  HttpResponse Poses(const Shown& shown, const HttpRequest& request);
  Kept* Find(const Shown& shown, double exaggerate);

  std::mutex mutex_{};  ///< One at a time: models are shared.
  std::deque<Kept> kept_{};
};

}  // namespace caltwin
