#include "host/run/truth_cubes.h"

#include <cmath>
#include <limits>

#include "host/base/units.h"
#include "host/plan/band_truth.h"
#include "host/plan/quadrature.h"
#include "host/render/truth.h"
#include "kernels/atmosphere/nodes.h"

namespace raycube::run {

TruthCubes::TruthCubes(base::OutputSet& set, const scene::Simulation& simulation, const CameraJob& job,
                       const MakeHeader& header)
    : instrument_(job.image()),
      plan_(job.plan),
      layers_(render::truth_layer_names(simulation.scene, job.image()).size()) {
  std::vector<scene::BandTruth> asked = plan::truth_columns(job.plan, *job.instrument);
  if (instrument_.asks_for(scene::BandTruth::transmission)) {
    asked.push_back(scene::BandTruth::transmission);
    for (const auto& spectrum : plan_.transmission_spectrum)
      node_transmission_.push_back(plan::in_bands(plan_.bands, spectrum));
  }
  for (const scene::BandTruth truth : asked) {
    const scene::BandTruthEntry& entry = scene::band_truth_entry(truth);
    const bool part = entry.kind == scene::BandTruthKind::part;
    const std::string what = part ? "part of the radiance: " : std::string(entry.name) + " per band: ";
    cubes_.push_back({truth, products::EnviWriter(set, entry.file() + ".img",
                                                  header(std::string(entry.unit), what + std::string(entry.text)))});
  }
}

products::Strip TruthCubes::strip_of(const render::Strip& strip, const float* values, std::size_t stride) const {
  return {strip.first_line, strip.lines, values, stride, strip.first_sample, strip.samples};
}

std::size_t TruthCubes::pixels_of(const render::Strip& strip) const {
  return static_cast<std::size_t>(strip.lines) *
         static_cast<std::size_t>(strip.samples > 0 ? strip.samples : instrument_.pixels);
}

void TruthCubes::write(const render::Strip& strip) {
  const std::size_t bands = plan_.bands.size();
  std::size_t column = bands;
  for (Cube& cube : cubes_) {
    switch (scene::band_truth_entry(cube.truth).kind) {
      case scene::BandTruthKind::part:
        cube.writer.write(strip_of(strip, strip.radiance + column, strip.columns));
        break;
      case scene::BandTruthKind::surface:
        write_means(strip, column, cube.writer);
        break;
      case scene::BandTruthKind::way:
        write_transmission(strip, cube.writer);
        break;
    }
    column += bands;
  }
}

/// Sums over the samples that hit, over how many those are.
void TruthCubes::write_means(const render::Strip& strip, std::size_t column, products::EnviWriter& to) const {
  const std::size_t pixels = pixels_of(strip), bands = plan_.bands.size();
  std::vector<float> values(pixels * bands);
  for (std::size_t p = 0; p < pixels; ++p) {
    const float hit = strip.truth[p * layers_ + render::truth::hit_fraction];
    const float* sum = strip.radiance + p * strip.columns + column;
    for (std::size_t b = 0; b < bands; ++b)
      values[p * bands + b] = hit > 0 ? sum[b] / hit : std::numeric_limits<float>::quiet_NaN();
  }
  to.write(strip_of(strip, values.data(), bands));
}

/// Nodes weighted by the pixel's mean height and view zenith; not a number where nothing was hit.
void TruthCubes::write_transmission(const render::Strip& strip, products::EnviWriter& to) const {
  const std::size_t pixels = pixels_of(strip), bands = plan_.bands.size();
  std::vector<float> values(pixels * bands);
  for (std::size_t p = 0; p < pixels; ++p) {
    const float* at = strip.truth + p * layers_;
    const float z = at[render::truth::z_m];
    int ih, iv;
    float fh, fv;
    rc_node_weights(z, plan_.height.first, plan_.height.step, plan_.height.count, &ih, &fh);
    rc_node_weights(static_cast<float>(1 / std::cos(base::rad_by_division(at[render::truth::view_zenith_deg]))),
                    plan_.view.first, plan_.view.step, plan_.view.count, &iv, &fv);
    for (std::size_t b = 0; b < bands; ++b) {
      double sum = 0;
      for (int h = 0; h < 2; ++h)
        for (int v = 0; v < 2; ++v) {
          const double w = (h ? fh : 1 - fh) * (v ? fv : 1 - fv);
          if (w != 0) sum += w * node_transmission_[(ih + h) * plan_.view.count + iv + v][b];
        }
      values[p * bands + b] = std::isnan(z) ? z : static_cast<float>(sum);
    }
  }
  to.write(strip_of(strip, values.data(), bands));
}

std::vector<products::EnviHeader*> TruthCubes::headers() {
  std::vector<products::EnviHeader*> out;
  for (Cube& cube : cubes_) out.push_back(&cube.writer.header());
  return out;
}

void TruthCubes::finish(products::RunRecord& record) {
  for (Cube& cube : cubes_) {
    const scene::BandTruthEntry& entry = scene::band_truth_entry(cube.truth);
    cube.writer.finish();
    record.files.emplace_back(entry.file() + ".img", std::string(entry.text) + ", per band, ENVI");
  }
}

}  // namespace raycube::run
