// The groups that small objects project into, found without walking the image (host/sensors/group_finder.h).
// Oracle: the walk over every group of the image, whose answer must be the survey's in every count and place.
// How much is looked at is counted, not timed.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <map>
#include <random>

#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/sensors/ray_groups.h"
#include "host/sensors/small_objects.h"
#include "tests/support/render_kit.h"
#include "tests/unit/scene_files.h"

namespace {

using namespace raycube;
using scene::InstrumentKind;

/// A plain with thin square plates and poles at random places about the origin.
scene::Simulation plain(int count, double within_m, double side_m, double half_m = 4000) {
  scene::Simulation simulation;
  scene::CompiledScene& scene = simulation.scene;
  const auto ground = test::add_material(scene, "ground", 0.2), target = test::add_material(scene, "target", 0.9);
  test::place(scene, test::rectangle({-half_m, -half_m, 0}, {2 * half_m, 0, 0}, {0, 2 * half_m, 0}, ground));
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-within_m, within_m);
  for (int i = 0; i < count; ++i) {
    const double x = place(random), y = place(random), z = 3 * std::abs(place(random)) / within_m;
    if (i % 4 == 3)
      test::place(scene, test::box({x, y, 0}, {x + side_m / 4, y + side_m / 4, 3 * side_m}, target));
    else
      test::place(scene, test::rectangle({x, y, z}, {side_m, 0, 0}, {0, side_m, 0}, target));
  }
  finish_top_tree(scene);
  return simulation;
}

scene::Instrument instrument(InstrumentKind kind, int pixels, int lines, double height_m, double pixel_m) {
  scene::Instrument out = test::nadir_camera(pixels, lines, height_m, pixel_m, 0.4, -0.3);
  out.kind = kind;
  out.samples_u = out.samples_v = 3;
  return out;
}

/// One pose a line (whisk-broom: a pixel), flown north over the origin, with jitter and a steady turn.
scene::Instrument flown(scene::Instrument out, double pixel_m, double jitter_deg, double turn_deg,
                        double pitch_deg = 0) {
  std::mt19937 random(5);
  std::normal_distribution<double> draw(0, 1);
  const double height_m = out.poses.at(0).z_m;
  out.poses.clear();
  const int each = out.kind == InstrumentKind::whiskbroom ? out.pixels : 1, count = out.lines * each;
  for (int i = 0; i < count; ++i) {
    const double way = static_cast<double>(i) / each + 0.5 - 0.5 * out.lines;
    out.poses.push_back({0.05 * draw(random), pixel_m * way - height_m * std::tan(pitch_deg * M_PI / 180),
                         height_m + 0.05 * draw(random), jitter_deg * draw(random),
                         pitch_deg + jitter_deg * draw(random),
                         turn_deg * static_cast<double>(i) / count - turn_deg / 2 + jitter_deg * draw(random)});
  }
  return out;
}

/// A survey by a walk over every group of the image.
sensors::SmallObjectSurvey walked(const scene::CompiledScene& scene, scene::Instrument settled, bool on) {
  settled.motion = sensors::pose_moves(settled) ? scene::PoseMotion::moving : scene::PoseMotion::held;
  const sensors::SmallObjectPixels small(scene, settled);
  const int width = sensors::pixels_per_group(settled);
  sensors::SmallObjectSurvey out;
  std::map<std::uint32_t, sensors::SmallObjectSurvey::Object> objects;
  for (int line = 0; line < settled.lines; ++line) {
    const auto groups = sensors::make_ray_groups(settled, scene, line, 1);
    for (int group = 0; group < static_cast<int>(groups.size()); ++group) {
      const int used = std::min(width, settled.pixels - group * width);
      const auto seen = small.in_group(groups[static_cast<std::size_t>(group)], used);
      out.looked_at += !seen.empty();
      const int fine = small.samples_of(seen);
      if (on && fine > 0) {
        out.groups.push_back({line, group * width, fine});
        out.levels[fine] += static_cast<std::uint64_t>(used), out.pixels += static_cast<std::uint64_t>(used);
      }
      for (const auto& one : seen) {
        auto [at, anew] = objects.try_emplace(one.object);
        if (anew) at->second.line = line, at->second.sample = group * width + one.lane;
        at->second.share = std::max(at->second.share, one.share), ++at->second.pixels;
      }
    }
  }
  out.objects = objects.size();
  for (const auto& [index, object] : objects) out.missed.push_back(object);
  return out;
}

