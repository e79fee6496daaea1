#include "scene_compiler/shape_list.h"

#include <algorithm>

#include "kernels/materials/shapes.h"

namespace raycube::scene {

namespace {

std::vector<ShapeEntry> read_entries() {
  std::vector<ShapeEntry> out;
#define RC_SHAPE(name, role, reciprocal, conserves, text) \
  out.push_back({RC_SHAPE_##name, #name, ShapeRole::role, reciprocal != 0, conserves != 0, text, {}});
#define RC_SHAPE_TABLE(name, text, source) out.back().table = true;
#define RC_SHAPE_PARAMETER(name, index, key, unit, low, high, text)         \
  static_assert((index) < 6, #name ": a shape has at most six parameters"); \
  out.back().parameters.push_back({key, unit, low, high, text});
#define RC_SHAPE_CURVE(name, index) out.back().curve_parameter = (index);
#include "kernels/materials/materials.def"
#undef RC_SHAPE
#undef RC_SHAPE_TABLE
#undef RC_SHAPE_PARAMETER
#undef RC_SHAPE_CURVE
  return out;
}

}  // namespace

std::span<const ShapeEntry> shape_entries() {
  static const std::vector<ShapeEntry> entries = read_entries();
  return entries;
}

const ShapeEntry& shape_entry(std::uint32_t number) { return shape_entries()[number]; }

const ShapeEntry* find_shape(std::string_view name, ShapeRole role) {
  const auto entries = shape_entries();
  const auto found = std::find_if(entries.begin(), entries.end(),
                                  [&](const ShapeEntry& entry) { return entry.name == name && entry.role == role; });
  return found == entries.end() ? nullptr : &*found;
}

}  // namespace raycube::scene
