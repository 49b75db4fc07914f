#include "linalg/minimal_residuals.hpp"

#include <cmath>

namespace fbi::linalg {
namespace {

constexpr double no_news = 1e-10;  // squared part of a product that earlier ones do not have, below: round-off

/// Sum of a b in eight parts.
double dot(const std::vector<double>& a, const std::vector<double>& b) {
  constexpr std::size_t parts = 8;
  double sum[parts] = {};
  std::size_t k = 0;
  for (; k + parts <= a.size(); k += parts)
    for (std::size_t i = 0; i < parts; ++i) sum[i] += a[k + i] * b[k + i];
  for (; k < a.size(); ++k) sum[0] += a[k] * b[k];
  double total = 0.0;
  for (const double part : sum) total += part;
  return total;
}

}  // namespace

std::vector<double>& MinimalResiduals::product() {
  if (used_ == static_cast<int>(columns_.size())) columns_.emplace_back();
  return columns_[used_].product;
}

MinimalResiduals::State MinimalResiduals::step(const Comm& comm, std::vector<double>& rest, double tolerance) {
  Column& here = columns_[used_];
  std::vector<double> sums(static_cast<std::size_t>(used_) + 3);
  for (int j = 0; j <= used_; ++j) sums[j] = dot(columns_[j].product, here.product);
  sums[used_ + 1] = dot(here.product, rest);
  sums[used_ + 2] = dot(rest, rest);
  comm.sum(sums.data(), used_ + 3);
  const double squared = sums[used_], along = sums[used_ + 1], residual = sums[used_ + 2];
  if (used_ == 0) first_ = residual;
  here.squared_norm = squared;
  here.parts.resize(used_);
  for (int j = 0; j < used_; ++j) {
    here.parts[j] = sums[j] / columns_[j].squared_norm;
    here.squared_norm -= here.parts[j] * sums[j];
    for (std::size_t k = 0; k < rest.size(); ++k) here.product[k] -= here.parts[j] * columns_[j].product[k];
  }
  if (!std::isfinite(here.squared_norm + residual)) return State::not_finite;
  if (!(here.squared_norm > (used_ > 0 ? no_news * squared : 0.0))) return State::nothing_new;
  here.coefficient = along / here.squared_norm;
  for (std::size_t k = 0; k < rest.size(); ++k) rest[k] -= here.coefficient * here.product[k];
  ++used_;
  return residual - here.coefficient * along <= tolerance * tolerance * first_ ? State::enough : State::goes_on;
}

std::vector<double> MinimalResiduals::coefficients() const {
  std::vector<double> c;
  for (int i = 0; i < used_; ++i) c.push_back(columns_[i].coefficient);
  for (int i = used_ - 1; i > 0; --i)
    for (int j = 0; j < i; ++j) c[j] -= columns_[i].parts[j] * c[i];
  return c;
}

}  // namespace fbi::linalg
