#include "host/sensors/detector.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/planck.h"
#include "host/lidar/draws.h"
#include "kernels/sampling/sampler.h"

namespace raycube::sensors {
namespace {

constexpr double kPlanck_J_s = 6.62607015e-34, kLight_m_s = 299792458.0;  // exact, SI 2019
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint32_t kGainOf = 0xde70u, kOffsetOf = 0xde71u, kBadOf = 0xde72u;  ///< of rc_hash: what stays

/// Of a list over wavelength.
double at(const std::vector<double>& um, const std::vector<double>& value, double wavelength_um) {
  if (value.size() == 1 || wavelength_um <= um.front()) return value.front();
  if (wavelength_um >= um.back()) return value.back();
  const auto i = static_cast<std::size_t>(std::upper_bound(um.begin(), um.end(), wavelength_um) - um.begin());
  const double part = (wavelength_um - um[i - 1]) / (um[i] - um[i - 1]);
  return (1 - part) * value[i - 1] + part * value[i];
}

/// a + b L: variance of a table's points at one wavelength, by least squares over their relative errors.
struct VarianceLine {
  double wavelength_um = 0, constant = 0, slope = 0;
};

std::vector<VarianceLine> variance_lines(const std::vector<scene::NoisePoint>& points) {
  std::vector<VarianceLine> out;
  for (std::size_t i = 0; i < points.size();) {
    std::size_t end = i + 1;
    while (end < points.size() && points[end].wavelength_um == points[i].wavelength_um) ++end;
    VarianceLine line{points[i].wavelength_um};
    double w = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (std::size_t k = i; k < end; ++k) {
      const double radiance = points[k].radiance, variance = std::pow(radiance / points[k].snr, 2),
                   weight = 1 / (variance * variance);
      w += weight, x += weight * radiance, y += weight * variance;
      xx += weight * radiance * radiance, xy += weight * radiance * variance;
    }
    line.slope = (w * xy - x * y) / (w * xx - x * x), line.constant = (y - line.slope * x) / w;
    if (!(line.slope > 0) || line.constant < -1e-9 * y / w)
      throw base::Error(base::Fault::input,
                        fmt::format("detector.noise: at {:g} nm the variance would be {:.3g} + {:.3g} L: no reading "
                                    "and shot noise add up to that; the ratios must rise with radiance, and no faster "
                                    "than it",
                                    1e3 * line.wavelength_um, line.constant, line.slope));
    line.constant = std::max(0.0, line.constant);
    out.push_back(line), i = end;
  }
  return out;
}

/// Whether a table of noise reaches over a wavelength; Error(input) else.
void require_reach(const std::vector<scene::NoisePoint>& points, const scene::Instrument& instrument,
                   std::size_t band) {
  const double um = instrument.bands[band].center_um, first = points.front().wavelength_um,
               last = points.back().wavelength_um;
  if (um < first || um > last)
    throw base::Error(
        base::Fault::input,
        fmt::format("detector.noise: reaches from {:g} to {:g} nm, band {} of '{}' lies at {:g} nm; add rows",
                    1e3 * first, 1e3 * last, band + 1, instrument.name, 1e3 * um));
}

/// Shot and reading noise of a table; between wavelengths noise at no light is linear, and so is the slope.
BandNoise of_lines(const std::vector<VarianceLine>& lines, double um) {
  std::vector<double> x, dark, slope;
  for (const VarianceLine& line : lines)
    x.push_back(line.wavelength_um), dark.push_back(std::sqrt(line.constant)), slope.push_back(line.slope);
  BandNoise out;
  out.electrons_per_radiance = 1 / at(x, slope, um);
  out.read_e = at(x, dark, um) * out.electrons_per_radiance;
  return out;
}

/// Of a table of noise as a function of radiance, whose coefficients are linear between wavelengths.
BandNoise of_functions(const std::vector<scene::NoisePoint>& points, double um) {
  std::vector<double> x, a, b, c;
  for (const scene::NoisePoint& p : points)
    x.push_back(p.wavelength_um), a.push_back(p.a), b.push_back(p.b), c.push_back(p.c);
  BandNoise out;
  out.a = at(x, a, um), out.b = at(x, b, um), out.c = at(x, c, um);
  return out;
}

/// An instrument's own (FNV-1a of its name): two cameras do not share their noise.
std::uint64_t seed_of(std::uint64_t seed, const std::string& name) {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
  return seed ^ hash;
}

}  // namespace

double BandNoise::sigma(double radiance) const { return std::abs(a * std::sqrt(std::max(0.0, b + radiance)) + c); }

double width_um(const scene::Band& band) {
  if (band.fwhm_um > 0) return band.fwhm_um * std::sqrt(std::numbers::pi / (4 * std::numbers::ln2));
  double area = 0;
  for (std::size_t i = 1; i < band.response.size(); ++i)
    area += 0.5 * (band.response[i] + band.response[i - 1]) * (band.wavelength_um[i] - band.wavelength_um[i - 1]);
  return area / *std::max_element(band.response.begin(), band.response.end());
}

Detector::Detector(const scene::Instrument& instrument, std::uint64_t seed, std::vector<double> band_mean)
    : instrument_(instrument), spec_(*instrument.detector), seed_(seed_of(seed, instrument.name)) {
  const bool functions = !spec_.noise.empty() && spec_.noise.front().function;
  const std::vector<VarianceLine> lines = functions ? std::vector<VarianceLine>{} : variance_lines(spec_.noise);
  const double opening = std::numbers::pi / 4 * spec_.aperture_diameter_m * spec_.aperture_diameter_m,
               solid_angle = instrument.ifov_across_rad * instrument.ifov_along_rad;
  for (std::size_t b = 0; b < instrument.bands.size(); ++b) {
    const double um = instrument.bands[b].center_um;
    BandNoise& band = band_.emplace_back();
    if (spec_.snr > 0) {
      band.c = std::abs(band_mean.at(b)) / spec_.snr;
      continue;
    }
    if (!spec_.noise.empty()) {
      require_reach(spec_.noise, instrument, b);
      band = functions ? of_functions(spec_.noise, um) : of_lines(lines, um);
      if (functions) continue;
    } else {
      const double photons = opening * solid_angle * spec_.integration_time_s * width_um(instrument.bands[b]) *
                             (1e-6 * um) / (kPlanck_J_s * kLight_m_s);
      band.electrons_per_radiance =
          photons * at(spec_.at_um, spec_.transmission, um) * at(spec_.at_um, spec_.quantum_efficiency, um);
      band.dark_e = spec_.dark_e_s * spec_.integration_time_s, band.read_e = spec_.read_noise_e;
    }
    if (spec_.bits > 0) {
      band.gain = spec_.gain_e_dn / band.electrons_per_radiance;
      band.offset = -(spec_.offset_dn * spec_.gain_e_dn + band.dark_e) / band.electrons_per_radiance;
    }
  }
  if (instrument.kind == scene::InstrumentKind::framing) return;
  const auto elements =
      static_cast<std::uint32_t>(instrument.kind == scene::InstrumentKind::pushbroom ? instrument.pixels : 1);
  for (std::uint32_t e = 0; e < elements; ++e)
    for (int b = 0; b < static_cast<int>(band_.size()); ++b) kept_.push_back(make_element(e, b));
}

std::uint32_t Detector::element_of(std::int64_t line, std::int64_t sample) const {
  if (instrument_.kind == scene::InstrumentKind::whiskbroom) return 0;
  if (instrument_.kind == scene::InstrumentKind::pushbroom) return static_cast<std::uint32_t>(sample);
  return static_cast<std::uint32_t>(line * instrument_.pixels + sample);
}

double Detector::top() const { return digital() ? std::ldexp(1.0, spec_.bits) - 1 : spec_.full_well_e.value_or(0); }

Detector::Element Detector::make_element(std::uint32_t element, int band) const {
  const auto stream = [&](std::uint32_t what) {
    return lidar::Stream(lidar::DrawSeed(seed_ ^ (std::uint64_t{what} << 32)), element,
                         static_cast<std::uint32_t>(band), lidar::DrawFor::gain);
  };
  Element out{1, 0, kNan};
  if (spec_.prnu > 0) out.gain += spec_.prnu * stream(kGainOf).normal();
  if (spec_.dsnu_e > 0) out.offset_e = spec_.dsnu_e * stream(kOffsetOf).normal();
  if (!(spec_.bad_share > 0)) return out;
  const double u = stream(kBadOf).uniform();
  if (u >= spec_.bad_share) return out;
  const BandNoise& of = band_[static_cast<std::size_t>(band)];
  const bool full = u < spec_.bad_share / 2;
  out.bad = 0;
  if (full && digital()) out.bad = top();
  if (full && !digital() && spec_.full_well_e) out.bad = (*spec_.full_well_e - of.dark_e) / of.electrons_per_radiance;
  return out;
}

std::uint64_t Detector::measure(std::int64_t line, std::int64_t first_sample, std::int64_t samples,
                                const float* radiance, float* out) const {
  const int bands = static_cast<int>(band_.size());
  const lidar::DrawSeed seed(seed_);
  std::uint64_t cut = 0;
  for (std::int64_t s = 0; s < samples; ++s) {
    const std::int64_t sample = first_sample + s;
    const std::uint32_t number = element_of(line, sample),
                        pixel = static_cast<std::uint32_t>(line * instrument_.pixels + sample);
    for (int b = 0; b < bands; ++b) {
      const BandNoise& band = band_[static_cast<std::size_t>(b)];
      const auto i = static_cast<std::size_t>(s * bands + b);
      const double light = static_cast<double>(radiance[i]);
      if (!std::isfinite(light)) {  // no light is known: nothing is measured
        out[i] = std::numeric_limits<float>::quiet_NaN();
        continue;
      }
      const Element here = element(number, b);
      if (!std::isnan(here.bad)) {
        out[i] = static_cast<float>(here.bad);
        continue;
      }
      lidar::Stream reading(seed, pixel, static_cast<std::uint32_t>(b), lidar::DrawFor::readout);
      if (!(band.electrons_per_radiance > 0)) {
        out[i] = static_cast<float>(light * here.gain + band.sigma(light) * reading.normal());
        continue;
      }
      const double signal = std::max(0.0, band.electrons_per_radiance * light * here.gain);
      double n = lidar::Stream(seed, pixel, static_cast<std::uint32_t>(b), lidar::DrawFor::counts)
                     .poisson(signal + band.dark_e);
      if (band.read_e > 0) n += band.read_e * reading.normal();
      n += here.offset_e;
      bool over = spec_.full_well_e && n >= *spec_.full_well_e;
      if (over) n = *spec_.full_well_e;
      if (!digital()) {
        out[i] = static_cast<float>((n - band.dark_e) / band.electrons_per_radiance);
      } else {
        const double dn = std::round(n / spec_.gain_e_dn + spec_.offset_dn);
        over = over || dn > top();
        out[i] = static_cast<float>(std::clamp(dn, 0.0, top()));
      }
      cut += over;
    }
  }
  return cut;
}

Expected Detector::expected(int band, double radiance) const {
  const BandNoise& of = band_[static_cast<std::size_t>(band)];
  if (!(of.electrons_per_radiance > 0)) return {radiance, of.sigma(radiance)};
  const double step = digital() ? spec_.gain_e_dn : 0;
  const double variance =
      std::max(0.0, of.electrons_per_radiance * radiance) + of.dark_e + of.read_e * of.read_e + step * step / 12;
  return {radiance, std::sqrt(variance) / of.electrons_per_radiance};
}

double Detector::nedt_K(int band, double kelvin) const {
  const double um = instrument_.bands[static_cast<std::size_t>(band)].center_um, step = 0.01;
  const double slope =
      (base::planck_radiance(um, kelvin + step) - base::planck_radiance(um, kelvin - step)) / (2 * step);
  return expected(band, base::planck_radiance(um, kelvin)).sigma / slope;
}

std::vector<BadElement> Detector::bad_elements() const {
  std::vector<BadElement> out;
  if (spec_.bad_share <= 0) return out;
  const bool framing = instrument_.kind == scene::InstrumentKind::framing,
             scans = instrument_.kind == scene::InstrumentKind::whiskbroom;
  const std::int64_t lines = framing ? instrument_.lines : 1, samples = scans ? 1 : instrument_.pixels;
  for (int b = 0; b < static_cast<int>(band_.size()); ++b)
    for (std::int64_t line = 0; line < lines; ++line)
      for (std::int64_t sample = 0; sample < samples; ++sample)
        if (const double bad = make_element(element_of(line, sample), b).bad; !std::isnan(bad))
          out.push_back({framing ? line : -1, scans ? -1 : sample, b, bad > 0});
  return out;
}

}  // namespace raycube::sensors
