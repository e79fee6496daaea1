// The shipped park through the scene compiler. The folder was assembled by the test before this one (fixture `park`).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>

#include "scene_compiler/load_simulation.h"
#include "scene_compiler/scene_info.h"
#include "scene_compiler/spectrum_file.h"

using namespace raycube;

namespace {

std::string park_file() {
  const char* folder = std::getenv("RAYCUBE_PARK");
  REQUIRE_MESSAGE(folder != nullptr, "RAYCUBE_PARK must name the assembled park: run this test through ctest");
  return std::string(folder) + "/park.toml";
}

/// Solar zenith and azimuth, degrees, from the low-precision formulae of the Astronomical Almanac (page C5; 0.01
/// degrees from 1950 to 2050), written apart from the program's own.
void almanac_sun(double days_since_j2000, double latitude_deg, double longitude_deg, double& zenith_deg,
                 double& azimuth_deg) {
  const double rad = std::numbers::pi / 180;
  const double mean_longitude = 280.460 + 0.9856474 * days_since_j2000;
  const double anomaly = (357.528 + 0.9856003 * days_since_j2000) * rad;
  const double ecliptic = (mean_longitude + 1.915 * std::sin(anomaly) + 0.020 * std::sin(2 * anomaly)) * rad;
  const double obliquity = (23.439 - 0.0000004 * days_since_j2000) * rad;
  const double right_ascension = std::atan2(std::cos(obliquity) * std::sin(ecliptic), std::cos(ecliptic));
  const double declination = std::asin(std::sin(obliquity) * std::sin(ecliptic));
  const double sidereal = (280.46062 + 360.98564737 * days_since_j2000 + longitude_deg) * rad;
  const double hour = sidereal - right_ascension, latitude = latitude_deg * rad;
  const double up =
      std::sin(latitude) * std::sin(declination) + std::cos(latitude) * std::cos(declination) * std::cos(hour);
  const double east = -std::cos(declination) * std::sin(hour);
  const double north =
      std::cos(latitude) * std::sin(declination) - std::sin(latitude) * std::cos(declination) * std::cos(hour);
  zenith_deg = std::acos(up) / rad;
  azimuth_deg = std::fmod(std::atan2(east, north) / rad + 360, 360);
}

double value_at(const scene::Curve& curve, double um) {
  const auto& w = curve.wavelength_um;
  const auto i = static_cast<std::size_t>(std::upper_bound(w.begin() + 1, w.end() - 1, um) - w.begin());
  const double f = (um - w[i - 1]) / (w[i] - w[i - 1]);
  return (1 - f) * curve.value[i - 1] + f * curve.value[i];
}

/// Reflectance of a deep pile of leaves: R = r + t^2 R / (1 - r R) (Stokes 1862).
double deep_pile(double r, double t) {
  const double b = 1 + r * r - t * t;
  return (b - std::sqrt(b * b - 4 * r * r)) / (2 * r);
}

}  // namespace

