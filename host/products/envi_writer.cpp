#include "host/products/envi_writer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "host/base/error.h"

namespace raycube::products {
namespace {

static_assert(std::endian::native == std::endian::little, "samples are written as they lie in memory, byte order 0");

using base::Error;
using base::Fault;

constexpr std::size_t kPart_bytes = 8u << 20;  // rearranged at a time: fits the outer cache, keeps memory bounded
constexpr std::size_t kBlock = 64;  // side of a transposed block: 64 x 64 floats are 16 KiB, half of an L1 cache

/// to[b * pixels + p] = convert(from[p * stride + b]) in cache-sized blocks.
template <class Sample, class Convert>
void transpose(const float* from, std::size_t stride, std::size_t pixels, std::size_t bands, Sample* to,
               std::size_t to_stride, const Convert& convert) {
  for (std::size_t b0 = 0; b0 < bands; b0 += kBlock)
    for (std::size_t p0 = 0; p0 < pixels; p0 += kBlock) {
      const std::size_t b1 = std::min(bands, b0 + kBlock), p1 = std::min(pixels, p0 + kBlock);
      for (std::size_t b = b0; b < b1; ++b)
        for (std::size_t p = p0; p < p1; ++p) to[b * to_stride + p] = convert(from[p * stride + b]);
    }
}

}  // namespace

EnviWriter::EnviWriter(base::OutputSet& set, const std::string& name, EnviHeader header,
                       std::optional<double> integer_scale)
    : data_(set.add(name)),
      text_(set.add(std::filesystem::path(name).replace_extension(".hdr").string())),
      header_(std::move(header)),
      integer_scale_(integer_scale),
      coverage_(data_.final_path(), header_.samples, header_.lines) {
  if (header_.samples < 1 || header_.lines < 1 || header_.bands < 1)
    throw Error(Fault::bug, name + ": image without extent");
  const auto bands = static_cast<std::size_t>(header_.bands);
  const auto fits = [&](std::size_t length) { return length == 0 || length == bands; };
  if (!fits(header_.wavelength.size()) || !fits(header_.fwhm.size()) || !fits(header_.band_names.size()))
    throw Error(Fault::bug, name + ": a header list has another length than the number of bands");
  if (!header_.wavelength.empty() && header_.wavelength_units != "Micrometers" &&
      header_.wavelength_units != "Nanometers")
    throw Error(Fault::bug, name + ": wavelength units must be Micrometers or Nanometers");
  header_.byte_order = 0;
  header_.header_offset = 0;
  header_.data_type = 4;
  if (integer_scale_) {
    if (!(*integer_scale_ > 0) || !std::isfinite(*integer_scale_))
      throw Error(Fault::input,
                  fmt::format("{}: the integer scale must be a positive number (found {})", name, *integer_scale_));
    header_.data_type = 12;
    header_.data_gain.assign(bands, 1.0 / *integer_scale_);
    header_.data_offset.assign(bands, 0.0);
    if (header_.data_ignore_value) header_.data_ignore_value = 0;
  }
  data_.reserve(header_.data_bytes());
}

/// values: of the piece alone, in the file's interleave. Runs that lie beside one another in the file go at once.
template <class Sample>
void EnviWriter::write_piece(const Piece& piece, const Sample* values) {
  const auto samples = static_cast<std::uint64_t>(header_.samples),
             all_lines = static_cast<std::uint64_t>(header_.lines), bands = static_cast<std::uint64_t>(header_.bands),
             lines = static_cast<std::uint64_t>(piece.lines), first_line = static_cast<std::uint64_t>(piece.first_line),
             first_sample = static_cast<std::uint64_t>(piece.first_sample),
             wide = static_cast<std::uint64_t>(piece.samples);
  const bool bip = header_.interleave == Interleave::bip, bsq = header_.interleave == Interleave::bsq;
  // Rows of the piece: of all bands of a line (BIP), or of one band.
  const std::uint64_t row_values = bip ? wide * bands : wide, rows = bip ? lines : lines * bands;
  const std::uint64_t beside = wide == samples ? (bsq ? lines : rows) : 1;  // rows that follow one another in the file
  for (std::uint64_t row = 0; row < rows; row += beside) {
    const std::uint64_t in_file =
        bsq ? row / lines * all_lines + first_line + row % lines : first_line * (bip ? 1 : bands) + row;
    const std::uint64_t at = bip ? (in_file * samples + first_sample) * bands : in_file * samples + first_sample;
    data_.write_at(at * sizeof(Sample), values + row * row_values, beside * row_values * sizeof(Sample));
  }
}

template <class Sample, class Convert>
void EnviWriter::write_as(const Strip& strip, Convert convert) {
  const Piece piece = strip.piece(header_.samples);
  const auto samples = static_cast<std::size_t>(piece.samples), bands = static_cast<std::size_t>(header_.bands);
  const std::size_t stride = strip.pixel_stride ? strip.pixel_stride : bands;
  const std::size_t line_samples = samples * bands;
  const std::size_t part_lines = std::max<std::size_t>(1, kPart_bytes / (line_samples * sizeof(Sample)));
  for (std::size_t l0 = 0; l0 < static_cast<std::size_t>(strip.lines); l0 += part_lines) {
    const std::size_t lines = std::min(part_lines, static_cast<std::size_t>(strip.lines) - l0),
                      pixels = lines * samples;
    const float* const from = strip.values + l0 * samples * stride;
    buffer_.resize(lines * line_samples * sizeof(Sample));
    auto* const to = reinterpret_cast<Sample*>(buffer_.data());
    switch (header_.interleave) {
      case Interleave::bip:
        for (std::size_t p = 0; p < pixels; ++p)
          for (std::size_t b = 0; b < bands; ++b) to[p * bands + b] = convert(from[p * stride + b]);
        break;
      case Interleave::bil:
        for (std::size_t l = 0; l < lines; ++l)
          transpose(from + l * samples * stride, stride, samples, bands, to + l * line_samples, samples, convert);
        break;
      case Interleave::bsq:
        transpose(from, stride, pixels, bands, to, pixels, convert);
        break;
    }
    write_piece<Sample>({piece.first_line + static_cast<std::int64_t>(l0), static_cast<std::int64_t>(lines),
                         piece.first_sample, piece.samples},
                        to);
  }
}

/// Apart from the conversion, so that both loops stay free of branches.
void EnviWriter::count_clipped(const Strip& strip, float scale) {
  const auto bands = static_cast<std::size_t>(header_.bands), stride = strip.pixel_stride ? strip.pixel_stride : bands;
  const std::size_t pixels = static_cast<std::size_t>(strip.lines * strip.piece(header_.samples).samples);
  for (std::size_t p = 0; p < pixels; ++p) {
    const float* const pixel = strip.values + p * stride;
    std::uint32_t low = 0, high = 0, nan = 0;
    float largest = 0;
    for (std::size_t b = 0; b < bands; ++b) {
      const float scaled = pixel[b] * scale;
      low += scaled < -0.5f;
      high += scaled >= 65535.5f;
      nan += scaled != scaled;
      largest = std::max(largest, pixel[b]);
    }
    clipped_.largest = std::max(clipped_.largest, static_cast<double>(largest));
    clipped_.low += low, clipped_.high += high, clipped_.nan += nan;
  }
}

void EnviWriter::write(const Strip& strip) {
  const auto bands = static_cast<std::size_t>(header_.bands);
  if (strip.pixel_stride != 0 && strip.pixel_stride < bands)
    throw Error(Fault::bug, "pixel stride shorter than the bands");
  coverage_.add(strip.piece(header_.samples));
  if (integer_scale_) {
    const float scale = static_cast<float>(*integer_scale_);
    count_clipped(strip, scale);
    write_as<std::uint16_t>(strip, [scale](float value) -> std::uint16_t {
      const float scaled = value * scale;
      const float held = scaled > 0.0f ? (scaled < 65535.0f ? scaled : 65535.0f) : 0.0f;  // NaN becomes 0
      return static_cast<std::uint16_t>(static_cast<std::int32_t>(held + 0.5f));
    });
  } else if (header_.interleave == Interleave::bip && (strip.pixel_stride == 0 || strip.pixel_stride == bands)) {
    write_piece(strip.piece(header_.samples), strip.values);
  } else {
    write_as<float>(strip, [](float value) { return value; });
  }
}

void EnviWriter::finish() {
  coverage_.require_whole();
  text_.append(envi_header_text(header_));
}

void EnviWriter::read_back(std::int64_t first_line, std::int64_t lines, float* values) const {
  if (integer_scale_ || !coverage_.has(first_line, lines))
    throw Error(Fault::bug, data_.final_path() + ": these lines cannot be read back");
  const auto samples = static_cast<std::size_t>(header_.samples), bands = static_cast<std::size_t>(header_.bands);
  std::vector<float> row(samples);
  for (std::int64_t l = 0; l < lines; ++l) {
    float* const line = values + static_cast<std::size_t>(l) * samples * bands;
    const auto number = static_cast<std::uint64_t>(first_line + l);
    if (header_.interleave == Interleave::bip) {
      data_.read_at(number * samples * bands * sizeof(float), line, samples * bands * sizeof(float));
      continue;
    }
    for (std::size_t b = 0; b < bands; ++b) {
      const std::uint64_t run = header_.interleave == Interleave::bil
                                    ? number * bands + b
                                    : b * static_cast<std::uint64_t>(header_.lines) + number;
      data_.read_at(run * samples * sizeof(float), row.data(), samples * sizeof(float));
      for (std::size_t x = 0; x < samples; ++x) line[x * bands + b] = row[x];
    }
  }
}

}  // namespace raycube::products
