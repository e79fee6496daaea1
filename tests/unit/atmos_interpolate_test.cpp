// Reading between nodes. Oracles: identity at nodes, Beer-Lambert, closed forms of the rules.
#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <numbers>

#include "atmos_tables/interpolate.h"
#include "atmos_tables/synthetic.h"
#include "atmos_tables/table_rows.h"
#include "host/base/error.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {
/// A small table whose values are made of a smooth formula, with every row the renderer reads.
RenderTable small_table() {
  RenderTable t = uniform_table({}, {0.5, 0.6});
  t.sun_zenith_deg = 40;
  t.rows.clear();
  add_axis(t, "target_height", {0, 100, 400});
  add_axis(t, "view_zenith", {0, 30, 60});
  add_axis(t, "relative_azimuth", {0, 90, 180});
  const auto& h = t.axis("target_height").nodes;
  const auto& v = t.axis("view_zenith").nodes;
  Row& sun = add_row(t, "sun_transmission", "test");
  Row& view = add_row(t, "view_transmission", "test");
  Row& path = add_row(t, "path_radiance_solar", "test");
  Row& factor = add_row(t, "two_way_factor", "test");
  for (std::size_t l = 0; l < 2; ++l)
    for (std::size_t i = 0; i < 3; ++i) {
      sun.values[l * 3 + i] = static_cast<float>(std::exp(-0.5 - 0.1 * static_cast<double>(l) + h[i] / 4000));
      for (std::size_t j = 0; j < 3; ++j) {
        const double depth =
            (1000 - h[i]) / 2000 / std::cos(v[j] * std::numbers::pi / 180) * (1.0 + static_cast<double>(l));
        view.values[(l * 3 + i) * 3 + j] = static_cast<float>(std::exp(-depth));
        factor.values[(l * 3 + i) * 3 + j] = static_cast<float>(1 + 0.01 * static_cast<double>(i + j));
        for (std::size_t k = 0; k < 3; ++k)
          path.values[((l * 3 + i) * 3 + j) * 3 + k] =
              static_cast<float>((7.0 + static_cast<double>(k)) * -std::expm1(-depth));
      }
    }
  validate(t, "test");
  return t;
}
}  // namespace

TEST_CASE("S18 interpolation returns the stored value at every node") {
  const RenderTable t = small_table();
  const auto& h = t.axis("target_height").nodes;
  const auto& v = t.axis("view_zenith").nodes;
  const auto& a = t.axis("relative_azimuth").nodes;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const auto view = view_transmission(t, h[i], v[j]);
      for (std::size_t l = 0; l < 2; ++l)
        CHECK(view[l] == doctest::Approx(t.rows.at("view_transmission").values[(l * 3 + i) * 3 + j]).epsilon(1e-13));
      for (std::size_t k = 0; k < 3; ++k) {
        const auto path = path_radiance(t, h[i], v[j], a[k]);
        for (std::size_t l = 0; l < 2; ++l)
          CHECK(path[l] ==
                doctest::Approx(t.rows.at("path_radiance_solar").values[((l * 3 + i) * 3 + j) * 3 + k]).epsilon(1e-13));
      }
    }
}

TEST_CASE("S18 transmission is linear in depth over height and in depth times cosine over zenith") {
  const RenderTable t = small_table();
  // Depth (1000 - h)/2000 / cos(zenith) is what the rule reproduces exactly; 3e-7: the stored float values.
  for (double h : {30.0, 250.0, 399.0})
    for (double z : {10.0, 45.0, 59.0}) {
      const auto view = view_transmission(t, h, z);
      const double depth = (1000 - h) / 2000 / std::cos(z * std::numbers::pi / 180);
      CHECK(view[0] == doctest::Approx(std::exp(-depth)).epsilon(3e-7));
      CHECK(view[1] == doctest::Approx(std::exp(-2 * depth)).epsilon(3e-7));
    }
  CHECK(sun_transmission(t, 50)[0] == doctest::Approx(std::exp(-0.5 + 50.0 / 4000)).epsilon(3e-7));
}

TEST_CASE("S18 path radiance over 1 - T is linear, azimuths fold, energy rule of elevated targets holds") {
  const RenderTable t = small_table();
  const double depth = (1000 - 250.0) / 2000 / std::cos(45 * std::numbers::pi / 180);
  CHECK(path_radiance(t, 250, 45, 45)[0] == doctest::Approx(7.5 * -std::expm1(-depth)).epsilon(1e-6));
  CHECK(path_radiance(t, 250, 45, -45)[0] == path_radiance(t, 250, 45, 45)[0]);
  CHECK(path_radiance(t, 250, 45, 315)[0] == doctest::Approx(path_radiance(t, 250, 45, 45)[0]).epsilon(1e-14));
  CHECK(fold_azimuth(190) == 170);
  // Constant source function J: L_up(z) = J (1 - exp(-tau_z)), so L0(z to H) = J (1 - T).
  const double below = 1 - std::exp(-0.2), above = 1 - std::exp(-0.9);
  CHECK(path_radiance_between(above, std::exp(-0.7), below) == doctest::Approx(1 - std::exp(-0.7)).epsilon(1e-14));
  CHECK(path_radiance_between(1.0, 1.0, 1.0 + 1e-7) == 0);
  CHECK_THROWS_AS(path_radiance_between(1.0, 1.0, 1.1), base::Error);
}

