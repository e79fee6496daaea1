#include "host/products/png_writer.h"

#include <csetjmp>

#include <png.h>

#include "host/base/error.h"

namespace raycube::products {
namespace {

/// What libpng's callbacks reach. Failures leave by longjmp, so nothing with a destructor lives in encode().
struct Sink {
  std::vector<std::uint8_t> bytes;
  char message[200] = "";
};

void take(png_structp png, png_bytep data, png_size_t length) {
  auto& bytes = static_cast<Sink*>(png_get_io_ptr(png))->bytes;
  bytes.insert(bytes.end(), data, data + length);
}
void nothing(png_structp) {}
void fail(png_structp png, png_const_charp message) {
  auto* sink = static_cast<Sink*>(png_get_error_ptr(png));
  std::snprintf(sink->message, sizeof sink->message, "%s", message);
  std::longjmp(png_jmpbuf(png), 1);
}
void ignore(png_structp, png_const_charp) {}

bool encode(Sink& sink, std::uint32_t width, std::uint32_t height, int channels, png_bytep pixels, png_textp text,
            int texts) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &sink, fail, ignore);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  if (!info || setjmp(png_jmpbuf(png))) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, &sink, take, nothing);
  png_set_IHDR(png, info, width, height, 8, channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (texts > 0) png_set_text(png, info, text, texts);
  png_write_info(png, info);
  for (std::uint32_t y = 0; y < height; ++y)
    png_write_row(png, pixels + static_cast<std::size_t>(y) * width * channels);
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return true;
}

}  // namespace

void write_png(base::OutputFile& file, std::uint32_t width, std::uint32_t height, int channels,
               const std::vector<std::uint8_t>& pixels, const std::map<std::string, std::string>& text) {
  if ((channels != 1 && channels != 3) || pixels.size() != static_cast<std::size_t>(width) * height * channels)
    throw base::Error(base::Fault::bug, file.final_path() + ": PNG of another size than its pixels");
  std::vector<png_text> chunks;
  for (const auto& [key, value] : text) {
    png_text chunk{};
    chunk.compression = PNG_TEXT_COMPRESSION_NONE;
    chunk.key = const_cast<char*>(key.c_str());
    chunk.text = const_cast<char*>(value.c_str());
    chunk.text_length = value.size();
    chunks.push_back(chunk);
  }
  Sink sink;
  if (!encode(sink, width, height, channels, const_cast<png_bytep>(pixels.data()), chunks.data(),
              static_cast<int>(chunks.size())))
    throw base::Error(base::Fault::bug, file.final_path() + ": libpng: " + sink.message);
  file.append(sink.bytes.data(), sink.bytes.size());
}

}  // namespace raycube::products
