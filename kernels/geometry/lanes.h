/* Lane masks: an int16 of 0 / -1 becomes a 16-bit word, bit i = lane i. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_LANES_H
#define RAYCUBE_KERNELS_GEOMETRY_LANES_H

/* Rounding unit of a float. */
#define RC_ULP 5.9604644775390625e-8f

#ifdef __has_builtin
#if defined(__AVX512DQ__) && __has_builtin(__builtin_ia32_cvtd2mask512)
#define RC_HAS_MASK512 1
#endif
#if defined(__AVX512DQ__) && defined(__AVX512VL__) && __has_builtin(__builtin_ia32_cvtd2mask256)
#define RC_HAS_MASK256 1
#endif
#if defined(__AVX512F__) && __has_builtin(__builtin_ia32_compresssf512_mask)
#define RC_HAS_PACK512 1
#endif
#if defined(__AVX512F__) && defined(__AVX512VL__) && __has_builtin(__builtin_ia32_compresssi256_mask)
#define RC_HAS_PACK256 1
#endif
#if defined(__AVX512F__) && __has_builtin(__builtin_ia32_permvarsf512)
#define RC_HAS_PERMUTE512 1
#endif
#if defined(__AVX512F__) && __has_builtin(__builtin_ia32_gathersiv16sf)
#define RC_HAS_GATHER 1
#define RC_HAS_GATHER512 1
#endif
/* What processors without AVX-512 have of it. */
#if defined(__AVX__) && __has_builtin(__builtin_ia32_movmskps256)
#define RC_HAS_SIGNS256 1
#endif
#if defined(__AVX2__) && __has_builtin(__builtin_ia32_permvarsf256) && __has_builtin(__builtin_ia32_permvarsi256)
#define RC_HAS_PERMUTE256 1
#if defined(__BMI2__) && __has_builtin(__builtin_ia32_pdep_di) && __has_builtin(__builtin_ia32_pext_di)
#define RC_HAS_CHOSEN256 1
#endif
#endif
#if defined(__AVX2__) && !defined(RC_HAS_GATHER512) && __has_builtin(__builtin_ia32_gatherd_ps256)
#define RC_HAS_GATHER 1
#endif
#endif

static inline uint rc_mask8(int8 m) {
#ifdef RC_HAS_MASK256
  return (uint)(uchar)__builtin_ia32_cvtd2mask256(m);
#elif defined(RC_HAS_SIGNS256)
  return (uint)__builtin_ia32_movmskps256(as_float8(m));
#else
  const int8 w = m & (int8)(1, 2, 4, 8, 16, 32, 64, 128);
  const int4 h = w.lo | w.hi;
  const int2 q = h.lo | h.hi;
  return (uint)(q.x | q.y);
#endif
}

static inline uint rc_mask16(int16 m) {
#ifdef RC_HAS_MASK512
  return (uint)(ushort)__builtin_ia32_cvtd2mask512(m);
#else
  return rc_mask8(m.lo) | rc_mask8(m.hi) << 8;
#endif
}

/* The other way: bit i of a word to 0 / -1 in lane i. */
static inline int16 rc_bits16(uint bits) {
  return ((int16)((int)bits) & (int16)(1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768)) !=
         0;
}

/* Least and most of numbers (no NaN): one instruction each, where fmin and fmax spend three on NaN. For float8 and
 * float16. */
static inline float8 rc_min8(float8 a, float8 b) { return a < b ? a : b; }
static inline float8 rc_max8(float8 a, float8 b) { return a > b ? a : b; }
static inline float16 rc_min16(float16 a, float16 b) { return a < b ? a : b; }
static inline float16 rc_max16(float16 a, float16 b) { return a > b ? a : b; }

/* Least and most of the lanes. */
static inline float rc_least16(float16 v) {
  const float8 h = rc_min8(v.lo, v.hi);
  const float4 q = h.lo < h.hi ? h.lo : h.hi;
  const float2 p = q.lo < q.hi ? q.lo : q.hi;
  return p.x < p.y ? p.x : p.y;
}
static inline float rc_most16(float16 v) { return -rc_least16(-v); }

/* vstore16 and vload16 as one access where the compiler is clang. Its library's are of quarters and halves, which are
 * not always joined again: a load of the whole soon after such a store waits for all of it to reach the cache, and
 * shadow rays took a third longer by loads of halves from the work-item's own memory. Loads from global memory are
 * joined, and oclgrind takes them for the crossing of a struct's arrays when they are not its own. */
#if defined(__clang__)
typedef float16 __attribute__((aligned(4))) rc_float16_packed;
typedef uint16 __attribute__((aligned(4))) rc_uint16_packed;
#define RC_OVERLOAD __attribute__((overloadable)) static inline
RC_OVERLOAD void rc_store16(float16 v, size_t i, private float* p) { *(private rc_float16_packed*)(p + 16 * i) = v; }
RC_OVERLOAD void rc_store16(float16 v, size_t i, global float* p) { *(global rc_float16_packed*)(p + 16 * i) = v; }
RC_OVERLOAD void rc_store16(uint16 v, size_t i, private uint* p) { *(private rc_uint16_packed*)(p + 16 * i) = v; }
RC_OVERLOAD void rc_store16(uint16 v, size_t i, global uint* p) { *(global rc_uint16_packed*)(p + 16 * i) = v; }
RC_OVERLOAD float16 rc_load16(size_t i, const private float* p) {
  return *(const private rc_float16_packed*)(p + 16 * i);
}
RC_OVERLOAD float16 rc_load16(size_t i, const global float* p) { return vload16(i, p); }
RC_OVERLOAD uint16 rc_load16(size_t i, const private uint* p) { return *(const private rc_uint16_packed*)(p + 16 * i); }
RC_OVERLOAD uint16 rc_load16(size_t i, const global uint* p) { return vload16(i, p); }
#else
#define rc_store16(v, i, p) vstore16(v, i, p)
#define rc_load16(i, p) vload16(i, p)
#endif

