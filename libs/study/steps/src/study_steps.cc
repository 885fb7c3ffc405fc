#include "lake/steps/study_steps.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <utility>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/provenance.h"
#include "step_stamp.h"

namespace lake::steps {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

const FileState* Find(const std::vector<FileState>& states, const fs::path& path) {
  const auto found = std::find_if(states.begin(), states.end(), [&](const FileState& s) { return s.path == path; });
  return found == states.end() ? nullptr : &*found;
}

std::vector<FileState> InputsNow(const StudyStep& step, const std::optional<StepStamp>& stamp,
                                 const std::map<std::string, StepStamp>& earlier) {
  std::vector<FileState> inputs;
  for (const fs::path& path : step.inputs) inputs.push_back(StateOf(path, stamp ? Find(stamp->inputs, path) : nullptr));
  for (const std::string& name : step.whole_steps) {
    const std::vector<FileState>& outputs = earlier.at(name).outputs;
    inputs.insert(inputs.end(), outputs.begin(), outputs.end());
  }
  return inputs;
}

std::string ChangedInput(const std::vector<FileState>& before, const std::vector<FileState>& now) {
  for (std::size_t i = 0; i < now.size(); ++i)
    if (i >= before.size() || before[i].sha256 != now[i].sha256)
      return fmt::format("{} changed", now[i].path.filename().string());
  return before.size() != now.size() ? "it has other inputs" : "";
}

std::string ChangedOutput(const std::vector<FileState>& outputs) {
  for (const FileState& output : outputs) {
    const FileState now = StateOf(output.path, &output);
    if (now.IsAbsent()) return fmt::format("{} is missing", output.path.filename().string());
    if (now.sha256 != output.sha256) return fmt::format("{} was changed", output.path.filename().string());
  }
  return "";
}

// Empty if the step need not be done.
std::string WhyDoIt(const StudyStep& step, const std::optional<StepStamp>& stamp, const std::vector<FileState>& inputs,
                    const std::string& made_by) {
  if (!stamp) return "not made yet";
  if (stamp->made_by != made_by) return "made by another build of lake";
  if (stamp->options != step.options) return "its options changed";
  if (const std::string changed = ChangedInput(stamp->inputs, inputs); !changed.empty()) return changed;
  return ChangedOutput(stamp->outputs);
}

// Throws what is being handled again, the step named before its text.
[[noreturn]] void RethrowAbout(const StudyStep& step) {
  const std::string place = fmt::format("step {} ({}): ", step.name, step.what);
  try {
    throw;
  } catch (const UsageError& error) {
    throw UsageError(place + error.what());
  } catch (const SolverError& error) {
    throw SolverError(place + error.what());
  } catch (const Interrupted&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw Error(place + "not enough memory for this input");
  } catch (const std::exception& error) {
    throw Error(place + error.what());
  }
}

StepStamp Do(const StudyStep& step, const std::vector<FileState>& inputs, const StepRunOptions& options) {
  const Clock::time_point start = Clock::now();
  Run run({step.program, options.command, step.options, step.folder, options.quiet, options.subject, false, step.name});
  try {
    run.Begin();
    step.work(run);
  } catch (...) {
    RethrowAbout(step);
  }
  StepStamp stamp{options.made_by, step.options, inputs, {}, SecondsSince(start)};
  for (const fs::path& path : run.Results()) stamp.outputs.push_back(StateOf(path));
  WriteStamp(step.folder, step.name, stamp);
  return stamp;
}

// Which step of how many, and how long the rest will take, going by the last time and by what those done now took.
class StepProgress {
 public:
  StepProgress(const std::vector<StudyStep>& steps, bool quiet) : steps_(steps), quiet_(quiet) {
    for (const StudyStep& step : steps) {
      const auto stamp = ReadStamp(step.folder, step.name);
      expected_s_.push_back(stamp ? stamp->seconds : step.expected_s);
    }
  }

  void Unchanged(std::size_t step) const { Say(step, "unchanged"); }

  void Begin(std::size_t step, const std::string& why) const {
    double left_s = 0;
    for (std::size_t i = step; i < steps_.size(); ++i) left_s += expected_s_[i];
    if (expected_done_s_ > 0) left_s *= std::clamp(took_s_ / expected_done_s_, 0.1, 10.0);
    Say(step, fmt::format("{} ({}), {:.0f} s left", steps_[step].what, why, std::max(1.0, left_s)));
  }

  void Done(std::size_t step, double seconds) { expected_done_s_ += expected_s_[step], took_s_ += seconds; }

 private:
  void Say(std::size_t step, const std::string& text) const {
    if (!quiet_) fmt::print(stderr, "[{}/{}] {}: {}\n", step + 1, steps_.size(), steps_[step].name, text);
  }

