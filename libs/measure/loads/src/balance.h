// Whether the path of a trial's rises can be gone along in balance at another pace. Not part of the interface.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lake/loads/body_path.h"
#include "loads_model.h"

namespace lake::loads {

// `trunk`: where its centre is at the person's own pace. The margin's interval is left open.
Balance FindBalance(const Model& model, const TrunkFit& trunk, const std::vector<Rise>& rises,
                    const LoadsOptions& options);

// The body over the rises, their mean.
BodyPath MeanBodyPath(const Model& model, const TrunkFit& trunk, const std::vector<Rise>& rises,
                      const LoadsOptions& options);

// The least margin as slowly as may be, mm.
double SlowMargin(const Model& model, const TrunkFit& trunk, const std::vector<Rise>& rises,
                  const LoadsOptions& options);

// Of the time that was asked for; nullopt if the balance is kept in it, or none was.
std::optional<std::string> BalanceWarning(const Balance& balance);

}  // namespace lake::loads
