// Objects that a pixel's samples would miss (S43). Oracles: plates over a plain whose share of every pixel is
// the exact area of a polygon cut by the pixel's square (the plate's corners carried into the pixel by
// Newton's method on pixel_ray, in double), of a point spread the integral of its response; the linear mix of
// two reflectances under a uniform sky; equality to the bit where no plate is, and whatever the tiles.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "atmos_tables/synthetic.h"
#include "host/render/truth.h"
#include "host/sensors/ray_groups.h"
#include "host/sensors/small_objects.h"
#include "tests/support/chance_checks.h"
#include "tests/support/render_kit.h"
#include "tests/support/same_bytes.h"

namespace {

using namespace raycube;
using raycube::test::same_bytes;

constexpr double kGround = 0.2, kPlate = 0.9, kSky = 40, kHeight_m = 0.001;
constexpr int kFirstAbundance = raycube::render::truth::abundance;  ///< layer of the first material
enum class Carrier { own_meshes, one_mesh, placements };

struct Plate {
  double x_m, y_m, side_m;
};

/// 32 plates at random places, one a cell of 8 x 4 cells of 6 m about the origin.
std::vector<Plate> field_of_plates(double side_m) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(0.6, 5.4);
  std::vector<Plate> plates;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 8; ++column)
      plates.push_back({6.0 * column - 24 + place(random), 6.0 * row - 12 + place(random), side_m});
  return plates;
}

/// Plates a millimetre over a plain under a uniform sky alone.
scene::Simulation plain(const std::vector<Plate>& plates, Carrier carrier = Carrier::own_meshes) {
  scene::Simulation simulation;
  scene::CompiledScene& scene = simulation.scene;
  const auto ground = test::add_material(scene, "ground", kGround),
             target = test::add_material(scene, "target", kPlate);
  const auto plate = [&](double x, double y, double side) {
    return test::rectangle({x - side / 2, y - side / 2, kHeight_m}, {side, 0, 0}, {0, side, 0}, target);
  };
  std::vector<scene::TriangleMesh> all = {test::rectangle({-2000, -2000, 0}, {4000, 0, 0}, {0, 4000, 0}, ground)};
  for (const Plate& p : plates) all.push_back(plate(p.x_m, p.y_m, p.side_m));
  if (carrier == Carrier::one_mesh) {
    test::place(scene, test::join(all));
  } else if (carrier == Carrier::own_meshes) {
    for (const auto& mesh : all) test::place(scene, mesh);
  } else {
    test::place(scene, all[0]);
    const std::uint32_t mesh = append_mesh(scene, "plate", plate(0, 0, plates.at(0).side_m));
    for (std::uint32_t i = 0; i < plates.size(); ++i)
      append_instance(scene, mesh, {1, 0, 0, plates[i].x_m, 0, 1, 0, plates[i].y_m, 0, 0, 1, 0}, i);
  }
  finish_top_tree(scene);
  simulation.sun.zenith_deg = 120;
  simulation.sky_directions = 1;
  return simulation;
}

/// 34 x 18 pixels of 1.5 m, 3 x 3 samples, small objects on.
scene::Instrument camera() {
  scene::Instrument out = test::nadir_camera(34, 18, 1500, 1.5, 0.4, -0.3);
  out.samples_u = out.samples_v = 3;
  out.small_objects = scene::SmallObjects::on;
  return out;
}

test::Image shoot(const scene::Simulation& simulation, const scene::Instrument& instrument,
                  const render::RenderOptions& options = {}) {
  scene::Simulation with = simulation;
  with.instruments = {instrument};
  return test::render_image(with, atmos::uniform_sky_table(0, kSky, {0.3, 1.0, 4.0}, 120), options);
}

using Point = std::array<double, 2>;

/// Place (u, v) in a pixel, pixels from its centre, of a point of the scene: Newton's method on the rays.
Point place_in_pixel(const scene::Instrument& instrument, int line, int sample, double x, double y, double z) {
  const auto ground = [&](double u, double v) {
    const auto ray = sensors::pixel_ray(instrument, line, sample, u, v);
    const double t = (z - ray.origin_m.z) / ray.direction.z;
    return Point{ray.origin_m.x + t * ray.direction.x - x, ray.origin_m.y + t * ray.direction.y - y};
  };
  double u = 0, v = 0;
  for (int round = 0; round < 20; ++round) {
    constexpr double step = 1e-4;
    const Point here = ground(u, v), along = ground(u + step, v), across = ground(u, v + step);
    const double a = (along[0] - here[0]) / step, b = (across[0] - here[0]) / step, c = (along[1] - here[1]) / step,
                 d = (across[1] - here[1]) / step;
    const double det = a * d - b * c;
    const double du = (d * here[0] - b * here[1]) / det, dv = (a * here[1] - c * here[0]) / det;
    u -= du, v -= dv;
    if (std::abs(du) + std::abs(dv) < 1e-9) break;  // the next step is its square
  }
  return {u, v};
}

