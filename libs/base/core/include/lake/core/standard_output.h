// What is printed arrives, or is an error.
#pragma once

namespace lake {

// Hands on what was printed to stdout so far. Throws Error where any of it could not be written: a full disk, a closed
// output.
void FlushStdout();

}  // namespace lake
