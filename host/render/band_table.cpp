#include "host/render/band_table.h"

#include <algorithm>
#include <string>

#include "host/base/error.h"

namespace raycube::render {

namespace {

constexpr std::size_t kWritten_bytes = std::size_t{1} << 20;  ///< rows that are written to the device together

std::size_t without(std::size_t bytes, std::size_t taken) { return bytes - std::min(bytes, taken); }

std::size_t rows_that_fit(std::size_t bytes, std::size_t row_bytes, std::size_t most) {
  return std::min(std::max(bytes / row_bytes, kFewestRows), std::max<std::size_t>(2, most));
}

}  // namespace

std::size_t most_rows(const plan::Plan& plan) { return plan.seen_curves.size() + plan.environment.nodes() + 1; }

BandTable::BandTable(const cl::Context& context, const scene::CompiledScene& scene, const plan::Plan& plan,
                     const StageShape& shape, std::size_t bytes)
    : scene_(scene),
      plan_(plan),
      row_floats_(static_cast<std::size_t>(shape.channels) * shape.bands_padded),
      channel_floats_(shape.bands_padded),
      capacity_(rows_that_fit(without(std::min<std::size_t>(bytes, context.device().info().max_alloc_bytes),
                                      plan.skeleton_rows() * row_floats_ * sizeof(float)),
                              row_floats_ * sizeof(float), most_rows(plan))),
      values_(context, (capacity_ + plan.skeleton_rows()) * row_floats_, cl::Access::read_only, "band table"),
      keys_(context, capacity_, cl::Access::read_only, "keys of the band table"),
      rows_(context, capacity_, cl::Access::read_only, "rows of the band table") {
  for (std::uint32_t m = 0; m < plan.skeleton_rows(); ++m) bake(plan::kSkeletonKey | m, skeleton_row() + m);
  bake(0, 0);
  write_baked();
  slots_[0] = {0, use_.end()};
  ensure({});
}

void BandTable::bake(std::uint64_t key, std::uint32_t row) {
  if (row != first_baked_ + baked_.size() / row_floats_ || baked_.size() * sizeof(float) > kWritten_bytes) {
    write_baked();
    first_baked_ = row;
  }
  const std::vector<float> values = plan::bake_row(plan_, scene_, key);
  baked_.insert(baked_.end(), values.begin(), values.end());
  // The path row and the material rows have their own number of channels; a row of the table holds the larger.
  baked_.resize(baked_.size() + row_floats_ - values.size(), 0.0f);
}

void BandTable::write_baked() {
  if (!baked_.empty()) values_.write(baked_, first_baked_ * row_floats_);
  baked_.clear();
}

std::vector<std::uint64_t> BandTable::keys_by_row() const {
  std::vector<std::uint64_t> keys(capacity_ + plan_.skeleton_rows(), 0);
  for (const auto& [key, slot] : slots_) keys[slot.row] = key;
  for (std::size_t m = 0; m < plan_.skeleton_rows(); ++m) keys[capacity_ + m] = plan::kSkeletonKey | m;
  return keys;
}

void BandTable::ensure(const std::vector<std::uint64_t>& keys) {
  if (keys.size() + 1 > capacity_)
    throw base::Error(base::Fault::bug, "band table: " + std::to_string(keys.size()) + " keys asked of " +
                                            std::to_string(capacity_) + " rows");
  bool changed = keys.empty();
  for (const auto key : keys) {  // mark what is here as in use before anything is evicted
    const auto found = slots_.find(key);
    if (found != slots_.end()) use_.splice(use_.end(), use_, found->second.use);
  }
  for (const auto key : keys) {
    if (slots_.count(key)) continue;
    std::uint32_t row = static_cast<std::uint32_t>(slots_.size());
    if (slots_.size() == capacity_) {
      row = slots_.at(use_.front()).row;
      slots_.erase(use_.front());
      use_.pop_front();
    }
    bake(key, row);
    use_.push_back(key);
    slots_[key] = {row, std::prev(use_.end())};
    changed = true;
  }
  if (!changed) return;
  write_baked();
  std::vector<std::uint64_t> sorted_keys;
  std::vector<std::uint32_t> rows;
  for (const auto& [key, slot] : slots_) {
    sorted_keys.push_back(key);
    rows.push_back(slot.row);
  }
  keys_.write(sorted_keys);
  rows_.write(rows);
}

}  // namespace raycube::render
