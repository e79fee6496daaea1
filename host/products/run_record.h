// run.json: how a product came about, for people and for repeating it.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host/base/output_file.h"

namespace raycube::products {

struct RunRecord {
  std::string command;  ///< as typed
  std::string instrument;
  std::string scene_hash;  ///< SHA-256 of the compiled scene
  std::uint64_t seed = 0;
  std::string digest;  ///< of radiance and truth (digest.h)
  // device
  std::string platform, device, driver, opencl_version;
  int compute_units = 0, threads = 0;
  std::string program_hash;  ///< SHA-256 of kernel source and build options
  std::vector<std::string> kernel_variants;
  // figures
  std::int64_t samples = 0, lines = 0, bands = 0, samples_per_pixel = 0;
  std::vector<std::pair<std::string, double>> stage_s;      ///< wall-clock seconds per stage, in order
  std::vector<std::pair<std::string, double>> processor_s;  ///< of all threads: plan, render
  double total_s = 0;
  std::uint64_t rays = 0;  ///< primary, sun and sky rays together
  double rays_per_s = 0, band_samples_per_s = 0;
  std::uint64_t memory_budget_bytes = 0, peak_memory_bytes = 0, device_memory_bytes = 0;
  std::uint64_t clipped_low = 0, clipped_high = 0, not_a_number = 0;
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, std::string>> files;  ///< name, what it holds
  std::vector<std::pair<std::string, base::FileHashes>>
      hashes;                      ///< of every file of the set, headers too, but this record
  std::string configuration_json;  ///< every option with its value (Simulation::resolved_json)
  std::string plan_json;           ///< the plan, as JSON text
  std::vector<std::pair<std::string, std::string>> more_json;  ///< further members: name, JSON text
};

/// The record with the program's version, commit and compiler, as indented JSON. Empty JSON members become null. Throws
/// Error(bug) when a member is not JSON.
std::string run_record_json(const RunRecord& record);

/// Ends an instrument's set: hashes of all its files, run.json as the last one, and the names of all
/// (OutputSet::publish).
void publish_run(base::OutputSet& set, RunRecord& record);

/// Names of the files that the run.json of a folder lists, with the headers of its .img; none where there is no such
/// record.
std::vector<std::string> files_of_run(const std::string& folder);

}  // namespace raycube::products
