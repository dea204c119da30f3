#include "sim/measure/csv.h"

#include <algorithm>
#include <utility>

namespace caltwin {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool IsBlank(char c) {
  return c == ' ' || c == '\t';
}

std::string_view Trimmed(std::string_view text) {
  while (!text.empty() && IsBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlank(text.back())) text.remove_suffix(1);
  return text;
}

}  // namespace

CsvReader::CsvReader(std::string_view text,
                     std::string name,
                     Faults* faults,
                     char separator)
    : text_(text), name_(std::move(name)), faults_(faults), separator_(separator) {
  if (text_.starts_with(kByteOrderMark)) text_.remove_prefix(kByteOrderMark.size());
}

std::optional<CsvRecord> CsvReader::Next() {
  while (at_ < text_.size()) {
    const std::string_view line = Trimmed(RestOfLine());
    if (!line.empty() && !line.starts_with('#')) return Record();
    if (!line.empty()) comments_.emplace_back(Trimmed(line.substr(1)));
    SkipToLineEnd();
    NextLine();
  }
  return std::nullopt;
}

// A tab that separates is no blank around a field.
bool CsvReader::IsBlank(char c) const {
  return c != separator_ && caltwin::IsBlank(c);
}

std::string_view CsvReader::Trimmed(std::string_view text) const {
  while (!text.empty() && IsBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlank(text.back())) text.remove_suffix(1);
  return text;
}

bool CsvReader::AtLineEnd() const {
  return at_ >= text_.size() || text_[at_] == '\n' || text_[at_] == '\r';
}

std::string_view CsvReader::RestOfLine() const {
  return text_.substr(at_, text_.find_first_of("\r\n", at_) - at_);
}

// Over the line end, of which CRLF is one.
void CsvReader::NextLine() {
  if (at_ >= text_.size()) return;
  at_ += text_.substr(at_, 2) == "\r\n" ? 2 : 1;
  ++line_;
  line_start_ = at_;
}

void CsvReader::SkipToLineEnd() {
  at_ = std::min(text_.size(), text_.find_first_of("\r\n", at_));
}

void CsvReader::SkipBlanks() {
  while (at_ < text_.size() && IsBlank(text_[at_])) ++at_;
}

CsvRecord CsvReader::Record() {
  CsvRecord record;
  while (true) {
    SkipBlanks();
    record.push_back(at_ < text_.size() && text_[at_] == '"' ? Quoted() : Plain());
    if (AtLineEnd()) break;
    ++at_;  // Over the separator.
  }
  NextLine();
  return record;
}

CsvField CsvReader::Plain() {
  const std::size_t end = std::min(
      text_.size(), text_.find_first_of(std::string{separator_, '\r', '\n'}, at_));
  CsvField field{.text = std::string(Trimmed(text_.substr(at_, end - at_))),
                 .line = line_,
                 .column = column()};
  at_ = end;
  return field;
}

CsvField CsvReader::Quoted() {
  CsvField field{.line = line_, .column = column()};
  do {
    ++at_;  // Over the opening quote, or the second of a doubled one.
    const std::size_t quote = text_.find('"', at_);
    if (quote == std::string_view::npos) {
      faults_->Add({.file = name_, .line = field.line, .column = field.column},
                   "a quote that is never closed");
      at_ = text_.size();
      return field;
    }
    Take(quote, &field.text);
    ++at_;
    if (at_ < text_.size() && text_[at_] == '"') field.text += '"';
  } while (at_ < text_.size() && text_[at_] == '"');
  SkipBlanks();
  if (!AtLineEnd() && text_[at_] != separator_) {
    faults_->Add({.file = name_, .line = line_, .column = column()},
                 "text after the closing quote",
                 "a quote inside a quoted field is written twice");
    SkipToLineEnd();
  }
  return field;
}

// Moves the text up to `end` to `field`, counting the lines it runs over.
void CsvReader::Take(std::size_t end, std::string* field) {
  field->append(text_.substr(at_, end - at_));
  for (; at_ < end; ++at_) {
    if (text_[at_] != '\n') continue;
    ++line_;
    line_start_ = at_ + 1;
  }
}

std::string CsvQuoted(const std::string& text) {
  const bool is_plain = text.find_first_of(",\"\r\n#") == std::string::npos &&
                        Trimmed(text).size() == text.size();
  if (is_plain) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace caltwin
