#include "atmos_tables/solar_spectrum.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/planck.h"

namespace raycube::atmos {

namespace {

struct SolarNode {
  double wavelength_nm, irradiance;
};
constexpr SolarNode kTsis1[] = {
#include "atmos_tables/data/solar_tsis1_gueymard.inc"
};
constexpr SolarNode kE490[] = {
#include "atmos_tables/data/solar_e490.inc"
};
constexpr double kFarKelvin = 5000;  ///< brightness temperature of the sun's far infrared, good to 10 % to 1000 um
constexpr double kJoint_um = 0.05;
constexpr double kStraight = 1e-3;  ///< of the irradiance: nodes nearer to a line hide none of the sun's lines
/// A table reaches this part of a wavelength beyond a file's end without a word: its outer bins do.
constexpr double kBesideEnd = 0.005;

/// Finest and coarsest distance of a file's nodes, nm.
std::string steps_text(const std::vector<double>& wavelength_um) {
  double finest = 1e9, coarsest = 0;
  for (std::size_t i = 1; i < wavelength_um.size(); ++i) {
    const double step_nm = 1000 * (wavelength_um[i] - wavelength_um[i - 1]);
    finest = std::min(finest, step_nm), coarsest = std::max(coarsest, step_nm);
  }
  return coarsest - finest < 1e-6 * coarsest ? fmt::format("steps of {:.4g} nm", finest)
                                             : fmt::format("steps of {:.4g} to {:.4g} nm", finest, coarsest);
}

}  // namespace

SolarSpectrum::SolarSpectrum(const scene::SolarSpectrumSpec& spec) {
  const auto take = [&](const auto& nodes, const char* source) {
    for (const SolarNode& node : nodes) nodes_.push_back({node.wavelength_nm, node.irradiance});
    source_ = source;
  };
  const bool shipped = spec.wavelength_um.empty();
  if (shipped && !is_shipped(spec.name))
    throw base::Error(base::Fault::input,
                      "solar spectrum '" + spec.name + "': there is no such name; use tsis1 or e490, or name a file");
  if (shipped && spec.name == "e490")
    take(kE490, "ASTM E-490-00a; averages over 2 nm to 500 nm");
  else
    take(kTsis1, "TSIS-1 HSRS (Coddington 2021) 0.35-2.5 um, Gueymard 2004 outside; averages over 2 nm to 500 nm");
  if (!shipped) join_file(spec);
}

void SolarSpectrum::join_file(const scene::SolarSpectrumSpec& spec) {
  const std::vector<double>& um = spec.wavelength_um;
  file_first_um_ = um.front(), file_last_um_ = um.back();
  if (!(file_last_um_ >= 0.35 && file_first_um_ <= nodes_.back().wavelength_nm / 1000))
    throw base::Error(base::Fault::input,
                      fmt::format("solar spectrum {}: covers {:g} to {:g} um and nothing from 0.35 to 31 um, where the "
                                  "sun's light counts; check its unit",
                                  spec.name, file_first_um_, file_last_um_));
  SolarSpectrum file;
  file.nodes_.clear();
  for (std::size_t i = 0; i < um.size(); ++i) file.nodes_.push_back({1000 * um[i], spec.irradiance[i]});
  // Where the default one begins (0.3 um) a file may reach further down: there is nothing to meet.
  const double first_um = nodes_.front().wavelength_nm / 1000;
  const auto factor = [&](double from_um, double to_um) {
    const double standing = mean_1au(std::max(from_um, first_um), std::max(to_um, first_um + kJoint_um));
    return file.mean_1au(std::max(from_um, first_um), std::max(to_um, first_um + kJoint_um)) / standing;
  };
  const double width_um = std::min(kJoint_um, file_last_um_ - file_first_um_);
  factor_below_ = factor(file_first_um_, file_first_um_ + width_um);
  factor_beyond_ = factor(file_last_um_ - width_um, file_last_um_);
  std::vector<Node> joined;
  for (const Node& node : nodes_)
    if (node.wavelength_nm < 1000 * file_first_um_)
      joined.push_back({node.wavelength_nm, factor_below_ * node.irradiance});
  joined.insert(joined.end(), file.nodes_.begin(), file.nodes_.end());
  for (const Node& node : nodes_)
    if (node.wavelength_nm > 1000 * file_last_um_)
      joined.push_back({node.wavelength_nm, factor_beyond_ * node.irradiance});
  nodes_ = std::move(joined);
  is_file_ = true;
  source_ = fmt::format("{}, {:g} to {:g} nm, {}; outside TSIS-1 HSRS and Gueymard 2004 to meet it", spec.name,
                        1000 * file_first_um_, 1000 * file_last_um_, steps_text(um));
}

double SolarSpectrum::irradiance_1au(double wavelength_um) const {
  const double nm = 1000 * wavelength_um;
  if (const Node& last = nodes_.back(); nm > last.wavelength_nm)
    return last.irradiance * base::planck_radiance(wavelength_um, kFarKelvin) /
           base::planck_radiance(last.wavelength_nm / 1000, kFarKelvin);
  const auto upper = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, nm,
                                      [](double value, const Node& node) { return value < node.wavelength_nm; });
  const Node &a = upper[-1], &b = *upper;
  const double w = (nm - a.wavelength_nm) / (b.wavelength_nm - a.wavelength_nm);
  return (1 - w) * a.irradiance + w * b.irradiance;
}

