// XML of models: numbers as text, files written whole.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <initializer_list>
#include <pugixml.hpp>
#include <span>
#include <string>

namespace lake::model {

// "1 2.5 3", each number read back as the same double.
std::string TextOf(std::span<const double> numbers);
inline std::string TextOf(const Eigen::Vector3d& numbers) {
  return TextOf(std::span(numbers.data(), 3));
}
inline std::string TextOf(std::initializer_list<double> numbers) {
  return TextOf(std::span(numbers.begin(), numbers.size()));
}

// A child with attributes, in order.
struct Attribute {
  const char* name;
  std::string value;
};
pugi::xml_node Add(pugi::xml_node parent, const char* name, std::initializer_list<Attribute> attributes = {});
// A child that holds a text.
pugi::xml_node AddText(pugi::xml_node parent, const char* name, const std::string& text);
void AddComment(pugi::xml_node parent, const std::string& text);

// Throws Error if it cannot be written.
void WriteXml(const std::filesystem::path& path, const pugi::xml_document& document);

// What each model says of itself.
std::string MadeBy();

std::string NumberText(double number);

}  // namespace lake::model