/// Area of a convex polygon inside the square of half a pixel about the origin (Sutherland and Hodgman).
double area_in_pixel(std::vector<Point> polygon) {
  for (int side = 0; side < 4; ++side) {
    const std::size_t axis = static_cast<std::size_t>(side % 2);
    const double sign = side < 2 ? 1 : -1;
    const auto inside = [&](const Point& p) { return 0.5 - sign * p[axis]; };
    std::vector<Point> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Point &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      const double dp = inside(p), dq = inside(q);
      if (dp >= 0) kept.push_back(p);
      if ((dp >= 0) != (dq >= 0))
        kept.push_back({p[0] + (q[0] - p[0]) * dp / (dp - dq), p[1] + (q[1] - p[1]) * dp / (dp - dq)});
    }
    polygon = kept;
  }
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    twice += p[0] * q[1] - p[1] * q[0];
  }
  return 0.5 * std::abs(twice);
}

/// Integral of the response, box of one pixel convolved with a Gaussian, over an upright rectangle.
double response_on(double lo, double hi, double sigma) {
  const auto ramp = [&](double t) {
    return 0.5 * t * (1 + std::erf(t / sigma / std::sqrt(2.0))) +
           sigma * std::exp(-0.5 * t * t / sigma / sigma) / std::sqrt(2 * M_PI);
  };
  const auto below = [&](double x) { return ramp(x + 0.5) - ramp(x - 0.5); };
  return below(hi) - below(lo);
}

