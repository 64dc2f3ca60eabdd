#include "tests/support/cvode.h"

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <memory>
#include <stdexcept>
#include <string>

namespace springdrive::testing {

namespace {

constexpr double kRelativeTolerance = 1e-12;
constexpr double kAbsoluteTolerance = 1e-14;
constexpr long kMostSteps = 1'000'000;

/// What CVODE hands out, given back at the end of its scope.
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

SUNContext new_context() {
    SUNContext context = nullptr;
    SUNContext_Create(nullptr, &context);
    return context;
}
void free_context(SUNContext context) { SUNContext_Free(&context); }
void free_solver(SUNLinearSolver solver) { SUNLinSolFree(solver); }
void free_cvode(void *cvode) { CVodeFree(&cvode); }

void check(int status, const char *call) {
    if (status < 0) {
        throw std::runtime_error(std::string(call) + " failed with " + std::to_string(status));
    }
}

Eigen::Map<Eigen::VectorXd> view(N_Vector vector) {
    return {N_VGetArrayPointer(vector), N_VGetLength(vector)};
}

int call_rates(realtype time_s, N_Vector y, N_Vector y_rate, void *rates) {
    view(y_rate) = (*static_cast<const Rates *>(rates))(time_s, view(y));
    return 0;
}

} // namespace

Eigen::VectorXd integrate(const Rates &rates, const Eigen::VectorXd &start, double end_s) {
    Rates function = rates;
    const Owned<SUNContext, free_context> context(new_context());
    const Owned<N_Vector, N_VDestroy> y(N_VNew_Serial(start.size(), context.get()));
    const Owned<SUNMatrix, SUNMatDestroy> matrix(
        SUNDenseMatrix(start.size(), start.size(), context.get()));
    const Owned<SUNLinearSolver, free_solver> solver(
        SUNLinSol_Dense(y.get(), matrix.get(), context.get()));
    const Owned<void *, free_cvode> cvode(CVodeCreate(CV_ADAMS, context.get()));

    view(y.get()) = start;
    check(CVodeInit(cvode.get(), call_rates, 0.0, y.get()), "CVodeInit");
    check(CVodeSStolerances(cvode.get(), kRelativeTolerance, kAbsoluteTolerance),
          "CVodeSStolerances");
    check(CVodeSetUserData(cvode.get(), &function), "CVodeSetUserData");
    check(CVodeSetLinearSolver(cvode.get(), solver.get(), matrix.get()), "CVodeSetLinearSolver");
    check(CVodeSetMaxNumSteps(cvode.get(), kMostSteps), "CVodeSetMaxNumSteps");
    check(CVodeSetStopTime(cvode.get(), end_s), "CVodeSetStopTime");
    double reached_s = 0.0;
    check(CVode(cvode.get(), end_s, y.get(), &reached_s, CV_NORMAL), "CVode");
    return view(y.get());
}

} // namespace springdrive::testing
