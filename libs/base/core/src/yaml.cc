#include "lake/core/yaml.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <map>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/nearest_name.h"

namespace lake {

struct YamlNode::Impl {
  YAML::Node node;
  std::string file;
  std::string name = "the file";  // the key under which it stands
  std::vector<std::string> taken = {};
};

namespace {

std::string Place(const std::string& file, const YAML::Mark& mark) {
  return mark.is_null() ? file : fmt::format("{}:{}", file, mark.line + 1);
}

Json ScalarJson(const std::string& text) {
  const std::optional<double> number = ParseNumber(text);
  return number ? Json(*number) : Json(text);
}

Json JsonOf(const YAML::Node& node) {
  if (node.IsScalar()) return ScalarJson(node.Scalar());
  if (node.IsSequence()) {
    Json list = Json::array();
    for (const YAML::Node& element : node) list.push_back(JsonOf(element));
    return list;
  }
  if (!node.IsMap()) return nullptr;
  std::map<std::string, Json> sorted;
  for (const auto& pair : node) sorted[pair.first.as<std::string>()] = JsonOf(pair.second);
  Json map = Json::object();
  for (const auto& [key, value] : sorted) map[key] = value;
  return map;
}

// Looks at each value once, and again for each alias (*name) of it.
class Checker {
 public:
  explicit Checker(std::string file) : file_(std::move(file)) {}

  void Check(const YAML::Node& node) {
    if (++values_ > kMostValues)
      throw Fail("{}: more than {} values, those of aliases included", Place(file_, node.Mark()), kMostValues);
    if (++depth_ > kDeepest)
      throw Fail("{}: lists and maps stand more than {} deep in each other", Place(file_, node.Mark()), kDeepest);
    if (node.IsSequence())
      for (const YAML::Node& element : node) Check(element);
    if (node.IsMap()) CheckMap(node);
    --depth_;
  }

 private:
  static constexpr int kMostValues = 100'000, kDeepest = 100;  // far beyond any file of ours

  void CheckMap(const YAML::Node& map);

