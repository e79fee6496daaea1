#include "scene_compiler/compiled_file.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <type_traits>

#include "host/base/error.h"
#include "host/base/input_file.h"
#include "host/base/output_file.h"
#include "host/base/sha256.h"
#include "kernels/shared/product_key.h"
#include "scene_compiler/measured_file.h"
#include "scene_compiler/shape_list.h"
#include "scene_compiler/skyline.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::scene {
namespace {

using base::Error;
using base::Fault;

// File: magic (16 bytes), version, byte-order mark, payload bytes (u64); payload = content, then source
// texts; SHA-256 of everything before it (32 bytes). A vector is its count (u64) and its elements; structs
// are those of kernels/shared.
constexpr char kMagic[16] = "RAYCUBE-SCENE\n\0";
constexpr std::uint32_t kByteOrderMark = 0x01020304;
constexpr std::size_t kHeaderBytes = 32, kTrailerBytes = 32;

/// Feeds bytes to a function: the hash, a byte counter or the file.
template <class Add>
class Writer {
 public:
  explicit Writer(Add add) : add_(std::move(add)) {}
  void raw(const void* data, std::size_t bytes) {
    if (bytes > 0) add_(data, bytes);
  }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void operator()(const T& value) { raw(&value, sizeof(T)); }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void operator()(const std::vector<T>& values) {
    (*this)(static_cast<std::uint64_t>(values.size()));
    raw(values.data(), values.size() * sizeof(T));
  }
  void operator()(const std::string& text) {
    (*this)(static_cast<std::uint64_t>(text.size()));
    raw(text.data(), text.size());
  }

 private:
  Add add_;
};

/// Reads from a buffer and refuses to pass its end; counts are checked before anything is allocated.
class Reader {
 public:
  Reader(const char* data, std::size_t bytes, std::string file) : data_(data), left_(bytes), file_(std::move(file)) {}
  void raw(void* out, std::size_t bytes) {
    if (bytes > left_) damaged("ends inside a field");
    if (bytes > 0) std::memcpy(out, data_, bytes);
    data_ += bytes;
    left_ -= bytes;
  }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void operator()(T& value) { raw(&value, sizeof(T)); }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void operator()(std::vector<T>& values) {
    values.resize(count(sizeof(T)));
    raw(values.data(), values.size() * sizeof(T));
  }
  void operator()(std::string& text) {
    text.resize(count(1));
    raw(text.data(), text.size());
  }
  std::size_t count(std::size_t element_bytes) {
    std::uint64_t n = 0;
    (*this)(n);
    if (n > left_ / element_bytes)
      damaged("has a count of " + std::to_string(n) + " where " + std::to_string(left_) + " bytes are left");
    return static_cast<std::size_t>(n);
  }
  std::size_t left() const { return left_; }
  [[noreturn]] void damaged(const std::string& what) const {
    throw Error(Fault::input,
                file_ + ": compiled scene is damaged: it " + what + "; compile it again with raycube scene compile");
  }

