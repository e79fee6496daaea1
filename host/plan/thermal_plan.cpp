#include "host/plan/thermal_plan.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/base/planck.h"
#include "host/base/units.h"
#include "host/plan/irradiance_map.h"
#include "host/plan/sky_basis.h"
#include "kernels/atmosphere/nodes.h"
#include "kernels/shared/tile_layout.h"
#include "scene_compiler/lobe_albedo.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/owner.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::plan {

namespace {

constexpr int kMostTemperatures = 16;  ///< evenly spread; two nodes of height and view leave room for 8 and 16

/// Temperature of a surface: its materials' by their share of the area.
double mean_temperature(const scene::CompiledScene& scene, const shared::Surface& surface) {
  double sum = 0, share = 0;
  for (int c = 0; c < 4; ++c) {
    if (surface.material[c] == 0) continue;
    sum += static_cast<double>(surface.fraction[c]) * scene.materials[surface.material[c] - 1].temperature_K;
    share += static_cast<double>(surface.fraction[c]);
  }
  return share > 0 ? sum / share : 0;
}

/// Area of a mesh's triangles and their integral of temperature, m2 and m2 K, in its own frame.
std::pair<double, double> mesh_area(const scene::CompiledScene& scene, std::span<const std::uint32_t> triangles,
                                    const std::vector<double>& surface_K) {
  double area = 0, warm = 0;
  for (const std::uint32_t primitive : triangles) {
    const shared::TriBlock& block = scene.blocks[primitive / RC_BLOCK];
    const std::uint32_t k = primitive % RC_BLOCK;
    const Eigen::Vector3d a(block.v0_x[k], block.v0_y[k], block.v0_z[k]),
        p(block.v1_x[k], block.v1_y[k], block.v1_z[k]), q(block.v2_x[k], block.v2_y[k], block.v2_z[k]);
    const double here = 0.5 * (p - a).cross(q - a).norm();
    area += here;
    warm += here * surface_K[block.surface[k]];
  }
  return {area, warm};
}

/// Areas of an instance against those of its mesh; exact for turns and uniform scales, the mean over directions else.
double area_scale(const shared::Instance& placed) {
  Eigen::Matrix3d m;
  m << placed.world_from_local_0.x, placed.world_from_local_0.y, placed.world_from_local_0.z,
      placed.world_from_local_1.x, placed.world_from_local_1.y, placed.world_from_local_1.z,
      placed.world_from_local_2.x, placed.world_from_local_2.y, placed.world_from_local_2.z;
  return std::pow(std::abs(m.determinant()), 2.0 / 3.0);
}

/// Tables of every lobe that sends otherwise than Lambert's law; equal shapes share one.
void add_lobe_albedos(const scene::CompiledScene& scene, Thermal& thermal) {
  if (!scene::camera_matter(scene).shaped) return;
  const std::size_t records = scene::lobe_records(scene);
  std::vector<std::uint32_t> at(scene.surfaces.size() * records, 0);
  std::vector<scene::Shape> known;
  for (std::size_t s = 0; s < scene.surfaces.size(); ++s)
    scene::for_each_lobe(scene, scene.surfaces[s], [&](std::size_t record, const scene::Shape& given, double) {
      if (record == RC_LOBE_BEHIND || given.number == RC_SHAPE_lambert) return;
      const scene::Shape shape = scene::as_cameras_see(given);
      auto found = std::find(known.begin(), known.end(), shape);
      if (found == known.end()) {
        base::throw_if_interrupted();
        const scene::LobeAlbedo table(shape, RC_ALBEDO_ZENITHS, RC_ALBEDO_AZIMUTHS);
        thermal.albedo.insert(thermal.albedo.end(), table.nodes().begin(), table.nodes().end());
        found = known.insert(known.end(), shape);
      }
      at[s * records + record] = static_cast<std::uint32_t>(found - known.begin() + 1);
    });
  if (!known.empty()) thermal.albedo_at = std::move(at);
}

/// The largest value of a curve in thermal light.
double most_beyond(const scene::Curve& curve, double from_um) {
  double most = curve.value.empty() ? 0 : curve.value.back();
  for (std::size_t i = 0; i < curve.value.size(); ++i)
    if (curve.wavelength_um[i] >= from_um) most = std::max(most, curve.value[i]);
  return most;
}

/// Matter whose front, transmittance and gloss together send back more of an even light than comes, at slant angles,
/// where a gloss mirrors more: its emission is negative there.
void tell_of_bright_lobes(const scene::CompiledScene& scene, Thermal& thermal) {
  constexpr double kThermalFrom_um = 3;
  for (const auto index : scene::used_families(scene)) {
    const scene::Material& material = scene.materials[index];
    if (material.gloss.number == RC_SHAPE_none) continue;
    const double through = most_beyond(material.transmittance, kThermalFrom_um);
    for (int zenith_deg = 0; zenith_deg <= 80; zenith_deg += 5) {
      const double zenith = zenith_deg * base::kPi / 180;
      const auto add = [&](const std::vector<scene::ShapeAndCurve>& parts) {
        double sum = 0;
        for (const auto& part : parts)
          sum += most_beyond(part.curve, kThermalFrom_um) *
                 scene::lobe_albedo(scene::as_cameras_see(part.shape), {std::sin(zenith), 0, std::cos(zenith)});
        return sum;
      };
      const double back = through + add(scene::front_parts(material)) + add(scene::gloss_parts(material));
      if (back <= 1) continue;
      thermal.notices.push_back(fmt::format(
          "material '{}' sends back {:.3g} times what comes, seen {} deg from its normal, more beyond: there "
          "its emission is negative; lower its reflectance or its gloss",
          material.name, back, zenith_deg));
      break;
    }
  }
}

}  // namespace

