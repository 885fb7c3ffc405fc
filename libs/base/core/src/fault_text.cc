#include "lake/core/fault_text.h"

#include <fmt/format.h>

#include <new>
#include <string_view>
#include <system_error>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"

namespace lake {

std::string FaultText(const std::exception& fault) {
  const std::string what = fault.what();
  if (dynamic_cast<const Error*>(&fault) || dynamic_cast<const Interrupted*>(&fault) ||
      dynamic_cast<const std::system_error*>(&fault))
    return what;
  if (dynamic_cast<const std::bad_alloc*>(&fault)) return "not enough memory for this input";
  constexpr std::string_view kIn = " in function ";
  const std::size_t in = what.starts_with("OpenCV") ? what.rfind(kIn) : std::string::npos;
  const std::string where = in == std::string::npos ? what : "OpenCV," + what.substr(in + kIn.size() - 1);
  return fmt::format(
      "a library failed at this input ({}): is the input damaged, or of an unusual size? If it is neither, please "
      "report "
      "this together with the input",
      where.substr(0, where.find_last_not_of(" \n") + 1));
}

}  // namespace lake
