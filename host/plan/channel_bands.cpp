#include "host/plan/channel_bands.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"

namespace raycube::plan {

namespace {

constexpr double kSame = 0.02;      ///< of the FWHM
constexpr double kNarrowest = 0.5;  ///< of a channel's FWHM
constexpr double kNode_um = 1e-9;   ///< half the width of a band that stands for one node: its neighbours leak
                                    ///< in by 1e-7 of their difference

struct Channel {
  double node_um, center_um, fwhm_um;
};

std::vector<Channel> channels_of(const atmos::RenderTable& table) {
  const auto provenance = nlohmann::json::parse(table.provenance_json, nullptr, false);
  std::vector<Channel> out;
  if (!provenance.is_object() || !provenance.contains("channels")) return out;
  for (const auto& c : provenance["channels"])
    if (c.is_array() && c.size() == 3) out.push_back({c[0].get<double>(), c[1].get<double>(), c[2].get<double>()});
  return out;
}

/// Centre and full width at half maximum; of a tabulated response its first moment and the distance of its
/// outermost half-maximum points.
std::pair<double, double> shape_of(const scene::Band& band) {
  if (band.wavelength_um.size() < 2) return {band.center_um, band.fwhm_um};
  const auto &x = band.wavelength_um, &r = band.response;
  double area = 0, moment = 0;
  for (std::size_t i = 1; i < x.size(); ++i) {
    const double w = x[i] - x[i - 1];
    area += w * (r[i - 1] + r[i]) / 2;
    moment += w * (r[i - 1] * (2 * x[i - 1] + x[i]) + r[i] * (x[i - 1] + 2 * x[i])) / 6;
  }
  const double half = *std::max_element(r.begin(), r.end()) / 2;
  double first = x.back(), last = x.front();
  for (std::size_t i = 1; i < x.size(); ++i) {
    if ((r[i - 1] < half) == (r[i] < half)) continue;
    const double at = x[i - 1] + (half - r[i - 1]) / (r[i] - r[i - 1]) * (x[i] - x[i - 1]);
    first = std::min(first, at), last = std::max(last, at);
  }
  return {moment / area, std::max(0.0, last - first)};
}

scene::Band at_node(const scene::Band& band, double node_um, const std::vector<double>& table_um) {
  scene::Band out;
  out.name = band.name, out.center_um = node_um;
  out.wavelength_um = {node_um - kNode_um, node_um, node_um + kNode_um};
  out.response = {0, 1, 0};
  if (out.wavelength_um.front() < table_um.front())
    out.wavelength_um.erase(out.wavelength_um.begin()), out.response.erase(out.response.begin());
  if (out.wavelength_um.back() > table_um.back()) out.wavelength_um.pop_back(), out.response.pop_back();
  return out;
}

}  // namespace

ChannelBands channel_bands(const scene::Instrument& instrument, const atmos::RenderTable& table) {
  ChannelBands out{instrument.bands, 0, {}};
  const auto channels = channels_of(table);
  if (channels.empty()) return out;
  const auto& um = table.axis("wavelength").nodes;
  base::Problems problems;
  std::string others;
  std::size_t mixed = 0;
  for (std::size_t b = 0; b < out.bands.size(); ++b) {
    const auto [center, fwhm] = shape_of(instrument.bands[b]);
    // Of channels with one centre (a panchromatic one and a green one) that of the band's own width.
    const Channel& nearest = *std::min_element(
        channels.begin(), channels.end(), [at = center, wide = fwhm](const Channel& p, const Channel& q) {
          const auto off = [&](const Channel& c) {
            const double slack = kSame * std::max(c.fwhm_um, wide), beside = std::abs(c.center_um - at);
            return std::pair(beside <= slack ? 0.0 : beside, std::abs(c.fwhm_um - wide));
          };
          return off(p) < off(q);
        });
    const double slack = kSame * nearest.fwhm_um;
    if (std::abs(center - nearest.center_um) <= slack && std::abs(fwhm - nearest.fwhm_um) <= slack) {
      const double node = *std::min_element(um.begin(), um.end(), [&](double p, double q) {
        return std::abs(p - nearest.node_um) < std::abs(q - nearest.node_um);
      });
      out.bands[b] = at_node(instrument.bands[b], node, um);
      ++out.channels;
      continue;
    }
    const std::string found =
        fmt::format("band {} is {:.6g} nm, FWHM {:.4g} nm, the nearest channel {:.6g} nm, FWHM {:.4g} nm", b + 1,
                    1000 * center, 1000 * fwhm, 1000 * nearest.center_um, 1000 * nearest.fwhm_um);
    if (fwhm < kNarrowest * nearest.fwhm_um)
      problems.add({"", 0, 0, "instrument '" + instrument.name + "'"},
                   "the atmosphere table holds means over channels, which say nothing of narrower bands", found,
                   "import a spectrum of this resolution, or channels of this instrument");
    if (mixed++ < 3) others += (others.empty() ? "" : "; ") + found;
  }
  problems.throw_if_any();
  if (mixed > 0)
    out.notices.push_back(fmt::format(
        "the atmosphere table holds means over {} channels; {} of {} bands are none of them and "
        "average those means once more, which "
        "smears gas bands (5 % rms with bands as wide as the channels): {}{}",
        channels.size(), mixed, out.bands.size(), others, mixed > 3 ? fmt::format("; and {} more", mixed - 3) : ""));
  return out;
}

}  // namespace raycube::plan
