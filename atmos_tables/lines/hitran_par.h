// Line lists as hitran.org delivers them: records of 160 characters, fixed columns (Rothman et al. 2005, JQSRT 96, 139,
// table 1).
//
//   columns  1-2 molecule, 3 isotopologue (1-9, 0 = 10, A = 11, B = 12 ...), 4-15 wavenumber, 16-25 intensity, 36-40
//   gamma_air,
//   41-45 gamma_self, 46-55 lower energy, 56-59 n_air, 60-67 delta_air. The rest (quanta, references) is not used.
// Lines may come in any order. A blank gamma_self counts as gamma_air; a negative lower energy means that it is
// unknown: such a line keeps its intensity of 296 K but for the partition sum. Ends LF or CR LF. No HITRAN data come
// with raycube.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "atmos_tables/lines/spectral_line.h"

namespace raycube::atmos {

struct LineList {
  std::string file;
  std::vector<SpectralLine> lines;   ///< inside the range asked for, ascending in wavenumber
  std::uint64_t records = 0;         ///< of the whole file
  std::uint64_t unknown_energy = 0;  ///< lines in range without a lower energy
  struct Extent {
    std::uint64_t records = 0;
    double first_per_cm = 0, last_per_cm = 0;
  };
  std::map<int, Extent> molecules;  ///< of the whole file, by HITRAN's number
};

/// Reads the lines between two wavenumbers, cm-1. The file is streamed: memory holds the range alone. Of records
/// outside it only the length, molecule and wavenumber are read. Throws Error(environment) when the file cannot be
/// read, Error(input) that lists faults with line numbers (at most 20): records that are not 160 characters long,
/// unreadable or blank numbers, unknown molecules, intensities, widths or wavenumbers that are not positive; a file
/// without records.
LineList read_hitran_par(const std::string& file, double low_per_cm, double high_per_cm);

}  // namespace raycube::atmos
