// The planner's trial on scenes whose errors are known in closed form (S60, S61).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <nlohmann/json.hpp>

#include "atmos_tables/synthetic.h"
#include "host/base/error.h"
#include "host/planner/plan_file.h"
#include "host/planner/plan_lines.h"
#include "host/planner/planner.h"
#include "host/planner/replicated.h"
#include "host/render/truth.h"
#include "host/sensors/view_bounds.h"
#include "tests/support/chance_checks.h"
#include "tests/support/full.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
using namespace raycube::planner;

constexpr double kGsd_m = 0.5, kDark = 0.2, kBright = 0.6;

/// A plane of stripes along y in front of a uniform sky of radiance 1, seen by 64 x 64 pixels: radiance = reflectance.
struct Stripes {
  scene::Simulation simulation;
  double period_m, first_m;

  explicit Stripes(double period, double bright = kBright) : period_m(period) {
    const auto a = test::add_material(simulation.scene, "dark", kDark),
               b = test::add_material(simulation.scene, "bright", bright);
    std::vector<scene::TriangleMesh> parts;
    const double half = 32 * kGsd_m + 2 * period_m;
    first_m = -half;
    for (double x = -half; x < half; x += period_m / 2)
      parts.push_back(test::rectangle({x, -half, 0}, {period_m / 2, 0, 0}, {0, 2 * half, 0}, parts.size() % 2 ? b : a));
    test::place(simulation.scene, test::join(parts));
    finish_top_tree(simulation.scene);
    simulation.sun.zenith_deg = 120, simulation.seed = testing::seed(simulation.seed);
    simulation.instruments = {test::nadir_camera(64, 64, 1000, kGsd_m)};
  }
  /// 1 on bright.
  double bright_at(double x) const { return std::fmod((x - first_m) / period_m, 1.0) >= 0.5; }
  /// Bright share of first .. x, m.
  double bright_up_to(double x) const {
    const double turns = (x - first_m) / period_m, whole = std::floor(turns);
    return period_m * (0.5 * whole + std::max(0.0, turns - whole - 0.5));
  }
  double left(int column) const { return (column - 32) * kGsd_m; }
  double exact(int column) const { return (bright_up_to(left(column) + kGsd_m) - bright_up_to(left(column))) / kGsd_m; }
  /// Under a Gaussian of the pixels' square, cut to `support` pixels and of sum 1: its sum at midpoints. The response
  /// at a distance is the difference of two normal distributions, half a pixel to either side.
  double blurred(int column, double sigma_px, double support_px) const {
    constexpr int kSteps = 4000;
    const auto below = [&](double u) { return std::erf(u / (sigma_px * std::sqrt(2.0))); };
    double sum = 0, weight = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double u = ((i + 0.5) / kSteps - 0.5) * support_px, response = below(u + 0.5) - below(u - 0.5);
      weight += response;
      sum += response * (bright_at(left(column) + (0.5 + u) * kGsd_m) ? kBright : kDark);
    }
    return sum / weight;
  }
  double sampled(int column, int side) const {
    double sum = 0;
    for (int i = 0; i < side; ++i) sum += bright_at(left(column) + (i + 0.5) / side * kGsd_m);
    return sum / side;
  }
  /// rms of a side's error over columns, over the mean radiance.
  double error(const std::vector<int>& columns, int side) const {
    double squares = 0, mean = 0;
    for (const int c : columns)
      squares += std::pow((kBright - kDark) * (sampled(c, side) - exact(c)), 2),
          mean += kDark + (kBright - kDark) * exact(c);
    const auto n = static_cast<double>(columns.size());
    return std::sqrt(squares / n) / (mean / n);
  }
};

const atmos::RenderTable& sky_of_one() {
  static const atmos::RenderTable table = atmos::uniform_sky_table(0, 1, {0.3, 1.0, 4.0}, 120);
  return table;
}

plan::Plan plan_of(const scene::Simulation& simulation) {
  const auto& instrument = simulation.instruments[0];
  return plan::make_plan(simulation, instrument, sky_of_one(), sensors::view_bounds(instrument));
}

