#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "calibration/kinds/triple_z/plane.h"
#include "sim/machine/axis.h"

namespace caltwin {

/// What a camera's pictures are taken with: pixels, and the model of Brown and Conrady.
struct CameraIntrinsics {
  double fx = 900, fy = 900;  ///< Focal length [pixel].
  double cx = 640, cy = 480;  ///< Principal point [pixel]; centres of pixels at half.
  double k1 = 0, k2 = 0;      ///< Radial distortion.
  double p1 = 0, p2 = 0;      ///< Tangential distortion.
  std::optional<double> baseline_mm{};  ///< Between two eyes, where there are two.
  bool is_stored = false;               ///< False: as drawn, nobody has said any.
};

/// A bed's plane as it was found, z = a x + b y + c, and what to do about it.
struct BedFound {
  std::vector<BedTouch> touches{};
  BedPlane plane{};
  double reference_mm = 10;  ///< As asked; it cancels in the offsets.
  Vec3<double> offsets_mm = Vec3<double>::Zero();  ///< To raise each screw by.
  /// How far each screw was raised already when the bed was touched.
  Vec3<double> raised_before_mm = Vec3<double>::Zero();
  bool is_by_printer = true;
  bool is_level = false;  ///< As far as the touches tell.
  std::string at{};       ///< "2026-11-26T19:20:00Z".
  std::vector<std::string> notes{};
};

/// What outlives the server: kept in a file that is whole whenever the power goes.
struct BedStore {
  CameraIntrinsics camera{};
  std::vector<BedFound> found{};  ///< The last four, newest last.
  /// How far each screw is raised, as applied since the newest was found; none:
  /// nothing.
  std::optional<Vec3<double>> applied_mm{};
};

/// The residual of a plane: rms of touched less fitted [mm]; 0 of three points.
double Residual_mm(const BedFound& found);

/// The plane as the bed stands now: as found, and turned by what was applied.
/// @param pivots_mm  where the screws stand
BedPlane PlaneNow(const BedStore& store, const Pivots<double>& pivots_mm);

/// @name As the REST interface has them
nlohmann::ordered_json ScrewsToJson(const Vec3<double>& screws_mm);
nlohmann::ordered_json ToJson(const CameraIntrinsics& camera);
nlohmann::ordered_json ToJson(const BedFound& found);

/// Reads what a server before this one kept; an empty store where there is no file.
/// A file that is none of ours is put aside (FILE.unread) and told in `note`.
BedStore ReadBedStore(const std::filesystem::path& file,
                      double sigma_mm,
                      std::string* note);
void WriteBedStore(const std::filesystem::path& file, const BedStore& store);

}  // namespace caltwin
