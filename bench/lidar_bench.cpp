// Pulses traced and binned against Embree doing the same; pulses a second with whole waveforms and echoes.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "bench/cases.h"
#include "bench/embree_baseline.h"
#include "bench/lidar_baseline.h"
#include "bench/scenes/scenes.h"
#include "bench/timing.h"
#include "host/base/error.h"
#include "host/lidar/detection.h"
#include "host/lidar/make_lidar_plan.h"
#include "host/base/parallel.h"
#include "host/render/lidar_renderer.h"
#include "scene_compiler/load_simulation.h"

namespace raycube::bench {

namespace {

constexpr double kLight_m_s = 299792458.0;

/// 1064 nm, 4 ns, a spot of 1 m (1/e2 diameter) from 600 m, 1000 bins of 1 ns; monostatic, no air, full overlap.
scene::Lidar bench_lidar(int subrays) {
  scene::Lidar lidar;
  lidar.name = "bench";
  lidar.trajectory = {{0, 0, 0, 600, 0, 0, 0}};
  lidar.pulse.lines = {{"1064", 1.064, 0, 100e-6}};
  lidar.pulse.fwhm_s = 4e-9;
  lidar.pulse.half_divergence_rad = 0.5 / 600;
  lidar.receiver.aperture_radius_m = 0.05;
  lidar.receiver.half_fov_rad = 5e-3;
  lidar.gate = {2 * 540 / kLight_m_s, 1e-9, 1000};
  lidar.transport.subrays = subrays;
  lidar.transport.overlap = scene::LidarOverlap::off;
  lidar.transport.air_return = false;
  return lidar;
}

lidar::Shot shot_at(const scene::Lidar& lidar, std::int64_t pulse, const lidar::Vec3& from, const lidar::Vec3& to) {
  lidar::Shot shot;
  shot.pulse = pulse;
  lidar::Vec3 axis{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
  const double length = std::hypot(axis[0], axis[1], axis[2]);
  for (double& x : axis) x /= length;
  const double flat = std::hypot(axis[2], axis[0]);
  shot.exit_m = shot.pupil_m = from;
  shot.exit_axis = shot.pupil_axis = axis;
  shot.exit_u = shot.pupil_u = {axis[2] / flat, 0, -axis[0] / flat};
  shot.half_divergence_rad = lidar.pulse.half_divergence_rad;
  return shot;
}

/// A raster of shots over 200 x 200 m from one place 600 m up: up to 13 degrees off the nadir.
std::vector<lidar::Shot> raster(const scene::Lidar& lidar, int count) {
  std::vector<lidar::Shot> shots;
  const int side = static_cast<int>(std::ceil(std::sqrt(count)));
  for (int i = 0; i < count; ++i)
    shots.push_back(shot_at(lidar, i, {0, 0, 600},
                            {-100 + 200.0 * (i % side + 0.5) / side, -100 + 200.0 * (i / side + 0.5) / side, 0}));
  return shots;
}

shared::rc_float4 float4_of(const lidar::Vec3& v, double scale = 1) {
  return {static_cast<float>(scale * v[0]), static_cast<float>(scale * v[1]), static_cast<float>(scale * v[2]), 0};
}

struct Rig {
  const scene::CompiledScene& scene;
  lidar::LidarPlan plan;
  std::vector<lidar::Shot> shots;
  std::vector<float> reflectance;  ///< of each surface
  LidarWork work;

  Rig(const scene::Simulation& simulation, const scene::Lidar& lidar, std::vector<lidar::Shot> shots_)
      : scene(simulation.scene), plan(lidar::make_lidar_plan(simulation, lidar, nullptr)), shots(std::move(shots_)) {
    plan.footprint.exit_a.clear(), plan.footprint.exit_b.clear();
    for (const auto& surface : scene.surfaces) {
      double sum = 0;
      for (int m = 0; m < 4; ++m)
        if (surface.material[m] > 0) sum += surface.fraction[m] * plan.matter[surface.material[m] - 1].reflectance;
      reflectance.push_back(static_cast<float>(sum));
    }
    const auto& receiver = lidar.receiver;
    const double area = M_PI * (receiver.aperture_radius_m * receiver.aperture_radius_m -
                                receiver.obscuration_radius_m * receiver.obscuration_radius_m);
    work.a = plan.footprint.a, work.b = plan.footprint.b;
    work.bins = lidar.gate.bins;
    work.bins_per_m = static_cast<float>(2 / (kLight_m_s * lidar.gate.bin_s));
    work.weight = static_cast<float>(plan.photons[0] / lidar.transport.subrays * area / M_PI * receiver.efficiency);
    work.reflectance = &reflectance;
    work.taps = &plan.taps;
    for (const auto& shot : shots) {
      const double spread = std::tan(shot.half_divergence_rad);
      const auto &w = shot.exit_axis, &u = shot.exit_u;
      const lidar::Vec3 v{w[1] * u[2] - w[2] * u[1], w[2] * u[0] - w[0] * u[2], w[0] * u[1] - w[1] * u[0]};
      work.groups.push_back({float4_of(shot.exit_m), float4_of(w), float4_of(u, spread), float4_of(v, spread), {}});
      work.start_m.push_back(static_cast<float>(0.5 * kLight_m_s * lidar.gate.start_s));
    }
  }
};

/// Same rows to rounding? Then the two in turn. Times are those of tracing and binning alone on both sides.
Spread compare(const Rig& rig, const EmbreeBaseline& embree, const Settings& settings, Report& report,
               const std::string& label) {
  const LidarBaseline baseline(embree, rig.scene);
  render::RenderOptions options;
  options.threads = settings.threads;
  render::LidarRenderer renderer(rig.scene, options);
  const auto bins = static_cast<std::size_t>(rig.work.bins);
  const std::size_t row_pad = LidarBaseline::row_pad(rig.work), row_floats = LidarBaseline::row_floats(rig.work);
  std::vector<float> unaligned(rig.shots.size() * row_floats + 16), ours;
  float* theirs = LidarBaseline::on_line(unaligned.data());
  renderer.render(rig.plan, rig.shots, [&](lidar::ShotResult&& result) {
    ours.insert(ours.end(), result.first.begin(), result.first.end());
  });
  baseline.run(rig.work, settings.threads, theirs);
  double total = 0, off = 0;
  std::size_t shots_off = 0;
  for (std::size_t s = 0; s < rig.shots.size(); ++s) {
    double sum = 0, difference = 0;
    for (std::size_t i = 0; i < bins; ++i) {
      const float their = theirs[s * row_floats + row_pad + i];
      sum += their, difference += std::abs(ours[s * bins + i] - their);
    }
    total += sum, off += difference;
    shots_off += difference > 1e-3 * sum;
  }
  std::printf("  %s: %.2g of the shots differ by more than 1e-3 of their light\n", label.c_str(),
              static_cast<double>(shots_off) / static_cast<double>(rig.shots.size()));
  // Hits part in up to 1e-3 of the rays among leaves by rounding alone; a range in fp32 from 600 m is good to 6e-5 m,
  // 4e-4 bin.
  report.validate(label + ": light in other bins than Embree's, of all", off / total, 3e-3);
  Pairs times;
  for (int i = 0; i < kPairs; ++i) {
    times.reference_s.push_back(seconds_of([&] { baseline.run(rig.work, settings.threads, theirs); }));
    renderer.render(rig.plan, rig.shots, [](lidar::ShotResult&&) {});
    times.ours_s.push_back(renderer.launch_s());
  }
  return times.ratio();
}

/// Seconds of a receiver beside the laser over those of one about it, launches alone, in turn.
Spread biaxial_vs_coaxial(const scene::Simulation& park, const std::vector<lidar::Shot>& beside, scene::Lidar lidar,
                          int subrays, const Settings& settings, Report& report) {
  lidar.transport.subrays = subrays;
  const lidar::LidarPlan plan = lidar::make_lidar_plan(park, lidar, nullptr);
  std::vector<lidar::Shot> about = beside;
  for (auto& shot : about) shot.pupil_m = shot.exit_m, shot.pupil_axis = shot.exit_axis, shot.pupil_u = shot.exit_u;
  render::RenderOptions options;
  options.threads = settings.threads;
  render::LidarRenderer two(park.scene, options), one(park.scene, options);
  const auto fired = [&](render::LidarRenderer& renderer, const std::vector<lidar::Shot>& shots) {
    double photons = 0;
    renderer.render(plan, shots, [&](lidar::ShotResult&& result) {
      photons = std::accumulate(result.first.begin(), result.first.end(), photons);
    });
    return photons;
  };
  // 0.12 m beside it and 610 m up little is hidden: leaves' edges.
  report.validate("park, biaxial: light that the receiver beside the laser does not see, of all",
                  1 - fired(two, beside) / fired(one, about), 0.05);
  Pairs times;
  for (int i = 0; i < kPairs; ++i) {
    fired(one, about), times.ours_s.push_back(one.launch_s());
    fired(two, beside), times.reference_s.push_back(two.launch_s());
  }
  return times.ratio();
}

/// About the size of the toy blocks that HELIOS++ was timed on: ground and 91 boxes, 1110 triangles.
scene::CompiledScene toy_blocks() {
  scene::TriangleMesh mesh;
  const auto corner = [&](double x, double y, double z) {
    mesh.vertices.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
    return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  };
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c}), mesh.triangles.push_back({a, c, d});
    for (int k = 0; k < 2; ++k)
      mesh.surface.push_back(0), mesh.user_face.push_back(static_cast<std::uint32_t>(mesh.user_face.size()));
  };
  for (int i = 0; i < 9; ++i) {
    const double y0 = -120 + i * 240.0 / 9, y1 = -120 + (i + 1) * 240.0 / 9;
    quad(corner(-120, y0, 0), corner(120, y0, 0), corner(120, y1, 0), corner(-120, y1, 0));
  }
  for (int i = 0; i < 91; ++i) {
    const double x = -95 + 19.0 * (i % 10) + i % 3, y = -95 + 19.0 * (i / 10) + i % 5, a = 3 + i % 4, h = 3 + i % 12;
    std::uint32_t v[8];
    for (int k = 0; k < 8; ++k) v[k] = corner(x + (k & 1 ? a : -a), y + (k & 2 ? a : -a), k & 4 ? h : 0);
    quad(v[4], v[5], v[7], v[6]), quad(v[0], v[2], v[3], v[1]), quad(v[0], v[1], v[5], v[4]);
    quad(v[2], v[6], v[7], v[3]), quad(v[0], v[4], v[6], v[2]), quad(v[1], v[3], v[7], v[5]);
  }
  return compile({mesh}, {{kIdentity}});
}

