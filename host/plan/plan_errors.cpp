#include "host/plan/plan_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace raycube::plan {

namespace {

constexpr double kBandFloor = 1e-4;
/// A band with less than this part of the brightest band's skylight has no sky.
constexpr double kFaintestBand = 1e-9;
using Bands = std::vector<double>;

Bands divide(Bands value, const Bands& by) {
  for (std::size_t b = 0; b < value.size(); ++b) value[b] /= by[b];
  return value;
}

Bands sum(const Bands& a, const Bands& b, double factor_a = 1) {
  Bands out(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) out[i] = factor_a * a[i] + b[i];
  return out;
}

/// A line along one axis: sample(t) gives band values, counts(t) whether t lies in the view.
template <class Sample, class Counts>
Line make_line(Sample sample, Counts counts) {
  Line line;
  for (int p = 0; p < kLinePositions; ++p) {
    const double t = static_cast<double>(p) / (kLinePositions - 1);
    line.value.push_back(sample(t));
    line.counts.push_back(counts(t) ? 1 : 0);
  }
  return line;
}

}  // namespace

namespace {

constexpr int kSkyStep = 4;  ///< every so many positions the sky is summed up, by cubics between
static_assert((kLinePositions - 1) == 3 * kSkyStep);

/// Irradiance of the sky at every position of the line of heights. The sky falls off smoothly with height, and its sums
/// over all directions are the dearest part of a plan. Error: none that was seen; with all thirteen summed up the
/// errors told of the starter, the park, EMIT's trees and 2.5 km of relief in both models of air are the same to the
/// last digit, as sun and path err more between nodes of height.
std::vector<Spectrum> irradiance_along(const TableSpectra& air, const Domain& domain, Sky kind) {
  std::array<Spectrum, 4> at;
  for (int k = 0; k < 4; ++k)
    at[static_cast<std::size_t>(k)] = coarse_sky_irradiance(air, domain.z(static_cast<double>(k) / 3), kind);
  std::vector<Spectrum> out;
  for (int p = 0; p < kLinePositions; ++p) {
    const double t = static_cast<double>(p) / kSkyStep;
    const std::array<double, 4> weight = {-(t - 1) * (t - 2) * (t - 3) / 6, t * (t - 2) * (t - 3) / 2,
                                          -t * (t - 1) * (t - 3) / 2, t * (t - 1) * (t - 2) / 6};
    Spectrum& here = out.emplace_back(air.size(), 0.0);
    for (std::size_t k = 0; k < 4; ++k)
      for (std::size_t i = 0; i < here.size(); ++i) here[i] += weight[k] * at[k][i];
  }
  return out;
}

/// Of a surface of mean emissivity: band means of B T_view.
Bands emitted_bands(const TableSpectra& air, const BandSpace& bands, const Spectrum& planck, double z, double sec) {
  const Spectrum light = product(planck, air.view_transmission(z, zenith_of_sec(sec)));
  return sum(bands.reflected_band_mean(light), bands.band_mean(light), -1);
}

}  // namespace

std::vector<double> typical_radiance(const TableSpectra& air, const Domain& domain, const BandSpace& bands,
                                     const Spectrum& sky_irradiance, const TypicalThermal& thermal) {
  const double mu0 = std::max(0.0, std::cos(domain.sun_zenith)), z = domain.z(0.5), sec = domain.sec(0.5);
  Bands typical = sum(bands.reflected_band_mean(sun_source(air, z, sec)),
                      bands.reflected_band_mean(product(sky_irradiance, sky_path(air, z, sec))), mu0);
  if (air.couples_ground()) typical = sum(typical, bands.reflected_band_mean(environment_source(air, z, sec)));
  typical = sum(typical, bands.band_mean(path_source(air, domain, z, domain.x(0.5), domain.y(0.5))));
  if (!domain.lamplight.empty()) typical = sum(typical, bands.reflected_band_mean(lamp_source(air, domain, z, sec)));
  if (!thermal.planck.empty()) {
    typical = sum(typical, emitted_bands(air, bands, thermal.planck, z, sec));
    typical =
        sum(typical, bands.reflected_band_mean(product(thermal.sky_irradiance, sky_path(air, z, sec, Sky::thermal))));
  }
  const double largest = *std::max_element(typical.begin(), typical.end());
  for (double& value : typical)
    value = std::max(value, std::max(kBandFloor * largest, std::numeric_limits<double>::min()));
  return typical;
}

