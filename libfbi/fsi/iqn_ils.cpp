#include "fsi/iqn_ils.hpp"

#include <cmath>

namespace fbi::fsi {

void IqnIls::begin_step() {
  has_last_ = false;
  for (Column& column : columns_) ++column.age;
  while (!columns_.empty() && columns_.back().age > reuse_) columns_.pop_back();
}

void IqnIls::add_column(const std::vector<double>& x, const std::vector<double>& r) {
  Column column;
  column.residual.resize(r.size());
  column.image.resize(r.size());
  for (std::size_t k = 0; k < r.size(); ++k) {
    column.residual[k] = r[k] - last_residual_[k];
    column.image[k] = x[k] + r[k] - last_image_[k];
  }
  columns_.push_front(std::move(column));
}

bool IqnIls::advance(std::vector<double>& x, const std::vector<double>& r, const NearbyMap& /*nearby*/) {
  if (has_last_) add_column(x, r);
  has_last_ = true;
  last_residual_ = r;
  last_image_ = x;
  for (std::size_t k = 0; k < x.size(); ++k) last_image_[k] += r[k];

  // V = Q R column by column, newest first; columns that newer ones nearly contain are dropped for good.
  std::vector<std::vector<double>> basis, triangle;
  std::vector<double> right;  // -Q^T r
  for (std::size_t c = 0; c < columns_.size();) {
    std::vector<double> next = columns_[c].residual, entries;
    const double whole = std::sqrt(dot(comm_, next, next));
    for (const std::vector<double>& direction : basis) {
      entries.push_back(dot(comm_, direction, next));
      for (std::size_t k = 0; k < next.size(); ++k) next[k] -= entries.back() * direction[k];
    }
    const double left = std::sqrt(dot(comm_, next, next));
    if (!(left > filter_ * whole)) {
      columns_.erase(columns_.begin() + static_cast<std::ptrdiff_t>(c));
      continue;
    }
    for (double& value : next) value /= left;
    entries.push_back(left);
    right.push_back(-dot(comm_, next, r));
    basis.push_back(std::move(next));
    triangle.push_back(std::move(entries));
    ++c;
  }
  relaxed_ = columns_.empty();
  if (relaxed_) {
    for (std::size_t k = 0; k < x.size(); ++k) x[k] += omega_ * r[k];
    return true;
  }
  x = last_image_;
  std::vector<double> a(columns_.size());
  for (std::size_t i = a.size(); i-- > 0;) {
    a[i] = right[i];
    for (std::size_t j = i + 1; j < a.size(); ++j) a[i] -= triangle[j][i] * a[j];
    a[i] /= triangle[i][i];
    for (std::size_t k = 0; k < x.size(); ++k) x[k] += a[i] * columns_[i].image[k];
  }
  return true;
}

std::vector<double> IqnIls::history() const {
  std::vector<double> ages;
  for (const Column& column : columns_) ages.push_back(column.age);
  return ages;
}

void IqnIls::set_history(const std::vector<double>& values) {
  columns_.assign(values.size(), {});
  for (std::size_t c = 0; c < values.size(); ++c) columns_[c].age = static_cast<Index>(values[c]);
}

std::vector<std::pair<std::string, std::vector<double>*>> IqnIls::state() {
  std::vector<std::pair<std::string, std::vector<double>*>> list;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    list.emplace_back("iqn_residual_" + std::to_string(c), &columns_[c].residual);
    list.emplace_back("iqn_image_" + std::to_string(c), &columns_[c].image);
  }
  return list;
}

}  // namespace fbi::fsi
