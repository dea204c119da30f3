#include "tests/blind/model_text.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace blind {
namespace {

constexpr double kMPerMm = 1e-3;
constexpr double kMmPerM = 1e3;
constexpr double kTile_mm = 20;
// As the model's own couplings have it.
constexpr const char* kStiff = R"(solref=".0004 .5" solimp=".9999 .9999 .001")";
constexpr const char* kStop = R"(solreflimit=".0004 1" solimplimit=".9999 .9999 .001")";

std::string Name(int axis) {
  return std::string(1, "xyz"[axis]);
}

std::string Words(const Vector3& v, double factor = 1) {
  return fmt::format(
      "{:.17g} {:.17g} {:.17g}", factor * v[0], factor * v[1], factor * v[2]);
}

/// Replaces the one place where `from` stands.
void Replace(const std::string& from, const std::string& to, std::string* text) {
  const std::size_t at = text->find(from);
  if (at == std::string::npos || text->find(from, at + 1) != std::string::npos) {
    throw std::runtime_error("the model does not say once: " + from);
  }
  text->replace(at, from.size(), to);
}

/// Where the body that begins before `at` ends: the place of its own closing tag.
std::size_t EndOfBody(const std::string& text, std::size_t at) {
  for (int depth = 1; depth > 0;) {
    at = std::min(text.find("<body ", at), text.find("</body>", at));
    if (at == std::string::npos) throw std::runtime_error("a body has no end");
    depth += text[at + 1] == '/' ? -1 : 1;
    if (depth == 0) break;
    ++at;
  }
  return at;
}

/// Wraps all that the carriage of an axis carries into these bodies.
void InsertBodies(int axis, const std::vector<std::string>& bodies, std::string* text) {
  const char* const carried[] = {"<body name=\"z_nut\">", "<body name=\"x_nut\">"};
  if (axis > 1) throw std::logic_error("nothing is known of what z carries");
  const std::size_t begin = text->find(carried[axis]);
  if (begin == std::string::npos) throw std::runtime_error("nothing is carried");
  std::string opened;
  std::string closed;
  for (const std::string& body : bodies) {
    opened += body;
    closed += "</body>";
  }
  text->insert(EndOfBody(*text, begin), closed);
  text->insert(begin, opened);
}

/// A flat tile with the height and the slopes of its middle.
std::string TileText(const std::function<double(double, double)>& height_mm,
                     double x_mm,
                     double y_mm) {
  constexpr double kThick_m = 0.01;
  constexpr double kHalf_mm = 0.5 * kTile_mm;
  const double slope_x =
      (height_mm(x_mm + kHalf_mm, y_mm) - height_mm(x_mm - kHalf_mm, y_mm)) / kTile_mm;
  const double slope_y =
      (height_mm(x_mm, y_mm + kHalf_mm) - height_mm(x_mm, y_mm - kHalf_mm)) / kTile_mm;
  return fmt::format(R"(<geom type="box" contype="2" conaffinity="2" group="3" )"
                     R"(pos="{:.9g} {:.9g} {:.12g}" euler="{:.9g} {:.9g} 0" )"
                     R"(size="{:.9g} {:.9g} {:.9g}"/>)"
                     "\n",
                     x_mm * kMPerMm,
                     y_mm * kMPerMm,
                     height_mm(x_mm, y_mm) * kMPerMm - kThick_m,
                     slope_y,
                     -slope_x,
                     kHalf_mm * kMPerMm,
                     kHalf_mm * kMPerMm,
                     kThick_m);
}

}  // namespace

Polynomial OverTravel(const Polynomial& over_u, const AxisDrawing& axis) {
  Polynomial in_mm{};
  Polynomial power = {1};  // Of U = (q - mid) / half.
  for (const double factor : over_u) {
    Polynomial next{};
    for (std::size_t k = 0; k < power.size(); ++k) {
      in_mm[k] += factor * power[k];
      next[k] -= power[k] * axis.Mid_mm() / axis.Half_mm();
      if (k + 1 < next.size()) next[k + 1] += power[k] / axis.Half_mm();
    }
    power = next;
  }
  return in_mm;
}

