// Reading YAML strictly: every error names file and line, and an unknown key is an error.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lake/core/json.h"

namespace lake {

// A node of a YAML file. Take what is known from it, then call Finish(): it throws for keys that were not taken.
class YamlNode {
 public:
  // Throws Error if the file cannot be read, is not YAML, is larger than 1 MiB, holds more than 100 000 values (those
  // of aliases counted each time) or more than 100 levels, or a key stands twice in a map.
  static YamlNode ReadFile(const std::filesystem::path& path);
  // What was read from there; throws likewise.
  static YamlNode ReadText(const std::string& text, const std::filesystem::path& path);

  ~YamlNode();
  YamlNode(YamlNode&&) noexcept;
  YamlNode& operator=(YamlNode&&) noexcept;

  bool Has(std::string_view key) const;

  // A child of a map; nullopt when the key is absent.
  std::optional<YamlNode> Child(std::string_view key);

  // A scalar child; nullopt when the key is absent. Throws Error if it has another type or is not finite.
  std::optional<double> Number(std::string_view key);
  std::optional<std::string> Text(std::string_view key);

  // A list of numbers, of exactly `count` if given.
  std::optional<std::vector<double>> Numbers(std::string_view key, std::optional<std::size_t> count = {});

  // The elements of a list, this node being one; the pairs of a map, this node being one. Throws Error if it is not.
  std::vector<YamlNode> Elements() const;
  std::vector<std::pair<std::string, YamlNode>> Pairs();

  bool IsMap() const;
  bool IsList() const;

  // This node itself as a scalar; a number nearer to 0 than 2.3e-308 is 0.
  double AsNumber() const;
  std::string AsText() const;

  // All that stands here and below, whatever was taken: maps by their sorted keys, scalars as numbers where they are
  // finite numbers, else as text. Two files that say the same give the same, whatever their order, blanks and comments.
  Json ToJson() const;

  // Throws Error naming the first key that was not taken, its line, and the keys that are known here.
  void Finish() const;

  // "file:line", for messages.
  std::string Where() const;

 private:
  struct Impl;
  explicit YamlNode(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// A kind of YAML file that lake reads, by a key of its own.
struct YamlKind {
  std::string_view key, name, readers;
};
// "camera", "study", "design" or "problem" (nullptr: none of them) by the keys that a file has.
const YamlKind* KindByKeys(const std::function<bool(std::string_view key)>& has);

// Throws Error if the file is not of the kind that is expected but of another: what it is, and what reads it.
void ExpectKind(const YamlNode& file, std::string_view expected);

}  // namespace lake