double SolarSpectrum::mean_1au(double from_um, double to_um) const {
  const double first = nodes_.front().wavelength_nm / 1000, last = nodes_.back().wavelength_nm / 1000;
  const auto value = [&](double um) { return irradiance_1au(std::clamp(um, first, last)); };
  if (!(to_um > from_um)) return value(from_um);
  double sum = 0, at = from_um, here = value(from_um);
  const auto advance = [&](double um) {
    const double next = value(um);
    sum += 0.5 * (here + next) * (um - at);
    at = um, here = next;
  };
  for (const Node& node : nodes_)
    if (const double um = node.wavelength_nm / 1000; um > from_um && um < to_um) advance(um);
  advance(to_um);
  return sum / (to_um - from_um);
}

double SolarSpectrum::step_um(double wavelength_um) const {
  const auto upper = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, 1000 * wavelength_um,
                                      [](double value, const Node& node) { return value < node.wavelength_nm; });
  return (upper->wavelength_nm - upper[-1].wavelength_nm) / 1000;
}

bool SolarSpectrum::straight(double wavelength_um) const {
  const double nm = 1000 * wavelength_um;
  const auto upper = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, nm,
                                      [](double value, const Node& node) { return value < node.wavelength_nm; });
  const Node &a = upper[-1], &b = *upper;
  const auto inside = [&](const Node& node) {
    return is_file_ && node.wavelength_nm >= 1000 * file_first_um_ - 1e-9 &&
           node.wavelength_nm <= 1000 * file_last_um_ + 1e-9;
  };
  if (!inside(a) || !inside(b)) return false;
  const auto on_line = [&](const Node& node) {
    if (!inside(node)) return true;  // the file ends here
    const double line = a.irradiance + (b.irradiance - a.irradiance) * (node.wavelength_nm - a.wavelength_nm) /
                                           (b.wavelength_nm - a.wavelength_nm);
    return std::abs(node.irradiance - line) <= kStraight * std::abs(line);
  };
  return (upper - 1 == nodes_.begin() || on_line(upper[-2])) && (upper + 1 == nodes_.end() || on_line(upper[1]));
}

std::optional<std::string> SolarSpectrum::notice(double first_um, double last_um) const {
  if (!is_file_) return std::nullopt;
  const bool below = first_um<(1 - kBesideEnd) * file_first_um_, beyond = last_um>(1 + kBesideEnd) * file_last_um_;
  if (!below && !beyond) return std::nullopt;
  const auto part = [](double end_um, const char* where, double factor) {
    return fmt::format(" {} {:g} um times {:.4g}", where, end_um, factor);
  };
  return "the solar spectrum's file does not reach over the whole table; the shipped tsis1 goes on" +
         (below ? part(file_first_um_, "below", factor_below_) : "") + (below && beyond ? " and" : "") +
         (beyond ? part(file_last_um_, "beyond", factor_beyond_) : "") + ", which meets it there";
}

}  // namespace raycube::atmos
