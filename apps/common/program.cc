#include "program.h"

#include <fmt/format.h>
#include <glog/logging.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <string_view>
#include <system_error>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/fault_text.h"
#include "lake/core/interrupt.h"
#include "lake/core/nearest_name.h"
#include "lake/core/options_json.h"
#include "lake/core/provenance.h"
#include "lake/core/removed.h"
#include "lake/core/shell_word.h"
#include "lake/core/standard_output.h"
#include "lake/core/threads.h"
#include "pages.h"

namespace lake {
namespace {

enum ExitCode { kDone = 0, kFailed = 1, kWrongUsage = 2, kNoSolution = 3, kSignalBase = 128 };

// One line, whatever the text holds.
int Complain(const std::string& program, std::string text, ExitCode code) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  fmt::print(stderr, "{}: {}\n", program, text);
  return code;
}

// What is said when a library calls abort(), as some do when they get no memory. A signal handler may only write.
char last_words[512];

void SayLastWords(int) {
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, last_words, std::strlen(last_words));
  _exit(kFailed);
}

void PrepareLastWords(const std::string& program) {
  const auto end = fmt::format_to_n(last_words, sizeof last_words - 1,
                                    "{}: a library gave up; too little memory is the usual reason (ulimit -v), and "
                                    "with --threads 1 less is needed\n",
                                    program)
                       .out;
  *end = '\0';
  std::signal(SIGABRT, SayLastWords);
}

// What Ceres finds remarkable, such as a Jacobian of less than full rank, is in what it returns, and is said in words
// of our own where it matters.
void SilenceCeres() {
  FLAGS_minloglevel = google::GLOG_FATAL;
}

// As it was given, but for the folder of the program.
std::string CommandLineOf(int argc, char** argv) {
  std::vector<std::string> words(argv, argv + argc);
  words.front() = std::filesystem::path(words.front()).filename();
  return CommandLine(words);
}

// The heading in --help-all of the options that --help leaves out.
constexpr const char* kFurther = "Further options";

// --help fits on a screen: it counts the further options, which --help-all shows.
class HelpPage : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    is_short_ = mode == CLI::AppFormatMode::Normal;
    left_out_ = 0;
    std::string page = CLI::Formatter::make_help(app, name, mode);
    if (left_out_ > 0) page += fmt::format("\n{} further options: {} --help-all\n", left_out_, app->get_name());
    return page;
  }

  std::string make_group(std::string group, bool is_positional,
                         std::vector<const CLI::Option*> options) const override {
    if (!is_short_ || group != kFurther) return CLI::Formatter::make_group(group, is_positional, options);
    left_out_ += options.size();
    return "";
  }

 private:
  mutable bool is_short_ = false;
  mutable std::size_t left_out_ = 0;
};

// The command line keeps the list as long as itself.
CLI::Option* AddFlag(CLI::App& cli, Option& option, const SharedOptions& list) {
  const std::string names = "--" + option.Name() + (option.HasNegation() ? ",!--no-" + option.Name() : "");
  const auto check = [](const std::string& text) -> std::string {
    bool is_flag = true;
    try {
      errno = 0;
      CLI::detail::to_flag_value(text);
      is_flag = errno == 0;  // from CLI11 2.3 on
    } catch (const std::invalid_argument&) {
      is_flag = false;
    }
    return is_flag ? "" : fmt::format("must be true or false, not '{}'", text);
  };
  const auto give = [&option, list](std::int64_t value) { option.Give({value > 0 ? "true" : "false"}); };
  return cli.add_flag_function(names, give, option.Help())
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast)
      ->check(check);
}

std::string NeedsValue(std::string_view option, std::string_view value) {
  return fmt::format("{} needs a value: {}", option, value);
}

// Whether the text is an option of this level or of those above.
bool IsOption(const CLI::App* level, const std::string& text) {
  for (; level; level = level->get_parent())
    if (text.starts_with('-') && level->get_option_no_throw(text)) return true;
  return false;
}

