#include "lake/report/report.h"

namespace lake::report {
namespace {

// An option that was left at nothing says nothing.
bool IsUnset(const Json& value) {
  return value.empty() || value == "" || value == false;
}

std::string Text(const Json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

}  // namespace

report::Section ProvenanceSection(const Json& head) {
  Section section{"Provenance", {}};
  Table made{"", {{"What"}, {.heading = "Value", .code = true}}, {}};
  made.rows.push_back({"program", head.at("program").get<std::string>() + " " + head.at("version").get<std::string>()});
  made.rows.push_back({"command", head.at("command").get<std::string>()});
  for (const auto& [name, value] : head.at("options").items())
    if (!IsUnset(value)) made.rows.push_back({"option " + name, Text(value)});
  Table inputs{"Inputs", {{"File"}, {.heading = "SHA-256", .code = true}}, {}};
  for (const Json& input : head.at("inputs"))
    inputs.rows.push_back({input.at("path").get<std::string>(), input.at("sha256").get<std::string>()});
  section.blocks.push_back(std::move(made));
  if (!inputs.rows.empty()) section.blocks.push_back(std::move(inputs));
  return section;
}

}  // namespace lake::report
