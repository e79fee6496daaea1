// One scene compiled with shared trees and with a tree for each mesh: rays find the same owners, sun and products are
// the same to the bit, and panels in one place show the user's first, whole.
#include <doctest/doctest.h>

#include <cmath>
#include <set>
#include <sstream>

#include "host/base/log.h"
#include "host/reference/double_trace.h"
#include "host/run/load_job.h"
#include "host/run/render_camera.h"
#include "host/run/render_lidar.h"
#include "scene_compiler/load_simulation.h"
#include "scene_compiler/owner.h"
#include "tests/support/devices.h"
#include "tests/support/test_scenes.h"
#include "tests/support/trace_chain.h"
#include "tests/unit/test_folder.h"

using namespace raycube;
using raycube::testing::TestFolder;
using test::TraceShape;

namespace {

std::string obj_text(const scene::TriangleMesh& mesh) {
  std::ostringstream out;
  out.precision(9);
  for (const auto& v : mesh.vertices) out << "v " << v[0] << ' ' << v[1] << ' ' << v[2] << '\n';
  for (const auto& t : mesh.triangles) out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  return out.str();
}

constexpr const char* kMatter = R"(format = 1
seed = 5
sky_directions = 12
material = [
  { name = "soil", reflectance = 0.2, temperature_K = 300.0 },
  { name = "grass", reflectance = 0.4, temperature_K = 295.0 },
  { name = "leaf", reflectance = 0.5, temperature_K = 294.0 },
  { name = "bark", reflectance = 0.1, temperature_K = 296.0 },
  { name = "net", reflectance = 0.2, transmittance = 0.5, transmission = "plate", temperature_K = 297.0 },
]
)";

/// Ground of two materials that interleave, hills, a house, nets in one plane; trees of bark and leaves, listed one
/// after the other and in turns.
std::string garden(const TestFolder& folder) {
  folder.write("hills.obj", obj_text(test::terrain(24, 60)));
  folder.write("bark.obj", obj_text(test::sphere(2, 0.7, 0.3)));
  folder.write("leaves.obj", obj_text(test::crown(300, 0.3, 2.2, 4)));
  folder.write("places.csv", "x_m,y_m,yaw_deg,scale\n-9,-6,10,1\n6,-8,100,1.3\n2,7,215,0.8\n-4,5,300,1.1\n");
  return std::string(kMatter) + R"(
plane = [
  { checker = { materials = ["soil", "grass"], cell_m = 1.5 }, position_m = [0.0, 0.0, 0.5], size_m = [24.0, 24.0] },
  { checker = { materials = ["grass", "bark"], cell_m = 0.7 }, position_m = [4.0, 3.0, 0.5], size_m = [9.0, 9.0] },
  { material = "net", position_m = [-6.0, 8.0, 3.0], size_m = [6.0, 6.0] },
  { material = "net", position_m = [-3.0, 8.0, 3.0], size_m = [6.0, 6.0] },
]
box = [{ material = "soil", position_m = [-5.0, -1.0, 0.0], size_m = [4.0, 5.0, 3.0], yaw_deg = 20.0 }]
mesh = [
  { name = "hills", file = "hills.obj", material = "grass" },
  { name = "bark", file = "bark.obj", material = "bark" },
  { name = "leaves", file = "leaves.obj", material = "leaf" },
  { name = "stone", file = "bark.obj", material = "soil" },
  { name = "moss", file = "leaves.obj", material = "grass" },
]
instance = [
  { mesh = "stone", position_m = [8.0, 2.0, 1.0] },
  { mesh = "moss", position_m = [8.0, 2.0, 1.0] },
  { mesh = "hills" },
  { mesh = "stone", position_m = [-2.0, -9.0, 1.0], yaw_deg = 70.0 },
  { mesh = "moss", position_m = [-2.0, -9.0, 1.0], yaw_deg = 70.0 },
]
scatter = [
  { mesh = "bark", positions = "places.csv", on_terrain = false },
  { mesh = "leaves", positions = "places.csv", on_terrain = false },
]
)";
}