// What the values of a list look like, as --help shows them: anything, 2,70.5 or NAME=….
enum class Form { kText, kNumbers, kNamed };

Form FormOf(const Option& option) {
  if (option.Value().starts_with("NAME=")) return Form::kNamed;
  return option.Value().ends_with(",...") ? Form::kNumbers : Form::kText;
}

bool HasForm(const std::string& word, Form form) {
  if (form == Form::kNamed) return !word.starts_with('-') && word.find('=') != std::string::npos;
  return std::ranges::all_of(SplitText(word, ','),
                             [](const std::string& part) { return ParseNumber(part).has_value(); });
}

CLI::Option* AddValue(CLI::App& cli, Option& option, const SharedOptions& list) {
  const auto give = [&cli, &option, list](const CLI::results_t& texts) {
    // CLI11 takes an option that follows for the value that is missing.
    if (std::ranges::any_of(texts, [&](const std::string& text) { return IsOption(&cli, text); }))
      throw CLI::ArgumentMismatch(NeedsValue("--" + option.Name(), option.Value()));
    const bool is_implied = !option.ImpliedText().empty() && texts == CLI::results_t{""};
    option.Give(is_implied ? OptionTexts{option.ImpliedText()} : texts);
    return true;
  };
  CLI::Option* added = cli.add_option((option.IsOperand() ? "" : "--") + option.Name(), give, option.Help());
  added->type_name(option.Value())->type_size(1)->default_str(option.DefaultText())->required(option.IsRequired());
  if (option.IsRepeated())
    added->expected(1, CLI::detail::expected_max_vector_size)
        ->allow_extra_args(FormOf(option) == Form::kText);  // else see NameEachValue()
  else
    added->expected(option.ImpliedText().empty() ? 1 : 0, 1);
  return added;
}

// --angles -20 70 design.yaml as --angles -20 --angles 70 design.yaml: CLI11 takes every word that follows for one more
// value, and what does not look like one belongs to the program. Last word first, as CLI11 reads them.
std::vector<std::string> NameEachValue(int argc, char** argv, const std::vector<SharedOptions>& lists) {
  std::map<std::string, Form> forms;
  for (const SharedOptions& list : lists)
    for (const Option& option : list->All())
      if (option.IsRepeated() && !option.IsOperand() && FormOf(option) != Form::kText)
        forms["--" + option.Name()] = FormOf(option);
  std::vector<std::string> words(argv + 1, argv + argc);
  for (std::size_t i = 0; i < words.size() && words[i] != "--"; ++i) {
    const std::string name = words[i].substr(0, words[i].find('='));
    const auto found = forms.find(name);
    if (found == forms.end()) continue;
    if (name == words[i]) ++i;
    for (; i + 1 < words.size() && HasForm(words[i + 1], found->second); i += 2)
      words.insert(words.begin() + static_cast<std::ptrdiff_t>(i) + 1, name);
  }
  std::ranges::reverse(words);
  return words;
}

// The options of the command line itself, of its groups, and of the command that was given.
std::vector<const CLI::App*> GivenLevels(const CLI::App& cli) {
  std::vector<const CLI::App*> levels = {&cli};
  for (const CLI::App* group : cli.get_subcommands([](const CLI::App* app) { return app->get_name().empty(); }))
    levels.push_back(group);
  for (const CLI::App* command : cli.get_subcommands()) levels.push_back(command);
  return levels;
}

