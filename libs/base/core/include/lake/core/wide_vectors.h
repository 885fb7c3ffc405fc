// LAKE_WIDE_VECTORS before a function compiles it twice, for every x86-64 processor and for those with AVX2, and the
// program takes what its processor has. Results are the same to the last bit: AVX2 alone brings no fused
// multiply-add, and sums of floating-point numbers keep their order. For loops over arrays that the compiler
// vectorises, in functions that call nothing.
#pragma once

// The sanitizers' own start-up comes after the loader has chosen; Clang 14 cannot choose for functions of one file.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define LAKE_WIDE_VECTORS __attribute__((target_clones("avx2", "default")))
#else
#define LAKE_WIDE_VECTORS
#endif
