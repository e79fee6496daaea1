#include "host/cli/atmos_import.h"

#include <memory>
#include <ostream>

#include "atmos_tables/import/import_file.h"
#include "host/cli/verb.h"

namespace raycube::cli {

Verb verb_atmos_import() {
  struct Options {
    std::string file, format = "auto", uvspec_input;
  };
  auto o = std::make_shared<Options>();
  Verb verb;
  verb.name = "import";
  verb.summary = "Read the output of MODTRAN, uvspec or 6S and say what it holds";
  verb.description =
      "Units and angles are converted to the project's; damaged rows are refused with file and line; sums that the code prints "
      "must hold to the printed digits. docs/import_formats.md lists formats and columns.";
  verb.examples = {"raycube atmos import tape7", "raycube atmos import uvspec.out --uvspec-input uvspec.inp --json"};
  verb.add_options = [o](base::OptionTable& table) {
    std::vector<std::string> formats{"auto"};
    for (const auto& name : atmos::imported::format_names()) formats.push_back(name);
    table.argument("FILE", "What the other code wrote", o->file);
    table.choice("--format", formats, "Format of FILE; auto: by its name and first lines", o->format);
    table.text("--uvspec-input", "FILE", "Input file of a uvspec run", o->uvspec_input).default_text = "FILE with the ending .inp";
  };
  verb.run = [o](Context& context) {
    const auto imported = atmos::imported::import_file(o->file, o->format == "auto" ? "" : o->format, o->uvspec_input);
    context.out << (context.common.json ? atmos::imported::imported_json(imported) : atmos::imported::imported_text(imported));
    return 0;
  };
  return verb;
}

}  // namespace raycube::cli
