#include "host/analysis/spectra.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "host/analysis/regions.h"
#include "host/analysis/statistics.h"
#include "host/base/error.h"
#include "scene_compiler/spectrum_file.h"

namespace raycube::analysis {
namespace {

using base::Error;
using base::Fault;

constexpr int kResponsePoints = 81;      ///< of a band's response, over twice its width to each side
constexpr double kResponseWidths = 2.0;  ///< where a Gaussian has 1.5e-5 of its peak

double at(const scene::Curve& curve, double um) {
  const auto& x = curve.wavelength_um;
  const auto after = std::upper_bound(x.begin(), x.end(), um);
  const auto i = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - x.begin(), 1, std::ssize(x) - 1));
  const double part = std::clamp((um - x[i - 1]) / (x[i] - x[i - 1]), 0.0, 1.0);
  return (1 - part) * curve.value[i - 1] + part * curve.value[i];
}

double over_band(const scene::Curve& curve, double center_um, double fwhm_um) {
  if (!(fwhm_um > 0)) return at(curve, center_um);
  double sum = 0, weights = 0;
  for (int k = 0; k < kResponsePoints; ++k) {
    const double off = kResponseWidths * (2.0 * k / (kResponsePoints - 1) - 1);
    const double weight = std::exp(-4 * std::numbers::ln2 * off * off);
    sum += weight * at(curve, center_um + off * fwhm_um), weights += weight;
  }
  return sum / weights;
}

NamedSpectrum of_file(const std::string& name, const std::string& what, const std::string& file,
                      const std::string& choice, const Cube& cube) {
  const std::vector<double> center = cube.wavelength_um(), fwhm = cube.fwhm_um();
  if (center.empty())
    throw Error(Fault::input, fmt::format("{}: its header {}, so that {} cannot be put on its bands", cube.path(),
                                          cube.header().why_no_wavelengths(), file));
  base::Problems problems;
  const bool table = file.ends_with(".csv");
  scene::SpectrumRequest request{.file = file, .spectrum = table ? "" : choice, .asked_by = {}};
  if (table && !choice.empty()) request.reflectance_column = choice;
  const std::optional<scene::Material> material = scene::read_spectrum(request, problems);
  problems.throw_if_any();
  const scene::Curve& curve = material->reflectance;
  NamedSpectrum out{name, Eigen::VectorXd(static_cast<Eigen::Index>(center.size())), what};
  const double first = curve.wavelength_um.front(), last = curve.wavelength_um.back();
  for (std::size_t b = 0; b < center.size(); ++b) {
    if (center[b] < first || center[b] > last)
      throw Error(Fault::input,
                  fmt::format("{}: reaches from {:g} to {:g} nm, band {} of {} does not lie there; choose "
                              "bands (--wavelengths {:g}:{:g})",
                              file, 1e3 * first, 1e3 * last, cube.band_text(b), cube.path(), 1e3 * first, 1e3 * last));
    out.value[static_cast<Eigen::Index>(b)] = over_band(curve, center[b], fwhm.empty() ? 0 : fwhm[b]);
  }
  return out;
}

}  // namespace

bool is_curve_file(const std::string& what) {
  const std::string file = what.substr(0, what.rfind('@'));
  return file.ends_with(".csv") || file.ends_with(".sli");
}

std::vector<NamedSpectrum> read_spectra(const std::vector<std::string>& texts, const Cube& cube, const Pass& pass) {
  std::vector<NamedSpectrum> out(texts.size());
  std::vector<Region> regions;
  std::vector<std::size_t> of_region;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const auto equals = texts[i].find('=');
    if (equals == std::string::npos || equals == 0)
      throw Error(Fault::input,
                  fmt::format("spectrum \"{}\": give NAME=WHAT, as in felt=felt.csv or felt=10:12,40:42", texts[i]));
    const std::string name = texts[i].substr(0, equals), what = texts[i].substr(equals + 1);
    for (std::size_t k = 0; k < i; ++k)
      if (out[k].name == name) throw Error(Fault::input, fmt::format("two spectra are called \"{}\"", name));
    const auto sign = what.rfind('@');
    const std::string file = what.substr(0, sign), choice = sign == std::string::npos ? "" : what.substr(sign + 1);
    if (is_curve_file(what)) {
      out[i] = of_file(name, what, file, choice, cube);
    } else {
      out[i] = {name, {}, what};
      regions.push_back(read_region(texts[i], cube)), of_region.push_back(i);
    }
  }
  if (regions.empty()) return out;
  const std::vector<RegionStatistics> means = region_statistics(cube, regions, pass);
  for (std::size_t r = 0; r < regions.size(); ++r) out[of_region[r]].value = means[r].mean();
  return out;
}

}  // namespace raycube::analysis
