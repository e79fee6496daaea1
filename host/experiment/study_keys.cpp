#include "host/experiment/study_keys.h"

#include <array>

namespace raycube::experiment {
namespace {

using scene::KeySpec;
using scene::TableSpec;

// Rows of keys.
#define RC_TABLE(path, text)
#define RC_KEY(table, key, type, unit, fallback, low, high, shape, text) \
  {table, key, type, unit, fallback, low, high, shape, text},
constexpr auto kExperimentKeys = [] {
  using enum scene::KeyType;
  return std::to_array<KeySpec>({
#include "host/experiment/keys_experiment.def"
  });
}();
constexpr auto kSweepKeys = [] {
  using enum scene::KeyType;
  return std::to_array<KeySpec>({
#include "host/experiment/keys_sweep.def"
  });
}();
#undef RC_TABLE
#undef RC_KEY

// Rows of tables.
#define RC_TABLE(path, text) {path, text},
#define RC_KEY(table, key, type, unit, fallback, low, high, shape, text)
constexpr auto kExperimentTables = std::to_array<TableSpec>({
#include "host/experiment/keys_experiment.def"
});
constexpr auto kSweepTables = std::to_array<TableSpec>({
#include "host/experiment/keys_sweep.def"
});
#undef RC_TABLE
#undef RC_KEY

}  // namespace

const scene::FileFormat& experiment_format() {
  static const scene::FileFormat format = {"raycube experiment file", kExperimentKeys, kExperimentTables};
  return format;
}

const scene::FileFormat& sweep_format() {
  static const scene::FileFormat format = {"raycube sweep file", kSweepKeys, kSweepTables};
  return format;
}

}  // namespace raycube::experiment
