// Things of a scene that may be smaller than what the samples of a pixel see, known from their boxes before
// any ray.
//
// A placed mesh that is small is one object. Else each of its connected parts of one surface is (triangles
// that share corners), at each of its places: plates of a file that holds a whole test site, or the rare cells
// of a class map. A kind of object is its mesh (small, placed several times) or the material it has most of. A kind of
// more than kMostOfAKind objects is a texture (leaves, a forest, gravel): many pixels hold some, errors over pixels see
// them, and the ordinary samples serve them as they do anything else.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "scene_compiler/owner.h"

namespace raycube::sensors {

inline constexpr std::size_t kMostOfAKind = 4096;

struct SceneObject {
  scene::Placement placement;
  std::uint64_t kind = 0;
  glm::dvec3 lo_m{0}, hi_m{0};            ///< box, scene frame
  std::vector<std::uint32_t> triangles;   ///< its primitives; empty where they are more than kFewTriangles
  std::array<glm::dvec3, 8> corners_m{};  ///< of its box in the mesh's frame, placed
};

/// More than so many triangles and the box stands for them.
inline constexpr std::size_t kFewTriangles = 64;

struct SceneObjects {
  std::vector<SceneObject> objects;
  std::vector<std::string> textures;  ///< kinds left out: too many objects, or a surface of too many triangles to look
};

/// Every object whose box is at most `widest_m` wide in two of its three directions.
SceneObjects small_scene_objects(const scene::CompiledScene& scene, double widest_m);

/// A scene's objects, looked for once for each width: what the plan found the render does not look for again. From any
/// thread.
class KnownObjects {
 public:
  /// Keeps a reference.
  explicit KnownObjects(const scene::CompiledScene& scene) : scene_(scene) {}
  const scene::CompiledScene& scene() const { return scene_; }
  std::shared_ptr<const SceneObjects> small(double widest_m);

 private:
  const scene::CompiledScene& scene_;
  std::mutex mutex_;
  std::map<double, std::shared_ptr<const SceneObjects>> small_;
};

/// Corners of a primitive of a placed tree, scene frame.
std::array<glm::dvec3, 3> triangle_of(const scene::CompiledScene& scene, std::uint32_t instance,
                                      std::uint32_t primitive);

/// "plane 2", "tree, placement 17".
std::string object_name(const scene::CompiledScene& scene, const SceneObject& object);

}  // namespace raycube::sensors
