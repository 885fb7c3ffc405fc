// Linked into all programs of the preset `coverage`: a worker process, which ends by _exit(), writes the lines that it
// ran too.
extern "C" {
void __gcov_dump();
[[noreturn]] void __real__exit(int status);

[[noreturn]] void __wrap__exit(int status) {
  __gcov_dump();
  __real__exit(status);
}
}
