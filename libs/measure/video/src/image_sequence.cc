#include "image_sequence.h"

#include <algorithm>
#include <charconv>
#include <vector>

#include "lake/core/error.h"

namespace lake::video {
namespace fs = std::filesystem;
namespace {

std::string DoublePercent(const std::string& text) {
  std::string doubled;
  for (const char c : text) doubled.append(c == '%' ? 2 : 1, c);
  return doubled;
}

}  // namespace

std::optional<ImageSequence> ImageSequence::Find(const fs::path& path) {
  const std::string pattern = path.filename().string();
  std::error_code error;
  if (pattern.find('%') == std::string::npos || fs::exists(path, error)) return std::nullopt;
  ImageSequence sequence;
  sequence.ParsePattern(pattern, path.string());
  sequence.folder_ = path.parent_path();
  const fs::path folder = sequence.folder_.empty() ? fs::path(".") : sequence.folder_;
  fs::directory_iterator entries(folder, error);
  if (error) throw Fail("{}: the folder cannot be read: {}", path.string(), error.message());
  std::vector<std::int64_t> numbers;
  for (const auto& entry : entries)
    if (const auto number = sequence.Number(entry.path().filename().string())) numbers.push_back(*number);
  if (numbers.empty()) throw Fail("{}: no file fits this pattern", path.string());
  std::sort(numbers.begin(), numbers.end());
  for (std::size_t i = 1; i < numbers.size(); ++i)
    if (numbers[i] != numbers[i - 1] + 1)
      throw Fail("{}: {} is missing, but {} is there; renumber the files without gaps", path.string(),
                 sequence.Name(numbers[i - 1] + 1), sequence.Name(numbers[i]));
  sequence.first_number_ = numbers.front();
  sequence.files_ = static_cast<std::int64_t>(numbers.size());
  return sequence;
}

void ImageSequence::ParsePattern(const std::string& pattern, const std::string& path) {
  const std::size_t percent = pattern.find('%'), d = pattern.find('d', percent);
  if (d == std::string::npos || pattern.find('%', percent + 1) != std::string::npos)
    throw Fail("{}: neither a file nor a pattern with one %d or %05d for the number", path);
  const std::string width = pattern.substr(percent + 1, d - percent - 1);
  const bool padded = width.size() == 2 && width[0] == '0' && width[1] >= '1' && width[1] <= '9';
  if (!padded && !width.empty())
    throw Fail("{}: neither a file nor a pattern with one %d or %05d for the number", path);
  digits_ = padded ? width[1] - '0' : 1;
  before_ = pattern.substr(0, percent);
  after_ = pattern.substr(d + 1);
}

std::string ImageSequence::Name(std::int64_t number) const {
  return fmt::format("{}{:0{}}{}", before_, number, digits_, after_);
}

std::optional<std::int64_t> ImageSequence::Number(const std::string& name) const {
  constexpr std::int64_t kMaxNumber = 1'000'000'000;  // libav counts in int
  if (name.size() <= before_.size() + after_.size()) return std::nullopt;
  std::int64_t number = -1;
  const char* end = name.data() + name.size() - after_.size();
  const auto [stop, error] = std::from_chars(name.data() + before_.size(), end, number);
  const bool fits = error == std::errc() && stop == end && number >= 0 && number <= kMaxNumber && Name(number) == name;
  return fits ? std::optional(number) : std::nullopt;
}

std::string ImageSequence::Url() const {
  const std::string folder = folder_.empty() ? "" : (folder_ / "").string();
  const std::string conversion = digits_ > 1 ? fmt::format("%0{}d", digits_) : "%d";
  return "file:" + DoublePercent(folder) + before_ + conversion + after_;
}

}  // namespace lake::video