void pulses_per_second(const Settings& settings, Report& report) {
  scene::Simulation simulation;
  simulation.scene = toy_blocks();
  scene::Lidar lidar = bench_lidar(19);
  lidar.gate.bins = 500;
  lidar.receiver.quantum_efficiency = 0.3;
  const lidar::LidarPlan plan = lidar::make_lidar_plan(simulation, lidar, nullptr);
  render::RenderOptions options;
  options.threads = settings.threads;
  render::LidarRenderer renderer(simulation.scene, options);
  const auto shots = raster(lidar, 20000);
  std::vector<double> rate, echo_rate;
  std::size_t echoes = 0;
  for (int i = 0; i < 5; ++i) {
    std::vector<lidar::ShotResult> results;
    const double traced_s = seconds_of(
        [&] { renderer.render(plan, shots, [&](lidar::ShotResult&& r) { results.push_back(std::move(r)); }); });
    if (i == 0) {
      const auto dark = std::count_if(results.begin(), results.end(),
                                      [](const lidar::ShotResult& r) { return r.ledger[0].collected <= 0; });
      report.validate("toy blocks: share of pulses without a return",
                      static_cast<double>(dark) / static_cast<double>(results.size()), 0.001);
      continue;  // warm-up
    }
    std::vector<std::size_t> found(results.size());
    const double detected_s = seconds_of([&] {
      base::for_each_index(results.size(), settings.threads,
                           [&](std::size_t s) { found[s] = lidar::detect(plan, results[s]).at(0).echoes.size(); });
    });
    echoes += std::accumulate(found.begin(), found.end(), std::size_t{0});
    rate.push_back(static_cast<double>(shots.size()) / traced_s);
    echo_rate.push_back(static_cast<double>(shots.size()) / (traced_s + detected_s));
  }
  std::size_t triangles = 0;
  for (const auto& mesh : simulation.scene.meshes) triangles += mesh.triangle_count();
  report.add("lidar_toy_triangles", static_cast<double>(triangles), "");
  report.validate("toy blocks: pulses per echo found in drawn waveforms",
                  static_cast<double>(shots.size()) * static_cast<double>(rate.size()) / static_cast<double>(echoes),
                  1.01);
  report.add("lidar_pulses_s", spread_of(rate), "pulses/s");
  report.add("lidar_pulses_with_echoes_s", spread_of(echo_rate), "pulses/s");
}

}  // namespace

