#include "host/experiment/kept_steps.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/data_folder.h"
#include "host/base/error.h"
#include "host/base/input_file.h"
#include "host/base/output_file.h"
#include "host/base/sha256.h"
#include "host/base/timing.h"
#include "host/base/version.h"

namespace raycube::experiment {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMark = ".raycube-study";     ///< of a folder that is a study's
constexpr const char* kStepMark = ".raycube-step";  ///< of a step's, before anything else is in it
constexpr const char* kRecord = "step.json";        ///< written last

std::string content_hash(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  base::Sha256 hash;
  std::vector<char> buffer(1 << 20);
  while (in.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) || in.gcount() > 0)
    hash.add(buffer.data(), static_cast<std::size_t>(in.gcount()));
  return hash.hex();
}

/// Of processes that this one has waited for.
double children_s() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

nlohmann::json record_of(const fs::path& folder) {
  std::ifstream in(folder / kRecord);
  return in ? nlohmann::json::parse(in, nullptr, false) : nlohmann::json();
}

bool inside(const fs::path& path, const fs::path& folder) {
  const std::string text = path.lexically_normal().string(), top = folder.lexically_normal().string();
  return text == top || text.rfind(top + "/", 0) == 0;
}

}  // namespace

KeptSteps::KeptSteps(const std::string& folder, const std::string& here, const std::string& study, bool looks_only)
    : folder_(fs::absolute(folder).lexically_normal().string()), here_(here) {
  std::error_code code;
  const fs::path mark = fs::path(folder_) / kMark;
  const std::string whose = "results of the study " + fs::absolute(study).lexically_normal().string() + "\n";
  const bool ours = fs::exists(mark, code);
  if (!ours && fs::exists(folder_, code) && !fs::is_empty(folder_, code))
    throw base::Error(base::Fault::input, folder_ + ": holds other things than a study's results; choose another -o");
  if (ours) {
    std::ifstream in(mark);
    const std::string said{std::istreambuf_iterator<char>(in), {}};
    if (said != whose)
      throw base::Error(base::Fault::input,
                        folder_ + ": holds " + said.substr(0, said.find('\n')) + "; choose another -o, or remove it");
  }
  program_ = content_hash("/proc/self/exe") + file_hash((base::data_folder() / "plots").string());
  folders_ = {{"here", here_}};
  if (looks_only) return;
  fs::create_directories(folder_, code);
  if (code) throw base::Error(base::Fault::environment, folder_ + ": cannot be made: " + code.message());
  // Inherited by the steps' processes: while one of them lives nobody else works here.
  lock_ = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY);
  if (lock_ < 0 || ::flock(lock_, LOCK_EX | LOCK_NB) != 0)
    throw base::Error(
        base::Fault::environment,
        folder_ + ": another run works in it, or a step that one left; wait for it, or choose another -o");
  if (!ours) base::write_output_file(mark.string(), whose, base::IfExists::replace);
}

KeptSteps::~KeptSteps() {
  if (lock_ >= 0) ::close(lock_);
}

std::string KeptSteps::file_hash(const std::string& path) const {
  std::error_code code;
  if (fs::is_directory(path, code)) {
    std::set<std::string> files;
    for (auto at = fs::recursive_directory_iterator(path, code); !code && at != fs::recursive_directory_iterator();
         at.increment(code)) {
      if (inside(at->path(), folder_))
        at.disable_recursion_pending();
      else if (at->is_regular_file(code) && at->path().extension() != ".pyc")
        files.insert(at->path().string());
    }
    code.clear();
    base::Sha256 all;
    for (const std::string& file : files) all.add(fs::relative(file, path).string()).add(file_hash(file));
    return all.hex();
  }
  const std::string state =
      fmt::format("{} {}", fs::file_size(path, code), fs::last_write_time(path, code).time_since_epoch().count());
  auto& known = hashes_[path];
  if (known.first != state) known = {state, content_hash(path)};
  return known.second;
}

std::string KeptSteps::key_of(const StepPlan& step, const Names& names) const {
  base::Sha256 key;
  key.add("step 1\n").add(program_);
  Names values = names;
  values["here"] = here_;
  std::error_code code;
  const auto add_file = [&](const std::string& text, bool needed) {
    fs::path path = fs::path(text).is_absolute() ? fs::path(text) : fs::path(here_) / text;
    if (inside(path, folder_)) return;  // another step's, by its key
    const bool below =
        fs::is_directory(path, code) && inside(path, here_) && path.lexically_normal() != fs::path(here_);
    if (needed) base::refuse_other_than_plain(path.string(), base::OrFolder::yes);
    if (needed ? fs::exists(path, code) : below || fs::is_regular_file(path, code))
      key.add(file_hash(path.lexically_normal().string()));
    else if (needed)
      throw base::Error(base::Fault::input, step.where + ": input " + path.string() + " is not there; check the path");
  };
  key.add(step.more);
  for (const Command& command : step.commands) {
    key.add(fmt::format("{} words\n", command.size()));
    for (std::size_t w = 0; w < command.size(); ++w) {
      const std::string& word = command[w];
      key.add(fmt::format("{}:{}\n", word.size(), word));
      bool of_step = false;
      for (const std::string& name : names_in(word)) {
        if (name == "folder")
          of_step = true;
        else if (const auto found = keys_.find(name); found != keys_.end())
          key.add(found->second), of_step = true;
        else if (const auto value = names.find(name); value != names.end())
          key.add(name + "=" + value->second + "\n");
      }
      if (!of_step && (w > 0 || word.find('/') != std::string::npos))
        add_file(with_names(word, values, step.where), false);
    }
  }
  for (const std::string& input : step.inputs) add_file(with_names(input, values, step.where), true);
  return key.hex();
}

