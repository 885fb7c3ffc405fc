// The options of programs, each described once. Beside each options struct stands a function that describes its fields,
//
//   void Describe(ProgramLimits& o, OptionList& options) {
//     options.Add("max-speed", o.max_speed_mm_s, "Speed of the actuator").Unit("mm/s").Positive();
//   }
//
// and from that come the option --max-speed, its line in --help, the man page and the shell's completion, its value in
// the summary's `options`, and the key `max_speed_mm_s` of a study file. A field's value is the option's default.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "lake/core/error.h"

namespace lake {

class YamlNode;

using OptionTexts = std::vector<std::string>;

// Sets a field from the texts given; `said` is the option's name for messages. Throws UsageError.
using SetOption = std::function<void(const OptionTexts& texts, const std::string& said)>;
// The field's value as the option would be given it; empty: none.
using TellOption = std::function<std::string()>;

// One option, bound to a field of a struct that outlives it. The setters return the option itself.
class Option {
 public:
  enum class Path { kNone, kFile, kFolder, kVideo };  // what the text is the place of; a video may be frames/%05d.png

  Option(std::string name, std::string help, SetOption set, TellOption text);

  // Of numbers: "mm", "mm/s", "degrees", …; stands behind the help, gives the key its ending.
  Option& Unit(std::string unit);
  // The key in a study file where it is not the name with '_' and the unit: max-speed, mm/s → max_speed_mm_s.
  Option& Key(std::string key);
  // What --help shows for the value, where unit, choices or type do not say it: "X,Y,W,H".
  Option& Value(std::string value);
  // What holds without the option, where the field's value does not show it.
  Option& Otherwise(std::string what);
  // May be given several times, or with several values.
  Option& Repeats();
  Option& Required();
  // Given by its place on the command line.
  Option& Operand();
  // May be given without a value, which then is this.
  Option& Implied(std::string value);
  // A flag that --no-NAME takes back.
  Option& WithNegation();
  Option& IsPath(Path path);
  // Of a text of its own kind: a list, on the command line with commas.
  Option& SplitAtCommas();

  Option& Positive();
  Option& NotNegative();
  Option& AtLeast(double low);
  Option& Between(double low, double high);

  const std::string& Name() const { return name_; }
  std::string Key() const;
  std::string Help() const;   // with unit, and what holds without the option or its value
  std::string Value() const;  // MM_S, constant|free, FILE, …; empty for a flag
  // The field's value as it was described; empty where Otherwise() says what holds, or where the option must be given.
  std::string DefaultText() const { return otherwise_.empty() && !is_required_ ? default_text_ : ""; }
  // The field's value now: the default, unless a file that another option names, or the option itself, said another.
  std::string Text() const;
  const std::string& ImpliedText() const { return implied_; }
  Path PathKind() const { return path_; }
  bool IsOperand() const { return is_operand_; }  // given by its place, not by --NAME
  bool IsFlag() const { return is_flag_; }
  bool HasNegation() const { return has_negation_; }
  bool IsFurther() const { return is_further_; }  // shown by --help-all alone
  bool IsRepeated() const { return repeats_; }
  bool IsRequired() const { return is_required_; }
  bool IsGiven() const { return !said_.empty(); }

  // Keeps the texts of the command line until OptionList::Apply(). One option may name a file whose values another
  // option changes, so the order of the description decides, not that of the command line.
  void Give(OptionTexts texts) { given_ = std::move(texts); }
  const OptionTexts& Given() const { return given_; }

  // Takes the texts of a command line; values may be lists with commas. Throws UsageError.
  void SetFromCommandLine(const OptionTexts& texts);
  // Takes the texts of a file: lists as their elements, maps as NAME=VALUE. Throws UsageError.
  void SetFromFile(const OptionTexts& elements);
  // The parts of lists with commas, where the option is a list; else the texts themselves.
  OptionTexts Split(const OptionTexts& texts) const;
  // As it was given, for messages: "--end 5.5 s", "'end_s'".
  const std::string& Said() const { return said_; }

 private:
  friend class OptionList;
  void Set(const OptionTexts& texts, const std::string& said);
  Option& Limit(double low, bool low_is_allowed, double high);

