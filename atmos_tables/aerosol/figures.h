// Layout of the restated figures. For the .cpp files of this folder.
#pragma once

#include <cstddef>

namespace raycube::atmos::figures {

inline constexpr std::size_t kWaves = 46, kPhaseWaves = 27, kPhaseAngles = 34, kPhases = 70;

struct OpticsRow {
  const char* name;
  double grade;
  double extinction[kWaves], absorption[kWaves], asymmetry[kWaves];
};
struct PhaseRow {
  const char* name;
  double grade;
  unsigned char function[kPhaseWaves];
};

}  // namespace raycube::atmos::figures
