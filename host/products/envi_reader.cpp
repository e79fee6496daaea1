#include "host/products/envi_reader.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <numeric>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/input_file.h"
#include "host/base/publication.h"
#include "host/base/memory.h"
#include "host/base/text.h"

namespace raycube::products {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::Fault;

bool is_file(const std::string& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool ends_with_hdr(const std::string& path) {
  const std::string tail = path.size() >= 4 ? path.substr(path.size() - 4) : "";
  return tail == ".hdr" || tail == ".HDR";
}

/// Numbers of a file's bytes, both `in` and `out` at strides.
template <class T>
void decode(const unsigned char* in, std::size_t in_bytes, std::size_t count, bool swap, double* out,
            std::size_t out_stride) {
  const auto value = [&](const unsigned char* bytes) {
    T number;
    std::memcpy(&number, bytes, sizeof(T));
    return static_cast<double>(number);
  };
  if (swap && sizeof(T) > 1) {
    for (std::size_t i = 0; i < count; ++i) {
      unsigned char turned[sizeof(T)];
      std::reverse_copy(in + i * in_bytes, in + i * in_bytes + sizeof(T), turned);
      out[i * out_stride] = value(turned);
    }
  } else if (in_bytes == sizeof(T) && out_stride == 1) {  // known strides: eight at a time
    for (std::size_t i = 0; i < count; ++i) out[i] = value(in + i * sizeof(T));
  } else {
    for (std::size_t i = 0; i < count; ++i) out[i * out_stride] = value(in + i * in_bytes);
  }
}

using Decode = void (*)(const unsigned char*, std::size_t, std::size_t, bool, double*, std::size_t);

/// Decoder of one component of a data type.
Decode decoder(int data_type) {
  switch (data_type) {
    case 1:
      return decode<std::uint8_t>;
    case 2:
      return decode<std::int16_t>;
    case 3:
      return decode<std::int32_t>;
    case 4:
    case 6:
      return decode<float>;
    case 5:
    case 9:
      return decode<double>;
    case 12:
      return decode<std::uint16_t>;
    case 13:
      return decode<std::uint32_t>;
    case 14:
      return decode<std::int64_t>;
    default:
      return decode<std::uint64_t>;
  }
}

}  // namespace

EnviPaths find_envi_pair(const std::string& path) {
  if (ends_with_hdr(path)) {
    if (!is_file(path)) throw Error(Fault::input, path + ": no such file");
    const std::string stem = path.substr(0, path.size() - 4);
    for (const char* extension :
         {"", ".img", ".dat", ".sli", ".bsq", ".bil", ".bip", ".raw", ".bin", ".lib", ".IMG", ".DAT"})
      if (is_file(stem + extension)) return {path, stem + extension};
    return {path, ""};
  }
  if (!is_file(path)) throw Error(Fault::input, path + ": no such file");
  const std::string stem = fs::path(path).replace_extension().string();
  for (const std::string& header : {path + ".hdr", path + ".HDR", stem + ".hdr", stem + ".HDR"})
    if (is_file(header)) return {header, path};
  throw Error(Fault::input,
              fmt::format("{}: its ENVI header is missing (looked for {}.hdr and {}.hdr)", path, path, stem));
}

struct EnviReader::State {
  EnviPaths paths;
  EnviHeader header;
  int fd = -1;
  ~State() {
    if (fd >= 0) ::close(fd);
  }

