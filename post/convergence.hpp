/// Errors of several runs against a resolution, with observed orders.
#pragma once

#include <string>
#include <vector>

#include "post/plot.hpp"
#include "post/reader.hpp"
#include "post/table.hpp"

namespace fbi::post {

/// What the error is drawn against.
enum class Against { h, dt, elements, unknowns, wall };

/// "h", "dt", "elements", "unknowns", "wall"; nothing for another name.
std::optional<Against> against(const std::string& name);

/// Resolution and cost of a run.
struct Resolution {
  double h = 0.0;         ///< (volume/cells)^(1/3) of the fluid, else the mean length of the fiber elements [length]
  double dt = 0.0;        ///< of the last step; 0: steady
  double elements = 0.0;  ///< cells of the fluid, else fiber elements
  double unknowns = 0.0;  ///< 4 a fluid node, 6 a fiber node
  double wall = 0.0;      ///< sum of the steps' wall times [s]
  double of(Against against) const;
};

/// Throws Error(file).
Resolution resolution(const Run& run);

/// One error of one run.
struct ErrorPoint {
  std::string run;
  std::string what;  ///< such as "velocity L2"
  Resolution resolution;
  double error = 0.0;
};

/// Points sorted from coarse to fine for each `what`, in the order of first appearance; the slope of the error in
/// log-log between neighbours, positive when the error falls: log(e1/e2)/|log(x1/x2)|. Throws Error(usage) when two
/// runs have the same resolution or a resolution that is not positive.
Table convergence_table(const std::vector<ErrorPoint>& points, Against against);

/// Log-log plot with a triangle of the slope between the last two points of the first curve, rounded to a half.
/// Errors of zero are left out. Throws Error(usage) when nothing is left.
Plot convergence_plot(const std::vector<ErrorPoint>& points, Against against, const std::string& title);

}  // namespace fbi::post