/// Rms over all pixels of how far what a decision renders is off what a column should have, over the mean of that.
double achieved(render::Renderer& renderer, const scene::Simulation& simulation, const Sampling& sampling,
                const plan::Plan& plan, const std::function<double(int column)>& want_of) {
  scene::Instrument camera = simulation.instruments[0];
  camera.sampler = sampling.sampler, camera.samples_u = sampling.samples_u, camera.samples_v = sampling.samples_v;
  camera.replicates = sampling.replicates;
  double squares = 0, mean = 0;
  std::vector<double> wanted;
  for (int column = 0; column < 64; ++column) wanted.push_back(want_of(column));
  renderer.probe(camera, plan, simulation.sun, simulation.seed, {{0, 64, 0, 64}}, [&](const render::PixelProbe& probe) {
    for (std::size_t p = 0; p < 64 * 64; ++p) {
      const double want = wanted[p % 64];
      squares += std::pow(probe.radiance[p * camera.bands.size()] - want, 2), mean += want;
    }
  });
  return std::sqrt(squares / 4096) / (mean / 4096);
}

}  // namespace

TEST_CASE("S60: a plane of one reflectance under an open sky needs one sample and one direction") {
  Stripes scene(5.37 * kGsd_m, kDark);
  scene.simulation.instruments[0].standard_error = scene::StandardError::worst;  // which takes a trial
  const plan::Plan plan = plan_of(scene.simulation);
  render::Renderer renderer(scene.simulation.scene, {});
  const Decision d = decide(renderer, scene.simulation, scene.simulation.instruments[0], plan, sky_of_one(), false);
  CHECK(d.sampling.samples_u == 1);
  CHECK(d.sampling.directions == 1);
  CHECK(d.within);
  CHECK(d.notes.empty());
  CHECK(d.samples_error < 1e-5);
  CHECK(d.sky_error < 1e-5);
  // Rendered at once it takes the fewest replicates, which is less than a trial.
  scene::Simulation plain = scene.simulation;
  plain.instruments[0].standard_error = scene::StandardError::off;
  const Decision at_once = decide(renderer, plain, plain.instruments[0], plan, sky_of_one(), false);
  REQUIRE(at_once.image);
  CHECK(at_once.sampling.replicates == 4);
  CHECK(at_once.total_error < 1e-4);
}

TEST_CASE("S60: the trial finds the sampling error of stripes that integration gives") {
  const Stripes scene(5.37 * kGsd_m);
  const plan::Plan plan = plan_of(scene.simulation);
  render::Renderer renderer(scene.simulation.scene, {});
  PixelTrial trial(renderer, scene.simulation, scene.simulation.instruments[0], plan);
  std::vector<int> columns(64);  // of so small an image the trial looks at all
  std::iota(columns.begin(), columns.end(), 0);
  for (const int side : {2, 4, 7}) {
    const double want = scene.error(columns, side);
    const TrialError found = trial.sampling_error(scene::SamplerKind::grid, side, side);
    CAPTURE(side);
    // The references' 32 rows of random points leave 0.4 / 32 / sqrt(32) of the contrast, a twentieth of the error
    // sought. They err independently in some 1500 pixels that see an edge, once against the error and once against each
    // other: 0.05 / sqrt(1500), four times.
    CHECK_WITHIN(found.estimate / want - 1, 0.005);
    CHECK_ABOVE(found.bound, found.estimate);
  }
}

