/// Geometry of a batch of hexahedra at the Gauss points: axis-aligned boxes (constant) and general hexahedra (on the
/// fly).
///
/// Both offer the same five functions, so that a kernel is written once. All derivatives "along z" are with respect to
/// the scaled reference coordinates of hex8_transform.hpp.
#pragma once

#include "fluid/hex8_transform.hpp"

namespace fbi::fluid {

/// Data of eight boxes: K_d = dz_d/dx_d = 2/(h_d g) and the weight of a point, V/8.
template <class B>
struct BoxCellsOf {
  B scale[3];
  B weight;
};

/// Data of eight general hexahedra: the modes (all but the constant) of the coordinates.
template <class B>
struct GeneralCellsOf {
  B modes[3][8];
};

/// Eight boxes.
template <class B>
class BoxGeometryOf {
 public:
  using Number = B;
  using Cells = BoxCellsOf<B>;
  explicit BoxGeometryOf(const Cells& cells) : cells_(cells) {}

  /// The geometry at one point.
  class At {
   public:
    At(const BoxGeometryOf& geometry, int) : cells_(geometry.cells_) {}
    const B& weight() const { return cells_.weight; }
    /// Gradient in x from derivatives along z.
    void gradient(const B* along_z, B* out) const {
      for (int i = 0; i < 3; ++i) out[i] = cells_.scale[i] * along_z[i];
    }
    /// Reference flux, times the weight: out_d = w sum_j K_dj flux_j.
    void pull_back(const B* flux, B* out) const {
      for (int i = 0; i < 3; ++i) out[i] = (cells_.scale[i] * cells_.weight) * flux[i];
    }
    /// lap v + grad div v from the mixed second derivatives along z (mixed[i][d]: of v_i over the directions besides
    /// d); on a box lap v is zero and (grad div v)_i = sum_{j != i} d^2 v_j/(dx_i dx_j).
    void viscous(const B (*)[3], const B (*mixed)[3], B* out) const {
      const B xy = cells_.scale[0] * cells_.scale[1], yz = cells_.scale[1] * cells_.scale[2],
                  xz = cells_.scale[0] * cells_.scale[2];
      out[0] = xy * mixed[1][2] + xz * mixed[2][1];
      out[1] = xy * mixed[0][2] + yz * mixed[2][0];
      out[2] = xz * mixed[0][1] + yz * mixed[1][0];
    }

   private:
    const Cells& cells_;
  };

 private:
  const Cells& cells_;
};

/// Eight general hexahedra.
template <class B>
class GeneralGeometryOf {
 public:
  using Number = B;
  using Cells = GeneralCellsOf<B>;
  explicit GeneralGeometryOf(const Cells& cells) {
    for (int i = 0; i < 3; ++i)
      for (int d = 0; d < 3; ++d) {
        derivative_at_points(cells.modes[i], d, first_[i][d]);
        mixed_at_points(cells.modes[i], d, mixed_[i][d]);
      }
  }

  class At {
   public:
    At(const GeneralGeometryOf& geometry, int q) : geometry_(geometry), q_(q) {
      B j[3][3];  // dx_i/dz_d
      for (int i = 0; i < 3; ++i)
        for (int d = 0; d < 3; ++d) j[i][d] = geometry.first_[i][d][line_of_point(d, q)];
      B cofactor[3][3];
      for (int d = 0; d < 3; ++d)
        for (int i = 0; i < 3; ++i) {
          const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, d1 = (d + 1) % 3, d2 = (d + 2) % 3;
          cofactor[d][i] = j[i1][d1] * j[i2][d2] - j[i1][d2] * j[i2][d1];
        }
      const B determinant = j[0][0] * cofactor[0][0] + j[1][0] * cofactor[0][1] + j[2][0] * cofactor[0][2];
      const B inverse = B(1.0) / determinant;
      for (int d = 0; d < 3; ++d)
        for (int i = 0; i < 3; ++i) k_[d][i] = inverse * cofactor[d][i];
      weight_ = B(1.0 / (gauss_scale * gauss_scale * gauss_scale)) * determinant;
    }
    const B& weight() const { return weight_; }
    void gradient(const B* along_z, B* out) const {
      for (int i = 0; i < 3; ++i) out[i] = k_[0][i] * along_z[0] + k_[1][i] * along_z[1] + k_[2][i] * along_z[2];
    }
    void pull_back(const B* flux, B* out) const {
      for (int d = 0; d < 3; ++d) out[d] = weight_ * (k_[d][0] * flux[0] + k_[d][1] * flux[1] + k_[d][2] * flux[2]);
    }
    /// With the full Hessian of the map: d^2 v/(dx_i dx_j) = sum_{k,l} K_ki K_lj (d^2 v/(dz_k dz_l) - grad v . d^2
    /// x/(dz_k dz_l)).
    void viscous(const B (*gradient)[3], const B (*mixed)[3], B* out) const {
      for (int i = 0; i < 3; ++i) out[i] = B(0.0);
      for (int d = 0; d < 3; ++d) {
        const int layer = layer_of_point(d, q_);
        const B* kk = k_[other_directions[d][0]];
        const B* kl = k_[other_directions[d][1]];
        B h[3];
        for (int i = 0; i < 3; ++i)
          h[i] = mixed[i][d] -
                 (gradient[i][0] * geometry_.mixed_[0][d][layer] + gradient[i][1] * geometry_.mixed_[1][d][layer] +
                  gradient[i][2] * geometry_.mixed_[2][d][layer]);
        const B metric = B(2.0) * (kk[0] * kl[0] + kk[1] * kl[1] + kk[2] * kl[2]);
        const B along_k = kk[0] * h[0] + kk[1] * h[1] + kk[2] * h[2];
        const B along_l = kl[0] * h[0] + kl[1] * h[1] + kl[2] * h[2];
        for (int i = 0; i < 3; ++i) out[i] += metric * h[i] + kk[i] * along_l + kl[i] * along_k;
      }
    }

   private:
    const GeneralGeometryOf& geometry_;
    int q_;
    B k_[3][3];  // dz_d/dx_i
    B weight_;
  };

 private:
  B first_[3][3][4];
  B mixed_[3][3][2];
};

using BoxCells = BoxCellsOf<Batch>;
using GeneralCells = GeneralCellsOf<Batch>;
using BoxGeometry = BoxGeometryOf<Batch>;
using GeneralGeometry = GeneralGeometryOf<Batch>;

}  // namespace fbi::fluid
