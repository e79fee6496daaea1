// Units of radiance in headers of cubes, against conversions by hand.
#include "host/products/radiance_unit.h"

#include <doctest/doctest.h>

#include <cmath>

using raycube::products::radiance_of;

// 1 W is 1e3 mW, 1e6 uW and 1e9 nW; 1 m2 is 1e4 cm2; 1 um is 1e3 nm. One of a unit of power, area and wavelength is
// (its power in W) / (its area in m2) / (its wavelength in um) W m-2 sr-1 um-1.
TEST_CASE("radiance units: each is the number of W m-2 sr-1 um-1 that it is by hand") {
  const struct {
    const char* unit;
    double ours;
  } kCases[] = {
      {"W m-2 sr-1 um-1", 1},
      {"W/(m^2 sr um)", 1},
      {"W/m2/sr/um", 1},
      {"W / m^2 / sr / micrometer", 1},
      {"W m^-2 sr^-1 um^-1", 1},
      {"W*m**-2*sr**-1*um**-1", 1},
      {"W.m-2.sr-1.um-1", 1},
      {"W m\u207b\u00b2 sr\u207b\u00b9 \u00b5m\u207b\u00b9", 1},
      {"W\u00b7m-2\u00b7sr-1\u00b7\u03bcm-1", 1},
      {"W m-2 sr-1 \xb5m-1", 1},  // Latin-1
      {"watts per square meter per steradian per micron", 1},
      {"watts per meter squared per steradian per micrometer", 1},
      {"mW m-2 sr-1 nm-1", 1},
      {"mW/(m^2 nm sr)", 1},
      {"milliwatts / (square metre nanometre steradian)", 1},
      {"W m-2 sr-1 nm-1", 1e3},
      {"uW cm-2 sr-1 nm-1", 10},
      {"uW/cm^2/sr/nm", 10},
      {"\u00b5W/(cm\u00b2*nm*sr)", 10},
      {"uW/(cm^2 nm sr)", 10},
      {"Radiance (uW cm-2 sr-1 nm-1)", 10},
      {"spectral radiance [W m-2 sr-1 um-1]", 1},
      {"Spectral Radiance, W/(m^2 sr um)", 1},
      {"Radiance: uW/cm^2/sr/nm", 10},
      {"uW/(cm^2 sr nm) radiance", 10},
      {"[microwatts per square centimeter per nanometer per steradian]", 10},
      {"microwatts per centimeter squared per nanometer per steradian", 10},
      {"mW cm-2 sr-1 um-1", 10},
      {"nW cm-2 sr-1 nm-1", 1e-2},
      {"uW m-2 sr-1 nm-1", 1e-3},
      {"mW m-2 sr-1 um-1", 1e-3},
      {"W cm-2 sr-1 um-1", 1e4},
  };
  for (const auto& [unit, ours] : kCases) {
    const auto found = radiance_of(unit);
    CHECK_MESSAGE(found.has_value(), unit);
    if (found) CHECK_MESSAGE(std::abs(*found / ours - 1) < 1e-12, unit << ": " << *found << " for " << ours);
  }
}

TEST_CASE("radiance units: what is no radiance by wavelength has none") {
  for (const char* unit :
       {"", "reflectance", "DN", "K", "radiance", "Radiance (DN)", "spectral irradiance (W m-2 um-1)",
        "W m-2 sr-1",           // all wavelengths
        "W m-2 um-1",           // irradiance
        "W sr-1 um-1",          // intensity
        "W m-2 sr-1 (cm-1)-1",  // by wavenumber
        "mW m-2 sr-1 cm", "W m-2 sr-2 um-1", "W m-2 sr-1 um", "10 W m-2 sr-1 um-1", "W m-2 sr-1 um-1 * 10",
        "W/m^2 sr um",  // what stands below the line is not told
        "W/m^2)/sr/um", "photons s-1 m-2 sr-1 um-1"})
    CHECK_MESSAGE(!radiance_of(unit), unit << ": " << *radiance_of(unit));
}
