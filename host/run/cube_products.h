// Everything a render leaves in an instrument's folder, written strip by strip.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "host/base/output_file.h"
#include "host/run/camera_job.h"
#include "host/products/run_record.h"

namespace raycube::run {

/// Refuses before the work what the end of it would refuse: a cube that is there already (unless replaced), a place
/// that cannot be a folder or cannot be written. Makes nothing.
void check_output_place(const std::string& folder, bool overwrite);

class CubeProducts {
 public:
  /// Begins the files in `folder`; refuses at once what exists (unless replaced) and a disk without room.
  CubeProducts(const std::string& folder, base::IfExists if_exists, const scene::Simulation& simulation,
               const CameraJob& job);
  ~CubeProducts();

  /// Throws Error(bug) when a radiance is no number (RadianceGuard).
  void add(const render::Strip& strip);
  /// Of what was added: pixels brighter than can be.
  std::optional<std::string> warning() const;
  /// Finishes every file, fills the record's digest, files and figures of the output, writes run.json and names them
  /// all.
  void publish(products::RunRecord& record);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::run
