#include "host/run/python_chart.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <vector>

#include "host/base/error.h"
#include "host/run/python_script.h"

namespace raycube::run {

namespace {

constexpr const char* kChartsNeed = "charts need Debian's python3 with python3-matplotlib";

/// chart: empty when the figures say where to draw. The script's stderr goes to ours.
void run_script(const std::string& script, const std::string& figures, const std::string& chart) {
  const std::string path = script_path(script);
  std::vector<std::string> arguments = {path, figures};
  if (!chart.empty()) arguments.push_back(chart);
  if (!run_python(kSystemPython, arguments, kChartsNeed))
    throw base::Error(base::Fault::environment, path + " failed (its message is above); " + kChartsNeed);
}

}  // namespace

void run_plot(const std::string& script, const std::string& figures) { run_script(script, figures, ""); }

void append_drawn(base::OutputFile& out, const std::string& path) {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(path.c_str(), "rb"), std::fclose);
  if (!in) throw base::Error(base::Fault::environment, out.final_path() + ": the script wrote nothing");
  char buffer[65536];
  for (std::size_t bytes; (bytes = std::fread(buffer, 1, sizeof buffer, in.get())) > 0;) out.append(buffer, bytes);
  if (std::ferror(in.get())) throw base::Error(base::Fault::environment, path + " cannot be read");
}

void draw_into(const std::string& script, base::OutputFile& figures, base::OutputFile& picture) {
  // The script writes under a name of its own with the right ending; the bytes then go where an unfinished file is
  // never seen.
  const std::string drawn = picture.temporary_path() + ".png";
  struct Remove {
    const std::string& path;
    ~Remove() { std::remove(path.c_str()); }
  } remove{drawn};
  figures.sync();
  run_script(script, figures.temporary_path(), drawn);
  append_drawn(picture, drawn);
}

std::string draw_chart(const std::string& script, const std::string& figures_json, const std::string& chart,
                       base::IfExists if_exists) {
  const std::string figures = std::filesystem::path(chart).replace_extension(".json").string();
  if (figures == chart)
    throw base::Error(base::Fault::input, chart + ": a chart is a PNG; its figures go to the .json beside it");
  base::OutputFile numbers(figures, if_exists), picture(chart, if_exists);
  numbers.append(figures_json);
  draw_into(script, numbers, picture);
  numbers.publish();
  picture.publish();
  return figures;
}

}  // namespace raycube::run