TEST_CASE("S1 S2 S3 S42: the shipped park compiles; one mesh is stored however many trees stand") {
  const auto simulation = scene::load_simulation(park_file());
  const auto info = scene::scene_info(simulation.scene);
  std::uint64_t plants = 0, trees = 0;
  for (const auto& mesh : info.meshes) {
    const bool tree = mesh.name == "maple" || mesh.name == "aspen" || mesh.name == "spruce";
    if (tree) {
      ++trees;
      plants += mesh.instances;
      CHECK_MESSAGE(mesh.triangles >= 20000, mesh.name);
    }
    if (mesh.name == "ground") CHECK(mesh.triangles == 2u * 800 * 800);  // two triangles per cell
    if (mesh.name == "blue checkerboard 24 x 24 ft") CHECK(mesh.triangles == 2u * 24 * 24);
    if (mesh.name == "wood block") CHECK(mesh.instances == 24);
  }
  CHECK(trees == 3);
  CHECK(plants >= 300);
  CHECK(info.placed_triangles > 20 * info.triangles);
  CHECK(info.bytes < 128u << 20);  // 1.4 M triangles of 40 bytes and their trees

  const auto& spectir = simulation.instruments.at(0);
  CHECK(spectir.bands.size() == 360);
  CHECK(spectir.pixels == 320);
  CHECK(spectir.lines == 320);
  CHECK(spectir.ifov_across_rad == doctest::Approx(1.0 / 610).epsilon(1e-12));
  CHECK(std::is_sorted(spectir.bands.begin(), spectir.bands.end(),
                       [](const auto& a, const auto& b) { return a.center_um < b.center_um; }));
  // S42: 394.8 + 4.6 n nm, then 6.3 nm steps; every band inside every curve
  CHECK(spectir.bands.front().center_um == doctest::Approx(0.3994).epsilon(1e-9));
  CHECK(spectir.bands.at(124).center_um == doctest::Approx(0.9698).epsilon(1e-9));
  CHECK(spectir.bands.back().center_um == doctest::Approx(2.4503).epsilon(1e-9));
  for (const auto& material : simulation.scene.materials) {
    CHECK_MESSAGE(material.reflectance.wavelength_um.front() < 0.3994 - 2.5 * 0.0046, material.name);
    CHECK_MESSAGE(material.reflectance.wavelength_um.back() > 2.4503 + 2.5 * 0.0063, material.name);
    CHECK_MESSAGE(!material.source.empty(), material.name);
  }
}

TEST_CASE("S24: the park's leaves, piled, are the foliage that libraries measured") {
  // Shares of a pile that light does not fall past, and what least squares over contents and share leave, rms:
  // docs/park.md.
  const struct {
    const char* name;
    double share, rms;
  } piles[] = {{"maple_leaf", 0.898, 0.009},
               {"aspen_leaf", 0.662, 0.011},
               {"walnut_leaf", 0.774, 0.011},
               {"spruce_needles", 0.771, 0.0225}};
  const auto simulation = scene::load_simulation(park_file());
  for (const auto& [name, share, rms] : piles) {
    CAPTURE(name);
    base::Problems problems;
    scene::SpectrumRequest request;
    request.file = std::filesystem::path(park_file()).parent_path() / "spectra" / (std::string(name) + ".csv");
    const auto measured = scene::read_spectrum(request, problems);
    REQUIRE(measured);
    const auto& materials = simulation.scene.materials;
    const auto leaf = std::find_if(materials.begin(), materials.end(), [&](const auto& m) { return m.name == name; });
    REQUIRE(leaf != materials.end());
    const auto& [wavelength_um, foliage] = measured->reflectance;
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < foliage.size(); ++i) {
      if (wavelength_um[i] < 0.4 || wavelength_um[i] > 2.49) continue;
      const double r = value_at(leaf->reflectance, wavelength_um[i]);
      const double t = value_at(leaf->transmittance, wavelength_um[i]);
      sum += std::pow(share * deep_pile(r, t) - foliage[i], 2);
      ++count;
    }
    CHECK(count > 200);
    CHECK(std::sqrt(sum / count) < rms);
  }
}

TEST_CASE("S46: the park's sun stands where the Astronomical Almanac puts it") {
  const auto simulation = scene::load_simulation(park_file(), {.seed = {}, .compile = false});
  // 2012-09-20 15:30 UTC is 4646.1458333 days after J2000; E 276000 N 4753000 of UTM zone 18 is 42.89674 N, 77.74352 W,
  // where grid north lies 1.8675 degrees west of true north: convergence = (lon - lon0) sin(lat) = -2.7435 * 0.68068
  double zenith = 0, azimuth = 0;
  almanac_sun(4646.1458333, 42.89674, -77.74352, zenith, azimuth);
  CHECK(std::abs(simulation.sun.zenith_deg - zenith) < 0.02);  // the formulae's 0.01 plus the position's rounding
  CHECK(std::abs(simulation.sun.azimuth_deg - (azimuth + 1.8675)) < 0.03);
}
