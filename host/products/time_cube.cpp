#include "host/products/time_cube.h"

#include <algorithm>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/products/envi_header.h"

namespace raycube::products {
namespace {
constexpr std::size_t kBuffer_values = std::size_t{1} << 20;
}

TimeCubeWriter::TimeCubeWriter(base::OutputFile& data, base::OutputFile& header, TimeCubeAxis axis,
                               std::vector<TimeCubeBand> bands)
    : data_(data), header_(header), axis_(axis), bands_(std::move(bands)) {
  if (axis_.bins < 1 || axis_.pixels < 1 || bands_.empty() || !(axis_.bin_s > 0))
    throw base::Error(base::Fault::bug, fmt::format("{}: a time cube of {} bins, {} pixels, {} bands",
                                                    data.final_path(), axis_.bins, axis_.pixels, bands_.size()));
}

void TimeCubeWriter::add(const std::vector<float>& values) {
  if (values.size() != bands_.size() * static_cast<std::size_t>(axis_.bins))
    throw base::Error(base::Fault::bug, fmt::format("{}: a record of {} values came where {} bands of {} bins make one",
                                                    data_.final_path(), values.size(), bands_.size(), axis_.bins));
  buffer_.insert(buffer_.end(), values.begin(), values.end());
  ++lines_;
  if (buffer_.size() < kBuffer_values) return;
  data_.append(buffer_.data(), buffer_.size() * sizeof(float));
  buffer_.clear();
}

void TimeCubeWriter::finish(const std::string& description, const std::string& sensor,
                            const std::string& acquisition_time) {
  if (!buffer_.empty()) data_.append(buffer_.data(), buffer_.size() * sizeof(float));
  buffer_.clear();
  EnviHeader h;
  h.samples = axis_.bins;
  h.lines = lines_;
  h.bands = static_cast<std::int64_t>(bands_.size());
  h.interleave = Interleave::bil;
  h.description = description;
  h.sensor_type = sensor;
  h.acquisition_time = acquisition_time;
  for (const auto& band : bands_) h.band_names.push_back(band.name);
  // Twelve digits: the wavelengths of a differential absorption pair lie close together.
  std::string wavelengths = "{";
  for (const auto& band : bands_)
    wavelengths += fmt::format("{}{:.12g}", wavelengths.size() > 1 ? ", " : "", band.wavelength_um);
  h.wavelength_units = "Micrometers";
  h.other["wavelength"] = wavelengths + "}";
  h.other["raycube bin start ns"] = fmt::format("{}", axis_.start_s * 1e9);
  h.other["raycube bin width ns"] = fmt::format("{}", axis_.bin_s * 1e9);
  h.other["raycube group index"] = fmt::format("{}", axis_.group_index);
  h.other["raycube pixels"] = fmt::format("{}", axis_.pixels);
  header_.append(envi_header_text(h));
}

}  // namespace raycube::products
