// Light that the facets of a mesh absorb, as the mean over all that are placed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/base/output_file.h"
#include "scene_compiler/owner.h"

namespace raycube::run {

/// Of each facet the light absorbed a square metre (of one side's area) over the light that falls on a level square
/// metre, by band. Whatever is placed counts, lit or not.
class FacetCount {
 public:
  /// Of the meshes of these names. cells: how often a cell that repeats is placed, 1 of others.
  FacetCount(const scene::CompiledScene& scene, const std::vector<std::string>& meshes, std::size_t bands,
             double cells);
  bool any() const { return !counted_.empty(); }
  /// Light absorbed at a hit, by band.
  void add(std::uint32_t primitive, const std::vector<double>& absorbed);
  /// Ends a batch. per_light: one over the light that fell onto a square metre in it.
  void end_batch(double per_light);
  /// The mesh of the place'th name as a binary PLY of triangles that share no corners: absorbed and error of each band
  /// at all three, which viewers colour meshes by. band_names: of the properties.
  void write(std::size_t place, const std::vector<std::string>& band_names, base::OutputFile& file) const;

 private:
  struct Counted {
    std::string name;
    std::uint32_t mesh = 0;
    std::vector<double> area_m2;             ///< [triangle]: over all placements of a cell
    std::vector<double> batch, sum, square;  ///< [triangle][band]
  };
  const scene::CompiledScene& scene_;
  std::size_t bands_;
  int batches_ = 0;
  std::vector<Counted> counted_;
  struct Place {
    std::uint32_t counted = RC_NONE, triangle = 0;
  };
  std::vector<Place> place_of_;  ///< [primitive]
};

}  // namespace raycube::run
