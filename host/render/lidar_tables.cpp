#include "host/render/lidar_tables.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/error.h"
#include "host/cl/program.h"
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
/// Of so few rays that every cell of a bin has about one, each adds its own pulse sooner than moments do (19 sub-rays:
/// by a tenth).
constexpr std::size_t kFewestFoldedRays = 48;
/// So many equal hits a float adds up to 1e-6; more that are added one by one, to pixels of an array or of a pulse
/// without width, need two (65 536 lose 1.3e-4 in one).
constexpr int kRaysOfAFloat = 512;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// Half divergence below which a bundle's rounding, 16 ulp of a direction, passes 5 % of its unit: single rays are
/// faster then.
constexpr double kNarrow = 2e-5;

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
      if (leaf > 0) tables.features |= RC_FEATURE_LEAVES;
      if (plate > 0) tables.features |= RC_FEATURE_PLATES;
      tables.optics.push_back(
          {static_cast<float>(rho), static_cast<float>(leaf), static_cast<float>(plate), static_cast<float>(mirrored)});
    }
  }
  for (const auto& material : scene.materials)
    if (material.gloss.number != RC_SHAPE_none) tables.features |= RC_FEATURE_GLOSS;
  if (scene::first_shaped(scene)) tables.features |= RC_FEATURE_SHAPED;
  if (tables.features & (RC_FEATURE_GLOSS | RC_FEATURE_SHAPED)) tables.lobes = lidar::pulse_lobes(plan, scene);
  const std::uint32_t further = scene::curve_roles(scene) - RC_CURVE_ROLES;
  tables.plan[RC_PLAN_LOBE_LINES] = further > 0 ? static_cast<std::uint32_t>(lines) : 1;
  tables.plan[RC_PLAN_LOBE_STRIDE] = RC_LOBES + further;
}

void fill_air(const lidar::LidarPlan& plan, LidarTables& tables) {
  const auto posts = static_cast<std::size_t>(plan.air.posts);
  for (std::size_t node = 0; posts && node < plan.nodes.size(); ++node)
    for (std::size_t i = 0; i < posts; ++i) {
      const double* depth = plan.air.depth.data() + node * posts;
      tables.air.push_back(static_cast<float>(depth[i]));
      tables.air.push_back(i + 1 < posts ? static_cast<float>((depth[i + 1] - depth[i]) / plan.air.dz_m) : 0.0f);
    }
  if (posts) tables.features |= RC_FEATURE_AIR;
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
  if (!scene.volumes.empty()) tables.features |= RC_FEATURE_VOLUMES;
  if (tables.air_rows && !tables.backscatter.empty()) tables.features |= RC_FEATURE_RETURN;
  if (tables.way) tables.features |= RC_FEATURE_STOPPED;
  tables.plan[RC_PLAN_VOLUMES] = static_cast<std::uint32_t>(scene.volumes.size());
}

void fill_taps(const lidar::LidarPlan& plan, LidarTables& tables) {
  const lidar::PulseTaps& taps = plan.taps;
  const auto padded = static_cast<std::size_t>(RC_PADDED(taps.taps));
  for (int q = 0; q <= taps.phases; ++q)
    for (std::size_t i = 0; i < padded; ++i)
      tables.taps.push_back(
          i < static_cast<std::size_t>(taps.taps) ? taps.share[static_cast<std::size_t>(q) * taps.taps + i] : 0.0f);
  if (tables.owner_rows == static_cast<std::size_t>(plan.lines()) && plan.lines() <= RC_FOLDED_LINES &&
      plan.footprint.a.size() >= kFewestFoldedRays) {
    const lidar::PulseMoments moments = lidar::make_moments(taps);
    for (int row = 0; row < moments.cells * RC_MOMENTS; ++row)
      for (std::size_t i = 0; i < padded; ++i)
        tables.taps.push_back(
            i < static_cast<std::size_t>(taps.taps)
                ? moments.share[static_cast<std::size_t>(row) * static_cast<std::size_t>(taps.taps) + i]
                : 0.0f);
    tables.cells = moments.cells;
    if (tables.cells > 0) tables.features |= RC_FEATURE_FOLDED;  // a pulse without width has none
  }
  tables.row_pad = padded;
  tables.row_floats = 2 * padded + static_cast<std::size_t>(RC_PADDED(plan.lidar.gate.bins));
  tables.plan[RC_PLAN_TAPS] = static_cast<std::uint32_t>(padded);
  tables.scratch_floats =
      2 * tables.way_rows * static_cast<std::size_t>(plan.lines()) * (tables.row_floats + padded) + 2 * padded;
  tables.stopped_floats =
      tables.owner_rows * tables.row_floats + RC_PADDED(tables.owner_rows / static_cast<std::size_t>(plan.lines()));
}

/// Width of the square that the sub-rays cover and a little more, in sixteenths.
double support(const lidar::Footprint& footprint) {
  float largest = 0.5f;
  for (const auto* part : {&footprint.a, &footprint.b})
    for (const float x : *part) largest = std::max(largest, std::abs(x));
  return std::ceil(32.01f * largest) / 16;
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
  set(RC_SET_SUPPORT, support(plan.footprint));
}

