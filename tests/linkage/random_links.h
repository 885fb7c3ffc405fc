// Random linkages for tests; the seed is made of the test's name, so every test sees its own and sees it again.
#pragma once

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "lake/linkage/linkage.h"

namespace lake::testing {

class RandomLinks {
 public:
  RandomLinks() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    const std::string name = std::string(test->test_suite_name()) + "." + test->name();
    std::seed_seq seed(name.begin(), name.end());
    engine_.seed(seed);
  }

  double Uniform(double lower, double upper) { return std::uniform_real_distribution(lower, upper)(engine_); }

  // Within the paper's bounds, or (every other one) far outside them; assemblable somewhere.
  linkage::Links Next() {
    while (true) {
      wide_ = !wide_;
      const double shortest = wide_ ? 10 : 50, longest = wide_ ? 250 : 100;
      const linkage::Links links{Uniform(shortest, longest), Uniform(shortest, longest),
                                 Uniform(shortest, longest), Uniform(shortest, longest),
                                 Uniform(shortest, 120),     Uniform(wide_ ? 20 : 200, 300)};
      if (!linkage::AssemblyRanges(links).empty()) return links;
    }
  }

  // A stroke inside one of the assembly ranges.
  double StrokeFor(const linkage::Links& links) {
    const auto ranges = linkage::AssemblyRanges(links);
    const auto& range = ranges[std::uniform_int_distribution<std::size_t>(0, ranges.size() - 1)(engine_)];
    return Uniform(range.lower_mm, range.upper_mm);
  }

 private:
  std::mt19937 engine_;
  bool wide_ = true;
};

inline std::string TextOf(const linkage::Links& l) {
  return ::testing::PrintToString(l.Values());
}

}  // namespace lake::testing
