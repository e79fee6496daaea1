// raycube_bench [--commit HASH] [--json FILE] [--list] [NAME ...]: runs the named groups of figures (default: all).
#include <CLI/CLI.hpp>
#include <cstdio>
#include <algorithm>

#include "bench/cases.h"
#include "host/base/error.h"
#include "host/base/standard_streams.h"

using namespace raycube;

int main(int argc, char** argv) {
  raycube::base::claim_standard_descriptors();
  CLI::App app("Benchmarks of raycube against Embree and the machine's memory. Validates before it times.");
  std::string commit = "unknown", json = "bench.json", run_json;
  std::vector<std::string> names;
  bool list = false, kernel_build = false;
  bench::Settings settings;
  app.add_option("--commit", commit, "Commit the figures belong to");
  app.add_option("--json", json, "File for the flat keys")->capture_default_str();
  app.add_option("--scene", settings.park_file, "Simulation file of the park")->capture_default_str();
  app.add_option("--peer-scene", settings.peer_file, "Simulation file that bench/peer_scene.py writes")
      ->capture_default_str();
  app.add_option("--threads", settings.threads, "Threads of both sides")
      ->capture_default_str()
      ->check(CLI::Range(1, 1024));
  app.add_flag("--list", list, "Names of the groups");
  app.add_flag("--kernel-build", kernel_build,
               "Print the seconds kernels take to build in this process (the group `build` calls it)");
  app.add_option("--check-run", run_json,
                 "Only compare the programs launched here for the scene's first instrument with those of this run.json "
                 "of `raycube render`");
  app.add_option("names", names, "Groups to run");
  CLI11_PARSE(app, argc, argv);
  try {
    if (list) {
      for (const auto& entry : bench::all_cases()) std::printf("%-12s %s\n", entry.name, entry.text);
      return 0;
    }
    if (kernel_build) {
      const bench::KernelBuild build = bench::kernel_build(settings);
      std::printf("%.6f %s %s\n", build.seconds, build.programs.all.c_str(), build.programs.trace.c_str());
      return 0;
    }
    if (!run_json.empty()) {
      bench::Report report(commit);
      report.add_programs(run_json, bench::programs_of_run(run_json));
      report.add_programs("raycube_bench", bench::kernel_build(settings).programs);
      return 0;
    }
    for (const auto& name : names)
      if (!bench::find_case(name))
        throw base::Error(base::Fault::input, "bench: no group '" + name + "'; --list names them");
    bench::Report report(commit);
    for (const auto& entry : bench::all_cases()) {
      if (!names.empty() && std::find(names.begin(), names.end(), entry.name) == names.end()) continue;
      std::printf("%s: %s\n", entry.name, entry.text);
      std::fflush(stdout);
      try {
        entry.run(settings, report);
      } catch (const base::Error& error) {
        report.set_text("failed", std::string(entry.name) + ": " + error.what());
        report.write_json(json);
        throw;
      }
      report.write_json(json);
    }
    report.print_table();
    std::printf("bench: %s\n", json.c_str());
    if (!report.guards_hold())
      throw base::Error(base::Fault::check,
                        "bench: a guard failed: the baseline is not what it should be, no ratio counts");
  } catch (const base::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return error.exit_status();
  }
  return 0;
}
