#include "lake/steps/study_steps.h"

#include <fmt/ranges.h>
#include <sys/resource.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <map>
#include <utility>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/fault_text.h"
#include "lake/core/interrupt.h"
#include "lake/core/numbers.h"
#include "lake/core/paths.h"
#include "lake/core/processes.h"
#include "lake/core/provenance.h"
#include "lake/core/threads.h"
#include "step_stamp.h"

namespace lake::steps {
namespace {

constexpr const char* kNotMade = "not made yet";

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
  if (!stamp) return kNotMade;
  if (stamp->made_by != made_by) return "made by another build of lake";
  if (stamp->options != step.options) return "its options changed";
  if (const std::string changed = ChangedInput(stamp->inputs, inputs); !changed.empty()) return changed;
  return ChangedOutput(stamp->outputs);
}

// Throws what is being handled again, the step named before its text, and behind it what the study file says for the
// options in it.
[[noreturn]] void RethrowAbout(const StudyStep& step) {
  const auto text_of = [&](const std::string& text) {
    return fmt::format("step {} ({}): {}{}", step.name, step.what, text, InStudyFile(text, step.keys));
  };
  try {
    throw;
  } catch (const UsageError& error) {
    throw UsageError(text_of(error.what()));
  } catch (const SolverError& error) {
    throw SolverError(text_of(error.what()));
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(text_of(FaultText(error)));
  }
}

// Of this process and of the largest that it has started.
double PeakMemoryMb() {
  constexpr double kKilobytesPerMb = 1024;
  double peak_mb = 0;
  for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    peak_mb += static_cast<double>(usage.ru_maxrss) / kKilobytesPerMb;
  }
  return peak_mb;
}

StepStamp Do(const StudyStep& step, const std::vector<FileState>& inputs, const StepRunOptions& options) {
  const Clock::time_point start = Clock::now();
  Run run({.program = step.program,
           .command = options.command,
           .options = step.summary_options,
           .out = step.folder,
           .quiet = options.quiet,
           .subject = options.subject,
           .step = step.name,
           .given = step.given});
  try {
    run.Begin();
    step.work(run);
    run.Publish();
  } catch (...) {
    RethrowAbout(step);
  }
  StepStamp stamp{.made_by = options.made_by,
                  .options = step.options,
                  .inputs = inputs,
                  .cost = {SecondsSince(start), PeakMemoryMb()}};
  for (const fs::path& path : run.Results()) stamp.outputs.push_back(StateOf(path));
  WriteStamp(step.folder, step.name, stamp);
  return stamp;
}

// Which step of how many, and how long the rest will take, where each has been done before: going by the last time and
// by what those done now took.
class StepProgress {
 public:
  StepProgress(const std::vector<StudyStep>& steps, bool quiet) : steps_(steps), quiet_(quiet) {
    for (const StudyStep& step : steps) {
      const auto stamp = ReadStamp(step.folder, step.name);
      expected_s_.push_back(stamp ? stamp->cost.seconds : kNaN);
      left_s_ += expected_s_.back();
    }
  }

  void Unchanged(std::size_t step) {
    left_s_ -= expected_s_[step];
    Say(step, "unchanged");
  }

  void Begin(std::size_t step, const std::string& why) const {
    const double pace = done_s_ > 0 ? std::clamp(SecondsSince(begin_) / done_s_, 0.1, 10.0) : 1;
    const std::string reason = why == kNotMade ? "" : fmt::format(" ({})", why);  // nobody asks why what is new is made
    const std::string left = std::isnan(left_s_) ? "" : fmt::format(", {:.0f} s left", std::max(1.0, pace * left_s_));
    Say(step, fmt::format("{}{}{}", steps_[step].what, reason, left));
  }

  void Done(std::size_t step, double seconds, bool is_said) {
    left_s_ -= expected_s_[step];
    done_s_ += expected_s_[step];
    if (is_said) Say(step, fmt::format("done in {:.1f} s", seconds));
  }

