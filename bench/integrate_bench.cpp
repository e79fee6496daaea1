// Spectral integration on term lists of known length against plain 16-wide stores.
#include <cmath>
#include <cstdlib>
#include <memory>

#include "bench/cases.h"
#include "bench/device.h"
#include "bench/scenes/scenes.h"
#include "bench/timing.h"
#include "bench/write_bandwidth.h"
#include "host/render/row_stages.h"
#include "kernels/sampling/sampler.h"

namespace raycube::bench {
namespace {

constexpr int kBands = 360, kMaterials = 12;
constexpr std::size_t kPixels = 512 * 512;  // 386 MB of radiance: past every cache

// One source, one node of everything: a term's row is a material's. Flat spectra; the numbers only have to differ.
plan::Plan synthetic_plan() {
  plan::Plan plan;
  for (int i = 0; i <= kBands; ++i) plan.wavelength_um.push_back(0.4 + 2.05 * i / kBands);
  for (int b = 0; b < kBands; ++b) plan.bands.push_back({static_cast<std::size_t>(b), {0.5, 0.5}});
  std::vector<double> source, path;
  for (std::size_t i = 0; i < plan.wavelength_um.size(); ++i) {
    source.push_back(100 + 10 * std::sin(0.1 * static_cast<double>(i)));
    path.push_back(5 + std::cos(0.07 * static_cast<double>(i)));
  }
  plan.source_spectrum = {source};
  plan.path_spectrum = {path};
  plan.transmission_spectrum = {std::vector<double>(source.size(), 1.0)};
  return plan;
}

scene::CompiledScene synthetic_scene() {
  auto scene = compile({crown_ground()}, {{kIdentity}});
  const scene::Material pattern = scene.materials[0];
  scene.materials.clear();
  scene.blocks.clear();  // in a scene without surfaces all materials may be asked for
  for (int m = 0; m < kMaterials; ++m) {
    scene.materials.push_back(pattern);
    scene.materials.back().name = "material " + std::to_string(m);
    scene.materials.back().reflectance = {{0.3, 1.0, 3.0}, {0.05 * (m + 1), 0.6, 0.9 - 0.05 * m}};
  }
  return scene;
}

struct FreeDeleter {
  void operator()(float* p) const { std::free(p); }
};

}  // namespace

void run_integrate(const Settings& settings, Report& report) {
  const auto scene = synthetic_scene();
  const auto plan = synthetic_plan();
  scene::Instrument instrument;
  instrument.name = "synthetic";
  const auto shape = render::make_stage_shape(instrument, plan, RC_GROUP_WIDTH);
  const cl::Context context(pick_device(settings.threads));
  const render::SceneBuffers buffers(context, scene);
  render::RowStages stages(context, buffers, plan, shape, sensors::SampleWeights(instrument));
  render::BandTable table(context, scene, plan, shape, 64 << 20);
  std::vector<std::uint64_t> keys;
  for (int m = 1; m <= kMaterials; ++m) keys.push_back(static_cast<std::uint64_t>(m));
  table.ensure(keys);
  const auto padded = static_cast<std::size_t>(shape.bands_padded);
  cl::Buffer<float> radiance(context, kPixels * padded, cl::Access::read_write, "radiance");
  const auto rows_in_table = table.values().size() / padded;
  const std::vector<float> baked = table.values().read_all();

  const std::size_t roof_floats = (std::size_t{384} << 20) / sizeof(float);
  const std::unique_ptr<float, FreeDeleter> roof(
      static_cast<float*>(std::aligned_alloc(64, roof_floats * sizeof(float))));
  fill16(roof.get(), roof_floats, 1.0f, settings.threads);
  std::vector<double> bandwidth;
  for (const std::uint32_t terms : {4u, 8u}) {
    render::RowBuffers rows(context, shape, kPixels, 8);
    std::vector<std::uint32_t> count(kPixels, terms), row(kPixels * rows.term_capacity, 0);
    std::vector<float> weight(kPixels * rows.term_capacity, 0.0f);
    for (std::size_t p = 0; p < kPixels; ++p)
      for (std::uint32_t t = 0; t < terms; ++t) {
        const std::uint32_t bits = rc_hash(41u, static_cast<std::uint32_t>(p), t, terms);
        row[p * rows.term_capacity + t] = bits % static_cast<std::uint32_t>(rows_in_table);
        weight[p * rows.term_capacity + t] = 0.05f + rc_unit_float(bits);
      }
    rows.term_count.write(count);
    rows.term_row.write(row);
    rows.term_weight.write(weight);
    const auto integrate = [&] {
      stages.integrate(0, kPixels, {kPixels, nullptr}, table, rows, radiance);
      context.finish();
    };
    integrate();
    double worst = 0;
    std::vector<float> line(padded);
    for (std::size_t p = 0; p < kPixels; p += 997) {
      radiance.read(line, p * padded);
      for (std::size_t b = 0; b < kBands; ++b) {
        double exact = 0;
        for (std::uint32_t t = 0; t < terms; ++t)
          exact += static_cast<double>(weight[p * rows.term_capacity + t]) *
                   baked[row[p * rows.term_capacity + t] * padded + b];
        worst = std::max(worst, std::abs(line[b] - exact) / exact);
      }
    }
    // `terms` fused multiply-adds of positive numbers: each rounds by 2^-24 at most.
    report.validate("integration of " + std::to_string(terms) + " terms against double, relative", worst, terms * 6e-8);
    float value = 2.0f;
    const Pairs pairs = alternate([&] { fill16(roof.get(), roof_floats, value += 1.0f, settings.threads); }, integrate);
    const double scale = static_cast<double>(kPixels * padded) / static_cast<double>(roof_floats);
    Spread ratio = pairs.ratio();
    ratio = {ratio.median * scale, ratio.lowest * scale, ratio.highest * scale, ratio.count};
    report.add("integrate" + std::to_string(terms) + "_vs_write_bandwidth", ratio, "x",
               Goal::at_least(terms == 4 ? 1.0 : 0.6));
    for (const double s : pairs.reference_s)
      bandwidth.push_back(1e-9 * static_cast<double>(roof_floats * sizeof(float)) / s);
  }
  report.add("write_bandwidth_gb_s", spread_of(bandwidth), "GB/s");
}

}  // namespace raycube::bench
