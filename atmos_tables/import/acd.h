// MODTRAN 6 .acd (atmospheric correction data): what separates ground and air, per k-term.
//
// Text: header lines, then per row frequency (cm-1), line of sight, k, weight of k, and five functions. Binary:
// little-endian records of the same fields (4-byte floats, the line of sight and k 4-byte integers) between 4-byte
// markers of 36, the record's length; the first record is a header with frequency -9999. One run per line of sight;
// every function per k (place.k) and, under the same name without k, its sum with the weights. Two-way products belong
// to each k, before the sum.
#pragma once

#include <string>

#include "atmos_tables/import/imported.h"

namespace raycube::atmos::imported {

Imported read_acd_text(const std::string& path);
Imported read_acd_binary(const std::string& path);

}  // namespace raycube::atmos::imported
