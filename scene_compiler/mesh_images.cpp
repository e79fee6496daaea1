#include "scene_compiler/mesh_images.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>

#include "host/base/text.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/texel_cut.h"

namespace raycube::scene {
namespace {

using base::Problems;

constexpr double kMostCells = 4e7;
constexpr double kCut_bytes = 210;  ///< of a triangle while the mesh grows: 1.5 times what it takes in the end
constexpr std::uint32_t kCutOut = 0xffffffffu;

/// Middle of a triangle in the two axes that it faces least, m, and whether its sides are longer than `size_m`.
struct Laid {
  double u_m = 0, v_m = 0;
  bool larger = false;
};
Laid laid(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& triangle, double size_m) {
  std::array<std::array<double, 3>, 3> p;
  for (std::size_t k = 0; k < 3; ++k)
    std::copy(mesh.vertices[triangle[k]].begin(), mesh.vertices[triangle[k]].end(), p[k].begin());
  std::array<double, 3> a{}, b{}, normal{};
  for (std::size_t k = 0; k < 3; ++k) a[k] = p[1][k] - p[0][k], b[k] = p[2][k] - p[0][k];
  for (std::size_t k = 0; k < 3; ++k)
    normal[k] = std::abs(a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
  const auto faced = std::max_element(normal.rbegin(), normal.rend());  // z before y before x where they are equal
  const auto axis = static_cast<std::size_t>(normal.rend() - faced) - 1;
  const std::size_t u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
  const auto middle = [&](std::size_t k) { return (p[0][k] + p[1][k] + p[2][k]) / 3; };
  const double longest =
      std::sqrt(std::max(a[0] * a[0] + a[1] * a[1] + a[2] * a[2], b[0] * b[0] + b[1] * b[1] + b[2] * b[2]));
  return {middle(u), middle(v), longest > 2 * size_m};
}

/// Of triangles of families the members that their textures have at their middles, by metres.
void lay_by_metres(const std::string& name, MaterialTable& materials, TriangleMesh& mesh,
                   std::vector<std::string>& notices) {
  std::size_t larger = 0;
  double texel_m = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double size_m = materials.texel_m(mesh.surface[t]);
    if (size_m <= 0) continue;
    const Laid at = laid(mesh, mesh.triangles[t], size_m);
    mesh.surface[t] = materials.at(mesh.surface[t], at.u_m, at.v_m);
    if (at.larger) ++larger, texel_m = size_m;
  }
  if (larger > 0)
    notices.push_back("mesh '" + name + "': " + base::counted(larger, "triangle is", "triangles are") +
                      " longer than two texels of " + number_text(texel_m) +
                      " m, and has the one at its middle; finer triangles show more");
}

TexelCounts texel_counts(const CoordinateImages& images) {
  TexelCounts out;
  for (const Texture* image : {images.texture, images.mask})
    if (image != nullptr) out[0].push_back(image->columns()), out[1].push_back(image->rows());
  if (images.relief != nullptr) out[0].push_back(images.relief->columns()), out[1].push_back(images.relief->rows());
  return out;
}

using Vector = std::array<double, 3>;

Vector across(const Vector& a, const Vector& b, const Vector& c) {
  Vector p{}, q{}, out{};
  for (std::size_t k = 0; k < 3; ++k) p[k] = b[k] - a[k], q[k] = c[k] - a[k];
  for (std::size_t k = 0; k < 3; ++k) out[k] = p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3];
  return out;
}
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Vector& a) { return std::sqrt(dot(a, a)); }

/// The mesh anew, triangle by triangle.
class Cutting {
 public:
  /// has_relief: of a surface.
  Cutting(const TriangleMesh& from, double most_triangles, const std::function<bool(std::uint32_t)>& has_relief)
      : from_(from), most_triangles_(most_triangles) {
    mesh.vertices = from.vertices;
    for (std::size_t t = 0; t < from.triangles.size(); ++t) {
      if (!has_relief(from.surface[t])) continue;
      const auto& at = from.triangles[t];
      const Vector n = across(place(at[0]), place(at[1]), place(at[2]));
      for (const std::uint32_t v : at)
        for (std::size_t k = 0; k < 3; ++k) normals_[from.vertices[v]][k] += n[k];
    }
  }