constexpr const char* kLooks = R"(
atmosphere = { model = "layered", spectral_step_nm = 20.0 }
time = { sun = { zenith_deg = 50.0, azimuth_deg = 150.0, day_of_year = 200 } }
[[instrument]]
name = "camera"
kind = "framing"
pixels = 29
lines = 23
altitude_agl_m = 60.0
gsd_m = 0.9
roll_deg = 4.0
samples = { lattice = 20 }
bands = { first_nm = 500.0, step_nm = 150.0, count = 5, fwhm_nm = 30.0 }
small_objects = "on"
[[instrument]]
name = "thermal"
kind = "framing"
pixels = 17
lines = 11
altitude_agl_m = 60.0
gsd_m = 1.5
samples = { grid = [3, 3] }
bands = { first_nm = 8500.0, step_nm = 1500.0, count = 2, fwhm_nm = 400.0 }
[[lidar]]
name = "lidar"
position_m = [-1.0, -2.0, 60.0]
prf_khz = 10.0
pulses = 60
[lidar.pulse]
energy_J = 1e-5
wavelength_nm = 1064.0
fwhm_ns = 4.0
divergence_mrad = 8.0
divergence_is = "full angle at 1/e^2"
[lidar.receiver]
aperture_diameter_m = 0.1
fov_mrad = 16.0
[lidar.gate]
start_range_m = 45.0
stop_range_m = 70.0
[lidar.scan]
pattern = "oscillating"
rate_hz = 100.0
half_angle_deg = 10.0
[lidar.sampling]
subrays = 48
bounces = 2
[lidar.products]
png = false
)";

/// The scene of a file both ways.
struct BothWays {
  scene::Simulation shared, alone;
  BothWays(const TestFolder& folder, const std::string& text) {
    folder.write("scene.toml", text);
    shared = scene::load_simulation(folder / "scene.toml");
    alone = scene::load_simulation(folder / "scene.toml", {.trees = scene::TreeSharing::none});
    CHECK(shared.scene.trees.size() < alone.scene.trees.size());
  }
};

/// First hits and the sun's bits of a tile of rays.
struct Traced {
  std::vector<std::uint32_t> hits;
  std::vector<std::uint16_t> sun;
  Traced(const cl::Context& context, const scene::CompiledScene& scene, const TraceShape& shape,
         const std::vector<shared::RayGroup>& groups) {
    test::TraceChain chain(context, scene, shape);
    hits = chain.primary(groups);
    chain.surface();
    sun = chain.sun({0.5f, -0.3f, std::sqrt(1 - 0.34f), 0});
  }
  reference::Hit at(const TraceShape& shape, std::uint32_t pixel, std::uint32_t s) const {
    return {hits[shape.hits_at(pixel, RC_HIT_INSTANCE, s)], hits[shape.hits_at(pixel, RC_HIT_PRIMITIVE, s)]};
  }
};

/// Names hits of one compiled scene by those of another of the same user's scene.
class Translation {
 public:
  Translation(const scene::CompiledScene& from, const scene::CompiledScene& to)
      : from_(from), placements_(scene::placements(to)), triangles_(to) {}
  reference::Hit operator()(const reference::Hit& hit) const {
    if (hit.miss()) return hit;
    const auto owner = scene::owner_of(from_, hit.instance, hit.primitive);
    const auto& placement = placements_[owner.placement];
    return {placement.instance, triangles_.of(placement.mesh)[owner.triangle]};
  }

 private:
  const scene::CompiledScene& from_;
  std::vector<scene::Placement> placements_;
  scene::MeshTriangles triangles_;
};

