// All combinations of what can be wired that the options allow, and few of them in which each pair of choices occurs.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "actuator/program_fixture.h"

namespace lake {

struct Combination {
  enum Choice { kPot, kSupply, kCurrent, kSense, kRelay, kButton, kChoices };

  unsigned choices = 0;  // bits

  bool Has(int choice) const { return choices >> choice & 1; }

  bool IsAllowed() const { return !Has(kRelay) || Has(kSupply); }

  std::string Name() const {
    static constexpr const char* kNames[] = {"pot", "supply", "current", "sense", "relay", "button"};
    std::string name;
    for (int choice = 0; choice < kChoices; ++choice)
      if (Has(choice)) name += (name.empty() ? "" : ", ") + std::string(kNames[choice]);
    return name.empty() ? "open loop alone" : name;
  }

  actuator::FirmwareOptions Options() const {
    actuator::FirmwareOptions options;
    if (Has(kPot)) WirePotentiometer(options);
    if (Has(kSupply)) options.supply_v = 12;
    options.current_sense = Has(kCurrent);
    options.bridge_sense = Has(kSense);
    if (Has(kRelay)) options.pins.safety_relay = 5;
    if (Has(kButton)) options.pins.hold_button = 4;
    return options;
  }
};

inline std::vector<Combination> AllCombinations() {
  std::vector<Combination> all;
  for (unsigned choices = 0; choices < 1U << Combination::kChoices; ++choices)
    if (Combination{choices}.IsAllowed()) all.push_back({choices});
  return all;
}

// Two choices, each made or not.
inline std::set<std::tuple<int, bool, int, bool>> PairsIn(const Combination& one) {
  std::set<std::tuple<int, bool, int, bool>> pairs;
  for (int a = 0; a < Combination::kChoices; ++a)
    for (int b = 0; b < a; ++b) pairs.emplace(a, one.Has(a), b, one.Has(b));
  return pairs;
}

// Of all, again and again the one with the most pairs that no other had.
inline std::vector<Combination> CombinationsOfPairs() {
  std::set<std::tuple<int, bool, int, bool>> left;
  for (const Combination& one : AllCombinations()) left.merge(PairsIn(one));
  const auto news = [&left](const Combination& one) {
    return std::ranges::count_if(PairsIn(one), [&left](const auto& pair) { return left.contains(pair); });
  };
  std::vector<Combination> chosen;
  while (!left.empty()) {
    chosen.push_back(std::ranges::max(AllCombinations(), {}, news));
    for (const auto& pair : PairsIn(chosen.back())) left.erase(pair);
  }
  return chosen;
}

// All with LAKE_LONG_TESTS=1.
inline std::vector<Combination> CombinationsToTry() {
  return std::getenv("LAKE_LONG_TESTS") ? AllCombinations() : CombinationsOfPairs();
}

}  // namespace lake
