#include "host/run/lidar_run_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "host/base/units.h"
#include "host/lidar/detector.h"
#include "host/lidar/record_bins.h"

namespace raycube::run {

namespace {

constexpr double kProbablyNone = 0.5;  ///< fewer expected returns of surfaces and volumes: most likely there is none

/// "73 % left the scene, 27 % were absorbed": shares above a thousandth.
std::string shares_text(const std::vector<std::pair<double, const char*>>& shares) {
  std::string text;
  for (const auto& [share, what] : shares)
    if (share > 1e-3) text += fmt::format("{}{:.3g} % {}", text.empty() ? "" : ", ", 100 * share, what);
  return text;
}

}  // namespace

/// A linear record's noise is as good as light where it makes an echo; a Geiger record's events are all somebody's
/// photons.
void LidarRunLight::add_returns(const lidar::ShotResult& result, const lidar::Detection& record) {
  const scene::Lidar& lidar = plan_.lidar;
  const bool geiger = lidar.detector.mode == scene::DetectorMode::geiger;
  const auto bins = static_cast<std::size_t>(lidar.gate.bins);
  const std::size_t row = static_cast<std::size_t>(record.pixel * plan_.lines() + record.line) * bins;
  for (const lidar::Echo& echo : record.echoes) {
    const double at = (echo.time_s - lidar.gate.start_s) / lidar.gate.bin_s - 0.5;
    const double last = static_cast<double>(bins) - 1;
    const auto from = static_cast<std::size_t>(std::clamp(std::round(at - half_bins_), 0.0, last));
    const auto to = static_cast<std::size_t>(std::clamp(std::round(at + half_bins_), 0.0, last));
    const auto within = [&](const std::vector<float>& rows) {
      double sum = 0;
      for (std::size_t bin = from; !rows.empty() && bin <= to; ++bin) sum += static_cast<double>(rows[row + bin]);
      return lidar.receiver.quantum_efficiency * sum;
    };
    const double media = lidar.echoes.air_is_background && !geiger ? within(result.particles) : 0;
    const double matter = within(result.first) + within(result.multiple) - media, air = within(result.air) + media;
    const double width = static_cast<double>(to - from + 1), noise = record.truth.noise_pe;
    const double other = geiger ? air + width * record.truth.background_pe : std::sqrt(air + width * noise * noise);
    if (matter > 0) returns_of_matter_ += matter / (matter + other);
  }
}

void LidarRunLight::add(const lidar::ShotResult& result, const std::vector<lidar::Detection>& records) {
  if (shots_++ == 0)
    half_bins_ = base::kFwhmOfSigma * lidar::recorded_sigma_s(plan_.lidar) / plan_.lidar.gate.bin_s + 1;
  double of_matter = 0;
  for (const auto* rows : {&result.first, &result.multiple}) {
    const lidar::BinSums sums = lidar::sums_of(rows->data(), rows->size());
    matter_photons_ += sums.sum, of_matter += sums.sum;
    strongest_pe_ = std::max(strongest_pe_, plan_.lidar.receiver.quantum_efficiency * sums.largest);
  }
  air_photons_ += lidar::sums_of(result.air.data(), result.air.size()).sum;
  if (plan_.lidar.echoes.air_is_background && plan_.lidar.detector.mode != scene::DetectorMode::geiger) {
    const double particles = lidar::sums_of(result.particles.data(), result.particles.size()).sum;
    // What is left of sums in floats is nothing.
    const double others = of_matter - particles > 1e-5 * particles ? of_matter - particles : 0;
    matter_photons_ -= of_matter - others, air_photons_ += particles;
  }
  for (const auto& record : records) {
    echoes_ += record.echoes.size();
    add_returns(result, record);
    lowest_threshold_pe_ =
        records_ == 0 ? record.truth.threshold_pe : std::min(lowest_threshold_pe_, record.truth.threshold_pe);
    ++records_;
  }
  for (const auto& ledger : result.ledger) {
    mean_.absorbed += ledger.absorbed, mean_.air += ledger.air, mean_.volumes += ledger.volumes,
        mean_.escaped += ledger.escaped;
    mean_.truncated += ledger.truncated, mean_.collected += ledger.collected, mean_.early += ledger.early,
        mean_.late += ledger.late;
    mean_.near += ledger.near;
    ++ledgers_;
  }
}

std::string LidarRunLight::where_it_went() const {
  const scene::Lidar& lidar = plan_.lidar;
  const double per_s = 0.5 * base::kLightSpeed_m_s / lidar.transport.group_index;
  const std::string gate = fmt::format("the gate holds {:.6g} to {:.6g} m", per_s * lidar.gate.start_s,
                                       per_s * (lidar.gate.start_s + lidar.gate.bins * lidar.gate.bin_s));
  // Light is followed from the pixels of a flash array: shares are of what they see.
  const std::string emitted = lidar.transport.sampling == scene::LidarSampling::receiver
                                  ? "of the ways that the pixels see, "
                                  : "of the light emitted ";
  const std::string fate = emitted + shares_text({{mean_.escaped / ledgers_, "left the scene"},
                                                  {mean_.absorbed / ledgers_, "was absorbed by surfaces"},
                                                  {mean_.air / ledgers_, "was lost to the air"},
                                                  {mean_.volumes / ledgers_, "was absorbed in volumes"},
                                                  {mean_.truncated / ledgers_, "was scattered by its last surface"}});
  if (matter_photons_ > 0 && lidar.detector.mode == scene::DetectorMode::geiger)
    return fmt::format(
        "the scene's light in the gate fires {:.3g} photo-electrons a record; give more energy_J, aperture or pulses, "
        "or a shorter gate",
        lidar.receiver.quantum_efficiency * matter_photons_ / std::max(1.0, records_));
  if (matter_photons_ > 0)
    return fmt::format(
        "the scene's light in the gate, {:.3g} photo-electrons a record and at most {:.3g} a bin, does not "
        "reach the threshold of {:.3g} "
        "above the background; give more energy_J or aperture, or lower the threshold ([lidar.echoes])",
        lidar.receiver.quantum_efficiency * matter_photons_ / std::max(1.0, records_), strongest_pe_,
        lowest_threshold_pe_);
  const double met = (mean_.absorbed + mean_.truncated + mean_.volumes) / ledgers_,
               beside = mean_.early + mean_.late + mean_.near;
  if (met < 1e-9) return "no beam meets anything: " + fate + "; point the LIDAR at the scene";
  if (!(mean_.truncated > 0) && mean_.absorbed > 0 && !(mean_.volumes > 0))
    return "surfaces absorb all light that meets them: " + fate +
           "; see the materials' reflectance at the laser's wavelength";
  if (beside > 0)
    return "the light of surfaces missed the gate: of what came back " +
           shares_text({{mean_.early / mean_.collected, "came before the gate opens"},
                        {mean_.late / mean_.collected, "after it closes"},
                        {mean_.near / mean_.collected, "from nearer than minimum_range_m"}}) +
           "; " +
           (mean_.near > mean_.early + mean_.late
                ? fmt::format("minimum_range_m is {:.6g}, lower it", lidar.transport.minimum_range_m)
                : gate + ", set start_range_m and stop_range_m");
  return "the receiver sees nothing of the light that surfaces scatter: " + fate +
         "; see fov_mrad, tilts and offsets of transmitter and receiver";
}

std::string LidarRunLight::warning() const {
  if (shots_ == 0 || records_ == 0 || !(ledgers_ > 0)) return {};
  const bool air_wanted = !plan_.lidar.echoes.air_is_background && air_photons_ > 0;
  if (echoes_ > 0 && (returns_of_matter_ >= kProbablyNone || air_wanted)) return {};
  const std::string what =
      echoes_ == 0 ? "no return was found" : fmt::format("all {} returns are noise, background or air", echoes_);
  const std::string air =
      matter_photons_ > 0 || !(air_photons_ > 0)
          ? ""
          : "; the gate holds the return of air and particles, which may count as background (air_is_background)";
  return fmt::format("{}: {} in {} pulses: {}{}", plan_.lidar.name, what, shots_, where_it_went(), air);
}

}  // namespace raycube::run
