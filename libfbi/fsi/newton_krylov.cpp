#include "fsi/newton_krylov.hpp"

#include <cmath>

namespace fbi::fsi {

InterfaceSolve interface_gmres(const Comm& comm,
                               const std::function<bool(const std::vector<double>&, std::vector<double>&)>& product,
                               const std::vector<double>& b, double tolerance, int maximum, std::vector<double>& x) {
  InterfaceSolve result;
  x.assign(b.size(), 0.0);
  const double size = std::sqrt(dot(comm, b, b));
  if (!(size > 0.0)) return result;
  std::vector<std::vector<double>> basis(1, b);
  for (double& value : basis[0]) value /= size;
  std::vector<std::vector<double>> columns;  // of the triangle that Givens rotations leave of the Hessenberg matrix
  std::vector<double> cosine, sine, right(1, size);
  while (result.iterations < maximum && std::abs(right.back()) > tolerance * size) {
    std::vector<double> next;
    if (!product(basis.back(), next)) {
      result.evaluated = false;
      return result;
    }
    ++result.iterations;
    std::vector<double> column;
    for (const std::vector<double>& direction : basis) {
      column.push_back(dot(comm, direction, next));
      for (std::size_t k = 0; k < next.size(); ++k) next[k] -= column.back() * direction[k];
    }
    const double length = std::sqrt(dot(comm, next, next));
    for (std::size_t k = 0; k < cosine.size(); ++k) {
      const double above = column[k];
      column[k] = cosine[k] * above + sine[k] * column[k + 1];
      column[k + 1] = cosine[k] * column[k + 1] - sine[k] * above;
    }
    const double diagonal = std::hypot(column.back(), length);
    if (!(diagonal > 0.0)) break;  // J is singular here: what there is must do
    cosine.push_back(column.back() / diagonal);
    sine.push_back(length / diagonal);
    column.back() = diagonal;
    columns.push_back(column);
    right.push_back(-sine.back() * right.back());
    right[right.size() - 2] *= cosine.back();
    if (!(length > 0.0)) break;
    for (double& value : next) value /= length;
    basis.push_back(std::move(next));
  }
  std::vector<double> y(columns.size());
  for (std::size_t i = columns.size(); i-- > 0;) {
    y[i] = right[i];
    for (std::size_t j = i + 1; j < columns.size(); ++j) y[i] -= columns[j][i] * y[j];
    y[i] /= columns[i][i];
    for (std::size_t k = 0; k < x.size(); ++k) x[k] += y[i] * basis[i][k];
  }
  return result;
}

bool NewtonKrylov::advance(std::vector<double>& x, const std::vector<double>& r, const NearbyMap& nearby) {
  const double size = std::sqrt(dot(comm_, x, x));
  std::vector<double> at(x.size()), minus(r.size()), change;
  for (std::size_t k = 0; k < r.size(); ++k) minus[k] = -r[k];
  const auto product = [&](const std::vector<double>& y, std::vector<double>& out) {
    const double delta = gamma_ * (gamma_ + size / std::sqrt(dot(comm_, y, y)));
    for (std::size_t k = 0; k < x.size(); ++k) at[k] = x[k] + delta * y[k];
    if (!nearby(at, out)) return false;
    for (std::size_t k = 0; k < x.size(); ++k) out[k] = (out[k] - at[k] - r[k]) / delta;
    return true;
  };
  const InterfaceSolve solve = interface_gmres(comm_, product, minus, tolerance_, maximum_, change);
  iterations_ = solve.iterations;
  if (!solve.evaluated) return false;
  for (std::size_t k = 0; k < x.size(); ++k) x[k] += change[k];
  return true;
}

}  // namespace fbi::fsi
