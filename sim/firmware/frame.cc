#include "sim/firmware/frame.h"

#include <algorithm>

namespace caltwin::rrf {

void Frame::Pop() {
  blocks_.pop_back();
  std::erase_if(variables_,
                [&](const Variable& v) { return v.depth > blocks_.size(); });
}

std::optional<std::size_t> Frame::CloseBlocks(int indent, bool continues_if) {
  while (!blocks_.empty() && blocks_.back().indent >= indent) {
    const Block& last = blocks_.back();
    if (continues_if && last.indent == indent && last.kind == Kind::kIf) break;
    if (last.kind == Kind::kWhile && last.is_active) return last.line;
    Pop();
  }
  return std::nullopt;
}

bool Frame::is_active() const {
  return std::ranges::all_of(blocks_, &Block::is_active);
}

bool Frame::ParentActive() const {
  return std::ranges::all_of(blocks_.begin(), blocks_.end() - 1, &Block::is_active);
}

void Frame::OpenIf(int indent, bool condition) {
  const bool is_reached = is_active();
  blocks_.push_back({.kind = Kind::kIf,
                     .indent = indent,
                     .is_active = is_reached && condition,
                     .is_taken = !is_reached || condition});
}

bool Frame::WantsElse(int indent) const {
  return !blocks_.empty() && blocks_.back().indent == indent &&
         blocks_.back().kind == Kind::kIf && !blocks_.back().is_taken && ParentActive();
}

bool Frame::SwitchIf(int indent, bool condition) {
  if (blocks_.empty() || blocks_.back().indent != indent ||
      blocks_.back().kind != Kind::kIf) {
    return false;
  }
  Block& block = blocks_.back();
  block.is_active = !block.is_taken && condition && ParentActive();
  block.is_taken = block.is_taken || condition;
  std::erase_if(variables_,
                [&](const Variable& v) { return v.depth >= blocks_.size(); });
  return true;
}

void Frame::OpenWhile(int indent, std::size_t line) {
  const bool is_reached = is_active();
  blocks_.push_back(
      {.kind = Kind::kWhile, .indent = indent, .is_active = is_reached, .line = line});
}

bool Frame::RepeatsWhile(std::size_t line) {
  if (blocks_.empty() || blocks_.back().kind != Kind::kWhile ||
      blocks_.back().line != line || !blocks_.back().is_active) {
    return false;
  }
  Block again = blocks_.back();
  Pop();
  ++again.iterations;
  blocks_.push_back(again);
  return true;
}

bool Frame::Break() {
  const auto loop =
      std::ranges::find(blocks_.rbegin(), blocks_.rend(), Kind::kWhile, &Block::kind);
  if (loop == blocks_.rend()) return false;
  loop->is_active = false;
  return true;
}

std::optional<std::size_t> Frame::Continue() {
  while (!blocks_.empty() && blocks_.back().kind != Kind::kWhile) Pop();
  if (blocks_.empty()) return std::nullopt;
  return blocks_.back().line;
}

std::optional<Value> Frame::Iterations() const {
  const auto loop =
      std::ranges::find(blocks_.rbegin(), blocks_.rend(), Kind::kWhile, &Block::kind);
  if (loop == blocks_.rend()) return std::nullopt;
  return Value{loop->iterations};
}

bool Frame::AddVariable(const std::string& name, Value value) {
  if (FindVariable(name) != nullptr) return false;
  variables_.push_back(
      {.name = name, .value = std::move(value), .depth = blocks_.size()});
  return true;
}

Value* Frame::FindVariable(const std::string& name) {
  const auto found = std::ranges::find(variables_, name, &Variable::name);
  return found == variables_.end() ? nullptr : &found->value;
}

}  // namespace caltwin::rrf
