#include "host/products/exr_writer.h"

#include <algorithm>
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

constexpr std::int64_t kChunkLines = 16;  ///< of ZIP_COMPRESSION

/// OpenEXR's bytes into our output file, so that its errors and its temporary name are ours.
class Stream : public Imf::OStream {
 public:
  explicit Stream(base::OutputFile& file) : Imf::OStream(file.final_path().c_str()), file_(file) {}
  void write(const char* bytes, int count) override {
    if (failure_) return;
    try {
      file_.write_at(position_, bytes, static_cast<std::size_t>(count));
    } catch (...) {
      failure_ =
          std::current_exception();  // the library may swallow what its destructors meet: rethrow_failure() does not
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
  std::int64_t next_line = 0;
};

ExrWriter::ExrWriter(base::OutputFile& file, std::int64_t width, std::int64_t height, const std::vector<ExrPart>& parts,
                     const std::map<std::string, std::string>& attributes)
    : state_(new State{Stream(file), width, height, parts, nullptr}) {
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
    state_->file = std::make_unique<Imf::MultiPartOutputFile>(state_->stream, headers.data(),
                                                              static_cast<int>(headers.size()), false, 0);
  } catch (const std::exception& failure) {
    state_->stream.rethrow_failure();
    throw Error(Fault::bug, file.final_path() + ": OpenEXR refused the header: " + failure.what());
  }
}

ExrWriter::~ExrWriter() = default;

void ExrWriter::write(const std::vector<ExrLines>& parts) {
  State& s = *state_;
  const std::int64_t first = parts.empty() ? 0 : parts[0].strip.first_line,
                     lines = parts.empty() ? 0 : parts[0].strip.lines;
  bool sound = parts.size() == s.parts.size();
  for (std::size_t p = 0; sound && p < parts.size(); ++p) {
    const Strip& strip = parts[p].strip;
    sound = strip.first_line == first && strip.lines == lines &&
            parts[p].values_of.size() == s.parts[p].channels.size() && strip.pixel_stride != 0;
  }
  if (!sound || first != s.next_line)
    throw Error(Fault::bug,
                fmt::format("EXR: lines from {} came of {} parts, line {} is next", first, parts.size(), s.next_line));
  try {
    std::vector<Imf::OutputPart> outputs;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const auto& [strip, values_of] = parts[p];
      const std::size_t x_step = strip.pixel_stride * sizeof(float),
                        y_step = x_step * static_cast<std::size_t>(s.width);
      Imf::FrameBuffer buffer;
      for (std::size_t c = 0; c < values_of.size(); ++c) {
        // A slice's base is where pixel (0, 0) of the whole image would lie; only lines of the strip are
        // touched.
        const auto at = reinterpret_cast<std::uintptr_t>(strip.values + values_of[c]);
        const auto base = at - static_cast<std::size_t>(first) * y_step;
        buffer.insert(s.parts[p].channels[c], Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(base), x_step, y_step));
      }
      outputs.emplace_back(*s.file, static_cast<int>(p)).setFrameBuffer(buffer);
    }
    // A chunk goes to the file when its last line comes. Up to the end of one at a time, part after part, so
    // that the chunks' order in the file is that of the image and not that of the strips, which memory cuts.
    for (std::int64_t line = first; line < first + lines;) {
      const std::int64_t next = std::min(first + lines, (line / kChunkLines + 1) * kChunkLines);
      for (auto& output : outputs) output.writePixels(static_cast<int>(next - line));
      line = next;
    }
  } catch (const std::exception& failure) {
    s.stream.rethrow_failure();
    throw Error(Fault::bug, std::string("OpenEXR: ") + failure.what());
  }
  s.next_line += lines;
}

void ExrWriter::finish() {
  State& s = *state_;
  if (s.next_line != s.height)
    throw Error(Fault::bug, fmt::format("EXR: {} of {} lines were written", s.next_line, s.height));
  s.file.reset();
  s.stream.rethrow_failure();
}

}  // namespace raycube::products
