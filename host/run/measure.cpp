#include "host/run/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/units.h"
#include "host/plan/bounces.h"
#include "host/plan/quadrature.h"
#include "host/render/replicates.h"
#include "host/run/air_table.h"
#include "host/run/camera_job.h"
#include "scene_compiler/bvh_builder.h"
#include "scene_compiler/counter_random.h"
#include "scene_compiler/panels.h"

namespace raycube::run {

namespace {

constexpr double kFar = 2000;        ///< of the camera, in diagonals of the area
constexpr double kLongest_um = 3.0;  ///< beyond which surfaces at everyday temperatures shine by themselves

/// -180 to 180.
double turned_deg(double deg) { return deg - 360 * std::floor(deg / 360 + 0.5); }

/// RAMI's: of the sun less that of the view, rad, -pi to pi.
double rami_azimuth_rad(const MeasureView& view, const scene::Sun& sun) {
  return base::rad_by_division(turned_deg(sun.azimuth_deg - view.azimuth_deg));
}

MeasureView view_in_plane(double zenith_deg, double plane_azimuth_deg, const scene::Sun& sun) {
  const double azimuth_deg = plane_azimuth_deg + (zenith_deg < 0 ? 180 : 0);
  return {zenith_deg, azimuth_deg - 360 * std::floor(azimuth_deg / 360),
          std::abs(turned_deg(azimuth_deg - sun.azimuth_deg)), 0};
}

std::vector<MeasureView> hemisphere_views(int directions, const scene::Sun& sun) {
  const int rings = std::max(1, static_cast<int>(std::lround(std::sqrt(directions / 1.5)))),
            around = (directions + rings - 1) / rings;
  const auto nodes = plan::gauss_legendre(rings);
  std::vector<MeasureView> out;
  for (int ring = 0; ring < rings; ++ring) {
    const auto [node, weight] = nodes[static_cast<std::size_t>(ring)];
    for (int k = 0; k < around; ++k) {
      MeasureView view = view_in_plane(base::deg_from_rad(std::asin(std::sqrt(0.5 * (node + 1)))),
                                       sun.azimuth_deg + 360 * (k + 0.5 * (ring % 2)) / around, sun);
      view.weight = 0.5 * weight / around;
      out.push_back(view);
    }
  }
  return out;
}

/// The level that a measure is of, and what of the scene lies above and below it.
struct Level {
  double z_m = 0, above_m = 0, below_m = 0;
};
Level level_of(const scene::Measure& measure, const scene::CompiledScene& scene) {
  const double low = double{scene.lo[2]}, high = double{scene.hi[2]}, z = measure.height_m.value_or(high);
  return {z, std::max(high - z, 0.0), std::max(z - low, 0.0)};
}

double diagonal_m(const scene::Measure& measure) { return std::hypot(measure.size_m[0], measure.size_m[1]); }

/// To where one looks from, level and upwards.
struct Way {
  double east, north, up;
};
Way way_of(const MeasureView& view) {
  const double zenith = base::rad_by_division(std::abs(view.zenith_deg)),
               azimuth = base::rad_by_division(view.azimuth_deg);
  return {std::sin(zenith) * std::sin(azimuth), std::sin(zenith) * std::cos(azimuth), std::cos(zenith)};
}

/// A camera far off, and above all of the scene, that sees the area about a place and nothing beside it.
scene::Instrument camera_of(const scene::Measure& measure, const MeasureView& view, const Level& level,
                            const std::array<double, 2>& center_m, const std::vector<scene::Band>& bands) {
  const Way way = way_of(view);
  const double far_m = std::max(kFar * diagonal_m(measure), 2 * level.above_m / way.up);
  scene::Instrument out;
  out.name = measure.name;
  out.bands = bands;
  out.pixels = out.lines = measure.pixels;
  out.ifov_across_rad = measure.size_m[0] / far_m / measure.pixels;
  out.ifov_along_rad = measure.size_m[1] * way.up / far_m / measure.pixels;
  // It stands on the view's side, its nose towards the area: from the vertical it looks ahead by the zenith angle.
  scene::Pose pose{};
  pose.x_m = center_m[0] + far_m * way.east;
  pose.y_m = center_m[1] + far_m * way.north;
  pose.z_m = level.z_m + far_m * way.up;
  pose.pitch_deg = std::abs(view.zenith_deg);
  pose.heading_deg = view.azimuth_deg + 180;
  out.poses = {pose};
  out.sampler = scene::SamplerKind::jittered;
  const int side = std::max(1, static_cast<int>(std::lround(std::sqrt(measure.samples))));
  out.samples_u = side, out.samples_v = (measure.samples + side - 1) / side;
  out.samples_given = true;
  out.small_objects = scene::SmallObjects::off;
  return out;
}

/// Middle of the area in a batch: in a scene that repeats elsewhere in its cell each time, along the R2 sequence from a
/// place by chance, since the area turns with the view and a turned cell would see some of it twice.
std::array<double, 2> center_of(const scene::Measure& measure, const std::optional<std::array<double, 2>>& cell_m,
                                std::uint64_t view, int batch) {
  std::array<double, 2> out = measure.center_m;
  if (!cell_m) return out;
  constexpr std::array<double, 2> kSteps{0.7548776662466927, 0.5698402909980532};
  for (std::size_t k = 0; k < 2; ++k) {
    const double place = scene::counter_uniform(0x3ea5, 0, view, k) + batch * kSteps[k];
    out[k] += (place - std::floor(place) - 0.5) * (*cell_m)[k];
  }
  return out;
}

/// Mean radiance of all pixels, [band].
std::vector<double> mean_radiance(render::Renderer& renderer, const scene::Instrument& camera, const plan::Plan& plan,
                                  const scene::Sun& sun, std::uint64_t seed) {
  std::vector<render::Tile> lines;
  for (int line = 0; line < camera.lines; ++line) lines.push_back({line, 1, 0, camera.pixels});
  const std::vector<float> found = renderer.draws_of(camera, plan, sun, {{seed, 0}}, lines)[0];
  const std::size_t bands = camera.bands.size();
  std::vector<double> mean(bands, 0.0);
  for (std::size_t i = 0; i < found.size(); ++i) mean[i % bands] += static_cast<double>(found[i]);
  for (double& value : mean) value *= static_cast<double>(bands) / static_cast<double>(found.size());
  return mean;
}

/// A level white plane and nothing else.
scene::CompiledScene white_panel() {
  scene::CompiledScene out;
  scene::Material white;
  white.name = "white";
  white.reflectance = {{0.05, 100.0}, {1.0, 1.0}};
  out.materials = {white};
  shared::Surface surface{};
  surface.material[0] = 1, surface.fraction[0] = 1;
  out.surfaces = {surface};
  const auto mesh =
      scene::plane_mesh({0, 0, 0}, {1000, 1000}, 0, 0, {0, [](std::uint32_t, std::uint32_t) { return 0u; }});
  scene::append_instance(out, out.meshes[scene::append_mesh(out, "panel", mesh)].tree,
                         {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, 0);
  scene::finish_top_tree(out);
  return out;
}

/// Radiance of an ideal white panel under the measure's sun, [band].
std::vector<double> white_radiance(const render::RenderOptions& options, const scene::Simulation& simulation,
                                   const std::vector<scene::Band>& bands, Services& services) {
  scene::Simulation panel;
  panel.scene = white_panel();
  panel.sun = simulation.sun;
  panel.atmosphere = simulation.atmosphere;
  panel.sky_directions = 1, panel.sky_directions_given = true, panel.paths_per_two = 1;
  scene::Measure small;
  small.name = "panel", small.size_m = {10, 10}, small.pixels = 4, small.samples = 1;
  const scene::Instrument camera = camera_of(small, {}, {}, {0, 0}, bands);
  render::Renderer renderer(panel.scene, options);
  const CameraJob job = prepare_camera(panel, camera, services);
  return mean_radiance(renderer, *job.instrument, job.plan, panel.sun, 1);
}

/// Reflectance factors of every batch, [batch][band].
using Batches = std::vector<std::vector<double>>;

ReflectanceFactor factor_of(const Batches& all, const Batches& single, std::size_t band) {
  std::vector<double> whole, more;
  for (std::size_t batch = 0; batch < all.size(); ++batch) {
    whole.push_back(all[batch][band]);
    more.push_back(all[batch][band] - single[batch][band]);
  }
  return {measured(whole), measured(more)};
}

void add(Batches& sum, const Batches& more, double weight) {
  if (sum.empty()) sum.assign(more.size(), std::vector<double>(more[0].size(), 0.0));
  for (std::size_t i = 0; i < more.size(); ++i)
    for (std::size_t b = 0; b < more[i].size(); ++b) sum[i][b] += weight * more[i][b];
}

}  // namespace

Measured measured(const std::vector<double>& batches) {
  const auto count = static_cast<double>(batches.size());
  double sum = 0, square = 0;
  for (const double value : batches) sum += value;
  for (const double value : batches) square += (value - sum / count) * (value - sum / count);
  return {sum / count, std::sqrt(square / (count - 1) / count)};
}

const std::vector<scene::Band>& bands_of(const scene::Simulation& simulation, const std::string& instrument) {
  const auto found = std::find_if(simulation.instruments.begin(), simulation.instruments.end(),
                                  [&](const scene::Instrument& one) { return one.name == instrument; });
  if (found == simulation.instruments.end()) throw base::Error(base::Fault::bug, "no instrument '" + instrument + "'");
  return found->bands;
}

void check_sun(const scene::Simulation& simulation, const std::string& who) {
  if (simulation.sun.moon_phase_deg < 0 && simulation.sun.zenith_deg < 89.9) return;
  throw base::Error(
      base::Fault::input,
      fmt::format("{} wants a sun above the horizon (found zenith {} deg{}); give time.sun a zenith_deg below "
                  "89.9",
                  who, simulation.sun.zenith_deg, simulation.sun.moon_phase_deg >= 0 ? ", the moon" : ""));
}

void check_sunlit_bands(const scene::Simulation& simulation, const std::string& who, const std::string& instrument) {
  if (const double last_um = band_range(bands_of(simulation, instrument)).second; last_um > kLongest_um)
    throw base::Error(base::Fault::input,
                      fmt::format("{} is of sunlight (found bands up to {:g} um of instrument '{}'); name an "
                                  "instrument of bands up to {:g} um in bands_of",
                                  who, last_um, instrument, kLongest_um));
}

namespace {

/// Refuses views that look past the scene, where nothing is.
void check_reach(const scene::Simulation& simulation, const scene::Measure& measure) {
  const scene::CompiledScene& scene = simulation.scene;
  if (scene.instances.empty())
    throw base::Error(base::Fault::input, fmt::format("measure '{}' has nothing to look at (found an empty scene); add "
                                                      "[[plane]], [[terrain]] or [[mesh]]",
                                                      measure.name));
  const Level level = level_of(measure, scene);
  for (const MeasureView& view : measure_views(measure, simulation.sun)) {
    const Way way = way_of(view);
    const double down = level.below_m / way.up, half = 0.5 * diagonal_m(measure);
    const std::array<double, 2> beyond{-down * way.east, -down * way.north};
    for (std::size_t k = 0; k < 2; ++k) {
      const double around = half + (simulation.cell_m ? 0.5 * (*simulation.cell_m)[k] : 0.0);
      const double low = measure.center_m[k] - around + std::min(0.0, beyond[k]),
                   high = measure.center_m[k] + around + std::max(0.0, beyond[k]);
      if (low >= double{scene.lo[k]} && high <= double{scene.hi[k]}) continue;
      throw base::Error(base::Fault::input,
                        fmt::format("measure '{}' looks past the scene's edge from {:.1f} deg off the zenith (found {} "
                                    "from {:g} to {:g} m, the scene from {:g} to {:g} m); {}",
                                    measure.name, view.zenith_deg, k == 0 ? "x" : "y", low, high, double{scene.lo[k]},
                                    double{scene.hi[k]},
                                    simulation.cell_m ? "give scene.periodic more copies"
                                                      : "give a smaller area, wider ground, or smaller zenith angles"));
    }
  }
}

}  // namespace

void check_measure(const scene::Simulation& simulation, const scene::Measure& measure) {
  const std::string who = "measure '" + measure.name + "'";
  check_sun(simulation, who);
  check_sunlit_bands(simulation, who, measure.bands_of);
  check_reach(simulation, measure);
}

std::vector<MeasureView> measure_views(const scene::Measure& measure, const scene::Sun& sun) {
  if (measure.views == scene::MeasureViews::hemisphere) return hemisphere_views(measure.directions, sun);
  const double plane_deg = sun.azimuth_deg - (measure.views == scene::MeasureViews::orthogonal ? 90 : 0);
  std::vector<MeasureView> out;
  const auto steps = static_cast<int>(std::floor((measure.last_deg - measure.first_deg) / measure.step_deg + 1e-9));
  for (int i = 0; i <= steps; ++i)
    out.push_back(view_in_plane(measure.first_deg + i * measure.step_deg, plane_deg, sun));
  return out;
}

MeasureResult measure(render::Renderer& renderer, const render::RenderOptions& options, scene::Simulation& simulation,
                      const scene::Measure& measure, Services& services) {
  const std::vector<scene::Band> bands = bands_of(simulation, measure.bands_of);
  check_measure(simulation, measure);
  simulation.atmosphere = {};
  simulation.atmosphere.none = true;
  simulation.thermal_below_3um = false;
  simulation.lamps.clear();
  simulation.sky_directions = 2 * measure.paths, simulation.sky_directions_given = true, simulation.paths_per_two = 1;
  simulation.bounces_given = true;
  const std::vector<double> white = white_radiance(options, simulation, bands, services);
  const Level level = level_of(measure, simulation.scene);

  MeasureResult out;
  out.views = measure_views(measure, simulation.sun);
  for (const scene::Band& band : bands) out.wavelength_um.push_back(band.center_um);
  // Nothing of a plan without air depends on where one looks from.
  const CameraJob job =
      prepare_camera(simulation, camera_of(measure, out.views.front(), level, measure.center_m, bands), services);
  const plan::Plan once = plan::without_paths(job.plan);
  Batches sum_all, sum_single;
  const Step step(services, "views of " + measure.name, out.views.size(), "directions");
  for (std::size_t v = 0; v < out.views.size(); ++v) {
    Batches all, single;
    for (int batch = 0; batch < kMeasureBatches; ++batch) {
      const scene::Instrument camera =
          camera_of(measure, out.views[v], level, center_of(measure, simulation.cell_m, v, batch), bands);
      const std::uint64_t seed = render::replicate_seed(simulation.seed + 0x9e3779b97f4a7c15ull * (v + 1), batch);
      const auto factors = [&](const plan::Plan& plan) {
        std::vector<double> found = mean_radiance(renderer, camera, plan, simulation.sun, seed);
        for (std::size_t b = 0; b < found.size(); ++b) found[b] /= white[b];
        return found;
      };
      all.push_back(factors(job.plan));
      single.push_back(job.plan.bounces.any() ? factors(once) : all.back());
    }
    auto& view = out.factor.emplace_back();
    for (std::size_t b = 0; b < bands.size(); ++b) view.push_back(factor_of(all, single, b));
    if (measure.views == scene::MeasureViews::hemisphere)
      add(sum_all, all, out.views[v].weight), add(sum_single, single, out.views[v].weight);
    step.advance();
  }
  for (std::size_t b = 0; !sum_all.empty() && b < bands.size(); ++b)
    out.albedo.push_back(factor_of(sum_all, sum_single, b));
  return out;
}

std::string measure_csv(const scene::Measure& measure, const MeasureResult& result) {
  std::string out = "# raycube measure '" + measure.name +
                    "': reflectance factors under the sun alone, without air; errors are standard errors\n"
                    "view_zenith_deg,view_azimuth_deg,relative_azimuth_deg,wavelength_um,brf,brf_error,brf_multiple,"
                    "brf_multiple_error\n";
  for (std::size_t v = 0; v < result.views.size(); ++v)
    for (std::size_t b = 0; b < result.wavelength_um.size(); ++b) {
      const MeasureView& view = result.views[v];
      const ReflectanceFactor& factor = result.factor[v][b];
      out += fmt::format("{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.4g},{:.9g},{:.4g}\n", view.zenith_deg, view.azimuth_deg,
                         view.relative_azimuth_deg, result.wavelength_um[b], factor.all.mean, factor.all.error,
                         factor.multiple.mean, factor.multiple.error);
    }
  return out;
}

std::string measure_mes(const MeasureResult& result, const scene::Sun& sun, std::size_t band,
                        Measured ReflectanceFactor::*part) {
  // https://rami-benchmark.jrc.ec.europa.eu, measurement brfpp: rows, columns, ratio of filtered rays; then zenith of
  // the sun and of the view, azimuth of the sun less that of the view, factor and standard deviation.
  std::string out = fmt::format("{:4d} {:4d} {:.6f}\n", result.views.size(), 5, 1.0);
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    const MeasureView& view = result.views[v];
    const Measured& value = result.factor[v][band].*part;
    out += fmt::format("{:.6f} {:.6f} {:.6f} {:.6f} {:.6f}\n", base::rad_by_division(sun.zenith_deg),
                       base::rad_by_division(std::abs(view.zenith_deg)), rami_azimuth_rad(view, sun), value.mean,
                       value.error);
  }
  return out;
}

nlohmann::ordered_json measure_json(const scene::Measure& measure, const MeasureResult& result) {
  nlohmann::ordered_json all = {
      {"measure", measure.name}, {"wavelength_um", result.wavelength_um}, {"views", nlohmann::json::array()}};
  const auto told = [](const std::vector<ReflectanceFactor>& factors) {
    nlohmann::ordered_json out;
    for (const ReflectanceFactor& factor : factors) {
      out["mean"].push_back(factor.all.mean), out["error"].push_back(factor.all.error);
      out["multiple"].push_back(factor.multiple.mean), out["multiple_error"].push_back(factor.multiple.error);
    }
    return out;
  };
  for (std::size_t v = 0; v < result.views.size(); ++v)
    all["views"].push_back({{"zenith_deg", result.views[v].zenith_deg},
                            {"azimuth_deg", result.views[v].azimuth_deg},
                            {"relative_azimuth_deg", result.views[v].relative_azimuth_deg},
                            {"brf", told(result.factor[v])}});
  if (!result.albedo.empty()) all["albedo"] = told(result.albedo);
  return all;
}

}  // namespace raycube::run
