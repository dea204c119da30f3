#pragma once

#include <string>
#include <vector>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/pictures_data.h"

namespace caltwin {

/// One picture of a diagnosis: an SVG drawing that stands alone.
struct DiagnosisPicture {
  std::string name{};     ///< Of its file, without ".svg": "evidence_map".
  std::string title{};    ///< "What the residual depends on".
  std::string caption{};  ///< What to look for.
  std::string svg{};
};

/// @name One picture each; no svg where there is nothing to draw.
DiagnosisPicture EvidencePicture(const PicturesData& data);
DiagnosisPicture SharesPicture(const Diagnosis& diagnosis);
DiagnosisPicture LackOfFitPicture(const PicturesData& data);
/// `number` counts findings from 1.
DiagnosisPicture FindingPicture(const FindingSeries& series, std::size_t number);
DiagnosisPicture ContrastPicture(const DirectionContrast& contrast);
DiagnosisPicture PeriodogramPicture(const Periodogram& periodogram);

/// Parts of the explainable variance, in percent, that sum to 100: each finding's share
/// and, last, what remains.
std::vector<double> SharesInPercent(const Diagnosis& diagnosis);

}  // namespace caltwin
