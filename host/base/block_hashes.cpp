#include "host/base/block_hashes.h"

#include <algorithm>
#include <cstring>

#include "host/base/error.h"

namespace raycube::base {
namespace {

/// Finaliser of splitmix64 (Steele, Lea, Flood 2014): numbers that look drawn, one for each word.
std::uint64_t key_of_word(std::uint64_t word) {
  std::uint64_t z = (word + 1) * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return (z ^ (z >> 31)) | 1u;
}

/// Sum of word x key over the bytes in their places; the parts of a word that others write count as zeros, so
/// sums of disjoint bytes add up.
std::uint64_t weighted_sum(std::uint64_t offset, const unsigned char* data, std::size_t bytes) {
  std::uint64_t sum = 0;
  const auto partial = [&](std::size_t count) {
    unsigned char padded[8] = {};
    std::memcpy(padded + offset % 8, data, count);
    std::uint64_t word;
    std::memcpy(&word, padded, 8);
    sum += word * key_of_word(offset / 8);
    offset += count, data += count, bytes -= count;
  };
  if (offset % 8 != 0 && bytes > 0) partial(std::min<std::size_t>(bytes, 8 - offset % 8));
  for (std::uint64_t number = offset / 8; bytes >= 8; ++number) {
    std::uint64_t word;
    std::memcpy(&word, data, 8);
    sum += word * key_of_word(number);
    offset += 8, data += 8, bytes -= 8;
  }
  if (bytes > 0) partial(bytes);
  return sum;
}

int value_of(char digit) { return digit <= '9' ? digit - '0' : digit - 'a' + 10; }

}  // namespace

std::string hash_of_list(const std::vector<std::string>& blocks) {
  Sha256 sha;
  for (const std::string& hex : blocks) {
    std::string raw;
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
      raw += static_cast<char>(value_of(hex[i]) * 16 + value_of(hex[i + 1]));
    sha.add(raw);
  }
  return sha.hex();
}

std::vector<unsigned char> BlockHashes::read(std::uint64_t offset, std::uint64_t bytes) const {
  std::vector<unsigned char> data(bytes);
  read_back_(offset, data.data(), data.size());
  return data;
}

void BlockHashes::changed(std::uint64_t start) const {
  throw Error(Fault::environment, path_ + ": the file does not hold what was written to it (between bytes " +
                                      std::to_string(start) + " and " + std::to_string(start + kHashBlock_bytes) +
                                      "): another program wrote into it, or the disk is failing; run again");
}

void BlockHashes::about_to_write(std::uint64_t offset, const void* data, std::size_t bytes) {
  auto* next = static_cast<const unsigned char*>(data);
  while (bytes > 0) {
    const std::uint64_t number = offset / kHashBlock_bytes;
    const std::size_t piece = std::min<std::uint64_t>(bytes, (number + 1) * kHashBlock_bytes - offset);
    if (blocks_.size() <= number) blocks_.resize(number + 1);
    write_in_block(number, offset, next, piece);
    offset += piece, next += piece, bytes -= piece;
  }
}

void BlockHashes::write_in_block(std::uint64_t number, std::uint64_t offset, const unsigned char* data,
                                 std::size_t bytes) {
  Block& block = blocks_[number];
  const std::uint64_t start = number * kHashBlock_bytes;
  if (!rewritten_ && !block.scattered && offset == start + block.in_order) {
    block.sha.add(data, bytes);
    block.in_order += bytes;
    return;
  }
  if (!block.scattered) scatter(block, start);
  const Span span{offset, offset + bytes};
  take_out_replaced(block, span);
  block.sum += weighted_sum(offset, data, bytes);
  auto& written = block.written;
  written.insert(std::lower_bound(written.begin(), written.end(), span), span);
  std::size_t last = 0;
  for (std::size_t i = 1; i < written.size(); ++i)
    if (written[i].first <= written[last].second)
      written[last].second = std::max(written[last].second, written[i].second);
    else
      written[++last] = written[i];
  written.resize(last + 1);
}

/// From the running hash to the sum, by reading back what was hashed and finding it unchanged.
void BlockHashes::scatter(Block& block, std::uint64_t start) {
  block.scattered = true;
  if (block.in_order == 0) return;
  const auto before = read(start, block.in_order);
  if (Sha256().add(before.data(), before.size()).digest() != block.sha.digest()) changed(start);
  block.sum = weighted_sum(start, before.data(), before.size());
  block.written = {{start, start + block.in_order}};
}

void BlockHashes::take_out_replaced(Block& block, const Span& span) {
  for (const Span& old : block.written) {
    const std::uint64_t first = std::max(old.first, span.first), last = std::min(old.second, span.second);
    if (first >= last) continue;
    const auto replaced = read(first, last - first);
    block.sum -= weighted_sum(first, replaced.data(), replaced.size());
  }
}

FileHashes BlockHashes::finish(std::uint64_t bytes) {
  FileHashes out;
  out.bytes = bytes;
  const std::uint64_t count = (bytes + kHashBlock_bytes - 1) / kHashBlock_bytes;
  blocks_.resize(count);
  for (std::uint64_t number = 0; number < count; ++number) {
    Block& block = blocks_[number];
    const std::uint64_t start = number * kHashBlock_bytes, wanted = std::min(kHashBlock_bytes, bytes - start);
    if (block.scattered || block.in_order != wanted) {
      if (!block.scattered) scatter(block, start);
      const auto data = read(start, wanted);
      if (weighted_sum(start, data.data(), data.size()) != block.sum) changed(start);
      out.blocks.push_back(Sha256().add(data.data(), data.size()).hex());
    } else {
      out.blocks.push_back(block.sha.hex());
    }
  }
  out.list = hash_of_list(out.blocks);
  return out;
}

}  // namespace raycube::base
