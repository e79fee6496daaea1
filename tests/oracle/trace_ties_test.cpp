// Rays aimed at what lies on the border of a decision: faces, edges and corners of boxes, round coordinates,
// axis-parallel directions, origins in the planes of faces. Bundles, single rays and every triangle without a tree must
// agree in every bit.
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "kernels/sampling/sampler.h"
#include "tests/support/any_hits.h"
#include "tests/support/brute_trace.h"
#include "tests/support/devices.h"
#include "tests/support/test_scenes.h"

using namespace raycube;
using raycube::test::first_context;
using test::TraceShape;

namespace {

using V = std::array<double, 3>;

// Numbers of a stream, the same on every machine.
class Stream {
 public:
  explicit Stream(std::uint32_t seed) : seed_(seed) {}
  double uniform() { return test::unit_random(seed_, next_++, 0); }
  /// lo .. hi
  int whole(int lo, int hi) { return lo + static_cast<int>(uniform() * (hi - lo + 1)); }

 private:
  std::uint32_t seed_, next_ = 0;
};

/// A box, or a plate of two triangles where it has no thickness. Its eight corners are the next eight vertices either
/// way.
void add_box(scene::TriangleMesh& mesh, const V& lo, const V& hi) {
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back({static_cast<float>(i & 1 ? hi[0] : lo[0]), static_cast<float>(i & 2 ? hi[1] : lo[1]),
                             static_cast<float>(i & 4 ? hi[2] : lo[2])});
  const std::array<std::uint32_t, 3> faces[] = {{0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}, {0, 1, 4}, {1, 5, 4},
                                                {2, 6, 3}, {3, 6, 7}, {0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}};
  const std::size_t flat = lo[0] == hi[0] ? 0 : lo[1] == hi[1] ? 4 : 8;
  const bool plate = lo[0] == hi[0] || lo[1] == hi[1] || lo[2] == hi[2];
  for (std::size_t t = plate ? flat : 0; t < (plate ? flat + 2 : 12); ++t)
    mesh.triangles.push_back({base + faces[t][0], base + faces[t][1], base + faces[t][2]});
}

scene::TriangleMesh finished(scene::TriangleMesh mesh) {
  mesh.surface.assign(mesh.triangles.size(), 0);
  mesh.user_face.resize(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) mesh.user_face[i] = static_cast<std::uint32_t>(i);
  return mesh;
}

// Boxes with corners at halves, each in a cell of its own, and plates without thickness across all three axes: most
// boxes of the tree are flat or share planes with others. No two faces touch: of surfaces closer than rounding either
// may be the first.
scene::TriangleMesh blocks_and_plates(std::uint32_t seed) {
  Stream random(seed);
  scene::TriangleMesh mesh;
  for (int i = 0; i < 27; ++i) {
    const V cell{4.0 * (i % 3) - 6, 4.0 * (i / 3 % 3) - 6, 4.0 * (i / 9) - 6};
    V lo, hi;
    for (int k = 0; k < 3; ++k) lo[k] = cell[k] + random.whole(0, 2) * 0.5, hi[k] = lo[k] + random.whole(1, 4) * 0.5;
    if (i % 2 == 0) hi[i / 2 % 3] = lo[i / 2 % 3];
    add_box(mesh, lo, hi);
  }
  return finished(mesh);
}

// Painted lines: long, thin and flat, as on a court.
scene::TriangleMesh lines() {
  scene::TriangleMesh mesh;
  for (const double s : {-1.0, 1.0}) {
    add_box(mesh, {s * 7.5 - 0.035, -14.035, 0}, {s * 7.5 + 0.035, 14.035, 0});
    add_box(mesh, {-7.4, s * 14 - 0.035, 0}, {7.4, s * 14 + 0.035, 0});
    add_box(mesh, {s * 3 - 0.035, -7.5, 0}, {s * 3 + 0.035, 7.5, 0});
  }
  add_box(mesh, {-2.9, -0.035, 0}, {2.9, 0.035, 0});
  return finished(mesh);
}

struct Placed {
  scene::CompiledScene scene;
  std::vector<V> corners;  // of all instances, scene frame
};

Placed place(const scene::TriangleMesh& mesh, const std::vector<std::array<double, 12>>& places) {
  Placed placed;
  const auto index = scene::append_mesh(placed.scene, "mesh", mesh);
  for (std::uint32_t i = 0; i < places.size(); ++i) {
    scene::append_instance(placed.scene, index, places[i], i);
    for (const auto& v : mesh.vertices) {
      V p;
      for (int k = 0; k < 3; ++k)
        p[k] =
            places[i][4 * k] * v[0] + places[i][4 * k + 1] * v[1] + places[i][4 * k + 2] * v[2] + places[i][4 * k + 3];
      placed.corners.push_back(p);
    }
  }
  scene::finish_top_tree(placed.scene);
  return placed;
}

// The mesh where it is, moved by round numbers, turned by a right angle, and turned, tilted and scaled.
Placed place(const scene::TriangleMesh& mesh) {
  return place(
      mesh, {test::kIdentity, test::placement(0, 0, 1, 20, -30, 0.5), test::placement(std::acos(0.0), 0, 1, -25, 8, 3),
             test::placement(0.3, 0.2, 1.3, 9, 28, -4), test::placement(1.1, 0, 1, -31, -22, 3.41)});
}

// Many instances of one plate: the boxes of the top tree are the plates themselves.
Placed plates() {
  scene::TriangleMesh mesh;
  add_box(mesh, {0, 0, 0}, {1, 0.5, 0});
  std::vector<std::array<double, 12>> places;
  for (int i = 0; i < 60; ++i)
    places.push_back(test::placement(i % 3 * std::acos(0.0), i % 5 == 0 ? std::acos(0.0) : 0, 1, 2 * (i % 8) - 8,
                                     3 * (i / 8) - 10, i % 7 * 0.5));
  return place(finished(mesh), places);
}

// Small plates, all of them several times in the same place: every hit is a tie, and the first instance's.
Placed copies() {
  Stream random(5);
  scene::TriangleMesh mesh;
  for (int i = 0; i < 64; ++i) {
    const V at{1.0 * (i % 4) - 2, 1.0 * (i / 4 % 4) - 2, 1.0 * (i / 16) - 2};
    V size{0.125, 0.25, 0.125};
    size[static_cast<std::size_t>(random.whole(0, 2))] = 0;
    add_box(mesh, at, {at[0] + size[0], at[1] + size[1], at[2] + size[2]});
  }
  return place(finished(mesh), std::vector<std::array<double, 12>>(7, test::kIdentity));
}

// A corner, a point of an edge or of a plane through two corners.
V target(const Placed& placed, Stream& random) {
  const V& a = placed.corners[static_cast<std::size_t>(random.whole(0, static_cast<int>(placed.corners.size()) - 1))];
  const std::size_t box = static_cast<std::size_t>(&a - placed.corners.data()) / 8 * 8;
  const V& b = placed.corners[box + static_cast<std::size_t>(random.whole(0, 7))];
  const double f = random.whole(0, 4) / 4.0;
  return {a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1]), a[2] + f * (b[2] - a[2])};
}

