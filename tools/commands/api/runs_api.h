#pragma once

#include <atomic>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "sim/base/temporary_folder.h"
#include "tools/server/events.h"
#include "tools/server/routes.h"

namespace caltwin {

/// Scenarios run for a client: begun, watched, read, ended. Two at a time; the last
/// sixteen are kept. Each runs in a process of its own.
class RunsApi {
 public:
  /// `events` is borrowed: `run` tells of each beginning and end.
  explicit RunsApi(EventTopic* events) : events_(events) {}
  RunsApi(const RunsApi&) = delete;
  RunsApi& operator=(const RunsApi&) = delete;
  /// Ends those at work.
  ~RunsApi();

  void AddTo(Routes* routes);

 private:
  struct Run {
    std::string id{};
    std::string scenario{};
    std::string state = "running";  ///< running, done, failed, stopped
    std::string detail{};           ///< Of one that failed.
    std::string text{};             ///< As the terminal would show it.
    std::string result{};           ///< `run --json`; empty until done.
    std::atomic<bool> stop = false;
    std::thread thread{};
  };

  HttpResponse Begin(const HttpRequest& request);
  HttpResponse List() const;
  HttpResponse Read(const HttpRequest& request) const;
  HttpResponse Stop(const HttpRequest& request);
  HttpResponse Delete(const HttpRequest& request);
  HttpResponse Report(const HttpRequest& request) const;
  /// Every line and its answer.
  HttpResponse Transcript(const HttpRequest& request) const;
  std::filesystem::path FileOf(const HttpRequest& request,
                               const std::filesystem::path& name) const;
  void Work(Run* run, const std::vector<std::string>& words);
  std::shared_ptr<Run> Find(const std::string& id) const;

  EventTopic* events_;
  TemporaryFolder folder_{"caltwin_server"};
  mutable std::mutex mutex_{};
  int last_ = 0;
  std::deque<std::shared_ptr<Run>> runs_{};
};

}  // namespace caltwin
