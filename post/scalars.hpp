/// Scalars of an output by name, such as "speed" or "velocity_x".
#pragma once

#include <string>
#include <vector>

#include "io/hdf5.hpp"

namespace fbi::post {

/// A scalar at points or nodes.
struct Scalar {
  std::string name;
  std::vector<double> values;

  /// Smallest and largest value; symmetric about 0 when both signs occur, the smaller one with a quarter of the other.
  std::array<double, 2> range() const;
};

/// From the dataset `group`/NAME of a step file: NAME (one component), NAME_x, _y, _z (three), NAME_xx ... NAME_zz
/// (six), NAME_magnitude; "speed" and "mean_speed" are the magnitudes of velocity and mean_velocity. Throws
/// Error(usage) that lists what there is, and `also` what the caller has besides.
Scalar read_scalar(const io::File& step, const std::string& group, const std::string& name,
                   const std::string& also = "");

/// The same of vectors in memory, NAME_x, _y, _z or NAME_magnitude; nothing for another name.
std::vector<double> component_of(const std::vector<double>& vectors, const std::string& component);

}  // namespace fbi::post