/* Sum of the lanes by one fixed tree. */
static inline float rc_lane_sum(float16 v) {
  const float8 a = v.lo + v.hi;
  const float4 b = a.lo + a.hi;
  const float2 c = b.lo + b.hi;
  return c.x + c.y;
}

/* Private arrays that vectors are read from and written to: a vector across two cache lines costs two. */
#define RC_LINE __attribute__((aligned(64)))

/* Only where all address spaces are one: GPUs hide latency otherwise, and NVIDIA's compiler refuses the cast. */
static inline void rc_prefetch(global const void* at, uint bytes) {
#if defined(__has_builtin) && (defined(__x86_64__) || defined(__aarch64__))
#if __has_builtin(__builtin_prefetch) && !defined(RC_NO_PREFETCH) /* oclgrind knows no prefetch */
  for (uint i = 0; i < bytes; i += 64u) __builtin_prefetch((const void*)((uintptr_t)at + i), 0, 3);
#endif
#endif
}

/* For functions whose callers fix an argument that loops or branches hang on. */
#define RC_ALWAYS __attribute__((always_inline))

/* Lowest set bit; bits != 0. */
static inline uint rc_lowest(uint bits) { return 31u - clz(bits & (0u - bits)); }

#ifdef RC_HAS_CHOSEN256
/* Numbers of the lanes in an 8-bit word, ascending; then zeros. */
static inline int8 rc_chosen8(uint lanes) {
  const ulong bytes = __builtin_ia32_pdep_di((ulong)lanes, 0x0101010101010101ul) * 255u;
  return convert_int8(as_uchar8(__builtin_ia32_pext_di(0x0706050403020100ul, bytes)));
}
#endif

/* Stores the lanes in `lanes` side by side; what lies up to 16 behind `to` may change. */
static inline void rc_pack16(float16 v, uint lanes, float* to) {
#ifdef RC_HAS_PACK512
  rc_store16(__builtin_ia32_compresssf512_mask(v, v, (ushort)lanes), 0, to);
#elif defined(RC_HAS_CHOSEN256)
  vstore8(__builtin_ia32_permvarsf256(v.lo, rc_chosen8(lanes & 255u)), 0, to);
  vstore8(__builtin_ia32_permvarsf256(v.hi, rc_chosen8(lanes >> 8)), 0, to + popcount(lanes & 255u));
#else
  RC_LINE float of[16];
  rc_store16(v, 0, of);
  for (; lanes; lanes &= lanes - 1u) *to++ = of[rc_lowest(lanes)];
#endif
}

/* Stores the lanes of eight that are in `lanes` side by side and returns their number; what lies up to eight behind
 * `to` may change. */
static inline uint rc_pack8(global const uint* from, uint lanes, uint* to) {
#ifdef RC_HAS_PACK256
  const int8 all = as_int8(vload8(0, from));
  vstore8(as_uint8(__builtin_ia32_compresssi256_mask(all, all, (uchar)lanes)), 0, to);
  return popcount(lanes);
#elif defined(RC_HAS_CHOSEN256)
  vstore8(as_uint8(__builtin_ia32_permvarsi256(as_int8(vload8(0, from)), rc_chosen8(lanes))), 0, to);
  return popcount(lanes);
#else
  uint count = 0;
  for (; lanes; lanes &= lanes - 1u) to[count++] = from[rc_lowest(lanes)];
  return count;
#endif
}

/* Lane i: v's lane from[i], which is below 16. */
static inline float16 rc_permute16(float16 v, uint16 from) {
#ifdef RC_HAS_PERMUTE512
  return __builtin_ia32_permvarsf512(v, as_int16(from));
#elif defined(RC_HAS_PERMUTE256)
  /* a permutation of eight reads three bits of a number */
  const int8 lo = as_int8(from.lo), hi = as_int8(from.hi);
  float16 out;
  out.lo = select(__builtin_ia32_permvarsf256(v.lo, lo), __builtin_ia32_permvarsf256(v.hi, lo), lo > 7);
  out.hi = select(__builtin_ia32_permvarsf256(v.lo, hi), __builtin_ia32_permvarsf256(v.hi, hi), hi > 7);
  return out;
#else
  RC_LINE float of[16], to[16];
  RC_LINE uint k[16];
  rc_store16(v, 0, of);
  rc_store16(from, 0, k);
  for (uint i = 0; i < 16u; ++i) to[i] = of[k[i]];
  return vload16(0, to);
#endif
}

#ifdef RC_HAS_GATHER
/* Lane i: from[index[i]] where i is in `lanes`, else 0, and nothing is read. */
static inline float16 rc_gather16(private const float* from, uint16 index, uint lanes) {
  const int16 at = as_int16(index);
#ifdef RC_HAS_GATHER512
  return __builtin_ia32_gathersiv16sf((float16)(0.0f), (const void*)from, at, (ushort)lanes, 4);
#else
  const int16 read = rc_bits16(lanes);
  float16 out;
  out.lo = __builtin_ia32_gatherd_ps256((float8)(0.0f), (const void*)from, at.lo, as_float8(read.lo), 4);
  out.hi = __builtin_ia32_gatherd_ps256((float8)(0.0f), (const void*)from, at.hi, as_float8(read.hi), 4);
  return out;
#endif
}
#endif

#endif
