#include "linalg/tensor_poisson.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "linalg/owned_block.hpp"
#include "mesh/exchange.hpp"

namespace fbi::linalg {
namespace {

// Measured (docs/adr/0013): an exact solve takes 4 ns + 0.02 ns (n1 + n2) a node in double precision, n1 and n2 nodes
// across the axis; one multigrid cycle some 200 ns, and more and larger messages. Beyond this n1 + n2 multigrid wins.
constexpr GlobalIndex most_across = 8000;
constexpr double node_time = 4e-9, node_and_mode_time = 2e-11;  // [s]
constexpr double message_time = 2e-6, byte_time = 2e-10;        // [s], of a network
// Slabs exchange with all others; from this many ranks on a grid with fewer partners is considered.
constexpr int many_slabs = 32;

int longest(const std::array<Index, 3>& n) {
  int axis = 0;
  for (int d = 1; d < 3; ++d)
    if (n[d] > n[axis]) axis = d;
  return axis;
}

/// The direction along which the blocks are slabs that follow each other in the order of the ranks; -1: none.
int slab_axis(const std::vector<IndexBlock>& blocks, const std::array<Index, 3>& n) {
  int cut = 0;  // bit d: some block is not whole along d
  for (const IndexBlock& block : blocks) {
    if (block.size() == 0) return -1;
    for (int d = 0; d < 3; ++d)
      if (block.extent(d) != n[d]) cut |= 1 << d;
  }
  if (cut == 0) return longest(n);
  if (cut != 1 && cut != 2 && cut != 4) return -1;
  const int axis = cut / 2;
  Index next = 0;
  for (const IndexBlock& block : blocks) {
    if (block.begin[axis] != next) return -1;
    next = block.end[axis];
  }
  return axis;
}

}  // namespace

bool TensorPoisson::supports(const mesh::HexMesh& mesh) {
  if (!mesh.box || mesh.has_images()) return false;
  const std::array<Index, 3> n = box_nodes(mesh);
  if (GlobalIndex{n[0]} + n[1] + n[2] - n[longest(n)] > most_across) return false;
  return !mesh.comm.any(owned_range(mesh).size() != static_cast<std::size_t>(mesh.owned_nodes));
}

TensorPoisson::Modes TensorPoisson::diagonalise(const LineMatrices& line) {
  const Index n = static_cast<Index>(line.k_diagonal.size());
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n, n), m = k;
  for (Index i = 0; i < n; ++i) {
    k(i, i) = line.k_diagonal[i];
    m(i, i) = line.m_diagonal[i];
    if (i + 1 == n) continue;
    k(i, i + 1) = k(i + 1, i) = line.k_off[i];
    m(i, i + 1) = m(i + 1, i) = line.m_off[i];
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(k, m);
  Modes modes;
  modes.q = solver.eigenvectors();
  modes.eigenvalue.assign(solver.eigenvalues().data(), solver.eigenvalues().data() + n);
  // Modes of a line that is its own mirror image are even or odd.
  const double tolerance = 1e-10;
  std::vector<Index> even, odd;
  for (Index c = 0; c < n; ++c) {
    const Eigen::VectorXd mode = modes.q.col(c), mirror = mode.reverse();
    if ((mode - mirror).norm() <= tolerance * mode.norm()) even.push_back(c);
    if ((mode + mirror).norm() <= tolerance * mode.norm()) odd.push_back(c);
  }
  modes.mirrored = n > 1 && static_cast<Index>(even.size()) == (n + 1) / 2 && static_cast<Index>(odd.size()) == n / 2;
  if (!modes.mirrored) return modes;
  even.insert(even.end(), odd.begin(), odd.end());
  const LineTransform<double>::Matrix q = modes.q;
  for (Index c = 0; c < n; ++c) {
    modes.q.col(c) = q.col(even[c]);
    modes.eigenvalue[c] = solver.eigenvalues()[even[c]];
  }
  return modes;
}

TensorPoisson::TensorPoisson(const mesh::HexMesh& mesh, const std::array<std::array<double, 2>, 3>& robin,
                             const std::array<std::vector<double>, 3>& factor)
    : comm_(mesh.comm), nodes_(mesh.global_nodes), owned_(mesh.owned_nodes), n_(box_nodes(mesh)) {
  singular_ =
      std::all_of(robin.begin(), robin.end(), [](const auto& ends) { return ends[0] == 0.0 && ends[1] == 0.0; });
  const IndexBlock mine = owned_range(mesh);
  std::vector<IndexBlock> owned(comm_.size());
  static_assert(sizeof(IndexBlock) == 6 * sizeof(int));
  MPI_Allgather(&mine, 6, MPI_INT, owned.data(), 6, MPI_INT, comm_.get());
  axis_ = slab_axis(owned, n_);
  const bool slabs = axis_ >= 0 && comm_.size() <= many_slabs;
  if (axis_ < 0) axis_ = longest(n_);
  d1_ = axis_ == 0 ? 1 : 0;
  d2_ = axis_ == 2 ? 1 : 2;
  const auto matrices = [&](int d) { return LineMatrices(mesh.box->coordinates[d], robin[d], factor[d]); };
  line_ = matrices(axis_);
  modes1_ = diagonalise(matrices(d1_));
  modes2_ = diagonalise(matrices(d2_));
  if (singular_) modes1_.eigenvalue[0] = modes2_.eigenvalue[0] = 0.0;  // exactly: round-off must not decide the level
  owned_layout_ = {owned, {2, 1, 0}};
  if (slabs) {
    first_layout_ = second_layout_ = {owned, {d2_, d1_, axis_}};
    for (int r = 0; r < comm_.size(); ++r) {
      group_.rank.push_back(r);
      group_.begin.push_back(owned[r].begin[axis_]);
    }
    group_.begin.push_back(n_[axis_]);
    group_.me = comm_.rank();
    return;
  }
  choose_grid(owned);
}

void TensorPoisson::choose_grid(const std::vector<IndexBlock>& owned) {
  const int ranks = comm_.size();
  // The grid of least time: work of a rank, messages in a row and a column, and fields that are sent there and back.
  int along = 1, across = 1;  // ranks along the axis, and across it
  double least = std::numeric_limits<double>::max();
  for (int j = 1; j <= std::min({ranks, static_cast<int>(n_[d1_]), static_cast<int>(n_[d2_])}); ++j) {
    const int i = std::min(ranks / j, std::max(1, static_cast<int>(n_[axis_]) / 2));
    const double planes = std::ceil(static_cast<double>(n_[axis_]) / i);
    const double lines = std::ceil(static_cast<double>(n_[d1_]) / j) * n_[d2_];
    const double work = node_time + node_and_mode_time * (n_[d1_] + n_[d2_]);
    const double sent = byte_time * 2 * sizeof(double) * (j > 1 ? 2 : 1);
    const double time = planes * lines * (work + sent) + 2 * message_time * (i - 1 + j - 1);
    if (time < least) {
      least = time;
      along = i;
      across = j;
    }
  }
  first_layout_ = second_layout_ = {std::vector<IndexBlock>(owned.size()), {d2_, d1_, axis_}};
  for (int r = 0; r < along * across; ++r) {
    const auto range = [](Index count, int part, int parts) {
      return std::array<Index, 2>{static_cast<Index>(mesh::even_begin(count, part, parts)),
                                  static_cast<Index>(mesh::even_begin(count, part + 1, parts))};
    };
    const auto set = [&](BlockLayout& layout, int d, const std::array<Index, 2>& ends) {
      layout.blocks[r].begin[d] = ends[0];
      layout.blocks[r].end[d] = ends[1];
    };
    const int i = r / across, j = r % across;
    for (BlockLayout* layout : {&first_layout_, &second_layout_}) set(*layout, axis_, range(n_[axis_], i, along));
    set(first_layout_, d1_, range(n_[d1_], j, across));
    set(first_layout_, d2_, {0, n_[d2_]});
    set(second_layout_, d1_, {0, n_[d1_]});
    set(second_layout_, d2_, range(n_[d2_], j, across));
  }
  if (comm_.rank() >= along * across) return;
  for (int i = 0; i < along; ++i) {
    group_.rank.push_back(i * across + comm_.rank() % across);
    group_.begin.push_back(static_cast<Index>(mesh::even_begin(n_[axis_], i, along)));
  }
  group_.begin.push_back(n_[axis_]);
  group_.me = comm_.rank() / across;
}

template <class Real>
void TensorPoisson::make(std::unique_ptr<Tables<Real>>& tables) const {
  tables = std::make_unique<Tables<Real>>();
  tables->first = LineTransform<Real>(modes2_.q, modes2_.mirrored);
  tables->second = LineTransform<Real>(modes1_.q, modes1_.mirrored);
  const IndexBlock& first = first_layout_.blocks[comm_.rank()];
  const IndexBlock& second = second_layout_.blocks[comm_.rank()];
  if (!(owned_layout_ == first_layout_)) {
    tables->gather = BlockExchange<Real>(comm_, owned_layout_, first_layout_);
    tables->field.resize(first.size());
  }
  if (!(first_layout_ == second_layout_)) {
    tables->turn = BlockExchange<Real>(comm_, first_layout_, second_layout_);
    tables->turned.resize(second.size());
  }
  if (group_.rank.empty()) return;
  std::vector<double> lambda;
  for (Index m2 = second.begin[d2_]; m2 < second.end[d2_]; ++m2)
    for (Index m1 = 0; m1 < n_[d1_]; ++m1) lambda.push_back(modes2_.eigenvalue[m2] + modes1_.eigenvalue[m1]);
  const Index level_mode = singular_ && second.begin[d2_] == 0 ? 0 : -1;
  tables->lines = std::make_unique<LineSolver<Real>>(comm_, group_, line_, lambda, level_mode);
}

template <class Real>
void TensorPoisson::solve(std::unique_ptr<Tables<Real>>& tables, const Real* b, Real* x) {
  if (tables == nullptr) make(tables);
  Tables<Real>& t = *tables;
  const Real* right = b;
  if (singular_) {
    double mean = 0.0;
    for (Index a = 0; a < owned_; ++a) mean += static_cast<double>(b[a]);
    mean = comm_.sum(mean) / static_cast<double>(nodes_);
    for (Index a = 0; a < owned_; ++a) x[a] = b[a] - static_cast<Real>(mean);
    right = x;
  }
  const IndexBlock& first = first_layout_.blocks[comm_.rank()];
  const IndexBlock& second = second_layout_.blocks[comm_.rank()];
  const bool gathers = !(owned_layout_ == first_layout_), turns = !(first_layout_ == second_layout_);
  Real* field = gathers ? t.field.data() : x;
  Real* turned = turns ? t.turned.data() : field;
  if (gathers) {
    t.gather.forward(right, field);
    right = field;
  }
  const Index planes = first.extent(axis_);
  t.first.forward(1, first.extent(d1_) * planes, right, field);
  if (turns) t.turn.forward(field, turned);
  t.second.forward(second.extent(d2_), planes, turned, turned);
  if (t.lines != nullptr) t.lines->solve(turned);
  t.second.backward(second.extent(d2_), planes, turned, turned);
  if (turns) t.turn.backward(turned, field);
  t.first.backward(1, first.extent(d1_) * planes, field, field);
  if (gathers) t.gather.backward(field, x);
}

void TensorPoisson::apply(const double* b, double* x) { solve(double_, b, x); }

void TensorPoisson::apply(const float* b, float* x) { solve(float_, b, x); }

void TensorPoisson::apply(Vec b, Vec x) {
  const double* right = nullptr;
  double* solution = nullptr;
  FBI_PETSC(VecGetArrayRead(b, &right));
  FBI_PETSC(VecGetArray(x, &solution));
  apply(right, solution);
  FBI_PETSC(VecRestoreArray(x, &solution));
  FBI_PETSC(VecRestoreArrayRead(b, &right));
}

}  // namespace fbi::linalg
