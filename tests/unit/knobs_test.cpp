// Knobs: what is set is what is got, levels hold the subject's own, a plan obeys what is given, and every level
// renders.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include <nlohmann/json.hpp>

#include "atmos_tables/clear_sky.h"
#include "host/base/error.h"
#include "host/knobs/knob.h"
#include "host/plan/node_choice.h"
#include "host/sensors/view_bounds.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;

/// A tilted plane and a box under a hazy sky, 8 x 4 pixels.
scene::Simulation small() {
  scene::Simulation s;
  const auto grey = test::add_material(s.scene, "grey", 0.3), light = test::add_material(s.scene, "light", 0.6);
  test::place(s.scene, test::rectangle({-60, -60, 0}, {120, 0, 30}, {0, 120, 0}, grey));
  test::place(s.scene, test::box({-2, -2, 10}, {2, 2, 25}, light));
  scene::finish_top_tree(s.scene);
  s.sun.zenith_deg = 40, s.sun.azimuth_deg = 160;
  s.sky_directions = 6;
  s.instruments = {test::nadir_camera(8, 4, 300, 2)};
  s.atmosphere.layered.emplace();  // so that the environment's knob applies; the table below is given directly
  s.lidars.emplace_back();
  s.lidars[0].gate = {1e-6, 1e-9, 100};
  s.lidars[0].pulse.lines = {{"one", 1.064, 0.001, 1e-4}};
  return s;
}

atmos::RenderTable table_of(const scene::Simulation& s) {
  scene::AtmosphereSpec clear;
  atmos::RenderTable table = atmos::make_table(clear, s.sun, 300, atmos::clear_sky_wavelengths(0.45, 0.95, 0),
                                               atmos::clear_sky_heights(0, 30));
  test::add_ground_coupling(table);
  return table;
}

}  // namespace

TEST_CASE(
    "S64 knobs: names are unique, levels hold the own setting, set then get returns every level, Settings puts all "
    "back") {
  scene::Simulation s = small();
  std::set<std::string> names;
  int applied = 0;
  for (const knobs::Knob& knob : knobs::all_knobs()) {
    INFO(knob.name);
    CHECK(names.insert(knob.name).second);
    CHECK_FALSE(knob.text.empty());
    CHECK(&knobs::find_knob(knob.name) == &knob);
    for (const knobs::Subject subject :
         {knobs::Subject{s, &s.instruments[0], nullptr}, knobs::Subject{s, nullptr, &s.lidars[0]}}) {
      if (!knob.applies(subject)) continue;
      ++applied;
      const double own = knob.get(subject);
      const std::vector<double> levels = knob.levels(subject);
      CHECK(std::count(levels.begin(), levels.end(), own) == 1);
      CHECK(levels.size() > 1);
      {
        const knobs::Settings keep(subject);
        std::set<std::string> labels;
        for (const double level : levels) {
          knob.set(subject, level);
          CHECK(knob.get(subject) == doctest::Approx(level).epsilon(1e-12));
          CHECK(labels.insert(knob.label(level)).second);
        }
      }
      CHECK(knob.get(subject) == own);
    }
  }
  CHECK(applied == static_cast<int>(knobs::all_knobs().size()));  // each belongs to a cube or to pulses, none to both
  CHECK_THROWS_WITH_AS(knobs::find_knob("colour"), doctest::Contains("samples, sampler"), base::Error);
}

TEST_CASE("S64 bin_ns: coarser bins keep the gate's start and its length") {
  scene::Simulation s = small();
  const knobs::Subject subject{s, nullptr, &s.lidars[0]};
  knobs::find_knob("bin_ns").set(subject, 4);
  CHECK(s.lidars[0].gate.start_s == 1e-6);
  CHECK(s.lidars[0].gate.bins == 25);
  CHECK(s.lidars[0].gate.bin_s == doctest::Approx(4e-9));
}

