// The vector types of the whole program: double precision, SI units, right-handed device frame
// (x right, y up, z towards the user, origin at the tip of the zero pose).
#pragma once

#include <Eigen/Core>

namespace springdrive {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

} // namespace springdrive
