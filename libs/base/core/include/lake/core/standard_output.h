// Errors of standard output.
#pragma once

namespace lake {

// Flushes stdout. Throws Error if any of it could not be written: a full disk, a closed output.
void FlushStdout();

}  // namespace lake