  void Failed(std::size_t step, const std::string& error) const { Say(step, "failed: " + error); }

 private:
  void Say(std::size_t step, const std::string& text) const {
    if (!quiet_) fmt::print(stderr, "[{}/{}] {}: {}\n", step + 1, steps_.size(), steps_[step].name, text);
  }

  const std::vector<StudyStep>& steps_;
  bool quiet_;
  std::vector<double> expected_s_;
  double left_s_ = 0, done_s_ = 0;  // as expected
  Clock::time_point begin_ = Clock::now();
};

bool ReadsAllOf(const StudyStep& step, const std::string& earlier) {
  return std::find(step.whole_steps.begin(), step.whole_steps.end(), earlier) != step.whole_steps.end();
}

// Those of the steps that have these names, all without names.
std::vector<StudyStep> Chosen(const std::vector<StudyStep>& steps, const std::vector<std::string>& names) {
  if (names.empty()) return steps;
  std::vector<std::string> known;
  std::vector<StudyStep> chosen;
  for (const StudyStep& step : steps) {
    known.push_back(step.name);
    if (std::ranges::find(names, step.name) != names.end()) chosen.push_back(step);
  }
  for (const std::string& name : names)
    if (std::ranges::find(known, name) == known.end())
      throw Fail("no step '{}' in this study; it has {}", name, fmt::join(known, ", "));
  return chosen;
}

// The stamps of other steps that one of these reads from: the results of one that failed are those of its last success.
std::map<std::string, StepStamp> StampsBefore(const std::vector<StudyStep>& steps,
                                              const std::vector<StudyStep>& chosen) {
  const auto is_chosen = [&](const StudyStep& step) {
    return std::ranges::any_of(chosen, [&](const StudyStep& one) { return one.name == step.name; });
  };
  std::map<std::string, StepStamp> stamps;
  for (const StudyStep& earlier : steps) {
    const auto reader = std::ranges::find_if(chosen, [&](const StudyStep& step) {
      const std::vector<std::string> before = StepsBefore(steps, step);
      return std::ranges::find(before, earlier.name) != before.end();
    });
    if (reader == chosen.end() || is_chosen(earlier)) continue;
    std::optional<StepStamp> stamp = ReadStamp(earlier.folder, earlier.name);
    if (!stamp)
      throw Fail("step {} ({}): reads what step {} leaves, which has not been done; do that first", reader->name,
                 reader->what, earlier.name);
    stamps[earlier.name] = std::move(*stamp);
  }
  return stamps;
}

// Each step is begun when those that it reads from are done, as many at the same time as there are threads, every one
// in a process of its own; where only one may be, in this process.
class StepRunner {
 public:
  // `stamps` are those of steps done before.
  StepRunner(const std::vector<StudyStep>& steps, const StepRunOptions& options,
             std::map<std::string, StepStamp> stamps)
      : steps_(steps), options_(options), stamps_(std::move(stamps)), progress_(steps, options.quiet) {
    for (const StudyStep& step : steps) {
      before_.push_back(StepsBefore(steps, step));
      outcomes_.push_back({.name = step.name});
    }
    state_.resize(steps.size(), State::kWaiting);
    workers_.resize(steps.size());
  }

  std::vector<StepOutcome> Run() {
    while (CanGoOn()) {
      ThrowIfInterrupted();
      if (MayBegin()) BeginWhatCanBe();
      TakeWhatEnded();
    }
    if (!failures_.empty()) std::rethrow_exception(failures_.begin()->second);
    return std::move(outcomes_);
  }

 private:
  enum class State { kWaiting, kDue, kWorking, kDone, kFailed };

  bool MayBegin() const { return failures_.empty() || options_.keep_going; }

  bool CanGoOn() const {
    if (!Working().empty()) return true;
    if (!MayBegin()) return false;
    for (std::size_t i = 0; i < steps_.size(); ++i)
      if (state_[i] == State::kDue || CanBegin(i)) return true;
    return false;
  }

