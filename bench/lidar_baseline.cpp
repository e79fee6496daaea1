#include "bench/lidar_baseline.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#ifdef __AVX512F__
#include <immintrin.h>
#endif

#include "bench/pieces.h"
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

/// Returns of a packet as numbers of lanes that send something.
struct Returns {
  alignas(64) float low[16], high[16];   ///< energy for the phases below and above
  alignas(64) int start[16], share[16];  ///< first bin; where the lower phase's shares begin
  int count = 0;
};

/// The same additions as the device's: neighbours that start in one bin add up in registers. Vectors: of 16 taps.
template <int Vectors>
void deposit(const Returns& r, const float* shares, float* row) {
  for (int i = 0; i < r.count;) {
    const int start = r.start[i];
    float* to = row + start;
    Vec16 low[Vectors], high[Vectors];
    for (int v = 0; v < Vectors; ++v) low[v] = loose(to + 16 * v), high[v] = all(0);
    for (; i < r.count && r.start[i] == start; ++i) {
      const float* at = shares + r.share[i];
      for (int v = 0; v < Vectors; ++v) {
        low[v] += r.low[i] * lanes(at + 16 * v);
        high[v] += r.high[i] * lanes(at + 16 * (Vectors + v));
      }
    }
    for (int v = 0; v < Vectors; ++v) loose(to + 16 * v) = low[v] + high[v];
  }
}

using Deposit = void (*)(const Returns&, const float*, float*);
constexpr std::array<Deposit, 4> kDeposits{deposit<1>, deposit<2>, deposit<3>, deposit<4>};

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

void LidarBaseline::run(const LidarWork& work, int threads, float* rows) const {
  const RTCScene scene = embree_.handle();
  const bool flat = embree_.flat();
  const std::size_t samples = work.a.size(), packets = (samples + 15) / 16, pad = row_pad(work),
                    row_size = row_floats(work);
  std::vector<float> as(packets * 16 + 16, 0.0f), bs(packets * 16 + 16, 0.0f);
  std::copy(work.a.begin(), work.a.end(), as.begin());
  std::copy(work.b.begin(), work.b.end(), bs.begin());
  const int taps = work.taps->taps, phases = work.taps->phases, first_tap = work.taps->first;
  std::vector<float> unaligned((static_cast<std::size_t>(phases) + 1) * pad + 16, 0.0f);
  float* shares = on_line(unaligned.data());
  for (std::size_t q = 0; q <= static_cast<std::size_t>(phases); ++q)
    std::copy_n(work.taps->share.data() + q * static_cast<std::size_t>(taps), taps, shares + q * pad);
  const Deposit add = kDeposits.at(pad / 16 - 1);
  in_parallel(work.groups.size(), 16, threads, [&](std::size_t begin, std::size_t end) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) RTCRayHit16 packet;
    alignas(64) int valid[16];
    alignas(64) float energy[16], place[16];
    Returns returns;
    std::vector<float> window(row_size + 16);
    float* row = on_line(window.data());
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
        lanes(energy) = work.weight * magnitude(nx * dx + ny * dy + nz * dz) *
                        (g.d0.x * dx + g.d0.y * dy + g.d0.z * dz) / (d2 * d2 * t2 * root(n2));
        lanes(place) = (t * root(d2) - work.start_m[s]) * work.bins_per_m;
        returns.count = 0;
        std::uint32_t last_tree = 0, last_primitive = RTC_INVALID_GEOMETRY_ID;
        float reflectance = 0;
        for (int k = 0; k < live; ++k) {
          const std::uint32_t primitive = packet.hit.primID[k];
          if (packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
          const std::uint32_t tree = flat ? 0u : scene_.instances[packet.hit.instID[0][k]].tree;
          if (primitive != last_primitive || tree != last_tree) {
            reflectance = (*work.reflectance)[surface_[tree][primitive]];
            last_primitive = primitive, last_tree = tree;
          }
          const float whole = std::floor(place[k]), phase = (place[k] - whole) * static_cast<float>(phases);
          const int q = std::min(static_cast<int>(phase), phases - 1), start = static_cast<int>(whole) + first_tap;
          if (start + taps <= 0 || start >= work.bins) continue;
          const float e = energy[k] * reflectance, high = e * (phase - static_cast<float>(q));
          const int i = returns.count++;
          returns.low[i] = e - high, returns.high[i] = high;
          returns.start[i] = start + static_cast<int>(pad), returns.share[i] = q * static_cast<int>(pad);
        }
        add(returns, shares, row);
      }
      write_row(row, row_size, rows + s * row_size);
    }
  });
}

}  // namespace raycube::bench
