// The command line: a table of subcommands (tools/commands), and what their ends mean.

#include <csignal>
#include <exception>
#include <iostream>

#include "scenarios/interrupt.h"
#include "sim/base/input_error.h"
#include "sim/firmware/stepped_plant.h"
#include "tools/commands/api/own_program.h"
#include "tools/commands/command.h"

namespace {

// The first Ctrl-C asks to stop and keep what is done, the second stops at once.
void OnInterrupt(int) {
  caltwin::RequestInterrupt();
  std::signal(SIGINT, SIG_DFL);
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGINT, OnInterrupt);
  std::signal(SIGPIPE, SIG_IGN);  // A reader that has left is an error of write().
  caltwin::EndWithServer();
  try {
    return caltwin::RunCommandLine(argc, argv);
  } catch (const caltwin::InputError& error) {
    std::cerr << caltwin::FaultsText(error);
    return caltwin::kBadInput;
  } catch (const caltwin::Jammed& jammed) {  // Served to a real controller.
    std::cerr << "caltwin: " << jammed.what() << "\n";
    return caltwin::kLost;
  } catch (const std::exception& error) {
    std::cerr << "caltwin: this is a mistake of caltwin's own: " << error.what()
              << "\n";
    return caltwin::kLost;
  }
}
