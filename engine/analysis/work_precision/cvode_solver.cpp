#include "engine/analysis/work_precision/cvode_solver.h"

#include "engine/analysis/work_precision/cvode_session.h"

namespace springdrive {

namespace {

int call_rates(realtype time_s, N_Vector y, N_Vector y_rate, void *equations) {
    cvode::view<PlantState>(y_rate) =
        static_cast<const PlantEquations *>(equations)->rates(time_s, cvode::view<PlantState>(y));
    return 0;
}

} // namespace

struct CvodeSolver::Parts {
    cvode::Session<PlantState> session;
};

CvodeSolver::CvodeSolver(CvodeMethod method, double relative_tolerance)
    : parts_(new Parts{{method, relative_tolerance, call_rates}}) {}

CvodeSolver::~CvodeSolver() = default;

PlantState CvodeSolver::advance(const PlantEquations &equations, double start_s, double end_s,
                                const PlantState &y) {
    PlantEquations now = equations;
    parts_->session.restart(start_s, end_s, y, &now);
    double reached_s = 0.0;
    parts_->session.run(end_s, reached_s);
    return parts_->session.y();
}

} // namespace springdrive
