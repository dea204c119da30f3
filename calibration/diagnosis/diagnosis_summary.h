#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/diagnosis_text.h"

namespace caltwin {

/// The first thing that the rows say by themselves and that answers a question, a bad
/// reading only where nothing else does; nullptr where none does.
const Fact* FirstAnswer(const Diagnosis& diagnosis);

/// Whether the rows determine nothing of what is always fitted.
bool IsOpen(const Diagnosis& diagnosis);

/// "These rows cannot show a wave of the Z screw; a wrong size of the tip: plain
/// settings take it up, or no row moves it."; empty where they can show everything.
std::string AbsorbedText(const std::vector<Absorbed>& absorbed);

/// A diagnosis for somebody who reads one sentence, then what it means for them.
struct DiagnosisSummary {
  /// What the answer is about.
  enum class Answer {
    kCause,      ///< A cause is named, or several are possible.
    kFigure,     ///< A plain figure: a scale, lost motion, a tilt.
    kElsewhere,  ///< It is not the machine: the gauge, the file, the slicer.
    kNothing,    ///< Nothing is wrong that these rows could show.
    kTooFew      ///< The rows determine nothing.
  };
  Answer answer = Answer::kNothing;
  std::string sentence{};
  std::vector<std::string> found{};
  std::vector<std::string> cannot_tell{};
  std::vector<std::string> to_do{};
};

/// {"answer": "figure", "sentence": "X loses ...", "found": [], "cannot_tell": [],
/// "to_do": []}; an answer is one of cause, figure, elsewhere, nothing, too_few.
nlohmann::ordered_json SummaryJson(const DiagnosisSummary& summary);

/// The summary's first sentence.
std::string AnswerSentence(const Diagnosis& diagnosis);

DiagnosisSummary SummaryOf(const Diagnosis& diagnosis, const TextNotes& notes);

}  // namespace caltwin
