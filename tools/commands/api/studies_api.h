#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include <nlohmann/json.hpp>

#include "tools/server/events.h"
#include "tools/server/routes.h"

namespace caltwin {

/// Studies of shipped scenarios, run for a client by `caltwin study` in a process of
/// its own, on half of the cores: begun, watched, read, ended. One at a time; the last
/// sixteen are kept in a folder, each in one of its own, and outlive the server. One
/// that was at work when its server ended is "stopped".
class StudiesApi {
 public:
  /// @param folder  made where it is not there
  /// @param events  borrowed: `study` tells of beginning, end and each percent
  StudiesApi(std::filesystem::path folder, EventTopic* events);
  StudiesApi(const StudiesApi&) = delete;
  StudiesApi& operator=(const StudiesApi&) = delete;
  /// Ends what is at work.
  ~StudiesApi();

  void AddTo(Routes* routes);

 private:
  using Json = nlohmann::ordered_json;

  struct One {
    std::string id{};
    Json asked{};                   ///< scenario, trials, seed, fidelity, vary.
    std::string state = "running";  ///< running, done, failed, stopped
    std::string detail{};           ///< Of one that failed or was stopped.
    std::string text{};             ///< As the terminal would show it.
    std::string begun_at{}, ended_at{};
    std::int64_t done = 0, all = 0;  ///< Runs.
    std::atomic<bool> stop = false;
    std::thread thread{};
  };

  HttpResponse Begin(const HttpRequest& request);
  HttpResponse List() const;
  HttpResponse Read(const HttpRequest& request) const;
  HttpResponse Delete(const HttpRequest& request);
  HttpResponse Report(const HttpRequest& request) const;

  void Work(One* one);
  /// Whether the line says how far the study is: then it is told, and is no text.
  bool TakesProgress(One* one, std::string_view line);
  void Tell(const One& one) const;
  /// @name Under mutex_
  std::shared_ptr<One> Find(const std::string& id) const;
  void MakeRoom();
  /// A folder of its own, which nobody else has.
  std::string NewFolder();

  static Json TreeOf(const One& one);
  void Keep(const One& one) const;
  void ReadKept();

  std::filesystem::path folder_;
  EventTopic* events_;
  mutable std::mutex mutex_{};
  std::deque<std::shared_ptr<One>> studies_{};
};

}  // namespace caltwin
