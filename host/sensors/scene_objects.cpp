#include "host/sensors/scene_objects.h"

#include <algorithm>
#include <bit>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <span>

#include "host/base/interrupt.h"
#include "scene_compiler/matter.h"

namespace raycube::sensors {

namespace {

using glm::dvec3;

/// A surface with more triangles in one mesh is told to be a texture: telling its parts apart takes a second a million.
constexpr std::size_t kMostTriangles = std::size_t{1} << 21;
/// However a box is turned, the middle one of its placed extents is no less than this part of its own.
constexpr double kLeastTurned = 0.5;
constexpr std::uint64_t kOfMesh = std::uint64_t{1} << 32;  ///< kinds that are meshes, beside those that are materials

struct Box {
  dvec3 lo{1e300}, hi{-1e300};
  void add(const dvec3& p) { lo = glm::min(lo, p), hi = glm::max(hi, p); }
  /// The middle one of its three extents: a pole is as wide as it is thick.
  double width() const {
    const dvec3 size = hi - lo;
    std::array<double, 3> extent{size.x, size.y, size.z};
    std::sort(extent.begin(), extent.end());
    return extent[1];
  }
};

dvec3 placed(const shared::Instance& at, const dvec3& p) {
  const auto row = [&](const shared::rc_float4& r) {
    return double{r.x} * p.x + double{r.y} * p.y + double{r.z} * p.z + double{r.w};
  };
  return {row(at.world_from_local_0), row(at.world_from_local_1), row(at.world_from_local_2)};
}

std::array<dvec3, 3> local_triangle(const scene::CompiledScene& scene, std::uint32_t primitive) {
  const shared::TriBlock& b = scene.blocks[primitive / 16];
  const std::uint32_t i = primitive % 16;
  return {{{b.v0_x[i], b.v0_y[i], b.v0_z[i]}, {b.v1_x[i], b.v1_y[i], b.v1_z[i]}, {b.v2_x[i], b.v2_y[i], b.v2_z[i]}}};
}

struct Corner {
  float x, y, z;
  bool operator==(const Corner&) const = default;
};

/// The first triangle at each corner, by place.
class FirstAtCorner {
 public:
  /// Forgets all, and makes room for the corners of so many triangles: three each at most, so that it is never full.
  void begin(std::size_t triangles) {
    slot_.assign(std::bit_ceil(4 * triangles + 1), RC_NONE);
    entry_.clear();
  }

  /// Files triangle t at a corner that nothing has been filed at.
  std::uint32_t of(const Corner& corner, std::uint32_t t) {
    std::uint64_t h = 0;
    for (const float f : {corner.x, corner.y, corner.z})
      h = (h ^ std::bit_cast<std::uint32_t>(f + 0.0f)) * 0x9e3779b97f4a7c15ull, h ^= h >> 29;
    for (std::size_t i = h & (slot_.size() - 1);; i = (i + 1) & (slot_.size() - 1)) {
      if (slot_[i] == RC_NONE) {
        slot_[i] = static_cast<std::uint32_t>(entry_.size());
        entry_.push_back({corner, t});
        return t;
      }
      if (entry_[slot_[i]].corner == corner) return entry_[slot_[i]].triangle;
    }
  }

