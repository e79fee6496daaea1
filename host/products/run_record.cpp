#include "host/products/run_record.h"

#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/input_file.h"
#include "host/base/json_text.h"
#include "host/base/version.h"

namespace raycube::products {
namespace {

using Json = nlohmann::ordered_json;

Json member(const char* name, const std::string& text) {
  if (text.empty()) return nullptr;
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& failure) {
    throw base::Error(base::Fault::bug, std::string("run record: ") + name + " is not JSON: " + failure.what());
  }
}

Json hashes_json(const std::vector<std::pair<std::string, base::FileHashes>>& hashes) {
  Json files = Json::object();
  for (const auto& [name, file] : hashes)
    files[name] = {{"bytes", file.bytes}, {"list", file.list}, {"blocks", file.blocks}};
  return {{"block_bytes", base::kHashBlock_bytes}, {"files", files}};
}

}  // namespace

std::string run_record_json(const RunRecord& r) {
  Json out;
  out["format"] = "raycube run";
  out["format_version"] = 1;
  out["program"] = {
      {"name", "raycube"}, {"version", base::kVersion}, {"commit", base::kCommit}, {"compiler", base::kCompiler}};
  out["command"] = r.command;
  out["instrument"] = r.instrument;
  out["scene_hash"] = r.scene_hash;
  out["seed"] = r.seed;
  out["digest"] = r.digest;
  out["device"] = {
      {"platform", r.platform},           {"name", r.device},    {"driver", r.driver}, {"opencl", r.opencl_version},
      {"compute_units", r.compute_units}, {"threads", r.threads}};
  out["program_hash"] = r.program_hash;
  out["kernel_variants"] = r.kernel_variants;
  out["image"] = {
      {"samples", r.samples}, {"lines", r.lines}, {"bands", r.bands}, {"samples_per_pixel", r.samples_per_pixel}};
  out["stage_s"] = Json::object();
  for (const auto& [stage, seconds] : r.stage_s) out["stage_s"][stage] = seconds;
  if (!r.processor_s.empty()) out["processor_s"] = Json::object();
  for (const auto& [part, seconds] : r.processor_s) out["processor_s"][part] = seconds;
  out["total_s"] = r.total_s;
  out["rays"] = r.rays;
  out["rays_per_s"] = r.rays_per_s;
  out["band_samples_per_s"] = r.band_samples_per_s;
  out["memory"] = {{"budget_bytes", r.memory_budget_bytes},
                   {"peak_bytes", r.peak_memory_bytes},
                   {"device_bytes", r.device_memory_bytes}};
  out["clipped"] = {{"low", r.clipped_low}, {"high", r.clipped_high}, {"not_a_number", r.not_a_number}};
  out["warnings"] = r.warnings;
  out["files"] = Json::object();
  for (const auto& [name, text] : r.files) out["files"][name] = text;
  out["sha256"] = hashes_json(r.hashes);
  out["configuration"] = member("configuration", r.configuration_json);
  out["plan"] = member("plan", r.plan_json);
  for (const auto& [name, text] : r.more_json) out[name] = member(name.c_str(), text);
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void publish_run(base::OutputSet& set, RunRecord& record) {
  record.hashes = set.hashes();
  set.add("run.json").append(run_record_json(record));
  set.replaces(files_of_run(set.folder()));
  set.publish();
}

std::vector<std::string> files_of_run(const std::string& folder) {
  std::vector<std::string> names;
  const std::string path = (std::filesystem::path(folder) / "run.json").string();
  if (!base::why_no_plain_file(path).empty()) return names;
  std::ifstream file(path);
  const Json record = Json::parse(base::shallow_json(file), nullptr, false);
  if (!record.is_object() || record.value("format", Json()) != "raycube run" || !record.contains("files") ||
      !record["files"].is_object())
    return names;
  for (const auto& [name, text] : record["files"].items()) {
    names.push_back(name);
    if (std::filesystem::path(name).extension() == ".img")
      names.push_back(std::filesystem::path(name).replace_extension(".hdr").string());
  }
  return names;
}

}  // namespace raycube::products
