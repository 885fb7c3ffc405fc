#include "name_together.h"

namespace lake::tracking {
namespace {

class Combinations {
 public:
  Combinations(const std::vector<std::vector<NamedTracklet>>& choices, const PairMisfit& pair_misfit)
      : choices_(choices), pair_misfit_(pair_misfit) {}

  std::vector<NamedTracklet> Best() {
    Try(0, 0);
    return best_;
  }

 private:
  // All choices of this name and those after it, beside what has been chosen for those before it.
  void Try(std::size_t name, double misfit) {
    if (name == choices_.size()) {
      if (misfit < least_) {
        least_ = misfit;
        best_ = chosen_;
      }
      return;
    }
    Try(name + 1, misfit);
    for (const NamedTracklet& choice : choices_[name]) {
      const std::optional<double> own = MisfitBesideChosen(choice);
      if (!own) continue;
      chosen_.push_back(choice);
      Try(name + 1, misfit + *own);
      chosen_.pop_back();
    }
  }

  std::optional<double> MisfitBesideChosen(const NamedTracklet& choice) const {
    double misfit = choice.misfit;
    for (const NamedTracklet& other : chosen_) {
      if (other.tracklet == choice.tracklet) return std::nullopt;
      const std::optional<double> pair = pair_misfit_(other, choice);
      if (!pair) return std::nullopt;
      misfit += *pair;
    }
    return misfit;
  }

  const std::vector<std::vector<NamedTracklet>>& choices_;
  const PairMisfit& pair_misfit_;
  std::vector<NamedTracklet> chosen_, best_;
  double least_ = 0;
};

}  // namespace

std::vector<NamedTracklet> LikeliestTogether(const std::vector<std::vector<NamedTracklet>>& choices,
                                             const PairMisfit& pair_misfit) {
  return Combinations(choices, pair_misfit).Best();
}

}  // namespace lake::tracking
