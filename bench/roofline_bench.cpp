// Each stage of a render of the park against what the machine can do: bytes it must move and additions and
// multiplications it must make, counted from what its kernel reads and writes, over the seconds of run.json.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bench/cases.h"
#include "bench/device.h"
#include "bench/park_job.h"
#include "bench/timing.h"
#include "bench/write_bandwidth.h"
#include "host/base/error.h"
#include "host/cl/kernel.h"
#include "kernels/shared/tile_layout.h"

namespace raycube::bench {
namespace {

// Twelve chains of fused multiply-adds, 16 wide, enough to hide four cycles of latency on two ports. a x + b with a =
// 1/2, b = 1/2 ends at 1 from any start, to a rounding: what is computed can be checked.
constexpr const char* kPeakSource = R"(
kernel void fma_peak(global float16* out, uint rounds, float a, float b) {
  float16 x[12];
  for (int i = 0; i < 12; ++i) x[i] = (float16)(i + get_global_id(0));
  for (uint r = 0; r < rounds; ++r)
    #pragma unroll
    for (int i = 0; i < 12; ++i) x[i] = fma(x[i], (float16)(a), (float16)(b));
  float16 sum = 0;
  for (int i = 0; i < 12; ++i) sum += x[i];
  out[get_global_id(0)] = sum;
}
)";

/// 1e9 fused multiply-adds count two each. Best of nine launches.
double fma_peak_gflop_s(const Settings& settings, Report& report) {
  const cl::Context context(pick_device(settings.threads));
  const cl::Program program(context, "fma_peak", kPeakSource, "-cl-std=CL1.2");
  cl::Kernel kernel(program, "fma_peak");
  constexpr std::uint32_t kRounds = 1 << 18;
  constexpr std::size_t kItems = 64;
  cl::Buffer<float> out(context, kItems * 16, cl::Access::read_write, "sums");
  kernel.arguments(out, cl_uint{kRounds}, 0.5f, 0.5f);
  double best = 1e9;
  for (int i = 0; i < kPairs + 1; ++i) {
    const double s = seconds_of([&] {
      context.launch(kernel, kItems);
      context.finish();
    });
    if (i > 0) best = std::min(best, s);
  }
  double worst = 0;
  for (const float sum : out.read_all()) worst = std::max(worst, std::abs(sum / 12.0 - 1));
  report.validate("fma peak: chains that do not end at 1, relative", worst, 1e-6);
  return 1e-9 * 2 * 12 * 16 * kRounds * kItems / best;
}

/// The park with fewer pixels and sky directions, beside it: 128 x 128 pixels, 121 samples, 360 bands.
std::string small_park(const Settings& settings) {
  load_park(settings);  // says how to make it where it is not there
  std::ifstream file(settings.park_file);
  std::stringstream text;
  text << file.rdbuf();
  std::string toml = text.str();
  for (const auto& [from, to] : {std::pair{"pixels = 320", "pixels = 128"},
                                 {"lines = 320", "lines = 128"},
                                 {"sky_directions = 484", "bounces = 0\nsky_directions = 20"}}) {
    const auto at = toml.find(from);
    if (at == std::string::npos)
      throw base::Error(base::Fault::input,
                        "bench: " + settings.park_file + " has no '" + from + "'; is this the shipped park?");
    toml.replace(at, std::string(from).size(), to);
  }
  const auto path = std::filesystem::path(settings.park_file).parent_path() / "park_roofline.toml";
  std::ofstream(path) << toml;
  return path.string();
}

struct Stage {
  const char* name;
  double bytes, flops;  ///< per pixel; flops 0: they depend on the scene, not on sizes
};

}  // namespace

