#include "host/render/lidar_tables.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/error.h"
#include "host/lidar/pulse_lobes.h"
#include "host/lidar/pulse_moments.h"
#include "host/render/scene_buffers.h"
#include "kernels/lidar/layout.h"
#include "kernels/shared/tile_layout.h"
#include "scene_compiler/matter.h"

namespace raycube::render {

namespace {

constexpr int kMostBundle = 1024;
/// Floats of an owner's rows that a work-item keeps in its own memory: 16 KiB, within a core's first cache.
constexpr std::size_t kRowWindow = 4096;
/// Lines whose moments a work-item keeps: 9 KiB each. Of so few rays that every cell has about one, each adds its own
/// pulse sooner (19 sub-rays: by a tenth).
constexpr int kMostFoldedLines = 4;
constexpr std::size_t kFewestFoldedRays = 48;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// Half divergence below which a bundle's rounding, 16 ulp of a direction, passes 5 % of its unit: single rays are
/// faster then.
constexpr double kNarrow = 2e-5;

std::string define(const char* name, auto value) { return " -D" + std::string(name) + "=" + std::to_string(value); }

/// As struct Scatter of kernels/geometry/primary_frame.h, chunk after chunk.
std::vector<float> bundle_samples(const lidar::Footprint& footprint, int chunk) {
  const int slots = RC_PADDED(chunk), bounds = RC_PADDED(slots / 16), rays = static_cast<int>(footprint.a.size());
  std::vector<float> out;
  for (int begin = 0; begin < rays; begin += chunk) {
    std::vector<float> a(slots, kInfinity), b(slots, kInfinity), lo_a(bounds, kInfinity), hi_a(bounds, -kInfinity),
        lo_b = lo_a, hi_b = hi_a;
    for (int k = 0; k < std::min(chunk, rays - begin); ++k) {
      a[k] = footprint.a[begin + k];
      b[k] = footprint.b[begin + k];
      lo_a[k / 16] = std::min(lo_a[k / 16], a[k]);
      hi_a[k / 16] = std::max(hi_a[k / 16], a[k]);
      lo_b[k / 16] = std::min(lo_b[k / 16], b[k]);
      hi_b[k / 16] = std::max(hi_b[k / 16], b[k]);
    }
    for (const auto* part : {&a, &b, &lo_a, &hi_a, &lo_b, &hi_b}) out.insert(out.end(), part->begin(), part->end());
  }
  return out;
}

/// [word][2][16]
std::vector<float> single_samples(const lidar::Footprint& footprint) {
  std::vector<float> out;
  for (std::size_t word = 0; word < footprint.a.size(); word += 16)
    for (const auto* part : {&footprint.a, &footprint.b})
      for (std::size_t k = word; k < word + 16; ++k) out.push_back(k < part->size() ? (*part)[k] : kInfinity);
  return out;
}

void fill_matter(const lidar::LidarPlan& plan, const scene::CompiledScene& scene, LidarTables& tables) {
  const auto lines = static_cast<std::size_t>(plan.lines());
  bool leaves = false, plates = false;
  for (const auto& surface : scene.surfaces) {
    for (std::size_t line = 0; line < lines; ++line) {
      double rho = 0, leaf = 0, plate = 0, mirrored = 0;
      for (int i = 0; i < 4; ++i) {
        if (surface.material[i] == 0) continue;
        const std::size_t material = surface.material[i] - 1;
        const lidar::Matter& matter = plan.matter[material * lines + line];
        rho += surface.fraction[i] * matter.reflectance, mirrored += surface.fraction[i] * matter.mirrored;
        (scene.materials[material].behind.number == RC_SHAPE_plate ? plate : leaf) +=
            surface.fraction[i] * matter.transmittance;
      }
      leaves |= leaf > 0;
      plates |= plate > 0;
      tables.optics.push_back(
          {static_cast<float>(rho), static_cast<float>(leaf), static_cast<float>(plate), static_cast<float>(mirrored)});
    }
  }
  bool gloss = false;
  for (const auto& material : scene.materials) gloss |= material.gloss.number != RC_SHAPE_none;
  const bool shaped = scene::first_shaped(scene) != nullptr;
  if (gloss || shaped) tables.lobes = lidar::pulse_lobes(plan, scene);
  tables.shot_options +=
      define("RC_LEAVES", int{leaves}) + define("RC_PLATES", int{plates}) + define("RC_GLOSS", int{gloss});
  if (shaped) tables.shot_options += define("RC_SHAPED", 1);
  if (const std::uint32_t further = scene::curve_roles(scene) - RC_CURVE_ROLES; further > 0)
    tables.shot_options += define("RC_FURTHER_RECORDS", further) + define("RC_LOBE_LINES", lines);
}

void fill_air(const lidar::LidarPlan& plan, LidarTables& tables) {
  const auto posts = static_cast<std::size_t>(plan.air.posts);
  for (std::size_t node = 0; posts && node < plan.nodes.size(); ++node)
    for (std::size_t i = 0; i < posts; ++i) {
      const double* depth = plan.air.depth.data() + node * posts;
      tables.air.push_back(static_cast<float>(depth[i]));
      tables.air.push_back(i + 1 < posts ? static_cast<float>((depth[i + 1] - depth[i]) / plan.air.dz_m) : 0.0f);
    }
  tables.air_options += define("RC_AIR", posts ? 1 : 0);
}

void fill_volumes(const lidar::LidarPlan& plan, const scene::CompiledScene& scene, LidarTables& tables) {
  tables.volumes = lidar::flatten_volumes(scene.volumes);
  const std::size_t nodes = plan.nodes.size();
  bool particles = false;
  for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
    particles |= scene.volumes[v].extinction_per_m > 0;
    for (std::size_t node = 0; node < nodes; ++node)
      tables.volume_depth.push_back(
          scene.volumes[v].gas.empty()
              ? 0.0f
              : static_cast<float>(lidar::kMoleculesPerPpmM * plan.cross_section_cm2[v * nodes + node]));
  }
  for (const double beta : plan.air.backscatter_per_m_sr) tables.backscatter.push_back(static_cast<float>(beta));
  tables.air_rows = plan.lidar.transport.air_return;
  tables.way_rows = scene.volumes.empty() ? 1 : 2;
  tables.way = particles || (tables.air_rows && !tables.backscatter.empty());
  tables.air_options += define("RC_VOLUMES", scene.volumes.size()) +
                        define("RC_AIR_RETURN", tables.air_rows && !tables.backscatter.empty() ? 1 : 0);
  tables.shot_options += define("RC_STOPPED", tables.way ? 1 : 0);
}

void fill_taps(const lidar::LidarPlan& plan, LidarTables& tables) {
  const lidar::PulseTaps& taps = plan.taps;
  const auto padded = static_cast<std::size_t>(RC_PADDED(taps.taps));
  for (int q = 0; q <= taps.phases; ++q)
    for (std::size_t i = 0; i < padded; ++i)
      tables.taps.push_back(
          i < static_cast<std::size_t>(taps.taps) ? taps.share[static_cast<std::size_t>(q) * taps.taps + i] : 0.0f);
  if (tables.owner_rows == static_cast<std::size_t>(plan.lines()) && plan.lines() <= kMostFoldedLines &&
      plan.footprint.a.size() >= kFewestFoldedRays) {
    const lidar::PulseMoments moments = lidar::make_moments(taps);
    for (int row = 0; row < moments.cells * RC_MOMENTS; ++row)
      for (std::size_t i = 0; i < padded; ++i)
        tables.taps.push_back(
            i < static_cast<std::size_t>(taps.taps)
                ? moments.share[static_cast<std::size_t>(row) * static_cast<std::size_t>(taps.taps) + i]
                : 0.0f);
    tables.cells = moments.cells;
  }
  tables.shot_options += define("RC_FOLDED", tables.cells > 0 ? 1 : 0);
  tables.row_pad = padded;
  tables.row_floats = 2 * padded + static_cast<std::size_t>(RC_PADDED(plan.lidar.gate.bins));
  tables.options += define("RC_TAPS_PADDED", padded);
  tables.shot_options +=
      define("RC_ROW_WINDOW", tables.owner_rows * tables.row_floats <= kRowWindow && !tables.multiple ? kRowWindow : 0);
  tables.stopped_floats =
      tables.owner_rows * tables.row_floats + RC_PADDED(tables.owner_rows / static_cast<std::size_t>(plan.lines()));
}

void fill_settings(const lidar::LidarPlan& plan, LidarTables& tables) {
  const scene::Lidar& lidar = plan.lidar;
  tables.settings.resize(RC_SET_COUNT);
  const auto set = [&](int i, double value) {
    tables.settings[static_cast<std::size_t>(i)] = static_cast<float>(value);
  };
  set(RC_SET_BINS_PER_M, lidar.transport.group_index / (299792458.0 * lidar.gate.bin_s));
  set(RC_SET_HALF_FOV, lidar.receiver.half_fov_rad);
  set(RC_SET_PUPIL, lidar.receiver.aperture_radius_m);
  set(RC_SET_OBSCURATION, lidar.receiver.obscuration_radius_m);
  set(RC_SET_FOCUS, lidar.receiver.focus_m > 0 ? 1 / lidar.receiver.focus_m : 0);
  set(RC_SET_PITCH, lidar.receiver.pixel_pitch_rad);
  set(RC_SET_MINIMUM_RANGE, lidar.transport.minimum_range_m);
  set(RC_SET_RANGE_LIMIT, lidar.transport.range_limit_m > 0 ? lidar.transport.range_limit_m : kInfinity);
  set(RC_SET_AIR_Z0, plan.air.z0_m);
  set(RC_SET_AIR_DZ, plan.air.dz_m);
  set(RC_SET_AIR_POSTS, plan.air.posts);
  set(RC_SET_GATE_WAY, lidar.gate.start_s * 299792458.0 / lidar.transport.group_index);
}

}  // namespace

