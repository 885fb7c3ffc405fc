// The bytes of a C3D file: words of three kinds of processor, the parameter section, and what it and the header say of
// the data. Not part of the interface.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace lake::exchange {

// Reads with bounds: throws Error naming the file beyond its end.
class C3dBytes {
 public:
  // Throws Error if it is no C3D file or of an unknown processor.
  C3dBytes(std::string bytes, std::string path);

  std::size_t Size() const { return bytes_.size(); }
  const std::string& Path() const { return path_; }
  std::size_t ParameterOffset() const { return parameter_offset_; }

  std::uint8_t Unsigned8(std::size_t offset) const;
  int Signed8(std::size_t offset) const {
    const int value = Unsigned8(offset);
    return value < 128 ? value : value - 256;
  }
  std::uint16_t Unsigned16(std::size_t offset) const;
  std::int16_t Signed16(std::size_t offset) const { return static_cast<std::int16_t>(Unsigned16(offset)); }
  double Float(std::size_t offset) const;
  std::string Text(std::size_t offset, std::size_t length) const;
  // Up to a zero byte, without the blanks round it.
  std::string TrimmedText(std::size_t offset, std::size_t length) const;

 private:
  enum Processor { kIntel = 84, kDec = 85, kMips = 86 };
  void Require(std::size_t offset, std::size_t length) const;

  std::string bytes_, path_;
  std::size_t parameter_offset_ = 512;
  Processor processor_ = kIntel;
};

// All parameters, by "GROUP:NAME" in capitals. An array holds 255 values in one dimension; a longer list goes on in
// NAME2, NAME3, … (user guide, POINT:LABELS2), and is read and written as one here. A parameter that is absent, of
// another type or beyond the file's end has no values.
class C3dParameters {
 public:
  explicit C3dParameters(const C3dBytes& bytes);

  std::optional<double> Number(const std::string& name) const;
  std::optional<std::size_t> Count(const std::string& name) const;  // a whole number that is not negative
  std::vector<double> Numbers(const std::string& name) const;
  std::vector<std::string> Texts(const std::string& name) const;  // trimmed

  // Of a section that cannot be read to its end.
  const std::vector<std::string>& Warnings() const { return warnings_; }

 private:
  struct Value {
    int type = 0;  // −1 text, 1 byte, 2 integer, 4 float
    std::vector<std::size_t> dimensions;
    std::size_t offset = 0;
  };
  std::vector<const Value*> PartsOf(const std::string& name) const;  // NAME, NAME2, NAME3, …
  // How many elements of so many bytes it has; 0 where they do not lie within the file.
  std::size_t ElementsOf(const Value& value, std::size_t first_dimension, std::size_t bytes) const;

  const C3dBytes& bytes_;
  std::map<std::string, Value> values_;
  std::vector<std::string> warnings_;
};

// What the header and the parameters say about the points.
struct C3dLayout {
  std::size_t points = 0, frames = 0, first_frame = 0;
  std::size_t analog_per_frame = 0;  // samples of all channels
  std::size_t data_offset = 0;       // bytes
  double scale = -1;                 // < 0: floats
  double rate_hz = 0;
  double mm_per_unit = 1;
  char up_axis = 'z';
  std::vector<std::string> labels;  // of the points
  std::vector<std::string> warnings;

  bool IsFloat() const { return scale < 0; }
  std::size_t WordBytes() const { return IsFloat() ? 4 : 2; }
  std::size_t FrameBytes() const { return WordBytes() * (4 * points + analog_per_frame); }
};

// A 16-bit word that was read with a sign, where it has none.
inline double Unsigned(double word) {
  return word < 0 ? word + 65536 : word;
}

// The file states its sizes in its header and in its parameters. Where these differ, those hold with which the frames
// end in the file's last block; among several of them what most places state. Of a file that is cut off the frames that
// are there. Throws Error where that does not decide, and for a file that holds neither points nor analogue channels.
C3dLayout ReadLayout(const C3dBytes& bytes, const C3dParameters& parameters);

// Little-endian output.
class C3dBuffer {
 public:
  C3dBuffer& Byte(int value);
  C3dBuffer& Word(std::size_t value);
  C3dBuffer& Float(float value);
  C3dBuffer& Append(const std::string& bytes);
  C3dBuffer& PadTo(std::size_t size);
  std::size_t Size() const { return bytes_.size(); }
  const std::string& Bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class C3dParameterWriter {
 public:
  C3dParameterWriter();
  void Group(int id, const std::string& name);
  enum NumberType { kWord = 2, kFloat = 4 };
  void Number(int group, const std::string& name, NumberType type, double value) {
    Numbers(group, name, type, {value});
  }
  // In arrays of `of_each`.
  void Numbers(int group, const std::string& name, NumberType type, const std::vector<double>& values,
               std::size_t of_each = 1);
  void Texts(int group, const std::string& name, const std::vector<std::string>& texts);

  // Ends the section with the parameter that says in which block the data begin, behind the section itself. Whole
  // blocks.
  std::string Finish(int group, const std::string& data_start_name);

 private:
  void Entry(int id, const std::string& name, const std::string& content);

  C3dBuffer section_;
};

}  // namespace lake::exchange