/// Share of each pixel that plates cover.
std::vector<double> exact_shares(const scene::Instrument& instrument, const std::vector<Plate>& plates) {
  std::vector<double> shares(static_cast<std::size_t>(instrument.lines * instrument.pixels), 0.0);
  for (int line = 0; line < instrument.lines; ++line)
    for (int sample = 0; sample < instrument.pixels; ++sample)
      for (const Plate& p : plates) {
        const Point middle = place_in_pixel(instrument, line, sample, p.x_m, p.y_m, kHeight_m);
        const double reach = 1 + instrument.psf_support_px;
        if (std::abs(middle[0]) > reach || std::abs(middle[1]) > reach) continue;
        std::vector<Point> corners;
        for (const auto& [i, j] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
          corners.push_back(
              place_in_pixel(instrument, line, sample, p.x_m + i * p.side_m / 2, p.y_m + j * p.side_m / 2, kHeight_m));
        double& share = shares[static_cast<std::size_t>(line * instrument.pixels + sample)];
        if (instrument.psf_sigma_px == 0) {
          share += area_in_pixel(corners);
          continue;
        }
        const auto [u0, u1] = std::minmax({corners[0][0], corners[2][0]});
        const auto [v0, v1] = std::minmax({corners[0][1], corners[2][1]});
        share += response_on(u0, u1, instrument.psf_sigma_px) * response_on(v0, v1, instrument.psf_sigma_px);
      }
  return shares;
}

struct Judged {
  int holding = 0, missed = 0;  ///< pixels with a tenth of a plate's share and more; of them, abundance 0
  double worst = 0, rms = 0;    ///< error of their abundance over the plate's share of a pixel
  double mix = 0;               ///< largest |L / sky - (mix of the truth's abundances)|
  double found = 0;             ///< sum of abundances over that of shares
};

Judged judge(const test::Image& image, const std::vector<double>& shares, double whole) {
  Judged out;
  double sum = 0, exact = 0;
  for (int line = 0; line < image.lines; ++line)
    for (int sample = 0; sample < image.pixels; ++sample) {
      const double share = shares[static_cast<std::size_t>(line * image.pixels + sample)];
      const double got = image.layer(line, sample, kFirstAbundance + 1),
                   ground = image.layer(line, sample, kFirstAbundance);
      out.mix = std::max(out.mix, std::abs(image.at(line, sample, 0) / kSky - (got * kPlate + ground * kGround)));
      sum += got, exact += share;
      if (share < 0.1 * whole) continue;
      ++out.holding, out.missed += got == 0;
      const double error = std::abs(got - share) / whole;
      out.worst = std::max(out.worst, error), out.rms += error * error;
    }
  out.rms = std::sqrt(out.rms / std::max(1, out.holding)), out.found = sum / exact;
  return out;
}

/// Largest share of a plate of that side in a pixel about the image's middle.
double whole_share(const scene::Instrument& instrument, double side_m) {
  scene::Instrument box = instrument;
  box.psf_sigma_px = 0, box.psf_support_px = 1;
  std::vector<Point> corners;
  for (const auto& [i, j] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
    corners.push_back(place_in_pixel(box, box.lines / 2, box.pixels / 2, i * side_m / 2, j * side_m / 2, kHeight_m));
  double twice = 0;
  for (std::size_t i = 0; i < 4; ++i)
    twice += corners[i][0] * corners[(i + 1) % 4][1] - corners[i][1] * corners[(i + 1) % 4][0];
  return 0.5 * std::abs(twice);
}

/// All found, each pixel's abundance right to 20 % of the plate's share (the bar), 10 % rms (what the count
/// of points is chosen for: 6 %, and luck), and the radiance the mix of the truth's own abundances: the same
/// samples made both. Under the plates' rim the sky is hidden a little.
void check_found(const scene::Instrument& instrument, const std::vector<Plate>& plates,
                 const scene::Simulation& simulation) {
  const Judged now = judge(shoot(simulation, instrument), exact_shares(instrument, plates),
                           whole_share(instrument, plates.at(0).side_m));
  CAPTURE(now.holding);
  CAPTURE(now.worst);
  CAPTURE(now.rms);
  CHECK(now.holding >= 32);
  CHECK(now.missed == 0);
  CHECK(now.worst < 0.2);
  CHECK_BELOW(now.rms, 0.1);
  CHECK(now.mix < 2e-3);
  CHECK(std::abs(now.found - 1) < 0.03);
  MESSAGE("holding " << now.holding << ", worst " << now.worst << ", rms " << now.rms << ", sum " << now.found);
}

}  // namespace

TEST_CASE(
    "S43 small objects: 32 plates of 4 % of a pixel and 32 of a tenth are all found, their abundance right "
    "to 20 %") {
  for (const double side_m : {0.3, 1.5 * std::sqrt(0.1)}) {
    const auto plates = field_of_plates(side_m);
    const auto simulation = plain(plates);
    check_found(camera(), plates, simulation);
    scene::Instrument ordinary = camera();
    ordinary.small_objects = scene::SmallObjects::off;
    const Judged before =
        judge(shoot(simulation, ordinary), exact_shares(ordinary, plates), whole_share(ordinary, side_m));
    MESSAGE("without: missed " << before.missed << " of " << before.holding << ", worst " << before.worst);
    CHECK(before.missed > before.holding / 4);  // what the samples alone make of them
    CHECK(before.worst > 0.5);
  }
}

TEST_CASE(
    "S43 small objects: plates that are parts of the plain's own mesh, or placements of one mesh, get the "
    "same samples") {
  const auto plates = field_of_plates(0.3);
  const auto own = shoot(plain(plates), camera());
  const auto parts = shoot(plain(plates, Carrier::one_mesh), camera()),
             placed = shoot(plain(plates, Carrier::placements), camera());
  REQUIRE(own.statistics.small_object_pixels.size() == 1);
  CHECK(own.statistics.small_object_pixels.begin()->first == 1024);
  CHECK(parts.statistics.small_object_pixels == own.statistics.small_object_pixels);
  CHECK(placed.statistics.small_object_pixels == own.statistics.small_object_pixels);
  const auto shares = exact_shares(camera(), plates);
  CHECK_BELOW(judge(parts, shares, 0.04).worst, 0.2);
  CHECK_BELOW(judge(placed, shares, 0.04).worst, 0.2);
}

TEST_CASE("S43 small objects: tilted frames, push-brooms standing and moving, whisk-brooms, a point spread") {
  const auto plates = field_of_plates(0.3);
  const auto simulation = plain(plates);
  SUBCASE("frame, pitched, rolled and turned") {
    scene::Instrument tilted = camera();
    tilted.pixels = 52, tilted.lines = 40;
    tilted.poses = {{0, 0, 1500, 8, 15, 20}};
    const auto axis = sensors::pixel_ray(tilted, tilted.lines / 2, tilted.pixels / 2, -0.5, -0.5).direction;
    tilted.poses[0].x_m = 1500 * axis.x / axis.z,
    tilted.poses[0].y_m = 1500 * axis.y / axis.z;  // it looks at the origin
    check_found(tilted, plates, simulation);
  }
  for (const auto motion : {scene::PoseMotion::held, scene::PoseMotion::moving}) {
    CAPTURE(static_cast<int>(motion));
    scene::Instrument broom = camera();
    broom.kind = scene::InstrumentKind::pushbroom, broom.motion = motion;
    broom.poses.clear();
    for (int line = 0; line < broom.lines; ++line)
      broom.poses.push_back({0.4, 1.5 * (line + 0.5) - 13.5, 1500, 0, 0, 0});
    SUBCASE("push-broom") { check_found(broom, plates, simulation); }
    SUBCASE("push-broom, looking ahead and heading east of north") {
      broom.lines = 60, broom.pixels = 44;
      broom.poses.clear();
      const double ahead_m = 1500 * std::tan(20 * M_PI / 180), heading = 30 * M_PI / 180;
      for (int line = 0; line < broom.lines; ++line) {
        const double way = 1.5 * (line + 0.5) - 45 - ahead_m;
        broom.poses.push_back({way * std::sin(heading), way * std::cos(heading), 1500, 0, 20, 30});
      }
      check_found(broom, plates, simulation);
    }
  }
  SUBCASE("whisk-broom") {
    scene::Instrument whisk = camera();
    whisk.kind = scene::InstrumentKind::whiskbroom;
    whisk.poses.clear();
    for (int line = 0; line < whisk.lines; ++line)
      for (int sample = 0; sample < whisk.pixels; ++sample)
        whisk.poses.push_back({0.4, 1.5 * (line + sample / double(whisk.pixels)) - 13.5, 1500, 0, 0, 0});
    check_found(whisk, plates, simulation);
  }
  SUBCASE("point spread") {
    scene::Instrument blurred = camera();
    blurred.psf_sigma_px = 0.4, blurred.psf_support_px = 3.4;
    const auto image = shoot(simulation, blurred);
    REQUIRE(image.statistics.small_object_pixels.size() == 1);
    CHECK(image.statistics.small_object_pixels.begin()->first == 16384);  // 960 in a pixel's area, on 11.6 of them
    const Judged now = judge(image, exact_shares(blurred, plates), 0.04 * 0.6);  // a blurred plate's largest share
    MESSAGE("holding " << now.holding << ", worst " << now.worst << ", rms " << now.rms);
    CHECK(now.missed == 0);
    CHECK(now.worst < 0.2);
  }
}

TEST_CASE("S43 S60 small objects: pixels without any keep their bits, and tiles, threads and memory change none") {
  const auto plates = field_of_plates(0.3);
  const auto simulation = plain(plates);
  scene::Instrument instrument = camera();
  instrument.standard_error = scene::StandardError::worst;
  const auto image = shoot(simulation, instrument);
  scene::Instrument off = instrument;
  off.small_objects = scene::SmallObjects::off;
  const auto ordinary = shoot(simulation, off);
  const auto survey = sensors::survey_small_objects(simulation.scene, instrument, true);
  std::vector<char> anew(static_cast<std::size_t>(image.lines * image.pixels), 0);
  for (const auto& group : survey.groups)
    for (int sample = group.sample; sample < std::min(group.sample + 4, image.pixels); ++sample)
      anew[static_cast<std::size_t>(group.line * image.pixels + sample)] = 1;
  std::uint64_t pixels = 0;
  const auto shares = exact_shares(instrument, plates);
  for (std::size_t p = 0; p < anew.size(); ++p) {
    pixels += anew[p] != 0;
    if (shares[p] > 0) CHECK(anew[p]);  // no pixel with a plate is left out
    if (!anew[p]) CHECK(std::memcmp(&image.radiance[p * 3], &ordinary.radiance[p * 3], 3 * sizeof(float)) == 0);
  }
  CHECK(survey.pixels == pixels);
  CHECK(image.statistics.small_object_pixels.at(1024) == pixels);
  CHECK(survey.objects == 32);
  CHECK(survey.missed.empty());
  for (const int lines : {1, 5}) {
    render::RenderOptions options;
    options.tile_lines = lines, options.threads = lines == 1 ? 1 : 2, options.row_capacity = lines == 1 ? 1 : 16;
    const auto other = shoot(simulation, instrument, options);
    CHECK(same_bytes(image.radiance, other.radiance));
    CHECK(same_bytes(image.truth, other.truth));
  }
  render::RenderOptions small;
  // Less is refused: one group of pixels for every count of samples takes 3.6 MB.
  small.memory_bytes = 4 << 20;
  CHECK(same_bytes(image.radiance, shoot(simulation, instrument, small).radiance));
}

TEST_CASE("S43 small objects: a scene without any keeps bits and rays") {
  const auto simulation = plain({{0, 0, 20}});  // an edge is no small object
  scene::Instrument off = camera();
  off.small_objects = scene::SmallObjects::off;
  const auto with = shoot(simulation, camera()), without = shoot(simulation, off);
  CHECK(with.statistics.small_object_pixels.empty());
  CHECK(with.statistics.primary_rays == without.statistics.primary_rays);
  CHECK(same_bytes(with.radiance, without.radiance));
}

TEST_CASE(
    "S43 small objects: thousands of one kind are a texture, and what covers a pixel densely asks for no "
    "more than its cover") {
  std::vector<Plate> gravel;
  for (int i = 0; i < 5000; ++i) gravel.push_back({0.4 * (i % 100) - 20, 0.4 * (i / 100) - 10, 0.1});
  const auto many = sensors::survey_small_objects(plain(gravel).scene, camera(), true);
  CHECK(many.pixels == 0);
  REQUIRE(many.textures.size() == 1);
  CHECK(many.textures[0] == "target");
  // 400 plates of 0.5 m, 2 m^2 in 2.25: what is left of a pixel is known by the ordinary 121 samples.
  std::vector<Plate> dense;
  for (int i = 0; i < 400; ++i) dense.push_back({0.53 * (i % 20) - 5.3, 0.53 * (i / 20) - 5.3, 0.5});
  scene::Instrument ordinary = camera();
  ordinary.samples_u = ordinary.samples_v = 11;
  const auto cover = sensors::survey_small_objects(plain(dense).scene, ordinary, true);
  CHECK(cover.objects == 400);
  CHECK(cover.pixels <= 4 * 40);  // at the lot's rim, in groups, at most
  CHECK(cover.missed.empty());
}

TEST_CASE("S43 small objects: what even the finest samples miss, or the file's own, is named with size and place") {
  auto plates = field_of_plates(0.3);
  plates.push_back({1.0, 1.0, 0.02});  // 1.8e-4 of a pixel: 2.9 of 16384 samples
  const auto simulation = plain(plates);
  const auto on = sensors::survey_small_objects(simulation.scene, camera(), true);
  REQUIRE(on.missed.size() == 1);
  CHECK(on.missed[0].size_m[0] == doctest::Approx(0.02).epsilon(1e-4));
  CHECK(on.missed[0].share == doctest::Approx(0.02 * 0.02 / 2.25).epsilon(1e-3));
  CHECK(on.missed[0].points == doctest::Approx(16384 * 0.02 * 0.02 / 2.25).epsilon(1e-3));
  CHECK(on.missed[0].name == "mesh 33 (target)");
  // The pixel: its footprint holds (1, 1).
  const Point at = place_in_pixel(camera(), on.missed[0].line, on.missed[0].sample, 1, 1, kHeight_m);
  CHECK(std::abs(at[0]) < 0.51);
  CHECK(std::abs(at[1]) < 0.51);
  const auto off = sensors::survey_small_objects(simulation.scene, camera(), false);
  CHECK(off.missed.size() == 33);
  CHECK(off.pixels == 0);
}

TEST_CASE("S43 small objects: closed boxes and turned plates count with the area they show") {
  scene::Simulation simulation;
  const auto ground = test::add_material(simulation.scene, "ground", kGround),
             target = test::add_material(simulation.scene, "target", kPlate);
  test::place(simulation.scene, test::rectangle({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}, ground));
  test::place(simulation.scene, test::box({0.2, 0.2, 0}, {0.5, 0.5, 0.3}, target));
  const double s = 0.3 / std::sqrt(2.0);
  test::place(simulation.scene, test::rectangle({-9, -3, kHeight_m}, {s, s, 0}, {-s, s, 0}, target));
  finish_top_tree(simulation.scene);
  const scene::Instrument above = camera();
  const sensors::SmallObjectPixels small(simulation.scene, above);
  REQUIRE(small.objects().objects.size() == 2);
  std::vector<double> shares(2, 0.0);
  for (int line = 0; line < above.lines; ++line)
    for (const auto& group : sensors::make_ray_groups(above, simulation.scene, line, 1))
      for (const auto& one : small.in_group(group, 4)) shares[one.object] = one.share;
  CHECK(shares[0] == doctest::Approx(0.04).epsilon(2e-3));  // its top, and 0.3 mm of its side
  CHECK(shares[1] == doctest::Approx(0.04).epsilon(1e-4));
}