  void keep(std::size_t triangle) { add(from_.triangles[triangle], from_.surface[triangle], triangle); }

  void cut(std::size_t triangle, const std::array<ImageCorner, 3>& corners, const CoordinateImages& images) {
    const std::uint32_t surface = from_.surface[triangle];
    cut_by_texels(
        corners, texel_counts(images), images.texture == nullptr && images.relief == nullptr,
        [&](double u, double v) {
          if (images.mask != nullptr && images.mask->at(u, v) == 0) return kCutOut;
          return images.texture != nullptr ? images.texture->at(u, v) : 0u;
        },
        [&](const std::vector<ImageCorner>& piece, std::uint32_t number) {
          if (full || number == kCutOut) return;
          std::vector<std::uint32_t> at;
          for (const ImageCorner& corner : piece)
            at.push_back(vertex(corner.position, [&](std::array<float, 3>& placed) {
              if (images.relief != nullptr) placed = lifted(triangle, corners, corner, *images.relief);
            }));
          for (std::size_t k = 2; k < at.size(); ++k)
            add({at[0], at[k - 1], at[k]}, MaterialTable::member(surface, number), triangle);
        });
  }

  TriangleMesh mesh;
  bool full = false;  ///< triangles are missing: there were more than asked for

 private:
  struct Bits {
    std::size_t operator()(const std::array<float, 3>& v) const {
      std::uint64_t h = 0;
      for (const float f : v) h = (h ^ std::bit_cast<std::uint32_t>(f + 0.0f)) * 0x9e3779b97f4a7c15ull, h ^= h >> 29;
      return h;
    }
  };

  Vector place(std::uint32_t vertex) const {
    const auto& v = from_.vertices[vertex];
    return {v[0], v[1], v[2]};
  }

  /// Pieces that meet at a place share its vertex, also where their images do not go on into each other. move: where
  /// that is to lie instead.
  template <class Move>
  std::uint32_t vertex(const std::array<double, 3>& position, Move&& move) {
    std::array<float, 3> rounded{};
    for (std::size_t k = 0; k < 3; ++k) rounded[k] = static_cast<float>(position[k]);
    const auto [entry, fresh] = known_.emplace(rounded, static_cast<std::uint32_t>(mesh.vertices.size()));
    if (fresh) move(rounded), mesh.vertices.push_back(rounded);
    return entry->second;
  }

  /// A place of a triangle, off it by the relief along the normals of its corners, linear between them.
  std::array<float, 3> lifted(std::size_t triangle, const std::array<ImageCorner, 3>& corners, const ImageCorner& at,
                              const Relief& relief) const {
    const auto& c = corners;
    const Vector whole = across(c[0].position, c[1].position, c[2].position);
    const double square = dot(whole, whole);
    Vector n{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double share = dot(across(at.position, c[(k + 1) % 3].position, c[(k + 2) % 3].position), whole) / square;
      const Vector& here = normals_.at(from_.vertices[from_.triangles[triangle][k]]);
      const double size = length(here);
      for (std::size_t i = 0; i < 3 && size > 0; ++i) n[i] += share * here[i] / size;
    }
    double height = relief.at(at.in_image[0], at.in_image[1]);
    if (relief.in_texels()) {
      const auto &p = c[0].in_image, &q = c[1].in_image, &r = c[2].in_image;
      const double texels =
          std::abs((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])) * relief.columns() * relief.rows();
      height *= texels > 0 ? std::sqrt(length(whole) / texels) : 0;
    }
    const double size = length(n);
    std::array<float, 3> out{};
    for (std::size_t k = 0; k < 3; ++k)
      out[k] = static_cast<float>(at.position[k] + (size > 0 ? height * n[k] / size : 0));
    return out;
  }

  void add(const std::array<std::uint32_t, 3>& corners, std::uint32_t surface, std::size_t triangle) {
    const auto& v = mesh.vertices;
    if (zero_area(v[corners[0]], v[corners[1]], v[corners[2]])) return;  // as thin as rounding
    full = full || static_cast<double>(mesh.triangles.size()) >= most_triangles_;
    if (full) return;
    mesh.triangles.push_back(corners);
    mesh.surface.push_back(surface);
    mesh.user_face.push_back(from_.user_face[triangle]);
  }

  const TriangleMesh& from_;
  double most_triangles_;
  std::unordered_map<std::array<float, 3>, std::uint32_t, Bits> known_;  ///< by places before they are lifted
  std::unordered_map<std::array<float, 3>, Vector, Bits> normals_;  ///< of corners with relief: sums of faces, by area
};

