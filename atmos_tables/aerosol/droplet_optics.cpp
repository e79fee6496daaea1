#include "atmos_tables/aerosol/droplet_optics.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <string>
#include <utility>

#include "atmos_tables/optics/size_distribution.h"
#include "atmos_tables/optics/sphere_cloud.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {

constexpr double kReference_um = 0.55, kTolerance = 1e-3;

/// Fine where droplets of 5 to 50 wavelengths have their forward peak, their bow and their glory.
std::vector<double> angles_deg() {
  std::vector<double> out;
  const auto run = [&](double from, double to, double step) {
    const int count = static_cast<int>(std::lround((to - from) / step));
    for (int i = 0; i < count; ++i) out.push_back(from + i * step);
  };
  run(0, 2, 0.1), run(2, 10, 0.5), run(10, 130, 2), run(130, 180, 0.5);
  out.push_back(180);
  return out;
}

SphereCloudOptics sum(const SizeDistribution& sizes, double wavelength_um, std::complex<double> index,
                      std::vector<double> angle_deg) {
  SphereCloudRequest request;
  request.wavelength_um = wavelength_um, request.index = index, request.tolerance = kTolerance;
  request.angle_deg = std::move(angle_deg);
  return integrate_spheres(sizes, request);
}

void check(const DropletModel& model) {
  base::Problems problems;
  const auto add = [&](const std::string& what, const std::string& found, const std::string& way_out) {
    problems.add({"", 0, 0, "droplets"}, what, found, way_out);
  };
  if (model.index.empty())
    add("a refractive index against wavelength is needed", "none", "give rows of wavelength, n, k");
  for (std::size_t i = 0; i < model.index.size(); ++i) {
    const DropletModel::Index& row = model.index[i];
    const std::string found =
        std::to_string(row.wavelength_um) + " um, " + std::to_string(row.n) + ", " + std::to_string(row.k);
    if (!(row.wavelength_um > 0 && row.n > 0 && row.k >= 0) || !std::isfinite(row.wavelength_um + row.n + row.k))
      add("row " + std::to_string(i + 1) +
              " of the refractive index: wavelength and n must be positive, k not negative",
          found, "correct it");
    else if (i > 0 && !(row.wavelength_um > model.index[i - 1].wavelength_um))
      add("row " + std::to_string(i + 1) + " of the refractive index: wavelengths must ascend", found, "sort the rows");
  }
  if (!model.index.empty() &&
      !(model.index.front().wavelength_um <= kReference_um && model.index.back().wavelength_um >= kReference_um))
    add("the refractive index must cover 0.55 um, where optical depths are stated",
        std::to_string(model.index.front().wavelength_um) + ".." + std::to_string(model.index.back().wavelength_um) +
            " um",
        "add rows on both sides");
  problems.throw_if_any();
}

}  // namespace

DropletOptics::DropletOptics(const DropletModel& model)
    : sizes_(model.modes.empty() ? SizeDistribution::modified_gamma(model.alpha, model.b, model.gamma)
                                 : SizeDistribution::lognormal(model.modes)) {
  check(model);
  const auto above =
      std::lower_bound(model.index.begin(), model.index.end(), kReference_um,
                       [](const DropletModel::Index& row, double wave) { return row.wavelength_um < wave; });
  std::complex<double> reference(above->n, above->k);
  if (above->wavelength_um > kReference_um) {
    const DropletModel::Index& below = above[-1];
    const double share = (kReference_um - below.wavelength_um) / (above->wavelength_um - below.wavelength_um);
    reference = {std::lerp(below.n, above->n, share), std::lerp(below.k, above->k, share)};
  }
  unit_um2_ = sum(sizes_, kReference_um, reference, {}).extinction_um2;
  for (const DropletModel::Index& row : model.index) nodes_.emplace_back(row);
}

const DropletOptics::Node& DropletOptics::summed(const Node& node) const {
  std::call_once(node.summed, [&] {
    static const std::vector<double> angle_deg = angles_deg();
    const SphereCloudOptics found = sum(sizes_, node.index.wavelength_um, {node.index.n, node.index.k}, angle_deg);
    std::vector<double> log_phase;
    for (double phase : found.phase_at_angle) log_phase.push_back(std::log(phase));
    node.optics = {found.extinction_um2 / unit_um2_, (found.extinction_um2 - found.scattering_um2) / unit_um2_,
                   found.asymmetry};
    node.shape = std::make_shared<const PhaseShape>(angle_deg, std::move(log_phase));
  });
  return node;
}

std::pair<double, double> DropletOptics::covers_um() const {
  return {nodes_.front().index.wavelength_um, nodes_.back().index.wavelength_um};
}

DropletOptics::Place DropletOptics::place(double wavelength_um) const {
  const auto [first_um, last_um] = covers_um();
  if (!(wavelength_um >= first_um && wavelength_um <= last_um))
    throw base::Error(base::Fault::input, "droplets: the refractive index covers " + std::to_string(first_um) + " to " +
                                              std::to_string(last_um) + " um (found " + std::to_string(wavelength_um) +
                                              " um); add rows");
  const auto high = std::lower_bound(nodes_.begin(), nodes_.end(), wavelength_um,
                                     [](const Node& node, double wave) { return node.index.wavelength_um < wave; });
  if (high->index.wavelength_um == wavelength_um) return {&summed(*high), &*high, 0, 0};
  const Node &below = high[-1], &above = *high;
  const double from = below.index.wavelength_um, to = above.index.wavelength_um;
  return {&summed(below), &summed(above), (wavelength_um - from) / (to - from),
          std::log(wavelength_um / from) / std::log(to / from)};
}

SubstanceOptics DropletOptics::at(double wavelength_um) const {
  const Place at = place(wavelength_um);
  const SubstanceOptics &low = at.low->optics, &high = at.high->optics;
  const double extinction = std::pow(low.extinction, 1 - at.logarithmic) * std::pow(high.extinction, at.logarithmic);
  return {extinction,
          extinction * std::lerp(low.absorption / low.extinction, high.absorption / high.extinction, at.linear),
          std::lerp(low.asymmetry, high.asymmetry, at.linear)};
}

PhaseFunction DropletOptics::phase(double wavelength_um) const {
  const Place at = place(wavelength_um);
  return PhaseFunction({{1 - at.linear, at.low->shape}, {at.linear, at.high->shape}});
}

}  // namespace raycube::atmos
