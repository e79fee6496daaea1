// What imported tables of one direction, one height or an instrument's channels are good for.
#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "host/base/error.h"
#include "host/base/units.h"
#include "host/plan/channel_bands.h"
#include "host/plan/one_direction.h"

using namespace raycube;

namespace {

atmos::RenderTable imported(const std::vector<double>& zenith_deg, const std::vector<double>& target_m) {
  atmos::RenderTable table;
  table.provenance_json = R"({"model": "imported", "files": [{"format": "tape7"}],
                              "channels": [[0.500, 0.501, 0.010], [0.600, 0.600, 0.010]]})";
  table.axes["wavelength"] = {"wavelength", "um", {0.500, 0.600}};
  table.axes["view_zenith"] = {"view_zenith", "deg", zenith_deg};
  table.axes["target_height"] = {"target_height", "m", target_m};
  table.axes["relative_azimuth"] = {"relative_azimuth", "deg", {0, 90, 180}};
  return table;
}

plan::ViewBounds views(double from_deg, double to_deg, double height_m = 5000) {
  plan::ViewBounds view;
  view.sec_min = 1 / std::cos(base::rad_from_deg(from_deg)), view.sec_max = 1 / std::cos(base::rad_from_deg(to_deg));
  view.sensor_height_m = height_m;
  return view;
}

scene::Instrument camera(const std::vector<scene::Band>& bands) {
  scene::Instrument out;
  out.name = "camera";
  out.bands = bands;
  return out;
}

scene::Band band(double center_um, double fwhm_um) {
  scene::Band out;
  out.center_um = center_um, out.fwhm_um = fwhm_um;
  return out;
}

}  // namespace

TEST_CASE("a table of nadir serves views whose path has as much air: silent to 0.5 %, told to 5 %, then refused") {
  const auto table = imported({0}, {0, 1000});
  const auto said = [&](double to_deg) {
    return plan::one_direction_notices(table, "camera", views(0, to_deg), {0, 1000});
  };
  // sec - 1 is 0.5 % at 5.72 deg and 5 % at 17.75 deg.
  CHECK(said(5.6).empty());
  REQUIRE(said(5.8).size() == 1);
  CHECK(said(5.8)[0].find("views from 0 to 5.8 deg off nadir") != std::string::npos);
  CHECK(said(17.7).size() == 1);
  for (const double to_deg : {17.8, 40.0}) CHECK_THROWS_AS(said(to_deg), base::Error);
  CHECK(plan::one_direction_notices(imported({0, 60}, {0, 1000}), "camera", views(0, 40), {0, 1000}).empty());
}

TEST_CASE("a table of one target height serves heights whose air is a part of the whole column") {
  const auto table = imported({0, 60}, {0});
  const auto said = [&](double high_m) {
    return plan::one_direction_notices(table, "camera", views(0, 1), {0, high_m});
  };
  // 1 - exp(-h / 8 km) is 0.5 % at 40 m and 5 % at 410 m.
  CHECK(said(39).empty());
  CHECK(said(42).size() == 1);
  CHECK_THROWS_AS(said(420), base::Error);
}

TEST_CASE("a band that is a channel takes the channel's node; another is told, a narrower one refused") {
  const auto table = imported({0}, {0});
  const auto same = plan::channel_bands(camera({band(0.501, 0.010), band(0.600, 0.010)}), table);
  CHECK(same.channels == 2);
  CHECK(same.notices.empty());
  for (std::size_t b = 0; b < 2; ++b) {
    const auto& um = same.bands[b].wavelength_um;
    REQUIRE(um.size() >= 2);  // at the table's ends one side is cut
    CHECK(um.back() - um.front() <= 2.1e-9);
    CHECK(std::abs(um.back() - (b == 0 ? 0.500 : 0.600)) <= 1.1e-9);
  }
  const auto shifted = plan::channel_bands(camera({band(0.503, 0.010), band(0.600, 0.020)}), table);
  CHECK(shifted.channels == 0);
  REQUIRE(shifted.notices.size() == 1);
  CHECK(shifted.notices[0].find("2 of 2 bands") != std::string::npos);
  CHECK(shifted.bands[0].center_um == 0.503);
  CHECK_THROWS_AS(plan::channel_bands(camera({band(0.501, 0.004)}), table), base::Error);
}