 private:
  struct Entry {
    Corner corner;
    std::uint32_t triangle;
  };
  std::vector<std::uint32_t> slot_;
  std::vector<Entry> entry_;
};

/// Triangles that hang together by shared corners, lot by lot: each lot in ascending order, lots in the order of their
/// first triangle.
struct Lots {
  std::vector<std::uint32_t> triangles;
  std::vector<std::size_t> end;  ///< of each lot
};

/// What connected() writes on: kept from surface to surface, since fresh pages cost as much as what is done in them.
struct ConnectedScratch {
  std::vector<std::uint32_t> parent, lot;
  std::vector<std::size_t> next;
  FirstAtCorner first;
};

Lots connected(const scene::CompiledScene& scene, std::span<const std::uint32_t> triangles, ConnectedScratch& scratch) {
  auto& [parent, lot, next, first] = scratch;
  parent.resize(triangles.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&parent = parent](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  first.begin(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const shared::TriBlock& at = scene.blocks[triangles[t] / 16];
    const std::uint32_t i = triangles[t] % 16;
    for (const Corner& corner : {Corner{at.v0_x[i], at.v0_y[i], at.v0_z[i]}, Corner{at.v1_x[i], at.v1_y[i], at.v1_z[i]},
                                 Corner{at.v2_x[i], at.v2_y[i], at.v2_z[i]}}) {
      const std::uint32_t a = root(first.of(corner, t)), b = root(t);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  Lots out;  // a lot's root is its first triangle
  lot.resize(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const std::uint32_t of = root(t);
    if (of == t)
      lot[t] = static_cast<std::uint32_t>(out.end.size()), out.end.push_back(0);
    else
      lot[t] = lot[of];
    ++out.end[lot[t]];
  }
  next.assign(out.end.size(), 0);
  for (std::size_t l = 1; l < out.end.size(); ++l) next[l] = out.end[l - 1], out.end[l] += out.end[l - 1];
  out.triangles.resize(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) out.triangles[next[lot[t]]++] = triangles[t];
  return out;
}

std::string name_of_kind(const scene::CompiledScene& scene, std::uint64_t kind) {
  if (kind & kOfMesh) return scene.meshes[static_cast<std::uint32_t>(kind)].name;
  return kind > 0 ? scene.materials[kind - 1].name : "nothing";
}

class Collector {
 public:
  Collector(const scene::CompiledScene& scene, double widest_m)
      : scene_(scene), widest_m_(widest_m), triangles_(scene) {}

  void collect() {
    const std::vector<scene::Placement> placements = scene::placements(scene_);
    std::vector<std::uint32_t> times(scene_.meshes.size(), 0);
    for (const auto& placement : placements) ++times[placement.mesh];
    for (const scene::Placement& placement : placements) {
      base::throw_if_interrupted();
      if (std::binary_search(scene_.buried.begin(), scene_.buried.end(), placement.number)) continue;  // nobody sees it
      const std::uint32_t mesh = placement.mesh;
      const bool again = times[mesh] > 1;
      if (add_whole(placement, again ? kOfMesh | mesh : first_kind(mesh))) continue;
      if (!again) {
        add_once(placement);
        continue;
      }
      auto known = parts_.find(mesh);
      if (known == parts_.end()) known = parts_.emplace(mesh, surfaces_of(mesh)).first;
      for (SurfaceParts& surface : known->second) add_parts(placement, surface);
    }
  }

  SceneObjects finish() {
    SceneObjects out;
    for (auto& object : objects_)
      if (count_[object.kind] <= kMostOfAKind) out.objects.push_back(std::move(object));
    for (const auto& [kind, count] : count_)
      if (count > kMostOfAKind) out.textures.push_back(kind_name(kind));
    for (const std::uint64_t kind : unread_)
      if (count_[kind] <= kMostOfAKind) out.textures.push_back(kind_name(kind));
    return out;
  }

 private:
  struct Part {
    Box local;
    std::size_t first = 0, count = 0;  ///< of its triangles
  };
  /// The connected parts of one surface of a mesh.
  struct SurfaceParts {
    std::uint64_t kind = 0;
    double narrowest_m = 1e300;  ///< least width of a part, mesh frame
    std::vector<Part> parts;
    std::vector<std::uint32_t> triangles;  ///< part by part
  };

  /// A surface's kind: the material that it has most of. Mixtures of a class map are many surfaces of few
  /// materials.
  std::uint64_t kind_of(std::uint32_t surface) const {
    const shared::Surface& mixed = scene_.surfaces[surface];
    const auto most =
        std::max_element(std::begin(mixed.fraction), std::end(mixed.fraction)) - std::begin(mixed.fraction);
    return mixed.material[most] > 0 ? scene::family_surface(scene_, mixed.material[most] - 1) + 1 : 0;
  }
  std::uint64_t first_kind(std::uint32_t mesh) const {
    const auto triangles = triangles_.of(mesh);
    return triangles.empty() ? 0 : kind_of(scene::surface_of(scene_, triangles.front()));
  }

  std::string kind_name(std::uint64_t kind) const { return name_of_kind(scene_, kind); }

  /// Files an object; of a kind that has too many only the count goes on.
  void add(const scene::Placement& placement, std::uint64_t kind, const Box& local,
           std::span<const std::uint32_t> triangles) {
    if (++count_[kind] > kMostOfAKind) return;
    SceneObject& object = objects_.emplace_back();
    object.placement = placement, object.kind = kind;
    Box world;
    for (std::size_t c = 0; c < 8; ++c) {
      object.corners_m[c] =
          placed(scene_.instances[placement.instance],
                 {c & 1 ? local.hi.x : local.lo.x, c & 2 ? local.hi.y : local.lo.y, c & 4 ? local.hi.z : local.lo.z});
      world.add(object.corners_m[c]);
    }
    object.lo_m = world.lo, object.hi_m = world.hi;
    if (triangles.size() <= kFewTriangles) object.triangles.assign(triangles.begin(), triangles.end());
  }

  /// How wide a box is once it is placed.
  double placed_width(std::uint32_t instance, const Box& local) const {
    Box world;
    for (std::size_t c = 0; c < 8; ++c)
      world.add(placed(scene_.instances[instance], {c & 1 ? local.hi.x : local.lo.x, c & 2 ? local.hi.y : local.lo.y,
                                                    c & 4 ? local.hi.z : local.lo.z}));
    return world.width();
  }

  bool add_whole(const scene::Placement& placement, std::uint64_t kind) {
    const scene::Mesh& mesh = scene_.meshes[placement.mesh];
    Box local;
    local.add({mesh.lo[0], mesh.lo[1], mesh.lo[2]}), local.add({mesh.hi[0], mesh.hi[1], mesh.hi[2]});
    if (mesh.triangle_count() == 0) return true;
    if (placed_width(placement.instance, local) > widest_m_) return false;
    add(placement, kind, local, triangles_.of(placement.mesh));
    return true;
  }

  /// A mesh's triangles, surface by surface, a family's members as one: those with more than kMostTriangles are only
  /// counted.
  struct BySurface {
    struct Surface {
      std::uint32_t number = 0;
      std::size_t first = 0, count = 0;  ///< in `triangles`
    };
    std::vector<Surface> surfaces;  ///< ascending
    std::vector<std::uint32_t> triangles;
    std::span<const std::uint32_t> of(const Surface& surface) const {
      return std::span(triangles).subspan(surface.first, surface.count);
    }
  };
  BySurface triangles_by_surface(std::uint32_t mesh) const {
    const auto all = triangles_.of(mesh), number = triangles_.surfaces_of(mesh);
    std::map<std::uint32_t, std::size_t> count;
    std::size_t* same = nullptr;
    for (std::size_t t = 0; t < all.size(); ++t) {
      if (t == 0 || number[t] != number[t - 1]) same = &count[scene::family_surface(scene_, number[t])];
      ++*same;
    }
    BySurface out;
    std::map<std::uint32_t, std::size_t> next;
    std::size_t end = 0;
    for (const auto& [surface, triangles] : count) {
      out.surfaces.push_back({surface, end, triangles});
      if (triangles <= kMostTriangles) next[surface] = end, end += triangles;
    }
    out.triangles.resize(end);
    auto at = next.end();
    for (std::size_t t = 0; t < all.size(); ++t) {
      if (t == 0 || number[t] != number[t - 1]) at = next.find(scene::family_surface(scene_, number[t]));
      if (at != next.end()) out.triangles[at->second++] = all[t];
    }
    return out;
  }

  /// No parts where the surface is a texture already, or has too many triangles to look.
  SurfaceParts parts_of(const BySurface& mesh, const BySurface::Surface& surface) {
    base::throw_if_interrupted();
    SurfaceParts of;
    of.kind = kind_of(surface.number);
    if (surface.count > kMostTriangles) unread_.insert(of.kind);
    if (surface.count > kMostTriangles || count_[of.kind] > kMostOfAKind) return of;
    Lots lots = connected(scene_, mesh.of(surface), scratch_);
    of.triangles = std::move(lots.triangles);
    std::size_t next = 0;
    for (const std::size_t end : lots.end) {
      Part& part = of.parts.emplace_back();
      part.first = next, part.count = end - next;
      for (; next < end; ++next)
        for (const dvec3& p : local_triangle(scene_, of.triangles[next])) part.local.add(p);
      of.narrowest_m = std::min(of.narrowest_m, part.local.width());
    }
    return of;
  }

  /// Parts of a mesh that is placed again.
  std::vector<SurfaceParts> surfaces_of(std::uint32_t mesh) {
    std::vector<SurfaceParts> out;
    const BySurface by_surface = triangles_by_surface(mesh);
    for (const auto& surface : by_surface.surfaces) out.push_back(parts_of(by_surface, surface));
    return out;
  }

  /// A mesh that is placed once. Its small surfaces come first: the mixtures of a class map's edges soon say that a
  /// kind is a texture, and its large surfaces need no look. Objects are filed surface by surface all the same.
  void add_once(const scene::Placement& placement) {
    const BySurface by_surface = triangles_by_surface(placement.mesh);
    std::vector<BySurface::Surface> order = by_surface.surfaces;
    std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.count < b.count; });
    const std::size_t before = objects_.size();
    std::map<std::uint32_t, std::vector<SceneObject>> found;
    for (const auto& surface : order) {
      SurfaceParts parts = parts_of(by_surface, surface);
      add_parts(placement, parts);
      if (objects_.size() == before) continue;
      found[surface.number] = {std::make_move_iterator(objects_.begin() + static_cast<std::ptrdiff_t>(before)),
                               std::make_move_iterator(objects_.end())};
      objects_.resize(before);
    }
    for (auto& [surface, objects] : found)
      objects_.insert(objects_.end(), std::make_move_iterator(objects.begin()), std::make_move_iterator(objects.end()));
  }

  /// The least a placement scales by, m per m of the mesh's frame.
  double least_scale(std::uint32_t instance) const {
    const shared::Instance& at = scene_.instances[instance];
    const dvec3 origin = placed(at, dvec3(0));
    return std::min({glm::length(placed(at, {1, 0, 0}) - origin), glm::length(placed(at, {0, 1, 0}) - origin),
                     glm::length(placed(at, {0, 0, 1}) - origin)});
  }

  void add_parts(const scene::Placement& placement, SurfaceParts& surface) {
    std::size_t& count = count_[surface.kind];
    if (count > kMostOfAKind) surface.parts = {}, surface.triangles = {};  // a texture by now
    if (surface.parts.empty() || kLeastTurned * least_scale(placement.instance) * surface.narrowest_m > widest_m_)
      return;
    for (const Part& part : surface.parts) {
      if (count > kMostOfAKind) break;
      if (placed_width(placement.instance, part.local) <= widest_m_)
        add(placement, surface.kind, part.local, std::span(surface.triangles).subspan(part.first, part.count));
    }
  }

  const scene::CompiledScene& scene_;
  double widest_m_;
  scene::MeshTriangles triangles_;
  std::vector<SceneObject> objects_;
  std::map<std::uint64_t, std::size_t> count_;
  std::map<std::uint32_t, std::vector<SurfaceParts>> parts_;  ///< of meshes that are placed again
  ConnectedScratch scratch_;
  std::set<std::uint64_t> unread_;  ///< kinds with a surface of too many triangles
};

}  // namespace

SceneObjects small_scene_objects(const scene::CompiledScene& scene, double widest_m) {
  Collector collector(scene, widest_m);
  collector.collect();
  return collector.finish();
}

std::shared_ptr<const SceneObjects> KnownObjects::small(double widest_m) {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<const SceneObjects>& known = small_[widest_m];
  if (!known) known = std::make_shared<const SceneObjects>(small_scene_objects(scene_, widest_m));
  return known;
}

std::array<dvec3, 3> triangle_of(const scene::CompiledScene& scene, std::uint32_t instance, std::uint32_t primitive) {
  std::array<dvec3, 3> corners = local_triangle(scene, primitive);
  for (dvec3& p : corners) p = placed(scene.instances[instance], p);
  return corners;
}

std::string object_name(const scene::CompiledScene& scene, const SceneObject& object) {
  const std::string& name = scene.meshes[object.placement.mesh].name;
  if (object.kind & kOfMesh) return name + ", placement " + std::to_string(object.placement.number);
  return name + " (" + name_of_kind(scene, object.kind) + ")";
}

}  // namespace raycube::sensors
