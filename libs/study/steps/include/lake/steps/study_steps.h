// A study's steps: each is done again only when something that it is made of has changed.
//
// A step is left out when its stamp, written beside its outputs after its last success, names the same program, the
// same options and the same content (SHA-256) of its inputs, and its outputs still have the content that it left.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"

namespace lake::steps {

// An option's key in a section of a study file.
struct StudyKey {
  std::string option;    // "seed"
  std::string key;       // "seeds"
  bool is_list = false;  // takes several values
};

std::vector<StudyKey> KeysOf(const OptionList& options);

// What a message's options are in a study file: ' (in the study file: seeds: ["knee=1,2"])' where it names --seed
// knee=1,2; the key alone where no value follows; empty where it names none of them.
std::string InStudyFile(const std::string& message, const std::vector<StudyKey>& keys);

// What a step took of a machine when it was done last.
struct StepCost {
  double seconds = 0;
  double memory_mb = 0;  // the most at a time, of its process and of the largest that it started
};

struct StudyStep {
  std::string name = {};                           // "exo"
  std::string what = {};                           // one line for progress and errors: "the exoskeleton trial, exo.mp4"
  std::string program = {};                        // whose work it is: "lake-track"
  std::filesystem::path folder = {};               // of its outputs
  std::vector<std::filesystem::path> inputs = {};  // files and folders it reads; one that is absent counts as such
  std::vector<std::string> whole_steps = {};       // earlier steps all outputs of which it reads
  Json options = Json::object();                   // what else its outputs depend on
  std::function<void(Run&)> work = {};  // writes through the run: its outputs are what the run has given out as results
  Json summary_options = Json::object();  // options for its summary, named as its program's
  std::vector<std::string> given = {};    // those of them that the study gives
  std::vector<StudyKey> keys = {};        // of its section of the study file, for errors that name options
};

struct StepRunOptions {
  std::string made_by = ThisProgram();    // that outputs are made by; those of another are made again
  std::string command = {};               // for the steps' summaries
  bool quiet = false;                     // no progress
  std::vector<std::string> subject = {};  // the study file, for the folders' lists of results
  std::vector<std::string> only = {};     // these steps alone; empty: all
  bool keep_going = false;                // where a step fails, all that does not read it is done nevertheless

  // Version and content hash of a program, by default the running one, but for the commit that it names: a commit that
  // changes nothing in the program makes no step be done again.
  static std::string ThisProgram(const std::filesystem::path& program = "/proc/self/exe");
};

struct StepOutcome {
  std::string name = {};
  bool done = false;     // false: its outputs were as they must be
  std::string why = {};  // it was done: "exo.mp4 changed"
  double seconds = 0;    // that it took when it was done last
};

// Removes what a step left that the study does not have any more, nothing else in its folder.
void RetireStudyStep(const std::filesystem::path& folder, const std::string& step);

// Steps come after those whose outputs they read, and begin when these are done: as many at the same time as there are
// threads, each in a process of its own, with the same outputs as in sequence. A failing step ends the run; of several
// the first counts. The exception has the cause's type, and its text names the step. Finished steps keep their outputs,
// running ones are finished, no further one begins. A running step has no stamp, and its earlier outputs stay until the
// new ones are complete.
//
// With `only`, the steps before must have been done and are not examined; other processes may run other steps
// meanwhile. Throws Error if there is no such step or if one that it reads from has not been done or failed.
std::vector<StepOutcome> RunSteps(const std::vector<StudyStep>& steps, const StepRunOptions& options);

// The earlier steps that a step reads outputs of.
std::vector<std::string> StepsBefore(const std::vector<StudyStep>& steps, const StudyStep& step);

// Why each step would be done by RunSteps, empty if it would not be: what has changed, or that a step before it is to
// be done (whose outputs may come out the same). Nothing is done or written.
std::vector<std::string> WhyDoSteps(const std::vector<StudyStep>& steps,
                                    const std::string& made_by = StepRunOptions::ThisProgram());

// What a step took the last time, whatever has changed since; nullopt if it has not been done.
std::optional<StepCost> LastCost(const StudyStep& step);

// The error of the step's last run; nullopt if it did not fail.
std::optional<std::string> StepFailure(const StudyStep& step);

}  // namespace lake::steps
