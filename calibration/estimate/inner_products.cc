#include "calibration/estimate/inner_products.h"

#include <algorithm>
#include <array>
#include <cstring>

// Compiled for processors that have AVX (CMakeLists.txt), which MuJoCo asks for anyway.
// So nothing of Eigen here: its inline functions would differ from those of other
// files.

namespace caltwin {
namespace {

constexpr std::ptrdiff_t kLanes = 4;
using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));
constexpr std::ptrdiff_t kTileA = 3,
                         kTileB = 4;  // 12 sums, 3 + 1 readings: 16 registers.
constexpr std::ptrdiff_t kRowsAtOnce = 256;

// Wherever a double may lie: one unaligned load.
Lanes LanesAt(const double* readings) {
  Lanes lanes;
  std::memcpy(&lanes, readings, sizeof lanes);
  return lanes;
}

// Adds the products of kA by kB columns over `rows` rows.
template <std::ptrdiff_t kA, std::ptrdiff_t kB>
void AddTile(const double* a,
             std::ptrdiff_t a_stride,
             const double* b,
             std::ptrdiff_t b_stride,
             std::ptrdiff_t rows,
             std::array<double, kA * kB>* sums) {
  Lanes lanes[kA * kB] = {};
  std::ptrdiff_t row = 0;
  for (; row + kLanes <= rows; row += kLanes) {
    Lanes of_a[kA];
#pragma GCC unroll 4
    for (std::ptrdiff_t i = 0; i < kA; ++i) of_a[i] = LanesAt(a + i * a_stride + row);
#pragma GCC unroll 4
    for (std::ptrdiff_t j = 0; j < kB; ++j) {
      const Lanes of_b = LanesAt(b + j * b_stride + row);
#pragma GCC unroll 4
      for (std::ptrdiff_t i = 0; i < kA; ++i) lanes[i + j * kA] += of_a[i] * of_b;
    }
  }
#pragma GCC unroll 12
  for (std::ptrdiff_t k = 0; k < kA * kB; ++k) {
    const Lanes of = lanes[k];
    (*sums)[static_cast<std::size_t>(k)] = (of[0] + of[1]) + (of[2] + of[3]);
  }
  for (; row < rows; ++row) {
    for (std::ptrdiff_t k = 0; k < kA * kB; ++k) {
      (*sums)[static_cast<std::size_t>(k)] +=
          a[k % kA * a_stride + row] * b[k / kA * b_stride + row];
    }
  }
}

struct Piece {
  const ColumnsView& a;
  const ColumnsView& b;
  std::ptrdiff_t first = 0;  // Row.
  std::ptrdiff_t rows = 0;
  double* products = nullptr;
};

template <std::ptrdiff_t kA, std::ptrdiff_t kB>
void AddAt(const Piece& piece, std::ptrdiff_t i, std::ptrdiff_t j) {
  std::array<double, kA* kB> sums = {};
  AddTile<kA, kB>(piece.a.data + i * piece.a.stride + piece.first,
                  piece.a.stride,
                  piece.b.data + j * piece.b.stride + piece.first,
                  piece.b.stride,
                  piece.rows,
                  &sums);
  for (std::ptrdiff_t k = 0; k < kB; ++k) {
    for (std::ptrdiff_t l = 0; l < kA; ++l) {
      piece.products[(i + l) + (j + k) * piece.a.columns] +=
          sums[static_cast<std::size_t>(l + k * kA)];
    }
  }
}

// All columns of `a` against kB of `b`.
template <std::ptrdiff_t kB>
void AddColumns(const Piece& piece, std::ptrdiff_t j) {
  std::ptrdiff_t i = 0;
  for (; i + kTileA <= piece.a.columns; i += kTileA) AddAt<kTileA, kB>(piece, i, j);
  for (; i < piece.a.columns; ++i) AddAt<1, kB>(piece, i, j);
}

}  // namespace

void InnerProducts(const ColumnsView& a, const ColumnsView& b, double* products) {
  std::fill(products, products + a.columns * b.columns, 0.0);
  for (std::ptrdiff_t first = 0; first < a.rows; first += kRowsAtOnce) {
    const Piece piece{.a = a,
                      .b = b,
                      .first = first,
                      .rows = std::min(kRowsAtOnce, a.rows - first),
                      .products = products};
    std::ptrdiff_t j = 0;
    for (; j + kTileB <= b.columns; j += kTileB) AddColumns<kTileB>(piece, j);
    for (; j < b.columns; ++j) AddColumns<1>(piece, j);
  }
}

}  // namespace caltwin
