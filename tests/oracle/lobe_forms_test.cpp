// S21: shapes that stand in a frame or in a table: Ward's grain, Phong's power, measured factors. Oracles: the other
// form of Ward's paper, the frame turned by Rodrigues' formula, integrals in closed form, functions that tables hold
// exactly.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "kernels/materials/shapes.h"
#include "scene_compiler/compiled_scene.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/measured_file.h"
#include "tests/unit/scene_files.h"

using namespace raycube;

namespace {

constexpr double kPi = std::numbers::pi;
constexpr RcLocal kUp{0, 0, 1};

double dot(const RcLocal& a, const RcLocal& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
RcLocal cross(const RcLocal& a, const RcLocal& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

RcLocal direction(double zenith_rad, double azimuth_rad) {
  return {std::sin(zenith_rad) * std::cos(azimuth_rad), std::sin(zenith_rad) * std::sin(azimuth_rad),
          std::cos(zenith_rad)};
}

/// Turned by the shortest way that takes the vertical to the normal (Rodrigues' formula).
RcLocal turned(const RcLocal& v, const RcLocal& normal) {
  const RcLocal axis = cross(kUp, normal);
  const double sine = std::sqrt(dot(axis, axis)), cosine = normal.z;
  if (!(sine > 0)) return v;
  const RcLocal k{axis.x / sine, axis.y / sine, axis.z / sine}, across = cross(k, v);
  const double along = dot(k, v) * (1 - cosine);
  return {v.x * cosine + across.x * sine + k.x * along, v.y * cosine + across.y * sine + k.y * along,
          v.z * cosine + across.z * sine + k.z * along};
}

/// Over the hemisphere above: midpoint rule in cosine and azimuth.
template <class G>
double over_hemisphere(G&& g) {
  constexpr int kRows = 600, kColumns = 720;
  double sum = 0;
  for (int i = 0; i < kRows; ++i)
    for (int j = 0; j < kColumns; ++j)
      sum += g(direction(std::acos((i + 0.5) / kRows), 2 * kPi * (j + 0.5) / kColumns));
  return sum * 2 * kPi / kRows / kColumns;
}

}  // namespace

TEST_CASE(
    "S21 ward: the other form of its paper, by half vectors that are no unit vectors, with the grain by azimuth") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int n = 0; n < 500; ++n) {
    const RcLocal in = direction(1.4 * unit(random), 6 * unit(random)),
                  out = direction(1.4 * unit(random), 6 * unit(random));
    const double ax = 0.1 + 0.5 * unit(random), ay = 0.1 + 0.5 * unit(random), azimuth_deg = 360 * unit(random);
    const RcLocal h{in.x + out.x, in.y + out.y, in.z + out.z};
    // Azimuths count clockwise from north, y.
    const double east = std::sin(azimuth_deg * kPi / 180), north = std::cos(azimuth_deg * kPi / 180);
    const double along = h.x * east + h.y * north, across = h.x * north - h.y * east;
    const double exponent = (std::pow(along / ax, 2) + std::pow(across / ay, 2)) / (h.z * h.z);
    const double expected = 0.7 / (kPi * ax * ay) * std::exp(-exponent) * dot(h, h) / std::pow(h.z, 4);
    const RcParameters p{{ax, 0.7, ay, azimuth_deg}, nullptr};
    CHECK(rc_shape_eval(RC_SHAPE_ward, 1, p, rc_angles(kUp, in, out)) == doctest::Approx(expected).epsilon(1e-10));
  }
}

TEST_CASE("S21 ward: on a tilted surface the grain is turned with it by the shortest way") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  const RcParameters p{{0.15, 1, 0.5, 70}, nullptr};
  for (int n = 0; n < 500; ++n) {
    const RcLocal normal = direction(2.8 * unit(random), 6 * unit(random));  // some of them face down
    const RcLocal in = direction(1.4 * unit(random), 6 * unit(random)),
                  out = direction(1.4 * unit(random), 6 * unit(random));
    const double flat = rc_shape_eval(RC_SHAPE_ward, 1, p, rc_angles(kUp, in, out));
    const double tilted =
        rc_shape_eval(RC_SHAPE_ward, 1, p, rc_angles(normal, turned(in, normal), turned(out, normal)));
    CHECK(tilted == doctest::Approx(flat).epsilon(1e-7).scale(1e-9));
  }
}