// The long names of all options, those of its groups and commands too.
std::vector<std::string> OptionNames(const CLI::App& cli, const std::string& prefix) {
  std::vector<std::string> names;
  for (const CLI::Option* option : cli.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back(prefix + name);
  for (const CLI::App* level : cli.get_subcommands([](const CLI::App*) { return true; }))
    for (std::string& name : OptionNames(*level, prefix)) names.push_back(std::move(name));
  return names;
}

void AddEffective(const CLI::Option& option, Json& options) {
  const std::string name = option.get_lnames().empty() ? option.get_name() : option.get_lnames().front();
  if (!option.get_configurable() || name == "help" || name == "version" || name == "config") return;
  if (option.count() == 0)
    options[name] = option.get_default_str();
  else if (option.results().size() == 1)
    options[name] = option.results().front();
  else
    options[name] = option.results();
}

// Prints a page and ends, as --help does.
void AddPages(CLI::App& cli) {
  const auto print = [](const std::string& page) {
    fmt::print("{}", page);
    throw CLI::Success();
  };
  cli.formatter(std::make_shared<HelpPage>());
  cli.set_help_all_flag("--help-all", "Help with all commands and options; the manual page is made of it")->group("");
  const auto complete = [&cli, print](const std::string& shell) { print(Completion(cli, shell)); };
  cli.add_option_function<std::string>("--completion", complete, "For this shell: bash, zsh, fish")
      ->configurable(false)
      ->group("");
}

// A file of --config, in which a name that stands twice would be read once, whichever is meant.
class ConfigFile : public CLI::ConfigTOML {
 public:
  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override {
    std::vector<CLI::ConfigItem> items = CLI::ConfigTOML::from_config(input);
    std::set<std::string> seen;
    for (const CLI::ConfigItem& item : items)
      if (!seen.insert(item.fullname()).second)
        throw CLI::ConfigError(fmt::format("'{}' stands twice; keep one", item.fullname()));
    return items;
  }
};

// What CLI11 says of a file of --config: "INI was not able to parse calibrate.thresh"; of a section that is no command
// "… calibrat.++".
std::string TextOf(const CLI::ConfigError& error, const CLI::App& cli) {
  constexpr std::string_view kUnknown = "INI was not able to parse ", kSection = ".++";
  const std::string file = cli.get_config_ptr()->as<std::string>();
  std::string_view text = error.what();
  if (!text.starts_with(kUnknown)) return fmt::format("{}: {}", file, text);
  text.remove_prefix(kUnknown.size());
  if (!text.ends_with(kSection)) {
    const std::string why =
        WhyRemoved(cli.get_name(), fmt::format("--{}", text.substr(text.rfind('.') + 1)));  // rfind: npos + 1 is 0
    return why.empty()
               ? fmt::format("{}: there is no option '{}'{}", file, text, DidYouMean(text, OptionNames(cli, "")))
               : fmt::format("{}: {}", file, why);
  }
  text.remove_suffix(kSection.size());
  return fmt::format("{}: there is no command '{}'", file, text);
}

std::string TextOf(const CLI::ExtrasError& error, const CLI::App& cli) {
  const std::vector<std::string> words = cli.remaining(true);
  const auto option = std::ranges::find_if(words, [](const std::string& word) { return word.starts_with("--"); });
  if (option == words.end()) return error.what();
  const std::string name = option->substr(0, option->find('='));
  return fmt::format("there is no option '{}'{}", name, DidYouMean(name, OptionNames(cli, "--")));
}

// What CLI11 says of an option that ends the line, "--starts: 1 required INT missing", or is given twice.
std::string TextOf(const CLI::ParseError& error) {
  constexpr std::string_view kRequired = " required ", kMissing = " missing";
  const std::string_view text = error.what();
  if (const std::size_t twice = text.find(": At Most 1 required"); twice != std::string::npos)
    return fmt::format("{} is given twice; give it once", text.substr(0, twice));
  const std::size_t name_end = text.find(": "), required = text.find(kRequired);
  if (name_end == std::string::npos || required == std::string::npos || !text.ends_with(kMissing))
    return std::string(text);
  const std::size_t value = required + kRequired.size();
  return NeedsValue(text.substr(0, name_end), text.substr(value, text.size() - kMissing.size() - value));
}

// What the command line has of an earlier version; its command comes first.
std::string RemovedIn(const std::string& program, int argc, char** argv) {
  for (int i = 1; i < argc && std::string_view(argv[i]) != "--"; ++i)
    if (const std::string why = WhyRemoved(program, argv[i]);
        !why.empty() && (i == 1 || std::string_view(argv[i]).starts_with("--")))
      return why;
  return {};
}

}  // namespace

