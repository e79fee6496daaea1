// Records of a line list in HITRAN's format, written for tests: no data of HITRAN.
#pragma once

#include <cstdio>
#include <string>

#include "atmos_tables/lines/spectral_line.h"

namespace raycube::testing {

/// 160 characters and a line end. Numbers below 1 lose their 0, as HITRAN prints them.
inline std::string hitran_record(const atmos::SpectralLine& line) {
  const auto field = [](const char* format, double value, std::size_t width) {
    char text[40];
    std::snprintf(text, sizeof text, format, value);
    std::string out = text;
    const std::size_t zero = out.find("0.");
    if (zero != std::string::npos && (zero == 0 || out[zero - 1] == '-') && out.size() > width) out.erase(zero, 1);
    return std::string(width - out.size(), ' ') + out;
  };
  std::string out = field("%.0f", line.molecule, 2) + field("%.0f", line.isotopologue, 1) +
                    field("%.6f", line.wavenumber_per_cm, 12) + field("%.3E", line.intensity, 10) +
                    field("%.3E", 1.0, 10) + field("%.4f", line.gamma_air, 5) + field("%.3f", line.gamma_self, 5) +
                    field("%.4f", line.lower_energy_per_cm, 10) + field("%.2f", line.n_air, 4) +
                    field("%.6f", line.delta_air, 8);
  out.resize(160, ' ');
  return out + "\n";
}

}  // namespace raycube::testing
