#include "host/reference/embree_scene.h"

#include <embree3/rtcore.h>

#include <limits>
#include <string>
#include <vector>

#include "host/base/error.h"
#include "scene_compiler/matter.h"

namespace raycube::reference {

namespace {

/// Owner of a reference-counted Embree handle.
template <typename Handle, void (*release)(Handle)>
struct Owner {
  Handle handle = nullptr;
  Owner() = default;
  explicit Owner(Handle h) : handle(h) {}
  Owner(Owner&& other) noexcept : handle(other.handle) { other.handle = nullptr; }
  Owner& operator=(Owner&&) = delete;
  ~Owner() {
    if (handle) release(handle);
  }
};
using Device = Owner<RTCDevice, rtcReleaseDevice>;
using Scene = Owner<RTCScene, rtcReleaseScene>;
using Geometry = Owner<RTCGeometry, rtcReleaseGeometry>;

void check(RTCDevice device, const char* doing) {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_NONE) return;
  throw base::Error(base::Fault::environment,
                    std::string("Embree failed while ") + doing + " (error " + std::to_string(static_cast<int>(error)) +
                        "); the reference needs libembree3-3 and memory for the scene: see `raycube info`");
}

RTCScene new_scene(RTCDevice device) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
  return scene;
}

}  // namespace

struct EmbreeScene::Impl {
  Device device;
  std::vector<Scene> trees;
  std::vector<std::vector<std::uint32_t>> primitive;  ///< [tree][Embree's primID] = block * 16 + lane
  std::vector<std::uint32_t> tree_of_instance;
  Scene top;
};

EmbreeScene::EmbreeScene(const scene::CompiledScene& scene) : impl_(std::make_unique<Impl>()) {
  impl_->device.handle = rtcNewDevice(nullptr);
  const RTCDevice device = impl_->device.handle;
  check(device, "starting");
  for (const scene::Tree& tree : scene.trees) {
    std::vector<std::uint32_t>& names = impl_->primitive.emplace_back();
    for (std::uint32_t p = tree.first_block * RC_BLOCK; p < (tree.first_block + tree.block_count) * RC_BLOCK; ++p)
      if (scene::surface_of(scene, p) != RC_NONE) names.push_back(p);
    impl_->trees.emplace_back(new_scene(device));
    const Geometry geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry.handle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, names.size() * 3));
    auto* indices = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry.handle, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, names.size()));
    check(device, "allocating a tree");
    for (std::size_t i = 0; i < names.size(); ++i) {
      const shared::TriBlock& b = scene.blocks[names[i] / RC_BLOCK];
      const std::uint32_t k = names[i] % RC_BLOCK;
      const float corners[9] = {b.v0_x[k], b.v0_y[k], b.v0_z[k], b.v1_x[k], b.v1_y[k],
                                b.v1_z[k], b.v2_x[k], b.v2_y[k], b.v2_z[k]};
      for (int c = 0; c < 9; ++c) vertices[9 * i + c] = corners[c];
      for (int c = 0; c < 3; ++c) indices[3 * i + c] = static_cast<std::uint32_t>(3 * i + c);
    }
    rtcCommitGeometry(geometry.handle);
    rtcAttachGeometryByID(impl_->trees.back().handle, geometry.handle, 0);
    rtcCommitScene(impl_->trees.back().handle);
    check(device, "building a tree");
  }
  impl_->top.handle = new_scene(device);
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const shared::Instance& placed = scene.instances[i];
    impl_->tree_of_instance.push_back(placed.tree);
    const Geometry geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(geometry.handle, impl_->trees[placed.tree].handle);
    const shared::rc_float4 rows[3] = {placed.world_from_local_0, placed.world_from_local_1, placed.world_from_local_2};
    float matrix[12];
    for (int r = 0; r < 3; ++r) {
      matrix[4 * r] = rows[r].x;
      matrix[4 * r + 1] = rows[r].y;
      matrix[4 * r + 2] = rows[r].z;
      matrix[4 * r + 3] = rows[r].w;
    }
    rtcSetGeometryTransform(geometry.handle, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, matrix);
    rtcCommitGeometry(geometry.handle);
    rtcAttachGeometryByID(impl_->top.handle, geometry.handle, i);
  }
  rtcCommitScene(impl_->top.handle);
  check(device, "building the placed trees");
}

EmbreeScene::~EmbreeScene() = default;

namespace {

void fill(RTCRay& out, const Ray& ray) {
  out.org_x = ray.origin[0] + ray.offset[0], out.org_y = ray.origin[1] + ray.offset[1],
  out.org_z = ray.origin[2] + ray.offset[2];
  out.dir_x = ray.direction[0], out.dir_y = ray.direction[1], out.dir_z = ray.direction[2];
  out.tnear = 0;
  out.tfar = std::numeric_limits<float>::infinity();
  out.mask = 0xFFFFFFFFu;
  out.time = 0, out.id = 0, out.flags = 0;
}

}  // namespace

Hit EmbreeScene::intersect(const Ray& ray, float t_far) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit query;
  fill(query.ray, ray);
  query.ray.tfar = t_far;
  query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->top.handle, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const std::uint32_t instance = query.hit.instID[0];
  return {instance, impl_->primitive[impl_->tree_of_instance[instance]][query.hit.primID]};
}

bool EmbreeScene::occluded(const Ray& ray, float t_far) const {
  if (!(t_far > 0)) return false;  // Embree leaves such a ray as it is
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay query;
  fill(query, ray);
  query.tfar = t_far;
  rtcOccluded1(impl_->top.handle, &context, &query);
  return query.tfar < 0;
}

}  // namespace raycube::reference
