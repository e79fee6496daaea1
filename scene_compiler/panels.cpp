#include "scene_compiler/panels.h"

#include <algorithm>
#include <cmath>

#include "host/base/units.h"

namespace raycube::scene {
namespace {

using Vector = std::array<double, 3>;

/// Cuts one side into squares from its low end; the last one may be cut.
std::vector<double> edges(double size_m, double cell_m) {
  std::vector<double> out;
  // A millionth of a cell left over is rounding, not a square.
  const auto count = cell_m > 0 ? static_cast<std::size_t>(std::max(1.0, std::ceil(size_m / cell_m - 1e-6))) : 1;
  for (std::size_t i = 0; i < count; ++i) out.push_back(-0.5 * size_m + static_cast<double>(i) * cell_m);
  out.push_back(0.5 * size_m);
  return out;
}

/// Rectangle spanned by axes u and v (unit) about a centre, facing u x v; squares from the corner -u, -v. held: its
/// edges are not lifted.
void add_rectangle(TriangleMesh& mesh, const Vector& center, const Vector& u, const Vector& v, double size_u,
                   double size_v, const Cut& cut, bool held) {
  const auto us = edges(size_u, cut.cell_m), vs = edges(size_v, cut.cell_m);
  const Vector n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  const auto lifted_m = [&](double a, double b) {
    const bool edge = a == us.front() || a == us.back() || b == vs.front() || b == vs.back();
    return !cut.height_m || (held && edge) ? 0.0 : cut.height_m(a - us.front(), b - vs.front());
  };
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto width = static_cast<std::uint32_t>(us.size());
  for (const double b : vs)
    for (const double a : us) {
      std::array<float, 3> point;
      const double h = lifted_m(a, b);
      for (std::size_t k = 0; k < 3; ++k) point[k] = static_cast<float>(center[k] + a * u[k] + b * v[k] + h * n[k]);
      mesh.vertices.push_back(point);
    }
  for (std::uint32_t j = 0; j + 1 < vs.size(); ++j)
    for (std::uint32_t i = 0; i + 1 < width; ++i) {
      const std::uint32_t sw = first + j * width + i, se = sw + 1, nw = sw + width, ne = nw + 1;
      const auto face = mesh.user_face.empty() ? 0u : mesh.user_face.back() + 1;
      const std::uint32_t surface = cut.surface(i, j);
      for (const auto& triangle : {std::array{sw, se, ne}, std::array{sw, ne, nw}}) {
        mesh.triangles.push_back(triangle);
        mesh.surface.push_back(surface);
        mesh.user_face.push_back(face);
      }
    }
}

}  // namespace

std::array<double, 3> turned(const std::array<double, 3>& local, double yaw_deg) {
  const double yaw = base::rad_by_division(yaw_deg), c = std::cos(yaw), s = std::sin(yaw);
  return {c * local[0] + s * local[1], -s * local[0] + c * local[1], local[2]};
}

std::array<double, 12> placement(const std::array<double, 3>& position_m, double yaw_deg, double scale) {
  const Vector x = turned({scale, 0, 0}, yaw_deg), y = turned({0, scale, 0}, yaw_deg);
  return {x[0], y[0], 0, position_m[0], x[1], y[1], 0, position_m[1], 0, 0, scale, position_m[2]};
}

TriangleMesh plane_mesh(const std::array<double, 3>& position_m, const std::array<double, 2>& size_m, double yaw_deg,
                        double tilt_deg, const Cut& cut) {
  const double tilt = base::rad_by_division(tilt_deg);
  TriangleMesh mesh;
  add_rectangle(mesh, position_m, turned({1, 0, 0}, yaw_deg), turned({0, std::cos(tilt), -std::sin(tilt)}, yaw_deg),
                size_m[0], size_m[1], cut, false);
  return mesh;
}

TriangleMesh box_mesh(const std::array<double, 3>& position_m, const std::array<double, 3>& size_m, double yaw_deg,
                      const std::array<Cut, 6>& faces) {
  const Vector x = turned({1, 0, 0}, yaw_deg), y = turned({0, 1, 0}, yaw_deg), z{0, 0, 1};
  const auto minus = [](const Vector& v) { return Vector{-v[0], -v[1], -v[2]}; };
  const auto at = [&](double dx, double dy, double dz) {
    Vector out = position_m;
    for (std::size_t k = 0; k < 3; ++k) out[k] += dx * x[k] + dy * y[k] + dz * z[k];
    return out;
  };
  const double w = size_m[0], l = size_m[1], h = size_m[2];
  TriangleMesh mesh;
  const auto side = [&](BoxFace face, const Vector& center, const Vector& u, const Vector& v, double size_u,
                        double size_v) { add_rectangle(mesh, center, u, v, size_u, size_v, faces[face], true); };
  side(kTop, at(0, 0, h), x, y, w, l);
  side(kBottom, at(0, 0, 0), minus(x), y, w, l);
  side(kNorth, at(0, l / 2, h / 2), minus(x), z, w, h);
  side(kSouth, at(0, -l / 2, h / 2), x, z, w, h);
  side(kEast, at(w / 2, 0, h / 2), y, z, l, h);
  side(kWest, at(-w / 2, 0, h / 2), minus(y), z, l, h);
  return mesh;
}

}  // namespace raycube::scene
