#include "bench/lidar_baseline.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#ifdef __AVX512F__
#include <immintrin.h>
#endif

#include "bench/pieces.h"
#include "host/base/error.h"
#include "host/lidar/pulse_moments.h"
#include "kernels/shared/tile_layout.h"

namespace raycube::bench {

LidarBaseline::LidarBaseline(const EmbreeBaseline& embree, const scene::CompiledScene& scene)
    : embree_(embree), scene_(scene) {
  for (std::size_t t = 0; t < scene.trees.size(); ++t) {
    std::vector<std::uint32_t>& surface = surface_.emplace_back();
    for (std::uint32_t p = 0; p < scene.trees[t].triangle_count; ++p) {
      const std::uint32_t at = embree.scene_primitive(static_cast<std::uint32_t>(t), p);
      surface.push_back(scene.blocks[at / RC_BLOCK].surface[at % RC_BLOCK]);
    }
  }
}

namespace {

using Vec16 = float __attribute__((vector_size(64)));                // a whole packet, aligned
using Loose16 = float __attribute__((vector_size(64), aligned(4)));  // the same anywhere

Vec16 all(float x) { return Vec16{} + x; }
const Vec16& lanes(const float* at) { return *reinterpret_cast<const Vec16*>(at); }
Vec16& lanes(float* at) { return *reinterpret_cast<Vec16*>(at); }
Loose16& loose(float* at) { return *reinterpret_cast<Loose16*>(at); }
Vec16 root(Vec16 v) {
#ifdef __AVX512F__
  return reinterpret_cast<Vec16>(_mm512_maskz_sqrt_ps(0xFFFF, reinterpret_cast<__m512>(v)));
#else
  for (int k = 0; k < 16; ++k) v[k] = std::sqrt(v[k]);
  return v;
#endif
}
Vec16 magnitude(Vec16 v) { return v < 0.0f ? -v : v; }

/// A finished row to memory past the caches, as the device writes its own. Both on cache lines, count a multiple of 16.
void write_row(const float* row, std::size_t count, float* to) {
#ifdef __AVX512F__
  for (std::size_t i = 0; i < count; i += 16) _mm512_stream_ps(to + i, _mm512_load_ps(row + i));
#else
  std::copy_n(row, count, to);
#endif
}

using Int16 = std::int32_t __attribute__((vector_size(64)));

Int16 whole_below(Vec16 v) {
  const Int16 cut = __builtin_convertvector(v, Int16);
  return cut + (__builtin_convertvector(cut, Vec16) > v);  // true is -1
}

/// Bit k: lane k of a comparison.
std::uint32_t mask(Int16 v) {
#ifdef __AVX512F__
  return _mm512_cmplt_epi32_mask(reinterpret_cast<__m512i>(v), _mm512_setzero_si512());
#else
  std::uint32_t bits = 0;
  for (int k = 0; k < 16; ++k) bits |= v[k] ? 1u << k : 0u;
  return bits;
#endif
}

/// Moments of what falls into each cell of a bin (host/lidar/pulse_moments.h), the same as the device's: lanes side by
/// side until another cell takes the slot or the pulse ends. Vectors: of 16 taps.
template <int Vectors>
class Moments {
 public:
  Moments(const float* shares, int cells, float* row) : shares_(shares), cells_(cells), row_(row) {
    std::fill(std::begin(cell_), std::end(cell_), kFree);
  }
  /// cell: start from the row's first float on, times cells, and the cell; below 0: none. y: place in it. Words wait,
  /// as on the device, until what the branches hang on is long known.
  void add(Int16 cell, Vec16 y, Vec16 energy) {
    waiting_[words_++] = {cell, y, energy};
    if (words_ == kWords) sort_words();
  }
  void fold_all() {
    sort_words();
    for (std::size_t slot = 0; slot < kSlots; ++slot)
      if (cell_[slot] != kFree) fold(slot), cell_[slot] = kFree;
  }

