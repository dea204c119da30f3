#include "sim/base/distribution.h"

#include <algorithm>
#include <cmath>

namespace caltwin {
namespace {

struct Drawer {
  Rng* rng;
  double operator()(double value) const { return value; }
  double operator()(const Normal& n) const { return n.mean + n.sd * rng->Normal(); }
  double operator()(const Uniform& u) const {
    return u.min + (u.max - u.min) * rng->Uniform();
  }
  double operator()(const LogNormal& l) const {
    return l.median * std::exp(std::log(l.factor) * rng->Normal());
  }
};

// The share of what is drawn that lies below `limit`.
struct Below {
  double limit;
  static double OfNormal(double z) { return std::erfc(-z / std::sqrt(2.0)) / 2; }
  double operator()(double) const { return 0; }
  double operator()(const Normal& n) const {
    return n.sd > 0 ? OfNormal((limit - n.mean) / n.sd) : 0;
  }
  double operator()(const Uniform& u) const {
    return u.max > u.min ? std::clamp((limit - u.min) / (u.max - u.min), 0.0, 1.0) : 0;
  }
  double operator()(const LogNormal& l) const {
    if (limit <= 0 || l.factor <= 1) return 0;
    return OfNormal(std::log(limit / l.median) / std::log(l.factor));
  }
};

struct MiddleOf {
  double operator()(double value) const { return value; }
  double operator()(const Normal& n) const { return n.mean; }
  double operator()(const Uniform& u) const { return (u.min + u.max) / 2; }
  double operator()(const LogNormal& l) const { return l.median; }
};

}  // namespace

double Draw(const Distribution& distribution, Rng* rng) {
  return std::visit(Drawer{rng}, distribution);
}

ShareBeyond Beyond(const Distribution& distribution, double min, double max) {
  if (std::holds_alternative<double>(distribution)) return {};
  const double below_max = std::visit(Below{max}, distribution);
  // A distribution without width draws its middle, which was read within the bounds.
  const bool is_narrow = below_max == 0 && Middle(distribution) <= max;
  return {.below = std::visit(Below{min}, distribution),
          .above = is_narrow ? 0 : 1 - below_max};
}

double Middle(const Distribution& distribution) {
  return std::visit(MiddleOf{}, distribution);
}

}  // namespace caltwin
