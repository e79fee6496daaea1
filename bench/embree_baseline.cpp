#include "bench/embree_baseline.h"

#include <embree3/rtcore.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "bench/pieces.h"
#include "host/base/error.h"

namespace raycube::bench {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// End of a lane that is no ray: where the machine has no packets of 16 Embree takes them as a stream, which knows such
/// lanes by an end before the start alone, not by the mask, and stops at one that is not a number.
constexpr float kNoRay = -1;

void check(RTCDevice device, const char* what) {
  if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE)
    throw base::Error(base::Fault::environment,
                      std::string("bench: Embree could not ") + what + " (error " + std::to_string(error) + ")");
}

bool count_bytes(void* total, ssize_t bytes, bool) {
  *static_cast<std::atomic<std::int64_t>*>(total) += bytes;
  return true;
}

/// use(corners, primitive) for each triangle of a tree, in its frame; corners: 9 floats, primitive: the scene's
/// number of it.
template <typename Use>
void for_each_triangle(const scene::CompiledScene& scene, const scene::Tree& tree, const Use& use) {
  for (std::uint32_t b = tree.first_block; b < tree.first_block + tree.block_count; ++b) {
    const shared::TriBlock& t = scene.blocks[b];
    for (std::uint32_t lane = 0; lane < RC_BLOCK; ++lane) {
      if (t.surface[lane] == RC_NONE) continue;
      const float corners[9] = {t.v0_x[lane], t.v0_y[lane], t.v0_z[lane], t.v1_x[lane], t.v1_y[lane],
                                t.v1_z[lane], t.v2_x[lane], t.v2_y[lane], t.v2_z[lane]};
      use(corners, b * RC_BLOCK + lane);
    }
  }
}

/// Row-major 3 x 4.
std::array<float, 12> matrix_of(const shared::Instance& instance) {
  std::array<float, 12> matrix;
  const shared::rc_float4* rows[] = {&instance.world_from_local_0, &instance.world_from_local_1,
                                     &instance.world_from_local_2};
  for (std::size_t r = 0; r < 3; ++r) {
    matrix[4 * r] = rows[r]->x;
    matrix[4 * r + 1] = rows[r]->y;
    matrix[4 * r + 2] = rows[r]->z;
    matrix[4 * r + 3] = rows[r]->w;
  }
  return matrix;
}

/// The rays `first` .. `first + live - 1` as a packet; valid: 0 where there is none, or it is to be skipped.
void fill_packet(const ShadowRays& rays, std::size_t first, std::size_t live, RTCRay16& packet, int* valid) {
  const bool own = !rays.dx.empty();
  for (int k = 0; k < 16; ++k) {
    const std::size_t i = first + std::min<std::size_t>(k, live - 1);
    const bool skipped = k >= static_cast<int>(live) || std::isnan(rays.x[i]);
    packet.org_x[k] = skipped ? 0.0f : rays.x[i];
    packet.org_y[k] = rays.y[i];
    packet.org_z[k] = rays.z[i];
    packet.dir_x[k] = own ? rays.dx[i] : rays.direction[0];
    packet.dir_y[k] = own ? rays.dy[i] : rays.direction[1];
    packet.dir_z[k] = own ? rays.dz[i] : rays.direction[2];
    packet.tnear[k] = 0.0f;
    packet.tfar[k] = skipped ? kNoRay : kInfinity;
    packet.time[k] = 0.0f;
    packet.mask[k] = 0xFFFFFFFFu;
    packet.flags[k] = 0;
    valid[k] = skipped ? 0 : -1;
  }
}

}  // namespace

const char* form_name(EmbreeForm form) { return form == EmbreeForm::merged ? "merged" : "placed"; }

const char* mode_name(EmbreeMode mode) {
  switch (mode) {
    case EmbreeMode::packet16_coherent:
      return "16 coherent";
    case EmbreeMode::packet16:
      return "16";
    case EmbreeMode::single:
      return "1";
  }
  return "";
}

struct EmbreeBaseline::Impl {
  std::atomic<std::int64_t> bytes{0};
  RTCDevice device = nullptr;
  RTCScene top = nullptr;
  std::vector<RTCScene> trees;
  bool flat = false;
  std::vector<std::vector<std::uint32_t>> primitive;  ///< [tree][Embree's number] = the scene's
  std::vector<std::uint32_t> tree_of_instance;
  std::vector<RayResult> merged;  ///< [Embree's number] = the scene's, of the merged form

