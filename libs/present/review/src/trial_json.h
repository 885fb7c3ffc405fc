// A trial as the page wants it: a column of numbers for each quantity, null where there is none.
#pragma once

#include "lake/core/json.h"
#include "lake/review/correction_book.h"
#include "lake/review/trial_session.h"

namespace lake::review {

// `fit` is nullptr where there is none (yet).
Json TrialJson(const CorrectionBook& book, const TrialFit* fit, const std::vector<std::int64_t>& repeated);

// `asked` is a list of gait::MeasureFrom.
Json CoursesJson(const motion::MarkerRecording& in_plane, const Json& asked);

}  // namespace lake::review