TEST_CASE("S60: replicates of a lattice find the error that integration gives for it") {
  // Stripes across the pixels: of a lattice shifted by a hash in each, the rms over pixels is that over shifts. The
  // oracle renders 64 x 64 pixels and holds them against integration.
  const Stripes scene(5.37 * kGsd_m);
  const plan::Plan plan = plan_of(scene.simulation);
  render::Renderer renderer(scene.simulation.scene, {});
  PixelTrial trial(renderer, scene.simulation, scene.simulation.instruments[0], plan);
  for (const int samples : {5, 21, 55}) {
    scene::Instrument camera = scene.simulation.instruments[0];
    camera.sampler = scene::SamplerKind::lattice, camera.samples_u = samples, camera.samples_v = 1;
    double squares = 0, mean = 0;
    constexpr int kDraws = 8;
    for (std::uint64_t draw = 0; draw < kDraws; ++draw)
      renderer.probe(camera, plan, scene.simulation.sun, testing::seed(77) + draw, {{0, 64, 0, 64}},
                     [&](const render::PixelProbe& probe) {
                       for (std::size_t p = 0; p < 64 * 64; ++p) {
                         const double want = kDark + (kBright - kDark) * scene.exact(static_cast<int>(p % 64));
                         squares += std::pow(probe.radiance[p * camera.bands.size()] - want, 2), mean += want;
                       }
                     });
    const double want = std::sqrt(squares / (4096 * kDraws)) / (mean / (4096 * kDraws));
    const SettingErrors found = trial.replicates(samples, 1);
    CAPTURE(samples);
    // 64 columns in 4096 pixels with shifts of their own: some 1500 pixels see an edge, and eight mean squares of as
    // many draws are known to 1.3 %; the trial says how well it knows its own.
    CHECK_WITHIN(found.samples.estimate / want - 1,
                 4 * std::hypot(found.samples.bound / found.samples.estimate - 1, 0.0065));
    CHECK_ABOVE(found.samples.bound, found.samples.estimate);
    CHECK(found.sky.estimate < 1e-5);
  }
}

TEST_CASE("S61: planned samples keep their tolerance on all pixels, and finer tolerances cost more") {
  const Stripes scene(5.37 * kGsd_m);
  scene::Simulation simulation = scene.simulation;
  render::Renderer renderer(simulation.scene, {});
  // Against integration: stripes run along the pixels, so a lattice may be chosen.
  const auto want = [&](int column) { return kDark + (kBright - kDark) * scene.exact(column); };
  double last_cost = 0;
  for (const double tolerance : {0.1, 0.02}) {
    simulation.tolerance = tolerance;
    const plan::Plan plan = plan_of(simulation);
    const Decision d = decide(renderer, simulation, simulation.instruments[0], plan, sky_of_one(), false);
    CAPTURE(tolerance);
    CAPTURE(d.sampling.samples_u);
    REQUIRE(d.within);
    CHECK_BELOW(achieved(renderer, simulation, d.sampling, plan, want), tolerance);
    CHECK_BELOW(d.total_error, tolerance);
    CHECK(d.s_per_megapixel >= last_cost);
    last_cost = d.s_per_megapixel;
    scene::Simulation tried = simulation;
    tried.instruments[0].standard_error = scene::StandardError::worst;  // which takes a trial
    const Decision by_trial = decide(renderer, tried, tried.instruments[0], plan, sky_of_one(), false);
    CHECK_FALSE(by_trial.image);
    REQUIRE(by_trial.within);
    CHECK_BELOW(achieved(renderer, simulation, by_trial.sampling, plan, want), tolerance);
  }
}

