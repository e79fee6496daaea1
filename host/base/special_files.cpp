#include "host/base/special_files.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "host/base/input_file.h"

namespace raycube::base {
namespace {

namespace fs = std::filesystem;

/// What is neither a file nor a folder, in each folder that was asked about: each is listed once.
class Folders {
 public:
  std::string special_beside(const fs::path& path) {
    const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
    const auto [listed, fresh] = special_.try_emplace(folder.string());
    std::error_code code;
    if (fresh)
      for (const auto& entry : fs::directory_iterator(folder, code))
        if (!entry.is_regular_file(code) && !entry.is_directory(code) && entry.exists(code))
          listed->second.push_back(entry.path());
    for (const fs::path& special : listed->second) {
      const fs::path name = special.filename();
      if (name != path.filename() &&
          (name.stem() == path.stem() || name.string().starts_with(path.filename().string() + ".")))
        return special.string() + ", which " + why_no_plain_file(special.string());
    }
    return "";
  }

 private:
  std::map<std::string, std::vector<fs::path>> special_;
};

/// A text of XML with its five named characters in place.
std::string plain(std::string text) {
  for (const auto& [name, character] :
       {std::pair{"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&apos;", "'"}, {"&amp;", "&"}})
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1))
      text.replace(at, std::string(name).size(), character);
  return text;
}

/// The files that a virtual raster names, each once; none where the file is no such.
std::set<std::string> sources_of(const std::string& file) {
  constexpr std::size_t kMostBytes = 64 << 20;
  std::ifstream in(file, std::ios::binary);
  std::string text(1024, '\0');
  in.read(text.data(), 1024);
  text.resize(static_cast<std::size_t>(in.gcount()));
  std::set<std::string> out;
  if (text.find("<VRTDataset") == std::string::npos) return out;
  for (std::string more(1 << 16, '\0'); text.size() < kMostBytes && in.read(more.data(), 1 << 16).gcount() > 0;)
    text.append(more, 0, static_cast<std::size_t>(in.gcount()));
  for (const char* tag : {"<SourceFilename", "<SourceDataset"})
    for (std::size_t at = text.find(tag); at != std::string::npos; at = text.find(tag, at + 1)) {
      const std::size_t begin = text.find('>', at), end = text.find('<', at + 1);
      if (begin == std::string::npos || end == std::string::npos || end < begin) break;
      const fs::path named = plain(text.substr(begin + 1, end - begin - 1));
      const std::string head = text.substr(at, begin - at);
      const bool relative =
          head.find("relativeToVRT=\"1\"") != std::string::npos || head.find("relativeToVRT='1'") != std::string::npos;
      out.insert((relative ? fs::path(file).parent_path() / named : named).string());
    }
  return out;
}

}  // namespace

std::string special_around(const std::string& file) {
  Folders folders;
  std::set<std::string> met;  // canonical: virtual rasters may name each other
  std::vector<std::string> left{file};
  while (!left.empty()) {
    const std::string path = left.back();
    left.pop_back();
    std::error_code code;
    if (!met.insert(fs::weakly_canonical(path, code).string()).second) continue;
    if (const std::string beside = folders.special_beside(path); !beside.empty()) return beside;
    if (path == file && !why_no_plain_file(file).empty()) return "";  // said by whoever opens it
    for (const std::string& source : sources_of(path)) {
      if (!fs::exists(source, code) || fs::is_directory(source, code)) continue;
      if (const std::string why = why_no_plain_file(source); !why.empty()) return source + ", which " + why;
      left.push_back(source);
    }
  }
  return "";
}

}  // namespace raycube::base