SolarShare solar_share(const TableSpectra& air, const Domain& domain, const BandSpace& brightest,
                       const Spectrum& sky_irradiance, const std::vector<double>& typical) {
  const Bands sun = divide(brightest.reflected_band_mean(sun_source(air, domain.z(0.5), domain.sec(0.5))), typical);
  const Bands sky = divide(
      brightest.reflected_band_mean(product(sky_irradiance, sky_path(air, domain.z(0.5), domain.sec(0.5)))), typical);
  // a surface that faces the sun, however low that stands; it is zero at night
  Bands around(typical.size(), 0.0);
  if (air.couples_ground())
    around = divide(brightest.reflected_band_mean(environment_source(air, domain.z(0.5), domain.sec(0.5))), typical);
  return {*std::max_element(sun.begin(), sun.end()), *std::max_element(sky.begin(), sky.end()),
          *std::max_element(around.begin(), around.end())};
}

Spectrum sky_importance(const TableSpectra& air, const Domain& domain, const BandSpace& bands,
                        const Spectrum& sky_irradiance, const std::vector<double>& typical, Sky kind) {
  const Bands sky =
      bands.reflected_band_mean(product(sky_irradiance, sky_path(air, domain.z(0.5), domain.sec(0.5), kind)));
  return bands.spread(divide(sky, typical));
}

std::vector<Mixture> band_mixtures(const SkySpectra& sky, const Spectrum& up, const BandSpace& bands) {
  std::array<Bands, kMaxSkyComponents> component;
  for (std::size_t m = 0; m < component.size(); ++m) component[m] = bands.reflected_band_mean(product(sky[m], up));
  const double faintest = kFaintestBand * *std::max_element(component[0].begin(), component[0].end());
  std::vector<Mixture> out(bands.bands(), Mixture{});
  for (std::size_t b = 0; b < out.size(); ++b)
    for (std::size_t m = 0; m < component.size() && component[0][b] > faintest; ++m)
      out[b][m] = component[m][b] / component[0][b];
  return out;
}

SkyLevel judge_sky(SkyFactors factors, const TableSpectra& air, const Domain& domain, const BandSpace& bands,
                   const std::vector<double>& typical) {
  SkyLevel out;
  const Spectrum up = sky_path(air, domain.z(0.5), domain.sec(0.5), factors.sky);
  out.mixture = band_mixtures(factors.spectra, up, bands);
  const Bands sky = bands.reflected_band_mean(product(factors.spectra[0], up));
  const Bands error = bands.reflected_band_mean(product(factors.occluder_error, product(factors.spectra[0], up)));
  for (std::size_t b = 0; b < typical.size(); ++b) {
    const Mixture& mixture = out.mixture[b];
    out.error = std::max(out.error, error[b] / typical[b]);
    if (mixture[0] == 0) continue;
    out.relative_error = std::max(out.relative_error, error[b] / sky[b]);
    for (const auto& node : factors.basis.value) {
      const double sum_here = mixture[0] * node[0] + mixture[1] * node[1] + mixture[2] * node[2] + mixture[3] * node[3];
      out.negative = out.negative || sum_here < 0;
    }
  }
  out.factors = std::move(factors);
  return out;
}

double diffuse_row_difference(const TableSpectra& air, const Domain& domain, const BandSpace& bands,
                              const Spectrum& sky_irradiance) {
  const Spectrum row = air.diffuse_irradiance(domain.z(0.5));
  if (row.empty()) return -1;
  double worst = 0;
  const Bands ours = bands.band_mean(sky_irradiance), theirs = bands.band_mean(row);
  for (std::size_t b = 0; b < ours.size(); ++b)
    if (theirs[b] > 0) worst = std::max(worst, std::abs(ours[b] / theirs[b] - 1));
  return worst;
}