TEST_CASE("S61: an image that costs less than a trial is its replicates, the same when rendered anew") {
  // The second scene has a bright plate of a tenth of a pixel, which small objects render by themselves.
  const Stripes scene(5.37 * kGsd_m);
  scene::Simulation simulation = scene.simulation;
  simulation.tolerance = 0.03;
  scene::Instrument& camera = simulation.instruments[0];
  for (const bool small : {false, true}) {
    if (small) {
      const float side = 0.3f * static_cast<float>(kGsd_m);
      test::place(simulation.scene, test::rectangle({1.1f, 2.3f, 0.001f}, {side, 0, 0}, {0, side, 0},
                                                    test::add_material(simulation.scene, "plate", 0.9)));
      finish_top_tree(simulation.scene);
      camera.small_objects = scene::SmallObjects::on;
    }
    render::Renderer renderer(simulation.scene, {});
    plan::Plan plan = plan_of(simulation);
    Decision d = decide(renderer, simulation, camera, plan, sky_of_one(), false);
    REQUIRE(d.image);
    CHECK(d.sampling.replicates == d.image->sums.count());
    CHECK(d.sampling.replicates >= 4);
    add_small_objects(d, camera, sensors::SmallObjectPixels(simulation.scene, camera));
    scene::Instrument planned = camera;
    apply(d, planned, plan);
    CHECK((planned.small_objects == scene::SmallObjects::on) == small);
    const auto image = [&](int tile_lines, const render::RenderedImage* rendered, render::RenderStatistics& found) {
      render::RenderOptions options;
      options.tile_lines = tile_lines;
      render::Renderer other(simulation.scene, options);
      std::vector<float> all, truth;
      found = other.render(
          planned, plan, simulation.sun, simulation.seed,
          [&](const render::Strip& strip) {
            const std::size_t pixels = static_cast<std::size_t>(strip.lines) * 64,
                              layers = render::truth_layer_names(simulation.scene).size();
            all.insert(all.end(), strip.radiance, strip.radiance + pixels * camera.bands.size());
            for (std::size_t i = 0; i < pixels * layers; ++i)  // not a number is not itself
              truth.push_back(std::isnan(strip.truth[i]) ? -1e30f : strip.truth[i]);
          },
          {}, rendered);
      all.insert(all.end(), truth.begin(), truth.end());
      return all;
    };
    render::RenderStatistics kept, anew, narrow;
    const auto from_kept = image(64, d.image.get(), kept);
    CHECK(from_kept == image(64, nullptr, anew));
    CHECK(kept.primary_rays == anew.primary_rays);
    CHECK(kept.sky_rays == anew.sky_rays);
    CHECK(kept.small_object_pixels == anew.small_object_pixels);
    CHECK(anew.small_object_pixels.empty() != small);
    // What a render anew says of its error is what the planner was told, in tiles of any height.
    const TrialError told = error_of(d.image->sums.spread()), again = error_of(anew.spread);
    CHECK(std::abs(again.bound - told.bound) < 1.1e-6);  // the steps it is told in
    CHECK(from_kept == image(5, nullptr, narrow));
    CHECK(std::abs(error_of(narrow.spread).bound - told.bound) < 1.1e-6);
    CHECK(std::abs(std::hypot(d.plan_error, told.bound) - d.total_error) < 1e-12);
    CHECK(d.within);
    // With little memory nothing is kept, and the choice is the same.
    render::RenderOptions little;
    little.memory_bytes = 1000 << 10;
    render::Renderer narrow_renderer(simulation.scene, little);
    const Decision again_d = decide(narrow_renderer, simulation, camera, plan_of(simulation), sky_of_one(), false);
    CHECK_FALSE(again_d.image);
    CHECK(again_d.sampling.replicates == d.sampling.replicates);
    CHECK(std::abs(again_d.total_error - d.total_error) < 1.1e-6);
    if (small) continue;
    // Against integration; of some 1500 pixels with an edge, as above.
    const auto want = [&](int column) { return kDark + (kBright - kDark) * scene.exact(column); };
    CHECK_WITHIN(achieved(renderer, simulation, d.sampling, plan, want) / told.estimate - 1, 0.05);
  }
}

TEST_CASE("S61: replicates are left where they would cost more than a trial") {
  const Stripes scene(5.37 * kGsd_m);
  scene::Simulation simulation = scene.simulation;
  simulation.tolerance = 0.0005;  // some ten thousand samples
  render::Renderer renderer(simulation.scene, {});
  const Decision d = decide(renderer, simulation, simulation.instruments[0], plan_of(simulation), sky_of_one(), false);
  CHECK_FALSE(d.image);
  CHECK(d.sampling.replicates == 1);
  CHECK(d.within);
  for (const auto change : {0, 1, 2, 3}) {
    scene::Simulation other = simulation;
    scene::Instrument& camera = other.instruments[0];
    if (change == 0) camera.samples_given = true;
    if (change == 1) other.sky_directions_given = true;
    if (change == 2) camera.psf_sigma_px = 0.5, camera.psf_support_px = 4;
    if (change == 3) camera.standard_error = scene::StandardError::worst;
    CAPTURE(change);
    CHECK_FALSE(may_replicate(other, camera, plan_of(other)));
  }
  CHECK(may_replicate(simulation, simulation.instruments[0], plan_of(simulation)));
}

