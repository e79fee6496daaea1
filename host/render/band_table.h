// The baked band values E[row][channel][band] on the device. Rows are kept by product key and replaced least recently
// used first; which slot a key gets cannot change a result, since terms are summed in key order.
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <vector>

#include "host/cl/buffer.h"
#include "host/plan/plan.h"
#include "host/render/tile_shape.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::render {

/// Rows a band table can come to: every material's, the environment nodes', the path's.
std::size_t most_rows(const plan::Plan& plan);

class BandTable {
 public:
  /// Holds as many rows as `bytes` allow, at least those of one pixel (261). Key 0 (path radiance) is baked at once and
  /// never leaves.
  BandTable(const cl::Context& context, const scene::CompiledScene& scene, const plan::Plan& plan,
            const StageShape& shape, std::size_t bytes);

  std::size_t capacity() const { return capacity_; }  ///< without the skeleton's
  /// First of the rows of light between surfaces, one for each skeleton wavelength; they never leave.
  std::uint32_t skeleton_row() const { return static_cast<std::uint32_t>(capacity_); }
  /// Bakes what is missing of `keys` (ascending, without 0, at most capacity() - 1 of them) and uploads it.
  void ensure(const std::vector<std::uint64_t>& keys);
  /// Row of a key that is in the table.
  std::uint32_t row_of(std::uint64_t key) const { return slots_.at(key).row; }
  /// Keys of what lies in the rows now, the skeleton's included; 0 also of a row that holds nothing.
  std::vector<std::uint64_t> keys_by_row() const;

  const cl::Buffer<float>& values() const { return values_; }
  const cl::Buffer<std::uint64_t>& keys() const { return keys_; }
  const cl::Buffer<std::uint32_t>& rows() const { return rows_; }
  std::uint32_t count() const { return static_cast<std::uint32_t>(slots_.size()); }

 private:
  struct Slot {
    std::uint32_t row;
    std::list<std::uint64_t>::iterator use;
  };
  void bake(std::uint64_t key, std::uint32_t row);
  /// Hands the rows that are baked to the device.
  void write_baked();

  const scene::CompiledScene& scene_;
  const plan::Plan& plan_;
  std::size_t row_floats_, channel_floats_, capacity_;
  std::vector<float> baked_;       ///< rows that follow one another, not yet on the device
  std::uint32_t first_baked_ = 0;  ///< row of the first of them
  cl::Buffer<float> values_;
  cl::Buffer<std::uint64_t> keys_;
  cl::Buffer<std::uint32_t> rows_;
  std::map<std::uint64_t, Slot> slots_;
  std::list<std::uint64_t> use_;  ///< least recently used first; key 0 is not in it
};

}  // namespace raycube::render
