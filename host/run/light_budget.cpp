#include "host/run/light_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/base/parallel.h"
#include "host/plan/bounces.h"
#include "host/plan/curve.h"
#include "host/products/csv_writer.h"
#include "host/render/photons.h"
#include "host/run/camera_job.h"
#include "host/run/photon_ledger.h"
#include "scene_compiler/counter_random.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::run {

namespace {

/// Steps of the sequences of Roberts (2018) in two and in four dimensions: powers of the roots of x^(d+1) = x + 1.
constexpr std::array<double, 2> kSteps2{0.7548776662466927, 0.5698402909980532};
constexpr std::array<double, 4> kSteps4{0.8566748838545029, 0.7338918566271260, 0.6287067210378087, 0.5385972572236101};

constexpr double kToldLost = 1e-3;  ///< share of the light past the scene's edge that is told

/// Photosynthetically active light, photons counted.
scene::Band par_band() {
  scene::Band out;
  out.name = "par", out.center_um = 0.55;
  out.wavelength_um = {0.4, 0.7}, out.response = {0.4, 0.7};
  return out;
}

/// A camera straight above: the plan is made for its bands.
scene::Instrument camera_above(const scene::CompiledScene& scene, const std::vector<scene::Band>& bands) {
  scene::Instrument out;
  out.name = "budget";
  out.bands = bands;
  out.pixels = out.lines = 1;
  out.ifov_across_rad = out.ifov_along_rad = 1e-4;
  out.poses = {{0, 0, double{scene.hi[2]} + 1000}};
  out.samples_u = out.samples_v = 1, out.samples_given = true;
  return out;
}

/// A band under the sun.
struct SunlitBand {
  plan::BandQuadrature weight;
  double level_w = 0;  ///< irradiance of level ground, W m-2 um-1
};

/// Sunlight is the table's, at the only node there is without air.
SunlitBand sunlit(const plan::Plan& plan, const plan::BandQuadrature& band) {
  SunlitBand out{{band.first, band.weight}, 0};
  double sum = 0;
  for (std::size_t i = 0; i < band.weight.size(); ++i)
    sum += out.weight.weight[i] *= plan.source_spectrum.front()[band.first + i];
  for (double& value : out.weight.weight) value /= sum;
  out.level_w = std::numbers::pi * sum * double{plan.sun_direction[2]};
  return out;
}

PhotonScene photon_scene(const scene::Simulation& simulation, const scene::LightBudget& budget,
                         const plan::Plan& plan) {
  const scene::CompiledScene& scene = simulation.scene;
  PhotonScene out{.compiled = scene,
                  .wavelengths = plan.wavelength_um.size(),
                  .material = {},
                  .named = scene::named_count(scene),
                  .shaped = {},
                  .band = {},
                  .levels = budget.levels_m,
                  .repeats = simulation.cell_m.has_value(),
                  .changing = scene::most_further(scene) > 0};
  for (const plan::BandQuadrature& band : plan.bands) out.band.push_back(sunlit(plan, band).weight);
  const auto named = scene::named_materials(scene);
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    const bool ground =
        std::find(budget.ground.begin(), budget.ground.end(), scene.materials[m].name) != budget.ground.end();
    const Spectrum none(out.wavelengths, 0.0);
    out.material.push_back({none, none, none, named[m], ground, {}, {}});
  }
  for (const std::uint32_t m : scene::used_materials(scene)) {
    const scene::Material& material = scene.materials[m];
    out.material[m].reflected = plan::sample_curve(material, material.reflectance, plan.wavelength_um);
    out.material[m].mirrored = plan::curve_on(scene, scene::gloss_curve(scene, m), plan.wavelength_um);
    const auto add_lobes = [&](const std::vector<scene::ShapeAndCurve>& parts, std::vector<LobeLight>& to) {
      for (const auto& part : parts)
        to.push_back({scene::as_cameras_see(part.shape), plan::sample_curve(material, part.curve, plan.wavelength_um)});
    };
    if (out.changing) {
      add_lobes(scene::front_parts(material), out.material[m].front_lobes);
      add_lobes(scene::gloss_parts(material), out.material[m].gloss_lobes);
    }
    if (scene::lets_light_through(material) || scene::is_plate(material))
      out.material[m].through = plan::sample_curve(material, material.transmittance, plan.wavelength_um);
  }
  for (const shared::Surface& surface : scene.surfaces) {
    bool shaped = false;
    scene::for_each_lobe(scene, surface, [&](std::size_t record, const scene::Shape& shape, double) {
      shaped = shaped || (record != RC_LOBE_BEHIND && shape.number != RC_SHAPE_lambert);
    });
    out.shaped.push_back(shaped);
  }
  return out;
}

