#include "host/run/facet_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "host/base/error.h"
#include "host/run/measure.h"

namespace raycube::run {

namespace {

static_assert(std::endian::native == std::endian::little, "PLY files are written in the machine's own order");

std::array<float, 9> corners_of(const scene::CompiledScene& scene, std::uint32_t primitive) {
  const shared::TriBlock& b = scene.blocks[primitive / RC_BLOCK];
  const std::size_t k = primitive % RC_BLOCK;
  return {b.v0_x[k], b.v0_y[k], b.v0_z[k], b.v1_x[k], b.v1_y[k], b.v1_z[k], b.v2_x[k], b.v2_y[k], b.v2_z[k]};
}

/// Columns of a placement's linear part.
std::array<glm::dvec3, 3> columns_of(const shared::Instance& placed) {
  const shared::rc_float4 &x = placed.world_from_local_0, &y = placed.world_from_local_1,
                          &z = placed.world_from_local_2;
  return {glm::dvec3(x.x, y.x, z.x), glm::dvec3(x.y, y.y, z.y), glm::dvec3(x.z, y.z, z.z)};
}

double area_m2(const std::array<float, 9>& c, const std::array<glm::dvec3, 3>& columns) {
  const auto edge = [&](std::size_t k) {
    glm::dvec3 out{0};
    for (std::size_t axis = 0; axis < 3; ++axis) out += (double{c[3 * k + axis]} - double{c[axis]}) * columns[axis];
    return out;
  };
  return 0.5 * glm::length(glm::cross(edge(1), edge(2)));
}

/// The square of its scale where a placement turns and scales alike in all directions; 0: it does not.
double scale_squared(const std::array<glm::dvec3, 3>& columns) {
  const double square = glm::dot(columns[0], columns[0]);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = i; j < 3; ++j)
      if (std::abs(glm::dot(columns[i], columns[j]) - (i == j ? square : 0)) > 1e-5 * square) return 0;
  return square;
}

constexpr std::size_t kPiece_bytes = std::size_t{1} << 20;

/// Of batches by their sum and sum of squares.
Measured measured_of(double sum, double square, int batches) {
  const double n = batches;
  return {sum / n, std::sqrt(std::max(0.0, (square - sum * sum / n) / (n * (n - 1))))};
}

template <class T>
void append(std::string& to, T value) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  to.append(bytes, sizeof value);
}

}  // namespace

FacetCount::FacetCount(const scene::CompiledScene& scene, const std::vector<std::string>& meshes, std::size_t bands,
                       double cells)
    : scene_(scene), bands_(bands) {
  if (meshes.empty()) return;
  std::vector<std::size_t> of_mesh(scene.meshes.size(), scene.meshes.size());  // place in counted_, or past its end
  place_of_.resize(scene.blocks.size() * RC_BLOCK);
  const scene::MeshTriangles triangles(scene);
  for (const std::string& name : meshes) {
    // Planes and terrains may have a mesh's name; they stand before all of those.
    auto mesh = static_cast<std::uint32_t>(scene.meshes.size());
    while (mesh > 0 && scene.meshes[mesh - 1].name != name) --mesh;
    if (mesh == 0) throw base::Error(base::Fault::bug, "no mesh '" + name + "'");
    --mesh;
    of_mesh[mesh] = counted_.size();
    Counted& counted = counted_.emplace_back();
    counted.name = name, counted.mesh = mesh;
    counted.area_m2.assign(triangles.of(mesh).size(), 0.0);
    counted.batch.assign(counted.area_m2.size() * bands, 0.0);
    counted.sum = counted.square = counted.batch;
    for (std::uint32_t k = 0; k < counted.area_m2.size(); ++k)
      place_of_[triangles.of(mesh)[k]] = {static_cast<std::uint32_t>(of_mesh[mesh]), k};
  }
  constexpr std::array<glm::dvec3, 3> kOwnFrame{glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)};
  std::vector<double> alike(counted_.size(), 0.0);
  for (const scene::Placement& placement : scene::placements(scene)) {
    const std::size_t place = of_mesh[placement.mesh];
    if (place >= counted_.size()) continue;
    const auto columns = columns_of(scene.instances[placement.instance]);
    const double square = scale_squared(columns);
    alike[place] += square / cells;
    for (std::size_t k = 0; square == 0 && k < counted_[place].area_m2.size(); ++k)
      counted_[place].area_m2[k] += area_m2(corners_of(scene, triangles.of(placement.mesh)[k]), columns) / cells;
  }
  for (std::size_t place = 0; place < counted_.size(); ++place)
    for (std::size_t k = 0; k < counted_[place].area_m2.size(); ++k)
      counted_[place].area_m2[k] +=
          alike[place] * area_m2(corners_of(scene, triangles.of(counted_[place].mesh)[k]), kOwnFrame);
}

void FacetCount::add(std::uint32_t primitive, const std::vector<double>& absorbed) {
  const Place& at = place_of_[primitive];
  if (at.counted == RC_NONE) return;
  double* const to = counted_[at.counted].batch.data() + at.triangle * bands_;
  for (std::size_t b = 0; b < bands_; ++b) to[b] += absorbed[b];
}

void FacetCount::end_batch(double per_light) {
  ++batches_;
  for (Counted& counted : counted_)
    for (std::size_t i = 0; i < counted.batch.size(); ++i) {
      const double area_m2 = counted.area_m2[i / bands_];
      const double value = area_m2 > 0 ? counted.batch[i] * per_light / area_m2 : 0;
      counted.sum[i] += value, counted.square[i] += value * value, counted.batch[i] = 0;
    }
}

void FacetCount::write(std::size_t place, const std::vector<std::string>& band_names, base::OutputFile& file) const {
  const Counted& counted = counted_[place];
  const scene::MeshTriangles triangles(scene_);
  const std::size_t count = counted.area_m2.size();
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment light absorbed by a facet's area over "
      "light on level ground, mean over all placed\nelement vertex {}\nproperty float x\n"
      "property float y\nproperty float z\n",
      3 * count);
  for (const std::string& band : band_names)
    out += fmt::format("property float absorbed_{}\nproperty float error_{}\n", band, band);
  out += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n", count);
  const auto put = [&] { file.append(out), out.clear(); };
  for (std::size_t k = 0; k < count; ++k) {
    const std::array<float, 9> corners = corners_of(scene_, triangles.of(counted.mesh)[k]);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      for (std::size_t axis = 0; axis < 3; ++axis) append(out, corners[3 * corner + axis]);
      for (std::size_t b = 0; b < bands_; ++b) {
        const Measured light = measured_of(counted.sum[k * bands_ + b], counted.square[k * bands_ + b], batches_);
        append(out, static_cast<float>(light.mean)), append(out, static_cast<float>(light.error));
      }
    }
    if (out.size() > kPiece_bytes) put();
  }
  for (std::int32_t k = 0; k < static_cast<std::int32_t>(count); ++k) {
    append(out, std::uint8_t{3});
    for (std::int32_t corner = 0; corner < 3; ++corner) append(out, 3 * k + corner);
    if (out.size() > kPiece_bytes) put();
  }
  put();
}

}  // namespace raycube::run