  Error was_cut() const {
    struct stat now {};
    ::fstat(fd, &now);
    return Error(Fault::environment,
                 fmt::format("{}: was cut while it was read: its header describes {} bytes (found {}); let the program "
                             "that writes it end, or copy the file again",
                             paths.data, header.header_offset + header.data_bytes(), now.st_size));
  }
  void read_at(std::uint64_t offset, unsigned char* out, std::size_t bytes) const {
    while (bytes > 0) {
      const ssize_t got = ::pread(fd, out, std::min<std::size_t>(bytes, 1u << 30), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0)
        throw Error(Fault::environment,
                    fmt::format("{}: reading failed at byte {}: {}", paths.data, offset, std::strerror(errno)));
      if (got == 0) throw was_cut();
      out += got, offset += static_cast<std::uint64_t>(got), bytes -= static_cast<std::size_t>(got);
    }
  }
};

EnviReader::EnviReader(const std::string& path) : state_(std::make_unique<State>()) {
  State& s = *state_;
  base::finish_publication_around(path);
  s.paths = find_envi_pair(path);
  s.header = read_envi_header(s.paths.header);
  if (s.paths.data.empty())
    throw Error(Fault::input, s.paths.header +
                                  ": its data file is missing (looked for the same name without .hdr, with .img, .dat, "
                                  ".sli, .bsq, .bil, .bip)");
  base::refuse_other_than_plain(s.paths.data);
  s.fd = ::open(s.paths.data.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (s.fd < 0 || ::fstat(s.fd, &status) != 0)
    throw Error(Fault::input, fmt::format("{}: cannot be opened: {}", s.paths.data, std::strerror(errno)));
  const std::uint64_t wanted = s.header.header_offset + s.header.data_bytes(),
                      found = static_cast<std::uint64_t>(status.st_size);
  if (found < wanted)
    throw Error(Fault::input, fmt::format("{}: is too short: {} samples x {} lines x {} bands of {} and a header "
                                          "offset of {} need {} bytes (found {}); "
                                          "the file is truncated or the header is another file's",
                                          s.paths.data, s.header.samples, s.header.lines, s.header.bands,
                                          s.header.type().name, s.header.header_offset, wanted, found));
  if (found > wanted)
    s.header.warnings.push_back(
        fmt::format("{}: has {} more than its header describes", s.paths.data, base::counted(found - wanted, "byte")));
}

EnviReader::~EnviReader() = default;
EnviReader::EnviReader(EnviReader&&) noexcept = default;
const EnviHeader& EnviReader::header() const { return state_->header; }
const EnviPaths& EnviReader::paths() const { return state_->paths; }

std::size_t EnviReader::values_per_pixel() const {
  return static_cast<std::size_t>(state_->header.bands) * static_cast<std::size_t>(state_->header.type().components);
}

std::vector<double> EnviReader::read_lines(std::int64_t first, std::int64_t count) const {
  std::vector<std::size_t> bands(static_cast<std::size_t>(state_->header.bands));
  std::iota(bands.begin(), bands.end(), std::size_t{0});
  std::vector<double> out;
  read_bands(first, count, bands, out);
  return out;
}

void EnviReader::read_bands(std::int64_t first, std::int64_t count, std::span<const std::size_t> chosen,
                            std::vector<double>& out) const {
  const State& s = *state_;
  const EnviHeader& h = s.header;
  if (first < 0 || count < 0 || first + count > h.lines)
    throw Error(Fault::bug,
                fmt::format("{}: lines {} to {} of {} asked for", s.paths.data, first, first + count, h.lines));
  const std::size_t samples = static_cast<std::size_t>(h.samples), bands = static_cast<std::size_t>(h.bands),
                    bytes = h.type().bytes, parts = static_cast<std::size_t>(h.type().components),
                    part_bytes = bytes / parts, lines = static_cast<std::size_t>(count), line_bytes = samples * bytes;
  const bool swap = (h.byte_order == 1) != (std::endian::native == std::endian::big);
  const Decode decoded = decoder(h.data_type);
  const std::size_t pixel = chosen.size() * parts;  // numbers of one
  out.resize(lines * samples * pixel);
  const auto part_of_band = [&](const unsigned char* in, std::size_t in_bytes, std::size_t many, double* to) {
    for (std::size_t part = 0; part < parts; ++part)
      decoded(in + part * part_bytes, in_bytes, many, swap, to + part, pixel);
  };
  thread_local std::vector<unsigned char> raw;  // kept: pages that are given back are cleared when they are asked for
  if (h.interleave == Interleave::bsq) {
    raw.resize(lines * line_bytes);
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      const std::uint64_t line = chosen[k] * static_cast<std::uint64_t>(h.lines) + static_cast<std::uint64_t>(first);
      s.read_at(h.header_offset + line * line_bytes, raw.data(), raw.size());
      part_of_band(raw.data(), bytes, lines * samples, out.data() + k * parts);
    }
    return;
  }
  raw.resize(lines * line_bytes * bands);
  s.read_at(h.header_offset + static_cast<std::uint64_t>(first) * line_bytes * bands, raw.data(), raw.size());
  const bool bip = h.interleave == Interleave::bip;
  if (bip && chosen.size() == bands && std::is_sorted(chosen.begin(), chosen.end())) {  // as it lies there
    decoded(raw.data(), part_bytes, out.size(), swap, out.data(), 1);
    return;
  }
  for (std::size_t l = 0; l < lines; ++l)
    for (std::size_t k = 0; k < chosen.size(); ++k)
      part_of_band(raw.data() + l * line_bytes * bands + chosen[k] * (bip ? bytes : line_bytes),
                   bip ? bands * bytes : bytes, samples, out.data() + l * samples * pixel + k * parts);
}

bool EnviReader::holds_plain_floats() const {
  const EnviHeader& h = state_->header;
  const bool native = (h.byte_order == 1) == (std::endian::native == std::endian::big);
  return h.data_type == 4 && h.interleave == Interleave::bip && native;
}

void EnviReader::read_floats(std::uint64_t first_pixel, std::size_t count, float* out) const {
  const State& s = *state_;
  const std::size_t pixel_bytes = static_cast<std::size_t>(s.header.bands) * sizeof(float);
  s.read_at(s.header.header_offset + first_pixel * pixel_bytes, reinterpret_cast<unsigned char*>(out),
            count * pixel_bytes);
}

std::vector<double> EnviReader::read_lines_scaled(std::int64_t first, std::int64_t count) const {
  std::vector<double> out = read_lines(first, count);
  const EnviHeader& h = state_->header;
  if ((h.data_gain.empty() && h.data_offset.empty()) || h.type().components != 1) return out;
  const auto bands = static_cast<std::size_t>(h.bands), samples = static_cast<std::size_t>(h.samples);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = h.scaled(out[i], i / bands % samples, i % bands);
  return out;
}

std::vector<double> EnviReader::read_pixel(std::int64_t line, std::int64_t sample) const {
  const auto whole = read_lines(line, 1);
  const std::size_t per_pixel = values_per_pixel();
  if (sample < 0 || sample >= state_->header.samples) throw Error(Fault::bug, "sample outside the image");
  const auto begin = whole.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(sample) * per_pixel);
  return {begin, begin + static_cast<std::ptrdiff_t>(per_pixel)};
}

}  // namespace raycube::products