/// Where photons start: evenly over the area, from above all of the scene.
class Source {
 public:
  Source(const scene::Simulation& simulation, const scene::LightBudget& budget, const plan::Plan& plan)
      : isotropic_(budget.isotropic), seed_(simulation.seed), sun_(plan.sun_direction) {
    const scene::CompiledScene& scene = simulation.scene;
    const double low = double{scene.lo[2]}, high = double{scene.hi[2]};
    top_m_ = high + 1e-3 * std::max(high - low, 1.0) + 1e-5 * std::abs(high);
    level_m_ = budget.height_m.value_or(top_m_);
    size_m_ = budget.size_m ? *budget.size_m : *simulation.cell_m;
    center_m_ = budget.center_m;
    if (simulation.cell_m)
      for (std::size_t k = 0; k < 2; ++k) center_m_[k] = 0.5 * (double{scene.lo[k]} + double{scene.hi[k]});
  }

  double area_m2() const { return size_m_[0] * size_m_[1]; }

  /// Photon `number` of a batch: ways and places along a sequence that covers them evenly, shifted by chance.
  shared::Photon photon(int batch, std::uint32_t number) const {
    const auto draw = [&](std::size_t k) {
      const double step = isotropic_ ? kSteps4[k] : kSteps2[k];
      const double at = scene::counter_uniform(seed_, 0xb0d6e7, static_cast<std::uint64_t>(batch), k) + step * number;
      return at - std::floor(at);
    };
    std::array<double, 3> way{-double{sun_[0]}, -double{sun_[1]}, -double{sun_[2]}};
    if (isotropic_) {
      const double u = draw(2), turn = 2 * std::numbers::pi * draw(3);
      way = {std::sqrt(u) * std::cos(turn), std::sqrt(u) * std::sin(turn), -std::sqrt(1 - u)};
    }
    const double back = (top_m_ - level_m_) / way[2];
    shared::Photon out{};
    out.origin = {static_cast<float>(center_m_[0] + (draw(0) - 0.5) * size_m_[0] + back * way[0]),
                  static_cast<float>(center_m_[1] + (draw(1) - 0.5) * size_m_[1] + back * way[1]),
                  static_cast<float>(top_m_), 1.0f};
    out.way = {static_cast<float>(way[0]), static_cast<float>(way[1]), static_cast<float>(way[2]), 0.0f};
    out.number = number;
    return out;
  }

  /// Back into the cell.
  void wrap(const std::array<double, 2>& cell_m, shared::Photon& photon) const {
    const auto into = [&](float& at, std::size_t k) {
      const double cells = std::floor((double{at} - center_m_[k]) / cell_m[k] + 0.5);
      if (cells != 0) at = static_cast<float>(double{at} - cells * cell_m[k]);
    };
    into(photon.origin.x, 0), into(photon.origin.y, 1);
  }

 private:
  bool isotropic_;
  std::uint64_t seed_;
  std::array<float, 3> sun_;
  double top_m_ = 0, level_m_ = 0;
  std::array<double, 2> center_m_{}, size_m_{};
};

/// Follows photons of one batch after another. Those of a launch are counted in blocks side by side, each with sums of
/// its own, which are added in order: results do not depend on threads.
class Following {
 public:
  Following(const scene::Simulation& simulation, const PhotonScene& scene, const Source& source,
            render::PhotonTracer& tracer, FacetCount& facets, int threads)
      : simulation_(simulation),
        scene_(scene),
        source_(source),
        tracer_(tracer),
        facets_(facets),
        threads_(threads),
        at_once_(static_cast<std::uint32_t>(std::clamp<std::size_t>(kMostCarried / scene.wavelengths / kBlock * kBlock,
                                                                    kBlock, render::PhotonTracer::kAtOnce))) {}