TEST_CASE("S21 ward: on surfaces that face almost straight down the frame is one") {
  const RcParameters p{{0.2, 1, 0.2, 40}, nullptr};  // alike along and across: the frame may not matter
  const RcLocal in = direction(0.3, 1.0), out = direction(0.4, 4.0);
  const double flat = rc_shape_eval(RC_SHAPE_ward, 1, p, rc_angles(kUp, in, out));
  for (const double from_down : {0.0, 1e-9, 1e-4, 5e-4, 1e-3, 3e-3}) {
    const RcLocal normal = direction(kPi - from_down, 2.0);
    CAPTURE(from_down);
    CHECK(rc_shape_eval(RC_SHAPE_ward, 1, p, rc_angles(normal, turned(in, normal), turned(out, normal))) ==
          doctest::Approx(flat).epsilon(1e-6));
  }
}

TEST_CASE("S21 ward: light along and across the grain, and the furnace at every roughness") {
  // Grain to the north, smoother along it: light from the zenith is spread to the east and west.
  const RcParameters grain{{0.1, 1, 0.4, 0}, nullptr};
  const auto sent = [&](double azimuth_rad) {
    return rc_shape_eval(RC_SHAPE_ward, 1, grain, rc_angles(kUp, kUp, direction(0.5, azimuth_rad)));
  };
  CHECK(sent(0) > 50 * sent(kPi / 2));  // x is east
  for (const double along : {0.1, 0.3, 1.0})
    for (const double across : {0.1, 0.5, 1.0})
      for (const double zenith : {0.0, 0.7, 1.2, 1.5}) {
        const RcParameters p{{along, 1, across, 20}, nullptr};
        const RcLocal in = direction(zenith, 0.4);
        const double albedo = over_hemisphere(
            [&](const RcLocal& out) { return rc_shape_eval(RC_SHAPE_ward, 1, p, rc_angles(kUp, in, out)) * out.z; });
        CAPTURE(along);
        CAPTURE(across);
        CAPTURE(zenith);
        CHECK(albedo < 1 + 2e-3);  // of the rule, for a lobe 0.1 wide
        // Light that narrow facets mirror from near the normal does not go down.
        if (zenith < 0.8 && along <= 0.1 && across <= 0.1) CHECK(albedo > 0.96);
      }
}

TEST_CASE("S21 phong: its form, all that it mirrors at normal incidence, and less from elsewhere") {
  // Light at 40 degrees, viewer 10 degrees off the mirrored way in the plane: cos^n 10 degrees.
  const auto pi_f = [](double n, double from_deg, double to_deg) {
    return rc_shape_eval(RC_SHAPE_phong, kPi, {{n, 0.6}, nullptr},
                         rc_angles(kUp, direction(from_deg * kPi / 180, 0), direction(to_deg * kPi / 180, kPi)));
  };
  CHECK(pi_f(20, 40, 50) == doctest::Approx(0.6 * 22 / 2 * std::pow(std::cos(kPi / 18), 20)).epsilon(1e-9));
  CHECK(pi_f(1, 40, 40) == doctest::Approx(0.6 * 3 / 2).epsilon(1e-9));
  for (const double n : {1.0, 5.0, 20.0, 49.0}) {
    const auto albedo = [&](double zenith) {
      const RcLocal in = direction(zenith, 0.3);
      return over_hemisphere([&](const RcLocal& out) {
        return rc_shape_eval(RC_SHAPE_phong, 1, {{n, 1}, nullptr}, rc_angles(kUp, in, out)) * out.z;
      });
    };
    CHECK(albedo(0) == doctest::Approx(1).epsilon(1e-3));  // (n + 2) / (2 pi) 2 pi / (n + 2)
    CHECK(albedo(1.0) < 1);
    CHECK(albedo(1.4) < albedo(1.0));
  }
}

namespace {

/// A file of factors, read; said: the problems.
std::optional<scene::MeasuredTables> read_factors(const std::string& text, std::string* said = nullptr) {
  const scene::testing::Folder folder;
  folder.write("factors.csv", text);
  base::Problems problems;
  auto out = scene::read_measured(folder.at("factors.csv"), {"scene.toml", 7, 0, "file"}, problems);
  for (const auto& line : problems.lines())
    if (said) *said += line + "\n";
  CHECK(out.has_value() == problems.lines().empty());
  return out;
}

/// Factors of a function of three angles, degrees, at all azimuths to the right.
template <class F>
std::string grid_of(F&& factor) {
  std::string text = "# source: made up\nlight_zenith_deg,view_zenith_deg,relative_azimuth_deg,factor\n";
  for (const double in : {0.0, 15.0, 40.0, 70.0})
    for (const double out : {0.0, 10.0, 30.0, 35.0, 75.0})
      for (const double turn : {0.0, 20.0, 90.0, 180.0}) {
        if ((in == 0 || out == 0) && turn > 0) continue;
        text += std::to_string(in) + "," + std::to_string(out) + "," + std::to_string(turn) + "," +
                std::to_string(factor(in, out, turn)) + "\n";
      }
  return text;
}

double pi_f(const scene::Shape& shape, double in_deg, double out_deg, double turn_deg) {
  return rc_shape_eval(
      shape.number, kPi, shape.parameters(),
      rc_angles(kUp, direction(in_deg * kPi / 180, 0.3), direction(out_deg * kPi / 180, 0.3 + turn_deg * kPi / 180)));
}

}  // namespace

