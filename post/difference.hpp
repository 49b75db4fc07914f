/// How much a field of one run differs from that of another one or from an exact solution.
#pragma once

#include <string>
#include <vector>

#include "input/expression.hpp"
#include "post/outputs.hpp"
#include "post/reader.hpp"

namespace fbi::post {

/// What is compared, and how.
struct DifferenceOptions {
  std::string field = "velocity";   ///< dataset of the outputs, or "centerline" of the fibers
  OutputChoice at;                  ///< of the first run; missing = the last time that both have
  bool on_coarse = false;           ///< integrate over the cells of the coarser mesh instead of the finer one
  bool remove_mean = false;         ///< of both fields, over the volume that both cover
  bool with_gradient = false;       ///< the H1 seminorm as well
  int points = 3;                   ///< Gauss points in each direction of a cell
  double allowed_uncovered = 0.01;  ///< part of the volume that only one of the meshes may cover
};

/// Norms of a difference and of what it is compared with: L2 norms over the common volume (or along all center lines),
/// the largest values at the Gauss points, the H1 seminorms (L2 norms of the gradient; 0 when not asked for).
struct Difference {
  std::string field;
  double time = 0.0;
  double l2 = 0.0, l2_reference = 0.0;
  double largest = 0.0, largest_reference = 0.0;
  double h1 = 0.0, h1_reference = 0.0;
  double measure = 0.0;    ///< volume (length) of the integral
  double uncovered = 0.0;  ///< part of the larger volume that was left out because only one mesh is there
  GlobalIndex cells = 0;   ///< cells (elements) of the first run
};

/// The field of `run` against that of `reference`, on meshes that need not match: Gauss points in the cells of the
/// finer mesh (more cells; with `on_coarse` of the coarser one), the other field at the same points in space. Equal
/// fields on equal meshes give exactly 0. Throws Error(usage) for a field or time that is not there (naming those that
/// are) and Error(geometry) when more volume is uncovered than allowed.
Difference field_difference(const Run& run, const Run& reference, const DifferenceOptions& options);

/// The field of `run` against formulas, one for each component: values at (x, y, z) and the time of the output. The
/// gradient of a formula is taken by central differences of fourth order.
Difference field_difference(const Run& run, const std::vector<input::Expression>& exact,
                            const DifferenceOptions& options);

/// The center lines of all fibers, by name, at equal shares of their reference lengths: sqrt(sum int |r - r_ref|^2 ds)
/// over the reference length; relative to the displacements of `reference`. The numbers of elements may differ.
Difference centerline_difference(const Run& run, const Run& reference, const DifferenceOptions& options);

/// The same against formulas for the position of the material point that is at (x, y, z) in the reference, at the time
/// of the output.
Difference centerline_difference(const Run& run, const std::vector<input::Expression>& exact,
                                 const DifferenceOptions& options);

/// "a, min(b, c), d" as three formulas. Throws Error(usage) when one is wrong or their number is not `components`.
std::vector<input::Expression> parse_formulas(const std::string& text, std::size_t components,
                                              const std::string& option);

}  // namespace fbi::post
