// The file of a render table (.rct), docs/table_format.md: a fixed head, a JSON header that describes axes, rows and
// provenance, then little-endian float32 arrays on 64-byte boundaries. Read and written whole; validated both ways.
#pragma once

#include <string>

#include "atmos_tables/render_table.h"
#include "host/base/output_file.h"

namespace raycube::atmos {

inline constexpr unsigned kRctVersion = 1;

/// Writes the table under a temporary name and publishes it. Returns its content hash. Throws Error(input) when the
/// table breaks a rule of the format, Error(environment) when the file cannot be written.
std::string write_rct(const RenderTable& table, const std::string& path, base::IfExists if_exists);

/// Reads and checks a file: magic, version, lengths, hash, header, every axis and value. Throws Error(input) naming the
/// file, what is wrong, the value found and the way out; Error(environment) when it cannot be opened.
RenderTable read_rct(const std::string& path);

/// SHA-256 (64 hex digits) over header and arrays: what the file carries, and the same for equal tables.
std::string content_hash(const RenderTable& table);

}  // namespace raycube::atmos