void run_lidar(const Settings& settings, Report& report) {
  {
    scene::Simulation terrain;
    terrain.scene = compile({terrain_mesh()}, {{kIdentity}});
    const EmbreeBaseline embree(terrain.scene);
    const std::size_t bytes =
        terrain.scene.nodes.size() * sizeof(shared::BvhNode) + terrain.scene.blocks.size() * sizeof(shared::TriBlock);
    report.add("lidar_bytes_per_triangle", static_cast<double>(bytes) / terrain.scene.meshes[0].triangle_count(),
               "bytes", Goal::at_most(100));
    const scene::Lidar few = bench_lidar(64), many = bench_lidar(1024);
    report.add("lidar_terrain_vs_embree16_bin",
               compare(Rig(terrain, few, raster(few, 20000)), embree, settings, report, "terrain, 64 sub-rays"), "x",
               Goal::at_least(2.0));
    report.add("lidar_terrain1024_vs_embree16_bin",
               compare(Rig(terrain, many, raster(many, 4000)), embree, settings, report, "terrain, 1024 sub-rays"), "x",
               Goal::at_least(2.5));
  }
  {
    const std::string file = settings.park_file.substr(0, settings.park_file.rfind('/') + 1) + "park_survey.toml";
    scene::LoadOptions load;
    load.need_instruments = true;
    const scene::Simulation park = scene::load_simulation(file, load);
    const EmbreeBaseline embree(park.scene);
    scene::Lidar lidar = park.lidars.at(0);
    lidar.transport.overlap = scene::LidarOverlap::off;
    lidar.transport.air_return = false;
    lidar.transport.subrays = 64;
    lidar.receiver_mount = lidar.transmitter;
    lidar.gate = {2 * 540 / kLight_m_s, 1e-9, 1000};
    const auto some = [&](std::int64_t every) {
      std::vector<lidar::Shot> shots;
      for (std::int64_t pulse = 0; pulse < lidar.pulses; pulse += every)
        for (const auto& shot : lidar::make_shots(lidar, pulse, 10, 1)) shots.push_back(shot);
      return shots;
    };
    std::vector<lidar::Shot> shots = some(20);
    report.add("lidar_park_vs_embree16_bin",
               compare(Rig(park, lidar, std::move(shots)), embree, settings, report, "park, 64 sub-rays"), "x",
               Goal::at_least(1.0));
    lidar.receiver_mount = park.lidars.at(0).receiver_mount;
    const Spread few = biaxial_vs_coaxial(park, some(20), lidar, 64, settings, report),
                 many = biaxial_vs_coaxial(park, some(200), lidar, 1024, settings, report);
    report.add("lidar_biaxial64_vs_coaxial", few, "x");
    report.add("lidar_biaxial1024_vs_coaxial", many, "x");
    report.add("lidar_biaxial_vs_coaxial", few.median > many.median ? few : many, "x", Goal::at_most(1.5));
  }
  pulses_per_second(settings, report);
}

}  // namespace raycube::bench
