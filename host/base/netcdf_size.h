// Bytes that a netCDF file of the classic formats must have: its library reads what is missing as zeros.
#pragma once

#include <cstdint>
#include <string>

namespace raycube::base {

/// By the header's counts (netCDF classic format specification: CDF-1, CDF-2, CDF-5); 0: it is none of these, or its
/// header cannot be followed.
std::uint64_t netcdf_bytes(const std::string& path);

}  // namespace raycube::base