  PhotonLedger batch(int number, std::uint32_t photons) {
    PhotonLedger sum(scene_);
    for (std::uint32_t first = 0; first < photons; first += at_once_)
      launch(number, first, std::min(at_once_, photons - first), sum);
    return sum;
  }

 private:
  static constexpr std::uint32_t kBlock = 1024;                      ///< photons
  static constexpr std::size_t kMostCarried = std::size_t{1} << 22;  ///< numbers that photons of a launch carry

  struct Block {
    PhotonCount count;
    std::vector<shared::Photon> photons;
  };

  void launch(int batch, std::uint32_t first, std::uint32_t count, PhotonLedger& sum) {
    const auto seed = static_cast<std::uint32_t>(
        scene::mix64(simulation_.seed + 0x9e3779b97f4a7c15ull * (static_cast<std::uint64_t>(batch) + 1)));
    std::vector<Block> blocks;
    for (std::uint32_t begin = 0; begin < count; begin += kBlock) {
      Block& block = blocks.emplace_back(Block{PhotonCount(scene_, facets_.any()), {}});
      for (std::uint32_t i = begin; i < std::min(begin + kBlock, count); ++i)
        block.photons.push_back(source_.photon(batch, first + i));
      block.count.start(block.photons.size());
    }
    for (std::uint32_t level = 1; level <= kMostMet && step(blocks, level, seed); ++level)
      for (const Block& block : blocks)
        for (const FacetDeposit& deposit : block.count.deposits) facets_.add(deposit.primitive, deposit.band);
    for (Block& block : blocks) block.count.give_up(block.photons.size()), sum.add(block.count.ledger);
  }

  /// Whether any photon was left.
  bool step(std::vector<Block>& blocks, std::uint32_t level, std::uint32_t seed) {
    std::vector<shared::Photon> all;
    std::vector<std::size_t> first;
    for (Block& block : blocks) {
      first.push_back(all.size());
      if (simulation_.cell_m)
        for (shared::Photon& photon : block.photons) source_.wrap(*simulation_.cell_m, photon);
      block.count.set_off(block.photons);
      all.insert(all.end(), block.photons.begin(), block.photons.end());
    }
    if (all.empty()) return false;
    tracer_.step(all, level, seed);
    base::for_each_index(blocks.size(), threads_, [&](std::size_t k) {
      std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(first[k]), blocks[k].photons.size(),
                  blocks[k].photons.begin());
      blocks[k].count.step(blocks[k].photons, level == 1);
    });
    return true;
  }

  const scene::Simulation& simulation_;
  const PhotonScene& scene_;
  const Source& source_;
  render::PhotonTracer& tracer_;
  FacetCount& facets_;
  int threads_;
  std::uint32_t at_once_;
};

/// A quantity of a ledger by name.
struct Quantity {
  std::string name, of;
  std::function<Spectrum(const PhotonLedger&)> value;
};

std::vector<Quantity> quantities(const PhotonScene& scene) {
  std::vector<Quantity> out{{"reflected", "", [](const PhotonLedger& l) { return l.reflected; }}};
  std::vector<std::size_t> first(scene.named, scene.material.size());
  for (std::size_t m = scene.material.size(); m-- > 0;) first[scene.material[m].named] = m;
  for (std::size_t k = 0; k < scene.named; ++k)
    out.push_back(
        {"absorbed", scene.compiled.materials[first[k]].name, [k](const PhotonLedger& l) { return l.absorbed[k]; }});
  out.push_back({"canopy", "", [&scene, first](const PhotonLedger& l) {
                   Spectrum sum(scene.wavelengths, 0.0);
                   for (std::size_t k = 0; k < scene.named; ++k)
                     for (std::size_t i = 0; !scene.material[first[k]].ground && i < sum.size(); ++i)
                       sum[i] += l.absorbed[k][i];
                   return sum;
                 }});
  out.push_back({"transmitted", "", [](const PhotonLedger& l) { return l.ground; }});
  out.push_back({"transmitted_uncollided", "", [](const PhotonLedger& l) { return l.ground_first; }});
  for (std::size_t k = 0; k < scene.named; ++k)
    out.push_back(
        {"arrived", scene.compiled.materials[first[k]].name, [k](const PhotonLedger& l) { return l.arrived[k]; }});
  for (std::size_t k = 0; k < scene.levels.size(); ++k) {
    out.push_back({"down", scene::number_text(scene.levels[k]), [k](const PhotonLedger& l) { return l.down[k]; }});
    out.push_back({"up", scene::number_text(scene.levels[k]), [k](const PhotonLedger& l) { return l.up[k]; }});
  }
  out.push_back({"lost", "", [](const PhotonLedger& l) { return l.lost; }});
  out.push_back({"unfinished", "", [](const PhotonLedger& l) { return l.unfinished; }});
  return out;
}

