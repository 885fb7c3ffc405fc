#include "xml.h"

#include <fmt/format.h>

#include <sstream>
#include <vector>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/provenance.h"

namespace lake::model {

std::string NumberText(double number) {
  return FormatNumber(number + 0.0);  // no -0
}

std::string TextOf(std::span<const double> numbers) {
  std::vector<std::string> texts;
  for (const double number : numbers) texts.push_back(NumberText(number));
  return fmt::format("{}", fmt::join(texts, " "));
}

pugi::xml_node Add(pugi::xml_node parent, const char* name, std::initializer_list<Attribute> attributes) {
  pugi::xml_node node = parent.append_child(name);
  for (const auto& [key, value] : attributes) node.append_attribute(key) = value.c_str();
  return node;
}

pugi::xml_node AddText(pugi::xml_node parent, const char* name, const std::string& text) {
  pugi::xml_node node = parent.append_child(name);
  node.text() = text.c_str();
  return node;
}

void AddComment(pugi::xml_node parent, const std::string& text) {
  parent.append_child(pugi::node_comment).set_value((" " + text + " ").c_str());
}

void WriteXml(const std::filesystem::path& path, const pugi::xml_document& document) {
  std::ostringstream text;
  document.save(text, "  ");
  WriteTextFile(path, text.str());
}

std::string MadeBy() {
  return "made by lake " + VersionAndCommit();
}

}  // namespace lake::model
