#include "tests/blind/ledger.h"

#include <cstdint>
#include <filesystem>
#include <iterator>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace blind {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(
    JudgedFinding, cause, axis, probability, alone, right, holds, tolerable)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Judgement,
                                   kind,
                                   name,
                                   seed,
                                   physics,
                                   sigma,
                                   sum_squares,
                                   separation,
                                   ran,
                                   verdict,
                                   findings,
                                   hidden,
                                   hidden_named,
                                   hidden_told,
                                   first_right,
                                   set_holds,
                                   explained,
                                   intervals,
                                   covered,
                                   rediagnosed,
                                   idempotent,
                                   seconds)

namespace {

using nlohmann::json;

/// What tells two programs apart: FNV-1a of the file.
std::string Fingerprint(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error("cannot read " + file);
  constexpr std::uint64_t kOffset = 14695981039346656037ULL;
  constexpr std::uint64_t kPrime = 1099511628211ULL;
  std::uint64_t hash = kOffset;
  for (auto it = std::istreambuf_iterator<char>(stream);
       it != std::istreambuf_iterator<char>();
       ++it) {
    hash = (hash ^ static_cast<unsigned char>(*it)) * kPrime;
  }
  return fmt::format("{:016x}", hash);
}

}  // namespace

Ledger::Ledger(const std::string& file, const std::string& binary) {
  const std::string program = Fingerprint(binary);
  std::uintmax_t whole = 0;  // Bytes up to the last line that is whole.
  if (std::ifstream in(file, std::ios::binary); in) {
    std::string line;
    while (std::getline(in, line) && !in.eof()) {
      const json entry = json::parse(line);
      if (whole == 0 && entry.at("program") != program) {
        throw std::runtime_error(
            fmt::format("{} counts another program than {}: give another --ledger, or "
                        "count anew",
                        file,
                        binary));
      }
      if (whole > 0) judged_[entry.at("case")] = entry.at("judgement").get<Judgement>();
      whole += line.size() + 1;
    }
  }
  if (std::filesystem::exists(file)) std::filesystem::resize_file(file, whole);
  stream_.open(file, std::ios::binary | std::ios::app);
  if (whole == 0) stream_ << json{{"program", program}}.dump() << "\n";
  stream_.flush();
  if (!stream_) throw std::runtime_error("cannot write " + file);
}

std::optional<Judgement> Ledger::Find(const std::string& key) const {
  const auto it = judged_.find(key);
  if (it == judged_.end()) return std::nullopt;
  return it->second;
}

void Ledger::Add(const std::string& key, const Judgement& judgement) {
  const std::scoped_lock lock(mutex_);
  stream_ << json{{"case", key}, {"judgement", judgement}}.dump() << "\n";
  stream_.flush();
  if (!stream_) throw std::runtime_error("cannot write the ledger");
}

}  // namespace blind