 private:
  const char* data_;
  std::size_t left_;
  std::string file_;
};

template <class Archive, class Scene>
void archive_content(Archive& ar, Scene& scene) {
  ar(scene.origin.epsg);
  ar(scene.origin.easting_m);
  ar(scene.origin.northing_m);
  ar(scene.origin.height_m);
  for (auto& material : scene.materials) {
    ar(material.name);
    ar(material.reflectance.wavelength_um);
    ar(material.reflectance.value);
    ar(material.transmittance.wavelength_um);
    ar(material.transmittance.value);
    ar(material.temperature_K);
  }
  ar(scene.surfaces);
  for (auto& mesh : scene.meshes) {
    ar(mesh.name);
    ar(mesh.tree);
    ar(mesh.placed_after);
    ar(mesh.lo);
    ar(mesh.hi);
    ar(mesh.user_face);
  }
  for (auto& tree : scene.trees) {
    ar(tree.meshes);
    ar(tree.root);
    ar(tree.first_block);
    ar(tree.block_count);
    ar(tree.triangle_count);
    ar(tree.depth);
    ar(tree.lo);
    ar(tree.hi);
  }
  ar(scene.instances);
  ar(scene.nodes);
  ar(scene.blocks);
  ar(scene.top_depth);
  ar(scene.lo);
  ar(scene.hi);
}

/// Ways of transmission, gloss and volumes.
template <class Archive, class Scene>
void archive_pulse_matter(Archive& ar, Scene& scene) {
  for (auto& material : scene.materials) {
    std::uint32_t way = material.behind.number == RC_SHAPE_plate ? 1 : 0;
    ar(way);
    if constexpr (!std::is_const_v<Scene>) {
      if (way > 1) ar.damaged("has a material with an unknown way of transmission");
      material.behind.number = way == 1 ? RC_SHAPE_plate : RC_SHAPE_leaf;
    }
    auto gloss = material.gloss.parameter;
    for (auto& value : gloss) ar(value);
    if constexpr (!std::is_const_v<Scene>)
      if (gloss[0] > 0) material.gloss = {RC_SHAPE_gloss, gloss};
  }
  for (auto& volume : scene.volumes) {
    ar(volume.shape);
    ar(volume.name);
    ar(volume.position_m);
    ar(volume.size_m);
    ar(volume.yaw_deg);
    ar(volume.gas);
    ar(volume.concentration_ppm);
    ar(volume.cells);
    ar(volume.values);
    for (auto* value : {&volume.source_g_s, &volume.wind_m_s, &volume.release_height_m, &volume.molar_mass_g,
                        &volume.sigma_y_a, &volume.sigma_y_b, &volume.sigma_z_a, &volume.sigma_z_b, &volume.sigma_y_m,
                        &volume.sigma_z_m, &volume.length_m, &volume.extinction_per_m, &volume.lidar_ratio_sr})
      ar(*value);
    ar(volume.wavelength_um);
    ar(volume.cross_section_cm2);
  }
}

/// How materials reflect, by the shapes' names: their numbers follow the list's order.
template <class Archive, class Scene>
void archive_shapes(Archive& ar, Scene& scene) {
  for (auto& material : scene.materials) {
    std::string name(shape_entry(material.front.number).name);
    ar(name);
    if constexpr (!std::is_const_v<Scene>) {
      const ShapeEntry* entry = find_shape(name, ShapeRole::front);
      if (entry == nullptr) ar.damaged("has a material of an unknown shape '" + name + "'");
      material.front.number = entry->number;
    }
    for (auto& value : material.front.parameter) ar(value);
  }
}

/// Which materials are one family.
template <class Archive, class Scene>
void archive_families(Archive& ar, Scene& scene) {
  std::uint32_t place = 0;
  for (auto& material : scene.materials) {
    ar(material.in_family);
    if constexpr (!std::is_const_v<Scene>)
      if (material.in_family != 0 && (&material == scene.materials.data() || material.in_family != place))
        ar.damaged("has a family whose members do not follow one another");
    place = material.in_family + 1;
  }
}

/// The table of a shape that has one.
template <class Archive, class Shape>
void archive_table(Archive& ar, Shape& shape) {
  std::vector<float> numbers;
  if (shape.table) numbers = *shape.table;
  ar(numbers);
  if constexpr (!std::is_const_v<Shape>) {
    if (numbers.empty() == (shape.number == RC_SHAPE_measured) || !(numbers.empty() || is_measured_table(numbers)))
      ar.damaged("has a measured shape whose table does not fit");
    shape.table = numbers.empty() ? nullptr : std::make_shared<const std::vector<float>>(std::move(numbers));
  }
}

/// Shapes of gloss by their names.
template <class Archive, class Material>
void archive_gloss_name(Archive& ar, Material& material) {
  const bool has = material.gloss.number != RC_SHAPE_none;
  std::string name(has ? shape_entry(material.gloss.number).name : "");
  ar(name);
  if constexpr (!std::is_const_v<Material>) {
    const ShapeEntry* entry = find_shape(name, ShapeRole::gloss);
    if (has != (entry != nullptr)) ar.damaged("has a gloss of an unknown shape '" + name + "'");
    if (has) material.gloss.number = entry->number;
  }
}

/// Shapes that change with wavelength, and what else shapes have.
template <class Archive, class Scene>
void archive_nodes(Archive& ar, Scene& scene) {
  for (auto& material : scene.materials) {
    archive_gloss_name(ar, material);
    archive_table(ar, material.front);
    for (const bool gloss : {false, true}) {
      auto& nodes = gloss ? material.gloss_nodes : material.front_nodes;
      const auto& first = gloss ? material.gloss : material.front;
      auto count = static_cast<std::uint32_t>(nodes.size());
      ar(count);
      if constexpr (!std::is_const_v<Scene>) {
        if (count > RC_MOST_NODES) ar.damaged("has a shape at too many wavelengths");
        nodes.assign(count, {0, first});
      }
      for (auto& node : nodes) {
        ar(node.wavelength_um);
        for (auto& value : node.shape.parameter) ar(value);
        archive_table(ar, node.shape);
      }
    }
    for (auto* curve : {&material.index_n, &material.index_k}) {
      ar(curve->wavelength_um);
      ar(curve->value);
    }
    if constexpr (!std::is_const_v<Scene>) {
      if (material.index_n.value.size() != material.index_n.wavelength_um.size() ||
          material.index_k.value.size() != material.index_n.value.size())
        ar.damaged("has a refractive index whose arrays do not fit");
      const auto behind = [](const ShapeNode& a, const ShapeNode& b) { return !(a.wavelength_um < b.wavelength_um); };
      const bool by_values = shape_entry(material.front.number).curve_parameter >= 0;
      if (by_values && material.front_nodes.empty() && !material.reflectance.value.empty())
        ar.damaged("has a shape without the values of its curve");
      if (material.gloss.number == RC_SHAPE_none && !(material.gloss_nodes.empty() && material.index_n.value.empty()))
        ar.damaged("has wavelengths or an index of a gloss that it does not have");
      for (const auto* nodes : {&material.front_nodes, &material.gloss_nodes})
        if (!(by_values && nodes == &material.front_nodes) &&
            std::adjacent_find(nodes->begin(), nodes->end(), behind) != nodes->end())
          ar.damaged("has a shape whose wavelengths do not ascend");
      make_lobes(material);
    }
  }
}

bool has_nodes(const CompiledScene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& material) {
    const bool plain_gloss = material.gloss.number == RC_SHAPE_none || material.gloss.number == RC_SHAPE_gloss;
    return !material.front_nodes.empty() || !material.gloss_nodes.empty() || !material.index_n.value.empty() ||
           !plain_gloss || material.front.table != nullptr;
  });
}

