#include "fsi/fluid_solver.hpp"

#include <cmath>

#include "base/timer.hpp"
#include "coupling/complete_rows.hpp"
#include "fem/hex8.hpp"

namespace fbi::fsi {
namespace {

constexpr double robin = 3.0;                  // Robin coefficient of the pressure operator at open faces, times 1/h
constexpr GlobalIndex direct_below = 3000;     // unknowns; below, factorising beats iterating

/// Local part of a vector for reading, released at the end of the scope.
class Read {
 public:
  explicit Read(Vec v) : v_(v) { FBI_PETSC(VecGetArrayRead(v_, &data_)); }
  ~Read() { VecRestoreArrayRead(v_, &data_); }
  Read(const Read&) = delete;
  Read& operator=(const Read&) = delete;
  const double* get() const { return data_; }

 private:
  Vec v_;
  const double* data_ = nullptr;
};

/// Local part of a vector for writing.
class Write {
 public:
  explicit Write(Vec v) : v_(v) { FBI_PETSC(VecGetArray(v_, &data_)); }
  ~Write() { VecRestoreArray(v_, &data_); }
  Write(const Write&) = delete;
  Write& operator=(const Write&) = delete;
  double* get() const { return data_; }

 private:
  Vec v_;
  double* data_ = nullptr;
};

/// Ghosted form of a vector: owned entries, then ghosts.
class GhostedForm {
 public:
  explicit GhostedForm(Vec v) : v_(v) { FBI_PETSC(VecGhostGetLocalForm(v_, &local_)); }
  ~GhostedForm() { VecGhostRestoreLocalForm(v_, &local_); }
  GhostedForm(const GhostedForm&) = delete;
  GhostedForm& operator=(const GhostedForm&) = delete;
  Vec get() const { return local_; }