LidarTables make_lidar_tables(const lidar::LidarPlan& plan, const scene::CompiledScene& scene) {
  const scene::Lidar& lidar = plan.lidar;
  const bool receiver = lidar.transport.sampling == scene::LidarSampling::receiver,
             exits = !plan.footprint.exit_a.empty();
  if ((receiver || plan.pixels() > 1) && !(lidar.receiver.pixel_pitch_rad > 0))
    throw base::Error(base::Fault::input, "LIDAR '" + lidar.name +
                                              "': arrays and receiver sampling need receiver.pixel_pitch > 0, found " +
                                              std::to_string(lidar.receiver.pixel_pitch_rad));
  LidarTables tables;
  const auto rays = static_cast<int>(plan.footprint.a.size());
  const double unit = receiver ? lidar.receiver.pixel_pitch_rad : lidar.pulse.half_divergence_rad;
  tables.single = exits || unit < kNarrow || rays < 2;
  tables.chunk = std::min(RC_PADDED(rays), kMostBundle);
  float largest = 0.5f;
  for (const auto* part : {&plan.footprint.a, &plan.footprint.b})
    for (const float x : *part) largest = std::max(largest, std::abs(x));
  tables.samples = tables.single ? single_samples(plan.footprint) : bundle_samples(plan.footprint, tables.chunk);
  for (const auto* part : {&plan.footprint.exit_a, &plan.footprint.exit_b}) {
    tables.exits.insert(tables.exits.end(), part->begin(), part->end());
    if (exits) tables.exits.resize(RC_PADDED(tables.exits.size()), 0.0f);
  }
  tables.multiple = lidar.transport.max_bounces > 1;
  tables.owner_rows = static_cast<std::size_t>(plan.lines()) * static_cast<std::size_t>(receiver ? 1 : plan.pixels());
  tables.options = " -cl-std=CL1.2" + define("RC_CHUNK_SAMPLES", tables.chunk) +
                   define("RC_SUPPORT", std::ceil(32.01f * largest) / 16) + "f" + define("RC_RECEIVER", int{receiver}) +
                   define("RC_LASER_LINES", plan.lines()) + define("RC_COLUMNS", lidar.receiver.columns) +
                   define("RC_ROWS", lidar.receiver.rows) + define("RC_RAY_COUNT", rays) +
                   define("RC_SINGLE", int{tables.single}) + define("RC_EXITS", int{exits}) +
                   define("RC_OVERLAP", lidar.transport.overlap == scene::LidarOverlap::exact ? 1 : 0) +
                   define("RC_GAUSSIAN", lidar.pulse.profile == scene::BeamProfile::gaussian ? 1 : 0);
  tables.air_options = define("RC_LINE_NODES", plan.nodes.size());
  tables.shot_options =
      define("RC_STACK", kernel_stack(scene.stack_bound())) + define("RC_BOUNCES", lidar.transport.max_bounces);
  fill_matter(plan, scene, tables);
  fill_air(plan, tables);
  fill_volumes(plan, scene, tables);
  fill_taps(plan, tables);
  fill_settings(plan, tables);
  for (const double photons : plan.photons) tables.photons.push_back(static_cast<float>(photons));
  for (const auto& node : plan.nodes) tables.node_weight.push_back(static_cast<float>(node.weight));
  for (const int node : plan.first_node) tables.first_node.push_back(static_cast<std::uint32_t>(node));
  return tables;
}

}  // namespace raycube::render