  std::string file_;
  int values_ = 0, depth_ = 0;
};

// A key that stands twice would be read once, whichever is meant.
void Checker::CheckMap(const YAML::Node& map) {
  std::map<std::string, int> lines;
  for (const auto& pair : map) {
    Check(pair.second);
    if (!pair.first.IsScalar()) throw Fail("{}: a key must be a single value", Place(file_, pair.first.Mark()));
    const auto [found, is_new] = lines.try_emplace(pair.first.Scalar(), pair.first.Mark().line + 1);
    if (!is_new)
      throw Fail("{}: key '{}' stands twice, first in line {}; keep one", Place(file_, pair.first.Mark()), found->first,
                 found->second);
  }
}

}  // namespace

YamlNode::YamlNode(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
YamlNode::~YamlNode() = default;
YamlNode::YamlNode(YamlNode&&) noexcept = default;
YamlNode& YamlNode::operator=(YamlNode&&) noexcept = default;

YamlNode YamlNode::ReadFile(const std::filesystem::path& path) {
  constexpr std::size_t kMostBytes = 1 << 20;
  return ReadText(ReadTextFile(path, kMostBytes), path);
}

YamlNode YamlNode::ReadText(const std::string& text, const std::filesystem::path& path) {
  try {
    const YAML::Node root = YAML::Load(text);
    Checker(path.string()).Check(root);
    return YamlNode(std::unique_ptr<Impl>(new Impl{.node = root, .file = path.string()}));
  } catch (const YAML::Exception& error) {
    throw Fail("{}: not YAML: {}", Place(path.string(), error.mark), error.msg);
  }
}

bool YamlNode::IsMap() const {
  return impl_->node.IsMap();
}
bool YamlNode::IsList() const {
  return impl_->node.IsSequence();
}

bool YamlNode::Has(std::string_view key) const {
  return IsMap() && std::as_const(impl_->node)[std::string(key)].IsDefined();
}

std::optional<YamlNode> YamlNode::Child(std::string_view key) {
  if (!impl_->node.IsNull() && !IsMap())
    throw Fail("{}: '{}' must have keys, such as {}, not a value or a list", Where(), impl_->name, key);
  if (std::ranges::find(impl_->taken, key) == impl_->taken.end()) impl_->taken.emplace_back(key);
  if (!Has(key)) return std::nullopt;
  return YamlNode(std::unique_ptr<Impl>(
      new Impl{.node = std::as_const(impl_->node)[std::string(key)], .file = impl_->file, .name = std::string(key)}));
}

std::optional<double> YamlNode::Number(std::string_view key) {
  const auto child = Child(key);
  return child ? std::optional(child->AsNumber()) : std::nullopt;
}

std::optional<std::string> YamlNode::Text(std::string_view key) {
  const auto child = Child(key);
  return child ? std::optional(child->AsText()) : std::nullopt;
}

std::optional<std::vector<double>> YamlNode::Numbers(std::string_view key, std::optional<std::size_t> count) {
  const auto child = Child(key);
  if (!child) return std::nullopt;
  std::vector<double> numbers;
  for (const YamlNode& element : child->Elements()) numbers.push_back(element.AsNumber());
  if (count && numbers.size() != *count)
    throw Fail("{}: '{}' must have {} numbers, not {}", child->Where(), key, *count, numbers.size());
  return numbers;
}

std::vector<YamlNode> YamlNode::Elements() const {
  if (!IsList()) throw Fail("{}: a list was expected", Where());
  std::vector<YamlNode> elements;
  for (const YAML::Node& element : impl_->node)
    elements.push_back(
        YamlNode(std::unique_ptr<Impl>(new Impl{.node = element, .file = impl_->file, .name = impl_->name})));
  return elements;
}

std::vector<std::pair<std::string, YamlNode>> YamlNode::Pairs() {
  if (!IsMap()) throw Fail("{}: a map was expected", Where());
  std::vector<std::pair<std::string, YamlNode>> pairs;
  for (const auto& pair : impl_->node) {
    const std::string key = pair.first.as<std::string>();
    impl_->taken.push_back(key);
    pairs.emplace_back(
        key, YamlNode(std::unique_ptr<Impl>(new Impl{.node = pair.second, .file = impl_->file, .name = key})));
  }
  return pairs;
}

double YamlNode::AsNumber() const {
  const std::optional<double> value = ParseNumber(AsText());
  if (!value) throw Fail("{}: '{}' is not a finite number", Where(), AsText());
  return std::fpclassify(*value) == FP_SUBNORMAL ? 0 : *value;  // Ipopt does not come to an end with 1e-320
}

std::string YamlNode::AsText() const {
  if (!impl_->node.IsScalar()) throw Fail("{}: a single value was expected", Where());
  return impl_->node.Scalar();
}

Json YamlNode::ToJson() const {
  return JsonOf(impl_->node);
}

void YamlNode::Finish() const {
  if (!IsMap()) return;
  for (const auto& pair : impl_->node) {
    const std::string key = pair.first.as<std::string>();
    if (std::find(impl_->taken.begin(), impl_->taken.end(), key) == impl_->taken.end())
      throw Fail("{}: unknown key '{}'{}; known here: {}", Place(impl_->file, pair.first.Mark()), key,
                 DidYouMean(key, impl_->taken), fmt::join(impl_->taken, ", "));
  }
}

std::string YamlNode::Where() const {
  return Place(impl_->file, impl_->node.Mark());
}

const YamlKind* KindByKeys(const std::function<bool(std::string_view key)>& has) {
  static constexpr YamlKind kKinds[] = {
      {"camera_matrix", "camera", "--camera reads it"},
      {"human", "study", "lake run reads it"},
      {"links", "design", "lake simulate, lake stroke, lake export and lake review read it"},
      {"bounds", "problem", "lake optimize --problem reads it"},
      {"margins", "problem", "lake optimize --problem reads it"}};
  const auto* kind = std::ranges::find_if(kKinds, has, &YamlKind::key);
  return kind == std::end(kKinds) ? nullptr : kind;
}

void ExpectKind(const YamlNode& file, std::string_view expected) {
  const YamlKind* kind = KindByKeys([&](std::string_view key) { return file.Has(key); });
  if (kind && kind->name != expected)
    throw Fail("{}: is a {}, not a {}; {}", file.Where(), kind->name, expected, kind->readers);
}

}  // namespace lake
