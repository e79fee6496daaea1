#include "atmos_tables/aerosol/own_aerosol.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "atmos_tables/aerosol/droplet_optics.h"
#include "atmos_tables/optics/gauss_legendre.h"
#include "host/base/error.h"
#include "host/base/units.h"

namespace raycube::atmos {

namespace {

constexpr double kDepthsAt_um = 0.55;
/// What rounded moments may leave below 0, of a phase function whose mean is 1.
constexpr double kMayBeNegative = 0.01;
constexpr double kMostIndexStep = 1.1, kLastConstantIndex_um = 40;

base::Where place_of(const scene::OwnAerosolSpec& aerosol) { return {"", 0, 0, "aerosol '" + aerosol.name + "'"}; }

std::string moment_fault(const std::vector<double>& moments) {
  if (moments.empty() || moments[0] != 1) return fmt::format("{:g}", moments.empty() ? 0.0 : moments[0]);
  return "";
}

/// What is wrong with moments of a phase function at one wavelength.
void check_moments(const scene::OwnAerosolSpec& aerosol, std::size_t i, base::Problems& problems) {
  const std::vector<double>& moments = aerosol.phase_moments[i];
  const std::string at = aerosol.wavelength_um.empty() || aerosol.phase_moments.size() == 1
                             ? ""
                             : fmt::format(" at {:g} um", aerosol.wavelength_um[i]);
  if (const std::string first = moment_fault(moments); !first.empty())
    return problems.add(place_of(aerosol), "the first moment" + at + ", chi_0, must be 1", first,
                        "divide all by it, and each by 2 k + 1 where they hold that factor");
  double least = 0, where_deg = 0;
  for (int half_deg = 0; half_deg <= 360; ++half_deg) {
    const double value = legendre_series(moments, std::cos(base::rad_by_division(half_deg / 2.0)));
    if (value < least) least = value, where_deg = half_deg / 2.0;
  }
  if (least < -kMayBeNegative)
    problems.add(place_of(aerosol), "its moments" + at + " make a phase function that is negative",
                 fmt::format("{:.3g} at {:g} deg, mean 1", least, where_deg),
                 "give more of them, and without the factor 2 k + 1");
}

/// A list with one value for all wavelengths, or one for each.
template <class Value>
const Value& value_at(const std::vector<Value>& list, std::size_t i) {
  return list.size() == 1 ? list[0] : list[i];
}

std::vector<double> mixed(const std::vector<double>& low, const std::vector<double>& high, double share) {
  std::vector<double> out(std::max(low.size(), high.size()), 0.0);
  for (std::size_t k = 0; k < low.size(); ++k) out[k] += (1 - share) * low[k];
  for (std::size_t k = 0; k < high.size(); ++k) out[k] += share * high[k];
  out[0] = 1;  // the shares add up to 1 but for rounding
  return out;
}

class StatedOptics : public ParticleOptics {
 public:
  explicit StatedOptics(const scene::OwnAerosolSpec& aerosol) : aerosol_(aerosol) {
    base::Problems problems;
    for (std::size_t i = 0; i < aerosol.phase_moments.size(); ++i) check_moments(aerosol, i, problems);
    const auto [first_um, last_um] = covers_um();
    if (!(first_um <= kDepthsAt_um && last_um >= kDepthsAt_um))
      problems.add(place_of(aerosol), "its optics must cover 0.55 um, to which optical depths are referred",
                   fmt::format("{:g} to {:g} um", first_um, last_um), "add rows on both sides");
    problems.throw_if_any();
    unit_ = extinction(kDepthsAt_um);
  }

  std::pair<double, double> covers_um() const override {
    if (aerosol_.wavelength_um.empty()) return {kMinAerosolWave_um, kMaxAerosolWave_um};
    return {aerosol_.wavelength_um.front(), aerosol_.wavelength_um.back()};
  }

  SubstanceOptics at(double wavelength_um) const override {
    const Place at = place(wavelength_um);
    const auto between_nodes = [&](const std::vector<double>& list) {
      return std::lerp(value_at(list, at.low), value_at(list, at.high), at.share);
    };
    const double ratio = extinction(wavelength_um) / unit_;
    const double asymmetry = aerosol_.asymmetry.empty() ? moments(at)[1] : between_nodes(aerosol_.asymmetry);
    return {ratio, ratio * (1 - between_nodes(aerosol_.single_scattering_albedo)), asymmetry};
  }

  PhaseFunction phase(double wavelength_um) const override {
    if (aerosol_.asymmetry.empty()) return PhaseFunction::of_moments(moments(place(wavelength_um)));
    return PhaseFunction::henyey_greenstein(at(wavelength_um).asymmetry);
  }

 private:
  struct Place {
    std::size_t low = 0, high = 0;
    double share = 0, log_share = 0;  ///< of the higher
  };
  Place place(double wavelength_um) const {
    const std::vector<double>& nodes = aerosol_.wavelength_um;
    const auto [first_um, last_um] = covers_um();
    if (!(wavelength_um >= first_um && wavelength_um <= last_um))
      throw base::Error(base::Fault::input,
                        fmt::format("aerosol '{}': its optics cover {:g} to {:g} um (found {:g} um); add rows, or "
                                    "narrow the bands",
                                    aerosol_.name, first_um, last_um, wavelength_um));
    if (nodes.size() < 2) return {};
    const auto above = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, wavelength_um);
    const auto high = static_cast<std::size_t>(above - nodes.begin());
    const double from = nodes[high - 1], to = nodes[high];
    return {high - 1, high, (wavelength_um - from) / (to - from), std::log(wavelength_um / from) / std::log(to / from)};
  }

