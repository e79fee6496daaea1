// Matter as a sum of lobes, each a shape that knows no wavelength times a curve, so that it costs no bands:
// - shapes whose parameters change with wavelength: given at some wavelengths, the nodes, and linear between two of
//   them in what is scattered, not in the parameters; beyond the first and the last as there;
// - shapes whose form depends on the material's curve (Hapke's): at nodes of the curve's value, polynomials between;
// - a gloss by Fresnel's law (fresnel.h).
#pragma once

#include <utility>
#include <vector>

#include "scene_compiler/compiled_scene.h"

namespace raycube::scene {

/// Share of node `node` (0 is the first) in light of a wavelength: a hat. 1 where the shape is the same everywhere.
double node_share(const std::vector<ShapeNode>& nodes, std::size_t node, double wavelength_um);

/// Gives a material whose shape's form depends on its curve the nodes of that: Chebyshev's in sqrt(1 - value), as many
/// as bring what lies between them to 5e-4, RC_MOST_NODES at most.
void take_nodes_of_curve(Material& material);

/// Linear between a curve's wavelengths, its ends beyond them.
double value_at(const Curve& curve, double wavelength_um);

/// Makes what follows from a material's nodes: the curves of the first ones, and the further lobes.
void make_lobes(Material& material);

/// The most further lobes that a material of the scene has, beyond the first of its front and of its gloss.
std::size_t most_further(const CompiledScene& scene);

/// The shapes by which a material's reflectance, or its gloss, is spread, each with its curve.
struct ShapeAndCurve {
  const Shape& shape;
  const Curve& curve;
};
std::vector<ShapeAndCurve> front_parts(const Material& material);
std::vector<ShapeAndCurve> gloss_parts(const Material& material);

inline bool is_gloss(const Shape& shape) { return rc_shape_role(shape.number) == RC_ROLE_gloss; }

/// Whether two materials spread what they reflect alike.
bool reflect_alike(const Material& a, const Material& b);
bool gloss_alike(const Material& a, const Material& b);

/// Two materials of different gloss that are mixed in one surface; null: none.
struct GlossClash {
  const Material *first = nullptr, *other = nullptr;
};
GlossClash gloss_clash(const CompiledScene& scene);

}  // namespace raycube::scene