NodeErrors estimate_node_errors(const TableSpectra& air, const Domain& domain, const BandSpace& bands,
                                const Spectrum& sky_irradiance, const std::vector<double>& typical,
                                const TypicalThermal& thermal) {
  NodeErrors out;
  const double mu0 = std::max(0.0, std::cos(domain.sun_zenith));
  const auto scaled = [&](Bands value, double factor) {
    for (double& v : value) v *= factor;
    return divide(std::move(value), typical);
  };
  const auto sun_bands = [&](double z, double sec) {
    return scaled(bands.reflected_band_mean(sun_source(air, z, sec)), mu0);
  };
  const auto sky_bands = [&](const Spectrum& irradiance, double z, double sec) {
    return scaled(bands.reflected_band_mean(product(irradiance, sky_path(air, z, sec))), 1);
  };
  const auto environment_bands = [&](double z, double sec) {
    return scaled(bands.reflected_band_mean(environment_source(air, z, sec)), 1);
  };
  const bool lamps = !domain.lamplight.empty();
  const auto lamp_bands = [&](double z, double sec) {
    return scaled(bands.reflected_band_mean(lamp_source(air, domain, z, sec)), 1);
  };
  const bool emits = !thermal.planck.empty();
  const auto emission_bands = [&](double z, double sec) {
    return divide(emitted_bands(air, bands, thermal.planck, z, sec), typical);
  };
  const auto thermal_sky_bands = [&](const Spectrum& irradiance, double z, double sec) {
    return divide(bands.reflected_band_mean(product(irradiance, sky_path(air, z, sec, Sky::thermal))), typical);
  };
  const auto path_bands = [&](double z, double x, double y) {
    return scaled(bands.band_mean(path_source(air, domain, z, x, y)), 1);
  };

  const auto always = [](double) { return true; };
  const auto inside = [&](double x, double y) { return std::hypot(x, y) <= domain.horizontal_max() + 1e-6; };
  if (domain.z_hi > domain.z_lo) {
    std::vector<Line> source, path;
    const std::vector<Spectrum> sky = irradiance_along(air, domain, Sky::solar),
                                thermal_sky =
                                    emits ? irradiance_along(air, domain, Sky::thermal) : std::vector<Spectrum>{};
    for (const double v : {0.0, 1.0}) {
      source.push_back(make_line([&](double t) { return sun_bands(domain.z(t), domain.sec(v)); }, always));
      source.push_back(make_line(
          [&](double t) {
            const auto p = static_cast<std::size_t>(std::lround(t * (kLinePositions - 1)));
            return sky_bands(sky[p], domain.z(t), domain.sec(v));
          },
          always));
      if (air.couples_ground())
        source.push_back(make_line([&](double t) { return environment_bands(domain.z(t), domain.sec(v)); }, always));
      if (lamps) source.push_back(make_line([&](double t) { return lamp_bands(domain.z(t), domain.sec(v)); }, always));
      if (!emits) continue;
      source.push_back(make_line([&](double t) { return emission_bands(domain.z(t), domain.sec(v)); }, always));
      source.push_back(make_line(
          [&](double t) {
            const auto p = static_cast<std::size_t>(std::lround(t * (kLinePositions - 1)));
            return thermal_sky_bands(thermal_sky[p], domain.z(t), domain.sec(v));
          },
          always));
    }
    for (const double xy : {0.0, 0.5, 1.0})
      path.push_back(make_line([&](double t) { return path_bands(domain.z(t), domain.x(xy), domain.y(xy)); },
                               [&](double) { return inside(domain.x(xy), domain.y(xy)); }));
    out.source_height = node_errors(source);
    out.path_height = node_errors(path);
  }
  if (domain.view.sec_max > domain.view.sec_min) {
    std::vector<Line> source;
    for (const double h : {0.0, 1.0}) {
      source.push_back(make_line([&](double t) { return sun_bands(domain.z(h), domain.sec(t)); }, always));
      source.push_back(
          make_line([&](double t) { return sky_bands(sky_irradiance, domain.z(h), domain.sec(t)); }, always));
      if (air.couples_ground())
        source.push_back(make_line([&](double t) { return environment_bands(domain.z(h), domain.sec(t)); }, always));
      if (lamps) source.push_back(make_line([&](double t) { return lamp_bands(domain.z(h), domain.sec(t)); }, always));
      if (!emits) continue;
      source.push_back(make_line([&](double t) { return emission_bands(domain.z(h), domain.sec(t)); }, always));
      source.push_back(make_line(
          [&](double t) { return thermal_sky_bands(thermal.sky_irradiance, domain.z(h), domain.sec(t)); }, always));
    }
    out.source_view = node_errors(source);
  }
  std::vector<Line> along_x, along_y;
  for (const double other : {0.0, 0.5, 1.0}) {
    if (domain.view.x_max > domain.view.x_min)
      along_x.push_back(make_line([&](double t) { return path_bands(domain.z_lo, domain.x(t), domain.y(other)); },
                                  [&](double t) { return inside(domain.x(t), domain.y(other)); }));
    if (domain.view.y_max > domain.view.y_min)
      along_y.push_back(make_line([&](double t) { return path_bands(domain.z_lo, domain.x(other), domain.y(t)); },
                                  [&](double t) { return inside(domain.x(other), domain.y(t)); }));
  }
  out.path_x = node_errors(along_x);
  out.path_y = node_errors(along_y);
  return out;
}

}  // namespace raycube::plan
