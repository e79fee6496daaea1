#include "host/run/python_script.h"

#include <sys/wait.h>

#include "host/base/data_folder.h"
#include "host/base/error.h"
#include "host/base/guarded_program.h"
#include "host/base/interrupt.h"

namespace raycube::run {

bool run_python(const std::string& python, const std::vector<std::string>& arguments, const std::string& needed) {
  // Isolated: a module is taken from the installation, not from the folder where a stranger's scene was unpacked, nor
  // from where PYTHONPATH says.
  std::vector<std::string> words = {python, "-I"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const int status = base::run_guarded({words, "", "", "", true});
  base::throw_if_interrupted();
  if (WIFEXITED(status) && WEXITSTATUS(status) == base::kNotStarted)
    throw base::Error(base::Fault::environment, python + " could not be started; " + needed);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

std::string script_path(const std::string& script) { return (base::data_folder() / "plots" / script).string(); }

}  // namespace raycube::run
