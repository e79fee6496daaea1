// Small simulation files for tests: a folder of its own that vanishes with the object.
#pragma once

#include <doctest/doctest.h>

#include <unistd.h>

#include <algorithm>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "host/base/error.h"
#include "scene_compiler/load_simulation.h"
#include "tests/support/skipped.h"

namespace raycube::scene::testing {

class Folder {
 public:
  Folder() {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("raycube-scene-" + std::to_string(::getpid()) + "-" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  /// Writes a file (parents are made) and returns its path.
  std::string write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << text;
    return (path_ / name).string();
  }
  std::string at(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

inline constexpr const char* kHead = "format = 1\n";
/// A grey material, used by most tests.
inline constexpr const char* kGrey = "[[material]]\nname = \"grey\"\nreflectance = 0.5\n";

inline Simulation load(const Folder& folder, const std::string& text, const LoadOptions& options = {}) {
  return load_simulation(folder.write("scene.toml", text), options);
}

/// All messages of a file that must be refused; "" when it was accepted. Paths are cut to the folder's
/// inside.
inline std::string refusal(const Folder& folder, const std::string& text) {
  std::string message;
  try {
    load(folder, text);
  } catch (const base::Error& error) {
    CHECK(error.fault() == base::Fault::input);
    message = error.what();
  }
  const std::string root = folder.at("");
  for (auto at = message.find(root); at != std::string::npos; at = message.find(root)) message.erase(at, root.size());
  return message;
}

inline bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }
#define CHECK_SAYS(message, part) \
  CHECK_MESSAGE(::raycube::scene::testing::has(message, part), "missing '" << part << "' in:\n" << message)

inline std::size_t line_count(const std::string& text) {
  return text.empty() ? 0 : static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + 1;
}

/// Folder of real input, or nothing after saying so.
inline std::optional<std::string> shared_folder(const char* test) {
  const char* folder = std::getenv("RAYCUBE_SHARED");
  if (folder != nullptr && std::filesystem::is_directory(folder)) return folder;
  raycube::testing::skip_part(std::string(test) + " has no real input");
  return std::nullopt;
}

}  // namespace raycube::scene::testing
