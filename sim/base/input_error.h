#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace caltwin {

/// Where in a user's input something stands; line and column count from 1, 0: unknown.
struct Place {
  std::string file{};
  int line = 0;
  int column = 0;
};

/// `file:line:column`, without what is unknown.
std::string ToString(const Place& place);

/// A person's mistake in a file, an option or a line of G-code: one message a fault,
/// each `place: what it says, what is allowed` and, indented below, a hint.
///
/// Caught in `main` (exit 2, see PrintFaults) and where a server answers.
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::vector<std::string> faults);
  InputError(const Place& place, const std::string& text, const std::string& hint = "");

  const std::vector<std::string>& faults() const { return faults_; }

 private:
  std::vector<std::string> faults_;
};

/// Collects the faults of one input, so that a person sees all of them at once, and
/// notes on what is sound and yet may not be what was meant.
class Faults {
 public:
  void Add(const Place& place, const std::string& text, const std::string& hint = "");
  /// All that another file was refused for.
  void Add(const InputError& error);
  bool empty() const { return faults_.empty(); }
  std::size_t size() const { return faults_.size(); }
  /// "place: text", once however often it is said.
  void Note(const Place& place, const std::string& text);
  const std::vector<std::string>& notes() const { return notes_; }
  /// Throws InputError with every fault collected, in the order they were added.
  void ThrowIfAny() const;

 private:
  std::vector<std::string> faults_{}, notes_{};
};

/// What goes to stderr: at most 20 faults, then "and N more".
std::string FaultsText(const InputError& error);

/// The known word nearest to `word` (edit distance at most 2 or a third of its length,
/// and not every letter another), or empty: what "did you mean" offers.
std::string NearestWord(const std::string& word, const std::vector<std::string>& known);

}  // namespace caltwin
