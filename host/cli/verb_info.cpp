#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <ostream>
#include <sstream>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "atmos_tables/rct_file.h"
#include "atmos_tables/report.h"
#include "host/base/error.h"
#include "host/base/input_file.h"
#include "host/base/json_text.h"
#include "host/base/memory.h"
#include "host/base/publication.h"
#include "host/cli/info_cube.h"
#include "host/cli/info_las.h"
#include "host/cli/info_mesh.h"
#include "host/cli/info_picture.h"
#include "host/cli/info_spectra.h"
#include "host/cli/verb.h"
#include "host/products/envi_reader.h"
#include "host/products/picture_reader.h"
#include "host/products/verify_run.h"
#include "scene_compiler/compiled_file.h"
#include "scene_compiler/scene_info.h"

namespace raycube::cli {
namespace {

using Json = nlohmann::ordered_json;
using base::Error;
using base::Fault;
namespace fs = std::filesystem;

struct InfoRequest {
  std::string file;
  bool header_only = false, every_band = false, verify = false;
};

/// A folder stands for the run it holds. A run that was killed while its files got their names is ended
/// first.
std::string resolve(const std::string& path) {
  if (fs::is_directory(path))
    base::finish_publication(path);
  else
    base::finish_publication_around(path);
  if (!fs::exists(path)) throw Error(Fault::input, path + ": no such file");
  if (!fs::is_directory(path)) {
    base::refuse_other_than_plain(path);
    return path;
  }
  const fs::path record = fs::path(path) / "run.json";
  base::refuse_other_than_plain(record.string());
  if (fs::exists(record)) return record.string();
  throw Error(Fault::input, path + ": is a folder without run.json; name a file");
}

/// Records of the runs in a folder's folders, as a render of several instruments leaves them, by their names.
std::vector<std::string> runs_in(const std::string& folder) {
  std::vector<std::string> out;
  if (!fs::is_directory(folder) || fs::exists(fs::path(folder) / "run.json")) return out;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && base::why_no_plain_file((entry.path() / "run.json").string()).empty())
      out.push_back((entry.path() / "run.json").string());
  std::sort(out.begin(), out.end());
  return out;
}

void print_run(Invocation& invocation, const std::string& path, const Json& run) {
  if (!run.is_object() || run.value("format", "") != "raycube run")
    throw Error(Fault::input,
                path + ": is JSON but no run record of raycube (its member \"format\" is not \"raycube run\")");
  if (invocation.common.json) {
    invocation.out << Json{{"kind", "run"}, {"file", path}, {"run", run}}.dump(2) << "\n";
    return;
  }
  const auto text = [&](const Json& at, const char* key) -> std::string {
    if (!at.is_object() || !at.contains(key)) return "-";
    return at[key].is_string() ? at[key].get<std::string>() : at[key].dump();
  };
  const auto member = [&](const char* key) { return run.value(key, Json::object()); };
  auto& out = invocation.out;
  out << fmt::format("{}: run of raycube {} ({})\n", path, text(member("program"), "version"),
                     text(member("program"), "commit"));
  out << fmt::format("  command       {}\n  instrument    {}\n", text(run, "command"), text(run, "instrument"));
  const Json image = member("image");
  out << fmt::format("  image         {} samples x {} lines x {} bands, {} samples per pixel\n", text(image, "samples"),
                     text(image, "lines"), text(image, "bands"), text(image, "samples_per_pixel"));
  if (const Json pulses = member("lidar"); !pulses.empty())
    out << fmt::format("  pulses        {}, {} without return, {} returns\n", text(pulses, "pulses"),
                       text(pulses, "pulses_without_return"), text(pulses, "returns"));
  out << fmt::format("  device        {} ({})\n", text(member("device"), "name"), text(member("device"), "driver"));
  out << fmt::format("  seed          {}\n  scene         {}\n  digest        {}\n", text(run, "seed"),
                     text(run, "scene_hash"), text(run, "digest"));
  out << fmt::format("  rate          {} rays/s, {} band samples/s\n", text(run, "rays_per_s"),
                     text(run, "band_samples_per_s"));
  if (const Json memory = member("memory"); memory.contains("peak_bytes") && memory["peak_bytes"].is_number_unsigned())
    out << fmt::format("  peak memory   {}\n", base::format_bytes(memory["peak_bytes"].get<std::uint64_t>()));
  const Json stages = member("stage_s"), files = member("files");
  for (const auto& [stage, seconds] : stages.items()) out << fmt::format("  {:<13} {} s\n", stage, seconds.dump());
  for (const auto& [name, what] : files.items())
    out << fmt::format("  {:<20} {}\n", name, what.is_string() ? what.get<std::string>() : "");
}

void print_run_file(Invocation& invocation, const std::string& path) {
  std::ifstream in(path);
  try {
    print_run(invocation, path, Json::parse(base::shallow_json(in)));
  } catch (const Json::parse_error& failure) {
    throw Error(Fault::input, fmt::format("{}: is not valid JSON at byte {}; is the file whole?", path, failure.byte));
  } catch (const Json::exception& failure) {
    throw Error(Fault::input,
                fmt::format("{}: a member of the run record has the wrong type: {}", path, failure.what()));
  }
}

void print_scene(Invocation& invocation, const std::string& path) {
  const auto info = scene::scene_info(scene::load_compiled(path));
  invocation.out << (invocation.common.json ? scene::scene_info_json(info) : scene::scene_info_text(info));
}

void print_table(Invocation& invocation, const std::string& path) {
  const auto table = atmos::read_rct(path);
  const std::string hash = atmos::content_hash(table);
  invocation.out << (invocation.common.json ? atmos::table_json(table, hash) : atmos::table_text(table, hash));
}

/// The disk against the record's hashes; the exit status.
int print_verified(Invocation& invocation, const std::string& path) {
  const auto found = products::verify_run(path);
  if (invocation.common.json) {
    invocation.out << Json{{"kind", "verification"}, {"file", path},         {"whole", found.whole()},
                           {"files", found.files},   {"bytes", found.bytes}, {"differences", found.differences}}
                          .dump(2)
                   << "\n";
  } else {
    for (const auto& difference : found.differences)
      invocation.out << (fs::path(path).parent_path() / difference).string() << "\n";
    invocation.out << fmt::format("{}: {} of {} files are as they were written, {}\n", path,
                                  found.files - found.differences.size(), found.files, base::format_bytes(found.bytes));
  }
  return found.whole() ? 0 : static_cast<int>(Fault::check);
}

/// Every run of a folder: as text one after the other, as JSON one document of them.
int print_runs(Invocation& invocation, const std::vector<std::string>& paths, bool verify) {
  int status = 0;
  std::ostringstream documents;
  for (const std::string& path : paths) {
    base::finish_publication_around(path);
    std::ostringstream own;
    Invocation each{invocation.common, invocation.log, own, invocation.command_line};
    if (verify)
      status = std::max(status, print_verified(each, path));
    else
      print_run_file(each, path);
    if (invocation.common.json)
      documents << (documents.tellp() > 0 ? ",\n" : "") << own.str();
    else
      invocation.out << own.str();
  }
  if (invocation.common.json)
    invocation.out << Json{{"kind", "runs"}, {"runs", Json::parse("[" + documents.str() + "]")}}.dump(2) << "\n";
  return status;
}

int run(Invocation& invocation, const InfoRequest& options) {
  if (const auto runs = runs_in(options.file); !runs.empty()) return print_runs(invocation, runs, options.verify);
  const std::string path = resolve(options.file);
  const std::string extension = fs::path(path).extension().string();
  if (options.verify) {
    if (extension != ".json") throw Error(Fault::input, path + ": --verify wants a run's folder or its run.json");
    return print_verified(invocation, path);
  }
  if (extension == ".rcs")
    print_scene(invocation, path);
  else if (extension == ".rct")
    print_table(invocation, path);
  else if (extension == ".json")
    print_run_file(invocation, path);
  else if (extension == ".las" || extension == ".LAS" || extension == ".laz")
    print_las_info(invocation, path);
  else if (is_mesh_file(path))
    print_mesh_info(invocation, path);
  else if (products::is_picture(path))
    print_picture_info(invocation, path, options.header_only);
  else if (is_spectrum_file(path))
    print_spectra_info(invocation, path);
  else
    print_cube_info(invocation, path, options.header_only, options.every_band);
  return 0;
}

}  // namespace

