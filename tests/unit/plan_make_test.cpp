// Whole plans: their spectra against the table read directly, their stated errors against measured ones, and bad input.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/synthetic.h"
#include "host/base/error.h"
#include "host/plan/plan.h"
#include "kernels/atmosphere/nodes.h"

using namespace raycube;

namespace {

constexpr double kPi = std::numbers::pi;

scene::Simulation simulation_with(double sun_zenith_deg, double relief_m) {
  scene::Simulation s;
  s.sun.zenith_deg = sun_zenith_deg;
  s.sun.azimuth_deg = 160;
  scene::Material grey, red;
  grey.name = "grey";
  grey.reflectance = {{0.3, 4.0}, {0.3, 0.3}};
  red.name = "ramp";
  red.reflectance = {{0.35, 0.7, 2.5}, {0.05, 0.4, 0.1}};
  s.scene.materials = {grey, red};
  s.scene.blocks.resize(1);
  for (std::size_t k = 0; k < RC_BLOCK; ++k)
    s.scene.blocks[0].surface[k] = k < 2 ? static_cast<std::uint32_t>(k) : RC_NONE;
  for (std::uint32_t c = 1; c <= 2; ++c) {
    shared::Surface surface{};
    surface.material[0] = c;
    surface.fraction[0] = 1;
    s.scene.surfaces.push_back(surface);
  }
  s.scene.lo = {-100, -100, 0};
  s.scene.hi = {100, 100, static_cast<float>(relief_m)};
  return s;
}

scene::Instrument spectrometer(int bands, double first_um, double step_um) {
  scene::Instrument instrument;
  instrument.name = "spectrometer";
  for (int b = 0; b < bands; ++b) {
    scene::Band band;
    band.center_um = first_um + step_um * b;
    band.fwhm_um = std::min(0.006, 1.1 * step_um);
    instrument.bands.push_back(band);
  }
  return instrument;
}

plan::ViewBounds pushbroom_view(double half_deg, double height_m) {
  const double s = std::sin(half_deg * kPi / 180);
  return {1, 1 / std::cos(half_deg * kPi / 180), -s, s, -0.02, 0.02, height_m};
}

double weight_of(const plan::NodeAxis& axis, double value, int node) {
  int index = 0;
  float fraction = 0;
  rc_node_weights(static_cast<float>(value), axis.first, axis.step, axis.count, &index, &fraction);
  return node == index ? 1 - double{fraction} : node == index + 1 ? double{fraction} : 0;
}

double band(const plan::Plan& p, std::size_t b, const std::vector<double>& on_grid) {
  double sum = 0;
  for (std::size_t i = 0; i < p.bands[b].weight.size(); ++i)
    sum += p.bands[b].weight[i] * on_grid[p.bands[b].first + i];
  return sum;
}

std::string message_of(const scene::Simulation& s, const scene::Instrument& i, const atmos::RenderTable& t,
                       const plan::ViewBounds& v) {
  try {
    plan::make_plan(s, i, t, v);
  } catch (const base::Error& error) {
    CHECK(error.fault() == base::Fault::input);
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("S15 no air: grey plane under the sun has L = rho E0 cos / pi, no sky, no path") {
  auto s = simulation_with(30, 20);
  s.atmosphere.none = true;
  atmos::UniformAir air;
  air.solar_irradiance = [](double l) { return 1800 - 400 * l; };
  air.sun_zenith_deg = 30;
  const auto table = atmos::uniform_table(air, atmos::wavelength_grid(0.4, 1.0, 0.01));
  const auto instrument = spectrometer(8, 0.5, 0.05);
  const auto p = plan::make_plan(s, instrument, table, pushbroom_view(15, 610));
  CHECK(p.sky_components == 0);
  CHECK(p.source_channels() == 1);
  CHECK(p.path_channels() == 1);
  CHECK(p.sky.rays == 0);
  CHECK(p.sun_direction[2] == doctest::Approx(std::cos(kPi / 6)).epsilon(1e-6));
  const auto row = plan::bake_row(p, s.scene, 1), path = plan::bake_row(p, s.scene, 0);
  REQUIRE(row.size() == 16);
  for (std::size_t b = 0; b < 8; ++b) {
    CHECK(row[b] ==
          doctest::Approx(0.3 * (1800 - 400 * instrument.bands[b].center_um) / kPi).epsilon(2e-7));  // float storage
    CHECK(path[b] == 0);
  }
  for (std::size_t b = 8; b < 16; ++b) CHECK(row[b] == 0);
}

TEST_CASE("S15 rows of a material that lets light through: its transmittance, and 1 - R - T of what it emits") {
  auto s = simulation_with(30, 20);
  s.atmosphere.none = true;
  atmos::UniformAir air;
  air.solar_irradiance = [](double) { return 1800.0; };
  air.sun_zenith_deg = 30;
  const auto table = atmos::uniform_table(air, atmos::wavelength_grid(0.4, 1.0, 0.01));
  auto p = plan::make_plan(s, spectrometer(8, 0.5, 0.05), table, pushbroom_view(15, 610));
  p.thermal.on = true, p.thermal.temperature_K = {300};  // one node, of unit radiance; surroundings without light
  const std::vector<double> none(p.wavelength_um.size(), 0.0), one(p.wavelength_um.size(), 1.0);
  p.source_spectrum.push_back(none), p.source_spectrum.push_back(one);
  REQUIRE(p.source_channels() == 3);
  s.scene.materials[0].transmittance = {{0.35, 2.5}, {0.2, 0.2}};
  const auto transmittance = [&](std::uint32_t material) {
    return rc_key_of(rc_curve_id(RC_CURVE_TRANSMITTANCE, material, scene::material_count(s.scene)));
  };
  const auto reflected = plan::bake_row(p, s.scene, 1), through = plan::bake_row(p, s.scene, transmittance(0)),
             opaque = plan::bake_row(p, s.scene, transmittance(1));
  REQUIRE(through.size() == 3 * 16);
  for (std::size_t b = 0; b < 8; ++b) {
    CHECK(through[b] == doctest::Approx(0.2 / 0.3 * double{reflected[b]}).epsilon(2e-7));
    CHECK(reflected[32 + b] + through[32 + b] == doctest::Approx(1 - 0.3 - 0.2).epsilon(2e-7));
    CHECK(opaque[b] == 0);
    CHECK(opaque[32 + b] == 0);
  }
}

TEST_CASE("S15 uniform air: sun, sky and path spectra carry the stated factors") {
  const auto s = simulation_with(40, 0);
  atmos::UniformAir air;
  air.solar_irradiance = [](double l) { return 1000 + 100 * l; };
  air.sun_transmission = [](double) { return 0.8; };
  air.view_transmission = [](double) { return 0.9; };
  air.two_way_factor = [](double) { return 1.05; };
  air.sky_radiance = [](double) { return 30.0; };
  air.path_radiance = [](double) { return 5.0; };
  air.sun_zenith_deg = 40;
  const auto table = atmos::uniform_table(air, atmos::wavelength_grid(0.4, 1.0, 0.005));
  const auto p = plan::make_plan(s, spectrometer(5, 0.5, 0.05), table, pushbroom_view(20, 610));
  REQUIRE(p.sky_components == 1);
  REQUIRE(p.source_channels() == 2);
  for (std::size_t i = 0; i < p.wavelength_um.size(); ++i) {
    // 1e-7: the table's floats
    CHECK(p.source_spectrum[0][i] ==
          doctest::Approx((1000 + 100 * p.wavelength_um[i]) * 0.8 * 0.9 * 1.05 / kPi).epsilon(3e-7));
    CHECK(p.source_spectrum[1][i] == doctest::Approx(30 * kPi * 0.9 * 1.05 / kPi).epsilon(3e-7));
    CHECK(p.path_spectrum[0][i] == doctest::Approx(5).epsilon(3e-7));
    CHECK(p.transmission_spectrum[0][i] == doctest::Approx(0.9).epsilon(3e-7));
  }
}

TEST_CASE(
    "S18 clear sky, relief and a wide swath: node interpolation stays inside the stated error and the tolerance") {
  auto s = simulation_with(40, 60);
  const auto table = atmos::build_clear_sky(s.atmosphere, s.sun, 610, atmos::clear_sky_wavelengths(0.36, 2.49),
                                            atmos::clear_sky_heights(0, 60));
  const auto instrument = spectrometer(360, 0.3948, 0.0057);
  const auto view = pushbroom_view(14.7, 610);
  const auto p = plan::make_plan(s, instrument, table, view);
  MESSAGE("plan of 360 bands and " << p.wavelength_um.size() << " grid points:\n" << plan::plan_json(p).dump(2));
  CHECK(p.source_channels() <= RC_MAX_CHANNELS);
  CHECK(p.path_channels() <= RC_MAX_CHANNELS);
  CHECK(p.source_spectrum.size() == static_cast<std::size_t>(p.source_channels()));
  CHECK(p.path_spectrum.size() == static_cast<std::size_t>(p.path_channels()));
  CHECK(p.transmission_spectrum.size() == static_cast<std::size_t>(p.height.count * p.view.count));

  // Sunlit level grey ground at random places of the view: plan against the table read there, worst band over
  // rms-typical
  std::vector<double> largest_error(instrument.bands.size(), 0), mean(instrument.bands.size(), 0);
  constexpr int places = 24;
  const double mu0 = std::cos(40 * kPi / 180);
  const auto& table_um = atmos::wavelengths(table);
  for (int k = 0; k < places; ++k) {
    const double z = 60 * std::fmod(0.5 + k * 0.7548776662, 1.0),
                 x = view.x_max * (2 * std::fmod(0.5 + k * 0.5698402909, 1.0) - 1);
    const double y = 0, sec = 1 / std::sqrt(1 - x * x), zenith = std::asin(std::abs(x)) * 180 / kPi,
                 azimuth = (x > 0 ? 90 : 270) - 160;
    auto direct = atmos::two_way_transmission(table, z, zenith);
    const auto e0 = atmos::solar_irradiance(table), up = atmos::view_transmission(table, z, zenith),
               r2 = atmos::two_way_factor(table, z, zenith);
    const auto diffuse = atmos::diffuse_irradiance(table, z), path = atmos::path_radiance(table, z, zenith, azimuth);
    for (std::size_t i = 0; i < direct.size(); ++i)
      direct[i] = 0.3 / kPi * (mu0 * e0[i] * direct[i] + diffuse[i] * up[i] * r2[i]) + path[i];
    const auto want = atmos::resample_linear(table_um, direct, p.wavelength_um);
    std::vector<double> found(p.wavelength_um.size(), 0.0);
    for (int h = 0; h < p.height.count; ++h) {
      const double wh = weight_of(p.height, z, h);
      for (int v = 0; v < p.view.count; ++v) {
        const double w = wh * weight_of(p.view, sec, v);
        const auto sun = static_cast<std::size_t>(h * p.view.count + v),
                   sky = static_cast<std::size_t>((p.height.count + h) * p.view.count + v);
        for (std::size_t i = 0; i < found.size(); ++i)
          found[i] += w * 0.3 * (mu0 * p.source_spectrum[sun][i] + p.source_spectrum[sky][i]);
      }
      for (int b = 0; b < p.path_y.count; ++b)
        for (int a = 0; a < p.path_x.count; ++a) {
          const double w = wh * weight_of(p.path_y, y, b) * weight_of(p.path_x, x, a);
          const auto& spectrum =
              p.path_spectrum[static_cast<std::size_t>((h * p.path_y.count + b) * p.path_x.count + a)];
          for (std::size_t i = 0; i < found.size(); ++i) found[i] += w * spectrum[i];
        }
    }
    for (std::size_t b = 0; b < instrument.bands.size(); ++b) {
      const double reference = band(p, b, want);
      largest_error[b] = std::max(largest_error[b], std::abs(band(p, b, found) - reference));
      mean[b] += reference / places;
    }
  }
  const double brightest = *std::max_element(mean.begin(), mean.end());
  double worst = 0;
  for (std::size_t b = 0; b < mean.size(); ++b)
    worst = std::max(worst, largest_error[b] / std::max(mean[b], 1e-4 * brightest));
  MESSAGE("worst band, worst place: " << worst);
  CHECK(worst < s.tolerance);
}

TEST_CASE("S18 flat scene seen straight down needs one node of everything") {
  auto s = simulation_with(40, 0);
  const auto table = atmos::build_clear_sky(s.atmosphere, s.sun, 610, atmos::clear_sky_wavelengths(0.4, 0.9), {0});
  const auto p = plan::make_plan(s, spectrometer(20, 0.45, 0.02), table, pushbroom_view(0.5, 610));
  CHECK(p.height.count == 1);
  CHECK(p.view.count == 1);
  CHECK(p.path_x.count == 1);
  CHECK(p.path_y.count == 1);
}

TEST_CASE("S18 sun below the horizon: no direct light, dark sky has no components") {
  auto s = simulation_with(120, 0);
  const auto table = atmos::build_clear_sky(s.atmosphere, s.sun, 610, atmos::clear_sky_wavelengths(0.4, 0.9), {0});
  const auto p = plan::make_plan(s, spectrometer(20, 0.45, 0.02), table, pushbroom_view(10, 610));
  CHECK_FALSE(p.sun_up);
  CHECK(p.sky_components == 0);
  CHECK(p.sun_direction[2] < 0);
  const auto row = plan::bake_row(p, s.scene, 1);
  CHECK(std::all_of(row.begin(), row.end(), [](float v) { return v == 0; }));
}

TEST_CASE("S61 the same plan twice, bit for bit; another seed moves only the seed of its rays") {
  auto s = simulation_with(40, 20);
  const auto table = atmos::build_clear_sky(s.atmosphere, s.sun, 610, atmos::clear_sky_wavelengths(0.4, 0.9, 0.005),
                                            atmos::clear_sky_heights(0, 20));
  const auto instrument = spectrometer(20, 0.45, 0.02);
  const auto a = plan::make_plan(s, instrument, table, pushbroom_view(10, 610)),
             b = plan::make_plan(s, instrument, table, pushbroom_view(10, 610));
  s.seed = 2;
  const auto c = plan::make_plan(s, instrument, table, pushbroom_view(10, 610));
  CHECK(a.source_spectrum == b.source_spectrum);
  CHECK(plan::plan_json(a) == plan::plan_json(b));
  const auto same = [](const auto& u, const auto& v) {
    return std::equal(u.begin(), u.end(), v.begin(), v.end(), [](const auto& p, const auto& q) {
      return p.x == q.x && p.y == q.y && p.z == q.z && p.w == q.w;
    });
  };
  CHECK(same(a.irradiance.value, b.irradiance.value));
  CHECK(a.source_spectrum == c.source_spectrum);
  CHECK(a.sky.hash_seed(1) != c.sky.hash_seed(2));
}

TEST_CASE("S18 bad input: missing row, foreign sun, view beyond the table") {
  auto s = simulation_with(40, 0);
  atmos::UniformAir air;
  air.sun_zenith_deg = 40;
  auto table = atmos::uniform_table(air, atmos::wavelength_grid(0.4, 1.0, 0.01));
  const auto instrument = spectrometer(5, 0.5, 0.05);
  auto without = table;
  without.rows.erase("two_way_factor");
  CHECK(message_of(s, instrument, without, pushbroom_view(5, 610)).find("two_way_factor") != std::string::npos);
  without = table;
  without.rows.erase("sky_radiance_solar");
  CHECK(message_of(s, instrument, without, pushbroom_view(5, 610)).find("sky_radiance_solar") != std::string::npos);
  s.sun.zenith_deg = 41;
  CHECK(message_of(s, instrument, table, pushbroom_view(5, 610)).find("41.0000 deg") != std::string::npos);
  s.sun.zenith_deg = 40;
  s.sky_directions = 5000;
  CHECK(message_of(s, instrument, table, pushbroom_view(5, 610)).find("found 5000") != std::string::npos);
  s.sky_directions = 16;
  const auto clear =
      atmos::build_clear_sky(s.atmosphere, s.sun, 610, atmos::clear_sky_wavelengths(0.4, 0.9, 0.02), {0});
  CHECK(message_of(s, instrument, clear, pushbroom_view(89.5, 610)).find("89.50 deg off nadir") != std::string::npos);
}

TEST_CASE(
    "S18 octahedral nodes: a node's own direction finds it, weights are a partition of one, no seams at the horizon") {
  const int size = 33, half = 16;
  for (int v = 0; v < size; ++v)
    for (int u = 0; u < size; ++u) {
      double x = static_cast<double>(u - half) / half, y = static_cast<double>(v - half) / half,
             z = 1 - std::abs(x) - std::abs(y);
      if (z < 0) {
        const double fx = (1 - std::abs(y)) * (x < 0 ? -1 : 1), fy = (1 - std::abs(x)) * (y < 0 ? -1 : 1);
        x = fx;
        y = fy;
      }
      int index[3];
      float weight[3];
      rc_octahedral_nodes(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), size, index, weight);
      double there = 0;
      for (int k = 0; k < 3; ++k) {
        const int iu = index[k] % size, iv = index[k] / size;
        REQUIRE(index[k] >= 0);
        REQUIRE(index[k] < size * size);
        // the lower half's edge is folded onto itself: (u, v) on the rim is the same direction as its mirror image
        const bool rim = (iu == 0 || iu == size - 1) && (u == 0 || u == size - 1) && iu == u && iv == size - 1 - v;
        const bool rim_v = (iv == 0 || iv == size - 1) && (v == 0 || v == size - 1) && iv == v && iu == size - 1 - u;
        const bool pole =
            (iu % (size - 1) == 0) && (iv % (size - 1) == 0) && (u % (size - 1) == 0) && (v % (size - 1) == 0);
        if ((iu == u && iv == v) || rim || rim_v || pole) there += double{weight[k]};
      }
      CHECK(there == doctest::Approx(1).epsilon(1e-6));
    }
}

TEST_CASE("S18 node weights: clamped ends, one node, exact at nodes") {
  int index = -1;
  float fraction = -1;
  rc_node_weights(3.5f, 1.0f, 0.5f, 4, &index, &fraction);
  CHECK(index == 2);
  CHECK(fraction == 1.0f);
  rc_node_weights(-3.0f, 1.0f, 0.5f, 4, &index, &fraction);
  CHECK(index == 0);
  CHECK(fraction == 0.0f);
  rc_node_weights(1.75f, 1.0f, 0.5f, 4, &index, &fraction);
  CHECK(index == 1);
  CHECK(fraction == 0.5f);
  rc_node_weights(99.0f, 1.0f, 1.0f, 1, &index, &fraction);
  CHECK(index == 0);
  CHECK(fraction == 0.0f);
  rc_node_weights(std::nanf(""), 1.0f, 0.5f, 4, &index, &fraction);
  CHECK(index == 0);
  CHECK(fraction == 0.0f);
}
