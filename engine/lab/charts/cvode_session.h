// CVODE's objects for a set of equations, freed at the end of their scope.
#pragma once

#include "engine/lab/charts/plant_solvers.h"

#include <Eigen/Core>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <stdexcept>
#include <string>

namespace springdrive::charts::cvode {

inline constexpr long kMaxSteps = 1'000'000;
inline constexpr double kAbsoluteShare = 1e-2; ///< of the relative tolerance

/// An object allocated by CVODE, freed at the end of its scope.
template <typename Handle, void (*Free)(Handle)> class Owned {
public:
    explicit Owned(Handle handle) : handle_(handle) {
        if (handle == nullptr) {
            throw std::runtime_error("CVODE: out of memory");
        }
    }
    Owned(const Owned &) = delete;
    Owned &operator=(const Owned &) = delete;
    ~Owned() { Free(handle_); }

    [[nodiscard]] Handle get() const { return handle_; }

private:
    Handle handle_;
};

inline SUNContext new_context() {
    SUNContext context = nullptr;
    SUNContext_Create(nullptr, &context);
    return context;
}
inline void free_context(SUNContext context) { SUNContext_Free(&context); }
inline void free_solver(SUNLinearSolver solver) { SUNLinSolFree(solver); }
inline void free_cvode(void *cvode) { CVodeFree(&cvode); }

/// @throw std::runtime_error for a status that is an error
inline void check(int status, const char *call) {
    if (status < 0) {
        throw std::runtime_error(std::string(call) + " failed with " + std::to_string(status));
    }
}

/// @tparam State  an Eigen vector of that size
template <typename State> Eigen::Map<State> view(N_Vector vector) {
    return Eigen::Map<State>(N_VGetArrayPointer(vector), N_VGetLength(vector));
}

/// CVODE on ẏ = f(t, y), restarted as often as needed.
/// @tparam State  the Eigen vector that y is
template <typename State> class Session {
public:
    /// @param relative_tolerance  of every step; in absolute terms `kAbsoluteShare` of it
    /// @param rates  f(t, y); it and any root function receive the pointer passed to `restart`
    /// @param size  of y, where State is dynamic
    Session(CvodeMethod method, double relative_tolerance, CVRhsFn rates,
            Eigen::Index size = State::RowsAtCompileTime)
        : context_(new_context()), y_(N_VNew_Serial(size, context_.get())),
          matrix_(SUNDenseMatrix(size, size, context_.get())),
          solver_(SUNLinSol_Dense(y_.get(), matrix_.get(), context_.get())),
          cvode_(CVodeCreate(method == CvodeMethod::adams ? CV_ADAMS : CV_BDF, context_.get())) {
        view<State>(y_.get()).setZero();
        check(CVodeInit(cvode_.get(), rates, 0.0, y_.get()), "CVodeInit");
        check(CVodeSStolerances(cvode_.get(), relative_tolerance,
                                kAbsoluteShare * relative_tolerance),
              "CVodeSStolerances");
        check(CVodeSetLinearSolver(cvode_.get(), solver_.get(), matrix_.get()),
              "CVodeSetLinearSolver");
        check(CVodeSetMaxNumSteps(cvode_.get(), kMaxSteps), "CVodeSetMaxNumSteps");
    }

    /// Restarts at `start_s` and does not step beyond `end_s`.
    void restart(double start_s, double end_s, const State &y, void *given) {
        view<State>(y_.get()) = y;
        check(CVodeReInit(cvode_.get(), start_s, y_.get()), "CVodeReInit");
        check(CVodeSetUserData(cvode_.get(), given), "CVodeSetUserData");
        check(CVodeSetStopTime(cvode_.get(), end_s), "CVodeSetStopTime");
    }

    /// Integrates to `end_s`, or to where a root function crosses zero. Returns CVODE's status.
    int run(double end_s, double &reached_s) {
        const int status = CVode(cvode_.get(), end_s, y_.get(), &reached_s, CV_NORMAL);
        check(status, "CVode");
        return status;
    }

    [[nodiscard]] State y() const { return view<State>(y_.get()); }
    [[nodiscard]] void *get() const { return cvode_.get(); }

private:
    Owned<SUNContext, free_context> context_;
    Owned<N_Vector, N_VDestroy> y_;
    Owned<SUNMatrix, SUNMatDestroy> matrix_;
    Owned<SUNLinearSolver, free_solver> solver_;
    Owned<void *, free_cvode> cvode_;
};

} // namespace springdrive::charts::cvode
