// One linkage for several people: the links are common, placement and stroke program are each person's own.
//
//   max  RoR - w M(|e_i - h_i|)                X = links; p_i, d_i(s) of each person i
//   s.t. M(|e_i - h_i| / L_i) <= limit,  and for each person what a redesign asks (redesign_problem.h)
//
// M is the largest RMS of those who count, or the mean RMS of all. With one person it is the redesign.
#pragma once

#include <string>
#include <vector>

#include "lake/redesign/redesign_problem.h"

namespace lake::redesign {

// Of people's misalignments, which one limit, penalty and goal are on. Of the quantile it is the worst of those who
// count, and who counts is sought (group.h).
enum class Across { kWorst, kMean, kQuantile };

struct Subject {
  std::string name;  // empty: one person alone
  HumanMotion human;
  Eigen::Vector2d placement_mm = Eigen::Vector2d::Zero();  // where the joint sits; if it is fitted, a start
  bool counts = true;                                      // not: the quantile leaves this person out
};

struct GroupProblem {
  RedesignProblem shared;  // all but the motion and the placement
  std::vector<Subject> people;
  Across across = Across::kWorst;
  double quantile = 0.9;  // part of the people whose misalignment counts

  static GroupProblem OfOne(const RedesignProblem& problem);
  RedesignProblem Of(std::size_t person) const;

  // How many of the people the quantile holds for; all where it is not asked for.
  std::size_t Counting() const;
  // Of one figure of each person: the mean, or the largest of those who count.
  double Combine(const std::vector<double>& of_people) const;

  // Throw as RedesignProblem's; UsageError also for a quantile that is not within 0 .. 1.
  void CheckOptions() const;
  void Check() const;
};

}  // namespace lake::redesign
