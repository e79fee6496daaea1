#include "host/render/device_tuning.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "host/base/cache_folder.h"
#include "host/base/error.h"
#include "host/base/json_text.h"
#include "host/base/sha256.h"
#include "host/render/renderer.h"
#include "kernels/kernel_source.h"

namespace raycube::render {

namespace {

constexpr std::size_t kMostLocal = 4096, kMostTileSamples = std::size_t{1} << 32;

/// A size of the file; throws when it is no number or out of range.
std::size_t size_in(const nlohmann::json& value, std::size_t most) {
  const auto size = value.get<std::uint64_t>();
  if (size == 0 || size > most) throw std::out_of_range("a size of launches");
  return static_cast<std::size_t>(size);
}

}  // namespace

DeviceTuning default_tuning(const cl::DeviceInfo& device) {
  return {cl::default_launch_sizes(device), device.is_cpu ? kCpuTileSamples : kTileSamples, false};
}

std::filesystem::path tuning_file(const cl::DeviceInfo& device) {
  const auto folder = base::cache_folder("tuning");
  if (folder.empty()) return {};
  std::string kernels;
  for (const auto name : kernels::kernel_names()) kernels += kernels::kernel_source(name);
  const std::string key = device.name + "\n" + device.vendor + "\n" + device.platform + "\n" + device.driver + "\n" +
                          std::to_string(device.compute_units) + "\n" + kernels;
  return folder / (base::sha256_hex(key) + ".json");
}

std::optional<DeviceTuning> read_tuning(const cl::DeviceInfo& device) {
  std::ifstream file(tuning_file(device));
  if (!file) return {};
  try {
    const auto json = nlohmann::json::parse(base::shallow_json(file));
    DeviceTuning tuning = default_tuning(device);
    for (const auto& [kernel, local] : json.at("local").items())
      tuning.sizes.local[kernel] = size_in(local, kMostLocal);
    tuning.tile_samples = size_in(json.at("tile_samples"), kMostTileSamples);
    tuning.tuned = true;
    return tuning;
  } catch (const std::exception&) {
    return {};
  }
}

base::OutputFile claim_tuning(const cl::DeviceInfo& device) {
  const auto path = tuning_file(device);
  if (path.empty())
    throw base::Error(base::Fault::environment,
                      "no place to keep the sizes found: neither XDG_CACHE_HOME nor HOME is set; set one of them to a "
                      "folder of yours");
  try {
    return base::OutputFile(path.string(), base::IfExists::replace);
  } catch (const base::Error& error) {
    throw base::Error(base::Fault::environment, std::string("sizes found could not be kept: ") + error.what() +
                                                    "; XDG_CACHE_HOME names another folder for them");
  }
}

void keep_tuning(const cl::DeviceInfo& device, const DeviceTuning& tuning, base::OutputFile& file) {
  DeviceTuning all = tuning;
  if (const auto before = read_tuning(device))
    all.sizes.local.insert(before->sizes.local.begin(), before->sizes.local.end());
  const nlohmann::ordered_json json = {{"device", device.name},
                                       {"driver", device.driver},
                                       {"compute_units", device.compute_units},
                                       {"local", all.sizes.local},
                                       {"tile_samples", all.tile_samples}};
  file.append(json.dump(2) + "\n");
  file.publish();
}

std::string tuning_json(const DeviceTuning& tuning) {
  return nlohmann::ordered_json{{"tuned", tuning.tuned},
                                {"local_size", tuning.sizes.other},
                                {"local_size_of", tuning.sizes.local},
                                {"tile_samples", tuning.tile_samples}}
      .dump();
}

cl::Device pick_device(const RenderOptions& options) {
  cl::Device device = cl::find_device(options.device);
  const auto units = static_cast<int>(device.info().compute_units);
  if (device.info().is_cpu && options.threads > 0 && options.threads < units)
    return device.with_compute_units(static_cast<std::uint32_t>(options.threads));
  return device;
}

DeviceTuning tuning_for(const RenderOptions& options, const cl::DeviceInfo& device) {
  if (options.tuning) return *options.tuning;
  if (options.tuned)
    if (const auto kept = read_tuning(device)) return *kept;
  return default_tuning(device);
}

}  // namespace raycube::render