/// Bands by which nothing is told apart are named by their numbers too.
std::vector<std::string> band_names(const std::vector<scene::Band>& bands, bool par) {
  std::vector<std::string> out;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    std::string name = par && b + 1 == bands.size() ? "par" : fmt::format("{:.0f}nm", 1e3 * bands[b].center_um);
    if (std::find(out.begin(), out.end(), name) != out.end()) name += fmt::format("_band{}", b + 1);
    out.push_back(std::move(name));
  }
  return out;
}

}  // namespace

const LightShare& BudgetResult::of(const std::string& quantity, const std::string& name) const {
  return *std::find_if(share.begin(), share.end(),
                       [&](const LightShare& one) { return one.quantity == quantity && one.of == name; });
}

std::vector<scene::Band> budget_bands(const scene::Simulation& simulation, const scene::LightBudget& budget) {
  std::vector<scene::Band> out = bands_of(simulation, budget.bands_of);
  if (budget.par) out.push_back(par_band());
  return out;
}

void check_budget(const scene::Simulation& simulation, const scene::LightBudget& budget) {
  const std::string who = "budget '" + budget.name + "'";
  if (!budget.isotropic) check_sun(simulation, who);
  check_sunlit_bands(simulation, who, budget.bands_of);
  const scene::CompiledScene& scene = simulation.scene;
  if (scene.instances.empty())
    throw base::Error(base::Fault::input, fmt::format("budget '{}' has nothing that light could meet (found an empty "
                                                      "scene); add [[plane]], [[terrain]] or [[mesh]]",
                                                      budget.name));
}

namespace {

/// A plan without air for the budget's bands.
plan::Plan plan_without_air(scene::Simulation& simulation, const scene::LightBudget& budget,
                            const std::vector<scene::Band>& bands, Services& services) {
  simulation.atmosphere = {};
  simulation.atmosphere.none = true;
  simulation.thermal_below_3um = false;
  simulation.lamps.clear();
  simulation.sky_directions = 1, simulation.sky_directions_given = true, simulation.paths_per_two = 1;
  simulation.bounces_given = true;
  const int bounces = std::exchange(simulation.bounces, 0);
  const scene::Sun sun = simulation.sun;
  // An even sky has the sun's spectrum, wherever that stands.
  if (budget.isotropic) simulation.sun.zenith_deg = 0, simulation.sun.moon_phase_deg = -1;
  plan::Plan out = prepare_camera(simulation, camera_above(simulation.scene, bands), services).plan;
  simulation.bounces = bounces, simulation.sun = sun;
  return out;
}

double most_lost(const BudgetResult& result) {
  double most = 0;
  for (const Measured& one : result.of("lost").band) most = std::max(most, one.mean);
  return most;
}

/// Shares of every batch, [quantity][band][batch].
using Answers = std::vector<std::vector<std::vector<double>>>;

BudgetResult told(const scene::LightBudget& budget, const std::vector<scene::Band>& bands, const plan::Plan& plan,
                  const std::vector<Quantity>& asked, const Answers& found) {
  BudgetResult out;
  out.band = band_names(bands, budget.par);
  for (std::size_t b = 0; b < bands.size(); ++b) {
    out.wavelength_um.push_back(bands[b].center_um);
    const bool power = !budget.isotropic && !(budget.par && b + 1 == bands.size());
    out.light_w.push_back(power ? std::optional(sunlit(plan, plan.bands[b]).level_w) : std::nullopt);
  }
  for (std::size_t q = 0; q < asked.size(); ++q) {
    LightShare& share = out.share.emplace_back(LightShare{asked[q].name, asked[q].of, {}});
    for (const std::vector<double>& batches : found[q]) share.band.push_back(measured(batches));
  }
  return out;
}

}  // namespace

