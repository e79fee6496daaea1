#include "tests/support/test_scenes.h"

#include <cmath>
#include <map>

#include "kernels/sampling/sampler.h"

namespace raycube::test {
namespace {

using Point = std::array<float, 3>;

void finish(scene::TriangleMesh& mesh) {
  mesh.surface.assign(mesh.triangles.size(), 0);
  mesh.user_face.resize(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) mesh.user_face[i] = static_cast<std::uint32_t>(i);
}

Point point(double x, double y, double z) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
}

}  // namespace

double unit_random(std::uint32_t seed, std::uint32_t index, std::uint32_t dimension) {
  return rc_unit_float(rc_hash(seed, index, 0, dimension));
}

std::array<double, 12> placement(double yaw, double tilt, double scale, double x, double y, double z) {
  const double c = std::cos(yaw), s = std::sin(yaw), k = std::cos(tilt), m = std::sin(tilt);
  return {scale * c,     -scale * s,    0,          x,  //
          scale * k * s, scale * k * c, -scale * m, y,  //
          scale * m * s, scale * m * c, scale * k,  z};
}

scene::TriangleMesh terrain(int cells, double size) {
  scene::TriangleMesh mesh;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const double x = size * (double(i) / cells - 0.5), y = size * (double(j) / cells - 0.5);
      const double z = 6 * std::sin(x / 23) * std::cos(y / 31) + 0.8 * std::sin(x / 3.1 + y / 4.7) +
                       0.15 * std::sin(x * 1.3) * std::sin(y * 1.7);
      mesh.vertices.push_back(point(x, y, z));
    }
  const auto at = [cells](int i, int j) { return static_cast<std::uint32_t>(j * (cells + 1) + i); };
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  finish(mesh);
  return mesh;
}

scene::TriangleMesh sphere(int levels, double radius, double bump) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::vector<std::array<double, 3>> v{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                       {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<std::array<std::uint32_t, 3>> f{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                              {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                              {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                              {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
    const auto split = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, fresh] =
          middle.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<std::uint32_t>(v.size()));
      if (fresh) v.push_back({(v[a][0] + v[b][0]) / 2, (v[a][1] + v[b][1]) / 2, (v[a][2] + v[b][2]) / 2});
      return it->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& t : f) {
      const std::uint32_t a = split(t[0], t[1]), b = split(t[1], t[2]), c = split(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {t[1], b, a}, {t[2], c, b}, {a, b, c}});
    }
    f = std::move(finer);
  }
  scene::TriangleMesh mesh;
  for (const auto& p : v) {
    const double n = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    const double r =
        radius * (1 + bump * std::sin(7 * p[0] / n) * std::sin(5 * p[1] / n + 1) * std::sin(6 * p[2] / n + 2)) / n;
    mesh.vertices.push_back(point(p[0] * r, p[1] * r, p[2] * r));
  }
  mesh.triangles = f;
  finish(mesh);
  return mesh;
}

scene::TriangleMesh crown(int leaves, double edge, double radius, std::uint32_t seed) {
  scene::TriangleMesh mesh;
  for (int i = 0; i < leaves; ++i) {
    const auto r = [&](std::uint32_t d) { return unit_random(seed, static_cast<std::uint32_t>(i), d); };
    const double rho = radius * std::cbrt(r(0)), cz = 2 * r(1) - 1, phi = 6.283185307179586 * r(2),
                 sz = std::sqrt(1 - cz * cz);
    const double centre[3] = {rho * sz * std::cos(phi), rho * sz * std::sin(phi), rho * cz};
    const double nz = 2 * r(3) - 1, psi = 6.283185307179586 * r(4), spin = 6.283185307179586 * r(5),
                 ns = std::sqrt(1 - nz * nz);
    const double e[3] = {-std::sin(psi), std::cos(psi), 0};
    const double n[3] = {ns * std::cos(psi), ns * std::sin(psi), nz};
    const double f[3] = {n[1] * e[2] - n[2] * e[1], n[2] * e[0] - n[0] * e[2], n[0] * e[1] - n[1] * e[0]};
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int corner = 0; corner < 4; ++corner) {
      const double angle = spin + corner * 1.5707963267948966, c = std::cos(angle) * edge / std::sqrt(2.0),
                   s = std::sin(angle) * edge / std::sqrt(2.0);
      mesh.vertices.push_back(
          point(centre[0] + c * e[0] + s * f[0], centre[1] + c * e[1] + s * f[1], centre[2] + c * e[2] + s * f[2]));
    }
    mesh.triangles.push_back({base, base + 1, base + 2});
    mesh.triangles.push_back({base, base + 2, base + 3});
  }
  finish(mesh);
  return mesh;
}