/// Same groups, counts and objects; few groups more than those that see something were looked at.
void check_as_walked(const scene::Simulation& simulation, const scene::Instrument& instrument, double looks_per_group) {
  const auto key = [](const auto& object) {
    return std::tuple(object.line, object.sample, object.share, object.pixels);
  };
  for (const bool on : {true, false}) {
    const auto walk = walked(simulation.scene, instrument, on);
    const auto survey = sensors::survey_small_objects(simulation.scene, instrument, on);
    REQUIRE(walk.objects > 0);
    CHECK(survey.objects == walk.objects);
    CHECK(survey.pixels == walk.pixels);
    CHECK(survey.levels == walk.levels);
    REQUIRE(survey.groups.size() == walk.groups.size());
    for (std::size_t i = 0; i < walk.groups.size(); ++i) {
      CHECK(survey.groups[i].line == walk.groups[i].line);
      CHECK(survey.groups[i].sample == walk.groups[i].sample);
      CHECK(survey.groups[i].samples == walk.groups[i].samples);
    }
    for (const auto& missed : survey.missed)
      CHECK(std::any_of(walk.missed.begin(), walk.missed.end(),
                        [&](const auto& object) { return key(object) == key(missed); }));
    if (!on) CHECK(2 * survey.missed.size() > walk.missed.size());
    CHECK(survey.looked_at >= walk.looked_at);
    MESSAGE(instrument.lines << " x " << instrument.pixels << ": " << walk.objects << " objects in " << walk.looked_at
                             << " groups, looked at " << survey.looked_at << " of "
                             << instrument.lines * sensors::groups_per_line(instrument));
    CHECK(static_cast<double>(survey.looked_at) <= looks_per_group * static_cast<double>(walk.looked_at));
  }
}

}  // namespace

TEST_CASE("S43 small objects: the survey finds what a walk over the image finds") {
  const auto simulation = plain(60, 100, 0.3);
  SUBCASE("frame, straight down") {
    check_as_walked(simulation, instrument(InstrumentKind::framing, 150, 130, 1500, 1.5), 3);
  }
  SUBCASE("frame, its last group not whole, a point spread") {
    scene::Instrument camera = instrument(InstrumentKind::framing, 149, 130, 1500, 1.5);
    camera.psf_sigma_px = 0.4, camera.psf_support_px = 3.4;
    check_as_walked(simulation, camera, 3);
  }
  SUBCASE("frame, oblique") {
    scene::Instrument camera = instrument(InstrumentKind::framing, 300, 260, 1500, 1.5);
    camera.poses = {{-100, -1500, 1500, 10, 42, 12}};
    check_as_walked(simulation, camera, 3);
  }
  SUBCASE("frame, along the ground") {
    scene::Instrument camera = instrument(InstrumentKind::framing, 400, 60, 20, 0.06);
    camera.poses = {{0, -160, 20, 0, 83, 0}};
    check_as_walked(simulation, camera, 3);
  }
  for (const auto motion : {scene::PoseMotion::held, scene::PoseMotion::moving, scene::PoseMotion::automatic}) {
    CAPTURE(static_cast<int>(motion));
    scene::Instrument broom = instrument(InstrumentKind::pushbroom, 150, 130, 1500, 1.5);
    broom.motion = motion;
    // A moving line is asked for what lies 3 of its steps on either side, since all corners of an object
    // count; jitter makes its steps long.
    SUBCASE("push-broom, steady") { check_as_walked(simulation, flown(broom, 1.5, 0, 0), 8); }
    SUBCASE("push-broom, jitter of 5 lines") { check_as_walked(simulation, flown(broom, 1.5, 0.3, 0), 30); }
    SUBCASE("push-broom, a full turn with jitter") { check_as_walked(simulation, flown(broom, 1.5, 0.02, 400), 30); }
    SUBCASE("push-broom, looking ahead") { check_as_walked(simulation, flown(broom, 1.5, 0.02, 30, 35), 40); }
    SUBCASE("push-broom, a point spread") {
      broom.psf_sigma_px = 0.4, broom.psf_support_px = 3.4;
      check_as_walked(simulation, flown(broom, 1.5, 0.02, 20), 10);
    }
  }
  SUBCASE("whisk-broom, steady, and with jitter and a turn") {
    const scene::Instrument whisk = instrument(InstrumentKind::whiskbroom, 150, 130, 1500, 1.5);
    check_as_walked(simulation, flown(whisk, 1.5, 0, 0), 30);
    check_as_walked(simulation, flown(whisk, 1.5, 0.02, 60), 60);
  }
}