TEST_CASE("S18 two-way transmission is the product times the factor") {
  const RenderTable t = small_table();
  const auto two = two_way_transmission(t, 100, 30);
  const auto sun = sun_transmission(t, 100), view = view_transmission(t, 100, 30);
  CHECK(two[1] == doctest::Approx(sun[1] * view[1] * double(1.02f)).epsilon(1e-12));
}

TEST_CASE("S18 with k-terms the sum over k comes before any product") {
  RenderTable t = small_table();
  add_axis(t, "k", {0, 1});
  Row& weight = add_row(t, "k_weight", "test");
  weight.values = {0.25f, 0.75f, 0.25f, 0.75f};
  const double sun_depth[2] = {0.1, 3.0}, view_depth[2] = {0.05, 2.0};
  for (const char* name : {"sun_transmission", "view_transmission"}) {
    Row& row = t.rows.at(name);
    const bool is_sun = row.name == "sun_transmission";
    row.axes.insert(row.axes.begin() + 1, "k");
    row.values.assign(row_size(t, row.axes), 0.0f);
    const std::size_t inner = row.values.size() / 4;
    const double* depth =
        is_sun ? sun_depth : view_depth;  // apart: g++ 12 takes another index in (a ? b : c)[i] under its sanitizers
    for (std::size_t i = 0; i < row.values.size(); ++i)
      row.values[i] = static_cast<float>(std::exp(-depth[i / inner % 2]));
  }
  t.rows.erase("two_way_factor");
  validate(t, "test");
  const double sun = 0.25 * std::exp(-0.1) + 0.75 * std::exp(-3.0),
               view = 0.25 * std::exp(-0.05) + 0.75 * std::exp(-2.0);
  const double both = 0.25 * std::exp(-0.15) + 0.75 * std::exp(-5.0);
  CHECK(sun_transmission(t, 0)[0] == doctest::Approx(sun).epsilon(1e-6));
  CHECK(view_transmission(t, 0, 0)[0] == doctest::Approx(view).epsilon(1e-6));
  CHECK(two_way_transmission(t, 0, 0)[0] == doctest::Approx(both).epsilon(1e-6));
  CHECK(two_way_factor(t, 0, 0)[0] == doctest::Approx(both / (sun * view)).epsilon(1e-6));
}

TEST_CASE("S18 deep bands interpolate without NaN, negative or lost light") {
  RenderTable t = small_table();
  for (float& value : t.rows.at("view_transmission").values) value = 1e-12f;
  t.rows.at("view_transmission").values[0] = 0.0f;  // underflowed
  t.rows.at("sun_transmission").values.assign(6, 1e-30f);
  for (double h : {0.0, 37.0, 250.0})
    for (double z : {0.0, 17.0, 60.0}) {
      for (double value : view_transmission(t, h, z)) CHECK((value >= 0 && value <= 1e-5));
      for (double value : path_radiance(t, h, z, 50)) CHECK((std::isfinite(value) && value >= 0));
    }
  CHECK(sun_transmission(t, 55)[0] == doctest::Approx(1e-30).epsilon(1e-5));
  CHECK(view_transmission(t, 250, 45)[1] > 0);
}

TEST_CASE("S18 a target at the sensor's height has T = 1 and no path radiance") {
  RenderTable t = small_table();
  auto& view = t.rows.at("view_transmission").values;
  auto& path = t.rows.at("path_radiance_solar").values;
  for (std::size_t l = 0; l < 2; ++l) {
    for (std::size_t j = 0; j < 3; ++j) view[(l * 3 + 2) * 3 + j] = 1;
    for (std::size_t j = 0; j < 9; ++j) path[(l * 3 + 2) * 9 + j] = 0;
  }
  CHECK(view_transmission(t, 400, 20)[0] == 1);
  CHECK(path_radiance(t, 400, 20, 0)[0] == 0);
  const auto near = path_radiance(t, 399.9, 0, 0), transmission = view_transmission(t, 399.9, 0);
  CHECK(near[0] == doctest::Approx(7 * (1 - transmission[0])).epsilon(1e-5));
}