bool has_families(const CompiledScene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(),
                     [](const Material& material) { return material.in_family != 0; });
}

bool has_shapes(const CompiledScene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(),
                     [](const Material& material) { return material.front.number != RC_SHAPE_lambert; });
}

bool has_pulse_matter(const CompiledScene& scene) {
  return !scene.volumes.empty() ||
         std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& material) {
           return material.behind.number != RC_SHAPE_leaf || material.gloss.number != RC_SHAPE_none;
         });
}

template <class Add>
void write_content(const CompiledScene& scene, Add add) {
  Writer<Add> writer(std::move(add));
  writer(static_cast<std::uint64_t>(scene.materials.size()));
  writer(static_cast<std::uint64_t>(scene.meshes.size()));
  writer(static_cast<std::uint64_t>(scene.trees.size()));
  archive_content(writer, scene);
}

template <class Add>
void write_pulse_matter(const CompiledScene& scene, Add add) {
  Writer<Add> writer(std::move(add));
  writer(static_cast<std::uint64_t>(scene.volumes.size()));
  archive_pulse_matter(writer, scene);
}

template <class Add>
void write_payload(const CompiledScene& scene, Add add) {
  write_content(scene, add);
  write_pulse_matter(scene, add);
  Writer<Add> writer(add);
  archive_shapes(writer, scene);
  archive_families(writer, scene);
  archive_nodes(writer, scene);
  for (const auto& material : scene.materials) writer(material.source), writer(material.las_class);
}

std::string read_file(const std::string& file) {
  base::refuse_other_than_plain(file);
  std::error_code error;
  const auto bytes = std::filesystem::file_size(file, error);
  std::ifstream stream(file, std::ios::binary);
  if (error || !stream) throw Error(Fault::input, file + ": cannot read compiled scene; check the path");
  std::string data(bytes, '\0');
  stream.read(data.data(), static_cast<std::streamsize>(bytes));
  data.resize(static_cast<std::size_t>(stream.gcount()));
  return data;
}

