#include "host/reference/compare.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/base/parallel.h"
#include "host/base/text.h"
#include "host/reference/lamp_light.h"
#include "host/reference/spread.h"
#include "host/reference/tie_search.h"
#include "kernels/sampling/lamp_draws.h"
#include "kernels/shared/tile_layout.h"

namespace raycube::reference {

struct Comparison::Result {
  std::uint32_t number = 0, line = 0, sample = 0;
  std::uint64_t rays = 0, hit_miss = 0, sun_rays = 0, sun_explained = 0, sun_unexplained = 0, sky_rays = 0,
                sky_explained = 0, sky_unexplained = 0, lamp_rays = 0, lamp_explained = 0, lamp_unexplained = 0;
  std::array<std::uint64_t, kCauses> hits{};
  bool excluded = false, beyond = false;
  std::vector<double> device, reference;  ///< [band]
  std::vector<float> difference;          ///< [band], relative, explained ties taken the device's way
  BandRadiance arithmetic, model;         ///< model empty when it was not asked for
};

namespace {

/// Part of the tolerance from which on the light that surfaces emit is reported though the plan has none.
constexpr double kThermalShown = 0.1;

/// How far fp32 may misplace a direction in the maps of the sky, rad: both its angles, the maps' nodes and the
/// direction itself are rounded to 2^-24 of at most pi, its angles also to 2e-8 by their series
/// (kernels/light/sky_map.h).
constexpr double kMisplaced_rad = 4 * 3.15 * kUlp;

/// By how much the light from `direction` may differ where that is misplaced: per component, sr-1, to the first order.
/// The maps are linear between nodes, so a slope holds on one side only: the steepest of all four sides counts.
Components misplaced_light(const plan::Plan& plan, const glm::dvec3& direction) {
  constexpr double kStep_rad = 1e-6;
  const double across = std::hypot(direction.x, direction.y);
  const glm::dvec3 turn = across > 0 ? glm::dvec3(-direction.y, direction.x, 0) / across : glm::dvec3(1, 0, 0);
  const glm::dvec3 down = glm::cross(turn, direction);
  const Components here = sky_light(plan, direction);
  Components out{};
  for (const glm::dvec3& step : {turn, -turn, down, -down}) {
    const glm::dvec3 beside = glm::normalize(direction + kStep_rad * step);
    if (beside.z < 0) continue;
    const Components there = sky_light(plan, beside);
    for (std::size_t m = 0; m < out.size(); ++m)
      out[m] = std::max(out[m], std::abs(there[m] - here[m]) * kMisplaced_rad / kStep_rad);
  }
  return out;
}

/// What each band's difference is relative to.
std::vector<double> scales(const std::vector<double>& reference, double floor) {
  double largest = 0;
  for (double value : reference) largest = std::max(largest, std::abs(value));
  std::vector<double> out;
  for (double value : reference) out.push_back(std::max({std::abs(value), floor * largest, 1e-300}));
  return out;
}

}  // namespace

Comparison::Comparison(const scene::CompiledScene& scene, const plan::Plan& plan, const scene::Instrument& instrument,
                       std::uint64_t seed, const CompareOptions& options)
    : plan_(plan), instrument_(instrument), seed_(seed), options_(options), scene_(scene), arithmetic_(scene, plan) {
  const auto brighten = [&](const plan::SkyBasis& basis, std::size_t first, std::size_t count) {
    for (const auto& value : basis.value)
      for (std::size_t m = 0; m < count; ++m)
        brightest_[first + m] = std::max(brightest_[first + m], std::abs(value[m]));
  };
  const auto solar = static_cast<std::size_t>(plan.sky_components);
  brighten(plan.sky_basis, 0, solar);
  if (plan.thermal.on) brighten(plan.thermal.basis, solar, static_cast<std::size_t>(plan.thermal.sky_components));
  if (!options_.table || options_.model_pixels == 0) return;
  model_ = std::make_unique<TableModel>(scene_, plan, *options_.table, options_.no_air, options_.model_directions,
                                        SkyShare{}, options_.beside_paths);
}

Comparison::~Comparison() = default;

/// The device keeps what a side's rays bring together. Where that differs, rays are sought whose turning accounts for
/// it in every component. Only ties of the double traversal may turn; then `sent` follows the device. Any subset is
/// tried of up to kMostTies ties, else up to three (host/reference/tie_search.h), or all seen (or hidden) ones at once:
/// a leaf that passes through the point within rounding puts it on one side or the other for every direction.
void Comparison::compare_sky(const Sample& sample, const float* device, SentRays& sent, Result& result) const {
  /// Part of a component's brightest light that a direction's own light may be off by, as its own is: the angle is
  /// rounded, and an aureole falls off by its own size in a degree.
  constexpr double kSlope = 0.1;
  const std::size_t count = sent.size(), components = static_cast<std::size_t>(plan_.components());
  const double known = known_share(scene_.compiled, plan_, sample);
  std::vector<Components> effect(count);
  Components residual{}, bound{};
  for (std::size_t m = 0; m < components; ++m) residual[m] = static_cast<double>(device[m]);
  for (std::size_t k = 0; k < count; ++k) {
    const SentRay& ray = sent[k];
    if (ray.weight == 0) continue;
    const double turned = spread(scene_.compiled, sample, ray.direction);
    const Components light = sky_light(plan_, ray.direction);
    for (std::size_t m = 0; m < components; ++m) {
      effect[k][m] = ray.weight * light[m] * turned * (ray.open ? -1 : 1);
      bound[m] += options_.limits.sky * std::max(1.0, turned) * (ray.weight + ray.solid_angle_sr) *
                  (std::abs(light[m]) + kSlope * brightest_[m]);
      residual[m] -= ray.weight * light[m] * ((ray.open ? turned : 0) - known);
    }
  }
  if (within(residual, bound)) return;
  for (const SentRay& ray : sent) {
    if (ray.weight == 0) continue;
    const double turned = std::max(1.0, spread(scene_.compiled, sample, ray.direction));
    const Components misplaced = misplaced_light(plan_, ray.direction);
    for (std::size_t m = 0; m < components; ++m) bound[m] += turned * ray.weight * misplaced[m];
  }
  if (within(residual, bound)) return;
  std::vector<std::size_t> ties;
  for (std::size_t k = 0; k < count; ++k)
    if (sent[k].weight > 0 && scene_.sees_in_double(sample, sent[k].direction) == Visibility::uncertain)
      ties.push_back(k);
  const auto turn = [&](const std::vector<std::size_t>& rays) {
    Components left = residual;
    for (std::size_t k : rays) left = minus(left, effect[k]);
    if (rays.empty() || !within(left, bound)) return false;
    for (std::size_t k : rays) sent[k].open = !sent[k].open;
    result.sky_explained += rays.size();
    return true;
  };
  const std::size_t n = ties.size();
  if (n <= 16) {
    std::vector<std::uint32_t> subsets(std::size_t{1} << n);
    std::iota(subsets.begin(), subsets.end(), 0u);
    std::stable_sort(subsets.begin(), subsets.end(),
                     [](std::uint32_t x, std::uint32_t y) { return std::popcount(x) < std::popcount(y); });
    std::vector<std::size_t> rays;
    for (std::uint32_t subset : subsets) {
      rays.clear();
      for (std::size_t i = 0; i < n; ++i)
        if (subset >> i & 1u) rays.push_back(ties[i]);
      if (turn(rays)) return;
    }
  } else {
    std::vector<std::size_t> seen, hidden;
    for (std::size_t k : ties) (sent[k].open ? seen : hidden).push_back(k);
    if (turn(seen) || turn(hidden)) return;
    if (n <= kMostTies && turn(subset_that_sums_to(ties, effect, residual, bound).rays)) return;
    if (turn(few_that_sum_to(ties, effect, residual, bound).rays)) return;
  }
  ++result.sky_unexplained;
  result.excluded = true;
}

std::vector<double> Comparison::compare_lamps(const Sample& side, std::uint32_t pixel, std::uint32_t sample,
                                              const float* device, Result& result) const {
  std::vector<double> out(static_cast<std::size_t>(plan_.lamps.sources()), 0.0);
  const rc_u32 number =
      rc_lamp_number(static_cast<int>(instrument_.sampler), static_cast<rc_u32>(instrument_.samples_u),
                     static_cast<rc_u32>(instrument_.samples_v), sample);
  for (std::size_t m = 0; m < out.size() && !side.hit.miss(); ++m) {
    const LampDraws draws = lamp_draws(scene_, plan_, seed_, pixel, number, static_cast<std::uint32_t>(m), side);
    out[m] = static_cast<double>(device[static_cast<std::size_t>(plan_.components()) + m]);
    const auto agrees = [&](double light) { return std::abs(out[m] - light) <= draws.bound; };
    const auto full = [&](const DrawnLamp& lamp) {
      return lamp.irradiance * spread(scene_.compiled, side, lamp.direction);
    };
    ++result.lamp_rays;
    if (agrees(draws.lamps.empty() || !draws.lamps[0].open ? 0 : full(draws.lamps[0]))) continue;
    const bool explained = std::any_of(draws.lamps.begin(), draws.lamps.end(), [&](const DrawnLamp& lamp) {
      const bool rounded = &lamp != &draws.lamps[0] && agrees(lamp.open ? full(lamp) : 0);
      return rounded || (agrees(lamp.open ? 0 : full(lamp)) &&
                         scene_.sees_in_double(side, lamp.at - side.point, lamp.limit) == Visibility::uncertain);
    });
    result.lamp_explained += explained;
    if (explained) continue;
    ++result.lamp_unexplained;
    result.excluded = true;
  }
  return out;
}

void Comparison::compare_sun(Sample& side, bool device_sees, Result& result) const {
  if (side.hit.miss() || !plan_.sun_up || !(side.cos_sun > 0)) return;
  ++result.sun_rays;
  if (side.sun_visible == device_sees) return;
  if (scene_.sees_in_double(side, to_double(plan_.sun_direction)) == Visibility::uncertain) {
    ++result.sun_explained;
    side.sun_visible = device_sees;
  } else {
    ++result.sun_unexplained;
    result.excluded = true;
  }
}

Comparison::Result Comparison::compare(const DevicePixel& device, bool with_model) const {
  SampledPixel pixel = scene_.sample_pixel(instrument_, plan_, seed_, device.address);
  const std::size_t samples = pixel.samples.size(),
                    planes = static_cast<std::size_t>(RC_SKY_PLANES_OF(plan_.met_sources()));
  const std::size_t sides = pixel.sides();
  if (device.hits.size() != samples || device.sun_visible.size() != sides || device.sky_met.size() != planes * sides ||
      device.radiance.size() != plan_.bands.size())
    throw base::Error(base::Fault::bug, "check: the device handed over " + std::to_string(device.hits.size()) +
                                            " hits and " + std::to_string(device.radiance.size()) +
                                            " bands of a pixel with " + base::counted(samples, "sample") + " and " +
                                            base::counted(plan_.bands.size(), "band"));
  Result result;
  result.number = pixel.number;
  result.line = device.address.line, result.sample = device.address.sample;
  result.rays = samples;
  std::vector<SentRays> sent(sides);
  std::vector<std::vector<double>> lamplight(plan_.lamps.sources() > 0 ? sides : 0);
  const auto rays = numbered_rays(plan_, instrument_, seed_, pixel.number);
  for (std::size_t s = 0; s < samples; ++s) {
    base::throw_if_interrupted();
    Sample& sample = pixel.samples[s];
    const Cause cause = scene_.tracer.explain(sample.ray, device.hits[s], sample.hit);
    ++result.hits[static_cast<std::size_t>(cause)];
    if (cause != Cause::agree) {
      result.hit_miss += device.hits[s].miss() != sample.hit.miss();
      if (cause == Cause::unexplained) {
        result.excluded = true;
      } else {
        // An explained tie may fall either way: from here on both sides speak of the device's triangle.
        sample.hit = device.hits[s];
        scene_.place(pixel, s, plan_);
      }
    }
    for (std::size_t i = s; i < sides; i += samples) {
      Sample& side = pixel.side(i);
      compare_sun(side, device.sun_visible[i] != 0, result);
      if (!lamplight.empty() && !result.excluded)
        lamplight[i] =
            compare_lamps(side, pixel.number, static_cast<std::uint32_t>(s), &device.sky_met[planes * i], result);
      sent[i] = sent_rays(scene_, plan_, seed_, pixel.number, side, rays[s]);
      if (side.hit.miss()) continue;
      result.sky_rays += sent[i].size();
      if (!result.excluded) compare_sky(side, &device.sky_met[planes * i], sent[i], result);
    }
  }
  result.arithmetic = arithmetic_.radiance(pixel, sent, lamplight);
  for (std::size_t b = 0; b < plan_.bands.size(); ++b) {
    result.device.push_back(static_cast<double>(device.radiance[b]));
    result.reference.push_back(result.arithmetic.total(b));
  }
  const std::vector<double> scale = scales(result.reference, options_.limits.band_floor);
  for (std::size_t b = 0; b < scale.size(); ++b)
    result.difference.push_back(static_cast<float>(std::abs(result.device[b] - result.reference[b]) / scale[b]));
  for (float difference : result.difference)
    if (!(difference <= options_.limits.worst)) result.beyond = true;
  if (with_model && !result.excluded) result.model = model_->radiance(pixel);
  return result;
}

void Comparison::add(const std::vector<DevicePixel>& pixels) {
  const std::size_t before = results_.size();
  results_.resize(before + pixels.size());
  base::for_each_index(pixels.size(), options_.threads, [&](std::size_t i) {
    results_[before + i] = compare(pixels[i], model_ && before + i < options_.model_pixels);
  });
}

namespace {

/// Section 5a: bands whose mean is below 1e-4 of the largest are judged against that floor.
template <typename Difference>
ModelDifference model_figure(std::size_t bands, std::size_t pixels, const std::vector<double>& mean,
                             Difference difference) {
  ModelDifference out;
  double largest = 0;
  for (double value : mean) largest = std::max(largest, value);
  for (std::size_t b = 0; b < bands && largest > 0; ++b) {
    double squares = 0;
    for (std::size_t p = 0; p < pixels; ++p) squares += difference(p, b) * difference(p, b);
    const double figure = std::sqrt(squares / static_cast<double>(pixels)) / std::max(mean[b], 1e-4 * largest);
    if (figure > out.figure) out = {figure, b};
  }
  return out;
}

}  // namespace

Report Comparison::report() const {
  Report report;
  report.limits = options_.limits;
  report.adjacency = !plan_.environment.empty();
  report.thermal = plan_.thermal.on;
  report.lamps = plan_.lamps.sources() > 0;
  report.pixels = results_.size();
  const std::size_t bands = plan_.bands.size();
  std::vector<const Result*> agreeing, modelled, ordered;
  for (const Result& r : results_) {
    report.rays += r.rays;
    for (std::size_t c = 0; c < report.hits.size(); ++c) report.hits[c] += r.hits[c];
    report.hit_miss += r.hit_miss;
    report.sun_rays += r.sun_rays, report.sun_explained += r.sun_explained, report.sun_unexplained += r.sun_unexplained;
    report.sky_rays += r.sky_rays, report.sky_explained += r.sky_explained, report.sky_unexplained += r.sky_unexplained;
    report.lamp_rays += r.lamp_rays, report.lamp_explained += r.lamp_explained;
    report.lamp_unexplained += r.lamp_unexplained;
    report.excluded_pixels += r.excluded;
    ordered.push_back(&r);
    if (r.excluded) continue;
    report.beyond_pixels += r.beyond;
    if (!r.model.sun.empty()) modelled.push_back(&r);
    agreeing.push_back(&r);
  }
  report.bands.resize(bands);
  std::vector<float> values;
  for (std::size_t b = 0; b < bands && !agreeing.empty(); ++b) {
    values.clear();
    double squares = 0;
    for (const Result* r : agreeing) {
      values.push_back(std::isnan(r->difference[b]) ? INFINITY : r->difference[b]);
      const double difference = static_cast<double>(values.back());
      squares += difference * difference;
      if (difference > report.worst) {
        report.worst = difference, report.worst_band = b, report.worst_line = r->line, report.worst_sample = r->sample;
      }
    }
    BandDifference& out = report.bands[b];
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    out.median = static_cast<double>(values[values.size() / 2]);
    out.max = static_cast<double>(*std::max_element(values.begin(), values.end()));
    out.rms = std::sqrt(squares / static_cast<double>(agreeing.size()));
    report.worst_median = std::max(report.worst_median, out.median);
  }
  report.model_pixels = modelled.size();
  if (!modelled.empty()) {
    std::vector<double> mean(bands, 0.0);
    for (const Result* r : modelled)
      for (std::size_t b = 0; b < bands; ++b) mean[b] += r->model.total(b) / static_cast<double>(modelled.size());
    const auto figure = [&](auto difference) {
      return model_figure(bands, modelled.size(), mean,
                          [&](std::size_t p, std::size_t b) { return difference(*modelled[p], b); });
    };
    report.model_total = figure([](const Result& r, std::size_t b) { return r.device[b] - r.model.total(b); });
    report.model_sun = figure([](const Result& r, std::size_t b) { return r.arithmetic.sun[b] - r.model.sun[b]; });
    report.model_sky = figure([](const Result& r, std::size_t b) { return r.arithmetic.sky[b] - r.model.sky[b]; });
    if (report.adjacency)
      report.model_environment =
          figure([](const Result& r, std::size_t b) { return r.arithmetic.environment[b] - r.model.environment[b]; });
    if (report.lamps)
      report.model_lamps =
          figure([](const Result& r, std::size_t b) { return r.arithmetic.lamps[b] - r.model.lamps[b]; });
    report.model_path = figure([](const Result& r, std::size_t b) { return r.arithmetic.path[b] - r.model.path[b]; });
    report.model_emission =
        figure([](const Result& r, std::size_t b) { return r.arithmetic.emission[b] - r.model.emission[b]; });
    report.model_surroundings =
        figure([](const Result& r, std::size_t b) { return r.arithmetic.surroundings[b] - r.model.surroundings[b]; });
    // A plan without thermal light where there is some to be seen.
    report.thermal = report.thermal || report.model_emission.figure > kThermalShown * report.limits.model;
  }
  std::sort(ordered.begin(), ordered.end(), [](const Result* a, const Result* b) { return a->number < b->number; });
  for (const Result* r : ordered) {
    report.picture_line.push_back(r->line);
    std::vector<float>& row = report.picture.emplace_back();
    for (float difference : r->difference) row.push_back(std::log10(std::max(difference, 1e-12f)));
  }
  return report;
}

}  // namespace raycube::reference