  /// In the units of the table, or over that at 0.55 um.
  double extinction(double wavelength_um) const {
    if (aerosol_.extinction.empty()) return std::pow(wavelength_um / kDepthsAt_um, -aerosol_.angstrom);
    const Place at = place(wavelength_um);
    return std::pow(aerosol_.extinction[at.low], 1 - at.log_share) *
           std::pow(aerosol_.extinction[at.high], at.log_share);
  }

  std::vector<double> moments(const Place& at) const {
    std::vector<double> out =
        mixed(value_at(aerosol_.phase_moments, at.low), value_at(aerosol_.phase_moments, at.high), at.share);
    if (out.size() < 2) out.resize(2, 0.0);
    return out;
  }

  scene::OwnAerosolSpec aerosol_;
  double unit_ = 1;
};

/// The index table with what is missing between its rows.
std::vector<DropletModel::Index> index_table(const scene::OwnAerosolSpec& aerosol) {
  std::vector<DropletModel::Index> out;
  if (aerosol.wavelength_um.empty()) {
    const double n = aerosol.refractive_n.at(0), k = aerosol.refractive_k.at(0);
    const int below = static_cast<int>(std::log(kDepthsAt_um / kMinAerosolWave_um) / std::log(kMostIndexStep)),
              above = static_cast<int>(std::log(kLastConstantIndex_um / kDepthsAt_um) / std::log(kMostIndexStep));
    out.push_back({kMinAerosolWave_um, n, k});
    for (int i = -below; i <= above; ++i) out.push_back({kDepthsAt_um * std::pow(kMostIndexStep, i), n, k});
    out.push_back({kLastConstantIndex_um, n, k});
    return out;
  }
  for (std::size_t i = 0; i < aerosol.wavelength_um.size(); ++i) {
    const DropletModel::Index here = {aerosol.wavelength_um[i], aerosol.refractive_n[i], aerosol.refractive_k[i]};
    if (i > 0) {
      const DropletModel::Index before = out.back();
      const double ratio = here.wavelength_um / before.wavelength_um;
      const int steps = static_cast<int>(std::ceil(std::log(ratio) / std::log(kMostIndexStep)));
      for (int s = 1; s < steps; ++s) {
        const double um = before.wavelength_um * std::pow(ratio, static_cast<double>(s) / steps);
        const double share = (um - before.wavelength_um) / (here.wavelength_um - before.wavelength_um);
        out.push_back({um, std::lerp(before.n, here.n, share), std::lerp(before.k, here.k, share)});
      }
    }
    out.push_back(here);
  }
  return out;
}

DropletModel spheres_of(const scene::OwnAerosolSpec& aerosol) {
  DropletModel model;
  model.index = index_table(aerosol);
  if (!aerosol.modified_gamma.empty())
    model.alpha = aerosol.modified_gamma.at(0), model.b = aerosol.modified_gamma.at(1),
    model.gamma = aerosol.modified_gamma.at(2);
  for (std::size_t i = 0; i < aerosol.median_radius_um.size(); ++i)
    model.modes.push_back({aerosol.number_share.empty() ? 1.0 : aerosol.number_share[i], aerosol.median_radius_um[i],
                           aerosol.geometric_sigma[i]});
  return model;
}

}  // namespace

HeightProfile own_heights(const scene::OwnAerosolSpec& aerosol, double ground_km, double top_km) {
  std::vector<HeightProfile::Knot> knots;
  if (aerosol.height_km.empty()) {
    // The profile is exponential between any two knots: these are levels for the solver.
    for (double scale_heights : {0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 9.0, 30.0}) {
      const double height_km = std::min(ground_km + scale_heights * aerosol.scale_height_km, top_km);
      knots.push_back({height_km, std::exp(-(height_km - ground_km) / aerosol.scale_height_km)});
      if (height_km == top_km) break;
    }
    return HeightProfile(std::move(knots));
  }
  for (std::size_t i = 0; i < aerosol.height_km.size(); ++i)
    knots.push_back({aerosol.height_km[i], aerosol.height_extinction[i]});
  const HeightProfile whole(knots);
  if (!(whole.depth(ground_km, top_km) > 0))
    throw base::Error(
        base::Fault::input,
        fmt::format("aerosol '{}': none of its extinction_profile lies between the ground, {:g} km above the "
                    "sea, and the top of the air, {:g} km; correct its heights",
                    aerosol.name, ground_km, top_km));
  std::erase_if(knots, [&](const auto& knot) { return knot.height_km <= ground_km || knot.height_km >= top_km; });
  const auto cut = [&](double height_km) { return HeightProfile::Knot{height_km, whole.extinction_per_km(height_km)}; };
  if (whole.knots().front().height_km <= ground_km) knots.insert(knots.begin(), cut(ground_km));
  if (whole.knots().back().height_km >= top_km) knots.push_back(cut(top_km));
  return HeightProfile(std::move(knots));
}

std::shared_ptr<const ParticleOptics> own_optics(const scene::OwnAerosolSpec& aerosol) {
  if (aerosol.refractive_n.empty()) return std::make_shared<const StatedOptics>(aerosol);
  return std::make_shared<const DropletOptics>(spheres_of(aerosol));
}

}  // namespace raycube::atmos