TEST_CASE("S43 small objects: a satellite's view, whose rays single precision rounds by a part of a pixel") {
  const auto simulation = plain(800, 250, 0.2);
  scene::Instrument camera = instrument(InstrumentKind::framing, 800, 800, 7e5, 0.4);
  camera.poses = {{0, 0, 7e5, 8, 15, 20}};
  const auto axis = sensors::pixel_ray(camera, 400, 400, -0.5, -0.5).direction;
  camera.poses[0].x_m = 7e5 * axis.x / axis.z, camera.poses[0].y_m = 7e5 * axis.y / axis.z;
  check_as_walked(simulation, camera, 40);
}

TEST_CASE("S43 small objects: one plate in 9e8 pixels is looked for where it is") {
  const auto simulation = plain(1, 20, 0.3, 6000);
  const int side = 30000;
  for (const auto kind : {InstrumentKind::framing, InstrumentKind::pushbroom}) {
    scene::Instrument large = instrument(kind, side, side, 15000, 0.3);
    if (kind == InstrumentKind::pushbroom) {
      large.motion = scene::PoseMotion::automatic;
      large = flown(large, 0.3, 0.01, 3);  // jitter of 9 lines: a hundred lines may see the plate
    }
    const auto survey = sensors::survey_small_objects(simulation.scene, large, true);
    MESSAGE("looked at " << survey.looked_at << " of " << std::uint64_t{1} * side * side / 4 << " groups");
    CHECK(survey.objects == 1);
    CHECK(survey.looked_at >= 1);
    CHECK(survey.looked_at < 1000);
  }
  // A camera's lines cost nothing either.
  const auto tall = sensors::survey_small_objects(simulation.scene,
                                                  instrument(InstrumentKind::framing, 1, 1000000000, 1500, 0.3), true);
  CHECK(tall.looked_at < 300);
}

TEST_CASE("S43 small objects: the survey of a long flight is stopped by a signal") {
  const auto simulation = plain(1, 20, 0.3);
  base::install_signal_handlers();
  for (const auto kind : {InstrumentKind::framing, InstrumentKind::pushbroom}) {
    scene::Instrument broom = instrument(kind, 64, 64, 1500, 0.3);
    broom.motion = scene::PoseMotion::held;
    if (kind == InstrumentKind::pushbroom) broom = flown(broom, 0.3, 0.01, 3);
    CHECK_NOTHROW(sensors::survey_small_objects(simulation.scene, broom, true));
    std::raise(SIGTERM);
    CHECK_THROWS_AS(sensors::survey_small_objects(simulation.scene, broom, true), base::Error);
    base::clear_interrupt();
  }
}

TEST_CASE("objects under the terrain are not looked for, since nothing above sees them") {
  const scene::testing::Folder folder;
  std::string posts = "ncols 3\nnrows 3\nxllcorner -15\nyllcorner -15\ncellsize 10\n";
  for (int i = 0; i < 9; ++i) posts += "5 ";
  folder.write("dem.asc", posts + "\n");
  folder.write("t.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
  std::string text = std::string(scene::testing::kHead) + scene::testing::kGrey +
                     "[[terrain]]\nraster = \"dem.asc\"\nmaterial = \"grey\"\n"
                     "[[mesh]]\nname = \"t\"\nfile = \"t.obj\"\nmaterial = \"grey\"\n";
  for (const char* place : {"[1, 1, 2]", "[2, 2, 7]", "[3, 3, 4.9]", "[4, 4, 5]"})
    text += std::string("[[instance]]\nmesh = \"t\"\nposition_m = ") + place + "\non_terrain = false\n";
  const scene::Simulation simulation = scene::testing::load(folder, text, {.need_instruments = false});
  CHECK(simulation.scene.buried.size() == 2);
  std::vector<double> x_m;
  for (const sensors::SceneObject& object : sensors::small_scene_objects(simulation.scene, 1.0).objects)
    x_m.push_back(std::round(object.lo_m.x));
  std::sort(x_m.begin(), x_m.end());
  CHECK(x_m == std::vector<double>{2, 4});
}
