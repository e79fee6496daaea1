// Everything a render leaves in an instrument's folder, written strip by strip, in any order.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/output_file.h"
#include "host/run/camera_job.h"
#include "host/run/missed_samples.h"
#include "host/run/services.h"
#include "host/products/run_record.h"

namespace raycube::run {

/// Bands that pictures show, from 0: the file's, else those nearest red, green and blue, or one.
std::vector<int> shown_bands(const scene::Instrument& instrument);

/// Refuses before the work what the end of it would refuse: a cube that is there already (unless replaced), a place
/// that cannot be a folder or cannot be written. Makes nothing.
void check_output_place(const std::string& folder, bool overwrite);

class CubeProducts {
 public:
  /// Begins the files in `folder`; refuses at once what exists (unless replaced) and a disk without room.
  CubeProducts(const std::string& folder, base::IfExists if_exists, const scene::Simulation& simulation,
               const CameraJob& job);
  ~CubeProducts();

  /// To its place in every file, whatever has come before. Throws Error(bug) when it leaves the image or comes twice,
  /// and, at once or in complete(), when a radiance is no number (RadianceGuard).
  void add(const render::Strip& strip);
  /// After the last strip: lets those who need the lines in order (digest, pictures) see what came otherwise, read back
  /// from the files. Throws Error(bug) when something is missing.
  void complete();
  /// Of a complete image: pixels brighter than can be.
  std::optional<std::string> warning() const;
  /// Of a complete image: samples that met nothing.
  const MissedSamples& missed() const;
  /// Finishes every file, fills the record's digest, files and figures of the output, writes run.json and names them
  /// all.
  void publish(products::RunRecord& record, const Services& services);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::run
