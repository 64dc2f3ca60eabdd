// CVODE (SUNDIALS) as the reference for our own integrators.
#pragma once

#include <Eigen/Core>

#include <functional>

namespace springdrive::testing {

/// ẏ = f(t, y).
using Rates = std::function<Eigen::VectorXd(double time_s, const Eigen::VectorXd &y)>;

/// y at `end_s`, from `start` at time 0, by Adams' method of variable order and step. The error of
/// a step is kept below 1e-12 of each component, or 1e-14 if a component is small. @throw
/// std::runtime_error if CVODE fails.
[[nodiscard]] Eigen::VectorXd integrate(const Rates &rates, const Eigen::VectorXd &start,
                                        double end_s);

} // namespace springdrive::testing
