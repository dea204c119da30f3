#pragma once

#include <filesystem>
#include <string>

#include "sim/measure/row.h"

namespace caltwin {

/// Reads measured rows, format 1 (CONTRACT, docs/data-format.md), strictly: every fault
/// of the file in one InputError, each with file:line:column, what is allowed, a hint.
///
/// Unknown columns are kept as text (`Row::extra`) and named in `remarks`. Where `n` is
/// left out it is filled in: the single commanded axis, for a touch against the sense
/// of approach if that is known (an outward normal faces the probe). Row numbers left
/// out count from 1 in file order. Files up to 64 MB.
RowTable ReadRows(const std::filesystem::path& file);
/// The same from text; `name` stands in messages.
RowTable ParseRows(const std::string& text, const std::string& name);

/// The rows as a file's text: columns in CONTRACT's order, those that no row knows left
/// out, numbers in the shortest form that reads back to the same bits. ParseRows of it
/// gives the same rows, if each has a number or none has.
std::string RowsText(const RowTable& table);
void WriteRows(const std::filesystem::path& file, const RowTable& table);

}  // namespace caltwin