void check_thermal_matter(const scene::CompiledScene& scene, const std::string& file, const std::string& demanded_by,
                          base::Problems& problems) {
  if (demanded_by.empty()) return;
  for (const auto index : scene::used_families(scene)) {
    const auto& material = scene.materials[index];
    if (!(material.temperature_K > 0))
      problems.add({file, 0, 0, "material '" + material.name + "'"}, "has no temperature, and " + demanded_by, "",
                   "give it temperature_K, or give [thermal] default_temperature_K");
  }
}

Emitters find_emitters(const scene::CompiledScene& scene, const std::string& file, const std::string& demanded_by) {
  Emitters out;
  base::Problems problems;
  check_thermal_matter(scene, file, demanded_by, problems);
  problems.throw_if_any();
  const auto used = scene::used_materials(scene);
  double plain = 0;
  for (const auto index : used) {
    const auto& material = scene.materials[index];
    out.distinct_K.push_back(material.temperature_K);
    plain += material.temperature_K / static_cast<double>(used.size());
  }
  std::sort(out.distinct_K.begin(), out.distinct_K.end());
  out.distinct_K.erase(std::unique(out.distinct_K.begin(), out.distinct_K.end()), out.distinct_K.end());
  std::vector<double> surface_K;
  for (const auto& surface : scene.surfaces) surface_K.push_back(mean_temperature(scene, surface));
  std::vector<std::pair<double, double>> meshes;
  const scene::MeshTriangles triangles(scene);
  for (std::uint32_t mesh = 0; mesh < scene.meshes.size(); ++mesh)
    meshes.push_back(mesh_area(scene, triangles.of(mesh), surface_K));
  double area = 0, warm = 0;
  for (const scene::Placement& placement : scene::placements(scene)) {
    const double scale = area_scale(scene.instances[placement.instance]);
    area += scale * meshes[placement.mesh].first;
    warm += scale * meshes[placement.mesh].second;
  }
  out.surroundings_K = area > 0 ? warm / area : plain;
  return out;
}

Spectrum planck_spectrum(const std::vector<double>& wavelength_um, double temperature_K) {
  Spectrum out;
  for (const double l : wavelength_um) out.push_back(base::planck_radiance(l, temperature_K));
  return out;
}

