// Who moves, as far as norms and tables differ by it.
#pragma once

namespace lake::motion {

enum class Sex { kMale, kFemale };

}  // namespace lake::motion
