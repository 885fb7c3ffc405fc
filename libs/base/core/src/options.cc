#include "lake/core/options.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "lake/core/csv.h"
#include "lake/core/name_value.h"
#include "lake/core/yaml.h"

namespace lake {
namespace {

// How a unit ends a key and stands for the value in --help.
struct UnitText {
  std::string_view unit, key, value;
};
constexpr UnitText kUnits[] = {{"mm", "mm", "MM"},
                               {"mm/s", "mm_s", "MM_S"},
                               {"mm/s²", "mm_s2", "MM_S2"},
                               {"cm", "cm", "CM"},
                               {"px", "px", "PX"},
                               {"s", "s", "S"},
                               {"Hz", "hz", "HZ"},
                               {"degrees", "deg", "DEG"},
                               {"percent", "percent", "PERCENT"},
                               {"N", "n", "N"},
                               {"N m", "nm", "NM"},
                               {"kg", "kg", "KG"},
                               {"years", "years", "YEARS"},
                               {"N/mm", "n_mm", "N_MM"},
                               {"ppm", "ppm", "PPM"},
                               {"mm per rad", "mm", "MM_RAD"},
                               {"degrees per mm RMS", "deg_per_mm", "DEG_MM"},
                               {"degrees per N", "deg_per_n", "DEG_N"}};

const UnitText* FindUnit(const std::string& unit) {
  const auto* found =
      std::find_if(std::begin(kUnits), std::end(kUnits), [&](const UnitText& u) { return u.unit == unit; });
  return found == std::end(kUnits) ? nullptr : found;
}

template <typename Integer>
Integer ParseInteger(const std::string& text, const std::string& said) {
  Integer value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc{} && end == text.data() + text.size()) return value;
  // 3.0 and 1e3 are whole numbers too.
  constexpr double kMost = 1e9;
  const std::optional<double> number = ParseNumber(text);
  const bool is_negative = number && *number < 0 && std::is_unsigned_v<Integer>;
  if (!number || *number != std::round(*number) || std::abs(*number) > kMost || is_negative)
    throw UsageError("{} must be a whole number{}, not {}", said, std::is_unsigned_v<Integer> ? " from 0 on" : "",
                     text);
  return static_cast<Integer>(*number);
}

}  // namespace

double OptionValue<double>::Parse(const std::string& text, const std::string& said) {
  const std::optional<double> number = ParseNumber(text);
  if (!number) throw UsageError("{} must be a finite number, not '{}'", said, text);
  return *number;
}
std::string OptionValue<double>::Format(double value) {
  return FormatNumber(value);
}

int OptionValue<int>::Parse(const std::string& text, const std::string& said) {
  return ParseInteger<int>(text, said);
}
std::string OptionValue<int>::Format(int value) {
  return fmt::format("{}", value);
}

std::uint64_t OptionValue<std::uint64_t>::Parse(const std::string& text, const std::string& said) {
  return ParseInteger<std::uint64_t>(text, said);
}
std::string OptionValue<std::uint64_t>::Format(std::uint64_t value) {
  return fmt::format("{}", value);
}

bool OptionValue<bool>::Parse(const std::string& text, const std::string& said) {
  std::string lower = text;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const char* yes : {"true", "yes", "on", "y"})
    if (lower == yes) return true;
  for (const char* no : {"false", "no", "off", "n"})
    if (lower == no) return false;
  throw UsageError("{} must be true or false", said);
}
std::string OptionValue<bool>::Format(bool value) {
  return value ? "true" : "false";
}

std::string OptionValue<std::string>::Parse(const std::string& text, const std::string&) {
  return text;
}
std::string OptionValue<std::string>::Format(const std::string& value) {
  return value;
}

std::filesystem::path OptionValue<std::filesystem::path>::Parse(const std::string& text, const std::string&) {
  return text;
}
std::string OptionValue<std::filesystem::path>::Format(const std::filesystem::path& value) {
  return value.string();
}

void CheckTextCount(const OptionTexts& texts, std::size_t count, const std::string& said) {
  if (texts.size() == count) return;
  if (count == 1) throw UsageError("{}: a single value was expected", said);
  throw UsageError("{} must have {} numbers, not {}", said, count, texts.size());
}