  std::string name_, help_, key_, value_, unit_, otherwise_, default_text_, implied_, type_, said_;
  SetOption set_;
  TellOption text_;
  OptionTexts given_;
  Path path_ = Path::kNone;
  bool is_operand_ = false, is_flag_ = false, has_negation_ = false, repeats_ = false, is_required_ = false,
       splits_ = false, is_further_ = false;
  std::optional<std::pair<double, double>> range_;
  bool low_is_allowed_ = true;
};

// How one value is read and written, by its type; `kType` is what --help shows. Parse throws UsageError.
template <typename T>
struct OptionValue;
template <>
struct OptionValue<double> {
  static constexpr const char* kType = "NUMBER";
  static double Parse(const std::string& text, const std::string& said);
  static std::string Format(double value);
};
template <>
struct OptionValue<int> {
  static constexpr const char* kType = "INT";
  static int Parse(const std::string& text, const std::string& said);
  static std::string Format(int value);
};
template <>
struct OptionValue<std::uint64_t> {
  static constexpr const char* kType = "INT";
  static std::uint64_t Parse(const std::string& text, const std::string& said);
  static std::string Format(std::uint64_t value);
};
template <>
struct OptionValue<bool> {
  static constexpr const char* kType = "";
  static bool Parse(const std::string& text, const std::string& said);
  static std::string Format(bool value);
};
template <>
struct OptionValue<std::string> {
  static constexpr const char* kType = "TEXT";
  static std::string Parse(const std::string& text, const std::string& said);
  static std::string Format(const std::string& value);
};
template <>
struct OptionValue<std::filesystem::path> {
  static constexpr const char* kType = "FILE";
  static std::filesystem::path Parse(const std::string& text, const std::string& said);
  static std::string Format(const std::filesystem::path& value);
};

// Throws UsageError unless there are `count` texts.
void CheckTextCount(const OptionTexts& texts, std::size_t count, const std::string& said);
std::string JoinTexts(const OptionTexts& texts);
// NAME=VALUE, each name once. Throws UsageError.
std::vector<std::pair<std::string, std::string>> NamesAndValues(const OptionTexts& texts, const std::string& said);

// How a field is read from all the texts given, by its type: one value …
template <typename T>
struct OptionField {
  using Element = T;
  static constexpr bool kIsList = false;
  static void Set(const OptionTexts& texts, const std::string& said, T& field) {
    CheckTextCount(texts, 1, said);
    field = OptionValue<T>::Parse(texts.front(), said);
  }
  static std::string Text(const T& field) { return OptionValue<T>::Format(field); }
};

// … or none …
template <typename T>
struct OptionField<std::optional<T>> {
  using Element = typename OptionField<T>::Element;
  static constexpr bool kIsList = OptionField<T>::kIsList;
  static void Set(const OptionTexts& texts, const std::string& said, std::optional<T>& field) {
    T value{};
    OptionField<T>::Set(texts, said, value);
    field = value;
  }
  static std::string Text(const std::optional<T>& field) { return field ? OptionField<T>::Text(*field) : ""; }
};

// … a list …
template <typename T>
struct OptionField<std::vector<T>> {
  using Element = T;
  static constexpr bool kIsList = true;
  static void Set(const OptionTexts& texts, const std::string& said, std::vector<T>& field) {
    field.clear();
    for (const std::string& text : texts) field.push_back(OptionValue<T>::Parse(text, said));
  }
  static std::string Text(const std::vector<T>& field) {
    OptionTexts texts;
    for (const T& value : field) texts.push_back(OptionValue<T>::Format(value));
    return JoinTexts(texts);
  }
};

// … of so many …
template <typename T, std::size_t kCount>
struct OptionField<std::array<T, kCount>> {
  using Element = T;
  static constexpr bool kIsList = true;
  static void Set(const OptionTexts& texts, const std::string& said, std::array<T, kCount>& field) {
    CheckTextCount(texts, kCount, said);
    for (std::size_t i = 0; i < kCount; ++i) field[i] = OptionValue<T>::Parse(texts[i], said);
  }
  static std::string Text(const std::array<T, kCount>& field) {
    return OptionField<std::vector<T>>::Text({field.begin(), field.end()});
  }
};

// … or a value to each name.
template <typename T>
struct OptionField<std::map<std::string, T>> {
  using Element = T;
  static constexpr bool kIsList = true;
  static void Set(const OptionTexts& texts, const std::string& said, std::map<std::string, T>& field) {
    field.clear();
    for (const auto& [name, value] : NamesAndValues(texts, said))
      field[name] = OptionValue<T>::Parse(value, said + " " + name);
  }
  static std::string Text(const std::map<std::string, T>& field) {
    OptionTexts texts;
    for (const auto& [name, value] : field) texts.push_back(name + "=" + OptionValue<T>::Format(value));
    return JoinTexts(texts);
  }
};

// The options of a program or of a section of a study file, in the order of --help.
class OptionList {
 public:
  template <typename T>
  Option& Add(std::string name, T& field, std::string help) {
    using Field = OptionField<T>;
    Option& option = AddCustom(
        std::move(name), std::move(help),
        [&field](const OptionTexts& texts, const std::string& said) { Field::Set(texts, said, field); },
        [&field] { return Field::Text(field); });
    option.type_ = OptionValue<typename Field::Element>::kType;
    option.is_flag_ = std::is_same_v<typename Field::Element, bool>;
    const bool is_path = std::is_same_v<typename Field::Element, std::filesystem::path>;
    option.splits_ = Field::kIsList && !is_path;
    if (is_path) option.path_ = Option::Path::kFile;
    return option;
  }

