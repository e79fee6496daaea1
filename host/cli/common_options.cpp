#include "host/cli/verb.h"

namespace raycube::cli {

void add_common_options(base::OptionTable& table, CommonOptions& values, unsigned set) {
  const std::size_t first = table.rows().size();
  if (set & kOutput) {
    table.text("-o,--output", "PATH", "Where the products go", values.output);
    table.flag("--overwrite", "Replace products that are there already", values.overwrite);
  }
  if (set & kDryRun) table.flag("--dry-run", "Validate, plan, and say memory and time; write nothing", values.dry_run);
  if (set & kSeed)
    table.integer<std::uint64_t>("--seed", "", 0, std::numeric_limits<std::uint64_t>::max(),
                                 "Seed of every random number; without it the file's own", values.seed);
  if (set & kSet)
    table.texts("--set", "KEY=VALUE",
                "Say a key of the simulation file otherwise, as in atmosphere.visibility_km=12 or "
                "instrument.spectir.pixels=100",
                values.set);
  if (set & kDevice)
    table.text("--device", "NAME", "OpenCL device: its number in `raycube devices` or a part of its name",
               values.device);
  if (set & kThreads) table.integer("--threads", "", 0, 4096, "CPU threads; 0: all of the machine", values.threads);
  if (set & kMemory)
    table.memory("--memory",
                 "Most that tiles, tables of band values and strips of a run take, on host and device "
                 "together; the program with its OpenCL driver (some 150 MiB) and the scene come on top",
                 values.memory_bytes);
  table.count("-q,--quiet", "Fewer messages on stderr: once keeps warnings and errors, twice errors", values.quiet);
  table.count("-v,--verbose", "More messages on stderr; twice for debugging", values.verbose);
  table.text("--log", "FILE", "Append every message to FILE as JSON lines", values.log_file);
  table.flag("--json", "Print the result as one JSON document", values.json);
  for (std::size_t i = first; i < table.rows().size(); ++i) table.rows()[i].common = true;
}

}  // namespace raycube::cli
