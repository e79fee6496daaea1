// Loops over many numbers at once, for whatever vector instructions the machine has.
#pragma once

/// Before a function: it is compiled for each set of vector instructions, and the machine's best is called. Products
/// and sums are rounded one by one (-ffp-contract=off) and in the order written, so that all give the same bits.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define RAYCUBE_WIDE __attribute__((target_clones("default", "avx2", "arch=skylake-avx512")))
#else
#define RAYCUBE_WIDE
#endif
