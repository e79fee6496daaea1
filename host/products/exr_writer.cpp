#include "host/products/exr_writer.h"

#include <exception>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>

#include <fmt/format.h>

#include "host/base/error.h"

namespace raycube::products {
namespace {

using base::Error;
using base::Fault;

/// OpenEXR's bytes into our output file, so that its errors and its temporary name are ours.
class Stream : public Imf::OStream {
 public:
  explicit Stream(base::OutputFile& file) : Imf::OStream(file.final_path().c_str()), file_(file) {}
  void write(const char* bytes, int count) override {
    if (failure_) return;
    try {
      file_.write_at(position_, bytes, static_cast<std::size_t>(count));
    } catch (...) {
      failure_ = std::current_exception();  // the library may swallow what its destructors meet: rethrow_failure() does not
      throw;
    }
    position_ += static_cast<std::uint64_t>(count);
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }
  void rethrow_failure() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  base::OutputFile& file_;
  std::uint64_t position_ = 0;
  std::exception_ptr failure_;
};

}  // namespace

struct ExrWriter::State {
  Stream stream;
  std::int64_t width, height;
  std::vector<ExrPart> parts;
  std::unique_ptr<Imf::MultiPartOutputFile> file;
  std::vector<std::int64_t> next_line;
};

ExrWriter::ExrWriter(base::OutputFile& file, std::int64_t width, std::int64_t height, const std::vector<ExrPart>& parts,
                     const std::map<std::string, std::string>& attributes)
    : state_(new State{Stream(file), width, height, parts, nullptr, std::vector<std::int64_t>(parts.size(), 0)}) {
  std::vector<Imf::Header> headers;
  for (const auto& part : parts) {
    Imf::Header header(static_cast<int>(width), static_cast<int>(height));
    header.setName(part.name);
    header.setType(Imf::SCANLINEIMAGE);
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const auto& channel : part.channels) header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
    for (const auto& [key, text] : attributes) header.insert(key, Imf::StringAttribute(text));
    headers.push_back(std::move(header));
  }
  try {
    state_->file = std::make_unique<Imf::MultiPartOutputFile>(state_->stream, headers.data(), static_cast<int>(headers.size()), false, 0);
  } catch (const std::exception& failure) {
    state_->stream.rethrow_failure();
    throw Error(Fault::bug, file.final_path() + ": OpenEXR refused the header: " + failure.what());
  }
}

ExrWriter::~ExrWriter() = default;

void ExrWriter::write(std::size_t part, const Strip& strip, const std::vector<std::size_t>& values_of) {
  State& s = *state_;
  const auto& channels = s.parts.at(part).channels;
  if (strip.first_line != s.next_line[part] || values_of.size() != channels.size() || strip.pixel_stride == 0)
    throw Error(Fault::bug, fmt::format("EXR part {}: line {} came, {} is next", s.parts[part].name, strip.first_line, s.next_line[part]));
  const std::size_t x_step = strip.pixel_stride * sizeof(float), y_step = x_step * static_cast<std::size_t>(s.width);
  Imf::FrameBuffer buffer;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    // A slice's base is where pixel (0, 0) of the whole image would lie; only lines of the strip are touched.
    const auto first = reinterpret_cast<std::uintptr_t>(strip.values + values_of[c]);
    const auto base = first - static_cast<std::size_t>(strip.first_line) * y_step;
    buffer.insert(channels[c], Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(base), x_step, y_step));
  }
  try {
    Imf::OutputPart output(*s.file, static_cast<int>(part));
    output.setFrameBuffer(buffer);
    output.writePixels(static_cast<int>(strip.lines));
  } catch (const std::exception& failure) {
    s.stream.rethrow_failure();
    throw Error(Fault::bug, std::string("OpenEXR: ") + failure.what());
  }
  s.next_line[part] += strip.lines;
}

void ExrWriter::finish() {
  State& s = *state_;
  for (std::size_t p = 0; p < s.parts.size(); ++p)
    if (s.next_line[p] != s.height)
      throw Error(Fault::bug, fmt::format("EXR part {}: {} of {} lines were written", s.parts[p].name, s.next_line[p], s.height));
  s.file.reset();
  s.stream.rethrow_failure();
}

}  // namespace raycube::products
