#include "linalg/single_gmres.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/timer.hpp"

namespace fbi::linalg {
namespace {

using Lanes = float __attribute__((vector_size(64)));
constexpr std::size_t lanes = 16;
constexpr std::size_t chunk = 4096;  // floats that stay in the first cache
// Who has another way waits so many iterations, and for that part of the pace that leads to the tolerance in all of
// them.
constexpr int patience = 10;
constexpr double least_pace = 1.0 / 3.0;

Lanes load(const float* p) {
  Lanes x;
  std::memcpy(&x, p, sizeof(Lanes));
  return x;
}

/// a . b of at most a chunk: summed in lanes of floats, then in double.
double short_dot(const float* a, const float* b, std::size_t n) {
  Lanes sums[4] = {};
  std::size_t k = 0;
  for (; k + 4 * lanes <= n; k += 4 * lanes)
    for (std::size_t i = 0; i < 4; ++i) sums[i] += load(a + k + i * lanes) * load(b + k + i * lanes);
  double total = 0.0;
  for (; k < n; ++k) total += static_cast<double>(a[k]) * b[k];
  const Lanes sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
  for (std::size_t i = 0; i < lanes; ++i) total += sum[i];
  return total;
}

}  // namespace

SingleGmres::SingleGmres(const Comm& comm, std::size_t size, std::size_t room, Step step, int restart)
    : comm_(comm), size_(size), room_(room), step_(std::move(step)), restart_(restart), factor_(restart + 1, 1.0) {}

double SingleGmres::start(const float* b) {
  if (basis_.empty()) basis_.emplace_back(room_);
  double sum = 0.0;
  for (std::size_t k = 0; k < size_; k += chunk) {
    const std::size_t n = std::min(chunk, size_ - k);
    std::copy_n(b + k, n, &basis_[0][k]);
    sum += short_dot(b + k, b + k, n);
  }
  const double length = std::sqrt(comm_.sum(sum));
  if (length > 0.0) factor_[0] = 1.0 / length;
  return length;
}

void SingleGmres::project(const float* w, int count, double* h) const {
  std::fill_n(h, count, 0.0);
  for (std::size_t k = 0; k < size_; k += chunk)
    for (int j = 0; j < count; ++j) h[j] += short_dot(&basis_[j][k], w + k, std::min(chunk, size_ - k));
  comm_.sum(h, count);
  for (int j = 0; j < count; ++j) h[j] *= factor_[j];
}

double SingleGmres::remove(float* w, int count, const double* h) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < size_; k += chunk) {
    const std::size_t n = std::min(chunk, size_ - k);
    for (int j = 0; j < count; ++j) {
      const float factor = static_cast<float>(h[j] * factor_[j]);
      const float* v = &basis_[j][k];
      float* to = w + k;
      for (std::size_t i = 0; i < n; ++i) to[i] -= factor * v[i];
    }
    sum += short_dot(w + k, w + k, n);
  }
  return std::sqrt(comm_.sum(sum));
}

KrylovResult SingleGmres::solve(float* b, float* x, double tolerance, int maximum, bool impatient) {
  KrylovResult result;
  std::fill_n(x, size_, 0.0f);
  const double scale = start(b);
  if (scale == 0.0 || !std::isfinite(scale)) {
    result.converged = scale == 0.0;
    result.relative_residual = scale;
    return result;
  }
  double residual = 1.0, length_of_start = scale;
  std::vector<double> h(restart_ + 1), cosine(restart_), sine(restart_), right(restart_ + 1);
  std::vector<std::vector<double>> columns(restart_);
  const auto stalls = [&] {
    return impatient && result.iterations >= patience && residual > tolerance &&
           std::log(residual) * maximum > least_pace * std::log(tolerance) * result.iterations;
  };
  while (result.iterations < maximum && residual > tolerance && !result.stalled) {
    // b and the first vector of the basis hold the residual of x.
    if (!(length_of_start > 0.0) || !std::isfinite(length_of_start)) break;
    std::fill(right.begin(), right.end(), 0.0);
    right[0] = length_of_start / scale;
    int count = 0;
    bool finite = true;
    while (count < restart_ && result.iterations < maximum && residual > tolerance && !result.stalled) {
      if (static_cast<int>(basis_.size()) < count + 2) basis_.emplace_back(room_);
      if (static_cast<int>(directions_.size()) < count + 1) directions_.emplace_back(room_);
      float* next = basis_[count + 1].data();
      step_(basis_[count].data(), static_cast<float>(factor_[count]), directions_[count].data(), next);
      double length = 0.0;
      {
        const Timed timed("orthogonalisation");
        project(next, count + 1, h.data());
        length = remove(next, count + 1, h.data());
      }
      ++result.iterations;
      finite = std::isfinite(length);
      if (!finite) break;
      columns[count].assign(h.begin(), h.begin() + count + 1);
      for (int j = 0; j < count; ++j) {
        const double upper = columns[count][j];
        columns[count][j] = cosine[j] * upper + sine[j] * columns[count][j + 1];
        columns[count][j + 1] = -sine[j] * upper + cosine[j] * columns[count][j + 1];
      }
      const double diagonal = std::hypot(columns[count][count], length);
      if (diagonal == 0.0) break;
      cosine[count] = columns[count][count] / diagonal;
      sine[count] = length / diagonal;
      columns[count][count] = diagonal;
      right[count + 1] = -sine[count] * right[count];
      right[count] *= cosine[count];
      residual = std::abs(right[count + 1]);
      result.stalled = stalls();
      ++count;
      if (length <= 1e-7 * diagonal) break;  // the space holds the solution
      factor_[count] = 1.0 / length;
    }
    for (int i = count - 1; i >= 0; --i) {
      for (int j = i + 1; j < count; ++j) right[i] -= columns[j][i] * right[j];
      right[i] /= columns[i][i];
    }
    for (std::size_t k = 0; k < size_; k += chunk)
      for (int j = 0; j < count; ++j) {
        const float factor = static_cast<float>(right[j] * scale);
        const std::size_t end = std::min(size_, k + chunk);
        for (std::size_t i = k; i < end; ++i) x[i] += factor * directions_[j][i];
      }
    if (!finite) {
      residual = std::nan("");
      break;
    }
    if (residual <= tolerance || result.iterations >= maximum || result.stalled || count == 0) break;
    // Restart with r = V (start e_1 - H y): the rotations, backwards, of what the least squares problem leaves.
    std::vector<double> rest(count + 1, 0.0);
    rest[count] = right[count];
    for (int j = count - 1; j >= 0; --j) {
      const double lower = rest[j + 1];
      rest[j + 1] = cosine[j] * lower;
      rest[j] = -sine[j] * lower;
    }
    std::fill_n(b, size_, 0.0f);
    for (int j = 0; j <= count; ++j)
      for (std::size_t k = 0; k < size_; ++k) b[k] += static_cast<float>(scale * rest[j] * factor_[j]) * basis_[j][k];
    length_of_start = start(b);
  }
  result.relative_residual = residual;
  result.converged = residual <= tolerance;
  return result;
}

}  // namespace fbi::linalg