/// A tree's arrays, and that each of its triangles has an owner.
void check_tree(const CompiledScene& scene, const Tree& tree, const Reader& reader) {
  if (tree.root >= scene.nodes.size() || std::uint64_t{tree.first_block} + tree.block_count > scene.blocks.size())
    reader.damaged("has a tree outside its arrays");
  std::map<std::uint32_t, std::size_t> triangles;  // of the mesh placed so far behind the first
  for (const auto mesh : tree.meshes) {
    if (mesh >= scene.meshes.size()) reader.damaged("has a tree of an unknown mesh");
    const Mesh& placed = scene.meshes[mesh];
    if (!(triangles.empty() ? placed.placed_after == 0 : placed.placed_after > triangles.rbegin()->first))
      reader.damaged("has a tree whose meshes are not in the order of their places");
    triangles[placed.placed_after] = placed.user_face.size();
  }
  for (std::uint32_t b = tree.first_block; b < tree.first_block + tree.block_count; ++b)
    for (std::uint32_t lane = 0; lane < RC_BLOCK; ++lane) {
      const shared::TriBlock& block = scene.blocks[b];
      if (block.surface[lane] == RC_NONE) continue;
      const auto mesh = triangles.find(block.placed_after[lane]);
      if (mesh == triangles.end() || block.triangle[lane] >= mesh->second)
        reader.damaged("has a triangle of an unknown mesh");
    }
}

/// References inside the arrays; a file whose hash is right was written so, but a foreign writer may have
/// erred.
void check_references(const CompiledScene& scene, const Reader& reader) {
  for (const auto& tree : scene.trees) check_tree(scene, tree, reader);
  for (const auto& mesh : scene.meshes)
    if (mesh.tree >= scene.trees.size()) reader.damaged("has a mesh outside its arrays");
  for (const auto& instance : scene.instances)
    if (instance.tree >= scene.trees.size() || instance.root >= scene.nodes.size())
      reader.damaged("has an instance outside its arrays");
  for (const auto& surface : scene.surfaces)
    for (const auto material : surface.material)
      if (material > scene.materials.size()) reader.damaged("has a surface of an unknown material");
  for (const auto& volume : scene.volumes) {
    const bool known = volume.shape == Volume::Shape::box || volume.shape == Volume::Shape::grid ||
                       volume.shape == Volume::Shape::plume;
    const std::int64_t cells =
        volume.shape == Volume::Shape::grid ? std::int64_t{volume.cells[0]} * volume.cells[1] * volume.cells[2] : 0;
    if (!known || volume.values.size() != static_cast<std::size_t>(cells) ||
        volume.wavelength_um.size() != volume.cross_section_cm2.size())
      reader.damaged("has a volume whose arrays do not fit");
  }
  for (const auto& block : scene.blocks)
    for (const auto surface : block.surface)
      if (surface != RC_NONE && surface >= scene.surfaces.size())
        reader.damaged("has a triangle of an unknown surface");
}

}  // namespace

std::string content_hash(const CompiledScene& scene) {
  base::Sha256 hash;
  const auto add = [&hash](const void* data, std::size_t bytes) { hash.add(data, bytes); };
  write_content(scene, add);
  // A scene that only instruments look at keeps the hash it always had.
  if (has_pulse_matter(scene)) write_pulse_matter(scene, add);
  if (has_shapes(scene)) {
    Writer<decltype(add)> writer(add);
    archive_shapes(writer, scene);
  }
  if (has_families(scene)) {
    Writer<decltype(add)> writer(add);
    archive_families(writer, scene);
  }
  if (has_nodes(scene)) {
    Writer<decltype(add)> writer(add);
    archive_nodes(writer, scene);
  }
  for (std::size_t i = 0; i < scene.materials.size(); ++i)  // of those that have one
    if (const std::int32_t of[] = {static_cast<std::int32_t>(i), scene.materials[i].las_class}; of[1] != 1)
      add(of, sizeof of);
  return hash.hex();
}

