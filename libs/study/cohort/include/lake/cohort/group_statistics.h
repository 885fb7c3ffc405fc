// Statistics of a group: means, reliability, differences between the trials, outliers.
#pragma once

#include <string>
#include <vector>

#include "lake/cohort/group_data.h"
#include "lake/reliability/reliability.h"

namespace lake::cohort {

// The quantities of the page and of the search for outliers: one for each that is measured.
struct MainQuantity {
  const char *trial, *name, *label, *unit;
  int decimals;
};
const std::vector<MainQuantity>& MainQuantities();

// A repeated measurement. Judges are the sessions that half of the participants have at least, or the repetitions of
// each one's first recording; only participants with a value in each count.
struct ReliabilityRow {
  std::string trial, quantity;
  std::string across;  // session, repetition
  double mean = 0;
  reliability::MeanSquares squares;
  reliability::Estimate icc2, icc3, sem;
  double mdc95 = 0;
  reliability::LimitsOfAgreement agreement;  // of the second judge with the first
};
std::vector<ReliabilityRow> ReliabilityOf(const GroupData& group);

// What an ICC of so few participants means, and how many it takes; empty where they are enough. Some 18 with two
// measurements each distinguish an ICC of 0.9 from one of 0.7 (one-sided 5 %, power 80 %, Walter, Eliasziw & Donner
// 1998, doi 10.1002/(SICI)1097-0258(19980115)17:1<101::AID-SIM727>3.0.CO;2-E).
std::string IccCaution(std::size_t participants);

// Exoskeleton minus human, in those who have both.
struct DifferenceRow {
  std::string quantity;
  double human = 0, exo = 0;  // means
  reliability::MeanOfSubjects difference;

  double StandardErrors() const;  // that the mean is from 0; NaN of one participant
  // Whether the interval of 95 % lies beside 0 where so many differences are compared (Bonferroni; 1: this one alone).
  bool IsClearAmong(std::size_t comparisons) const;
};
// The largest first, relative to their standard errors.
std::vector<DifferenceRow> DifferencesOf(const GroupData& group);

struct OutlierRow {
  std::string participant;
  MainQuantity quantity;
  double value = 0, median = 0, score = 0;

  std::string Why() const;
};
std::vector<OutlierRow> OutliersOf(const GroupData& group);

// Over the participants' own mean curves.
struct CurveRow {
  std::string trial, quantity;
  std::vector<reliability::MeanOfSubjects> percent;  // kPercents of them
  std::vector<std::pair<std::string, Curve>> participants;
};
std::vector<CurveRow> CurvesOf(const GroupData& group);

}  // namespace lake::cohort