/// Corners of a triangle and their places in images; nullopt: the file gives none.
std::optional<std::array<ImageCorner, 3>> image_corners(const MeshFile& file, std::size_t triangle) {
  std::array<ImageCorner, 3> out;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t v = file.mesh.triangles[triangle][k];
    std::copy(file.mesh.vertices[v].begin(), file.mesh.vertices[v].end(), out[k].position.begin());
    std::copy(file.in_image[v].begin(), file.in_image[v].end(), out[k].in_image.begin());
    if (!std::isfinite(out[k].in_image[0]) || !std::isfinite(out[k].in_image[1])) return std::nullopt;
  }
  return out;
}

/// Cuts every triangle whose material has images by coordinates; false after reporting.
bool lay_by_coordinates(const Record& record, const MaterialTable& materials, MeshFile& file, MemorySum& memory,
                        Problems& problems) {
  const auto has_images = [&](std::uint32_t surface) { return materials.images(surface).any(); };
  if (std::none_of(file.mesh.surface.begin(), file.mesh.surface.end(), has_images)) return true;
  const auto whole = static_cast<double>(file.mesh.triangles.size());
  const double most = whole + std::floor(std::max(0.0, memory.left()) / kCut_bytes);
  Cutting cutting(file.mesh, most, [&](std::uint32_t surface) { return materials.images(surface).relief != nullptr; });
  double cells = 0;
  for (std::size_t t = 0; t < file.mesh.triangles.size(); ++t) {
    const CoordinateImages images = materials.images(file.mesh.surface[t]);
    if (!images.any()) {
      cutting.keep(t);
      continue;
    }
    const auto corners = image_corners(file, t);
    if (!corners) {
      problems.add(record.place("file"),
                   "a material's image lies by texture coordinates, and faces have none that are numbers",
                   "face " + std::to_string(file.mesh.user_face[t]) + " of " + record.text("file"),
                   images.mask != nullptr || images.relief != nullptr
                       ? "unwrap the mesh, or use a material without a mask or relief for these faces"
                       : "unwrap the mesh, or give the texture a texel_m");
      return false;
    }
    cells += texel_cells(*corners, texel_counts(images));
    if (cells > kMostCells) {
      problems.add(record.place("file"), "more than 4e7 texels on one mesh",
                   "from face " + std::to_string(file.mesh.user_face[t]) + " on",
                   "give coarser images (gdal_translate -outsize)");
      return false;
    }
    cutting.cut(t, *corners, images);
    if (cutting.full) break;
  }
  const double more = (cutting.full ? most + 1 : static_cast<double>(cutting.mesh.triangles.size())) - whole;
  if (more > 0 && !memory.take(more * (cutting.full ? kCut_bytes : kTriangle_bytes), record.place("file"),
                               std::string(cutting.full ? "more than " : "") + number_text(more) +
                                   " triangles along the texels of its images",
                               "give coarser images (gdal_translate -outsize)", problems))
    return false;
  file.mesh = std::move(cutting.mesh);
  file.in_image.clear();
  if (!file.mesh.triangles.empty()) return true;
  problems.add(record.where, "the mask leaves nothing of mesh '" + record.text("name") + "'", record.text("file"),
               "see the mask's band and 'least', and the mesh's texture coordinates");
  return false;
}

}  // namespace

void lay_images(const Record& record, MaterialTable& materials, MeshFile& file, MemorySum& memory,
                std::vector<std::string>& notices, Problems& problems) {
  // Pieces first: a family's mask belongs to its first member, whose surface its triangles have until then.
  if (lay_by_coordinates(record, materials, file, memory, problems))
    lay_by_metres(record.text("name"), materials, file.mesh, notices);
}

}  // namespace raycube::scene
