// blind_triple_z: hides causes in a triple-Z printer's data and has them diagnosed.

#include "tests/blind/triple_z/case.h"

int main(int argc, char** argv) {
  const blind::PrinterKind triple_z{
      .name = "triple_z",
      .causes =
          [](bool is_outside) {
            std::vector<std::string> names;
            for (const blind::TzCause& cause : blind::TzCauses()) {
              if (cause.is_outside == is_outside) names.push_back(cause.name);
            }
            return names;
          },
      .write =
          [](const blind::PrinterRequest& request, const std::string& folder) {
            const blind::TzCase made = blind::MakeTzCase(request);
            blind::WriteTzCase(made, folder);
            return made.truth;
          },
      .has_pairs = true};
  return blind::PrinterMain(argc, argv, triple_z);
}
