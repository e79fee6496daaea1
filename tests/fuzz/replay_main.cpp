// Feeds every file of every corpus to its target in the ordinary build: replay CORPUS_FOLDER. What once crashed stays
// in the corpora. An exception that is no base::Error, or a signal, fails the test; a target without a corpus, or none
// of whose corpus is read, or a corpus without a target, too.
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>
#include <vector>

#include "tests/fuzz/targets.h"

int main(int count, char** arguments) {
  namespace fs = std::filesystem;
  if (count != 2 || !fs::is_directory(arguments[1])) {
    std::cerr << "usage: replay CORPUS_FOLDER\n";
    return 2;
  }
  const fs::path corpora = arguments[1];
  int files = 0, faults = 0;
  for (const auto& entry : fs::directory_iterator(corpora))
    if (!raycube::fuzz::find_target(entry.path().filename().string())) {
      std::cerr << entry.path() << ": no target of this name\n";
      ++faults;
    }
  for (const auto& target : raycube::fuzz::targets()) {
    std::set<fs::path> paths;  // in order of name
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(corpora / target.name, missing)) paths.insert(entry.path());
    if (paths.empty()) {
      std::cerr << target.name << ": has no corpus\n";
      ++faults;
    }
    bool read = paths.empty();
    for (const auto& path : paths) {
      std::ifstream in(path, std::ios::binary);
      const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
      try {
        read |= raycube::fuzz::feed(target, reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
      } catch (const std::exception& error) {
        std::cerr << path.string() << ": " << error.what() << "\n";
        ++faults;
      }
      ++files;
    }
    if (!read) {
      std::cerr << target.name << ": none of its corpus is read; correct the target, or add a sound file\n";
      ++faults;
    }
  }
  std::cout << files << " files of " << raycube::fuzz::targets().size() << " corpora, " << faults << " faults\n";
  return faults ? 1 : 0;
}