  template <typename T>
  Option& AddOperand(std::string name, T& field, std::string help) {
    return Add(std::move(name), field, std::move(help)).Operand();
  }

  // One of these names. `Field` is the choices' type or an optional one.
  template <typename T>
  using Choices = std::vector<std::pair<std::string, T>>;
  template <typename Field, typename T>
  Option& AddChoice(std::string name, Field& field, const Choices<T>& choices, std::string help) {
    std::string names;
    for (const auto& [text, value] : choices) names += (names.empty() ? "" : "|") + text;
    const auto now = [&field, choices] {
      for (const auto& [text, value] : choices)
        if (field == value) return text;
      return std::string();
    };
    const auto set = [&field, choices](const OptionTexts& texts, const std::string& said) {
      CheckTextCount(texts, 1, said);
      OptionTexts known;
      for (const auto& [text, value] : choices) {
        known.push_back(text);
        if (text == texts.front()) {
          field = value;
          return;
        }
      }
      ThrowNoSuchChoice(texts.front(), known, said);
    };
    return AddCustom(std::move(name), std::move(help), set, now).Value(names);
  }

  // A flag that gives the field this value.
  template <typename T>
  Option& AddFlag(std::string name, T& field, T value, std::string help) {
    const auto set = [&field, value, otherwise = field](const OptionTexts& texts, const std::string& said) {
      CheckTextCount(texts, 1, said);
      field = OptionValue<bool>::Parse(texts.front(), said) ? value : otherwise;
    };
    Option& option = AddCustom(std::move(name), std::move(help), set,
                               [&field, value] { return OptionValue<bool>::Format(field == value); });
    option.is_flag_ = true;
    return option;
  }

  // A text of its own kind.
  Option& AddCustom(
      std::string name, std::string help, SetOption set, TellOption text = [] { return std::string(); });

  // Called once the options are set: `check` derives values from others, and throws Error where options contradict each
  // other.
  void Check(std::function<void(const OptionList&)> check) { checks_.push_back(std::move(check)); }
  void RunChecks() const;

  // Sets the options that a command line gives, in the order of the description, then runs the checks. Throws Error.
  void Apply();

  // The same without these; checks stay.
  OptionList Without(const std::vector<std::string_view>& names) const;

  // The same, of which --help shows these and the operands alone. Throws std::out_of_range where there is no such
  // option.
  OptionList WithUsual(const std::vector<std::string_view>& names) const;

  std::deque<Option>& All() & { return options_; }
  const std::deque<Option>& All() const& { return options_; }
  const std::deque<Option>& All() && = delete;
  // Throws std::out_of_range where there is no such option.
  const Option& operator[](std::string_view name) const;
  // Not where there is no such option, as after Without().
  bool IsGiven(std::string_view name) const;
  bool IsAnyGiven() const;

 private:
  const Option* Find(std::string_view name) const;
  [[noreturn]] static void ThrowNoSuchChoice(const std::string& text, const OptionTexts& known,
                                             const std::string& said);
  std::deque<Option> options_;
  std::vector<std::function<void(const OptionList&)>> checks_;
};

// The description of an options struct, for Describe() functions that take it alone.
template <typename Options>
OptionList OptionsOf(Options& options) {
  OptionList list;
  Describe(options, list);
  return list;
}

// Where an option that IsPath() finds what `node` says: the paths as texts.
using ResolvePath = std::function<OptionTexts(const YamlNode& node, const Option& option)>;

// Takes the options from the keys of a map; others stay for the caller and YamlNode::Finish(). Throws Error with file
// and line.
void ReadOptions(YamlNode& node, OptionList& options, const ResolvePath& resolve);

}  // namespace lake