TEST_CASE("S21 measured: linear in its three angles between what was measured, and as at the ends beyond them") {
  // Terms of the azimuth vanish where one of the ways is upright.
  const auto factor = [](double in, double out, double turn) {
    return 0.5 + 0.004 * in + 0.002 * out + 1e-6 * in * out * turn;
  };
  const auto tables = read_factors(grid_of(factor));
  REQUIRE(tables.has_value());
  REQUIRE(tables->table.size() == 1);
  CHECK(tables->wavelength_um.empty());
  CHECK(scene::is_measured_table(*tables->table[0]));
  const scene::Shape shape{RC_SHAPE_measured, {}, tables->table[0]};
  // Its values are kept as floats, 6e-8 of them.
  for (const double in : {0.0, 3.0, 15.0, 28.0, 70.0})
    for (const double out : {0.0, 7.0, 33.0, 60.0, 75.0})
      for (const double turn : {0.0, 11.0, 90.0, 140.0, 180.0})
        CHECK(pi_f(shape, in, out, turn) == doctest::Approx(factor(in, out, turn)).epsilon(1e-6));
  CHECK(pi_f(shape, 20, 30, -50) == doctest::Approx(factor(20, 30, 50)).epsilon(1e-6));
  CHECK(pi_f(shape, 85, 80, 30) == doctest::Approx(factor(70, 75, 30)).epsilon(1e-6));
}

TEST_CASE("S21 measured: left and right are averaged, wavelengths are columns, upright ways need no azimuth") {
  const auto tables = read_factors(
      "light_zenith_deg,view_zenith_deg,relative_azimuth_deg,1.6um,550nm\n"
      "30,0,77,0.2,0.4\n30,40,0,0.3,0.5\n30,40,90,0.1,0.2\n30,40,-90,0.3,0.4\n30,40,180,0.6,0.7\n");
  REQUIRE(tables.has_value());
  CHECK(tables->wavelength_um == std::vector<double>{0.55, 1.6});
  const scene::Shape green{RC_SHAPE_measured, {}, tables->table[0]}, infrared{RC_SHAPE_measured, {}, tables->table[1]};
  CHECK(pi_f(green, 30, 40, 90) == doctest::Approx(0.3).epsilon(1e-6));
  CHECK(pi_f(infrared, 30, 40, 270) == doctest::Approx(0.2).epsilon(1e-6));
  CHECK(pi_f(green, 10, 0, 0) == doctest::Approx(0.4).epsilon(1e-6));
  CHECK(pi_f(infrared, 30, 20, 180) == doctest::Approx(0.4).epsilon(1e-6));
}

TEST_CASE("S21 measured: of many wavelengths those are kept between which the others lie on lines") {
  // Linear between 400, 520, 700, 730 and 1200 nm, differently at each place; then what no eight wavelengths hold.
  const std::vector<int> ends_nm = {400, 520, 700, 730, 1200};
  const auto line = [&](int nm, int place) {
    std::size_t i = 1;
    while (ends_nm[i] < nm) ++i;
    const double f = double(nm - ends_nm[i - 1]) / (ends_nm[i] - ends_nm[i - 1]);
    const auto at = [&](std::size_t end) { return 0.3 + 0.2 * std::sin(3.0 * double(end) + place); };
    return (1 - f) * at(i - 1) + f * at(i);
  };
  const auto text = [](auto&& factor) {
    std::string out = "light_zenith_deg,view_zenith_deg,relative_azimuth_deg";
    for (int nm = 400; nm <= 1200; nm += 10) out += "," + std::to_string(nm) + "nm";
    for (int place = 0; place < 6; ++place) {
      out += "\n30," + std::to_string(20 + 10 * (place % 3)) + "," + std::to_string(90 * (place / 3));
      for (int nm = 400; nm <= 1200; nm += 10) out += "," + std::to_string(factor(nm, place));
    }
    return out + "\n";
  };
  const auto tables = read_factors(text(line));
  REQUIRE(tables.has_value());
  REQUIRE(tables->wavelength_um.size() == ends_nm.size());
  for (std::size_t i = 0; i < ends_nm.size(); ++i) {
    CHECK(tables->wavelength_um[i] == doctest::Approx(1e-3 * ends_nm[i]));
    const scene::Shape shape{RC_SHAPE_measured, {}, tables->table[i]};
    CHECK(pi_f(shape, 30, 30, 90) == doctest::Approx(line(ends_nm[i], 4)).epsilon(1e-5));  // text has six digits
  }
  std::string said;
  CHECK_FALSE(read_factors(text([](int nm, int place) { return nm / 10 % 2 == place % 2 ? 0.2 : 0.4; }), &said));
  CHECK(said.find("81 wavelengths") != std::string::npos);
}