std::vector<TemperatureLevel> temperature_levels(const Emitters& emitters, const TableSpectra& air,
                                                 const Domain& domain, const BandSpace& bands,
                                                 const std::vector<double>& table_um,
                                                 const std::vector<double>& typical) {
  const auto& distinct = emitters.distinct_K;
  std::vector<TemperatureLevel> out;
  if (distinct.empty()) return {{{emitters.surroundings_K}, 0}};
  const double lo = distinct.front(), hi = distinct.back();
  const Spectrum up = air.view_transmission(domain.z(0.5), zenith_of_sec(domain.sec(0.5)));
  const auto emitted = [&](double kelvin) {
    const Spectrum light = product(planck_spectrum(table_um, kelvin), up);
    auto whole = bands.band_mean(light);
    const auto reflected = bands.reflected_band_mean(light);
    for (std::size_t b = 0; b < whole.size(); ++b) whole[b] -= reflected[b];
    return whole;
  };
  const auto largest = [&](const std::vector<double>& here, const std::vector<double>& low,
                           const std::vector<double>& high) {
    double worst = 0;
    for (std::size_t b = 0; b < here.size(); ++b)
      worst = std::max(worst, std::abs(here[b] - 0.5 * (low[b] + high[b])) / typical[b]);
    return worst;
  };
  if (hi > lo) {
    const auto middle = emitted(0.5 * (lo + hi)), low = emitted(lo), high = emitted(hi);
    out.push_back({{0.5 * (lo + hi)}, std::max(largest(middle, low, low), largest(middle, high, high))});
  }
  for (int count = 2; count < std::min(static_cast<int>(distinct.size()), kMostTemperatures + 1); ++count) {
    TemperatureLevel level;
    for (int k = 0; k < count; ++k) level.node_K.push_back(lo + (hi - lo) * k / (count - 1));
    for (int k = 0; k + 1 < count; ++k) {
      const auto a = level.node_K[static_cast<std::size_t>(k)], b = level.node_K[static_cast<std::size_t>(k) + 1];
      level.error = std::max(level.error, largest(emitted(0.5 * (a + b)), emitted(a), emitted(b)));
    }
    out.push_back(std::move(level));
  }
  if (distinct.size() <= RC_MAX_CHANNELS) out.push_back({distinct, 0});
  return out;
}

double node_coordinate(const std::vector<double>& node_K, double temperature_K) {
  const Cell cell = find_cell(node_K, temperature_K);
  return static_cast<double>(cell.index) + cell.fraction;
}

void add_leaning_keys(const scene::CompiledScene& scene, std::vector<std::uint32_t>& keys) {
  const rc_id role = scene::curve_roles(scene);
  for (const auto material : scene::used_materials(scene))
    if (scene.materials[material].front.number != RC_SHAPE_lambert)
      keys.push_back(rc_curve_id(role, material, scene::material_count(scene)));
}

Thermal make_thermal(const scene::CompiledScene& scene, const Emitters& emitters, const TemperatureLevel& nodes,
                     const SkyFactors& factors) {
  Thermal out;
  out.on = true;
  out.sky_components = factors.rank;
  out.temperature_K = nodes.node_K;
  out.surroundings_K = emitters.surroundings_K;
  for (const auto& surface : scene.surfaces) {
    const auto at = [&](int c) {
      const double kelvin = surface.material[c] > 0 ? scene.materials[surface.material[c] - 1].temperature_K : 0;
      return static_cast<float>(node_coordinate(nodes.node_K, kelvin));
    };
    out.surface_node.push_back({at(0), at(1), at(2), at(3)});
  }
  if (factors.rank > 0) {
    out.basis = factors.basis;
  } else {  // a black sky: directions still ask what hides it
    out.basis.zenith_rad = {0, base::kPi / 2};
    out.basis.azimuth_rad = {0, base::kPi};
    out.basis.value.assign(4, {1 / base::kPi, 0, 0, 0});
  }
  add_lobe_albedos(scene, out);
  if (!out.albedo_at.empty()) tell_of_bright_lobes(scene, out);
  const SkyIrradiance open(out.basis);
  for (int i = 0; i < RC_TILT_NODES; ++i) {
    const double nz = -1 + 2.0 * i / (RC_TILT_NODES - 1);
    auto value = open.at(std::acos(nz), 0);
    value[static_cast<std::size_t>(out.sky_components)] = base::kPi * (1 - nz) / 2;
    out.tilt_irradiance.push_back(
        {static_cast<float>(value[0]), static_cast<float>(value[1]), static_cast<float>(value[2]), 0});
  }
  return out;
}

}  // namespace raycube::plan
