#include "c3d_bytes.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <functional>
#include <numeric>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/utf8.h"

namespace lake::exchange {
namespace {

// Of a list that does not fit into one parameter: NAME, NAME2, NAME3, …
std::string PartName(const std::string& name, std::size_t part) {
  return part == 1 ? name : fmt::format("{}{}", name, part);
}

// Calls with each part's name, its first value and the one behind its last.
void ForEachPart(const std::string& name, std::size_t count,
                 const std::function<void(const std::string&, std::size_t, std::size_t)>& call) {
  constexpr std::size_t kMost = 255;  // a dimension is a byte
  for (std::size_t begin = 0, part = 1; begin < count; begin += kMost, ++part)
    call(PartName(name, part), begin, std::min(count, begin + kMost));
}

}  // namespace

C3dBytes::C3dBytes(std::string bytes, std::string path) : bytes_(std::move(bytes)), path_(std::move(path)) {
  constexpr char kKey = 0x50;
  if (bytes_.size() > 1 && bytes_[1] != kKey)  // some of Vicon's have zeros before the header
    bytes_.erase(0, std::min(bytes_.find_first_not_of('\0'), bytes_.size()));
  if (bytes_.size() < 2 || bytes_[1] != kKey) throw Fail("{}: not a C3D file, whose second byte is 80", path_);
  constexpr std::size_t kHeads = 1024;  // header and parameters
  Require(0, kHeads);
  const std::size_t block = Unsigned8(0);
  parameter_offset_ = block > 0 ? 512 * (block - 1) : 512;
  const int processor = Unsigned8(parameter_offset_ + 3);
  const auto has_rate = [&](Processor kind) {
    processor_ = kind;
    return Float(20) >= 1 && Float(20) <= 1e5;
  };
  if (processor >= kIntel && processor <= kMips)
    processor_ = static_cast<Processor>(processor);
  else if (!has_rate(kIntel) && !has_rate(kDec) && !has_rate(kMips))
    throw Fail("{}: not a C3D file: the processor type {} is not 84, 85 or 86", path_, processor);
}

void C3dBytes::Require(std::size_t offset, std::size_t length) const {
  if (offset > bytes_.size() || length > bytes_.size() - offset)
    throw Fail("{}: ends before byte {}: is the file cut off?", path_, offset + length);
}

std::uint8_t C3dBytes::Unsigned8(std::size_t offset) const {
  Require(offset, 1);
  return static_cast<std::uint8_t>(bytes_[offset]);
}

std::uint16_t C3dBytes::Unsigned16(std::size_t offset) const {
  Require(offset, 2);
  const unsigned first = Unsigned8(offset), second = Unsigned8(offset + 1);
  return static_cast<std::uint16_t>(processor_ == kMips ? first << 8 | second : second << 8 | first);
}

double C3dBytes::Float(std::size_t offset) const {
  Require(offset, 4);
  const std::uint32_t first = Unsigned16(offset), second = Unsigned16(offset + 2);
  switch (processor_) {
    case kIntel:
      return std::bit_cast<float>(second << 16 | first);
    case kMips:
      return std::bit_cast<float>(first << 16 | second);
    case kDec:
      return std::bit_cast<float>(first << 16 | second) / 4;  // words swapped, exponent larger by two
  }
  return 0;
}

std::string C3dBytes::Text(std::size_t offset, std::size_t length) const {
  Require(offset, length);
  return bytes_.substr(offset, length);
}

std::string C3dBytes::TrimmedText(std::size_t offset, std::size_t length) const {
  const std::string text = Text(offset, length);
  return std::string(Trim(std::string_view(text.c_str())));
}

// Each entry: length of the name (negative: locked), id of the group (negative: this is a group), name, offset to the
// next entry; then for a parameter type, dimensions and values.
C3dParameters::C3dParameters(const C3dBytes& bytes) : bytes_(bytes) {
  std::map<int, std::string> groups;
  std::vector<std::pair<int, std::pair<std::string, Value>>> parameters;
  // Up to the data, as a stated length may be too short; an entry beyond both is none.
  const std::size_t begin = bytes.ParameterOffset(), blocks = bytes.Unsigned8(begin + 2), data = bytes.Unsigned16(16);
  const std::size_t stated = std::max(begin + 512 * blocks, 512 * (std::max<std::size_t>(data, 1) - 1)),
                    end = stated > begin ? stated : bytes.Size();
  for (std::size_t at = begin + 4; at + 1 < end;) try {
      const auto length = static_cast<std::size_t>(std::abs(bytes.Signed8(at)));
      const int id = bytes.Signed8(at + 1);
      if (length == 0 || id == 0) break;
      std::string name = bytes.TrimmedText(at + 2, length);
      std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
      const std::size_t after = at + 2 + length,
                        next = bytes.Unsigned16(after) > 0 ? after + bytes.Unsigned16(after) : 0;
      if (id < 0) {
        groups[-id] = name;
      } else {
        Value value;
        value.type = bytes.Signed8(after + 2);
        const std::size_t dimensions = bytes.Unsigned8(after + 3);
        if (dimensions > 7)
          throw Fail("{}: parameter {} has {} dimensions, more than 7", bytes.Path(), name, dimensions);
        for (std::size_t d = 0; d < dimensions; ++d) value.dimensions.push_back(bytes.Unsigned8(after + 4 + d));
        value.offset = after + 4 + dimensions;
        parameters.push_back({id, {name, value}});
      }
      if (next == 0) break;
      at = next;
    } catch (const Error& error) {
      warnings_.push_back(fmt::format("{}; the parameters from there on are left out", error.what()));
      break;
    }
  for (const auto& [id, parameter] : parameters)
    if (const int type = parameter.second.type; type == -1 || type == 1 || type == 2 || type == 4)
      values_.emplace(groups[id] + ":" + parameter.first, parameter.second);
}

std::size_t C3dParameters::ElementsOf(const Value& value, std::size_t first_dimension, std::size_t bytes) const {
  std::size_t count = 1;
  for (std::size_t d = first_dimension; d < value.dimensions.size(); ++d) count *= value.dimensions[d];
  return value.offset > bytes_.Size() || count * bytes > bytes_.Size() - value.offset ? 0 : count;
}

std::vector<const C3dParameters::Value*> C3dParameters::PartsOf(const std::string& name) const {
  std::vector<const Value*> parts;
  for (auto found = values_.find(name); found != values_.end(); found = values_.find(PartName(name, parts.size() + 1)))
    parts.push_back(&found->second);
  return parts;
}

std::vector<double> C3dParameters::Numbers(const std::string& name) const {
  std::vector<double> numbers;
  for (const Value* value : PartsOf(name)) {
    const auto bytes = static_cast<std::size_t>(std::max(value->type, 0));
    const std::size_t end = value->offset + bytes * ElementsOf(*value, 0, bytes);
    for (std::size_t at = value->offset; at < end; at += bytes)
      numbers.push_back(bytes == 1 ? bytes_.Unsigned8(at) : bytes == 2 ? bytes_.Signed16(at) : bytes_.Float(at));
  }
  return numbers;
}

std::optional<double> C3dParameters::Number(const std::string& name) const {
  const std::vector<double> numbers = Numbers(name);
  if (numbers.empty()) return std::nullopt;
  // Counts beyond 32 767 are stored in the sign bit.
  return values_.at(name).type == 2 && numbers[0] < 0 ? numbers[0] + 65536 : numbers[0];
}

std::optional<std::size_t> C3dParameters::Count(const std::string& name) const {
  constexpr double kMost = 4294967295;  // of two words
  const double value = Number(name).value_or(-1);
  if (!(value >= 0 && value <= kMost) || value != std::floor(value)) return std::nullopt;
  return static_cast<std::size_t>(value);
}

std::vector<std::string> C3dParameters::Texts(const std::string& name) const {
  std::vector<std::string> texts;
  for (const Value* value : PartsOf(name)) {
    const std::size_t length = value->dimensions.empty() ? 1 : value->dimensions[0];
    if (value->type != -1 || length == 0) continue;
    const std::size_t count = ElementsOf(*value, 1, length);
    for (std::size_t i = 0; i < count; ++i)
      texts.push_back(Utf8FromText(bytes_.TrimmedText(value->offset + i * length, length)));
  }
  return texts;
}

C3dBuffer& C3dBuffer::Byte(int value) {
  bytes_ += static_cast<char>(value);
  return *this;
}

C3dBuffer& C3dBuffer::Word(std::size_t value) {
  return Byte(static_cast<int>(value & 0xFF)).Byte(static_cast<int>(value >> 8 & 0xFF));
}

C3dBuffer& C3dBuffer::Float(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return Word(bits & 0xFFFF).Word(bits >> 16);
}

C3dBuffer& C3dBuffer::Append(const std::string& bytes) {
  bytes_ += bytes;
  return *this;
}

C3dBuffer& C3dBuffer::PadTo(std::size_t size) {
  bytes_.resize(size, '\0');
  return *this;
}

C3dParameterWriter::C3dParameterWriter() {
  section_.Byte(1).Byte(0x50).Byte(0).Byte(84);
}

void C3dParameterWriter::Entry(int id, const std::string& name, const std::string& content) {
  section_.Byte(static_cast<int>(name.size())).Byte(id).Append(name).Word(2 + content.size()).Append(content);
}

void C3dParameterWriter::Group(int id, const std::string& name) {
  Entry(-id, name, std::string(1, '\0'));
}

void C3dParameterWriter::Numbers(int group, const std::string& name, NumberType type, const std::vector<double>& values,
                                 std::size_t of_each) {
  ForEachPart(name, values.size() / of_each, [&](const std::string& part, std::size_t begin, std::size_t end) {
    std::vector<std::size_t> dimensions;
    if (of_each > 1) dimensions.push_back(of_each);
    if (values.size() > 1) dimensions.push_back(end - begin);
    C3dBuffer content;
    content.Byte(type).Byte(static_cast<int>(dimensions.size()));
    for (const std::size_t dimension : dimensions) content.Byte(static_cast<int>(dimension));
    for (std::size_t i = begin * of_each; i < end * of_each; ++i)
      type == kFloat ? content.Float(static_cast<float>(values[i])) : content.Word(static_cast<std::size_t>(values[i]));
    Entry(group, part, content.Byte(0).Bytes());
  });
}

void C3dParameterWriter::Texts(int group, const std::string& name, const std::vector<std::string>& texts) {
  std::size_t length = 1;
  for (const std::string& text : texts) length = std::max(length, text.size());
  if (length > 127) throw Fail("C3D: the name '{}…' is longer than 127 bytes", texts.front().substr(0, 20));
  ForEachPart(name, texts.size(), [&](const std::string& part, std::size_t begin, std::size_t end) {
    C3dBuffer content;
    content.Byte(-1).Byte(2).Byte(static_cast<int>(length)).Byte(static_cast<int>(end - begin));
    for (std::size_t i = begin; i < end; ++i) content.Append(texts[i] + std::string(length - texts[i].size(), ' '));
    Entry(group, part, content.Byte(0).Bytes());
  });
}

std::string C3dParameterWriter::Finish(int group, const std::string& data_start_name) {
  constexpr std::size_t kEntryAndEnd = 64;  // bytes that the last entry and the end mark take at most
  const std::size_t blocks = (section_.Size() + kEntryAndEnd + 511) / 512;
  constexpr std::size_t kMostBlocks = 255;
  if (blocks > kMostBlocks)
    throw Fail("C3D: names and events take {} kB, and there is room for {} kB", blocks / 2, kMostBlocks / 2);
  Number(group, data_start_name, kWord, static_cast<double>(2 + blocks));
  section_.Word(0).PadTo(blocks * 512);
  std::string bytes = section_.Bytes();
  bytes[2] = static_cast<char>(blocks);
  return bytes;
}

}  // namespace lake::exchange
