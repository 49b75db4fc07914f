/// Geometry of a batch of hexahedra at the Gauss points: axis-aligned boxes (constant) and general hexahedra (on the
/// fly).
///
/// Both offer the same five functions, so that a kernel is written once. All derivatives "along z" are with respect to
/// the scaled reference coordinates of hex8_transform.hpp.
#pragma once

#include "fluid/hex8_transform.hpp"

namespace fbi::fluid {

/// Data of eight boxes: K_d = dz_d/dx_d = 2/(h_d g) and the weight of a point, V/8.
struct BoxCells {
  Batch scale[3];
  Batch weight;
};

/// Data of eight general hexahedra: the modes (all but the constant) of the coordinates.
struct GeneralCells {
  Batch modes[3][8];
};

/// Eight boxes.
class BoxGeometry {
 public:
  using Cells = BoxCells;
  explicit BoxGeometry(const BoxCells& cells) : cells_(cells) {}

  /// The geometry at one point.
  class At {
   public:
    At(const BoxGeometry& geometry, int) : cells_(geometry.cells_) {}
    const Batch& weight() const { return cells_.weight; }
    /// Gradient in x from derivatives along z.
    void gradient(const Batch* along_z, Batch* out) const {
      for (int i = 0; i < 3; ++i) out[i] = cells_.scale[i] * along_z[i];
    }
    /// Reference flux, times the weight: out_d = w sum_j K_dj flux_j.
    void pull_back(const Batch* flux, Batch* out) const {
      for (int i = 0; i < 3; ++i) out[i] = (cells_.scale[i] * cells_.weight) * flux[i];
    }
    /// lap v + grad div v from the mixed second derivatives along z (mixed[i][d]: of v_i over the directions besides
    /// d); on a box lap v is zero and (grad div v)_i = sum_{j != i} d^2 v_j/(dx_i dx_j).
    void viscous(const Batch (*)[3], const Batch (*mixed)[3], Batch* out) const {
      const Batch xy = cells_.scale[0] * cells_.scale[1], yz = cells_.scale[1] * cells_.scale[2],
                  xz = cells_.scale[0] * cells_.scale[2];
      out[0] = xy * mixed[1][2] + xz * mixed[2][1];
      out[1] = xy * mixed[0][2] + yz * mixed[2][0];
      out[2] = xz * mixed[0][1] + yz * mixed[1][0];
    }

   private:
    const BoxCells& cells_;
  };

 private:
  const BoxCells& cells_;
};

/// Eight general hexahedra.
class GeneralGeometry {
 public:
  using Cells = GeneralCells;
  explicit GeneralGeometry(const GeneralCells& cells) {
    for (int i = 0; i < 3; ++i)
      for (int d = 0; d < 3; ++d) {
        derivative_at_points(cells.modes[i], d, first_[i][d]);
        mixed_at_points(cells.modes[i], d, mixed_[i][d]);
      }
  }

  class At {
   public:
    At(const GeneralGeometry& geometry, int q) : geometry_(geometry), q_(q) {
      Batch j[3][3];  // dx_i/dz_d
      for (int i = 0; i < 3; ++i)
        for (int d = 0; d < 3; ++d) j[i][d] = geometry.first_[i][d][line_of_point(d, q)];
      Batch cofactor[3][3];
      for (int d = 0; d < 3; ++d)
        for (int i = 0; i < 3; ++i) {
          const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, d1 = (d + 1) % 3, d2 = (d + 2) % 3;
          cofactor[d][i] = j[i1][d1] * j[i2][d2] - j[i1][d2] * j[i2][d1];
        }
      const Batch determinant = j[0][0] * cofactor[0][0] + j[1][0] * cofactor[0][1] + j[2][0] * cofactor[0][2];
      const Batch inverse = Batch(1.0) / determinant;
      for (int d = 0; d < 3; ++d)
        for (int i = 0; i < 3; ++i) k_[d][i] = inverse * cofactor[d][i];
      weight_ = Batch(1.0 / (gauss_scale * gauss_scale * gauss_scale)) * determinant;
    }
    const Batch& weight() const { return weight_; }
    void gradient(const Batch* along_z, Batch* out) const {
      for (int i = 0; i < 3; ++i) out[i] = k_[0][i] * along_z[0] + k_[1][i] * along_z[1] + k_[2][i] * along_z[2];
    }
    void pull_back(const Batch* flux, Batch* out) const {
      for (int d = 0; d < 3; ++d) out[d] = weight_ * (k_[d][0] * flux[0] + k_[d][1] * flux[1] + k_[d][2] * flux[2]);
    }
    /// With the full Hessian of the map: d^2 v/(dx_i dx_j) = sum_{k,l} K_ki K_lj (d^2 v/(dz_k dz_l) - grad v . d^2
    /// x/(dz_k dz_l)).
    void viscous(const Batch (*gradient)[3], const Batch (*mixed)[3], Batch* out) const {
      for (int i = 0; i < 3; ++i) out[i] = Batch(0.0);
      for (int d = 0; d < 3; ++d) {
        const int layer = layer_of_point(d, q_);
        const Batch* kk = k_[other_directions[d][0]];
        const Batch* kl = k_[other_directions[d][1]];
        Batch h[3];
        for (int i = 0; i < 3; ++i)
          h[i] = mixed[i][d] -
                 (gradient[i][0] * geometry_.mixed_[0][d][layer] + gradient[i][1] * geometry_.mixed_[1][d][layer] +
                  gradient[i][2] * geometry_.mixed_[2][d][layer]);
        const Batch metric = Batch(2.0) * (kk[0] * kl[0] + kk[1] * kl[1] + kk[2] * kl[2]);
        const Batch along_k = kk[0] * h[0] + kk[1] * h[1] + kk[2] * h[2];
        const Batch along_l = kl[0] * h[0] + kl[1] * h[1] + kl[2] * h[2];
        for (int i = 0; i < 3; ++i) out[i] += metric * h[i] + kk[i] * along_l + kl[i] * along_k;
      }
    }

   private:
    const GeneralGeometry& geometry_;
    int q_;
    Batch k_[3][3];  // dz_d/dx_i
    Batch weight_;
  };

 private:
  Batch first_[3][3][4];
  Batch mixed_[3][3][2];
};

}  // namespace fbi::fluid
