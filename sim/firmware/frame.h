#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/firmware/value.h"

namespace caltwin::rrf {

/// Where one source of lines stands: the wire, or a macro file being run. Blocks are
/// told by indentation.
class Frame {
 public:
  enum class Kind { kIf, kWhile };

  /// Closes the blocks that a line with this indentation ends (an `elif` or `else`
  /// keeps the `if` it belongs to). Where one of them is a loop still running: its
  /// line, to which to go back, and the block stays.
  std::optional<std::size_t> CloseBlocks(int indent, bool continues_if);
  /// Whether the line that comes now is to be obeyed.
  bool is_active() const;

  void OpenIf(int indent, bool condition);
  /// `elif` and `else`; false where no `if` stands at this indentation.
  bool SwitchIf(int indent, bool condition);
  /// Whether the condition of an `elif` matters: no branch has been taken yet.
  bool WantsElse(int indent) const;
  /// A loop begins; its condition is evaluated with the block already open, and Break
  /// called where it does not hold.
  void OpenWhile(int indent, std::size_t line);
  /// The running loop whose line this is, for which `iterations` counts on.
  bool RepeatsWhile(std::size_t line);
  /// Ends, or begins anew, the innermost loop; nullopt where there is none.
  bool Break();
  std::optional<std::size_t> Continue();
  std::optional<Value> Iterations() const;

  /// Adds a variable to the block open now; false where it exists.
  bool AddVariable(const std::string& name, Value value);
  Value* FindVariable(const std::string& name);

  std::map<std::string, Value> params{};
  bool is_file = false;

 private:
  struct Block {
    Kind kind = Kind::kIf;
    int indent = 0;
    bool is_active = false;
    bool is_taken = false;  ///< Of an if: one of its branches was.
    std::size_t line = 0;   ///< Of a while.
    std::int64_t iterations = 0;
  };
  struct Variable {
    std::string name{};
    Value value{};
    std::size_t depth = 0;
  };
  void Pop();
  bool ParentActive() const;

  std::vector<Block> blocks_{};
  std::vector<Variable> variables_{};
};

}  // namespace caltwin::rrf