shared::rc_float4 floats(const V& v, double scale = 1) {
  return {static_cast<float>(scale * v[0]), static_cast<float>(scale * v[1]), static_cast<float>(scale * v[2]), 0};
}

// Along an axis, nearly so, across a lattice, or anywhere.
V direction(Stream& random) {
  V d{};
  const int kind = random.whole(0, 3), axis = random.whole(0, 2);
  for (int k = 0; k < 3; ++k) {
    if (kind == 0) d[k] = k == axis ? 1 : 0;
    if (kind == 1) d[k] = k == axis ? 1 : std::pow(10.0, -random.whole(3, 24)) * random.whole(-1, 1);
    if (kind == 2) d[k] = random.whole(-2, 2);
    if (kind == 3) d[k] = 2 * random.uniform() - 1;
  }
  if (d[0] == 0 && d[1] == 0 && d[2] == 0) d[axis] = 1;
  const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) * (random.whole(0, 1) ? 1 : -1);
  for (double& component : d) component /= length;
  return d;
}

struct Differences {
  std::size_t rays = 0, hits = 0, single = 0, bundle = 0;
};

// Every pixel of 4 x 4 samples has a camera of its own; its first sample's ray goes to a target, the others step by
// round numbers from there.
void compare_primary(const Placed& placed, std::uint32_t seed, int pixels_per_group, int sampler, Differences& found) {
  TraceShape shape;
  shape.nu = shape.nv = 4, shape.pixels_per_group = pixels_per_group, shape.sampler = sampler;
  shape.columns = shape.pixels_per_line = 60, shape.lines = 40;
  Stream random(seed);
  std::vector<shared::RayGroup> groups;
  for (std::uint32_t i = 0; i < shape.groups(); ++i) {
    const V aim = target(placed, random), d = direction(random);
    const double distance = random.whole(0, 3) ? random.whole(1, 300) : random.whole(1, 8) * 0.5,
                 step = std::ldexp(1.0, random.whole(-12, 3));
    shared::RayGroup g{};
    g.origin = floats({aim[0] - distance * d[0], aim[1] - distance * d[1], aim[2] - distance * d[2]});
    if (random.whole(0, 1)) g.origin = {std::round(g.origin.x), std::round(g.origin.y), std::round(g.origin.z), 0};
    V towards{aim[0] - double(g.origin.x), aim[1] - double(g.origin.y), aim[2] - double(g.origin.z)};
    if (towards[0] == 0 && towards[1] == 0 && towards[2] == 0) towards = d;
    const int axis = std::abs(towards[0]) > std::abs(towards[1]) && std::abs(towards[0]) > std::abs(towards[2]) ? 0
                     : std::abs(towards[1]) > std::abs(towards[2])                                              ? 1
                                                                                                                : 2;
    V along{}, across{};
    along[(axis + 1) % 3] = step, across[(axis + 2) % 3] = step;
    // Sample 0 of pixel 0 lies at (a0, a0 + (1 - pixels) / 2).
    const double a0 = 0.125 - 0.5, first = a0 - 0.5 * (pixels_per_group - 1);
    g.d0 = floats({towards[0] - first * along[0] - a0 * across[0], towards[1] - first * along[1] - a0 * across[1],
                   towards[2] - first * along[2] - a0 * across[2]});
    g.du = floats(along), g.dv = floats(across);
    groups.push_back(g);
  }
  const auto truth = test::BruteTrace(first_context(), placed.scene, shape).primary(groups);
  shape.bundle = true;
  const auto bundle = test::TraceChain(first_context(), placed.scene, shape).primary(groups);
  shape.bundle = false;
  const auto single = test::TraceChain(first_context(), placed.scene, shape).primary(groups);
  for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel)
    for (std::uint32_t s = 0; s < shape.samples(); ++s) {
      const std::size_t at = shape.hits_at(pixel, RC_HIT_INSTANCE, s),
                        primitive = shape.hits_at(pixel, RC_HIT_PRIMITIVE, s);
      ++found.rays;
      found.hits += truth[at] != RC_NONE;
      found.single += truth[at] != single[at] || truth[primitive] != single[primitive];
      const bool differs = truth[at] != bundle[at] || truth[primitive] != bundle[primitive];
      if (differs && ++found.bundle <= 5)
        MESSAGE("seed " << seed << " pixel " << pixel << " sample " << s << ": all " << truth[at] << "/"
                        << truth[primitive] << ", bundle " << bundle[at] << "/" << bundle[primitive] << ", single "
                        << single[at] << "/" << single[primitive]);
    }
}

