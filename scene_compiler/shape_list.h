// The entries of kernels/materials/materials.def as data.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace raycube::scene {

enum class ShapeRole { front, behind, gloss };

struct ShapeParameter {
  std::string_view key, unit, low, high, text;
};

struct ShapeEntry {
  std::uint32_t number;  ///< RC_SHAPE_name
  std::string_view name;
  ShapeRole role;
  bool reciprocal;
  bool conserves;  ///< energy, by itself
  std::string_view text;
  std::vector<ShapeParameter> parameters;  ///< at most six
  bool table = false;                      ///< a material's table of its name asks for it
  int curve_parameter = -1;                ///< which holds the curve's value, of shapes whose form depends on that
};

std::span<const ShapeEntry> shape_entries();

/// 0 <= number < RC_SHAPE_COUNT.
const ShapeEntry& shape_entry(std::uint32_t number);

/// Null: no shape of this name and role.
const ShapeEntry* find_shape(std::string_view name, ShapeRole role);

}  // namespace raycube::scene
