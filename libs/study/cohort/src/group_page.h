// group.html: what a cohort found, and links to each study.
#pragma once

#include <vector>

#include "lake/cohort/group_statistics.h"
#include "lake/report/report.h"
#include "workflow.h"

namespace lake::cohort {

struct GroupFindings {
  std::string repetition;  // what one of the movement is called
  std::vector<CurveRow> curves;
  std::vector<ReliabilityRow> reliability;
  std::vector<DifferenceRow> differences;
  std::vector<OutlierRow> outliers;
  std::vector<Failure> failures;
};

report::Report MakeGroupPage(const Workflow& workflow, const GroupData& group, const GroupFindings& findings,
                             const Json& head);

}  // namespace lake::cohort
