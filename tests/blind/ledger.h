#pragma once

#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "tests/blind/judge.h"

namespace blind {

/// Judgements on disk, a line of JSON each, so that a count of many hours may be done
/// in parts: what stands there is not examined again. The first line says which program
/// was judged: rates of two programs are not one rate.
class Ledger {
 public:
  /// Opens `file` and reads what it holds; a last line that was cut off is dropped.
  /// Throws std::runtime_error where it judged another program than `binary`, or cannot
  /// be read or written.
  Ledger(const std::string& file, const std::string& binary);

  /// `key`: the command that makes the case again.
  std::optional<Judgement> Find(const std::string& key) const;

  /// Writes it down at once. May be called from any thread.
  void Add(const std::string& key, const Judgement& judgement);

  std::size_t size() const { return judged_.size(); }

 private:
  std::map<std::string, Judgement> judged_{};
  std::ofstream stream_{};
  std::mutex mutex_{};
};

}  // namespace blind