std::string JoinTexts(const OptionTexts& texts) {
  return fmt::format("{}", fmt::join(texts, ","));
}

std::vector<std::pair<std::string, std::string>> NamesAndValues(const OptionTexts& texts, const std::string& said) {
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const std::string& text : texts) {
    const auto pair = SplitNameValue(said, text);
    if (pair.second.empty()) throw UsageError("{} '{}': no value for '{}'", said, text, pair.first);
    if (std::any_of(pairs.begin(), pairs.end(), [&](const auto& other) { return other.first == pair.first; }))
      throw UsageError("{}: '{}' is given twice", said, pair.first);
    pairs.push_back(pair);
  }
  return pairs;
}

Option::Option(std::string name, std::string help, SetOption set, TellOption text)
    : name_(std::move(name)),
      help_(std::move(help)),
      default_text_(text()),
      type_("TEXT"),
      set_(std::move(set)),
      text_(std::move(text)) {}

Option& Option::Unit(std::string unit) {
  if (!FindUnit(unit)) throw std::invalid_argument(fmt::format("unit '{}' has no ending for keys", unit));
  unit_ = std::move(unit);
  return *this;
}
Option& Option::Key(std::string key) {
  key_ = std::move(key);
  return *this;
}
Option& Option::Value(std::string value) {
  value_ = std::move(value);
  return *this;
}
Option& Option::Otherwise(std::string what) {
  otherwise_ = std::move(what);
  return *this;
}
Option& Option::Repeats() {
  repeats_ = true;
  return *this;
}
Option& Option::Operand() {
  is_operand_ = true;
  return *this;
}
Option& Option::Required() {
  is_required_ = true;
  return *this;
}
Option& Option::Implied(std::string value) {
  implied_ = std::move(value);
  return *this;
}
Option& Option::WithNegation() {
  has_negation_ = true;
  return *this;
}
Option& Option::SplitAtCommas() {
  splits_ = true;
  return *this;
}
Option& Option::IsPath(Path path) {
  path_ = path;
  return *this;
}

Option& Option::Limit(double low, bool low_is_allowed, double high) {
  range_ = {low, high};
  low_is_allowed_ = low_is_allowed;
  return *this;
}
Option& Option::Positive() {
  return Limit(0, false, INFINITY);
}
Option& Option::NotNegative() {
  return Limit(0, true, INFINITY);
}
Option& Option::AtLeast(double low) {
  return Limit(low, true, INFINITY);
}
Option& Option::Between(double low, double high) {
  return Limit(low, true, high);
}

std::string Option::Key() const {
  if (!key_.empty()) return key_;
  std::string key = name_;
  std::replace(key.begin(), key.end(), '-', '_');
  if (const UnitText* unit = FindUnit(unit_)) key.append("_").append(unit->key);
  return key;
}

std::string Option::Help() const {
  std::string help = help_;
  if (!unit_.empty()) help += fmt::format(" [{}]", unit_);
  if (!implied_.empty()) help += fmt::format(" (without a value: {})", implied_);
  if (!otherwise_.empty()) help += fmt::format(" (default: {})", otherwise_);
  return help;
}

std::string Option::Value() const {
  if (is_flag_) return "";
  if (!value_.empty()) return value_;
  if (const UnitText* unit = FindUnit(unit_)) return std::string(unit->value);
  switch (path_) {
    case Path::kFile:
      return "FILE";
    case Path::kFolder:
      return "DIR";
    case Path::kVideo:
      return "VIDEO";
    case Path::kNone:
      break;
  }
  return type_;
}

std::string Option::Text() const {
  const std::string now = text_();
  return now == default_text_ ? DefaultText() : now;
}

OptionTexts Option::Split(const OptionTexts& texts) const {
  if (!splits_) return texts;
  OptionTexts parts;
  for (const std::string& text : texts)
    for (const std::string& part : SplitText(text, ',')) parts.push_back(part);
  return parts;
}

void Option::SetFromCommandLine(const OptionTexts& texts) {
  const std::string said = is_operand_ ? name_ : "--" + name_;
  if (std::find(texts.begin(), texts.end(), "") != texts.end()) throw UsageError("{} is empty", said);
  Set(Split(texts), said);
  said_ = fmt::format("{} {}{}", said, JoinTexts(texts), unit_.empty() ? "" : " " + unit_);
}