/// Lines that a program's private arrays have room for, and their nodes: what is one of each stays in registers.
std::uint32_t room_for(const lidar::LidarPlan& plan) {
  const auto lines = static_cast<std::uint32_t>(plan.lines()), nodes = static_cast<std::uint32_t>(plan.nodes.size());
  if (lines <= 1 && nodes <= 1) return 1;
  std::uint32_t room = 16;
  while (room < lines || RC_NODES_OF_ROOM(room) < nodes) room *= 4;
  return room;
}

/// Which set of features a launch's programs are built for.
enum class Built { plain, survey, all };

Built built_for(const lidar::LidarPlan& plan, const LidarTables& tables) {
  const auto within = [&](std::uint32_t set) { return room_for(plan) == 1 && (tables.features & ~set) == 0; };
  return within(RC_FEATURES_PLAIN) ? Built::plain : within(RC_FEATURES_SURVEY) ? Built::survey : Built::all;
}

/// Of all that a launch may have and count, few programs are built, so that launches share them: what a program can do
/// beyond its launch changes no bit.
void set_programs(const lidar::LidarPlan& plan, const scene::CompiledScene& scene, LidarTables& tables) {
  const Built built = built_for(plan, tables);
  const bool single = (tables.features & RC_FEATURE_SINGLE) != 0;
  tables.samples = single ? single_samples(plan.footprint) : bundle_samples(plan.footprint, kMostBundle);
  tables.plan[RC_PLAN_SLOTS] = kMostBundle;
  tables.plan[RC_PLAN_FEATURES] = tables.features;
  const bool window = built != Built::all && tables.owner_rows * tables.row_floats <= kRowWindow;
  const std::string standard = " -cl-std=CL1.2", all = standard + " -DRC_FEATURES=RC_FEATURES_ALL",
                    lines = cl::define("RC_MOST_LINES", room_for(plan));
  tables.shot_options = (built == Built::plain    ? standard + " -DRC_FEATURES=RC_FEATURES_PLAIN"
                         : built == Built::survey ? standard + " -DRC_FEATURES=RC_FEATURES_SURVEY"
                                                  : all) +
                        cl::define("RC_CHUNK_SAMPLES", kMostBundle) +
                        cl::define("RC_STACK", kernel_stack(scene.stack_bound())) + lines +
                        cl::define("RC_ROW_WINDOW", window ? kRowWindow : 0);
  tables.air_options = all + lines;
  tables.beam_options = all;
}

}  // namespace

LidarTables make_lidar_tables(const lidar::LidarPlan& plan, const scene::CompiledScene& scene, bool apart, bool hits) {
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
  const bool single = exits || unit < kNarrow || rays < 2;
  for (const auto* part : {&plan.footprint.exit_a, &plan.footprint.exit_b}) {
    tables.exits.insert(tables.exits.end(), part->begin(), part->end());
    if (exits) tables.exits.resize(RC_PADDED(tables.exits.size()), 0.0f);
  }
  tables.multiple = lidar.transport.max_bounces > 1;
  tables.owner_rows = static_cast<std::size_t>(plan.lines()) * static_cast<std::size_t>(receiver ? 1 : plan.pixels());
  const auto feature = [&](bool has, std::uint32_t which) { tables.features |= has ? which : 0u; };
  feature(receiver, RC_FEATURE_RECEIVER);
  feature(single, RC_FEATURE_SINGLE);
  feature(exits, RC_FEATURE_EXITS);
  feature(!receiver && plan.pixels() > 1, RC_FEATURE_PIXELS);
  feature(lidar.transport.overlap == scene::LidarOverlap::exact, RC_FEATURE_OVERLAP);
  feature(lidar.pulse.profile == scene::BeamProfile::gaussian, RC_FEATURE_GAUSSIAN);
  feature(hits, RC_FEATURE_HITS);
  feature(tables.multiple, RC_FEATURE_BOUNCES);
  feature(apart, RC_FEATURE_SHADOWS);
  tables.plan.resize(RC_PLAN_COUNT);
  tables.plan[RC_PLAN_LINES] = static_cast<std::uint32_t>(plan.lines());
  tables.plan[RC_PLAN_NODES] = static_cast<std::uint32_t>(plan.nodes.size());
  tables.plan[RC_PLAN_COLUMNS] = static_cast<std::uint32_t>(lidar.receiver.columns);
  tables.plan[RC_PLAN_ROWS] = static_cast<std::uint32_t>(lidar.receiver.rows);
  tables.plan[RC_PLAN_RAYS] = static_cast<std::uint32_t>(rays);
  tables.plan[RC_PLAN_BOUNCES] = static_cast<std::uint32_t>(lidar.transport.max_bounces);
  fill_matter(plan, scene, tables);
  fill_air(plan, tables);
  fill_volumes(plan, scene, tables);
  fill_taps(plan, tables);
  fill_settings(plan, tables);
  const bool folded = (tables.features & (RC_FEATURE_FOLDED | RC_FEATURE_PIXELS)) == RC_FEATURE_FOLDED;
  if (!folded && rays > kRaysOfAFloat) tables.features |= RC_FEATURE_RESTS, tables.floats_of_sum = 2;
  set_programs(plan, scene, tables);
  for (const double photons : plan.photons) tables.photons.push_back(static_cast<float>(photons));
  for (const auto& node : plan.nodes) tables.node_weight.push_back(static_cast<float>(node.weight));
  for (const int node : plan.first_node) tables.first_node.push_back(static_cast<std::uint32_t>(node));
  return tables;
}

}  // namespace raycube::render