void compare_shadows(const Placed& placed, std::uint32_t seed, Differences& found) {
  TraceShape shape;
  shape.nu = shape.nv = 8;
  shape.columns = shape.pixels_per_line = 24, shape.lines = 2;
  test::BruteTrace brute(first_context(), placed.scene, shape);
  shape.bundle = true;
  test::TraceChain with_bundles(first_context(), placed.scene, shape);
  shape.bundle = false;
  test::TraceChain without(first_context(), placed.scene, shape);
  Stream random(seed);
  std::vector<float> points(shape.pixels() * shape.elements().surface);
  for (int round = 0; round < 24; ++round) {
    const V d = direction(random);
    const shared::rc_float4 sun = floats(d);
    for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel) {
      const double spread = std::ldexp(1.0, random.whole(-24, 9));
      const V about = target(placed, random);
      for (std::uint32_t s = 0; s < shape.elements().padded; ++s) {
        V aim = about;
        if (random.whole(0, 2)) aim = target(placed, random);
        const double back = random.whole(0, 2) ? spread * random.whole(-4, 16) : 0;
        for (std::uint32_t k = 0; k < 3; ++k) {
          points[shape.surface_at(pixel, RC_POINT_X + k, s)] = static_cast<float>(aim[k] - back * d[k]);
          points[shape.surface_at(pixel, RC_NORMAL_X + k, s)] = static_cast<float>(d[k]);
        }
      }
    }
    const auto truth = brute.sun(points, sun);
    with_bundles.set_surface(points);
    without.set_surface(points);
    const auto bundle = with_bundles.sun(sun), single = without.sun(sun);
    for (std::size_t word = 0; word < truth.size(); ++word) {
      found.rays += 16;
      found.hits += static_cast<std::size_t>(16 - __builtin_popcount(truth[word]));
      found.single += static_cast<std::size_t>(__builtin_popcount(truth[word] ^ single[word]));
      const unsigned differs = truth[word] ^ bundle[word];
      if (differs && found.bundle < 5)
        MESSAGE("seed " << seed << " word " << word << " direction " << sun.x << " " << sun.y << " " << sun.z
                        << ": seen by all " << truth[word] << ", bundle " << bundle[word] << ", single "
                        << single[word]);
      found.bundle += static_cast<std::size_t>(__builtin_popcount(differs));
    }
  }
}

