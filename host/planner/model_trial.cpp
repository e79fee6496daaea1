#include "host/planner/model_trial.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/interrupt.h"
#include "host/base/parallel.h"
#include "host/reference/radiance.h"
#include "host/planner/judged_pixels.h"
#include "host/sensors/ray_groups.h"
#include "host/base/units.h"
#include "scene_compiler/matter.h"

namespace raycube::planner {

namespace {

constexpr int kPixelStep = 4;                        ///< of a run: two of its eight
constexpr std::uint64_t kModelPixels = 0x2545f491u;  ///< added to the seed

using Band = double (*)(const reference::BandRadiance&, std::size_t);

/// Share of a pixel that materials of these weights cover.
double weight_of(const scene::CompiledScene& scene, const std::vector<double>& material,
                 const reference::SampledPixel& pixel) {
  double share = 0;
  for (const reference::Sample& sample : pixel.samples)
    if (!sample.hit.miss())
      scene::for_each_material(
          scene.surfaces[scene::surface_of(scene, sample.hit.primitive)],
          [&](std::size_t m, float fraction) { share += sample.weight * material[m] * static_cast<double>(fraction); });
  return share;
}

double part(const std::vector<double>& value, std::size_t band) { return value.empty() ? 0 : value[band]; }

}  // namespace

ModelPixels compare_models(const scene::Simulation& simulation, const scene::Instrument& instrument,
                           const plan::Plan& plan, const atmos::RenderTable& table,
                           const std::vector<render::Tile>& tiles, const ModelSettings& settings) {
  scene::Instrument few = instrument;
  few.sampler = scene::SamplerKind::jittered;
  few.samples_u = few.samples_v = settings.side;
  const reference::ReferenceScene scene(simulation.scene);
  const reference::TableModel whole(scene, plan, table, simulation.atmosphere.none, settings.directions,
                                    {0, settings.turn_rad});

  plan::Plan same = plan;  // that looks where the table does, and takes all of the sky for granted
  same.sky.open_share.clear();
  std::vector<std::array<double, 8>> light;
  for (const glm::dvec3& d : whole.directions()) light.push_back(reference::sky_light(plan, d));
  // The open sky as those directions add it up; the surroundings, of one radiance, in closed form.
  const auto open = [&](const glm::dvec3& normal) {
    std::array<double, 8> sum{};
    if (plan.components() == 0) return sum;
    for (std::size_t k = 0; k < light.size(); ++k) {
      const double cosine = std::max(0.0, glm::dot(normal, whole.directions()[k])) * whole.solid_angle_sr();
      for (std::size_t m = 0; m < sum.size(); ++m) sum[m] += cosine * light[k][m];
    }
    if (plan.thermal.on) sum[static_cast<std::size_t>(plan.components()) - 1] = std::numbers::pi * (1 - normal.z) / 2;
    return sum;
  };
  const reference::ArithmeticModel planned(simulation.scene, same, open);
  const auto look = [&](const reference::Sample& side) {
    reference::SentRays sent;
    for (const glm::dvec3& direction :
         plan.components() > 0 && !side.hit.miss() ? whole.directions() : std::vector<glm::dvec3>{}) {
      const double cosine = glm::dot(side.normal, direction);
      if (cosine > 0)
        sent.push_back(
            {direction, cosine * whole.solid_angle_sr(), whole.solid_angle_sr(), scene.sees(side, direction)});
    }
    return sent;
  };

  std::vector<reference::PixelAddress> pixels;
  const int width = sensors::pixels_per_group(instrument), per_line = sensors::groups_per_line(instrument);
  for (const render::Tile& tile : tiles) {
    const auto groups = sensors::make_ray_groups(instrument, simulation.scene, tile.first_line, tile.lines);
    for (int line = 0; line < tile.lines; ++line)
      reference::append_addresses(pixels, tile.first_line + line, tile.first_column, tile.columns,
                                  groups.data() + line * per_line, width);
  }
  ModelPixels out;
  out.planned.resize(pixels.size()), out.whole.resize(pixels.size());
  const std::vector<double> material = material_weights(simulation);
  if (!material.empty()) out.weight.resize(pixels.size());
  base::for_each_index(pixels.size(), settings.threads, [&](std::size_t p) {
    base::throw_if_interrupted();
    const reference::SampledPixel pixel = scene.sample_pixel(few, same, settings.seed, pixels[p]);
    std::vector<reference::SentRays> sent;
    for (std::size_t i = 0; i < pixel.sides(); ++i) sent.push_back(look(pixel.side(i)));
    out.planned[p] = planned.radiance(pixel, sent);
    out.whole[p] = whole.radiance(pixel);
    if (!material.empty()) out.weight[p] = static_cast<float>(weight_of(simulation.scene, material, pixel));
  });
  return out;
}

ModelError model_error(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan,
                       const atmos::RenderTable& table, int threads, int directions) {
  TrialImage image;
  std::vector<render::Tile> tiles;
  for (const render::Tile& run : trial_tiles(instrument, simulation.seed + kModelPixels)) {
    for (int column = run.first_column; column < run.first_column + run.columns; column += kPixelStep)
      tiles.push_back({run.first_line, 1, column, 1});
    image.run_end.push_back(tiles.size());
  }
  ModelSettings settings;
  settings.seed = simulation.seed, settings.threads = threads, settings.directions = directions;
  auto [ours, theirs, weight] = compare_models(simulation, instrument, plan, table, tiles, settings);
  image.bands = plan.bands.size();
  image.figure = simulation.tolerance_of.figure;
  if (std::any_of(weight.begin(), weight.end(), [](float w) { return w > 0; })) image.weight = std::move(weight);
  image.left_out = 1 - static_cast<double>(tiles.size()) / (static_cast<double>(instrument.pixels) * instrument.lines);
  const auto image_of = [&](const std::vector<reference::BandRadiance>& radiance, Band value) {
    TrialImage out = image;
    for (const reference::BandRadiance& pixel : radiance)
      for (std::size_t b = 0; b < out.bands; ++b) out.radiance.push_back(static_cast<float>(value(pixel, b)));
    return out;
  };
  const auto all = [](const reference::BandRadiance& r, std::size_t b) { return r.total(b) - r.surroundings[b]; };
  const std::vector<double> mean =
      judged_means(image_of(theirs, [](const reference::BandRadiance& r, std::size_t b) { return r.total(b); }));
  const auto error = [&](Band value) { return error_from(image_of(ours, value), image_of(theirs, value), mean); };
  ModelError out;
  out.pixels = tiles.size();
  out.total = error(all);
  out.sun = error([](const reference::BandRadiance& r, std::size_t b) { return r.sun[b]; });
  out.sky = error([](const reference::BandRadiance& r, std::size_t b) { return r.sky[b]; });
  out.path = error([](const reference::BandRadiance& r, std::size_t b) { return r.path[b]; });
  out.environment = error([](const reference::BandRadiance& r, std::size_t b) { return part(r.environment, b); });
  out.emission = error([](const reference::BandRadiance& r, std::size_t b) { return r.emission[b]; });
  return out;
}

}  // namespace raycube::planner