 private:
  Vec v_;
  Vec local_ = nullptr;
};

}  // namespace

FluidSolver::FluidSolver(fluid::FluidField& fluid, const coupling::Coupling* coupling,
                         const coupling::InterfaceOperator* interface, const SolverParameters& parameters)
    : fluid_(fluid), coupling_(coupling), interface_(interface), parameters_(parameters), comm_(fluid.mesh().comm) {
  const mesh::HexMesh& mesh = fluid_.mesh();
  ghosted_ = fluid_.create_vector();
  if (coupling_ != nullptr) rows_.resize(3 * static_cast<std::size_t>(coupling_->rows()));
  const bool steady = fluid_.sigma() == 0.0;
  direct_ = parameters_.linear == LinearSolver::direct || steady ||
            (parameters_.linear == LinearSolver::automatic && 4 * mesh.global_nodes < direct_below);
  if (direct_) {
    factors_ = std::make_unique<linalg::DirectSolver>(comm_);
    return;
  }
  work_ = fluid_.create_vector();
  work2_ = fluid_.create_vector();
  scaled_ = fluid_.create_vector();
  FBI_PETSC(VecCreateMPI(comm_.get(), mesh.owned_nodes, mesh.global_nodes, pressure_right_.out()));
  FBI_PETSC(VecDuplicate(pressure_right_, pressure_solution_.out()));
  krylov_ = std::make_unique<linalg::Krylov>(
      comm_, ghosted_, [this](Vec x, Vec y) { apply_operator(x, y); },
      [this](Vec r, Vec x) { apply_preconditioner(r, x); }, parameters_.krylov_iterations);
}

FluidSolver::~FluidSolver() = default;

double FluidSolver::continuity_scale() const {
  const double sigma = fluid_.sigma();
  return sigma > 0.0 ? fluid_.parameters().density * sigma * fluid_.smallest_cell() : 1.0;
}

double FluidSolver::project_residual(Vec r) const {
  if (!fluid_.pressure_is_free()) return 0.0;
  const mesh::HexMesh& mesh = fluid_.mesh();
  Write values(r);
  double sum = 0.0;
  for (Index a = 0; a < mesh.owned_nodes; ++a) sum += values.get()[4 * static_cast<std::size_t>(a) + 3];
  const double mean = comm_.sum(sum) / static_cast<double>(mesh.global_nodes);
  for (Index a = 0; a < mesh.owned_nodes; ++a) values.get()[4 * static_cast<std::size_t>(a) + 3] -= mean;
  return mean;
}

void FluidSolver::remove_mean_pressure(Vec x) const {
  if (!fluid_.pressure_is_free()) return;
  const mesh::HexMesh& mesh = fluid_.mesh();
  const std::vector<double>& volume = fluid_.lumped_volume();
  Write values(x);
  double sums[2] = {0.0, 0.0};
  for (Index a = 0; a < mesh.owned_nodes; ++a) {
    sums[0] += volume[a] * values.get()[4 * static_cast<std::size_t>(a) + 3];
    sums[1] += volume[a];
  }
  comm_.sum(sums, 2);
  for (Index a = 0; a < mesh.owned_nodes; ++a) values.get()[4 * static_cast<std::size_t>(a) + 3] -= sums[0] / sums[1];
}

void FluidSolver::interpolate(Vec u, std::vector<double>& out) const {
  Timed timed("M v");
  out.resize(3 * static_cast<std::size_t>(coupling_->rows()));
  GhostedForm form(u);
  Read values(form.get());
  coupling_->interpolate(values.get(), 4, out.data());
}

void FluidSolver::add_spread(const std::vector<double>& lambda, Vec r, bool dirichlet_rows) const {
  Timed timed("M^T lambda");
  FBI_PETSC(VecSet(ghosted_, 0.0));
  {
    GhostedForm form(ghosted_);
    FBI_PETSC(VecSet(form.get(), 0.0));
    Write values(form.get());
    coupling_->spread(lambda.data(), 4, values.get(), 1.0);
  }
  FBI_PETSC(VecGhostUpdateBegin(ghosted_, ADD_VALUES, SCATTER_REVERSE));
  FBI_PETSC(VecGhostUpdateEnd(ghosted_, ADD_VALUES, SCATTER_REVERSE));
  Read force(ghosted_);
  Write residual(r);
  const std::vector<char>& dirichlet = fluid_.is_dirichlet();
  const std::size_t owned = 4 * static_cast<std::size_t>(fluid_.mesh().owned_nodes);
  for (std::size_t k = 0; k < owned; ++k)
    if (dirichlet_rows || dirichlet[k] == 0) residual.get()[k] += force.get()[k];
}

void FluidSolver::apply_operator(Vec x, Vec y) {
  fluid_.apply_jacobian(x, y);
  if (coupling_ != nullptr && coupling_->global_rows() > 0) {
    {
      Read from(x);
      Write to(ghosted_);
      const std::vector<char>& dirichlet = fluid_.is_dirichlet();
      const std::size_t owned = 4 * static_cast<std::size_t>(fluid_.mesh().owned_nodes);
      for (std::size_t k = 0; k < owned; ++k) to.get()[k] = dirichlet[k] != 0 ? 0.0 : from.get()[k];
    }
    FBI_PETSC(VecGhostUpdateBegin(ghosted_, INSERT_VALUES, SCATTER_FORWARD));
    FBI_PETSC(VecGhostUpdateEnd(ghosted_, INSERT_VALUES, SCATTER_FORWARD));
    interpolate(ghosted_, rows_);
    interface_->solve(rows_.data());
    add_spread(rows_, y);
  }
  Write values(y);
  const double scale = continuity_scale();
  for (Index a = 0; a < fluid_.mesh().owned_nodes; ++a) values.get()[4 * static_cast<std::size_t>(a) + 3] *= scale;
}

void FluidSolver::velocity_block(const double* r, double* x) {
  Timed timed("velocity block");
  const Index owned = fluid_.mesh().owned_nodes;
  for (Index a = 0; a < owned; ++a)
    for (int i = 0; i < 3; ++i) {
      const std::size_t k = 4 * static_cast<std::size_t>(a) + i;
      x[k] = weight_[3 * static_cast<std::size_t>(a) + i] * r[k];
    }
  if (coupling_ == nullptr || coupling_->global_rows() == 0) return;
  {
    Write to(ghosted_);
    for (Index a = 0; a < owned; ++a) {
      for (int i = 0; i < 3; ++i)
        to.get()[4 * static_cast<std::size_t>(a) + i] = x[4 * static_cast<std::size_t>(a) + i];
      to.get()[4 * static_cast<std::size_t>(a) + 3] = 0.0;
    }
  }
  FBI_PETSC(VecGhostUpdateBegin(ghosted_, INSERT_VALUES, SCATTER_FORWARD));
  FBI_PETSC(VecGhostUpdateEnd(ghosted_, INSERT_VALUES, SCATTER_FORWARD));
  interpolate(ghosted_, rows_);
  factor_.solve(rows_.data());
  {
    GhostedForm form(ghosted_);
    FBI_PETSC(VecSet(form.get(), 0.0));
    Write values(form.get());
    coupling_->spread(rows_.data(), 4, values.get(), 1.0);
  }
  FBI_PETSC(VecGhostUpdateBegin(ghosted_, ADD_VALUES, SCATTER_REVERSE));
  FBI_PETSC(VecGhostUpdateEnd(ghosted_, ADD_VALUES, SCATTER_REVERSE));
  Read force(ghosted_);
  for (Index a = 0; a < owned; ++a)
    for (int i = 0; i < 3; ++i) {
      const std::size_t k = 4 * static_cast<std::size_t>(a) + i;
      x[k] -= weight_[3 * static_cast<std::size_t>(a) + i] * force.get()[k];
    }
}

void FluidSolver::apply_preconditioner(Vec r, Vec x) {
  Timed timed("preconditioner");
  const Index owned = fluid_.mesh().owned_nodes;
  const double scale = continuity_scale();
  const std::vector<char>& dirichlet = fluid_.is_dirichlet();
  const std::vector<double>& volume = fluid_.lumped_volume();
  const double viscosity = fluid_.parameters().viscosity;
  {
    Read right(r);
    Write u(x);
    velocity_block(right.get(), u.get());
    for (Index a = 0; a < owned; ++a) u.get()[4 * static_cast<std::size_t>(a) + 3] = 0.0;
  }
  apply_operator(x, work_);
  {
    Timed timed_pressure("pressure cycle");
    {
      Read right(r), product(work_);
      Write to(pressure_right_);
      for (Index a = 0; a < owned; ++a) {
        const std::size_t k = 4 * static_cast<std::size_t>(a) + 3;
        to.get()[a] = (right.get()[k] - product.get()[k]) / scale;
      }
    }
    pressure_->apply(pressure_right_, pressure_solution_);
    Read right(pressure_right_);
    Read solution(pressure_solution_);
    Write p(x);
    for (Index a = 0; a < owned; ++a)
      p.get()[4 * static_cast<std::size_t>(a) + 3] =
          pressure_scale_ * solution.get()[a] + viscosity / volume[a] * right.get()[a];
  }
  apply_operator(x, work_);
  {
    Read right(r);
    Write rest(work_);
    for (Index a = 0; a < owned; ++a)
      for (int i = 0; i < 3; ++i) {
        const std::size_t k = 4 * static_cast<std::size_t>(a) + i;
        rest.get()[k] = right.get()[k] - rest.get()[k];
      }
  }
  {
    Read rest(work_);
    Write correction(work2_);
    velocity_block(rest.get(), correction.get());
  }
  Read right(r), correction(work2_);
  Write u(x);
  for (Index a = 0; a < owned; ++a)
    for (int i = 0; i < 3; ++i) {
      const std::size_t k = 4 * static_cast<std::size_t>(a) + i;
      u.get()[k] = dirichlet[k] != 0 ? right.get()[k] : u.get()[k] + correction.get()[k];
    }
}

void FluidSolver::renew_pressure() {
  const double sigma = fluid_.sigma(), density = fluid_.parameters().density;
  // The Schur complement of the momentum rows. The inertial part of PSPG, tau (grad q, rho v'), takes from the divergence what
  // tau (grad q, grad p) adds: together they leave 1/(rho sigma), whatever tau is.
  pressure_scale_ = density * sigma;
  if (pressure_ != nullptr) return;
  Timed timed("pressure setup");
  const mesh::HexMesh& mesh = fluid_.mesh();
  if (linalg::TensorPoisson::supports(mesh)) {
    const std::array<std::array<bool, 2>, 3> open = fluid_.open_sides();
    std::array<std::array<double, 2>, 3> ends{};
    for (int d = 0; d < 3; ++d) {
      const std::vector<double>& x = mesh.box->coordinates[d];
      if (open[d][0]) ends[d][0] = robin / (x[1] - x[0]);
      if (open[d][1]) ends[d][1] = robin / (x[x.size() - 1] - x[x.size() - 2]);
    }
    pressure_ = std::make_unique<linalg::TensorPoisson>(mesh, ends);
    return;
  }
  const std::vector<double> one(mesh.local_cells(), 1.0);
  pressure_ = std::make_unique<linalg::MultigridPressure>(comm_, fluid_.pressure_laplacian(one, robin),
                                                          fluid_.pressure_is_free());
}

void FluidSolver::renew_weight() {
  Timed timed("velocity weight");
  const mesh::HexMesh& mesh = fluid_.mesh();
  const fluid::FluidParameters& parameters = fluid_.parameters();
  const double sigma = fluid_.sigma(), density = parameters.density, viscosity = parameters.viscosity;
  if (cell_size_.empty()) {
    for (Index c = 0; c < mesh.local_cells(); ++c) {
      Eigen::Matrix<double, 3, 8> corners;
      for (int a = 0; a < 8; ++a)
        corners.col(a) = Eigen::Map<const Vec3>(mesh.node(mesh.cells[8 * static_cast<std::size_t>(c) + a]));
      const Mat3 jacobian = 2.0 * corners * fem::hex8_gradient(Vec3::Zero());  // edge vectors of the cell's middle
      const double volume = std::abs(jacobian.determinant());
      double inverse_squares = 0.0;
      for (int i = 0; i < 3; ++i) inverse_squares += 1.0 / jacobian.col(i).squaredNorm();
      cell_size_.push_back(std::cbrt(volume));
      cell_diffusion_.push_back(volume / 9.0 * inverse_squares);  // int |grad N_a|^2, exact on boxes
    }
  }
  const bool convective = parameters.convective_form != fluid::ConvectiveForm::none;
  const std::vector<double>& tau = fluid_.tau_m();
  std::vector<double> diagonal(mesh.local_nodes(), 0.0);
  {
    GhostedForm form(fluid_.iterate());
    Read velocity(form.get());
    for (Index c = 0; c < mesh.local_cells(); ++c) {
      const Index* nodes = &mesh.cells[8 * static_cast<std::size_t>(c)];
      const double h = cell_size_[c];
      double speed = 0.0, reaction = 0.0;
      if (convective) {
        // Mean velocity and, from the spread around it, the size of its differences across the cell.
        Vec3 v = Vec3::Zero();
        double squares = 0.0;
        for (int a = 0; a < 8; ++a) {
          const Eigen::Map<const Vec3> at(velocity.get() + 4 * static_cast<std::size_t>(nodes[a]));
          v += 0.125 * at;
          squares += 0.125 * at.squaredNorm();
        }
        speed = v.norm();
        const double difference = 2.0 * std::sqrt(std::max(0.0, squares - v.squaredNorm()));
        // rho (v.grad) dv and rho (dv.grad) v
        reaction = density * (speed + difference) / h;
      }
      // One direction in three is streamline, and grad-div acts on one mode in three.
      const double streamline = density * density * tau[c] * speed * speed;
      const double grad_div = parameters.grad_div ? 0.5 * density * speed * h : 0.0;
      const double diffusion = (viscosity + (streamline + grad_div) / 3.0) * cell_diffusion_[c];
      for (int a = 0; a < 8; ++a) diagonal[nodes[a]] += diffusion + 0.125 * reaction * h * h * h;
    }
  }
  complete_ghosts(diagonal);
  const std::vector<double>& volume = fluid_.lumped_volume();
  const std::vector<char>& dirichlet = fluid_.is_dirichlet();
  weight_.resize(3 * static_cast<std::size_t>(mesh.local_nodes()));
  for (Index a = 0; a < mesh.local_nodes(); ++a)
    for (int i = 0; i < 3; ++i) {
      const std::size_t node = a;
      weight_[3 * node + i] = dirichlet[4 * node + i] != 0 ? 0.0 : 1.0 / (density * sigma * volume[a] + diagonal[a]);
    }
}

void FluidSolver::complete_ghosts(std::vector<double>& values) {
  const Index nodes = fluid_.mesh().local_nodes();
  {
    GhostedForm form(ghosted_);
    Write to(form.get());
    for (Index a = 0; a < nodes; ++a)
      for (int i = 0; i < 4; ++i) to.get()[4 * static_cast<std::size_t>(a) + i] = i == 0 ? values[a] : 0.0;
  }
  FBI_PETSC(VecGhostUpdateBegin(ghosted_, ADD_VALUES, SCATTER_REVERSE));
  FBI_PETSC(VecGhostUpdateEnd(ghosted_, ADD_VALUES, SCATTER_REVERSE));
  FBI_PETSC(VecGhostUpdateBegin(ghosted_, INSERT_VALUES, SCATTER_FORWARD));
  FBI_PETSC(VecGhostUpdateEnd(ghosted_, INSERT_VALUES, SCATTER_FORWARD));
  GhostedForm form(ghosted_);
  Read from(form.get());
  for (Index a = 0; a < nodes; ++a) values[a] = from.get()[4 * static_cast<std::size_t>(a)];
}

bool FluidSolver::renew_velocity(bool geometry_changed, bool interface_changed) {
  const mesh::HexMesh& mesh = fluid_.mesh();
  const bool first = weight_.empty();
  renew_weight();
  if (coupling_ == nullptr || coupling_->global_rows() == 0) return true;
  // The factor may lag behind the weight: fixed fibers keep theirs, which is what makes them cheap.
  if (!first && !geometry_changed && !interface_changed) return true;
  Timed timed("multiplier factor");
  const linalg::MultiplierRows rows = coupling::complete_rows(mesh, *coupling_, weight_);
  std::vector<linalg::InterfaceBlock> blocks;
  for (Index f = 0; f < interface_->fibers(); ++f) {
    const Index first = interface_->first_row_of(f), count = interface_->first_row_of(f + 1) - first;
    blocks.push_back({first, count, interface_->is_diagonal(f) ? nullptr : interface_->block(f).data(),
                      interface_->diagonal().data() + first});
  }
  return !comm_.any(!factor_.factorize(rows, blocks));
}

bool FluidSolver::prepare(bool geometry_changed, bool interface_changed) {
  if (direct_) return factorize_direct();
  renew_pressure();
  return renew_velocity(geometry_changed, interface_changed);
}

linalg::KrylovResult FluidSolver::solve(Vec b, Vec x, double tolerance) {
  Timed timed("linear solve");
  const mesh::HexMesh& mesh = fluid_.mesh();
  if (direct_) {
    const std::size_t owned = 4 * static_cast<std::size_t>(mesh.owned_nodes);
    FBI_PETSC(VecSet(extended_right_, 0.0));
    {
      Read right(b);
      Write to(extended_right_);
      std::copy_n(right.get(), owned, to.get());
      if (fluid_.pressure_is_free() && mesh.first_node == 0 && mesh.owned_nodes > 0) to.get()[3] = 0.0;
    }
    factors_->solve(extended_right_, extended_solution_);
    double finite = 0.0;
    {
      Read solution(extended_solution_);
      Write to(x);
      for (std::size_t k = 0; k < owned; ++k) {
        to.get()[k] = solution.get()[k];
        finite += solution.get()[k];
      }
    }
    remove_mean_pressure(x);
    linalg::KrylovResult result;
    result.iterations = 1;
    result.converged = !comm_.any(!std::isfinite(finite));
    return result;
  }
  FBI_PETSC(VecCopy(b, scaled_));
  {
    Write values(scaled_);
    const double scale = continuity_scale();
    for (Index a = 0; a < mesh.owned_nodes; ++a) values.get()[4 * static_cast<std::size_t>(a) + 3] *= scale;
  }
  const linalg::KrylovResult result = krylov_->solve(scaled_, x, tolerance);
  remove_mean_pressure(x);
  return result;
}

bool FluidSolver::factorize_direct() {
  Timed timed("direct factorisation");
  const mesh::HexMesh& mesh = fluid_.mesh();
  jacobian_ = fluid_.assemble_jacobian();
  const PetscInt owned = 4 * mesh.owned_nodes;
  const PetscInt rows = coupling_ != nullptr ? 3 * coupling_->rows() : 0;
  const GlobalIndex first_row = coupling_ != nullptr ? coupling_->first_row() : 0;
  // Rank r's extended unknowns: its fluid unknowns, then its multipliers.
  const GlobalIndex mine[2] = {4 * mesh.first_node, 3 * first_row};
  std::vector<GlobalIndex> starts(2 * comm_.size());
  MPI_Allgather(mine, 2, MPI_INT64_T, starts.data(), 2, MPI_INT64_T, comm_.get());
  const auto owner = [&](GlobalIndex number, int which) {
    int rank = comm_.size() - 1;
    while (rank > 0 && starts[2 * rank + which] > number) --rank;
    return rank;
  };
  const auto fluid_number = [&](GlobalIndex number) {
    return static_cast<PetscInt>(number + starts[2 * owner(number, 0) + 1]);
  };
  const auto multiplier_number = [&](GlobalIndex number) {  // number = 3 row + direction
    const int rank = owner(number, 1);
    const GlobalIndex fluid_end = rank + 1 < comm_.size() ? starts[2 * (rank + 1)] : 4 * mesh.global_nodes;
    return static_cast<PetscInt>(number + fluid_end);
  };

  std::vector<PetscInt> i, j;
  std::vector<double> v;
  const auto add = [&](PetscInt row, PetscInt column, double value) {
    i.push_back(row);
    j.push_back(column);
    v.push_back(value);
  };
  const bool pin = fluid_.pressure_is_free();  // the pressure of node 0 is the level; shifted to mean zero afterwards
  for (PetscInt row = 4 * mesh.first_node; row < 4 * mesh.first_node + owned; ++row) {
    if (pin && row == 3) {
      add(fluid_number(3), fluid_number(3), 1.0);
      continue;
    }
    PetscInt count = 0;
    const PetscInt* columns = nullptr;
    const PetscScalar* values = nullptr;
    FBI_PETSC(MatGetRow(jacobian_, row, &count, &columns, &values));
    for (PetscInt k = 0; k < count; ++k)
      if (!(pin && columns[k] == 3)) add(fluid_number(row), fluid_number(columns[k]), values[k]);
    FBI_PETSC(MatRestoreRow(jacobian_, row, &count, &columns, &values));
  }
  if (coupling_ != nullptr) {
    const coupling::LocalM& m = coupling_->local_m();
    const std::vector<char>& dirichlet = fluid_.is_dirichlet();
    for (std::size_t p = 0; p < m.row.size(); ++p)
      for (Index k = m.begin[p]; k < m.begin[p + 1]; ++k)
        for (int d = 0; d < 3; ++d) {
          const std::size_t local = 4 * static_cast<std::size_t>(m.node[k]) + d;
          if (dirichlet[local] != 0) continue;
          const PetscInt node = fluid_number(4 * mesh.node_number[m.node[k]] + d);
          const PetscInt multiplier = multiplier_number(3 * m.row[p] + d);
          add(node, multiplier, m.value[k]);
          add(multiplier, node, m.value[k]);
        }
    for (Index f = 0; f < interface_->fibers(); ++f) {
      const Index first = interface_->first_row_of(f), count = interface_->first_row_of(f + 1) - first;
      for (Index a = 0; a < 3 * count; ++a)
        for (Index b = 0; b < 3 * count; ++b) {
          if (interface_->is_diagonal(f) && a != b) continue;
          const double value =
              interface_->is_diagonal(f) ? interface_->diagonal()[first + a / 3] : interface_->block(f)(a, b);
          add(multiplier_number(3 * (first_row + first) + a), multiplier_number(3 * (first_row + first) + b), -value);
        }
    }
  }
  FBI_PETSC(MatCreate(comm_.get(), extended_.out()));
  FBI_PETSC(MatSetSizes(extended_, owned + rows, owned + rows, PETSC_DETERMINE, PETSC_DETERMINE));
  FBI_PETSC(MatSetType(extended_, MATAIJ));
  FBI_PETSC(MatSetPreallocationCOO(extended_, static_cast<PetscCount>(i.size()), i.data(), j.data()));
  FBI_PETSC(MatSetValuesCOO(extended_, v.data(), INSERT_VALUES));
  FBI_PETSC(MatCreateVecs(extended_, extended_right_.out(), extended_solution_.out()));
  return factors_->factorize(extended_);
}

}  // namespace fbi::fsi