 private:
  static constexpr std::int32_t kFree = -1, kSlots = 16, kWords = 16;
  struct Word {
    Int16 cell;
    Vec16 y, energy;
  };
  void sort_words() {
    for (int w = 0; w < words_; ++w) sort(waiting_[w]);
    words_ = 0;
  }
  void sort(const Word& word) {
    for (std::uint32_t left = mask(word.cell >= 0); left;) {
      const std::int32_t here = word.cell[__builtin_ctz(left)];
      const Int16 same = word.cell == here;
      left &= ~mask(same);
      const auto slot = static_cast<std::size_t>((here ^ here >> 4) % kSlots);
      if (cell_[slot] != here) {
        if (cell_[slot] != kFree) fold(slot);
        cell_[slot] = here;
        std::fill(std::begin(sum_[slot]), std::end(sum_[slot]), all(0));
      }
      Vec16 moment = same ? word.energy : all(0);
      for (int m = 0; m < RC_MOMENTS; ++m, moment *= word.y) sum_[slot][m] += moment;
    }
  }
  void fold(std::size_t slot) {
    const std::int32_t start = cell_[slot] / cells_;
    const float* at = shares_ + static_cast<std::size_t>(cell_[slot] - start * cells_) * RC_MOMENTS * Vectors * 16;
    float moment[RC_MOMENTS];
    for (int m = 0; m < RC_MOMENTS; ++m) {
      moment[m] = 0;
      for (int k = 0; k < 16; ++k) moment[m] += sum_[slot][m][k];
    }
    for (int v = 0; v < Vectors; ++v) {
      Vec16 sum = loose(row_ + start + 16 * v);
      for (int m = 0; m < RC_MOMENTS; ++m) sum += moment[m] * lanes(at + 16 * (m * Vectors + v));
      loose(row_ + start + 16 * v) = sum;
    }
  }
  Vec16 sum_[kSlots][RC_MOMENTS];
  std::int32_t cell_[kSlots];
  Word waiting_[kWords];
  int words_ = 0;
  const float* shares_;
  int cells_;
  float* row_;
};

/// Of a packet's lanes. instances: null where there is one tree. surface: [tree][Embree's primitive].
Vec16 reflectances(const LidarWork& work, const RTCRayHit16& packet, int live, const shared::Instance* instances,
                   const std::vector<std::vector<std::uint32_t>>& surface) {
  alignas(64) float of[16] = {};
  std::uint32_t last_tree = 0, last_primitive = RTC_INVALID_GEOMETRY_ID;
  float reflectance = 0;
  for (int k = 0; k < live; ++k) {
    const std::uint32_t primitive = packet.hit.primID[k];
    if (packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
    const std::uint32_t tree = instances ? instances[packet.hit.instID[0][k]].tree : 0u;
    if (primitive != last_primitive || tree != last_tree) {
      reflectance = (*work.reflectance)[surface[tree][primitive]];
      last_primitive = primitive, last_tree = tree;
    }
    of[k] = reflectance;
  }
  return lanes(of);
}

}  // namespace

float* LidarBaseline::on_line(float* at) {
  return at + (64 - reinterpret_cast<std::uintptr_t>(at) % 64) % 64 / sizeof(float);
}
std::size_t LidarBaseline::row_pad(const LidarWork& work) {
  return RC_PADDED(static_cast<std::size_t>(work.taps->taps));
}
std::size_t LidarBaseline::row_floats(const LidarWork& work) {
  return 2 * row_pad(work) + RC_PADDED(static_cast<std::size_t>(work.bins));
}

template <int Vectors>
void LidarBaseline::run_of(const LidarWork& work, int threads, float* rows) const {
  const RTCScene scene = embree_.handle();
  const bool flat = embree_.flat();
  const std::size_t samples = work.a.size(), packets = (samples + 15) / 16, pad = row_pad(work),
                    row_size = row_floats(work);
  std::vector<float> as(packets * 16 + 16, 0.0f), bs(packets * 16 + 16, 0.0f);
  std::copy(work.a.begin(), work.a.end(), as.begin());
  std::copy(work.b.begin(), work.b.end(), bs.begin());
  const int taps = work.taps->taps, first_tap = work.taps->first;
  const lidar::PulseMoments pulse = lidar::make_moments(*work.taps);
  const auto powers = static_cast<std::size_t>(pulse.cells * RC_MOMENTS);
  std::vector<float> unaligned(powers * pad + 16, 0.0f);
  float* shares = on_line(unaligned.data());
  for (std::size_t q = 0; q < powers; ++q)
    std::copy_n(pulse.share.data() + q * static_cast<std::size_t>(taps), taps, shares + q * pad);
  in_parallel(work.groups.size(), 16, threads, [&](std::size_t begin, std::size_t end) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) RTCRayHit16 packet;
    alignas(64) int valid[16];
    std::vector<float> window(row_size + 16);
    float* row = on_line(window.data());
    Moments<Vectors> moments(shares, pulse.cells, row);
    for (std::size_t s = begin; s < end; ++s) {
      const shared::RayGroup& g = work.groups[s];
      std::fill(row, row + row_size, 0.0f);
      for (std::size_t p = 0; p < packets; ++p) {
        const int live = static_cast<int>(std::min<std::size_t>(16, samples - 16 * p));
        const Vec16 a = loose(as.data() + 16 * p), b = loose(bs.data() + 16 * p);
        const Vec16 dx = b * g.dv.x + (a * g.du.x + g.d0.x), dy = b * g.dv.y + (a * g.du.y + g.d0.y),
                    dz = b * g.dv.z + (a * g.du.z + g.d0.z);
        lanes(packet.ray.org_x) = all(g.origin.x), lanes(packet.ray.org_y) = all(g.origin.y),
        lanes(packet.ray.org_z) = all(g.origin.z);
        lanes(packet.ray.dir_x) = dx, lanes(packet.ray.dir_y) = dy, lanes(packet.ray.dir_z) = dz;
        lanes(packet.ray.tnear) = lanes(packet.ray.time) = all(0);
        lanes(packet.ray.tfar) = all(std::numeric_limits<float>::infinity());
        for (int k = 0; k < 16; ++k) {
          packet.ray.mask[k] = 0xFFFFFFFFu;
          packet.ray.flags[k] = 0;
          packet.hit.geomID[k] = packet.hit.primID[k] = packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
          valid[k] = k < live ? -1 : 0;
          if (k >= live) packet.ray.tfar[k] = -1;  // as in embree_baseline.cpp
        }
        rtcIntersect16(valid, scene, &context, &packet);
        if (!flat) {  // Embree gives normals in the mesh's frame; they go by the transposed inverse
          for (int k = 0; k < live; ++k) {
            if (packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
            const shared::Instance& placed = scene_.instances[packet.hit.instID[0][k]];
            if (placed.flags & 1u) continue;
            const shared::rc_float4 &r0 = placed.local_from_world_0, &r1 = placed.local_from_world_1,
                                    &r2 = placed.local_from_world_2;
            const float x = packet.hit.Ng_x[k], y = packet.hit.Ng_y[k], z = packet.hit.Ng_z[k];
            packet.hit.Ng_x[k] = r0.x * x + r1.x * y + r2.x * z;
            packet.hit.Ng_y[k] = r0.y * x + r1.y * y + r2.y * z;
            packet.hit.Ng_z[k] = r0.z * x + r1.z * y + r2.z * z;
          }
        }
        const Vec16 nx = lanes(packet.hit.Ng_x), ny = lanes(packet.hit.Ng_y), nz = lanes(packet.hit.Ng_z),
                    t = lanes(packet.ray.tfar);
        const Vec16 d2 = dx * dx + dy * dy + dz * dz, n2 = nx * nx + ny * ny + nz * nz, t2 = t * t;
        // cosine to the surface and to the axis over the range squared, in one division
        const Vec16 energy = reflectances(work, packet, live, flat ? nullptr : scene_.instances.data(), surface_) *
                             work.weight * magnitude(nx * dx + ny * dy + nz * dz) *
                             (g.d0.x * dx + g.d0.y * dy + g.d0.z * dz) / (d2 * d2 * t2 * root(n2));
        const Vec16 place = (t * root(d2) - work.start_m[s]) * work.bins_per_m;
        const Int16 bin = whole_below(place), start = bin + first_tap;
        const Vec16 part = (place - __builtin_convertvector(bin, Vec16)) * static_cast<float>(pulse.cells);
        const Int16 cut = __builtin_convertvector(part, Int16), last = Int16{} + (pulse.cells - 1),
                    cell = cut > last ? last : cut;
        const Int16 hit =
            reinterpret_cast<const Int16&>(packet.hit.geomID) != -1 && start + taps > 0 && start < work.bins;
        moments.add(hit ? (start + static_cast<int>(pad)) * pulse.cells + cell : Int16{} - 1,
                    hit ? part - __builtin_convertvector(cell, Vec16) - 0.5f : all(0), hit ? energy : all(0));
      }
      moments.fold_all();
      write_row(row, row_size, rows + s * row_size);
    }
  });
}

void LidarBaseline::run(const LidarWork& work, int threads, float* rows) const {
  switch (row_pad(work) / 16) {
    case 1:
      return run_of<1>(work, threads, rows);
    case 2:
      return run_of<2>(work, threads, rows);
    case 3:
      return run_of<3>(work, threads, rows);
    case 4:
      return run_of<4>(work, threads, rows);
  }
  throw base::Error(base::Fault::bug, "the baseline bins pulses of up to 64 taps");
}

}  // namespace raycube::bench
