#include "engine/lab/charts/cvode_solver.h"

#include "engine/lab/charts/cvode_session.h"

namespace springdrive::charts {

namespace {

int call_rates(realtype time_s, N_Vector y, N_Vector y_rate, void *equations) {
    cvode::view<rig::PlantState>(y_rate) =
        static_cast<const rig::PlantEquations *>(equations)->rates(time_s,
                                                                   cvode::view<rig::PlantState>(y));
    return 0;
}

} // namespace

struct CvodeSolver::Parts {
    cvode::Session<rig::PlantState> session;
};

CvodeSolver::CvodeSolver(CvodeMethod method, double relative_tolerance)
    : parts_(new Parts{{method, relative_tolerance, call_rates}}) {}

CvodeSolver::~CvodeSolver() = default;

rig::PlantState CvodeSolver::advance(const rig::PlantEquations &equations, double start_s,
                                     double end_s, const rig::PlantState &y) {
    rig::PlantEquations now = equations;
    parts_->session.restart(start_s, end_s, y, &now);
    double reached_s = 0.0;
    parts_->session.run(end_s, reached_s);
    return parts_->session.y();
}

} // namespace springdrive::charts
