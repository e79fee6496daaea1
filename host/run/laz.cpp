#include "host/run/laz.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include "host/base/error.h"
#include "host/run/python_script.h"

namespace raycube::run {
namespace {

constexpr const char* kLazNeeds =
    "products.laz needs a Python with laspy (2 or later) and lazrs: python3 -m venv V && V/bin/pip install laspy "
    "lazrs, "
    "then set RAYCUBE_PYTHON=V/bin/python; or leave laz out";
constexpr const char* kScript = "las_to_laz.py";
/// Ends with 0 where the script will find what it asks for.
constexpr const char* kQuestion =
    "import sys\ntry:\n  import laspy\n  ok = laspy.LazBackend.LazrsParallel.is_available()\nexcept Exception:\n  ok = "
    "False\nsys.exit(0 if ok else 1)";

std::vector<std::string> candidates() {
  if (const char* named = std::getenv("RAYCUBE_PYTHON"); named && *named) return {named};
  std::error_code ignored;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
  return {(program / "venv/bin/python").string(), kSystemPython};
}

bool has_laz(const std::string& python) {
  try {
    return run_python(python, {"-c", kQuestion}, kLazNeeds);
  } catch (const base::Error& error) {
    if (error.fault() != base::Fault::environment) throw;
    return false;  // not to be started
  }
}

}  // namespace

std::string laz_python() {
  static std::string found;  // starting one takes a quarter of a second: asked for before a run and by its products
  if (!found.empty()) return found;
  if (const std::string script = script_path(kScript); !std::filesystem::exists(script))
    throw base::Error(base::Fault::environment,
                      script + " is missing; install the program whole, or correct RAYCUBE_DATA");
  std::string tried;
  for (const std::string& python : candidates()) {
    if (has_laz(python)) return found = python;
    tried += (tried.empty() ? "" : ", ") + python;
  }
  throw base::Error(base::Fault::environment, "no laspy with lazrs (looked in " + tried + "); " + kLazNeeds);
}

void write_laz(const std::string& python, const std::string& las, const std::string& laz) {
  const std::string script = script_path(kScript);
  if (!run_python(python, {script, las, laz}, kLazNeeds))
    throw base::Error(base::Fault::environment, script + " failed (its message is above)");
}

}  // namespace raycube::run
