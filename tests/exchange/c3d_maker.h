// C3D files made by the format's user guide (c3d.org), so that what they hold is known independently of the reader:
// floats and integers, of every processor, and with statements that contradict one another.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace lake {

struct C3dEntry {
  std::string group, name;
  int type = 4;  // −1 text, 1 byte, 2 integer, 4 float
  std::vector<int> dimensions;
  std::vector<double> numbers;
  std::vector<std::string> texts;  // of dimensions[0] bytes each
};

// What is stored for each point and frame is `Stored`, times the scale; missing where IsMissing.
struct C3dMaker {
  int processor = 84;
  bool is_float = true;
  int points = 3, frames = 40, channels = 0, samples = 4, first = 1;
  double scale = 0.125, rate_hz = 100;  // exact in single precision
  double missing_residual = -1;
  std::vector<C3dEntry> entries;
  // Of the header, where it is not as the data are.
  std::optional<double> h_points, h_analog, h_first, h_last, h_scale, h_block, h_samples, h_rate;
  std::optional<int> section_blocks, stated_processor;
  int parameter_block = 2, zeros_before = 0, behind = 0, spare_blocks = 0;
  bool is_padded = true, groups_last = false;
  int name_sign = 1;  // −1: locked
  std::vector<std::string> labels, read_labels;

  static double Stored(int point, int frame, int axis) {
    const int values[] = {100 * point + frame % 1000, point - 2 * (frame % 500), 500 + frame % 7};
    return values[axis];
  }
  static bool IsMissing(int point, int frame) { return (point + frame) % 7 == 6; }
  int Analog() const { return channels * samples; }
  // What is stored of a channel, in each sample of a frame.
  std::function<double(int frame, int channel)> analog = [](int, int channel) { return 17 + channel; };

  void Add(const std::string& group, const std::string& name, int type, std::vector<double> numbers) {
    std::vector<int> dimensions;
    if (numbers.size() > 1) dimensions.push_back(static_cast<int>(numbers.size()));
    entries.push_back({group, name, type, dimensions, std::move(numbers), {}});
  }
  void AddTexts(const std::string& group, const std::string& name, const std::vector<std::string>& texts, char pad) {
    std::size_t length = 1;
    for (const std::string& text : texts) length = std::max(length, text.size());
    std::vector<std::string> padded;
    for (const std::string& text : texts) padded.push_back(text + std::string(length - text.size(), pad));
    entries.push_back({group, name, -1, {static_cast<int>(length), static_cast<int>(texts.size())}, {}, padded});
  }
  C3dEntry* Find(const std::string& name) {
    for (C3dEntry& entry : entries)
      if (entry.group + ":" + entry.name == name) return &entry;
    throw std::runtime_error(name);
  }
  void Remove(const std::string& name) {
    std::erase_if(entries, [&](const C3dEntry& entry) { return entry.group + ":" + entry.name == name; });
  }
  void Fill() {
    Add("POINT", "USED", 2, {static_cast<double>(points)});
    Add("POINT", "FRAMES", 2, {static_cast<double>(std::min(frames, 65535))});
    Add("POINT", "DATA_START", 2, {0});  // set when the section is written
    Add("POINT", "SCALE", 4, {is_float ? -scale : scale});
    Add("POINT", "RATE", 4, {rate_hz});
    AddTexts("POINT", "UNITS", {"mm"}, ' ');
    if (labels.empty())
      for (int p = 0; p < points; ++p) labels.push_back("M" + std::to_string(p + 1));
    read_labels = labels;
    AddTexts("POINT", "LABELS", {labels.begin(), labels.begin() + std::min(points, 255)}, ' ');
    if (points > 255) AddTexts("POINT", "LABELS2", {labels.begin() + 255, labels.end()}, ' ');
    Add("ANALOG", "USED", 2, {static_cast<double>(channels)});
    if (channels > 0) Add("ANALOG", "RATE", 4, {rate_hz * samples});
  }