TEST_CASE("S17 S18 the sky divided by its shape is exact where it is its shape") {
  RenderTable t = uniform_table({}, {0.5});
  t.sun_zenith_deg = 40;
  add_axis(t, "sky_zenith", {0, 40, 80, 90});
  add_axis(t, "sky_azimuth", {0, 60, 180});
  add_axis(t, "scattering_angle", {0, 90, 180});
  add_row(t, "sky_phase_mean", "test").values = {5, 1, 2};
  add_row(t, "sky_scattering_depth", "test").values = {0.4f};
  const double mu0 = std::cos(40 * std::numbers::pi / 180);
  const auto exact = [&](double zenith, double azimuth) {
    const double z = zenith * std::numbers::pi / 180, mu = std::cos(z);
    const double c = mu0 * mu + std::sqrt(1 - mu0 * mu0) * std::sin(z) * std::cos(azimuth * std::numbers::pi / 180);
    const double angle = std::acos(std::min(1.0, c)) * 180 / std::numbers::pi;
    const double phase = angle < 90 ? 5 - 4 * angle / 90 : 1 + (angle - 90) / 90;
    return 3 * sky_shape(phase, double(0.4f), mu0, mu);
  };
  Row& sky = add_row(t, "sky_radiance_solar", "test");
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      sky.values[i * 3 + j] = static_cast<float>(exact(t.axis("sky_zenith").nodes[i], t.axis("sky_azimuth").nodes[j]));
  for (double z : {0.0, 12.0, 40.0, 55.0, 86.0, 90.0})
    for (double a : {0.0, 7.0, 100.0, 180.0}) {
      CAPTURE(z);
      CAPTURE(a);
      CHECK(sky_radiance(t, 0, z, a)[0] == doctest::Approx(exact(z, a)).epsilon(1e-6));
    }
  // Closed form away from mu = mu0, and its limit there.
  CHECK(sky_shape(1, 0.4, 0.8, 0.5) == doctest::Approx(0.8 / 0.3 * (std::exp(-0.5) - std::exp(-0.8))).epsilon(1e-12));
  CHECK(sky_shape(1, 0.4, 0.8, 0.8) == doctest::Approx(0.5 * std::exp(-0.5)).epsilon(1e-12));
}

TEST_CASE("S18 a uniform sky lights a plane with pi times its radiance") {
  const RenderTable t = uniform_sky_table(1500, 30, wavelength_grid(0.4, 0.5, 0.01), 60, 10);
  CHECK(wavelengths(t).size() == 11);
  CHECK(sky_radiance(t, 123, 77, 31)[3] == 30);
  CHECK(diffuse_irradiance(t, 5)[0] == doctest::Approx(30 * std::numbers::pi).epsilon(1e-7));
  CHECK(direct_irradiance(t, 5)[0] == doctest::Approx(750).epsilon(1e-7));
  CHECK(view_transmission(t, 5, 70)[0] == 1);
  CHECK(path_radiance(t, 5, 70, 0)[0] == 0);
}

TEST_CASE("S18 outside the table is one clear error") {
  const RenderTable t = small_table();
  CHECK_THROWS_WITH_AS(view_transmission(t, 500, 0), doctest::Contains("target_height 500 m lies outside"),
                       base::Error);
  CHECK_THROWS_WITH_AS(view_transmission(t, 0, 61), doctest::Contains("view_zenith 61 deg lies outside"), base::Error);
  CHECK_THROWS_AS(view_transmission(t, 0, 90), base::Error);
  CHECK_THROWS_AS(view_transmission(t, std::nan(""), 0), base::Error);
  CHECK_THROWS_WITH_AS(sky_radiance(t, 0, 10, 0), doctest::Contains("sky_radiance_solar"), base::Error);
  CHECK_THROWS_AS(sky_radiance(t, 0, 91, 0), base::Error);
}

TEST_CASE("S11 S18 wavelength grids hold a 0.01 nm line") {
  const auto grid = wavelength_grid_with_line(0.5, 0.6, 0.001, 0.55, 5e-5, 1e-6);
  for (std::size_t i = 1; i < grid.size(); ++i) CHECK(grid[i] > grid[i - 1]);
  CHECK(grid.front() == 0.5);
  CHECK(grid.back() == doctest::Approx(0.6));
  CHECK(grid.size() == 101 + 100);
  CHECK(gaussian_line(0.55, 0.55, 1e-5, 2.0) == doctest::Approx(std::exp(-2.0)));
  CHECK(gaussian_line(0.550005, 0.55, 1e-5, 2.0) == doctest::Approx(std::exp(-1.0)));
  const auto half = resample_linear({0.5, 0.6}, {1, 3}, {0.5, 0.55, 0.6});
  CHECK(half[1] == doctest::Approx(2));
}
