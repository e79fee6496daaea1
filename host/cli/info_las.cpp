#include "host/cli/info_las.h"

#include <ostream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "host/base/memory.h"
#include "host/products/las_layout.h"
#include "host/products/las_reader.h"

namespace raycube::cli {
namespace {

using Json = nlohmann::ordered_json;
using namespace products;

const char* where_packets(const LasInfo& info) {
  if (!las::has_packets(info.format)) return "none";
  return info.packets_at ? "internal" : info.packet_file.empty() ? "missing" : "external";
}

Json las_json(const LasInfo& info) {
  Json out = {{"kind", "las"},
              {"file", info.path},
              {"version", fmt::format("{}.{}", info.major, info.minor)},
              {"format", info.format},
              {"compressed", info.compressed},
              {"record_bytes", info.record_bytes},
              {"points", info.points},
              {"by_return", info.by_return},
              {"low", info.low},
              {"high", info.high},
              {"scale", info.scale},
              {"offset", info.offset},
              {"global_encoding", info.global_encoding},
              {"source_id", info.source_id},
              {"system_id", info.system_id},
              {"software", info.software},
              {"creation_year", info.creation_year},
              {"creation_day", info.creation_day},
              {"wkt", info.wkt}};
  if (info.pulses) out["pulses"] = *info.pulses;
  if (info.pulses_without_return) out["pulses_without_return"] = *info.pulses_without_return;
  out["extra_fields"] = Json::array();
  for (const auto& f : info.extra_fields)
    out["extra_fields"].push_back({{"name", f.name}, {"type", las_type_name(f.type)}, {"description", f.description}});
  if (las::has_packets(info.format)) {
    Json& waves = out["waveforms"] = {
        {"where", where_packets(info)}, {"bytes", info.packet_bytes}, {"descriptors", Json::array()}};
    if (!info.packet_file.empty()) waves["file"] = info.packet_file;
    for (const auto& [index, d] : info.descriptors)
      waves["descriptors"].push_back({{"index", index},
                                      {"bits", d.bits},
                                      {"samples", d.samples},
                                      {"spacing_ps", d.spacing_ps},
                                      {"gain", d.gain},
                                      {"offset", d.offset}});
  }
  for (const auto& r : info.records)
    out["records"].push_back(
        {{"user", r.user}, {"id", r.id}, {"bytes", r.bytes}, {"description", r.description}, {"extended", r.extended}});
  return out;
}

void print_text(std::ostream& out, const LasInfo& info) {
  const auto line = [&](const char* name, const std::string& value) {
    if (!value.empty()) out << fmt::format("  {:<13} {}\n", name, value);
  };
  out << fmt::format("{}: LAS {}.{}{}, point format {}\n", info.path, info.major, info.minor,
                     info.compressed ? " compressed (LAZ)" : "", info.format);
  line("size",
       fmt::format("{} points of {} bytes, {}", info.points, info.record_bytes, base::format_bytes(info.file_bytes)));
  std::string returns;
  for (std::size_t i = 0; i < info.by_return.size(); ++i)
    if (info.by_return[i]) returns += fmt::format("{}{}: {}", returns.empty() ? "" : ", ", i + 1, info.by_return[i]);
  line("by return", returns);
  if (info.pulses)
    line("pulses", fmt::format("{}, of these {} without return", *info.pulses, info.pulses_without_return.value_or(0)));
  for (std::size_t i = 0; i < 3 && info.points; ++i)
    line(i == 0   ? "x"
         : i == 1 ? "y"
                  : "z",
         fmt::format("{:.4f} to {:.4f}, scale {} from {}", info.low[i], info.high[i], info.scale[i], info.offset[i]));
  const auto quote = info.wkt.find('"');
  const std::string system =
      quote == std::string::npos ? info.wkt : info.wkt.substr(quote + 1, info.wkt.find('"', quote + 1) - quote - 1);
  line("coordinates", !system.empty() ? system : info.geotiff_keys ? "GeoTIFF keys" : "not stated");
  line("GPS time", info.global_encoding & las::kAdjustedGpsTime ? "adjusted standard (GPS - 1e9 s)" : "week or none");
  line("written by", fmt::format("{}{}{}", info.software, info.system_id.empty() ? "" : ", system ", info.system_id));
  if (info.creation_year) line("written on", fmt::format("day {} of {}", info.creation_day, info.creation_year));
  if (las::has_packets(info.format)) {
    line("waveforms", fmt::format("{}, {}{}{}", where_packets(info), base::format_bytes(info.packet_bytes),
                                  info.packet_file.empty() ? "" : " in ", info.packet_file));
    for (const auto& [index, d] : info.descriptors)
      line(fmt::format("  kind {}", index).c_str(),
           fmt::format("{} samples of {} bits every {} ps, value = {} + {} x sample", d.samples, d.bits, d.spacing_ps,
                       d.offset, d.gain));
  }
  if (!info.extra_fields.empty()) {
    std::string fields;
    for (const auto& f : info.extra_fields)
      fields += fmt::format("{}{} ({})", fields.empty() ? "" : ", ", f.name, las_type_name(f.type));
    line("extra bytes", fields);
  }
}

}  // namespace

void print_las_info(Invocation& invocation, const std::string& path) {
  const LasInfo info = read_las_info(path);
  for (const auto& warning : info.warnings) invocation.log.warning(warning);
  if (invocation.common.json)
    invocation.out << las_json(info).dump(2, ' ', false, Json::error_handler_t::replace) << "\n";
  else
    print_text(invocation.out, info);
}

}  // namespace raycube::cli