Verb verb_info() {
  const auto options = std::make_shared<InfoRequest>();
  Verb verb("info", "Say what a product, scene or table holds");
  verb.description =
      "FILE is an ENVI image or spectral library (either of its two files), a compiled scene (.rcs), a "
      "render table (.rct), a point cloud (.las), a picture (OpenEXR, PNG, JPEG, TIFF), a mesh (.obj, .ply, .gltf and "
      "others: its parts by name), spectra (.csv, and as laboratories and field spectrometers write them), a run "
      "record (.json), the "
      "folder "
      "of a run, or a folder of such folders. --verify names, of each file that is not as it was written, the first "
      "block of 4 MiB that "
      "differs. Statistics of an image read it once, line by line; its ignore value, NaN and infinities are "
      "counted apart.";
  verb.examples = {"raycube info out/spectir/radiance.img", "raycube info --json out/spectir | jq .run.digest",
                   "raycube info out/als/returns.las", "raycube info out/spectir/preview.exr",
                   "raycube info --verify out/spectir"};
  verb.add_options = [options](base::OptionTable& table) {
    table.argument("FILE", "What to look at", options->file);
    table.flag("--header", "Of an image the header alone, without reading its samples", options->header_only);
    table.flag("--verify",
               "Of a run: read its files and compare them with the hashes in run.json; exit status 1 when "
               "one is missing or differs",
               options->verify);
    table.flag("--bands", "Of an image one line of statistics per band", options->every_band);
  };
  verb.run = [options](Invocation& invocation) { return run(invocation, *options); };
  return verb;
}

}  // namespace raycube::cli
