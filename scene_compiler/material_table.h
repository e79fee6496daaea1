// The scene's materials by name, and the surfaces made of them.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene_compiler/compiled_scene.h"
#include "scene_compiler/document.h"
#include "scene_compiler/relief.h"
#include "scene_compiler/texture.h"

namespace raycube::scene {

/// What a material is to cover: a mesh may have texture coordinates, a panel (a plane, a box's face) a relief in m;
/// nothing where it is only named.
enum class Covers { shape, panel, mesh, nothing };

/// The images of a material that lie by texture coordinates; null: it has none.
struct CoordinateImages {
  const Texture* texture = nullptr;
  const Texture* mask = nullptr;
  const Relief* relief = nullptr;
  bool any() const { return texture != nullptr || mask != nullptr || relief != nullptr; }
};

class MaterialTable {
 public:
  /// Reads every [[material]]; problems name their places.
  MaterialTable(const Record& root, base::Problems& problems);

  /// Surface of one pure material. An unknown name is reported with the nearest known one, and 0 returned; so is a
  /// material that only meshes can have.
  std::uint32_t surface(const std::string& name, const base::Where& where, base::Problems& problems,
                        Covers covers = Covers::shape) const;

  /// Images of a pure material's surface.
  CoordinateImages images(std::uint32_t surface) const;
  /// Surface of the member, from 0, of a family whose first member's surface this is.
  static std::uint32_t member(std::uint32_t surface, std::uint32_t number) { return surface + number; }

  /// Surface of a place on matter of this surface, by the textures of its materials: of a family the member that lies
  /// there. u_m, v_m: Texture::at's.
  std::uint32_t at(std::uint32_t surface, double u_m, double v_m);
  /// Side of the smallest texel of its materials, m; 0: none has a texture that lies by metres.
  double texel_m(std::uint32_t surface) const;
  /// Relief of a pure material's surface; null: it has none.
  const Relief* relief(std::uint32_t surface) const;

  /// Surface of an area mix of up to four materials (surface index, fraction > 0, sum 1); equal mixes share
  /// one.
  std::uint32_t mix(const std::vector<std::pair<std::uint32_t, double>>& parts);
  /// Whether all of them reflect by one shape, as the parts of one surface must.
  bool reflect_alike(const std::vector<std::pair<std::uint32_t, double>>& parts) const;

  /// Moves materials and surfaces into the scene; the first surfaces are the pure materials, in order.
  void move_to(CompiledScene& scene);

 private:
  void add(const std::string& name, std::vector<Material> members);
  void check_cover(const std::string& name, std::uint32_t surface, const base::Where& where, Covers covers,
                   base::Problems& problems) const;

  std::vector<Material> materials_;
  std::uint64_t roles_ = 0;  ///< most curves of a material
  std::map<std::string, std::uint32_t> index_;
  std::map<std::uint32_t, Texture> textures_, masks_;  ///< by the (first member's) index
  std::map<std::uint32_t, Relief> reliefs_;            ///< likewise
  std::vector<shared::Surface> surfaces_;
  std::map<std::array<std::uint32_t, 8>, std::uint32_t> mixes_;
};

}  // namespace raycube::scene