void Option::SetFromFile(const OptionTexts& elements) {
  const std::string said = fmt::format("'{}'", Key());
  Set(elements, said);
  said_ = said;
  given_ = elements;  // as a command line would give them, for summaries
}

void Option::Set(const OptionTexts& texts, const std::string& said) {
  set_(texts, said);
  for (const std::string& text : range_ ? texts : OptionTexts{}) {
    const double number = OptionValue<double>::Parse(text, said);
    const auto [low, high] = *range_;
    if (!low_is_allowed_ && !(number > low)) throw UsageError("{} must be positive, not {}", said, text);
    const std::string range =
        std::isfinite(low) && std::isfinite(high) ? fmt::format(" (from {} to {})", low, high) : "";
    if (number < low) throw UsageError("{} must be at least {}, not {}{}", said, low, text, range);
    if (number > high) throw UsageError("{} must be at most {}, not {}{}", said, high, text, range);
  }
}

Option& OptionList::AddCustom(std::string name, std::string help, SetOption set, TellOption text) {
  return options_.emplace_back(std::move(name), std::move(help), std::move(set), std::move(text));
}

void OptionList::RunChecks() const {
  for (const auto& check : checks_) check(*this);
}

void OptionList::Apply() {
  for (Option& option : options_)
    if (!option.Given().empty()) option.SetFromCommandLine(option.Given());
  RunChecks();
}

OptionList OptionList::Without(const std::vector<std::string_view>& names) const {
  OptionList rest = *this;
  std::erase_if(rest.options_, [&](const Option& option) {
    return std::find(names.begin(), names.end(), option.Name()) != names.end();
  });
  return rest;
}

OptionList OptionList::WithUsual(const std::vector<std::string_view>& names) const {
  for (const std::string_view name : names) (*this)[name];
  OptionList same = *this;
  for (Option& option : same.options_)
    option.is_further_ = !option.is_operand_ && std::find(names.begin(), names.end(), option.Name()) == names.end();
  return same;
}

const Option* OptionList::Find(std::string_view name) const {
  const auto found = std::find_if(options_.begin(), options_.end(), [&](const Option& o) { return o.Name() == name; });
  return found == options_.end() ? nullptr : &*found;
}

const Option& OptionList::operator[](std::string_view name) const {
  if (const Option* option = Find(name)) return *option;
  throw std::out_of_range(fmt::format("no option '{}'", name));
}

bool OptionList::IsGiven(std::string_view name) const {
  const Option* option = Find(name);
  return option && option->IsGiven();
}

bool OptionList::IsAnyGiven() const {
  return std::any_of(options_.begin(), options_.end(), [](const Option& option) { return option.IsGiven(); });
}

void OptionList::ThrowNoSuchChoice(const std::string& text, const OptionTexts& known, const std::string& said) {
  throw UsageError("{} must be one of {}, not '{}'", said, fmt::join(known, ", "), text);
}

namespace {

OptionTexts TextsOf(YamlNode& node) {
  OptionTexts texts;
  if (node.IsList())
    for (const YamlNode& element : node.Elements()) texts.push_back(element.AsText());
  else if (node.IsMap())
    for (const auto& [name, value] : node.Pairs()) texts.push_back(name + "=" + value.AsText());
  else
    texts.push_back(node.AsText());
  return texts;
}

}  // namespace

void ReadOptions(YamlNode& node, OptionList& options, const ResolvePath& resolve) {
  for (Option& option : options.All()) {
    auto child = node.Child(option.Key());
    if (!child) continue;
    const OptionTexts texts = option.PathKind() == Option::Path::kNone ? TextsOf(*child) : resolve(*child, option);
    try {
      const bool is_list = child->IsList() || child->IsMap() || option.PathKind() != Option::Path::kNone;
      option.SetFromFile(is_list ? texts : option.Split(texts));
    } catch (const Error& error) {
      throw Fail("{}: {}", child->Where(), error.what());
    }
  }
  try {
    options.RunChecks();
  } catch (const Error& error) {
    throw Fail("{}: {}", node.Where(), error.what());
  }
}

}  // namespace lake