TEST_CASE("S21 measured: what a file lacks or has twice is told with its line") {
  const std::string header = "light_zenith_deg,view_zenith_deg,relative_azimuth_deg,factor\n";
  const auto says = [](const std::string& text, const std::vector<std::string>& parts) {
    std::string said;
    CHECK_FALSE(read_factors(text, &said).has_value());
    for (const std::string& part : parts) {
      CAPTURE(said);
      CHECK(said.find(part) != std::string::npos);
    }
  };
  says(header + "30,40,0,1\n30,40,180,1\n60,40,0,1\n",
       {"1 combination of its angles has", "light 60, viewer 40, azimuth 180"});
  says(header + "30,40,0,1\n30,40,0,1\n", {"factors.csv:3", "stand twice"});
  CHECK(read_factors(header + "30,40,0,1\n30,40,180,1\n30,40,360,1\n").has_value());  // a whole circle
  says(header + "95,40,0,1\n", {"factors.csv:2", "light_zenith_deg outside", "95"});
  says(header + "30,40,0,-1\n", {"factors.csv:2", "factor outside", "-1"});
  says(header + "30,40,0,nan\n", {"factors.csv:2"});
  says("light_zenith_deg,view_zenith_deg,relative_azimuth_deg,550nm,R650nm\n1,1,1,1,1\n",
       {"'r650nm' names no wavelength"});
  says("light_zenith_deg,view_zenith_deg,relative_azimuth_deg,view_zenith_deg,factor\n1,1,1,1,1\n",
       {"two columns have one name", "view_zenith_deg"});
  says("light_zenith_deg,relative_azimuth_deg,factor\n1,1,1\n", {"no column 'view_zenith_deg'"});
  says("light_zenith_deg,view_zenith_deg,relative_azimuth_deg,brf\n1,1,1,1\n", {"no column of factors"});
  says("light_zenith_deg,view_zenith_deg,relative_azimuth_deg,factor,550nm\n1,1,1,1,1\n", {"'factor' and factors"});
  says("light_zenith_deg,view_zenith_deg,relative_azimuth_deg,550nm,0.55um\n1,1,1,1,1\n", {"stands in two columns"});
}

TEST_CASE("S21 measured: records of surfaces point to their tables, each once, behind all records") {
  scene::CompiledScene scene;
  const auto table = std::make_shared<const std::vector<float>>(std::vector<float>{1, 1, 1, 0, 0, 0, 0.25f});
  const auto other = std::make_shared<const std::vector<float>>(std::vector<float>{1, 1, 1, 0, 0, 0, 0.75f});
  const auto again = std::make_shared<const std::vector<float>>(*table);  // as of another file
  for (int i = 0; i < 3; ++i) {
    scene::Material& material = scene.materials.emplace_back();
    material.reflectance = {{0.3, 3}, {0.5, 0.5}};
    material.front = {RC_SHAPE_measured, {}, i == 0 ? table : i == 1 ? other : again};
    shared::Surface& surface = scene.surfaces.emplace_back();
    surface.material[0] = static_cast<std::uint32_t>(i + 1), surface.fraction[0] = 1;
  }
  const auto lobes = scene::surface_lobes(scene);
  const auto* numbers = reinterpret_cast<const float*>(lobes.data());
  const auto value = [&](int i) {
    const float* place = lobes[static_cast<std::size_t>(i) * RC_LOBES].parameter;
    return numbers[(static_cast<std::size_t>(place[0]) << 20) + static_cast<std::size_t>(place[1]) + 6];
  };
  CHECK(value(0) == 0.25f);
  CHECK(value(1) == 0.75f);
  CHECK(value(2) == 0.25f);
  CHECK(lobes[0].parameter[1] == lobes[2 * RC_LOBES].parameter[1]);
  CHECK(lobes.size() == 3 * RC_LOBES + 2);  // 14 floats
}
