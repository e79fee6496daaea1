#include "bench/lidar_baseline.h"

#include <embree3/rtcore.h>

#include <cmath>
#include <limits>

#include "bench/pieces.h"

namespace raycube::bench {

LidarBaseline::LidarBaseline(const EmbreeBaseline& embree, const scene::CompiledScene& scene) : embree_(embree), scene_(scene) {
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    std::vector<std::uint32_t>& surface = surface_.emplace_back();
    for (std::uint32_t p = 0; p < scene.meshes[m].triangle_count; ++p) {
      const std::uint32_t at = embree.scene_primitive(static_cast<std::uint32_t>(m), p);
      surface.push_back(scene.blocks[at / RC_BLOCK].surface[at % RC_BLOCK]);
    }
  }
}

void LidarBaseline::run(const LidarWork& work, int threads, float* rows) const {
  const RTCScene scene = embree_.handle();
  const bool flat = embree_.flat();
  const std::size_t samples = work.a.size(), packets = (samples + 15) / 16;
  std::vector<float> as(packets * 16, 0.0f), bs(packets * 16, 0.0f);
  std::copy(work.a.begin(), work.a.end(), as.begin());
  std::copy(work.b.begin(), work.b.end(), bs.begin());
  const int taps = work.taps->taps, phases = work.taps->phases, first_tap = work.taps->first;
  const float* shares = work.taps->share.data();
  in_parallel(work.groups.size(), 16, threads, [&](std::size_t begin, std::size_t end) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) RTCRayHit16 packet;
    alignas(64) int valid[16];
    alignas(64) float energy[16], place[16];
    for (std::size_t s = begin; s < end; ++s) {
      const shared::RayGroup& g = work.groups[s];
      float* row = rows + s * static_cast<std::size_t>(work.bins);
      std::fill(row, row + work.bins, 0.0f);
      for (std::size_t p = 0; p < packets; ++p) {
        const int live = static_cast<int>(std::min<std::size_t>(16, samples - 16 * p));
        for (int k = 0; k < 16; ++k) {
          const float a = as[16 * p + static_cast<std::size_t>(k)], b = bs[16 * p + static_cast<std::size_t>(k)];
          packet.ray.org_x[k] = g.origin.x, packet.ray.org_y[k] = g.origin.y, packet.ray.org_z[k] = g.origin.z;
          packet.ray.dir_x[k] = std::fma(b, g.dv.x, std::fma(a, g.du.x, g.d0.x));
          packet.ray.dir_y[k] = std::fma(b, g.dv.y, std::fma(a, g.du.y, g.d0.y));
          packet.ray.dir_z[k] = std::fma(b, g.dv.z, std::fma(a, g.du.z, g.d0.z));
          packet.ray.tnear[k] = 0.0f;
          packet.ray.tfar[k] = std::numeric_limits<float>::infinity();
          packet.ray.time[k] = 0.0f;
          packet.ray.mask[k] = 0xFFFFFFFFu;
          packet.ray.flags[k] = 0;
          packet.hit.geomID[k] = packet.hit.primID[k] = packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
          valid[k] = k < live ? -1 : 0;
        }
        rtcIntersect16(valid, scene, &context, &packet);
        if (!flat) {  // Embree gives normals in the mesh's frame; they go by the transposed inverse
          for (int k = 0; k < live; ++k) {
            if (packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
            const shared::Instance& placed = scene_.instances[packet.hit.instID[0][k]];
            if (placed.flags & 1u) continue;
            const shared::rc_float4 &r0 = placed.local_from_world_0, &r1 = placed.local_from_world_1, &r2 = placed.local_from_world_2;
            const float x = packet.hit.Ng_x[k], y = packet.hit.Ng_y[k], z = packet.hit.Ng_z[k];
            packet.hit.Ng_x[k] = r0.x * x + r1.x * y + r2.x * z;
            packet.hit.Ng_y[k] = r0.y * x + r1.y * y + r2.y * z;
            packet.hit.Ng_z[k] = r0.z * x + r1.z * y + r2.z * z;
          }
        }
        for (int k = 0; k < 16; ++k) {
          const float dx = packet.ray.dir_x[k], dy = packet.ray.dir_y[k], dz = packet.ray.dir_z[k];
          const float nx = packet.hit.Ng_x[k], ny = packet.hit.Ng_y[k], nz = packet.hit.Ng_z[k];
          const float d2 = dx * dx + dy * dy + dz * dz, n2 = nx * nx + ny * ny + nz * nz, length = std::sqrt(d2);
          const float range = packet.ray.tfar[k] * length;
          const float cosine = std::abs(nx * dx + ny * dy + nz * dz) / (length * std::sqrt(n2));
          const float off_axis = (g.d0.x * dx + g.d0.y * dy + g.d0.z * dz) / length;
          energy[k] = work.weight * cosine * off_axis / (range * range);
          place[k] = (range - work.start_m[s]) * work.bins_per_m;
        }
        for (int k = 0; k < live; ++k) {
          if (packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
          const std::uint32_t mesh = flat ? 0u : scene_.instances[packet.hit.instID[0][k]].mesh;
          const float e = energy[k] * (*work.reflectance)[surface_[mesh][packet.hit.primID[k]]];
          const float whole = std::floor(place[k]), phase = (place[k] - whole) * static_cast<float>(phases);
          const int q = std::min(static_cast<int>(phase), phases - 1), bin = static_cast<int>(whole) + first_tap;
          const float f = phase - static_cast<float>(q);
          const float *low = shares + q * taps, *high = low + taps;
          const int from = std::max(0, -bin), to = std::min(taps, work.bins - bin);
          for (int i = from; i < to; ++i) row[bin + i] += e * (low[i] + f * (high[i] - low[i]));
        }
      }
    }
  });
}

}  // namespace raycube::bench