TEST_CASE("S64 plans obey what is given and say so; the impossible is refused") {
  scene::Simulation s = small();
  const atmos::RenderTable table = table_of(s);
  const scene::Instrument& camera = s.instruments[0];
  const auto make = [&] { return plan::make_plan(s, camera, table, sensors::view_bounds(camera)); };
  CHECK_FALSE(plan::plan_json(make()).contains("given"));
  for (const int nodes : {1, 4}) {
    s.plan = {};
    s.plan.height_nodes = nodes, s.plan.view_nodes = nodes == 4 ? 1 : nodes, s.plan.path_nodes = std::min(nodes, 2),
    s.plan.sky_rank = std::min(nodes, 2);
    const plan::Plan plan = make();
    CHECK(plan.height.count == nodes);
    CHECK(plan.view.count == s.plan.view_nodes);
    CHECK(plan.path_x.count == s.plan.path_nodes);
    CHECK(plan.path_y.count == s.plan.path_nodes);
    CHECK(plan.sky_components == s.plan.sky_rank);
    const auto report = plan::plan_json(plan);
    CHECK(report["given"]["height_nodes"] == nodes);
    CHECK(report.contains("within_tolerance"));
  }
  s.plan = {};
  s.plan.height_nodes = s.plan.view_nodes = s.plan.path_nodes = 7;
  CHECK_THROWS_WITH_AS(make(), doctest::Contains("height_nodes 7"), base::Error);
}

TEST_CASE("S64 every count of nodes and every rank is obeyed by itself, whatever the errors say") {
  scene::Simulation s = small();
  const knobs::Subject subject{s, &s.instruments[0], nullptr};
  plan::NodeErrors errors;  // nodes gain nothing: none would be chosen
  errors.sky_rank = {0, 0, 0, 0};
  int obeyed = 0;
  for (const char* name : {"sky_rank", "height_nodes", "view_nodes", "path_nodes"}) {
    const knobs::Knob& knob = knobs::find_knob(name);
    for (const double level : knob.levels(subject)) {
      const knobs::Settings keep(subject);
      knob.set(subject, level);
      const plan::NodeChoice choice = plan::choose_nodes(errors, 1, s.plan);
      if (std::string(name) == "path_nodes" && level > 5) {
        CHECK_FALSE(choice.possible);  // 49 channels; there are 32
        continue;
      }
      REQUIRE(choice.possible);
      const auto is = [&](const char* whose, int count) {
        CHECK(count == (std::string(name) == whose ? std::max(1, static_cast<int>(level)) : 1));
      };
      is("sky_rank", choice.sky_rank), is("height_nodes", choice.height), is("view_nodes", choice.view),
          is("path_nodes", choice.path_x), is("path_nodes", choice.path_y);
      ++obeyed;
    }
  }
  CHECK(obeyed == 5 + 3 * 7 - 1);
}

TEST_CASE("S64 all knobs at their cheapest, and all at their dearest, render finite radiance") {
  // Every program of its own has to be compiled: two stand for all.
  scene::Simulation s = small();
  const atmos::RenderTable table = table_of(s);
  const knobs::Subject subject{s, &s.instruments[0], nullptr};
  for (const bool dearest : {false, true}) {
    const knobs::Settings keep(subject);
    for (const knobs::Knob& knob : knobs::all_knobs())
      if (knob.applies(subject))
        knob.set(subject, dearest ? knob.levels(subject).back() : knob.levels(subject).front());
    if (dearest) s.plan = {2, 2, 5, 3};  // 30 of 32 channels
    const test::Image image = test::render_image(s, table);
    // Dearest: a look of 64 points, once more for the scene's mean (all pixels of so small an image), then 64 or all
    // samples.
    const std::uint64_t pixels = 8 * 4, refined = image.statistics.refined_pixels;
    CHECK(image.statistics.primary_rays == (dearest ? (3 * pixels - refined) * 64 + refined * 21 * 21 : pixels));
    CHECK((image.statistics.refined_pixels > 0) == dearest);
    CHECK(std::all_of(image.radiance.begin(), image.radiance.end(), [](float l) { return std::isfinite(l); }));
    // One sky direction stands for half the sky: what it takes away may be more than there is, and only the mean over
    // pixels is right.
    if (dearest) CHECK(*std::min_element(image.radiance.begin(), image.radiance.end()) > 0);
  }
}
