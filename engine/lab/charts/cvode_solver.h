// CVODE (SUNDIALS) on the plant's equations: the reference of the integrators' chart, and one of
// the methods compared.
#pragma once

#include "engine/lab/charts/cvode_method.h"
#include "engine/lab/rig/plant_equations.h"

#include <memory>

namespace springdrive::charts {

class CvodeSolver {
public:
    /// @param relative_tolerance  of every step; in absolute terms a hundredth of it
    /// @throw std::runtime_error where CVODE has no memory
    CvodeSolver(CvodeMethod method, double relative_tolerance);
    ~CvodeSolver();
    CvodeSolver(const CvodeSolver &) = delete;
    CvodeSolver &operator=(const CvodeSolver &) = delete;

    /// y at `end_s`, from `y` at `start_s`. Restarts, as inputs are discontinuous at the start of a
    /// period.
    /// @throw std::runtime_error where CVODE fails
    [[nodiscard]] rig::PlantState advance(const rig::PlantEquations &equations, double start_s,
                                          double end_s, const rig::PlantState &y);

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

} // namespace springdrive::charts
