// What a triangle is made of, asked in one place: its surface, the materials mixed in that, and the curves they own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "kernels/shared/product_key.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::scene {

/// Number of the surface of primitive `block * RC_BLOCK + lane`; RC_NONE in a lane without a triangle.
inline std::uint32_t surface_of(const CompiledScene& scene, std::uint32_t primitive) {
  return scene.blocks[primitive / RC_BLOCK].surface[primitive % RC_BLOCK];
}

/// What primitive `block * RC_BLOCK + lane` is made of.
inline const shared::Surface& matter_of(const CompiledScene& scene, std::uint32_t primitive) {
  return scene.surfaces[surface_of(scene, primitive)];
}

inline std::uint32_t material_count(const CompiledScene& scene) {
  return static_cast<std::uint32_t>(scene.materials.size());
}

/// Which of the materials that the user named, counted from 0 in the file's order, each material is: members of a
/// family are one.
std::vector<std::uint32_t> named_materials(const CompiledScene& scene);
/// How many those are.
std::size_t named_count(const CompiledScene& scene);

/// Materials (indices, ascending) that some placed triangle carries; all of them in a scene without triangles. Only
/// their curves must cover what an instrument sees.
std::vector<std::uint32_t> used_materials(const CompiledScene& scene);
/// The same, of each family the first used member alone: what its members share is asked of one.
std::vector<std::uint32_t> used_families(const CompiledScene& scene);

/// Calls f(material's index, its share of the area) for each material of a surface.
template <class F>
void for_each_material(const shared::Surface& surface, F&& f) {
  for (int i = 0; i < 4; ++i)
    if (surface.material[i] != 0) f(static_cast<std::size_t>(surface.material[i] - 1), surface.fraction[i]);
}

/// The narrowest gloss that cameras see: below it single precision and the sun as a point would show.
inline constexpr double kLeastRoughness = 0.1;

/// Records for further lobes in surface_lobes: most of any material, up to a multiple of 8, so that kernels are not
/// compiled anew for each number of them.
std::size_t further_records(const CompiledScene& scene);
/// Records of a surface in surface_lobes.
std::size_t lobe_records(const CompiledScene& scene);
/// Calls place(record, shape, share of the area) for each lobe of a surface; more than once for one that its materials
/// share, whose shares then are of each of them (what lets light through) or 1.
void for_each_lobe(const CompiledScene& scene, const shared::Surface& surface,
                   const std::function<void(std::size_t, const Shape&, double)>& place);

/// Shapes of every surface, [surface][lobe_records(scene)]; behind them their tables, each once, to which a
/// record's first two parameters then count floats from the beginning of all (kernels/materials/measured.h). Materials
/// mixed in one surface share what they reflect by one shape. copies: of each surface's records, one after the other,
/// whose shares are multiplied by factor(copy, surface, record, its shape).
using LobeFactor = std::function<double(std::size_t, const shared::Surface&, std::size_t, const Shape&)>;
std::vector<shared::Lobe> surface_lobes(const CompiledScene& scene, std::size_t copies = 1,
                                        const LobeFactor& factor = {});

/// The first used material that does not reflect by Lambert's law; null: none.
const Material* first_shaped(const CompiledScene& scene);

/// Whether what falls onto the other side of a material goes to all sides: a leaf.
bool lets_light_through(const Material& material);
/// Whether it goes straight on: a plate. Pulses see it, and cameras along paths (docs/light.md).
bool is_plate(const Material& material);
bool is_plate(const CompiledScene& scene, std::uint32_t primitive);
/// The same of any of a primitive's materials.
bool lets_light_through(const CompiledScene& scene, std::uint32_t primitive);

/// The gloss of what a primitive is made of; none. Of materials mixed in one surface cameras take one gloss at most
/// (plan::check_curves).
const Shape* gloss_of(const CompiledScene& scene, std::uint32_t primitive);