// Sixteens of rays from points close to each other or far apart, each to a target or in any direction, some of them
// all in one.
void compare_any(const Placed& placed, std::uint32_t seed, Differences& found) {
  Stream random(seed);
  test::AnyRays rays;
  for (int sixteen = 0; sixteen < 3000; ++sixteen) {
    const V about = target(placed, random), shared = direction(random);
    const bool parallel = random.whole(0, 3) == 0, near = random.whole(0, 1);
    for (int k = 0; k < 16; ++k) {
      const V aim = near ? about : target(placed, random), d = parallel ? shared : direction(random);
      const double back = random.whole(0, 2) ? std::ldexp(1.0, random.whole(-24, 9)) * random.whole(-4, 16) : 0;
      for (auto [at, way, axis] :
           {std::tuple{&rays.x, &rays.dx, 0u}, {&rays.y, &rays.dy, 1u}, {&rays.z, &rays.dz, 2u}}) {
        at->push_back(static_cast<float>(aim[axis] - back * d[axis]));
        way->push_back(static_cast<float>(d[axis]));
      }
    }
  }
  for (const test::AnyAnswers& answers : test::any_hits(first_context(), placed.scene, rays)) {
    found.rays += 16;
    found.hits += static_cast<std::size_t>(__builtin_popcount(answers.without_tree));
    found.single += static_cast<std::size_t>(__builtin_popcount(answers.alone ^ answers.without_tree));
    found.bundle += static_cast<std::size_t>(__builtin_popcount(answers.together ^ answers.without_tree));
    found.bundle += static_cast<std::size_t>(__builtin_popcount(answers.one_way ^ answers.without_tree));
  }
}

void report(const std::string& what, const Differences& found) {
  MESSAGE(what << ": rays " << found.rays << ", hits " << found.hits << "; other than without a tree: single "
               << found.single << ", bundle " << found.bundle);
  CHECK(found.hits > 500);
  CHECK(found.hits < found.rays);
  CHECK(found.single == 0);
  CHECK(found.bundle == 0);
}

}  // namespace

TEST_CASE("S5 S7: camera rays aimed at faces, edges and corners: bundles, single rays and every triangle agree") {
  for (const auto& [name, placed] : {std::pair{"blocks", place(blocks_and_plates(1))},
                                     {"lines", place(lines())},
                                     {"plates", plates()},
                                     {"copies", copies()}}) {
    Differences found;
    compare_primary(placed, 11, 4, RC_SAMPLER_GRID, found);
    compare_primary(placed, 12, 1, RC_SAMPLER_GRID, found);
    compare_primary(placed, 13, 4, RC_SAMPLER_JITTERED, found);
    report(name, found);
  }
}

TEST_CASE(
    "S8: shadow rays aimed at faces, edges and corners, points on faces: bundles, single rays and every triangle "
    "agree") {
  for (const auto& [name, placed] :
       {std::pair{"blocks", place(blocks_and_plates(2))}, {"lines", place(lines())}, {"plates", plates()}}) {
    Differences found;
    compare_shadows(placed, 21, found);
    report(name, found);
  }
}

TEST_CASE(
    "S8: rays in directions of their own aimed at faces, edges and corners: sixteen at once, alone and every "
    "triangle agree") {
  for (const auto& [name, placed] :
       {std::pair{"blocks", place(blocks_and_plates(3))}, {"lines", place(lines())}, {"plates", plates()}}) {
    Differences found;
    compare_any(placed, 31, found);
    report(name, found);
  }
}
