#include "host/cli/atmos_export.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <ostream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "atmos_tables/rct_file.h"
#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/base/output_file.h"
#include "host/cli/services.h"
#include "host/products/csv_writer.h"

namespace raycube::cli {

namespace {

struct ExportRequest {
  std::string file;
  std::vector<std::string> rows;
};

/// The rows that are asked for, in the table's order; all of them where none is.
std::vector<const atmos::Row*> chosen_rows(const atmos::RenderTable& table, const ExportRequest& o) {
  for (const std::string& name : o.rows)
    if (!table.has(name)) {
      std::vector<std::string> known;
      for (const auto& [other, row] : table.rows) known.push_back(other);
      throw base::Error(base::Fault::input,
                        fmt::format("{}: has no row '{}'; it has: {}", o.file, name, fmt::join(known, ", ")));
    }
  std::vector<const atmos::Row*> out;
  for (const auto& [name, row] : table.rows)
    if (o.rows.empty() || std::find(o.rows.begin(), o.rows.end(), name) != o.rows.end()) out.push_back(&row);
  return out;
}

/// Axes that some of the rows have, the wavelength first.
std::vector<const atmos::Axis*> axes_of(const atmos::RenderTable& table, const std::vector<const atmos::Row*>& rows) {
  std::vector<const atmos::Axis*> out;
  const auto add = [&](const std::string& name) {
    const atmos::Axis* axis = &table.axis(name);
    if (std::find(out.begin(), out.end(), axis) == out.end()) out.push_back(axis);
  };
  for (const atmos::Row* row : rows)
    if (!row->axes.empty() && row->axes.front() == "wavelength") add("wavelength");
  for (const atmos::Row* row : rows)
    for (const std::string& name : row->axes) add(name);
  return out;
}

/// A line for each value: its row, unit and places on all axes; those that the row has not stay empty.
void add_row(products::CsvWriter& csv, const atmos::RenderTable& table, const atmos::Row& row,
             const std::vector<const atmos::Axis*>& axes) {
  std::vector<std::size_t> stride(axes.size(), 0);  // of the row's values along each axis; 0: it has it not
  std::size_t values = 1;
  for (auto name = row.axes.rbegin(); name != row.axes.rend(); ++name) {
    const atmos::Axis* axis = &table.axis(*name);
    stride[static_cast<std::size_t>(std::find(axes.begin(), axes.end(), axis) - axes.begin())] = values;
    values *= axis->nodes.size();
  }
  for (std::size_t i = 0; i < row.values.size(); ++i) {
    csv.add(row.name).add(row.unit);
    for (std::size_t a = 0; a < axes.size(); ++a) {
      if (stride[a] == 0)
        csv.add("");
      else
        csv.add(axes[a]->nodes[i / stride[a] % axes[a]->nodes.size()]);
    }
    csv.add(row.values[i]);
    csv.end_row();
  }
}

int export_table(const ExportRequest& o, Invocation& invocation) {
  const atmos::RenderTable table = atmos::read_rct(o.file);
  const auto rows = chosen_rows(table, o);
  const auto axes = axes_of(table, rows);
  const std::string output = invocation.common.output.empty()
                                 ? std::filesystem::path(o.file).replace_extension(".csv").string()
                                 : invocation.common.output;
  std::error_code unknown;
  if (std::filesystem::equivalent(output, o.file, unknown))
    throw base::Error(base::Fault::input,
                      output + ": the table itself would be replaced by its values; give another file with -o");
  std::vector<std::string> columns = {"row", "unit"};
  for (const atmos::Axis* axis : axes) columns.push_back(axis->name + (axis->unit.empty() ? "" : "_" + axis->unit));
  columns.push_back("value");
  base::OutputFile file(output, if_exists(invocation.common));
  products::CsvWriter csv(file, columns);
  std::vector<std::string> names;
  for (const atmos::Row* row : rows) {
    base::throw_if_interrupted();
    add_row(csv, table, *row, axes);
    names.push_back(row->name);
  }
  csv.finish();
  file.publish();
  if (invocation.common.json)
    invocation.out << nlohmann::ordered_json{{"table", o.file},
                                             {"csv", output},
                                             {"rows", names},
                                             {"columns", columns},
                                             {"values", csv.rows()}}
                          .dump(2)
                   << "\n";
  else
    invocation.out << output << "\n";
  return 0;
}

}  // namespace

Verb verb_atmos_export() {
  auto o = std::make_shared<ExportRequest>();
  Verb verb("export", "Write a render table as CSV");
  verb.description =
      "One line for each value: the row's name and unit, its place on every axis (named with the unit; empty where the "
      "row does not have the axis), and the value. docs/table_format.md says what the rows are.";
  verb.examples = {"raycube atmos export park.rct",
                   "raycube atmos export park.rct --row sun_transmission --row diffuse_irradiance -o light.csv"};
  verb.common = kOutput;
  verb.output_default = "the table's name with .csv";
  verb.add_options = [o](base::OptionTable& table) {
    table.argument("FILE", "A render table (.rct)", o->file);
    table.texts("--row", "NAME", "Only this row; may be repeated", o->rows);
  };
  verb.run = [o](Invocation& invocation) { return export_table(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