/// Its further lobe of a number; null where its materials have none. Materials mixed in one surface share their shapes.
const FurtherLobe* further_of(const CompiledScene& scene, std::uint32_t primitive, std::size_t number);

/// What the matter of a scene asks of a camera's kernels.
struct CameraMatter {
  bool shaped = false;          ///< some used material does not reflect by Lambert's law, or is glossy too
  bool through = false;         ///< some lets light through, to all sides
  bool plates = false;          ///< some lets it straight on; then it counts as shaped, so that ways are known
  bool glossy = false;          ///< some has a gloss beside what it reflects
  int further = 0;              ///< beyond the first of shapes that change with wavelength: most of any material
  int further_records = 0;      ///< for them in surface_lobes
  std::uint32_t materials = 0;  ///< of the scene
  /// Slots of a sample: the near side, the far one where matter lets light through, the near one's gloss where some is,
  /// and the further lobes of what is seen.
  int sides() const { return 1 + int{through} + int{glossy} + further; }
};
CameraMatter camera_matter(const CompiledScene& scene);

/// surface_lobes as cameras take them: no gloss narrower than kLeastRoughness, which pulses may know. One record, of no
/// meaning, where all reflect by Lambert's law and let nothing through.
std::vector<shared::Lobe> camera_lobes(const CompiledScene& scene);
/// A gloss, or another shape, as cameras take it.
Shape as_cameras_see(Shape shape);

/// Curves by which cameras see the used materials, ascending: reflectances, where any is a leaf or a plate the
/// transmittances of all, since they may share surfaces, and where any is glossy the glosses of all; those of materials
/// without count as zero.
std::vector<std::uint32_t> seen_curves(const CompiledScene& scene);

/// Roles of a material's curves: the last of them may be nobody's (further_records). Curves are numbered from 1, see
/// kernels/shared/product_key.h.
std::uint32_t curve_roles(const CompiledScene& scene);
inline std::uint32_t curve_count(const CompiledScene& scene) { return curve_roles(scene) * material_count(scene); }

/// Id of a material's reflectance.
inline std::uint32_t reflectance_curve(const CompiledScene& scene, std::size_t material) {
  return rc_curve_id(RC_CURVE_REFLECTANCE, static_cast<std::uint32_t>(material), material_count(scene));
}

inline std::uint32_t gloss_curve(const CompiledScene& scene, std::size_t material) {
  return rc_curve_id(RC_CURVE_GLOSS, static_cast<std::uint32_t>(material), material_count(scene));
}

/// Of a material's further lobe.
inline std::uint32_t further_curve(const CompiledScene& scene, std::size_t material, std::size_t number) {
  return rc_curve_id(RC_CURVE_FURTHER + static_cast<std::uint32_t>(number), static_cast<std::uint32_t>(material),
                     material_count(scene));
}

inline std::uint32_t transmittance_curve(const CompiledScene& scene, std::size_t material) {
  return rc_curve_id(RC_CURVE_TRANSMITTANCE, static_cast<std::uint32_t>(material), material_count(scene));
}

/// Index of the material that owns a curve, 1 <= curve <= curve_count.
inline std::uint32_t material_of_curve(const CompiledScene& scene, std::uint32_t curve) {
  return rc_curve_material(curve, material_count(scene));
}

/// 1 at every wavelength: what a gloss is multiplied by, whose own form holds its reflectance.
const Curve& white_curve();

/// What light is multiplied by under a curve's key: of shapes that change with wavelength the first node's part. Empty
/// of a term that the material does not have.
const Curve& curve_of(const CompiledScene& scene, std::uint32_t curve);

/// Whether a curve is of what a material reflects (by its gloss): its own, or of a term of that.
bool is_of_front(const CompiledScene& scene, std::uint32_t curve);
bool is_of_gloss(const CompiledScene& scene, std::uint32_t curve);

/// Whether light goes to a camera by a curve: by the transmittance of a leaf, a glossy material's gloss, a term.
bool carries_light(const CompiledScene& scene, std::uint32_t curve);

}  // namespace raycube::scene
