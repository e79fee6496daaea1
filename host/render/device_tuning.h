// The device of a render and the sizes of its launches: as `raycube tune` found and kept them for that device, else the
// defaults. None of them can change a bit of a result; what could (how bundles split, when single rays take over) is a
// constant of the kernels.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "host/base/output_file.h"
#include "host/cl/device.h"
#include "host/cl/launch_sizes.h"

namespace raycube::render {

struct RenderOptions;

/// Samples of a tile past which a launch gains nothing. A GPU wants them all in one launch, as --memory allows: an item
/// is a group of pixels, and the park's 25 600 groups of 233 samples by 2^21 at a time keep 17 of 132 units at work.
inline constexpr std::size_t kTileSamples = std::size_t{1} << 27;
/// The same of a CPU, which a few hundred work-items keep busy: smaller tiles let writing overlap tracing, fewer pages
/// are fresh (65536 pixels of 64 samples and 360 bands: 5 % less than by tiles of 2^21), and memory that does not help
/// is not taken (with it, 961 samples a pixel would need more than 16 as long as the budget lasts).
inline constexpr std::size_t kCpuTileSamples = std::size_t{1} << 19;

struct DeviceTuning {
  cl::LaunchSizes sizes;
  std::size_t tile_samples = kTileSamples;
  bool tuned = false;  ///< found by `raycube tune`
};

/// What is used on a device where nothing was tuned.
DeviceTuning default_tuning(const cl::DeviceInfo& device);

/// Where the sizes found for a device are kept, by its name, vendor, driver and compute units and by the kernels'
/// sources: what was found for other kernels says nothing of these. Empty when the user has no home.
std::filesystem::path tuning_file(const cl::DeviceInfo& device);

/// What `raycube tune` kept; nothing when it never ran here or the file cannot be read (a cache: then the defaults
/// serve).
std::optional<DeviceTuning> read_tuning(const cl::DeviceInfo& device);

/// The file to be, claimed before anything is timed. Throws Error(environment) when the user has no home or may not
/// write there.
base::OutputFile claim_tuning(const cl::DeviceInfo& device);

/// Keeps sizes there; those of kernels that the file had and `tuning` has not stay.
void keep_tuning(const cl::DeviceInfo& device, const DeviceTuning& tuning, base::OutputFile& file);

/// Member "launches" of run.json, as JSON text.
std::string tuning_json(const DeviceTuning& tuning);

/// The device that the options ask for; of a CPU, as many threads. Throws as cl::find_device.
cl::Device pick_device(const RenderOptions& options);

/// The options' own sizes, else what was kept if they say so, else the defaults.
DeviceTuning tuning_for(const RenderOptions& options, const cl::DeviceInfo& device);

}  // namespace raycube::render