Names KeptSteps::values_of(const StepPlan& step, const Names& names) const {
  Names out;
  for (const Command& command : step.commands)
    for (const std::string& word : command)
      for (const std::string& name : names_in(word))
        if (const auto value = names.find(name); value != names.end())
          out.insert(*value);
        else if (const auto before = values_.find(name); before != values_.end())
          out.insert(before->second.begin(), before->second.end());
  return out;
}

std::string KeptSteps::folder_of(const StepPlan& step, const std::string& key, bool by_key) const {
  return (fs::path(folder_) / "steps" / (by_key ? step.name + "-" + key.substr(0, 16) : step.name)).string();
}

bool KeptSteps::is_kept(const StepPlan& step, const Names& names) const {
  for (const Command& command : step.commands)
    for (const std::string& word : command)
      for (const std::string& name : names_in(word))
        if (name != "folder" && folders_.count(name) == 0 && names.count(name) == 0) return false;  // that is to run
  const std::string key = key_of(step, names);
  const nlohmann::json record = record_of(folder_of(step, key, false));
  return record.is_object() && record.value("key", "") == key;
}

void KeptSteps::forget_reports(const std::vector<std::string>& names) const {
  std::error_code ignored;
  for (const std::string& name : names) fs::remove(fs::path(folder_) / name, ignored);
}

KeptStep KeptSteps::make(const StepPlan& step, const Names& names, bool by_key) {
  KeptStep out;
  out.key = key_of(step, names);
  out.folder = folder_of(step, out.key, by_key);
  const Names values_here = values_of(step, names);
  const auto take = [&](const std::string& run) {  // what builds on it is made of this very run
    folders_[step.name] = out.folder, keys_[step.name] = out.key + run, values_[step.name] = values_here;
    return out;
  };
  if (const nlohmann::json record = record_of(out.folder); record.is_object() && record.value("key", "") == out.key) {
    out.seconds = record.value("seconds", 0.0), out.processor_s = record.value("processor_s", 0.0);
    return take(record.value("run", ""));
  }
  std::error_code code;
  const fs::path folder(out.folder), mark = folder / kStepMark;
  if (fs::exists(folder, code) && !fs::exists(mark, code))
    throw base::Error(base::Fault::input, out.folder + ": is no step's folder; move it away");
  if (fs::exists(folder, code)) {
    fs::remove(folder / kRecord, code);  // first: what is left of a step is none
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.path() == mark) continue;
      if (!fs::exists(entry.path() / kMark, code)) {
        fs::remove_all(entry.path(), code);
        continue;
      }
      for (const auto& inner : fs::directory_iterator(entry.path()))  // a study in it keeps its own steps
        if (inner.path().filename() != "steps" && inner.path().filename() != kMark) fs::remove_all(inner.path(), code);
    }
  }
  fs::create_directories(folder, code);
  base::write_output_file(mark.string(), step.name + "\n", base::IfExists::replace);
  Names values = folders_;
  for (const auto& [name, value] : names) values[name] = value;
  values["folder"] = out.folder;
  const auto start = std::chrono::steady_clock::now();
  const double before_s = children_s();
  for (const Command& command : step.commands) {
    Command words;
    for (const std::string& word : command) words.push_back(with_names(word, values, step.where));
    run_command(words, here_, (folder / "stdout.txt").string(), (folder / "stderr.txt").string());
  }
  out.run = true;
  out.seconds = base::seconds_since(start), out.processor_s = children_s() - before_s;
  const std::string run =
      fmt::format("{}.{}", std::chrono::system_clock::now().time_since_epoch().count(), static_cast<int>(::getpid()));
  nlohmann::ordered_json record = {
      {"step", step.name}, {"key", out.key},           {"seconds", out.seconds}, {"processor_s", out.processor_s},
      {"run", run},        {"commands", step.commands}};
  if (!values_here.empty()) record["parameters"] = values_here;
  base::write_output_file((folder / kRecord).string(), record.dump(2) + "\n", base::IfExists::replace);
  return take(run);
}

}  // namespace raycube::experiment