/// Owners of both ways' first hits, ray by ray: those that differ must be two right answers to rounding.
void compare_hits(const cl::Context& context, const BothWays& scenes, const TraceShape& shape,
                  const std::vector<shared::RayGroup>& groups) {
  const Traced a(context, scenes.shared.scene, shape, groups), b(context, scenes.alone.scene, shape, groups);
  const Translation translate(scenes.shared.scene, scenes.alone.scene);
  const reference::DoubleTracer judge(scenes.alone.scene);
  std::size_t rays = 0, hits = 0, apart = 0, unexplained = 0;
  std::set<std::uint32_t> owners;
  for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel)
    for (std::uint32_t s = 0; s < shape.samples(); ++s, ++rays) {
      const reference::Hit of_a = translate(a.at(shape, pixel, s)), of_b = b.at(shape, pixel, s);
      hits += !of_b.miss();
      if (!of_b.miss()) owners.insert(scene::owner_of(scenes.alone.scene, of_b.instance, of_b.primitive).placement);
      if (of_a == of_b) continue;
      ++apart;
      const auto width = static_cast<std::uint32_t>(shape.pixels_per_group);
      const std::uint32_t line = pixel / shape.columns, column = pixel % shape.columns;
      const auto numbered = test::numbered(groups, shape);
      const auto ray =
          test::host_ray(numbered[line * shape.groups_per_line() + column / width], shape, pixel, column % width, s);
      reference::DoubleRay exact{
          {ray.origin[0], ray.origin[1], ray.origin[2]}, {ray.direction[0], ray.direction[1], ray.direction[2]}, 0};
      unexplained += judge.explain(exact, of_a, of_b) == reference::Cause::unexplained;
    }
  MESSAGE(rays << " rays, " << hits << " hits, " << apart << " owners differ");
  CHECK(hits > rays / 2);
  CHECK(owners.size() > 12);
  CHECK(unexplained == 0);
  CHECK(apart <= rays / 10000);
  if (apart == 0) CHECK(a.sun == b.sun);
}

/// Files of a product's folder but for what tells of the run.
void compare_products(const std::string& a, const std::string& b, std::set<std::string> wanted) {
  const auto bytes = [](const std::filesystem::path& file) {
    std::ostringstream out;
    out << std::ifstream(file, std::ios::binary).rdbuf();
    std::string text = out.str();
    if (file.extension() == ".las") text.replace(90, 4, 4, '\0');  // day and year it was made
    return text;
  };
  for (const auto& entry : std::filesystem::directory_iterator(a)) {
    const std::string name = entry.path().filename().string();
    if (name == "run.json") continue;
    CAPTURE(name);
    CHECK(bytes(entry.path()) == bytes(std::filesystem::path(b) / name));
    wanted.erase(name);
  }
  for (const auto& name : wanted) FAIL_CHECK("missing: " << name);
}

/// Every product of every instrument.
void render_all(const scene::Simulation& simulation, const std::string& folder) {
  base::Log log({.verbosity = -2, .json_file = ""});
  run::Services services{log};
  const render::RenderOptions options;
  for (const auto* instrument : run::pick_instruments(simulation, "")) {
    render::Renderer renderer(simulation.scene, options);
    const auto job = run::prepare_camera(simulation, *instrument, services);
    run::render_camera(simulation, job, renderer, options,
                       {folder + instrument->name, base::IfExists::refuse, "test", 0}, services);
  }
  for (const auto* lidar : run::pick_lidars(simulation, ""))
    run::render_lidar(simulation, *lidar, options, {folder + lidar->name, base::IfExists::refuse, "test", 0}, services,
                      {});
}

/// A square of 8 x 8 cells of 0.25 m from the origin to x = y = 2, at z = 0, moved along x.
scene::TriangleMesh panel(double x_m) {
  scene::TriangleMesh mesh;
  for (int j = 0; j <= 8; ++j)
    for (int i = 0; i <= 8; ++i)
      mesh.vertices.push_back({static_cast<float>(x_m + 0.25 * i), static_cast<float>(0.25 * j), 0.0f});
  for (std::uint32_t j = 0; j < 8; ++j)
    for (std::uint32_t i = 0; i < 8; ++i) {
      const std::uint32_t v = 9 * j + i;
      mesh.triangles.push_back({v, v + 1, v + 10});
      mesh.triangles.push_back({v, v + 10, v + 9});
    }
  return mesh;
}

}  // namespace

