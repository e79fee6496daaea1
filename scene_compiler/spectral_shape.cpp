#include "scene_compiler/spectral_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "kernels/shared/product_key.h"
#include "scene_compiler/fresnel.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/shape_list.h"

namespace raycube::scene {

namespace {

constexpr double kProductError = 1e-4, kBetweenValues = 5e-4;
constexpr double kRootStep = 0.02;  ///< of sqrt(1 - value), between two wavelengths
constexpr int kMostHalvings = 12;
constexpr double kFirst_um = 0.05, kLast_um = 1000.0;  ///< a share holds wherever anybody may look

/// Wavelengths of a curve and of nodes, and as many between them as it takes for a curve times a share, both linear, to
/// be linear too, to kProductError of the curve's largest.
std::vector<double> wavelengths_of(const Curve& curve, const std::vector<ShapeNode>& nodes) {
  std::vector<double> ends = curve.wavelength_um;
  for (const ShapeNode& at : nodes)
    if (at.wavelength_um > ends.front() && at.wavelength_um < curve.wavelength_um.back())
      ends.push_back(at.wavelength_um);
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  const double most = std::max(1e-9, *std::max_element(curve.value.begin(), curve.value.end()));
  std::vector<double> out = {ends.front()};
  for (std::size_t i = 1; i < ends.size(); ++i) {
    const double a = ends[i - 1], b = ends[i], rise = std::abs(value_at(curve, b) - value_at(curve, a));
    double turn = 0;
    for (std::size_t node = 0; node < nodes.size(); ++node)
      turn = std::max(turn, std::abs(node_share(nodes, node, b) - node_share(nodes, node, a)));
    const int steps = std::max(1, static_cast<int>(std::ceil(std::sqrt(rise * turn / (4 * kProductError * most)))));
    for (int k = 1; k <= steps; ++k) out.push_back(k < steps ? a + (b - a) * k / steps : b);
  }
  return out;
}

/// A curve times a node's share.
Curve times_share(const Curve& curve, const std::vector<ShapeNode>& nodes, std::size_t node) {
  Curve out;
  if (curve.wavelength_um.empty()) return out;
  out.wavelength_um = wavelengths_of(curve, nodes);
  for (const double l : out.wavelength_um) out.value.push_back(value_at(curve, l) * node_share(nodes, node, l));
  return out;
}

int curve_parameter(const Shape& shape) { return shape_entry(shape.number).curve_parameter; }

double root(double value) { return std::sqrt(std::max(0.0, 1 - value)); }

/// Lagrange's polynomial of a node, 1 there and 0 at the others, at g.
double polynomial(const std::vector<double>& nodes, std::size_t node, double g) {
  double out = 1;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (i != node) out *= (g - nodes[i]) / (nodes[node] - nodes[i]);
  return out;
}

/// Diffusive reflectance, which a shape of the curve's value is divided by, and its curve times.
double by_diffusion(double g) { return (1 - g) / (1 + g); }

std::vector<double> roots_of(const std::vector<ShapeNode>& nodes) {
  std::vector<double> out;
  for (const ShapeNode& node : nodes)
    out.push_back(root(node.shape.parameter[static_cast<std::size_t>(curve_parameter(node.shape))]));
  return out;
}

/// Largest relative error, over values of the curve and some angles, of what lies between nodes.
double error_between(const Shape& shape, const std::vector<ShapeNode>& nodes, double low, double high) {
  constexpr int kSteps = 24;
  const auto parameter = static_cast<std::size_t>(curve_parameter(shape));
  const std::vector<double> at = roots_of(nodes);
  const auto direction = [](double cosine, double turn) {
    const double sine = std::sqrt(1 - cosine * cosine);
    return RcLocal{sine * std::cos(turn), sine * std::sin(turn), cosine};
  };
  const auto sent = [&](double g, const Shape& of, const RcAngles& angles) {
    return rc_shape_eval(of.number, by_diffusion(g), of.parameters(), angles);
  };
  double worst = 0;
  for (const double in : {0.15, 0.5, 1.0})
    for (const double out : {0.15, 0.6, 1.0})
      for (const double turn : {0.0, 1.5, 3.0}) {
        const RcAngles angles = rc_angles({0, 0, 1}, direction(in, 0), direction(out, turn));
        std::vector<double> of_node;
        for (std::size_t i = 0; i < nodes.size(); ++i) of_node.push_back(sent(at[i], nodes[i].shape, angles));
        for (int k = 0; k <= kSteps; ++k) {
          const double g = low + (high - low) * k / kSteps;
          Shape there = shape;
          there.parameter[parameter] = 1 - g * g;
          double sum = 0;
          for (std::size_t i = 0; i < nodes.size(); ++i) sum += polynomial(at, i, g) * of_node[i];
          worst = std::max(worst, std::abs(sum / sent(g, there, angles) - 1));
        }
      }
  return worst;
}

/// A curve with as many wavelengths more as it takes for what goes by sqrt(1 - value) to be linear between two of them,
/// to about kBetweenValues.
Curve finer(const Curve& curve) {
  Curve out;
  const auto add_up_to = [&](auto&& self, double end_um, double end, int halvings) -> void {
    const double begin_um = out.wavelength_um.back(), begin = out.value.back();
    if (std::abs(root(end) - root(begin)) > kRootStep && halvings > 0) {
      self(self, 0.5 * (begin_um + end_um), 0.5 * (begin + end), halvings - 1);
      self(self, end_um, end, halvings - 1);
      return;
    }
    out.wavelength_um.push_back(end_um), out.value.push_back(end);
  };
  for (std::size_t i = 0; i < curve.value.size(); ++i) {
    if (i == 0)
      out.wavelength_um.push_back(curve.wavelength_um[0]), out.value.push_back(curve.value[0]);
    else
      add_up_to(add_up_to, curve.wavelength_um[i], curve.value[i], kMostHalvings);
  }
  return out;
}

/// The part of node `node` in a curve by whose values the shape goes.
Curve part_of_values(const Curve& curve, const std::vector<ShapeNode>& nodes, std::size_t node) {
  const std::vector<double> at = roots_of(nodes);
  Curve out = finer(curve);
  for (double& value : out.value) value = polynomial(at, node, root(value)) * by_diffusion(at[node]);
  return out;
}

/// Factors of a gloss by Fresnel's law, as curves.
std::array<Curve, 4> fresnel_curves(const Material& material) {
  std::array<Curve, 4> out;
  for (Curve& curve : out) curve.wavelength_um = material.index_n.wavelength_um;
  for (std::size_t i = 0; i < material.index_n.value.size(); ++i) {
    const auto factors = fresnel_factors(material.index_n.value[i], material.index_k.value[i]);
    for (std::size_t f = 0; f < out.size(); ++f) out[f].value.push_back(factors[f]);
  }
  return out;
}

std::vector<ShapeAndCurve> parts_of(const Material& material, const Shape& first, const Curve& curve, bool gloss) {
  std::vector<ShapeAndCurve> out{{first, curve}};
  for (const FurtherLobe& lobe : material.further)
    if (is_gloss(lobe.shape) == gloss) out.push_back({lobe.shape, lobe.curve});
  return out;
}

bool alike(const std::vector<ShapeNode>& a, const std::vector<ShapeNode>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

}  // namespace

double value_at(const Curve& curve, double wavelength_um) {
  const auto& x = curve.wavelength_um;
  if (x.size() == 1 || wavelength_um <= x.front()) return curve.value.front();
  if (wavelength_um >= x.back()) return curve.value.back();
  const auto above = static_cast<std::size_t>(std::upper_bound(x.begin(), x.end(), wavelength_um) - x.begin());
  const double f = (wavelength_um - x[above - 1]) / (x[above] - x[above - 1]);
  return (1 - f) * curve.value[above - 1] + f * curve.value[above];
}

double node_share(const std::vector<ShapeNode>& nodes, std::size_t node, double wavelength_um) {
  if (nodes.empty()) return 1;
  const double at = std::clamp(wavelength_um, nodes.front().wavelength_um, nodes.back().wavelength_um);
  const double here = nodes[node].wavelength_um;
  if (at < here && node > 0) {
    const double below = nodes[node - 1].wavelength_um;
    return std::max(0.0, (at - below) / (here - below));
  }
  if (at > here && node + 1 < nodes.size()) {
    const double above = nodes[node + 1].wavelength_um;
    return std::max(0.0, (above - at) / (above - here));
  }
  return 1;
}

void make_lobes(Material& material) {
  static const Curve white{{kFirst_um, kLast_um}, {1.0, 1.0}};
  material.further.clear();
  material.front_curve = material.gloss_curve = {};
  const auto add = [&](const std::vector<ShapeNode>& nodes, const Curve& curve, Curve& first) {
    for (std::size_t node = 0; node < nodes.size(); ++node) {
      const bool by_values = curve_parameter(nodes[node].shape) >= 0;
      Curve part = by_values ? part_of_values(curve, nodes, node) : times_share(curve, nodes, node);
      if (node == 0)
        first = std::move(part);
      else
        material.further.push_back({nodes[node].shape, std::move(part)});
    }
  };
  add(material.front_nodes, material.reflectance, material.front_curve);
  add(material.gloss_nodes, white, material.gloss_curve);
  if (material.index_n.value.empty()) return;
  auto curves = fresnel_curves(material);
  material.gloss_curve = std::move(curves[0]);
  for (std::size_t f = 1; f < curves.size(); ++f) {
    Shape shape = material.gloss;
    shape.parameter[2] = static_cast<double>(f + 1);
    material.further.push_back({shape, std::move(curves[f])});
  }
}

void take_nodes_of_curve(Material& material) {
  const int parameter = curve_parameter(material.front);
  if (parameter < 0 || material.reflectance.value.empty()) return;
  const auto [least, most] = std::minmax_element(material.reflectance.value.begin(), material.reflectance.value.end());
  const double low = root(*most), high = root(*least);
  auto& nodes = material.front_nodes;
  for (std::size_t count = 1; count <= RC_MOST_NODES; ++count) {
    nodes.assign(count, {0, material.front});
    for (std::size_t i = 0; i < count; ++i) {
      const double g =
          0.5 * (low + high) +
          0.5 * (high - low) * std::cos(std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(count));
      nodes[i].shape.parameter[static_cast<std::size_t>(parameter)] = 1 - g * g;
    }
    if (error_between(material.front, nodes, low, high) < kBetweenValues || !(high > low)) break;
  }
  material.front = nodes.front().shape;
}

std::size_t most_further(const CompiledScene& scene) {
  std::size_t most = 0;
  for (const Material& material : scene.materials) most = std::max(most, material.further.size());
  return most;
}

std::vector<ShapeAndCurve> front_parts(const Material& material) {
  return parts_of(material, material.front,
                  material.front_curve.value.empty() ? material.reflectance : material.front_curve, false);
}

std::vector<ShapeAndCurve> gloss_parts(const Material& material) {
  if (material.gloss.number == RC_SHAPE_none) return {};
  return parts_of(material, material.gloss, material.gloss_curve.value.empty() ? white_curve() : material.gloss_curve,
                  true);
}

bool reflect_alike(const Material& a, const Material& b) {
  return a.front == b.front && alike(a.front_nodes, b.front_nodes);
}

bool gloss_alike(const Material& a, const Material& b) {
  return a.gloss == b.gloss && alike(a.gloss_nodes, b.gloss_nodes) &&
         a.index_n.value.empty() == b.index_n.value.empty();
}

GlossClash gloss_clash(const CompiledScene& scene) {
  for (const shared::Surface& surface : scene.surfaces) {
    GlossClash out;
    for_each_material(surface, [&](std::size_t material, float) {
      const Material& here = scene.materials[material];
      if (here.gloss.number == RC_SHAPE_none) return;
      if (out.first && !gloss_alike(*out.first, here)) out.other = &here;
      if (!out.first) out.first = &here;
    });
    if (out.other) return out;
  }
  return {};
}

}  // namespace raycube::scene