scene::TriangleMesh triangle_soup(int count, double half, double size, std::uint32_t seed) {
  scene::TriangleMesh mesh;
  for (int i = 0; i < count; ++i) {
    const auto r = [&](std::uint32_t d) { return 2 * unit_random(seed, static_cast<std::uint32_t>(i), d) - 1; };
    const double c[3] = {half * r(0), half * r(1), half * r(2)};
    const double s = size * (0.05 + 0.95 * std::abs(r(3)));
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::uint32_t k = 0; k < 3; ++k)
      mesh.vertices.push_back(point(c[0] + s * r(4 + 3 * k), c[1] + s * r(5 + 3 * k), c[2] + s * r(6 + 3 * k)));
    mesh.triangles.push_back({base, base + 1, base + 2});
  }
  finish(mesh);
  return mesh;
}

scene::TriangleMesh court_lines() {
  scene::TriangleMesh mesh;
  const double half = 0.035, w = 7.5, h = 14, pi = std::acos(-1.0);
  const auto line = [&](double x0, double y0, double x1, double y1) {
    const double length = std::hypot(x1 - x0, y1 - y0), nx = -half * (y1 - y0) / length, ny = half * (x1 - x0) / length;
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Point& p : {point(x0 - nx, y0 - ny, 0), point(x0 + nx, y0 + ny, 0), point(x1 + nx, y1 + ny, 0),
                           point(x1 - nx, y1 - ny, 0)})
      mesh.vertices.push_back(p);
    mesh.triangles.push_back({base, base + 2, base + 1});
    mesh.triangles.push_back({base, base + 3, base + 2});
  };
  const auto arc = [&](double x, double y, double r, double from_deg, double to_deg, std::uint32_t n) {
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const double q : {r - half, r + half})
      for (std::uint32_t k = 0; k <= n; ++k) {
        const double angle = (from_deg + (to_deg - from_deg) * k / n) * pi / 180;
        mesh.vertices.push_back(point(x + q * std::cos(angle), y + q * std::sin(angle), 0));
      }
    for (std::uint32_t k = 0; k < n; ++k) mesh.triangles.push_back({base + k, base + n + 1 + k, base + n + 2 + k});
    for (std::uint32_t k = 0; k < n; ++k) mesh.triangles.push_back({base + k, base + n + 2 + k, base + k + 1});
  };
  for (const double s : {-1.0, 1.0}) {
    line(s * w, -h - half, s * w, h + half);
    line(-w + half, s * h, w - half, s * h);
    line(-2.45, s * (h - 5.8), 2.45, s * (h - 5.8));
    for (const double x : {-2.45, 2.45}) line(x, s * (h - half), x, s * (h - 5.8 + half));
    arc(0, s * (h - 5.8), 1.8, s > 0 ? 180 : 0, s > 0 ? 360 : 180, 24);
    arc(0, s * (h - 1.575), 6.75, s > 0 ? 192 : 12, s > 0 ? 348 : 168, 48);
  }
  line(-w + half, 0, w - half, 0);
  arc(0, 0, 1.8, 0, 360, 48);
  finish(mesh);
  return mesh;
}

scene::CompiledScene single(const scene::TriangleMesh& mesh) {
  scene::CompiledScene scene;
  scene::append_instance(scene, scene::append_mesh(scene, "mesh", mesh), kIdentity, 0);
  scene::finish_top_tree(scene);
  return scene;
}

}  // namespace raycube::test
