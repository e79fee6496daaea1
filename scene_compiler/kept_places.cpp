#include "scene_compiler/kept_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace raycube::scene {
namespace {

using Vec = std::array<double, 3>;

constexpr std::size_t kTrianglesLookedAt = 1024;
constexpr double kShareOfSide = 0.1, kShareOfExtent = 0.5;

/// A mesh in its own frame, m.
struct MeshSize {
  Vec low{}, high{};
  double side = 0;  ///< median over triangles of the longest side
};

MeshSize size_of(const TriangleMesh& mesh) {
  MeshSize out;
  out.low.fill(std::numeric_limits<double>::infinity());
  out.high.fill(-std::numeric_limits<double>::infinity());
  for (const auto& vertex : mesh.vertices)
    for (std::size_t i = 0; i < 3; ++i) {
      out.low[i] = std::min(out.low[i], double{vertex[i]});
      out.high[i] = std::max(out.high[i], double{vertex[i]});
    }
  const std::size_t step = std::max<std::size_t>(1, mesh.triangles.size() / kTrianglesLookedAt);
  std::vector<double> sides;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += step) {
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto &a = mesh.vertices[mesh.triangles[t][k]], &b = mesh.vertices[mesh.triangles[t][(k + 1) % 3]];
      longest = std::max(longest, std::hypot(double{a[0]} - b[0], double{a[1]} - b[1], double{a[2]} - b[2]));
    }
    sides.push_back(longest);
  }
  std::nth_element(sides.begin(), sides.begin() + static_cast<std::ptrdiff_t>(sides.size() / 2), sides.end());
  out.side = sides[sides.size() / 2];
  return out;
}

/// The box of a placed mesh: its middle, half its extent along each axis, and how much its longest side
/// grows.
struct PlacedBox {
  Vec middle{}, half{};
  double scale = 0;
};

PlacedBox place(const MeshSize& mesh, const std::array<double, 12>& m) {
  PlacedBox out;
  for (std::size_t i = 0; i < 3; ++i) {
    out.middle[i] = m[4 * i + 3];
    for (std::size_t j = 0; j < 3; ++j) {
      out.middle[i] += m[4 * i + j] * 0.5 * (mesh.low[j] + mesh.high[j]);
      out.half[i] += std::abs(m[4 * i + j]) * 0.5 * (mesh.high[j] - mesh.low[j]);
    }
  }
  for (std::size_t j = 0; j < 3; ++j) out.scale = std::max(out.scale, std::hypot(m[j], m[4 + j], m[8 + j]));
  return out;
}

/// The placement of a mesh whose shadows start farthest off.
struct Worst {
  double off_m = 0;
  PlacedBox box;
};

void judge(const NamedMesh& mesh, const MeshSize& size, const Worst& worst, SceneParts& parts,
           base::Problems& problems) {
  const Vec& half = worst.box.half;
  const double extent = 2 * std::max({half[0], half[1], half[2]}), side = size.side * worst.box.scale;
  const auto there = fmt::format("({:.6g}, {:.6g}, {:.6g}) m", worst.box.middle[0], worst.box.middle[1],
                                 worst.box.middle[2]);
  const auto off = fmt::format("{:.2g} m", worst.off_m);
  const char* way_out = "give coordinates relative to [scene] origin, near the scene's middle";
  if (worst.off_m > kShareOfExtent * extent)
    problems.add(
        mesh.where, "'" + mesh.name + "' is too small for single precision so far from the scene's origin",
        fmt::format("{:.3g} m across at {}, where shadow rays start {} off", extent, there, off), way_out);
  else if (worst.off_m > kShareOfSide * side)
    parts.notices.push_back(fmt::format(
        "{}: '{}' (triangles of {:.2g} m) at {}: so far from the scene's origin single precision starts "
        "shadow rays {} off the surface; {}",
        mesh.where.text(), mesh.name, side, there, off, way_out));
}

}  // namespace

double shadow_start_m(double x_m, double y_m, double z_m) {
  return 16 * std::ldexp(1.0, -24) * (std::abs(x_m) + std::abs(y_m) + std::abs(z_m));
}

void check_kept_places(SceneParts& parts, base::Problems& problems) {
  std::vector<MeshSize> sizes;
  for (const NamedMesh& mesh : parts.meshes)
    sizes.push_back(mesh.mesh.triangles.empty() ? MeshSize{} : size_of(mesh.mesh));
  std::vector<Worst> worst(parts.meshes.size());
  for (const Placed& placed : parts.placed) {
    const PlacedBox box = place(sizes[placed.mesh], placed.scene_from_mesh);
    const Vec& c = box.middle;
    const double off = shadow_start_m(c[0], c[1], c[2]);
    if (off > worst[placed.mesh].off_m) worst[placed.mesh] = {off, box};
  }
  for (std::size_t m = 0; m < worst.size(); ++m)
    if (worst[m].off_m > 0) judge(parts.meshes[m], sizes[m], worst[m], parts, problems);
}

}  // namespace raycube::scene
