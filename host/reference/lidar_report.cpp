#include <algorithm>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "host/base/text.h"
#include "host/reference/lidar_compare.h"
#include "host/reference/report_text.h"

namespace raycube::reference {

std::vector<std::string> LidarReport::failures() const {
  std::vector<std::string> out;
  if (pulses == 0)
    out.push_back("no pulse was compared");
  else if (compared_pulses == 0)
    out.push_back("no pulse's rays agree with the reference, so no bin was compared");
  if (const std::uint64_t count = hits[static_cast<std::size_t>(Cause::unexplained)]; count > 0)
    out.push_back(std::to_string(count) + " of " + std::to_string(rays) +
                  " first hits differ without explanation, the first in pulse " + std::to_string(unexplained_pulse) +
                  ", ray " + std::to_string(unexplained_ray));
  if (beyond_pulses > 0)
    out.push_back(base::counted(beyond_pulses, "pulse differs", "pulses differ") + " by more than " +
                  three_digits(limits.bin) + " of their peak bin, the worst by " + three_digits(worst) + " in pulse " +
                  std::to_string(worst_pulse) + ", line " + std::to_string(worst_line + 1) + ", bin " +
                  std::to_string(worst_bin));
  if (!(ledger_closure <= limits.ledger))
    out.push_back("a ledger is " + three_digits(ledger_closure) + " of the emitted energy from closed, limit " +
                  three_digits(limits.ledger));
  if (!(ledger_difference <= 10 * limits.ledger))
    out.push_back("a ledger's entry differs by " + three_digits(ledger_difference) + " of the emitted energy, limit " +
                  three_digits(10 * limits.ledger));
  if (has_air && !(air_worst <= limits.air))
    out.push_back("the return of air and particles differs by " + three_digits(air_worst) + " of its peak bin, limit " +
                  three_digits(limits.air));
  if (has_air && !(air_end_worst <= limits.air_end))
    out.push_back("the return of air and particles in bins with a surface's echo differs by " +
                  three_digits(air_end_worst) + " of its peak bin, limit " + three_digits(limits.air_end));
  if (has_scattered && !(std::abs(scattered.energy_z) <= limits.deviations))
    out.push_back("light scattered more than once is " + three_digits(scattered.energy_ratio) +
                  " of the reference's, " + three_digits(scattered.energy_z) + " standard errors off");
  if (has_scattered && !(scattered.chi_z <= limits.deviations))
    out.push_back("light scattered more than once has a chi-square of " + three_digits(scattered.chi_square) +
                  " per group, " + three_digits(scattered.chi_z) + " deviations too large");
  return out;
}

std::string LidarReport::text() const {
  std::string out =
      "pulses " + std::to_string(pulses) + ", rays " + std::to_string(rays) + "\nfirst hits:" + counts_text(hits);
  out += "\npulses with the same hits " + std::to_string(pulses - parted_pulses) +
         ", of these decided by rounding on the way to the receiver " + std::to_string(edge_pulses) + ", compared " +
         std::to_string(compared_pulses);
  out += "\nbins, over the peak bin: median of pulses " + three_digits(median) + ", worst " + three_digits(worst) +
         " (limit " + three_digits(limits.bin) + ")";
  if (worst_pulse >= 0)
    out += " in pulse " + std::to_string(worst_pulse) + ", line " + std::to_string(worst_line + 1) + ", bin " +
           std::to_string(worst_bin);
  if (rounded_pulses > 0)
    out += "; " + base::counted(rounded_pulses, "pulse") + " beyond it by no more than rounded paths do (" +
           three_digits(1e6 * float_path_m) + " um), the worst by " + three_digits(rounded_worst);
  if (has_air)
    out += "\nreturns of air and particles, over their own peak bin: median of pulses " + three_digits(air_median) +
           ", worst " + three_digits(air_worst) + " (limit " + three_digits(limits.air) +
           "), in bins with a surface's echo " + three_digits(air_end_worst) + " (limit " +
           three_digits(limits.air_end) + ")";
  out += "\nledger: closes to " + three_digits(ledger_closure) + " (limit " + three_digits(limits.ledger) + ")";
  if (!has_scattered) out += ", entries differ by " + three_digits(ledger_difference);
  if (has_scattered && scattered.groups == 0)
    out += "\nscattered more than once: too little was collected to be compared; a wider receiver sees more of it";
  else if (has_scattered)
    out += "\nscattered more than once: on the same draws " + std::to_string(scattered.same_draws) + " of " +
           std::to_string(scattered.pulses) + " pulses agree in every bin; on others energy " +
           three_digits(scattered.energy_ratio) + " of the reference's (" + three_digits(scattered.energy_z) +
           " standard errors), chi-square " + three_digits(scattered.chi_square) + " in each of " +
           std::to_string(scattered.groups) + " groups of bins (" + three_digits(scattered.chi_z) +
           " deviations, limit " + three_digits(limits.deviations) + ")";
  for (const std::string& failure : failures()) out += "\nBEYOND LIMITS: " + failure;
  return out + "\n";
}

std::string LidarReport::json() const {
  nlohmann::ordered_json out;
  out["passed"] = failures().empty();
  out["failures"] = failures();
  out["pulses"] = pulses;
  out["rays"] = rays;
  for (std::size_t c = 0; c < kCauses; ++c) out["hits_" + key_of(static_cast<Cause>(c))] = hits[c];
  out["parted_pulses"] = parted_pulses;
  out["edge_pulses"] = edge_pulses;
  out["compared_pulses"] = compared_pulses;
  out["rounded_pulses"] = rounded_pulses;
  out["rounded_worst"] = rounded_worst;
  out["float_path_m"] = float_path_m;
  out["beyond_pulses"] = beyond_pulses;
  out["median"] = median;
  out["worst"] = worst;
  out["worst_limit"] = limits.bin;
  out["worst_pulse"] = worst_pulse;
  out["worst_line"] = worst_line;
  out["worst_bin"] = worst_bin;
  out["ledger_closure"] = ledger_closure;
  out["ledger_limit"] = limits.ledger;
  if (!has_scattered) out["ledger_difference"] = ledger_difference;
  if (has_air)
    out["air"] = {{"median", air_median},
                  {"worst", air_worst},
                  {"limit", limits.air},
                  {"worst_at_echoes", air_end_worst},
                  {"limit_at_echoes", limits.air_end}};
  if (has_scattered)
    out["scattered"] = {{"pulses", scattered.pulses},
                        {"same_draws", scattered.same_draws},
                        {"energy_ratio", scattered.energy_ratio},
                        {"energy_z", scattered.energy_z},
                        {"groups", scattered.groups},
                        {"chi_square", scattered.chi_square},
                        {"chi_z", scattered.chi_z},
                        {"limit", limits.deviations}};
  return out.dump(2);
}

}  // namespace raycube::reference
