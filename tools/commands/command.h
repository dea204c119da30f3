#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

// Only what declares options reads CLI11, which costs seconds a file.
namespace CLI {  // NOLINT(readability-identifier-naming)
class App;
}

namespace caltwin {

/// @name How `caltwin` ends, as docs/commands.md says.
inline constexpr int kPassed = 0;
inline constexpr int kCheckFailed = 1;
inline constexpr int kBadInput = 2;  ///< An InputError; `main` prints it.
inline constexpr int kLost = 3;      ///< A process or a link was lost.
inline constexpr int kInterrupted = 130;

/// Of the trees that `--json` writes.
inline constexpr int kJsonIndent = 2;

/// What runs a subcommand once its options are parsed; returns an exit code, throws
/// InputError for a person's fault.
using Action = std::function<int()>;

/// One subcommand: what help lists, and the function that declares its options on
/// `app`. Options live in a struct that the returned action keeps alive
/// (std::make_shared is allowed here for want of a shorter way).
struct Command {
  std::string_view name;
  std::string_view about;
  Action (*declare)(CLI::App* app);
};

/// Every subcommand there is, in the order help lists them (commands.cc).
std::span<const Command> AllCommands();

/// Parses the command line and runs the subcommand it names; its exit code.
int RunCommandLine(int argc, const char* const* argv);

/// @name One function a file: NAME_command.cc.
Action DeclareCalibrate(CLI::App* app);
Action DeclareCompare(CLI::App* app);
Action DeclareDiagnose(CLI::App* app);
Action DeclarePredict(CLI::App* app);
Action DeclareExplain(CLI::App* app);
Action DeclareImport(CLI::App* app);
Action DeclareIso230(CLI::App* app);
Action DeclareKlipper(CLI::App* app);
Action DeclareLinuxCnc(CLI::App* app);
Action DeclareNew(CLI::App* app);
Action DeclareOracle(CLI::App* app);
Action DeclarePlan(CLI::App* app);
Action DeclareRender(CLI::App* app);
Action DeclareRun(CLI::App* app);
Action DeclareServe(CLI::App* app);
Action DeclareSimulate(CLI::App* app);
Action DeclareStudy(CLI::App* app);
Action DeclareValidate(CLI::App* app);

}  // namespace caltwin
