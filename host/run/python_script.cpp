#include "host/run/python_script.h"

#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstring>

#include "host/base/data_folder.h"
#include "host/base/error.h"
#include "host/base/interrupt.h"

extern char** environ;

namespace raycube::run {

bool run_python(const std::string& python, const std::vector<std::string>& arguments, const std::string& needed) {
  // Isolated: a module is taken from the installation, not from the folder where a stranger's scene was unpacked, nor
  // from where PYTHONPATH says.
  std::vector<char*> words = {const_cast<char*>(python.c_str()), const_cast<char*>("-I")};
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, python.c_str(), nullptr, nullptr, words.data(), environ);
  if (failed)
    throw base::Error(base::Fault::environment,
                      python + " could not be started (" + std::strerror(failed) + "); " + needed);
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) throw base::Error(base::Fault::environment, python + ": its end could not be waited for");
  base::throw_if_interrupted();  // the terminal's Ctrl-C has ended the script as well
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

std::string script_path(const std::string& script) { return (base::data_folder() / "plots" / script).string(); }

}  // namespace raycube::run
