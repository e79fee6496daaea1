// Hashes of a file's blocks, made while it is written in any order, against SHA-256 of the file as it lies on
// the disk.
#include <doctest/doctest.h>

#include <algorithm>
#include <fstream>
#include <numeric>
#include <random>

#include <fcntl.h>
#include <unistd.h>

#include "host/base/error.h"
#include "host/base/output_file.h"
#include "host/base/sha256.h"
#include "tests/unit/test_folder.h"

using namespace raycube::base;
using raycube::testing::TestFolder;

namespace {

struct Write {
  std::uint64_t offset, bytes;
};

std::string random_bytes(std::size_t count, std::uint32_t seed) {
  std::mt19937_64 draw(seed);
  std::string out(count, '\0');
  for (char& c : out) c = static_cast<char>(draw());
  return out;
}

/// What the hashes must be, from the finished file alone.
FileHashes hashes_of(const std::string& content) {
  FileHashes out;
  out.bytes = content.size();
  std::string raw;
  for (std::size_t at = 0; at < content.size(); at += kHashBlock_bytes) {
    Sha256 sha;
    sha.add(content.data() + at, std::min<std::size_t>(kHashBlock_bytes, content.size() - at));
    out.blocks.push_back(sha.hex());
    for (const auto byte : sha.digest()) raw += static_cast<char>(byte);
  }
  out.list = sha256_hex(raw);
  return out;
}

void check_same(const FileHashes& found, const FileHashes& wanted) {
  CHECK(found.bytes == wanted.bytes);
  CHECK(found.blocks == wanted.blocks);
  CHECK(found.list == wanted.list);
}

/// Writes these pieces of a random content, in this order, and holds the hashes against the file.
void check_writes(const std::vector<Write>& writes) {
  const TestFolder folder;
  OutputFile file(folder / "a");
  file.hash_blocks();
  std::uint32_t seed = 1;
  for (const Write& write : writes) {
    const std::string bytes = random_bytes(write.bytes, seed++);
    file.write_at(write.offset, bytes.data(), bytes.size());
  }
  const FileHashes found = file.hashes();
  file.publish();
  check_same(found, hashes_of(folder.read("a")));
}

constexpr std::uint64_t kBlock = kHashBlock_bytes;

}  // namespace

TEST_CASE("blocks in order: whole ones, a last short one, an empty file") {
  check_writes({{0, 2 * kBlock}, {2 * kBlock, 17}});
  check_writes({{0, 1000}, {1000, kBlock}, {1000 + kBlock, kBlock - 1000}});
  check_writes({});
  check_writes({{0, 1}});
}

TEST_CASE("an image in bands: each strip goes to many places, none in order") {
  constexpr std::uint64_t kBands = 9, kLines = 40,
                          kLine_bytes = 31 * 4 * 1021;  // planes of 5 MB that no block divides
  std::vector<Write> writes;
  for (std::uint64_t line = 0; line < kLines; line += 8)
    for (std::uint64_t band = 0; band < kBands; ++band)
      writes.push_back({(band * kLines + line) * kLine_bytes, 8 * kLine_bytes});
  check_writes(writes);
}

TEST_CASE("headers filled in at the end, what is written twice, holes") {
  check_writes({{400, 3 * kBlock}, {0, 400}});  // a header last
  check_writes(
      {{0, 2 * kBlock}, {12, 2}, {kBlock - 3, 7}, {0, kBlock + 5}});  // parts replaced, across blocks, unaligned
  check_writes({{0, 100}, {50, 100}, {149, 3}, {10, 300}});
  check_writes({{3 * kBlock + 5, 9}});  // three blocks that nobody writes
  check_writes({{0, 10}, {kBlock + 10, 1}, {20, 1}});
}

TEST_CASE("any order of any pieces: hundreds of draws") {
  std::mt19937 draw(7);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Write> writes;
    const int count = 1 + static_cast<int>(draw() % 12);
    for (int i = 0; i < count; ++i) {
      // Near the ends of blocks, where things go wrong, and small: the file stays below 3 blocks.
      const std::uint64_t edge = draw() % 3 * kBlock + draw() % 64;
      writes.push_back({edge > 32 ? edge - 32 : edge, 1 + draw() % 100});
    }
    check_writes(writes);
  }
}

TEST_CASE("a stranger's bytes in the file are told, or differ from the hashes") {
  const TestFolder folder;
  const auto tamper = [](const OutputFile& file, std::uint64_t at) {
    const int fd = ::open(file.temporary_path().c_str(), O_WRONLY | O_CLOEXEC);
    REQUIRE(::pwrite(fd, "log line", 8, static_cast<off_t>(at)) == 8);
    ::close(fd);
  };
  const std::string bytes = random_bytes(kBlock + 1000, 3);
  SUBCASE("in order: the hashes are those of what was written") {
    OutputFile file(folder / "a");
    file.hash_blocks();
    file.append(bytes);
    tamper(file, 77);
    check_same(file.hashes(), hashes_of(bytes));
  }
  SUBCASE("read back at the end") {
    OutputFile file(folder / "a");
    file.hash_blocks();
    file.write_at(kBlock / 2, bytes.data(), 1000);
    file.write_at(0, bytes.data(), kBlock / 2);
    tamper(file, 77);
    CHECK_THROWS_WITH_AS(static_cast<void>(file.hashes()), doctest::Contains("another program wrote into it"), Error);
  }
  SUBCASE("read back when a header is filled in") {
    OutputFile file(folder / "a");
    file.hash_blocks();
    file.append(bytes);
    tamper(file, 77);
    CHECK_THROWS_AS(file.write_at(0, "LASF", 4), Error);
  }
  SUBCASE("in a hole") {
    OutputFile file(folder / "a");
    file.hash_blocks();
    file.write_at(5000, "x", 1);
    tamper(file, 77);
    CHECK_THROWS_AS(static_cast<void>(file.hashes()), Error);
  }
}