double Value(const Polynomial& polynomial, double q) {
  double value = 0;
  for (std::size_t k = polynomial.size(); k-- > 0;) value = value * q + polynomial[k];
  return value;
}

ModelText::ModelText(std::string unedited) : text_(std::move(unedited)) {}

// A body of its own, so that any number may follow one another. Beside light carriages
// its own inertia makes the joint stiff; tied as it is, it slows nothing.
std::string ModelText::AddJoint(int carriage, const std::string& what) {
  const std::string name = fmt::format("error_{}", ++num_joints_);
  drives_[Place(carriage)].bodies.push_back(fmt::format(
      R"(<body name="{0}" gravcomp="1"><joint name="{0}" armature="1" {1}/>)"
      R"(<inertial pos="0 0 0" mass=".05" diaginertia="1e-4 1e-4 1e-4"/>)"
      "\n",
      name,
      what));
  return name;
}

void ModelText::Couple(const std::string& joint,
                       const std::string& leader,
                       const Polynomial& polynomial,
                       double per_mm) {
  std::string coefficients;
  double factor = per_mm;
  for (const double coefficient : polynomial) {
    coefficients += fmt::format("{:.17g} ", coefficient * factor);
    factor *= kMmPerM;
  }
  equalities_ +=
      fmt::format("<joint joint1=\"{}\" joint2=\"{}\" polycoef=\"{}\" {}/>\n",
                  joint,
                  leader,
                  coefficients,
                  kStiff);
}

void ModelText::AddSlide(int carriage,
                         const std::string& leader,
                         const Vector3& along,
                         const Polynomial& mm) {
  const auto joint =
      AddJoint(carriage, fmt::format(R"(type="slide" axis="{}")", Words(along)));
  Couple(joint, leader, mm, kMPerMm);
}

void ModelText::AddHinge(int carriage,
                         const std::string& leader,
                         const Vector3& about,
                         const Vector3& pivot_mm,
                         const Polynomial& rad) {
  const auto joint = AddJoint(carriage,
                              fmt::format(R"(type="hinge" axis="{}" pos="{}")",
                                          Words(about),
                                          Words(pivot_mm, kMPerMm)));
  Couple(joint, leader, rad, 1);
}

// Turned by t about the origin, by -2 t about p, by t about the origin again: all is
// upright and has gone from p's one image to the other, R(t) p - R(-t) p.
// With p half a throw across the axis that is a sin t along it.
void ModelText::AddCranks(int carriage,
                          double amplitude_mm,
                          double period_mm,
                          double phase_rad) {
  const double rate = 2 * std::numbers::pi / period_mm;
  const Vector3 about = Along(2);
  const Vector3 throw_mm = 0.5 * amplitude_mm * Cross(Along(carriage), about);
  const std::string leader = Name(carriage) + "_nut";
  const Polynomial turn = {phase_rad, rate};
  AddHinge(carriage, leader, about, {}, turn);
  AddHinge(carriage, leader, about, throw_mm, {-2 * phase_rad, -2 * rate});
  AddHinge(carriage, leader, about, {}, turn);
}

void ModelText::LeanRail(int axis, const Vector3& by) {
  Vector3& lean = drives_[Place(axis)].lean;
  lean = lean + by;
}

// A joint of its own stands half as far out as the gap is wider; two limited tendons
// let the carriage go that much further to either side.
void ModelText::WidenGap(int axis, const Polynomial& mm) {
  const std::string joint = Name(axis) + "_wear";
  bodies_ += fmt::format(
      R"(<body name="{0}"><joint name="{0}" type="slide" axis="1 0 0" armature="1e6"/>)"
      R"(<inertial pos="0 0 0" mass=".05" diaginertia="1e-4 1e-4 1e-4"/></body>)"
      "\n",
      joint);
  Polynomial half = mm;
  for (double& coefficient : half) coefficient *= 0.5;
  Couple(joint, Name(axis) + "_nut", half, kMPerMm);
  drives_[Place(axis)].is_worn = true;
}

void ModelText::ShapeTable(std::function<double(double, double)> height_mm) {
  heights_mm_.push_back(std::move(height_mm));
}

