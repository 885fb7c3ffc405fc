#include "strides.h"

#include <algorithm>
#include <map>
#include <utility>

namespace lake::gait {

std::vector<Stride> StridesOf(const std::vector<motion::StsEvent>& events) {
  std::map<std::pair<motion::StsEventKind, int>, motion::StsEvent> numbered;
  for (const motion::StsEvent& event : events) numbered.try_emplace({event.kind, event.repetition}, event);
  std::vector<Stride> strides;
  for (const auto& [key, strike] : numbered) {
    const auto off = numbered.find({motion::StsEventKind::kToeOff, key.second}),
               next = numbered.find({key.first, key.second + 1});
    if (key.first == motion::StsEventKind::kHeelStrike && off != numbered.end() && next != numbered.end())
      strides.push_back({strike, off->second, next->second});
  }
  return strides;
}

void CountStrides(const std::vector<motion::StsEvent>& events, Walk& walk) {
  const auto strikes = std::ranges::count(events, motion::StsEventKind::kHeelStrike, &motion::StsEvent::kind);
  walk.strides = static_cast<int>(StridesOf(events).size());
  // A stride goes on after each heel strike, and before it.
  walk.incomplete = static_cast<int>(2 * strikes) - 2 * walk.strides;
}

}  // namespace lake::gait