  const std::vector<StudyStep>& steps_;
  bool quiet_;
  std::vector<double> expected_s_;
  double expected_done_s_ = 0, took_s_ = 0;
};

bool ReadsAllOf(const StudyStep& step, const std::string& earlier) {
  return std::find(step.whole_steps.begin(), step.whole_steps.end(), earlier) != step.whole_steps.end();
}

// The stamps of the steps all outputs of which a step reads.
std::map<std::string, StepStamp> StampsBefore(const std::vector<StudyStep>& steps, const StudyStep& step) {
  std::map<std::string, StepStamp> stamps;
  for (const StudyStep& earlier : steps) {
    if (!ReadsAllOf(step, earlier.name)) continue;
    std::optional<StepStamp> stamp = ReadStamp(earlier.folder, earlier.name);
    if (!stamp)
      throw Fail("step {} ({}): reads what step {} leaves, which has not been done; do that first", step.name,
                 step.what, earlier.name);
    stamps[earlier.name] = std::move(*stamp);
  }
  return stamps;
}

bool LiesBelow(const fs::path& path, const fs::path& folder) {
  const fs::path below = path.lexically_normal().lexically_relative(folder.lexically_normal());
  return !below.empty() && *below.begin() != "..";
}

const StudyStep& StepOfName(const std::vector<StudyStep>& steps, const std::string& name) {
  std::vector<std::string> names;
  for (const StudyStep& step : steps) {
    if (step.name == name) return step;
    names.push_back(step.name);
  }
  throw Fail("no step '{}' in this study; it has {}", name, fmt::join(names, ", "));
}

// `stamps` are those of steps done before.
std::vector<StepOutcome> RunInOrder(const std::vector<StudyStep>& steps, const StepRunOptions& options,
                                    std::map<std::string, StepStamp> stamps) {
  StepProgress progress(steps, options.quiet);
  std::vector<StepOutcome> outcomes;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    ThrowIfInterrupted();
    const StudyStep& step = steps[i];
    std::optional<StepStamp> stamp = ReadStamp(step.folder, step.name);
    const std::vector<FileState> inputs = InputsNow(step, stamp, stamps);
    const std::string why = WhyDoIt(step, stamp, inputs, options.made_by);
    if (why.empty()) {
      progress.Unchanged(i);
    } else {
      progress.Begin(i, why);
      RemoveStamp(step.folder, step.name);
      stamp = Do(step, inputs, options);
      progress.Done(i, stamp->seconds);
    }
    outcomes.push_back({step.name, !why.empty(), why, stamp->seconds});
    stamps[step.name] = std::move(*stamp);
  }
  return outcomes;
}

}  // namespace

void RetireStudyStep(const fs::path& folder, const std::string& step) {
  RemoveStamp(folder, step);
  RetireStep(folder, step);
  std::error_code not_empty;
  fs::remove(folder, not_empty);
}

std::string StepRunOptions::ThisProgram(const fs::path& program) {
  return fmt::format("lake {} {}", Version(), Sha256OfProgram(program));
}

std::vector<StepOutcome> RunSteps(const std::vector<StudyStep>& steps, const StepRunOptions& options) {
  return RunInOrder(steps, options, {});
}

StepOutcome RunStep(const std::vector<StudyStep>& steps, const std::string& name, const StepRunOptions& options) {
  const StudyStep& step = StepOfName(steps, name);
  return RunInOrder({step}, options, StampsBefore(steps, step)).front();
}

std::vector<std::string> StepsBefore(const std::vector<StudyStep>& steps, const StudyStep& step) {
  std::vector<std::string> names;
  for (const StudyStep& earlier : steps) {
    if (earlier.name == step.name) break;
    const bool reads = std::any_of(step.inputs.begin(), step.inputs.end(),
                                   [&](const fs::path& input) { return LiesBelow(input, earlier.folder); });
    if (reads || ReadsAllOf(step, earlier.name)) names.push_back(earlier.name);
  }
  return names;
}

std::vector<std::string> WhyDoSteps(const std::vector<StudyStep>& steps, const std::string& made_by) {
  std::vector<std::string> reasons;
  std::map<std::string, StepStamp> done;
  for (const StudyStep& step : steps) {
    const std::vector<std::string> before = StepsBefore(steps, step);
    const auto due =
        std::find_if(before.begin(), before.end(), [&](const std::string& name) { return !done.contains(name); });
    std::optional<StepStamp> stamp = ReadStamp(step.folder, step.name);
    if (due != before.end())
      reasons.push_back(stamp ? fmt::format("step {} is to be done before", *due) : "not made yet");
    else
      reasons.push_back(WhyDoIt(step, stamp, InputsNow(step, stamp, done), made_by));
    if (reasons.back().empty()) done[step.name] = std::move(*stamp);
  }
  return reasons;
}

}  // namespace lake::steps
