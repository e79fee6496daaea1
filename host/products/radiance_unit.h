// Units of spectral radiance as headers of cubes write them.
#pragma once

#include <optional>
#include <string>

namespace raycube::products {

/// The unit of ours.
inline constexpr const char* kRadianceUnit = "W m-2 sr-1 um-1";

/// How many W m-2 sr-1 um-1 one of a unit is: "uW/(cm^2 nm sr)", "W m-2 sr-1 um-1", "microwatts per square centimeter
/// per nanometer per steradian", "Radiance (uW cm-2 sr-1 nm-1)" .. nullopt: the text is no unit of radiance by
/// wavelength.
std::optional<double> radiance_of(const std::string& unit);

}  // namespace raycube::products