  ~Impl() {
    if (top) rtcReleaseScene(top);
    for (RTCScene tree : trees)
      if (tree) rtcReleaseScene(tree);
    if (device) rtcReleaseDevice(device);
  }

  /// Triangles of their own corners, to be filled and then built.
  struct Corners {
    RTCGeometry geometry;
    float* vertices;
    std::size_t count = 0, most;
    void add(const float* nine) {
      if (count == most) throw base::Error(base::Fault::bug, "bench: a tree has more used lanes than triangles");
      std::copy(nine, nine + 9, vertices + 9 * count++);
    }
  };

  Corners begin_triangles(std::size_t triangles) const {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * triangles));
    auto* indices = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles));
    check(device, "make a tree's buffers");
    for (std::size_t n = 0; n < 3 * triangles; ++n) indices[n] = static_cast<unsigned>(n);
    return {geometry, vertices, 0, triangles};
  }

  RTCScene build(const Corners& corners) const {
    if (corners.count != corners.most)
      throw base::Error(base::Fault::bug, "bench: a tree has fewer used lanes than triangles");
    rtcSetGeometryBuildQuality(corners.geometry, RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitGeometry(corners.geometry);
    RTCScene built = rtcNewScene(device);
    rtcSetSceneBuildQuality(built, RTC_BUILD_QUALITY_MEDIUM);
    rtcAttachGeometry(built, corners.geometry);
    rtcReleaseGeometry(corners.geometry);
    rtcCommitScene(built);
    check(device, "build a tree");
    return built;
  }

  RTCScene build(const scene::CompiledScene& scene, const scene::Tree& tree) {
    Corners corners = begin_triangles(tree.triangle_count);
    std::vector<std::uint32_t>& numbers = primitive.emplace_back();
    for_each_triangle(scene, tree, [&](const float* nine, std::uint32_t number) {
      corners.add(nine);
      numbers.push_back(number);
    });
    return build(corners);
  }

  RTCScene build_merged(const scene::CompiledScene& scene) {
    Corners corners = begin_triangles(placed_triangles(scene));
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
      const auto place = matrix_of(scene.instances[i]);
      for_each_triangle(scene, scene.trees[scene.instances[i].tree], [&](const float* nine, std::uint32_t number) {
        float moved[9];
        for (std::size_t corner = 0; corner < 3; ++corner)
          for (std::size_t row = 0; row < 3; ++row) {
            double at = place[4 * row + 3];
            for (std::size_t k = 0; k < 3; ++k) at += static_cast<double>(place[4 * row + k]) * nine[3 * corner + k];
            moved[3 * corner + row] = static_cast<float>(at);
          }
        corners.add(moved);
        merged.push_back({i, number});
      });
    }
    return build(corners);
  }

  void build_top(const scene::CompiledScene& scene) {
    top = rtcNewScene(device);
    rtcSetSceneBuildQuality(top, RTC_BUILD_QUALITY_MEDIUM);
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
      RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
      rtcSetGeometryInstancedScene(geometry, trees[scene.instances[i].tree]);
      rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, matrix_of(scene.instances[i]).data());
      rtcCommitGeometry(geometry);
      rtcAttachGeometryByID(top, geometry, static_cast<unsigned>(i));
      rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(top);
    check(device, "build the top tree");
  }
};

std::size_t placed_triangles(const scene::CompiledScene& scene) {
  std::size_t triangles = 0;
  for (const shared::Instance& instance : scene.instances) triangles += scene.trees[instance.tree].triangle_count;
  return triangles;
}

EmbreeBaseline::EmbreeBaseline(const scene::CompiledScene& scene, EmbreeForm form) : impl_(std::make_unique<Impl>()) {
  Impl& e = *impl_;
  e.device = rtcNewDevice(nullptr);
  if (!e.device) throw base::Error(base::Fault::environment, "bench: Embree has no device; is libembree3 whole?");
  rtcSetDeviceMemoryMonitorFunction(e.device, count_bytes, &e.bytes);
  if (form == EmbreeForm::merged) {
    e.flat = true;
    e.trees.push_back(e.build_merged(scene));
    return;
  }
  for (const scene::Tree& tree : scene.trees) e.trees.push_back(e.build(scene, tree));
  for (const shared::Instance& instance : scene.instances) e.tree_of_instance.push_back(instance.tree);
  e.flat = scene.instances.size() == 1 && (scene.instances[0].flags & 1u);
  if (!e.flat) e.build_top(scene);
}