  bool CanBegin(std::size_t i) const {
    return state_[i] == State::kWaiting &&
           std::ranges::all_of(before_[i], [&](const std::string& name) { return stamps_.contains(name); });
  }

  std::vector<std::size_t> Working() const {
    std::vector<std::size_t> working;
    for (std::size_t i = 0; i < steps_.size(); ++i)
      if (state_[i] == State::kWorking) working.push_back(i);
    return working;
  }

  // Why a step is to be done, and the inputs that it finds.
  struct Due {
    std::size_t step;
    std::string why;
    std::vector<FileState> inputs;
  };

  // A step that can begin is either done with, as nothing has changed, or due.
  void Examine(std::size_t i) {
    std::optional<StepStamp> stamp = ReadStamp(steps_[i].folder, steps_[i].name);
    std::vector<FileState> inputs = InputsNow(steps_[i], stamp, stamps_);
    std::string why = WhyDoIt(steps_[i], stamp, inputs, options_.made_by);
    if (why.empty()) {
      progress_.Unchanged(i);
      return Finish(i, std::move(*stamp));
    }
    state_[i] = State::kDue;
    due_.push_back({i, std::move(why), std::move(inputs)});
  }

  void BeginWhatCanBe() {
    for (std::size_t i = 0; i < steps_.size(); ++i)  // in order: a step comes after those that it reads from
      if (CanBegin(i)) Examine(i);
    const std::size_t working = Working().size(), most = static_cast<std::size_t>(Threads());
    const std::size_t count = std::min(due_.size(), most - std::min(most, working));
    for (std::size_t k = 0; k < count; ++k) Begin(due_[k], count + working == 1);
    due_.erase(due_.begin(), due_.begin() + static_cast<std::ptrdiff_t>(count));
  }

  void Begin(const Due& due, bool alone) {
    const StudyStep& step = steps_[due.step];
    progress_.Begin(due.step, due.why);
    RemoveStamp(step.folder, step.name);
    outcomes_[due.step].done = true;
    outcomes_[due.step].why = due.why;
    if (Threads() == 1) return TakeStep(due.step, false, [&] { return Do(step, due.inputs, options_); });
    StepRunOptions options = options_;
    if (!alone) options.quiet = true;  // two lines of progress would write over each other
    state_[due.step] = State::kWorking;
    workers_[due.step] = std::make_unique<WorkerProcess>([&](const std::function<void()>&) {
      Do(step, due.inputs, options);
      return std::string();
    });
  }

  void TakeWhatEnded() {
    const std::vector<std::size_t> working = Working();
    if (working.empty()) return;
    std::vector<const WorkerProcess*> workers;
    for (const std::size_t i : working) workers.push_back(workers_[i].get());
    const std::vector<bool> ready = WaitForWorkers(workers);
    Progress no_progress("", "", std::nullopt, true);  // steps show their own
    for (std::size_t w = 0; w < working.size(); ++w) {
      const std::size_t i = working[w];
      if (!ready[w] || workers_[i]->Read(no_progress)) continue;
      TakeStep(i, working.size() > 1, [&] { return StampOfWorker(i); });
      workers_[i].reset();
    }
  }

  StepStamp StampOfWorker(std::size_t i) {
    workers_[i]->Take();
    std::optional<StepStamp> stamp = ReadStamp(steps_[i].folder, steps_[i].name);
    if (!stamp) throw Fail("step {} ({}): its outputs were changed while it worked", steps_[i].name, steps_[i].what);
    return std::move(*stamp);
  }

  // A failure is kept until the others that are under way have ended: what they do is not lost.
  void TakeStep(std::size_t i, bool is_said, const std::function<StepStamp()>& take) {
    try {
      StepStamp stamp = take();
      progress_.Done(i, stamp.cost.seconds, is_said);
      Finish(i, std::move(stamp));
    } catch (const Error& error) {
      failures_[i] = std::current_exception();
      state_[i] = State::kFailed;
      WriteFailure(steps_[i].folder, steps_[i].name, error.what());
      if (options_.keep_going) progress_.Failed(i, error.what());
    }
  }

