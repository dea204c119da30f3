#pragma once

#include "sim/measure/import/import.h"

namespace caltwin {

/// Reads a table as people keep it, its columns known by their headings: `commanded,
/// measured`, `axis,target,actual`, `x,y,height`, `X cmd (mm), X meas`, `nominal, run
/// 1, run 2`, `target, error um`; apart by commas, semicolons, tabs, blanks or the bars
/// of markdown; HTML tables too. Lengths without a unit are in mm (said so); a column
/// of deviations must say its unit. Where headings say too little the numbers do (said
/// so): a number beside a command was read. Diagonals and sides of squares
/// (square_lengths.h) and a probe beside another gauge are known too. Of a text with
/// remarks every table is read, those of a heading of their own or of one above, each a
/// campaign named after the line before it. Throws
/// InputError, listing the columns, where headings say too little: then `--map` names
/// them.
Imported ReadPlainTable(const std::string& text,
                        const std::string& name,
                        const ImportOptions& options);

/// Reads one table; `around`: the text that it stands in, whose remarks may say what
/// its columns do not (inches, steps that were counted).
Imported ReadOneTable(const std::string& table,
                      const std::string& around,
                      const std::string& name,
                      const ImportOptions& options);

/// The table of a markdown or HTML text as lines of fields apart by tabs, each at the
/// place it had; a text without such a table comes back as it is.
std::string WithoutMarkup(const std::string& text);

}  // namespace caltwin