SharedOptions AddOptions(CLI::App& cli, OptionList options, const std::string& group) {
  const auto list = std::make_shared<OptionList>(std::move(options));
  CLI::App& level = group.empty() ? cli : *cli.add_option_group(group);
  for (Option& option : list->All()) {
    CLI::Option* added = option.IsFlag() ? AddFlag(level, option, list) : AddValue(level, option, list);
    if (option.IsFurther()) added->group(kFurther);
  }
  return list;
}

Json EffectiveOptions(const CLI::App& cli, const std::vector<SharedOptions>& lists) {
  Json options = Json::object();
  for (const CLI::App* command : cli.get_subcommands()) options["command"] = command->get_name();
  for (const CLI::App* level : GivenLevels(cli))
    for (const CLI::Option* option : level->get_options()) AddEffective(*option, options);
  for (const SharedOptions& list : lists) options.update(OptionsJson(*list));
  return options;
}

int ParseAndRun(CLI::App& cli, const std::vector<SharedOptions>& lists, int argc, char** argv,
                const std::function<int()>& work) {
  const std::string name = cli.get_name();
  cli.set_version_flag("--version", fmt::format("{} {}", name, VersionAndCommit()));
  AddPages(cli);
  SilenceCeres();
  PrepareLastWords(name);
  const auto parse_and_work = [&] {
    if (const std::string why = RemovedIn(name, argc, argv); !why.empty()) throw UsageError("{}", why);
    try {
      cli.parse(NameEachValue(argc, argv, lists));
      return work();
    } catch (const CLI::Success& page) {
      return cli.exit(page);  // --help, --version
    }
  };
  try {
    const int code = parse_and_work();
    FlushStdout();
    return code;
  } catch (const CLI::ConfigError& error) {
    return Complain(name, fmt::format("{}; see {} --help", TextOf(error, cli), name), kWrongUsage);
  } catch (const CLI::ExtrasError& error) {
    return Complain(name, fmt::format("{}; see {} --help", TextOf(error, cli), name), kWrongUsage);
  } catch (const CLI::ParseError& error) {
    return Complain(name, fmt::format("{}; see {} --help", TextOf(error), name), kWrongUsage);
  } catch (const UsageError& error) {
    return Complain(name, error.what(), kWrongUsage);
  } catch (const SolverError& error) {
    return Complain(name, error.what(), kNoSolution);
  } catch (const Interrupted& interrupted) {
    fmt::print(stderr, "{}: interrupted\n", name);
    return kSignalBase + interrupted.Signal();
  } catch (const std::system_error& error) {
    const bool starved = error.code() == std::errc::resource_unavailable_try_again;
    return Complain(name,
                    starved ? "the system gives this program no more threads or memory; close others, or raise its "
                              "limits (ulimit -u, ulimit -v)"
                            : fmt::format("{}{}", std::ferror(stdout) ? "stdout: " : "", error.what()),
                    kFailed);
  } catch (const std::exception& error) {
    return Complain(name, FaultText(error), kFailed);
  }
}

int RunTool(const std::string& name, const std::string& what, const std::string& examples, OptionList options, int argc,
            char** argv, const std::function<void()>& work) {
  CLI::App cli(what, name);
  cli.footer(examples);
  const SharedOptions given = AddOptions(cli, std::move(options));
  return ParseAndRun(cli, {given}, argc, argv, [&] {
    given->Apply();
    work();
    return kDone;
  });
}

