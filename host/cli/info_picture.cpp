#include "host/cli/info_picture.h"

#include <ostream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "host/base/interrupt.h"
#include "host/base/text.h"
#include "host/cli/info_statistics.h"
#include "host/products/picture_reader.h"

namespace raycube::cli {
namespace {

using products::Picture;
using products::PictureChannel;
using products::PicturePart;

nlohmann::ordered_json picture_part_json(const PicturePart& part) {
  nlohmann::ordered_json out = {{"width", part.width}, {"height", part.height}};
  if (!part.name.empty()) out["name"] = part.name;
  if (!part.compression.empty()) out["compression"] = part.compression;
  out["channels"] = nlohmann::ordered_json::array();
  for (const PictureChannel& channel : part.channels) {
    out["channels"].push_back({{"name", channel.name}, {"type", channel.type}});
    if (channel.statistics) out["channels"].back()["statistics"] = statistics_json(*channel.statistics);
  }
  if (!part.texts.empty()) out["texts"] = part.texts;
  return out;
}

/// "float", or how many channels are of each type.
std::string types_text(const PicturePart& part) {
  std::map<std::string, int> types;
  for (const PictureChannel& channel : part.channels) ++types[channel.type];
  if (types.size() == 1) return types.begin()->first;
  std::string out;
  for (const auto& [type, count] : types) out += fmt::format("{}{} {}", out.empty() ? "" : ", ", count, type);
  return out;
}

void print_part(std::ostream& out, const PicturePart& part) {
  if (!part.name.empty()) out << fmt::format("  part          {}\n", part.name);
  out << fmt::format("  size          {} x {} pixels, {}, {}{}\n", part.width, part.height,
                     base::counted(part.channels.size(), "channel"), types_text(part),
                     part.compression.empty() ? "" : ", compression " + part.compression);
  for (const auto& [key, text] : part.texts) out << fmt::format("  {:<13} {}\n", key, text);
  if (part.channels.empty()) return;
  if (!part.channels.front().statistics) {
    std::vector<std::string> names;
    for (const PictureChannel& channel : part.channels) names.push_back(channel.name);
    out << fmt::format("  channels      {}\n", fmt::join(names, ", "));
    return;
  }
  out << statistics_title();
  for (const PictureChannel& channel : part.channels) out << statistics_line(channel.name, *channel.statistics);
}

}  // namespace

void print_picture_info(Invocation& invocation, const std::string& path, bool header_only) {
  const Picture picture = products::read_picture(path, header_only, [](std::int64_t) { base::throw_if_interrupted(); });
  if (invocation.common.json) {
    nlohmann::ordered_json out = {{"kind", "picture"}, {"file", path}, {"format", picture.format}};
    if (picture.transform) out["transform"] = *picture.transform;
    out["parts"] = nlohmann::ordered_json::array();
    for (const PicturePart& part : picture.parts) out["parts"].push_back(picture_part_json(part));
    invocation.out << out.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << "\n";
    return;
  }
  invocation.out << fmt::format("{}: {}\n", path, picture.format);
  if (picture.transform)
    invocation.out << fmt::format("  map           {:.10g}\n", fmt::join(*picture.transform, ", "));
  for (const PicturePart& part : picture.parts) print_part(invocation.out, part);
}

}  // namespace raycube::cli
