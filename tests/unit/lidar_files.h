// A LIDAR's simulation file for tests, in parts that a test can replace.
#pragma once

#include <map>

#include "scene_files.h"

namespace raycube::scene::testing {

/// The smallest LIDAR that loads; replace["pulse"] = "..." puts other lines into a table, "top" into [[lidar]] itself.
inline std::string lidar_text(std::map<std::string, std::string> replace = {}) {
  std::map<std::string, std::string> parts = {{"top", "position_m = [0, 0, 1000]\nprf_khz = 10\npulses = 100\n"},
                                              {"pulse",
                                               "energy_J = 1e-4\nwavelength_nm = 1064\ndivergence_mrad = "
                                               "0.5\ndivergence_is = \"full angle at 1/e^2\"\nfwhm_ns = 4\n"},
                                              {"receiver", "aperture_diameter_m = 0.1\nfov_mrad = 1\n"},
                                              {"gate", "bins = 8000\n"}};
  for (auto& [part, text] : replace) parts[part] = text;
  std::string out = "format = 1\n[[lidar]]\nname = \"l\"\n" + parts["top"];
  for (const auto& [part, text] : parts)
    if (part != "top") out += "[lidar." + part + "]\n" + text;
  return out;
}

inline const char* kBeam = "energy_J = 1e-4\nwavelength_nm = 1064\nfwhm_ns = 4\n";

}  // namespace raycube::scene::testing
