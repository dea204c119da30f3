// blind_delta: hides causes in a delta's data and has them diagnosed.

#include "tests/blind/delta/case.h"

int main(int argc, char** argv) {
  const blind::PrinterKind delta{
      .name = "delta",
      .causes =
          [](bool is_outside) {
            std::vector<std::string> names;
            for (const blind::DeltaCause& cause : blind::DeltaCauses()) {
              if (cause.is_outside == is_outside) names.push_back(cause.name);
            }
            return names;
          },
      .write =
          [](const blind::PrinterRequest& request, const std::string& folder) {
            const blind::DeltaCase made = blind::MakeDeltaCase(request);
            blind::WriteDeltaCase(made, folder);
            return made.truth;
          },
      .has_pairs = true};
  return blind::PrinterMain(argc, argv, delta);
}
