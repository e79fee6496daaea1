#include "bench/scenes/scenes.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "kernels/sampling/sampler.h"
#include "host/base/units.h"

namespace raycube::bench {
namespace {

using Point = std::array<double, 3>;

double random(unsigned seed, unsigned item, unsigned dimension) {
  return rc_unit_float(rc_hash(seed, item, 0u, dimension));
}

void add_point(scene::TriangleMesh& mesh, const Point& p) {
  mesh.vertices.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
}

void add_face(scene::TriangleMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  mesh.user_face.push_back(static_cast<std::uint32_t>(mesh.triangles.size()));
  mesh.triangles.push_back({a, b, c});
  mesh.surface.push_back(0);
}

double ground_height(double x, double y) {
  return 3.0 * std::sin(x / 37) * std::cos(y / 29) + 0.8 * std::sin(x / 7.3 + 1) * std::sin(y / 5.9) +
         0.1 * std::sin(3.1 * x + 2.3 * y);
}

scene::TriangleMesh ground_grid(int quads, double size_m, double relief) {
  scene::TriangleMesh mesh;
  for (int j = 0; j <= quads; ++j)
    for (int i = 0; i <= quads; ++i) {
      const double x = size_m * (static_cast<double>(i) / quads - 0.5),
                   y = size_m * (static_cast<double>(j) / quads - 0.5);
      add_point(mesh, {x, y, relief * ground_height(x, y)});
    }
  const auto at = [quads](int i, int j) { return static_cast<std::uint32_t>(j * (quads + 1) + i); };
  for (int j = 0; j < quads; ++j)
    for (int i = 0; i < quads; ++i) {
      add_face(mesh, at(i, j), at(i + 1, j), at(i + 1, j + 1));
      add_face(mesh, at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  return mesh;
}

// Icosahedron with each face cut in four, `levels` times: 20 * 4^levels triangles on the unit sphere.
scene::TriangleMesh icosphere(int levels) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::vector<Point> points{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                            {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<std::array<std::uint32_t, 3>> faces{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                                  {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                                  {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                                  {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [place, fresh] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(points.size()));
      if (fresh)
        points.push_back({0.5 * (points[a][0] + points[b][0]), 0.5 * (points[a][1] + points[b][1]),
                          0.5 * (points[a][2] + points[b][2])});
      return place->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const auto& f : {std::array{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}}) finer.push_back(f);
    }
    faces = std::move(finer);
  }
  scene::TriangleMesh mesh;
  for (const Point& p : points) {
    const double r = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    add_point(mesh, {p[0] / r, p[1] / r, p[2] / r});
  }
  for (const auto& f : faces) add_face(mesh, f[0], f[1], f[2]);
  return mesh;
}

scene::TriangleMesh unit_box() {
  scene::TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) add_point(mesh, {(i & 1) - 0.5, ((i >> 1) & 1) - 0.5, ((i >> 2) & 1) - 0.5});
  for (const auto& q : {std::array{0u, 2u, 3u, 1u},
                        {4u, 5u, 7u, 6u},
                        {0u, 1u, 5u, 4u},
                        {2u, 6u, 7u, 3u},
                        {0u, 4u, 6u, 2u},
                        {1u, 3u, 7u, 5u}}) {
    add_face(mesh, q[0], q[1], q[2]);
    add_face(mesh, q[0], q[2], q[3]);
  }
  return mesh;
}

std::array<double, 12> placed(double x, double y, double z, double yaw, double sx, double sy, double sz) {
  const double c = std::cos(yaw), s = std::sin(yaw);
  return {c * sx, -s * sy, 0, x, s * sx, c * sy, 0, y, 0, 0, sz, z};
}

scene::Instrument camera(const std::string& name, int size, double pixel_m, double height_m, double pitch_deg) {
  scene::Instrument instrument;
  instrument.name = name;
  instrument.pixels = instrument.lines = size;
  // the pixel's size along the boresight's slant range
  const double range_m = height_m / std::cos(base::rad_by_division(pitch_deg));
  instrument.ifov_along_rad = instrument.ifov_across_rad = pixel_m / range_m;
  instrument.poses = {{0, -height_m * std::tan(base::rad_by_division(pitch_deg)), height_m, 0, pitch_deg, 0}};
  return instrument;
}

}  // namespace

void append(scene::TriangleMesh& mesh, const scene::TriangleMesh& other, const std::array<double, 12>& m) {
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const auto& v : other.vertices)
    add_point(mesh, {m[0] * v[0] + m[1] * v[1] + m[2] * v[2] + m[3], m[4] * v[0] + m[5] * v[1] + m[6] * v[2] + m[7],
                     m[8] * v[0] + m[9] * v[1] + m[10] * v[2] + m[11]});
  for (const auto& t : other.triangles) add_face(mesh, base + t[0], base + t[1], base + t[2]);
}

scene::TriangleMesh terrain_mesh() {
  scene::TriangleMesh mesh = ground_grid(450, 400, 1);
  const scene::TriangleMesh sphere = icosphere(2), box = unit_box();
  for (unsigned i = 0; i < 2000; ++i) {
    scene::TriangleMesh bumpy = sphere;
    for (std::size_t k = 0; k < bumpy.vertices.size(); ++k) {
      const float bump = 1.0f + 0.2f * (rc_unit_float(rc_hash(11u, i, static_cast<unsigned>(k), 1u)) - 0.5f);
      for (float& x : bumpy.vertices[k]) x *= bump;
    }
    const double r = 1.2 + 2.6 * random(12, i, 0), x = 390 * (random(12, i, 1) - 0.5),
                 y = 390 * (random(12, i, 2) - 0.5);
    append(mesh, bumpy, placed(x, y, ground_height(x, y) + 0.6 * r, 6.28 * random(12, i, 3), r, r, r));
  }
  for (unsigned i = 0; i < 300; ++i) {
    const double x = 380 * (random(13, i, 0) - 0.5), y = 380 * (random(13, i, 1) - 0.5), h = 2 + 8 * random(13, i, 2);
    append(mesh, box,
           placed(x, y, ground_height(x, y) + 0.4 * h, 6.28 * random(13, i, 3), 2 + 8 * random(13, i, 4),
                  2 + 8 * random(13, i, 5), h));
  }
  return mesh;
}

scene::TriangleMesh bumpy_sphere() {
  scene::TriangleMesh mesh = icosphere(5);
  for (std::size_t k = 0; k < mesh.vertices.size(); ++k) {
    const float r = 2.0f * (1.0f + 0.1f * (rc_unit_float(rc_hash(14u, static_cast<unsigned>(k), 0u, 0u)) - 0.5f));
    for (float& x : mesh.vertices[k]) x *= r;
  }
  return mesh;
}

scene::Instrument terrain_camera() { return camera("terrain", 256, 0.5, 600, 3.4); }

namespace {

/// A square of `leaf_m` at `centre`, turned any way by draws 3 to 5 of an item.
void add_leaf(scene::TriangleMesh& mesh, const Point& centre, double leaf_m, unsigned seed, unsigned item) {
  const double nz = 2 * random(seed, item, 3) - 1, az = 2 * M_PI * random(seed, item, 4),
               turn = 2 * M_PI * random(seed, item, 5);
  const double ns = std::sqrt(1 - nz * nz);
  const Point e1{-std::sin(az), std::cos(az), 0}, e2{-nz * std::cos(az), -nz * std::sin(az), ns};
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int k = 0; k < 4; ++k) {
    const double angle = turn + k * M_PI / 2, c = leaf_m * M_SQRT1_2 * std::cos(angle),
                 s = leaf_m * M_SQRT1_2 * std::sin(angle);
    add_point(mesh, {centre[0] + c * e1[0] + s * e2[0], centre[1] + c * e1[1] + s * e2[1],
                     centre[2] + c * e1[2] + s * e2[2]});
  }
  add_face(mesh, base, base + 1, base + 2);
  add_face(mesh, base, base + 2, base + 3);
}

}  // namespace

scene::TriangleMesh leaf_slab(double layers, double leaf_m, double side_m, double height_m, unsigned seed) {
  scene::TriangleMesh mesh;
  const auto leaves = static_cast<unsigned>(layers * side_m * side_m / (leaf_m * leaf_m));
  for (unsigned i = 0; i < leaves; ++i)
    add_leaf(mesh,
             {side_m * (random(seed, i, 0) - 0.5), side_m * (random(seed, i, 1) - 0.5), height_m * random(seed, i, 2)},
             leaf_m, seed, i);
  return mesh;
}

scene::TriangleMesh crown_mesh(int leaves, double leaf_m, unsigned seed) {
  scene::TriangleMesh mesh;
  for (int i = 0; i < leaves; ++i) {
    const auto item = static_cast<unsigned>(i);
    const double r = 3 * std::cbrt(random(seed, item, 0)), cz = 2 * random(seed, item, 1) - 1,
                 phi = 2 * M_PI * random(seed, item, 2);
    const double sz = std::sqrt(1 - cz * cz);
    const Point centre{r * sz * std::cos(phi), r * sz * std::sin(phi), r * cz};
    add_leaf(mesh, centre, leaf_m, seed, item);
  }
  return mesh;
}

std::vector<std::array<double, 12>> crown_places() {
  std::vector<std::array<double, 12>> places;
  for (unsigned i = 0; i < 100; ++i)
    places.push_back(placed(54 * (random(21, i, 0) - 0.5), 54 * (random(21, i, 1) - 0.5), 4 + 3 * random(21, i, 2),
                            6.28 * random(21, i, 3), 1, 1, 1));
  return places;
}

scene::TriangleMesh crown_ground() { return ground_grid(120, 80, 0.1); }

scene::Instrument crown_camera() { return camera("crowns", 64, 1.0, 600, 3.4); }

scene::CompiledScene compile(const std::vector<scene::TriangleMesh>& meshes,
                             const std::vector<std::vector<std::array<double, 12>>>& places) {
  scene::CompiledScene scene;
  scene.materials.emplace_back();
  scene.materials.back().name = "bench", scene.materials.back().source = "constant, generated";
  scene.materials.back().reflectance = {{0.3, 15.0}, {0.25, 0.25}};
  shared::Surface surface{};
  surface.material[0] = 1;
  surface.fraction[0] = 1;
  scene.surfaces.push_back(surface);
  std::uint32_t id = 0;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const std::uint32_t mesh = scene::append_mesh(scene, "mesh " + std::to_string(i), meshes[i]);
    for (const auto& place : places[i]) scene::append_instance(scene, mesh, place, id++);
  }
  scene::finish_top_tree(scene);
  return scene;
}

}  // namespace raycube::bench
