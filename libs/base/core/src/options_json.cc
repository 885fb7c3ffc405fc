#include "lake/core/options_json.h"

namespace lake {

Json GivenOptionsJson(const OptionList& options) {
  Json json = Json::object();
  for (const Option& option : options.All()) {
    const OptionTexts texts = option.Split(option.Given());
    if (texts.empty()) continue;
    json[option.Name()] = option.IsRepeated() && texts.size() > 1 ? Json(texts) : Json(JoinTexts(texts));
  }
  return json;
}

Json OptionsJson(const OptionList& options) {
  Json json = Json::object();
  for (const Option& option : options.All()) json[option.Name()] = option.Text();
  json.update(GivenOptionsJson(options));
  return json;
}

}  // namespace lake
