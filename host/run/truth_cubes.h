// Truth per band on its way into files: a cube for each entry of scene_compiler/band_truth.def that an instrument asks
// for.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/base/output_file.h"
#include "host/products/envi_writer.h"
#include "host/products/run_record.h"
#include "host/render/types.h"
#include "host/run/camera_job.h"

namespace raycube::run {

class TruthCubes {
 public:
  /// Header of a cube of the instrument's bands: unit, description.
  using MakeHeader = std::function<products::EnviHeader(const std::string& unit, const std::string& text)>;

  /// Begins the files in the set. Keeps references.
  TruthCubes(base::OutputSet& set, const scene::Simulation& simulation, const CameraJob& job, const MakeHeader& header);

  /// Of a strip whose columns are bands and truth.
  void write(const render::Strip& strip);
  /// For what a header gets before the end.
  std::vector<products::EnviHeader*> headers();
  /// Once the image is whole: finishes the files and names them in the record.
  void finish(products::RunRecord& record);

 private:
  struct Cube {
    scene::BandTruth truth;
    products::EnviWriter writer;
  };
  products::Strip strip_of(const render::Strip& strip, const float* values, std::size_t stride) const;
  std::size_t pixels_of(const render::Strip& strip) const;
  void write_means(const render::Strip& strip, std::size_t column, products::EnviWriter& to) const;
  void write_transmission(const render::Strip& strip, products::EnviWriter& to) const;

  const scene::Instrument& instrument_;
  const plan::Plan& plan_;
  std::size_t layers_;  ///< of truth.img
  std::vector<Cube> cubes_;
  std::vector<std::vector<double>> node_transmission_;  ///< [h * view.count + v][band]
};

}  // namespace raycube::run
