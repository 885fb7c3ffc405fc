// The page's files, compiled in.
#pragma once

#include <string_view>

namespace lake::review {

std::string_view PageHtml();
std::string_view PageStyle();
std::string_view PageScript();
std::string_view ChartLicence();

}  // namespace lake::review
