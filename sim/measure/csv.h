#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/input_error.h"

namespace caltwin {

/// One field of a CSV record, with where it begins; line and column count from 1.
struct CsvField {
  std::string text{};
  int line = 0;
  int column = 0;
};
using CsvRecord = std::vector<CsvField>;

/// Splits a CSV text into records, and nothing more: RFC 4180 (fields in double quotes
/// may hold commas, line ends and doubled quotes; CRLF or LF), plus what people's files
/// have: a byte order mark, blank lines, comment lines whose first character is `#`,
/// blanks around unquoted fields (taken off).
///
/// A quote that is never closed, or followed by other than a separator, is a fault, and
/// the rest of its line is skipped.
class CsvReader {
 public:
  /// `text` and `faults` must outlive the reader; `name` stands in messages. Measured
  /// rows have commas; spreadsheets elsewhere semicolons or tabs.
  CsvReader(std::string_view text,
            std::string name,
            Faults* faults,
            char separator = ',');

  /// The next record; nullopt at the end.
  std::optional<CsvRecord> Next();
  /// The comments so far, without `#` and surrounding blanks.
  const std::vector<std::string>& comments() const { return comments_; }

 private:
  bool AtLineEnd() const;
  bool IsBlank(char c) const;
  std::string_view Trimmed(std::string_view text) const;
  std::string_view RestOfLine() const;
  int column() const { return static_cast<int>(at_ - line_start_) + 1; }
  void NextLine();
  void SkipToLineEnd();
  void SkipBlanks();
  CsvRecord Record();
  CsvField Plain();
  CsvField Quoted();
  void Take(std::size_t end, std::string* field);

  std::string_view text_;
  std::string name_;
  Faults* faults_;
  char separator_;
  std::vector<std::string> comments_;
  std::size_t at_ = 0;
  std::size_t line_start_ = 0;
  int line_ = 1;
};

/// The field as it must be written to be read back the same: in quotes where needed.
std::string CsvQuoted(const std::string& text);

}  // namespace caltwin
