/** For functions with plain loops that the compiler turns into vector code. */
#pragma once

/**
 * Compiled twice; the processor chooses. Neither version may fuse multiplications with additions (-ffp-contract=off),
 * so both give the same pixels. The thread sanitizer cannot be there yet when the choice is made.
 */
#if defined(__x86_64__) && !defined(__SANITIZE_THREAD__)
#define ML2SIM_VECTORIZED __attribute__((target_clones("avx2", "default")))
#else
#define ML2SIM_VECTORIZED
#endif
