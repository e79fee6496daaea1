#include "host/run/python_chart.h"

#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "host/base/data_folder.h"
#include "host/base/error.h"
#include "host/base/interrupt.h"

extern char** environ;

namespace raycube::run {

namespace {

/// chart: empty when the figures say where to draw. The script's stderr goes to ours.
void run_script(const std::string& script, const std::string& figures, const std::string& chart) {
  const std::string python = "/usr/bin/python3", path = (base::data_folder() / "plots" / script).string();
  const char* arguments[] = {python.c_str(), path.c_str(), figures.c_str(), chart.empty() ? nullptr : chart.c_str(),
                             nullptr};
  pid_t child = 0;
  const int failed = posix_spawn(&child, python.c_str(), nullptr, nullptr, const_cast<char**>(arguments), environ);
  if (failed)
    throw base::Error(base::Fault::environment, python + " could not be started (" + std::strerror(failed) +
                                                    "); charts need Debian's python3 with python3-matplotlib");
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) throw base::Error(base::Fault::environment, path + ": its end could not be waited for");
  base::throw_if_interrupted();  // the terminal's Ctrl-C has ended the script as well
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw base::Error(base::Fault::environment,
                      path + " failed (its message is above); charts need python3-matplotlib");
}

}  // namespace

void run_plot(const std::string& script, const std::string& figures) { run_script(script, figures, ""); }

void append_drawn(base::OutputFile& picture, const std::string& path) {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(path.c_str(), "rb"), std::fclose);
  if (!in) throw base::Error(base::Fault::environment, picture.final_path() + ": the chart script wrote nothing");
  char buffer[65536];
  for (std::size_t bytes; (bytes = std::fread(buffer, 1, sizeof buffer, in.get())) > 0;) picture.append(buffer, bytes);
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