  std::string Word(double value) const {
    const auto bits = static_cast<std::uint16_t>(static_cast<std::int64_t>(value));
    const char low = static_cast<char>(bits & 0xFF), high = static_cast<char>(bits >> 8);
    return processor == 86 ? std::string{high, low} : std::string{low, high};
  }
  // IEEE in either order of bytes; DEC's exponent is larger by two, and its high word stands first.
  std::string Float(double value) const {
    const auto stored = static_cast<float>(processor == 85 ? 4 * value : value);
    char bytes[4];
    std::memcpy(bytes, &stored, 4);
    if (processor == 86) return {bytes[3], bytes[2], bytes[1], bytes[0]};
    if (processor == 85) return {bytes[2], bytes[3], bytes[0], bytes[1]};
    return {bytes, 4};
  }
  std::string Named(const std::string& name, int id, const std::string& content) const {
    const char description[] = "what it is";
    const std::string rest = content + static_cast<char>(sizeof description - 1) + description;
    return std::string{static_cast<char>(name_sign * static_cast<int>(name.size())), static_cast<char>(id)} + name +
           Word(2 + static_cast<double>(rest.size())) + rest;
  }
  std::string Section(int data_block) const {
    std::vector<std::string> names;
    std::string groups, parameters;
    for (const C3dEntry& entry : entries) {
      const auto found = std::find(names.begin(), names.end(), entry.group);
      const int id = 3 + 5 * static_cast<int>(found - names.begin());
      if (found == names.end()) {
        names.push_back(entry.group);
        groups += Named(entry.group, -id, "");
      }
      std::string content{static_cast<char>(entry.type), static_cast<char>(entry.dimensions.size())};
      for (const int dimension : entry.dimensions) content += static_cast<char>(dimension);
      for (double number : entry.numbers) {
        if (entry.name == "DATA_START" && number == 0) number = data_block;
        content += entry.type == 4   ? Float(number)
                   : entry.type == 2 ? Word(number)
                                     : std::string(1, static_cast<char>(number));
      }
      for (const std::string& text : entry.texts) content += text;
      parameters += Named(entry.name, id, content);
    }
    return groups_last ? parameters + groups : groups + parameters;
  }
  std::string Bytes() const {
    const auto length = static_cast<int>(Section(0).size()) + 6, blocks = (length + 511) / 512;
    const int data_block = parameter_block + blocks + spare_blocks;
    std::string section = std::string{1, 0x50, static_cast<char>(section_blocks.value_or(blocks)),
                                      static_cast<char>(stated_processor.value_or(processor))} +
                          Section(data_block);
    section.resize(static_cast<std::size_t>(512 * (blocks + spare_blocks)), '\0');
    const double last = std::min(first + frames - 1, 65535);
    std::string header = std::string{static_cast<char>(parameter_block), 0x50} + Word(h_points.value_or(points)) +
                         Word(h_analog.value_or(Analog())) + Word(h_first.value_or(first)) +
                         Word(h_last.value_or(last)) + Word(10) + Float(h_scale.value_or(is_float ? -scale : scale)) +
                         Word(h_block.value_or(data_block)) + Word(h_samples.value_or(channels > 0 ? samples : 0)) +
                         Float(h_rate.value_or(rate_hz));
    header.resize(static_cast<std::size_t>(512 * (parameter_block - 1)), '\0');
    std::string data;
    const auto put = [&](double stored, double factor) { data += is_float ? Float(stored * factor) : Word(stored); };
    for (int f = 0; f < frames; ++f) {
      for (int p = 0; p < points; ++p) {
        for (int axis = 0; axis < 3; ++axis) put(Stored(p, f, axis), scale);
        put(IsMissing(p, f) ? missing_residual : 3, 1);
      }
      for (int a = 0; a < Analog(); ++a) put(analog(f, a % channels), 1);
    }
    if (is_padded) data.resize((data.size() + 511) / 512 * 512, '\0');
    return std::string(static_cast<std::size_t>(zeros_before), '\0') + header + section + data +
           std::string(static_cast<std::size_t>(behind), 'x');
  }
};

}  // namespace lake