void run_roofline(const Settings& settings, Report& report) {
  const std::string park = small_park(settings);
  const std::size_t roof_floats = (std::size_t{384} << 20) / sizeof(float);
  const auto release = [](float* p) { std::free(p); };
  const std::unique_ptr<float, decltype(release)> roof(
      static_cast<float*>(std::aligned_alloc(64, roof_floats * sizeof(float))), release);
  std::vector<double> write_gb_s;
  for (int i = 0; i < kPairs + 1; ++i) {
    const double s = seconds_of([&] { fill16(roof.get(), roof_floats, static_cast<float>(i), settings.threads); });
    if (i > 0) write_gb_s.push_back(1e-9 * static_cast<double>(roof_floats * sizeof(float)) / s);
  }
  const double bandwidth_gb_s = spread_of(write_gb_s).median, peak_gflop_s = fma_peak_gflop_s(settings, report);
  report.add("roofline_write_gb_s", spread_of(write_gb_s), "GB/s");
  report.add("roofline_fma_gflop_s", peak_gflop_s, "Gflop/s");

  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "raycube";
  const auto folder = std::filesystem::path(park).parent_path() / "roofline_out";
  const std::string command = shell_quoted(program.string()) + " render " + shell_quoted(park) +
                              " --instrument spectir --threads " + std::to_string(settings.threads) +
                              " -q --overwrite -o " + shell_quoted(folder.string()) + " > /dev/null";
  nlohmann::json run;
  for (int i = 0; i < 2; ++i) {  // the first compiles
    if (std::system(command.c_str()) != 0)
      throw base::Error(base::Fault::environment, "bench: the park was not rendered by: " + command);
    run = nlohmann::json::parse(std::ifstream(folder / "spectir/run.json"));
  }
  const double pixels = run.at("image").at("samples").get<double>() * run.at("image").at("lines").get<double>();
  const double samples = run.at("image").at("samples_per_pixel"), bands = run.at("image").at("bands"),
               terms = run.at("rows").at("terms_p50");
  constexpr std::size_t kComponents = 4;  // of the park's sky: one float4 of met sky per sample
  const shared::TileElements pixel(static_cast<std::size_t>(samples), RC_SKY_PLANES_OF(kComponents));
  const double hits = 4.0 * static_cast<double>(pixel.hits), surface = 4.0 * static_cast<double>(pixel.surface),
               lift = 4.0 * static_cast<double>(pixel.lift), sun = 2.0 * static_cast<double>(pixel.sun),
               sky = 4.0 * static_cast<double>(pixel.met_sky), bands_padded = 16 * std::ceil(bands / 16);
  // Bytes that pass through memory between stages (docs/design.md, stages); the scene's trees and triangles come on top
  // and mostly from caches. make_surface gathers a triangle of 36 bytes a sample. integrate reads its table (terms
  // rows) from the second cache.
  const Stage stages[] = {
      {"trace_primary", hits, 0},
      {"make_surface", hits + surface + lift + 36 * samples, 0},
      {"trace_sun", surface + sun, 0},
      {"trace_sky", surface + sky, 0},
      {"shade", hits + surface + lift + sky + sun, 0},
      {"resolve", 8 * terms, 0},
      {"integrate", 4 * bands_padded + 8 * terms, 2 * terms * bands_padded},
      {"write", 4 * bands, 0},
  };
  std::printf("  %-14s %9s %12s %8s %12s %8s\n", "stage", "s", "bytes/pixel", "of roof", "flop/pixel", "of peak");
  for (const Stage& stage : stages) {
    const double s = run.at("stage_s").at(stage.name).get<double>();
    const double of_roof = 1e-9 * stage.bytes * pixels / s / bandwidth_gb_s,
                 of_peak = 1e-9 * stage.flops * pixels / s / peak_gflop_s;
    std::printf("  %-14s %9.4f %12.0f %8.4f %12.0f %8.4f\n", stage.name, s, stage.bytes, of_roof, stage.flops, of_peak);
    report.add(std::string("roofline_") + stage.name + "_of_write_bandwidth", of_roof, "x");
    if (stage.flops > 0) report.add(std::string("roofline_") + stage.name + "_of_fma_peak", of_peak, "x");
  }
  report.add("roofline_primary_mrays_s", 1e-6 * samples * pixels / run.at("stage_s").at("trace_primary").get<double>(),
             "Mrays/s");
}

}  // namespace raycube::bench