void save_compiled(const CompiledScene& scene, const std::string& file, bool overwrite) {
  static_assert(std::endian::native == std::endian::little, "the file's byte order is the host's: little endian");
  std::uint64_t payload_bytes = 0;
  write_payload(scene, [&](const void*, std::size_t bytes) { payload_bytes += bytes; });
  base::OutputFile out(file, overwrite ? base::IfExists::replace : base::IfExists::refuse);
  base::Sha256 hash;
  std::string buffer;  // small fields are gathered: each append is a system call
  const auto flush = [&] {
    out.append(buffer);
    buffer.clear();
  };
  const auto add = [&](const void* data, std::size_t bytes) {
    hash.add(data, bytes);
    if (buffer.size() + bytes > (1u << 20)) flush();
    if (bytes > (1u << 20))
      out.append(data, bytes);
    else
      buffer.append(static_cast<const char*>(data), bytes);
  };
  add(kMagic, sizeof kMagic);
  add(&kCompiledFileVersion, sizeof kCompiledFileVersion);
  add(&kByteOrderMark, sizeof kByteOrderMark);
  add(&payload_bytes, sizeof payload_bytes);
  write_payload(scene, add);
  const auto digest = hash.digest();
  buffer.append(reinterpret_cast<const char*>(digest.data()), digest.size());
  flush();
  out.publish();
}

CompiledScene load_compiled(const std::string& file) {
  const std::string data = read_file(file);
  if (data.empty())
    throw Error(Fault::input, file + ": file is empty (0 bytes); compile the scene again with raycube scene compile");
  if (data.size() < sizeof kMagic || std::memcmp(data.data(), kMagic, sizeof kMagic) != 0)
    throw Error(Fault::input, file +
                                  ": not a compiled scene (its first bytes are not RAYCUBE-SCENE); compile "
                                  "one with raycube scene compile");
  Reader header(data.data() + sizeof kMagic, data.size() - sizeof kMagic, file);
  std::uint32_t version = 0, order = 0;
  std::uint64_t payload_bytes = 0;
  header(version);
  header(order);
  if (order != kByteOrderMark)
    throw Error(Fault::input, file + ": compiled scene has another byte order; compile it on this machine");
  if (version != kCompiledFileVersion)
    throw Error(Fault::input, file + ": compiled scene has version " + std::to_string(version) +
                                  ", this program reads " + std::to_string(kCompiledFileVersion) +
                                  "; compile it again with raycube scene compile");
  header(payload_bytes);
  if (header.left() < kTrailerBytes || payload_bytes != header.left() - kTrailerBytes)
    header.damaged("has " + std::to_string(data.size()) + " bytes and should have " + std::to_string(payload_bytes) +
                   " + " + std::to_string(kHeaderBytes + kTrailerBytes));
  const auto digest = base::Sha256().add(data.data(), data.size() - kTrailerBytes).digest();
  if (std::memcmp(digest.data(), data.data() + data.size() - kTrailerBytes, kTrailerBytes) != 0)
    header.damaged("does not have the SHA-256 it carries");

  CompiledScene scene;
  Reader reader(data.data() + kHeaderBytes, static_cast<std::size_t>(payload_bytes), file);
  std::uint64_t materials = 0, meshes = 0, trees = 0;
  reader(materials);
  reader(meshes);
  reader(trees);
  // Each of them takes at least its counts: no huge allocation from a small file.
  if (materials > reader.left() / 48 || meshes > reader.left() / 48 || trees > reader.left() / 48)
    reader.damaged("has impossible counts");
  scene.materials.resize(static_cast<std::size_t>(materials));
  scene.meshes.resize(static_cast<std::size_t>(meshes));
  scene.trees.resize(static_cast<std::size_t>(trees));
  archive_content(reader, scene);
  std::uint64_t volumes = 0;
  reader(volumes);
  if (volumes > reader.left() / 200) reader.damaged("has impossible counts");
  scene.volumes.resize(static_cast<std::size_t>(volumes));
  archive_pulse_matter(reader, scene);
  archive_shapes(reader, scene);
  archive_families(reader, scene);
  archive_nodes(reader, scene);
  for (auto& material : scene.materials) reader(material.source), reader(material.las_class);
  if (reader.left() != 0) reader.damaged("has bytes left over");
  check_references(scene, reader);
  scene.skyline = survey_skyline(scene, 0);
  scene.content_hash = content_hash(scene);
  return scene;
}

}  // namespace raycube::scene
