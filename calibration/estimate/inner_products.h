#pragma once

#include <cstddef>

namespace caltwin {

/// Columns of doubles, each contiguous, `stride` doubles from one to the next.
struct ColumnsView {
  const double* data = nullptr;
  std::ptrdiff_t rows = 0;
  std::ptrdiff_t columns = 0;
  std::ptrdiff_t stride = 0;
};

/// Every inner product of a column of `a` with a column of `b`:
///   products[i + j * a.columns] = sum over rows r of a(r, i) b(r, j)
///
/// For few columns of many rows, where a general matrix product spends half its time on
/// copies: columns are read as they lie, a piece at a time that fits into the cache.
/// Four partial sums a product, whatever the processor, so every machine gives the same
/// bytes. Rounding grows as that of a plain sum of rows / 4 terms.
/// @param products  a.columns * b.columns doubles, written over
void InnerProducts(const ColumnsView& a, const ColumnsView& b, double* products);

}  // namespace caltwin