// The play between nut and carriage: firm, with a gap, with a spring, or worn.
std::string ModelText::PlayText(int axis) const {
  const Drive& drive = drives_[Place(axis)];
  const std::string name = Name(axis);
  const double half_m = 0.5 * drive.gap_mm * kMPerMm;
  const std::string play = fmt::format(
      R"(<joint joint="{0}" coef="1"/><joint joint="{0}_nut" coef="{1:.17g}"/>)",
      name,
      -(1 + drive.scale));
  if (drive.is_worn) {
    const auto side = [&](const char* word, double low_m, double high_m, int wear) {
      return fmt::format(
          R"(<fixed name="{0}_{1}" limited="true" range="{2:.17g} {3:.17g}" {4}>{5})"
          R"(<joint joint="{0}_wear" coef="{6}"/></fixed>)"
          "\n",
          name,
          word,
          low_m,
          high_m,
          kStop,
          play,
          wear);
    };
    return fmt::format("<fixed name=\"{}_play\">{}</fixed>\n", name, play) +
           side("up", -1, half_m, -1) + side("down", -half_m, 1, 1);
  }
  std::string how;
  if (drive.n_per_mm > 0) {
    const double n_per_m = drive.n_per_mm / kMPerMm;
    // Structural damping where no gap lets it drag the carriage across.
    const double damping = half_m > 0 ? 0 : 0.1 * std::sqrt(n_per_m);
    how = fmt::format(
        R"( stiffness="{:.17g}" damping="{:.17g}" springlength="{:.17g} {:.17g}")",
        n_per_m,
        damping,
        -half_m,
        half_m);
  } else if (half_m > 0) {
    how = fmt::format(
        R"( limited="true" range="{:.17g} {:.17g}" {})", -half_m, half_m, kStop);
  }
  return fmt::format("<fixed name=\"{}_play\"{}>{}</fixed>\n", name, how, play);
}

std::string ModelText::TilesText() const {
  if (heights_mm_.empty()) return {};
  const auto height_mm = [&](double x_mm, double y_mm) {
    double sum_mm = 0;
    for (const auto& shape : heights_mm_) sum_mm += shape(x_mm, y_mm);
    return sum_mm;
  };
  const int across = static_cast<int>(std::ceil(table_mm_[0] / kTile_mm));
  const int along = static_cast<int>(std::ceil(table_mm_[1] / kTile_mm));
  std::string text;
  for (int i = 0; i < across; ++i) {
    for (int j = 0; j < along; ++j) {
      text += TileText(height_mm, (i + 0.5) * kTile_mm, (j + 0.5) * kTile_mm);
    }
  }
  return text;
}

std::string ModelText::Text() const {
  std::string text = text_;
  for (int axis = 0; axis < 3; ++axis) {
    const Drive& drive = drives_[Place(axis)];
    const std::string name = Name(axis);
    const std::string rail = R"(<joint name=")" + name + R"(" class="rail" axis=")";
    Replace(rail + Words(Along(axis)), rail + Words(Along(axis) + drive.lean), &text);
    const std::size_t play = text.find("<fixed name=\"" + name + "_play\"");
    if (play == std::string::npos) throw std::runtime_error("no play of " + name);
    const std::string end = "</fixed>";
    text.replace(play, text.find(end, play) + end.size() - play, PlayText(axis));
    if (drive.gap_mm > 0 || drive.n_per_mm > 0 || drive.is_worn) {
      const std::string rigid = "<tendon name=\"" + name + "_rigid\"";
      Replace(rigid, rigid + " active=\"false\"", &text);
    }
    if (!drive.bodies.empty()) InsertBodies(axis, drive.bodies, &text);
  }
  Replace("<body name=\"table\">",
          fmt::format("{}<body name=\"table\" euler=\"{:.17g} {:.17g} 0\">\n{}",
                      bodies_,
                      slopes_[1],
                      -slopes_[0],
                      TilesText()),
          &text);
  Replace("</equality>", equalities_ + "</equality>", &text);
  return text;
}

}  // namespace blind
