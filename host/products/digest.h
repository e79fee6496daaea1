// The digest of a result: SHA-256 over the radiance samples in (line, sample, band) order as little-endian float32,
// then the truth layers in (line, sample, layer) order. It says nothing of interleave, scaling, tiles or time.
#pragma once

#include <cstdint>
#include <string>

#include "host/base/sha256.h"
#include "host/products/envi_writer.h"

namespace raycube::products {

class Digest {
 public:
  /// Next radiance lines, in line order.
  void add_radiance(const Strip& strip, std::int64_t samples, std::int64_t bands);
  /// After the last radiance line: the whole truth file, read back from its writer.
  void add_truth(const EnviWriter& truth);
  std::string hex() const { return hash_.hex(); }

 private:
  base::Sha256 hash_;
};

}  // namespace raycube::products
