/// Profiles of the flow over a height: means over the other two directions.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "post/fiber_lines.hpp"
#include "post/outputs.hpp"
#include "post/table.hpp"

namespace fbi::post {

/// Which mean is taken.
struct ProfileOptions {
  int axis = 1;                  ///< of the height
  std::optional<Vec3> from, to;  ///< corners of the box that is averaged over; missing: all of the fluid [length]
  std::optional<Index> bins;     ///< missing: the node layers of a box, bins about as high as the cells elsewhere
  OutputChoice at;
  bool instantaneous = false;  ///< the flow of the moment although the run has running means
};

/// Means at one height (node layer) or over one bin. <.> is the mean over the area or volume.
struct ProfileRow {
  double height = 0.0;   ///< of the layer; of a bin the mean height of its volume [length]
  double measure = 0.0;  ///< area of the layer or volume of the bin
  Vec3 velocity = Vec3::Zero();
  double pressure = 0.0;
  std::array<double, 6> reynolds{};    ///< xx, xy, xz, yy, yz, zz [velocity^2]
  std::array<double, 6> dispersive{};  ///< the same; 0 without running means
};

/// With running means V, R (R_ij the mean in time of v_i'v_j'): velocity <V>, reynolds <R_ij>, dispersive
/// <V_i V_j> - <V_i><V_j>. Of one output: velocity <v>, reynolds <v_i v_j> - <v_i><v_j>, the fluctuations about the
/// mean over the plane.
struct Profiles {
  std::string run;
  int axis = 1;
  double time = 0.0;
  double averaged_over = 0.0;  ///< duration of the running means; 0 = of the moment [time]
  bool layers = false;         ///< rows are node layers, not bins
  std::vector<ProfileRow> rows;
  std::optional<CanopyHeight> canopy;
};

/// Takes the means of a run. On the layers of nodes of a box the integrals are exact for the trilinear fields. In bins
/// (always on other meshes) cells are cut into parts lower than a third of a bin, whose Gauss points go to the bin they
/// lie in, weighted by volume (so do those of cells that the box cuts): sums over all bins are the integrals over the
/// box, and a profile that is linear over a bin is exact at its mean height; what the mean changes with the height
/// within a bin is taken off the covariances. Throws Error(usage) for a box without fluid or an output that is not
/// there, Error(file) for a run without fluid or velocity.
Profiles mean_profiles(const Run& run, const ProfileOptions& options);

/// One row a height.
Table profile_table(const Profiles& profiles);

/// Velocity and stresses beside each other, the height upwards, the canopy as a dashed line. Writes BASE.dat and
/// BASE.gp; gnuplot makes BASE.svg, BASE.png and BASE.pdf. Returns the files' paths. Throws Error(file).
std::vector<std::string> write_profile_plot(const std::string& base, const Profiles& profiles);

}  // namespace fbi::post
