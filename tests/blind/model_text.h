#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "tests/blind/gantry.h"

namespace blind {

/// c0 + c1 q + ... + c4 q^4: what a joint equality of MJCF can say, q in mm.
using Polynomial = std::array<double, 5>;

/// The polynomial of q [mm] that is `over_u` of U, -1 .. 1 over the axis's travel.
Polynomial OverTravel(const Polynomial& over_u, const AxisDrawing& axis);
double Value(const Polynomial& polynomial, double q);

/// A router's model.xml, edited as text as a person would edit it: joints that follow
/// other joints, turned rails, loose nuts, soft drives, tiles on the table. Nothing
/// here knows MuJoCo but by the words of its format; lengths are mm, the file's metres
/// come about when it is written.
class ModelText {
 public:
  explicit ModelText(std::string unedited);

  /// What the carriage of x or y carries is moved along `along` by the polynomial [mm]
  /// of the leader's place ("x", "x_nut").
  void AddSlide(int carriage,
                const std::string& leader,
                const Vector3& along,
                const Polynomial& mm);
  /// The same, turned about `about` through a point of the carriage.
  void AddHinge(int carriage,
                const std::string& leader,
                const Vector3& about,
                const Vector3& pivot_mm,
                const Polynomial& rad);
  /// What the carriage carries moves along its axis by a sin(2 pi q / period + phase),
  /// q the nut's place: two cranks of half the throw that turn against each other.
  void AddCranks(int carriage, double amplitude_mm, double period_mm, double phase_rad);
  /// The axis's rail leans by `by` per length.
  void LeanRail(int axis, const Vector3& by);
  /// The carriage moves 1 + scale times as far as its nut.
  void SetScale(int axis, double scale) { drives_[Place(axis)].scale = scale; }
  void SetGap(int axis, double gap_mm) { drives_[Place(axis)].gap_mm = gap_mm; }
  /// The drive gives way by a spring.
  void SetSpring(int axis, double n_per_mm) {
    drives_[Place(axis)].n_per_mm = n_per_mm;
  }
  /// The gap is wider by the polynomial [mm] of the nut's place.
  void WidenGap(int axis, const Polynomial& mm);
  /// Heights gained along +x and +y.
  void TiltTable(double slope_x, double slope_y) { slopes_ = {slope_x, slope_y}; }
  /// The table's top stands higher by `height_mm(x, y)`: laid with small flat tiles.
  void ShapeTable(std::function<double(double x_mm, double y_mm)> height_mm);
  /// How far the table reaches.
  void SetTableSize(double x_mm, double y_mm) { table_mm_ = {x_mm, y_mm}; }
  /// The ball's radius is another than drawn. It stands in the machine file.
  void GrowTip(double by_mm) { tip_growth_mm_ += by_mm; }

  double tip_growth_mm() const { return tip_growth_mm_; }
  std::string Text() const;

 private:
  struct Drive {
    double scale = 0, gap_mm = 0, n_per_mm = 0;
    bool is_worn = false;
    Vector3 lean{};
    std::vector<std::string> bodies{};  ///< Between the carriage and what it carries.
  };
  static std::size_t Place(int axis) { return static_cast<std::size_t>(axis); }
  std::string AddJoint(int carriage, const std::string& what);
  void Couple(const std::string& joint,
              const std::string& leader,
              const Polynomial& polynomial,
              double per_mm);
  std::string PlayText(int axis) const;
  std::string TilesText() const;

  std::string text_;
  std::array<Drive, 3> drives_{};
  std::array<double, 2> slopes_{}, table_mm_{300, 300};
  double tip_growth_mm_ = 0;
  std::vector<std::function<double(double, double)>> heights_mm_{};
  std::string bodies_{}, tendons_{}, equalities_{};
  int num_joints_ = 0;
};

}  // namespace blind