Program::Program(std::string name, std::string what, std::string example)
    : name_(std::move(name)), cli_(std::make_unique<CLI::App>(std::move(what), name_)) {
  cli_->footer("Example:\n  " + example);
  cli_->option_defaults()->always_capture_default();
  cli_->add_option("-o,--out", out_, "Folder for the results; made if absent (default: ./lake-out/NAME)");
  cli_->add_option_function<std::string>(
          "--threads", [this](const std::string& text) { threads_ = OptionValue<int>::Parse(text, "--threads"); },
          "Threads to work with; results do not depend on it (default: the machine's)")
      ->type_name("INT");
  cli_->add_flag("--quiet", quiet_, "No progress");
  cli_->add_flag("--json", json_, "Print the summary to stdout as JSON");
  cli_->config_formatter(std::make_shared<ConfigFile>());
  cli_->allow_config_extras(CLI::config_extras_mode::error);
  cli_->set_config("--config", "", "Take options from this file; each run writes those it was given as options.toml");
}

Program::~Program() = default;

SharedOptions Program::Add(OptionList options, const std::string& group) {
  lists_.push_back({cli_.get(), AddOptions(*cli_, std::move(options), group)});
  return lists_.back().second;
}

std::function<bool()> Program::AddCommand(const std::string& name, const std::string& what, const std::string& example,
                                          OptionList options) {
  CLI::App* command = cli_->add_subcommand(name, what);
  lists_.push_back({command, AddOptions(*command, std::move(options))});
  command->footer("Example:\n  " + example);
  command->fallthrough();
  cli_->require_subcommand(0, 1);
  return [command] { return command->parsed(); };
}

void Program::TakeOutByPlace() {
  cli_->remove_option(cli_->get_option("--out"));
  cli_->add_option("out", out_, "Folder for the results; made if absent");
}

std::vector<SharedOptions> Program::GivenLists() const {
  std::vector<SharedOptions> lists;
  for (const auto& [app, list] : lists_)
    if (app == cli_.get() || app->parsed()) lists.push_back(list);
  return lists;
}

std::vector<std::string> Program::Subject() const {
  std::vector<std::string> named, files;
  for (const CLI::App* level : GivenLevels(*cli_))
    for (const CLI::Option* option : level->get_options())
      for (const std::string& value : option->results()) {
        std::error_code error;
        const std::filesystem::path path = std::filesystem::weakly_canonical(value, error);
        if (error || value.empty()) continue;
        if (option->get_positional()) named.push_back(path.string());
        if (option->get_name() != "--out" && std::filesystem::exists(path, error)) files.push_back(path.string());
      }
  return named.empty() ? files : named;
}

int Program::Main(int argc, char** argv, const std::function<std::string()>& result_name,
                  const std::function<Json(Run&)>& work) {
  std::vector<SharedOptions> lists;
  for (const auto& [app, list] : lists_) lists.push_back(list);
  return ParseAndRun(*cli_, lists, argc, argv, [&] {
    CatchInterrupts();
    if (threads_) SetThreads(*threads_);
    for (const SharedOptions& list : GivenLists()) list->Apply();
    return Work(CommandLineOf(argc, argv), result_name(), work);
  });
}

int Program::Work(const std::string& command, const std::string& result_name, const std::function<Json(Run&)>& work) {
  const bool is_default = out_.empty();
  if (is_default) out_ = (std::filesystem::path("lake-out") / result_name).string();  // or an absolute path
  Json options = EffectiveOptions(*cli_, GivenLists());
  options["out"] = out_;
  Run::Info info{.program = name_,
                 .command = command,
                 .options = options,
                 .out = out_,
                 .quiet = quiet_,
                 .subject = Subject(),
                 .default_folder = is_default};
  for (const SharedOptions& list : GivenLists())
    for (const Option& option : list->All())
      if (!option.Given().empty()) info.given.push_back(option.Name());
  Run run(std::move(info));
  const Json results = work(run);
  if (results.is_null()) {
    run.Publish();
    return kDone;
  }
  WriteTextFile(run.Result("options.toml"), cli_->config_to_str(false));
  const Json summary = run.WriteSummary(results);
  if (json_)
    fmt::print("{}\n", summary.dump(2, ' ', false, Json::error_handler_t::replace));
  else
    fmt::print("{}results in {}\n", run.ReportText(), out_);
  return run.IsRejected() ? kFailed : kDone;
}

}  // namespace lake
