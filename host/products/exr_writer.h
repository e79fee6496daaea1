// Multi-part OpenEXR, written strip by strip: truth layers and a few radiance bands under readable channel names.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/base/output_file.h"
#include "host/products/envi_writer.h"

namespace raycube::products {

/// One part: float32 channels. OpenEXR keeps channels in alphabetical order; names like "hit.X" group them.
struct ExrPart {
  std::string name;                   ///< unique in the file
  std::vector<std::string> channels;  ///< unique in the part
};

/// Lines of one part: the strip must state its pixel stride; `values_of[c]` is the index in a pixel of
/// channel c's value, in the order of ExrPart::channels.
struct ExrLines {
  Strip strip;
  std::vector<std::size_t> values_of;
};

class ExrWriter {
 public:
  /// Begins a file of width x height pixels; attributes are stored as strings in every part.
  ExrWriter(base::OutputFile& file, std::int64_t width, std::int64_t height, const std::vector<ExrPart>& parts,
            const std::map<std::string, std::string>& attributes);
  ~ExrWriter();

  /// Next lines, the same of every part. The file's bytes do not depend on how the image is cut into strips.
  void write(const std::vector<ExrLines>& parts);
  /// After the last line of every part. Throws Error(bug) when lines are missing.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::products
