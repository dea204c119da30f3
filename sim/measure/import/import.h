#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/measure/data_header.h"
#include "sim/measure/row.h"

namespace caltwin {

/// What a person knows of a file beyond what stands in it.
struct ImportOptions {
  std::string axis{};  ///< x, y or z, where the file does not say which was measured.
  std::string unit{};  ///< Of the readings, where the file does not say.
  std::string campaign{};  ///< A name; empty: the reader's.
  std::optional<double>
      step_mm{};                   ///< True length of a motor step; wins over the file.
  std::vector<std::string> map{};  ///< `value_mm=dev[um]` (sim/measure/import/map.h).
};

/// A stranger's file as measured rows, and what a person should know of the way there.
struct Imported {
  RowTable table{};
  DataHeader header{};
  std::string machine_yaml{};  ///< A machine file's text; empty: nothing known.
  std::vector<std::string> recognised{};  ///< What the file was found to be.
  std::vector<std::string> assumed{};     ///< Units, signs, senses nobody stated.
  std::vector<std::string> warnings{};    ///< What is odd and was kept as it stands.
};

/// One kind of file that can be read. `read` throws InputError, with file:line:column,
/// for what it does not take; `name` stands in messages.
struct Importer {
  std::string_view kind{};
  std::string_view about{};
  Imported (*read)(const std::string& text,
                   const std::string& name,
                   const ImportOptions& options) = nullptr;
};

/// Every kind there is (catalog.cc).
std::span<const Importer> AllImporters();

/// Reads a file as that kind. Known blunders (blunders.h) are told before anything
/// else; the rows are numbered in file order. Files up to 64 MB.
Imported Import(const std::string& kind,
                const std::filesystem::path& file,
                const ImportOptions& options);
/// The same from text.
Imported ImportText(const std::string& kind,
                    const std::string& text,
                    const std::string& name,
                    const ImportOptions& options);

}  // namespace caltwin
