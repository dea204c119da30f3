#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/commands/twin_options.h"

namespace caltwin {

/// What `caltwin serve --http` is asked.
struct WebOptions {
  int port = 0;
  std::string address = "127.0.0.1";
  std::filesystem::path token_file{};
  std::filesystem::path state{};  ///< A folder; empty: StateFolder().
  bool has_machine =
      false;           ///< Else practice machines: a router and a triple-Z printer.
  TwinOptions twin{};  ///< The machine, where one is named.
  std::string link{};  ///< Of a real machine; empty: the twin.
};

/// Where a server keeps what it finds: $XDG_STATE_HOME/caltwin or
/// ~/.local/state/caltwin.
std::filesystem::path StateFolder();

/// A server's machines, routes and pages.
class WebService {
 public:
  /// Builds the machines. Throws InputError; of an address that others reach without a
  /// token too.
  WebService(const WebOptions& options, const std::atomic<bool>* stop);
  WebService(const WebService&) = delete;
  WebService& operator=(const WebService&) = delete;
  ~WebService();

  /// What a person at the terminal should know, a line each.
  std::vector<std::string> Notes() const;
  /// Until `*stop`. `listening` is told the address to open.
  void Serve(const std::function<void(const std::string& url)>& listening);

 private:
  struct Parts;
  void BuildMachines();
  void AddRoutes();
  void AddPages();
  std::filesystem::path StoreOf(const std::string& machine,
                                const std::string& which,
                                const char* what) const;

  WebOptions options_;
  const std::atomic<bool>* stop_;
  std::unique_ptr<Parts> parts_;
};

}  // namespace caltwin
