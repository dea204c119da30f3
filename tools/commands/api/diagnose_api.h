#pragma once

#include <atomic>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "sim/base/temporary_folder.h"
#include "tools/server/multipart.h"
#include "tools/server/routes.h"

namespace caltwin {

/// "What is wrong with my machine?" over REST: measured files go in, the JSON of
/// `caltwin diagnose --json` comes out. The last sixteen are kept for their reports and
/// corrections; nothing leaves the computer.
class DiagnoseApi {
 public:
  explicit DiagnoseApi(const std::atomic<bool>* stop) : stop_(stop) {}

  void AddTo(Routes* routes);

 private:
  /// Files of one question, as they lie in a folder of their own.
  struct Kept {
    std::string id{};
    std::vector<std::string> words{};  ///< `diagnose data.csv --machine ...`.
    std::shared_ptr<const std::filesystem::path>
        folder{};  ///< Gone with the last user.
  };

  HttpResponse Diagnose(const HttpRequest& request);
  HttpResponse Report(const HttpRequest& request);
  HttpResponse Correction(const HttpRequest& request);
  HttpResponse Rows(const HttpRequest& request);

  std::string DiagnoseOne(const Kept& kept, const std::string& file);
  Kept Keep(Kept kept);
  Kept Find(const std::string& id);

  const std::atomic<bool>* stop_;
  TemporaryFolder folder_{"caltwin_server"};
  std::mutex mutex_{};
  int last_ = 0;
  std::deque<Kept> kept_{};
};

}  // namespace caltwin