TEST_CASE("S61: under a point spread cells are chosen, whose weighing counts as their error") {
  const Stripes scene(5.37 * kGsd_m);
  scene::Simulation simulation = scene.simulation;
  scene::Instrument& camera = simulation.instruments[0];
  camera.psf_sigma_px = 0.5, camera.psf_support_px = 4;
  render::Renderer renderer(simulation.scene, {});
  for (const double tolerance : {0.05, testing::full() ? 0.01 : 0.02}) {
    simulation.tolerance = tolerance;
    const plan::Plan plan = plan_of(simulation);
    const Decision d = decide(renderer, simulation, camera, plan, sky_of_one(), false);
    CAPTURE(tolerance);
    CAPTURE(d.sampling.samples_u);
    CHECK(d.sampling.sampler == scene::SamplerKind::jittered);
    CHECK(d.sampling.samples_u == d.sampling.samples_v);
    REQUIRE(d.within);
    const auto want = [&](int column) { return scene.blurred(column, 0.5, 4); };
    CHECK_BELOW(achieved(renderer, simulation, d.sampling, plan, want), tolerance);
  }
}

TEST_CASE("S60: where the look's samples just do they are taken, and no more directions than the open sky needs") {
  const Stripes scene(5.37 * kGsd_m);
  scene::Simulation simulation = scene.simulation;
  simulation.instruments[0].standard_error = scene::StandardError::worst;  // which takes a trial
  render::Renderer renderer(simulation.scene, {});
  {
    const plan::Plan plan = plan_of(simulation);
    PixelTrial trial(renderer, simulation, simulation.instruments[0], plan);
    const auto error = [&](int samples) { return trial.replicates(samples, 1).samples.estimate; };
    simulation.tolerance = 1.15 * error(21);  // and the next coarser lattice does not hold it
    REQUIRE(error(18) > kUse * simulation.tolerance);
  }
  const Decision d = decide(renderer, simulation, simulation.instruments[0], plan_of(simulation), sky_of_one(), false);
  CHECK(d.sampling.samples_u == 21);
  CHECK(d.sampling.directions == 1);
  CHECK(d.within);
}

TEST_CASE("S60: what the file gives stays, its error is told, and a tolerance it cannot keep is said to be so") {
  const Stripes scene(5.37 * kGsd_m);
  scene::Simulation simulation = scene.simulation;
  simulation.tolerance = 0.001;
  scene::Instrument& camera = simulation.instruments[0];
  camera.samples_u = camera.samples_v = 2, camera.samples_given = true;
  simulation.sky_directions = 3, simulation.sky_directions_given = true;
  plan::Plan plan = plan_of(simulation);
  render::Renderer renderer(simulation.scene, {});
  const Decision untried = decide(renderer, simulation, camera, plan, sky_of_one(), false);
  CHECK_FALSE(untried.estimated);
  const Decision d = decide(renderer, simulation, camera, plan, sky_of_one(), true);
  CHECK(d.sampling.samples_u == 2);
  CHECK(d.sampling.directions == 3);
  CHECK(d.samples_error > 0.01);
  CHECK_FALSE(d.within);
  REQUIRE(d.notes.size() == 1);
  CHECK(d.notes[0].find("is not kept") != std::string::npos);
  apply(d, camera, plan);
  const auto lines = plan_lines(d, plan);
  int given = 0;
  for (const auto& line : lines)
    if (line.given) ++given;
  CHECK(given == 2);  // samples and directions

  // A replay of it changes nothing; of another scene, or with other nodes, it is a guess whose error nobody knows yet.
  PlanFile::Entry entry{"camera", false, d.sampling, 0, axes_json(plan), decision_json(d, lines)};
  const Decision replay = replayed(entry, {}, simulation, camera, plan, "plan.json");
  CHECK(replay.sampling.samples_u == 2);
  CHECK(replay.samples_error == d.samples_error);
  const auto is_guess = [&](const Decision& guess, const std::string& named) {
    CHECK(guess.sampling.samples_u == 2);
    CHECK(guess.sampling.directions == 3);
    CHECK_FALSE(guess.estimated);
    CHECK(guess.total_error < 0);
    REQUIRE(guess.notes.size() == 1);
    CHECK(guess.notes[0].find(named) != std::string::npos);
  };
  is_guess(replayed(entry, {"seed 1, not 2"}, simulation, camera, plan, "plan.json"), "seed 1, not 2");
  plan.height.count = 5;
  is_guess(replayed(entry, {}, simulation, camera, plan, "plan.json"), "nodes and components");
}