EmbreeBaseline::~EmbreeBaseline() = default;

RTCSceneTy* EmbreeBaseline::handle() const { return impl_->flat ? impl_->trees[0] : impl_->top; }
bool EmbreeBaseline::flat() const { return impl_->flat; }
std::uint32_t EmbreeBaseline::scene_primitive(std::uint32_t tree, std::uint32_t primitive) const {
  return impl_->primitive[tree][primitive];
}

std::size_t EmbreeBaseline::memory_bytes() const { return static_cast<std::size_t>(impl_->bytes.load()); }

void EmbreeBaseline::primary(const PrimaryRays& rays, EmbreeMode mode, int threads, RayResult* result) const {
  const RTCScene scene = impl_->flat ? impl_->trees[0] : impl_->top;
  const bool flat = impl_->flat;
  const std::size_t samples = rays.samples(), width = static_cast<std::size_t>(rays.width);
  const std::size_t packets = (samples + 15) / 16;
  std::vector<float> us(packets * 16, 0.0f), vs(packets * 16, 0.0f);
  std::copy(rays.u.begin(), rays.u.end(), us.begin());
  std::copy(rays.v.begin(), rays.v.end(), vs.begin());
  in_parallel(rays.group_count, 16, threads, [&](std::size_t begin, std::size_t end) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = mode == EmbreeMode::packet16_coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                                          : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    alignas(64) RTCRayHit16 packet;
    alignas(64) int valid[16];
    for (std::size_t g = begin; g < end; ++g) {
      const shared::RayGroup& group = rays.groups[g];
      for (std::size_t i = 0; i < width; ++i) {
        const float centre = static_cast<float>(i) - 0.5f * static_cast<float>(width - 1);
        RayResult* out = result + (g * width + i) * samples;
        for (std::size_t p = 0; p < packets; ++p) {
          const std::size_t live = std::min<std::size_t>(16, samples - 16 * p);
          for (int k = 0; k < 16; ++k) {
            const float a = centre + us[16 * p + k], b = vs[16 * p + k];
            // The kernels' own operations (kernels/geometry/samples.h): the same rays to the bit.
            const float a_ahead = a * group.d0.w, b_ahead = b * group.d0.w;
            packet.ray.org_x[k] =
                group.origin.x + std::fma(b, group.ov.x, std::fma(b_ahead, group.dv.x, a_ahead * group.du.x));
            packet.ray.org_y[k] =
                group.origin.y + std::fma(b, group.ov.y, std::fma(b_ahead, group.dv.y, a_ahead * group.du.y));
            packet.ray.org_z[k] =
                group.origin.z + std::fma(b, group.ov.z, std::fma(b_ahead, group.dv.z, a_ahead * group.du.z));
            packet.ray.dir_x[k] = std::fma(b, group.dv.x, std::fma(a, group.du.x, group.d0.x));
            packet.ray.dir_y[k] = std::fma(b, group.dv.y, std::fma(a, group.du.y, group.d0.y));
            packet.ray.dir_z[k] = std::fma(b, group.dv.z, std::fma(a, group.du.z, group.d0.z));
            packet.ray.tnear[k] = 0.0f;
            packet.ray.tfar[k] = k < static_cast<int>(live) ? kInfinity : kNoRay;
            packet.ray.time[k] = 0.0f;
            packet.ray.mask[k] = 0xFFFFFFFFu;
            packet.ray.flags[k] = 0;
            packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
            packet.hit.primID[k] = RTC_INVALID_GEOMETRY_ID;
            packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
            valid[k] = k < static_cast<int>(live) ? -1 : 0;
          }
          if (mode == EmbreeMode::single) {
            for (std::size_t k = 0; k < live; ++k) {
              RTCRayHit one;
              one.ray = rtcGetRayFromRayN(reinterpret_cast<RTCRayN*>(&packet.ray), 16, static_cast<unsigned>(k));
              one.hit.geomID = one.hit.primID = one.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
              rtcIntersect1(scene, &context, &one);
              const bool hit = one.hit.geomID != RTC_INVALID_GEOMETRY_ID;
              out[16 * p + k] = {hit && flat ? 0u : one.hit.instID[0], one.hit.primID};
            }
          } else {
            rtcIntersect16(valid, scene, &context, &packet);
            for (std::size_t k = 0; k < live; ++k) {
              const bool hit = packet.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID;
              out[16 * p + k] = {hit && flat ? 0u : packet.hit.instID[0][k], packet.hit.primID[k]};
            }
          }
        }
      }
    }
  });
}