BudgetResult light_budget(const render::RenderOptions& options, scene::Simulation& simulation,
                          const scene::LightBudget& budget, const std::vector<base::OutputFile*>& facet_files,
                          Services& services) {
  check_budget(simulation, budget);
  const std::vector<scene::Band> bands = budget_bands(simulation, budget);
  const plan::Plan plan = plan_without_air(simulation, budget, bands, services);
  const PhotonScene scene = photon_scene(simulation, budget, plan);
  const Source source(simulation, budget, plan);
  const auto curves = plan::sampled_curves(simulation.scene, plan.wavelength_um);
  render::PhotonTracer tracer(simulation.scene, options,
                              plan::surface_scattering(simulation.scene, curves, plan.wavelength_um.size()));
  const int side = 2 * simulation.cell_copies + 1;
  FacetCount facets(simulation.scene, budget.facets, bands.size(), side * side);
  Following following(simulation, scene, source, tracer, facets, services.threads);

  const auto in_batch = static_cast<std::uint32_t>((budget.photons + kMeasureBatches - 1) / kMeasureBatches);
  const std::vector<Quantity> asked = quantities(scene);
  Answers found(asked.size(), std::vector<std::vector<double>>(bands.size()));
  const Step step(services, "photons of " + budget.name, kMeasureBatches, "batches");
  for (int batch = 0; batch < kMeasureBatches; ++batch) {
    base::throw_if_interrupted();
    const PhotonLedger ledger = following.batch(batch, in_batch);
    facets.end_batch(source.area_m2() / in_batch);
    for (std::size_t q = 0; q < asked.size(); ++q) {
      const std::vector<double> values = plan::in_bands(scene.band, asked[q].value(ledger));
      for (std::size_t b = 0; b < bands.size(); ++b) found[q][b].push_back(values[b] / in_batch);
    }
    step.advance();
  }
  BudgetResult out = told(budget, bands, plan, asked, found);
  for (std::size_t k = 0; k < facet_files.size(); ++k) facets.write(k, out.band, *facet_files[k]);
  if (const double lost = most_lost(out); lost > kToldLost)
    services.log.warning(
        fmt::format("{:.2g} % of the light of budget '{}' goes past the scene's edge; {}", 100 * lost, budget.name,
                    simulation.cell_m ? "give scene.periodic more copies" : "give an area within the scene"));
  return out;
}

void write_budget(const scene::LightBudget& budget, const BudgetResult& result, base::OutputFile& file) {
  file.append("# raycube budget '" + budget.name + "': shares of the " + (budget.isotropic ? "even sky's " : "sun's ") +
              "light that falls onto the area, without air; errors are standard errors\n");
  products::CsvWriter csv(file, {"quantity", "of", "band", "wavelength_um", "share", "error", "w_m2_um"});
  for (const LightShare& share : result.share)
    for (std::size_t b = 0; b < result.band.size(); ++b) {
      const Measured& one = share.band[b];
      csv.add(share.quantity).add(share.of).add(result.band[b]).add(result.wavelength_um[b]);
      csv.add(one.mean).add(one.error);
      csv.add(result.light_w[b] ? *result.light_w[b] * one.mean : std::numeric_limits<double>::quiet_NaN());
      csv.end_row();
    }
  csv.finish();
}

nlohmann::ordered_json budget_json(const scene::LightBudget& budget, const BudgetResult& result) {
  nlohmann::ordered_json out = {{"budget", budget.name},
                                {"light", budget.isotropic ? "isotropic" : "sun"},
                                {"band", result.band},
                                {"wavelength_um", result.wavelength_um}};
  for (const auto& light : result.light_w)
    out["light_w_m2_um"].push_back(light ? nlohmann::ordered_json(*light) : nlohmann::ordered_json());
  for (const LightShare& share : result.share) {
    nlohmann::ordered_json entry = {{"quantity", share.quantity}};
    if (!share.of.empty()) entry["of"] = share.of;
    for (const Measured& one : share.band) entry["mean"].push_back(one.mean), entry["error"].push_back(one.error);
    out["shares"].push_back(std::move(entry));
  }
  return out;
}

}  // namespace raycube::run
