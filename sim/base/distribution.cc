#include "sim/base/distribution.h"

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

double Middle(const Distribution& distribution) {
  return std::visit(MiddleOf{}, distribution);
}

}  // namespace caltwin
