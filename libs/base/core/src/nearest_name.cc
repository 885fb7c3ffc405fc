#include "lake/core/nearest_name.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cctype>

namespace lake {
namespace {

using Eigen::Index;

bool IsSameLetter(char a, char b) {
  const auto plain = [](char c) { return c == '-' || c == ' ' ? '_' : static_cast<char>(std::tolower(c)); };
  return plain(a) == plain(b);
}

// The optimal string alignment distance (Boytsov 2011, doi 10.1145/1963190.1963191), capitals and - or _ alike.
int Distance(std::string_view a, std::string_view b) {
  Eigen::MatrixXi d(a.size() + 1, b.size() + 1);
  for (Index i = 0; i < d.rows(); ++i)
    for (Index j = 0; j < d.cols(); ++j) {
      if (i == 0 || j == 0) {
        d(i, j) = static_cast<int>(i + j);
        continue;
      }
      const bool same = IsSameLetter(a[i - 1], b[j - 1]);
      d(i, j) = std::min({d(i - 1, j) + 1, d(i, j - 1) + 1, d(i - 1, j - 1) + (same ? 0 : 1)});
      if (i > 1 && j > 1 && IsSameLetter(a[i - 1], b[j - 2]) && IsSameLetter(a[i - 2], b[j - 1]))
        d(i, j) = std::min(d(i, j), d(i - 2, j - 2) + 1);
    }
  return d(d.rows() - 1, d.cols() - 1);
}

}  // namespace

std::string DidYouMean(std::string_view name, const std::vector<std::string>& known) {
  constexpr std::size_t kLongest = 60;  // names of ours are shorter
  if (name.size() > kLongest) return "";
  const auto distance = [&](const std::string& other) { return Distance(name, other); };
  const auto nearest = std::ranges::min_element(known, {}, distance);
  if (nearest == known.end() || distance(*nearest) > std::max<int>(1, static_cast<int>(name.size()) / 3)) return "";
  return fmt::format("; did you mean '{}'?", *nearest);
}

}  // namespace lake