void EmbreeBaseline::shadow(const ShadowRays& rays, EmbreeMode mode, int threads, RayResult* result) const {
  const RTCScene scene = impl_->flat ? impl_->trees[0] : impl_->top;
  const std::size_t count = rays.x.size();
  in_parallel(count, 4096, threads, [&](std::size_t begin, std::size_t end) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = mode == EmbreeMode::packet16_coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                                          : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    alignas(64) RTCRay16 packet;
    alignas(64) int valid[16];
    for (std::size_t first = begin; first < end; first += 16) {
      const std::size_t live = std::min<std::size_t>(16, end - first);
      fill_packet(rays, first, live, packet, valid);
      if (mode == EmbreeMode::single) {
        for (std::size_t k = 0; k < live; ++k) {
          if (!valid[k]) {
            result[first + k] = {0, 0};
            continue;
          }
          RTCRay one = rtcGetRayFromRayN(reinterpret_cast<RTCRayN*>(&packet), 16, static_cast<unsigned>(k));
          rtcOccluded1(scene, &context, &one);
          result[first + k] = {one.tfar < 0 ? RC_NONE : 0u, 0};
        }
      } else {
        rtcOccluded16(valid, scene, &context, &packet);
        for (std::size_t k = 0; k < live; ++k) result[first + k] = {valid[k] && packet.tfar[k] < 0 ? RC_NONE : 0u, 0};
      }
    }
  });
}

void EmbreeBaseline::closest(const ShadowRays& rays, EmbreeMode mode, int threads, RayResult* result) const {
  const RTCScene scene = impl_->flat ? impl_->trees[0] : impl_->top;
  const bool flat = impl_->flat;
  in_parallel(rays.x.size(), 4096, threads, [&](std::size_t begin, std::size_t end) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = mode == EmbreeMode::packet16_coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                                          : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    alignas(64) RTCRayHit16 packet;
    alignas(64) int valid[16];
    for (std::size_t first = begin; first < end; first += 16) {
      const std::size_t live = std::min<std::size_t>(16, end - first);
      fill_packet(rays, first, live, packet.ray, valid);
      for (int k = 0; k < 16; ++k)
        packet.hit.geomID[k] = packet.hit.primID[k] = packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
      if (mode != EmbreeMode::single) rtcIntersect16(valid, scene, &context, &packet);
      for (std::size_t k = 0; k < live; ++k) {
        if (mode == EmbreeMode::single && valid[k]) {
          RTCRayHit one;
          one.ray = rtcGetRayFromRayN(reinterpret_cast<RTCRayN*>(&packet.ray), 16, static_cast<unsigned>(k));
          one.hit.geomID = one.hit.primID = one.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
          rtcIntersect1(scene, &context, &one);
          const bool hit = one.hit.geomID != RTC_INVALID_GEOMETRY_ID;
          result[first + k] = {hit && flat ? 0u : one.hit.instID[0], one.hit.primID};
          continue;
        }
        const bool hit = packet.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID;
        result[first + k] = {hit && flat ? 0u : packet.hit.instID[0][k], packet.hit.primID[k]};
      }
    }
  });
}

void EmbreeBaseline::to_scene(RayResult* results, std::size_t count) const {
  for (std::size_t i = 0; i < count; ++i)
    if (results[i].instance == RC_NONE)
      continue;
    else if (!impl_->merged.empty())
      results[i] = impl_->merged[results[i].primitive];
    else
      results[i].primitive = impl_->primitive[impl_->tree_of_instance[results[i].instance]][results[i].primitive];
}

}  // namespace raycube::bench