  void Finish(std::size_t i, StepStamp stamp) {
    outcomes_[i].seconds = stamp.cost.seconds;
    stamps_[steps_[i].name] = std::move(stamp);
    state_[i] = State::kDone;
  }

  const std::vector<StudyStep>& steps_;
  const StepRunOptions& options_;
  std::map<std::string, StepStamp> stamps_;
  StepProgress progress_;
  std::vector<std::vector<std::string>> before_;
  std::vector<State> state_;
  std::vector<Due> due_;
  std::map<std::size_t, std::exception_ptr> failures_;  // by step: the first of them is reported
  std::vector<StepOutcome> outcomes_;
  std::vector<std::unique_ptr<WorkerProcess>> workers_;
};

// The word that stands at a place, where it is a value: a number or NAME=….
std::optional<std::string> ValueAt(const std::string& message, std::size_t begin) {
  std::string word = message.substr(begin, message.find_first_of(" )", begin) - begin);
  word.erase(word.find_last_not_of(",;:.") + 1);
  if (ParseNumber(word)) return word;
  return word.find('=') == std::string::npos ? std::nullopt : std::optional(fmt::format("\"{}\"", word));
}

// The key, with the values that the message gives; empty where it does not name the option.
std::string Line(const std::string& message, const StudyKey& key) {
  const std::string name = "--" + key.option;
  bool is_named = false;
  std::vector<std::string> values;
  for (std::size_t at = message.find(name); at != std::string::npos; at = message.find(name, at + 1)) {
    const std::size_t end = at + name.size();
    if (end < message.size() && (std::isalnum(static_cast<unsigned char>(message[end])) || message[end] == '-'))
      continue;
    is_named = true;
    if (end == message.size()) continue;
    if (const auto value = ValueAt(message, end + 1)) values.push_back(*value);
  }
  if (!is_named || values.empty()) return is_named ? key.key : "";
  return key.is_list ? fmt::format("{}: [{}]", key.key, fmt::join(values, ", "))
                     : fmt::format("{}: {}", key.key, values.front());
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
  const std::vector<StudyStep> chosen = Chosen(steps, options.only);
  return StepRunner(chosen, options, StampsBefore(steps, chosen)).Run();
}

std::vector<std::string> StepsBefore(const std::vector<StudyStep>& steps, const StudyStep& step) {
  std::vector<std::string> names;
  for (const StudyStep& earlier : steps) {
    if (earlier.name == step.name) break;
    const bool reads = std::any_of(step.inputs.begin(), step.inputs.end(),
                                   [&](const fs::path& input) { return LiesIn(input, earlier.folder); });
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
      reasons.push_back(stamp ? fmt::format("step {} is to be done before", *due) : kNotMade);
    else
      reasons.push_back(WhyDoIt(step, stamp, InputsNow(step, stamp, done), made_by));
    if (reasons.back().empty()) done[step.name] = std::move(*stamp);
  }
  return reasons;
}

std::optional<StepCost> LastCost(const StudyStep& step) {
  const std::optional<StepStamp> stamp = ReadStamp(step.folder, step.name);
  return stamp ? std::optional(stamp->cost) : std::nullopt;
}

std::optional<std::string> StepFailure(const StudyStep& step) {
  return ReadFailure(step.folder, step.name);
}

std::vector<StudyKey> KeysOf(const OptionList& options) {
  std::vector<StudyKey> keys;
  for (const Option& option : options.All())
    if (!option.IsOperand()) keys.push_back({option.Name(), option.Key(), option.IsRepeated()});
  return keys;
}

std::string InStudyFile(const std::string& message, const std::vector<StudyKey>& keys) {
  std::vector<std::string> lines;
  for (const StudyKey& key : keys)
    if (std::string line = Line(message, key); !line.empty()) lines.push_back(std::move(line));
  return lines.empty() ? "" : fmt::format(" (in the study file: {})", fmt::join(lines, ", "));
}

}  // namespace lake::steps