TEST_CASE("shared trees: first hits have the owners that trees of one mesh give, and the sun sees the same samples") {
  const TestFolder folder;
  const BothWays scenes(folder, garden(folder));
  CHECK(scenes.shared.scene.trees.size() == 3);  // all that is unmoved; stone and moss; bark and leaves
  test::on_every_device([&](const cl::Context& context) {
    for (const bool bundle : {true, false})
      for (const int sampler : {0, 1}) {
        CAPTURE(bundle);
        CAPTURE(sampler);
        TraceShape shape;
        shape.nu = shape.nv = 4, shape.bundle = bundle, shape.sampler = sampler;
        shape.columns = shape.pixels_per_line = 48, shape.lines = 40;
        compare_hits(context, scenes, shape, test::nadir_groups(shape, 0, 0, 30, 0.6, 30, 0.2));
      }
  });
}

TEST_CASE("shared trees: radiance, truth, waveforms and returns with their objects are the same to the byte") {
  const TestFolder folder;
  const BothWays scenes(folder, garden(folder) + kLooks);
  render_all(scenes.shared, folder / "shared-");
  render_all(scenes.alone, folder / "alone-");
  compare_products(folder / "shared-camera", folder / "alone-camera", {"radiance.img", "truth.img"});
  compare_products(folder / "shared-thermal", folder / "alone-thermal", {"radiance.img", "truth.img"});
  compare_products(folder / "shared-lidar", folder / "alone-lidar", {"returns.las", "returns.csv", "pulses.csv"});
}

TEST_CASE("shared trees: of panels in one place the user's first is seen, whole, whichever tree holds it") {
  const TestFolder folder;
  folder.write("panel.obj", obj_text(panel(0)));
  folder.write("beside.obj", obj_text(panel(2)));
  // Placements 0 (far below), 1 and 2: in the tree of all that is unmoved, 3 and 5: "twice" in its own tree, and 4.
  // 6 to 9: "left" and "right" share a tree; the second of one stands where the first of the other does.
  const BothWays scenes(folder, std::string(kMatter) + R"(
plane = [{ material = "grass", size_m = [40.0, 40.0], position_m = [0.0, 0.0, -4.0] }]
mesh = [
  { name = "a", file = "panel.obj", material = "leaf" },
  { name = "b", file = "panel.obj", material = "bark" },
  { name = "twice", file = "beside.obj", material = "soil" },
  { name = "later", file = "beside.obj", material = "leaf" },
  { name = "left", file = "panel.obj", material = "soil" },
  { name = "right", file = "beside.obj", material = "bark" },
]
instance = [
  { mesh = "b" },
  { mesh = "a" },
  { mesh = "twice" },
  { mesh = "later" },
  { mesh = "twice", position_m = [-4.0, -4.0, 0.0] },
  { mesh = "left", position_m = [0.0, -4.0, 0.0] },
  { mesh = "left", position_m = [2.0, -4.0, 0.0] },
  { mesh = "right", position_m = [0.0, -4.0, 0.0] },
  { mesh = "right", position_m = [2.0, -4.0, 0.0] },
]
)");
  REQUIRE(scenes.shared.scene.trees.size() == 3);
  // Which placement is seen at a place: x and y of its low corner, m.
  const struct {
    double x, y;
    std::uint32_t placement;
  } seen[] = {{0, 0, 1}, {2, 0, 3}, {-2, -4, 5}, {0, -4, 6}, {2, -4, 7}, {4, -4, 9}};
  test::on_every_device([&](const cl::Context& context) {
    for (const bool bundle : {true, false})
      for (const auto* scene : {&scenes.shared.scene, &scenes.alone.scene})
        for (const auto& place : seen) {
          CAPTURE(bundle);
          CAPTURE(place.x);
          CAPTURE(place.y);
          TraceShape shape;
          shape.nu = shape.nv = 5, shape.bundle = bundle;
          shape.columns = shape.pixels_per_line = 28, shape.lines = 28;
          // 28 pixels of 1 / 16 m about the middle: the panel but for its rim.
          const auto groups = test::nadir_groups(shape, place.x + 1, place.y + 1, 8, 0.0625, 8, 0);
          const Traced traced(context, *scene, shape, groups);
          std::size_t others = 0;
          for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel)
            for (std::uint32_t s = 0; s < shape.samples(); ++s) {
              const auto hit = traced.at(shape, pixel, s);
              REQUIRE_FALSE(hit.miss());
              others += scene::owner_of(*scene, hit.instance, hit.primitive).placement != place.placement;
            }
          CHECK(others == 0);
        }
  });
}
