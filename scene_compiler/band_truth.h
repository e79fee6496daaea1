// The entries of scene_compiler/band_truth.def as data.
#pragma once

#include <string>
#include <string_view>

namespace raycube::scene {

/// Numbers of the entries.
enum class BandTruth {
#define RC_BAND_TRUTH(name, kind, unit, text) name,
#include "scene_compiler/band_truth.def"
#undef RC_BAND_TRUTH
};

enum class BandTruthKind { part, surface, way };

struct BandTruthEntry {
  std::string_view name;
  BandTruthKind kind;
  std::string_view unit, text;
  /// Of the cube, without ".img".
  std::string file() const { return (kind == BandTruthKind::part ? "radiance_" : "") + std::string(name); }
};

inline constexpr BandTruthEntry kBandTruth[] = {
#define RC_BAND_TRUTH(name, kind, unit, text) {#name, BandTruthKind::kind, unit, text},
#include "scene_compiler/band_truth.def"
#undef RC_BAND_TRUTH
};

constexpr const BandTruthEntry& band_truth_entry(BandTruth truth) { return kBandTruth[static_cast<int>(truth)]; }

}  // namespace raycube::scene
