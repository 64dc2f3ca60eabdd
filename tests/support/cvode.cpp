#include "tests/support/cvode.h"

#include "engine/lab/charts/cvode_session.h"

namespace springdrive::testing {

namespace {

/// The absolute tolerance is a hundredth of it.
constexpr double kRelativeTolerance = 1e-12;

int call_rates(realtype time_s, N_Vector y, N_Vector y_rate, void *rates) {
    charts::cvode::view<Eigen::VectorXd>(y_rate) =
        (*static_cast<const Rates *>(rates))(time_s, charts::cvode::view<Eigen::VectorXd>(y));
    return 0;
}

} // namespace

Eigen::VectorXd integrate(const Rates &rates, const Eigen::VectorXd &start, double end_s) {
    Rates function = rates;
    charts::cvode::Session<Eigen::VectorXd> session(charts::CvodeMethod::adams, kRelativeTolerance,
                                                    call_rates, start.size());
    session.restart(0.0, end_s, start, &function);
    double reached_s = 0.0;
    session.run(end_s, reached_s);
    return session.y();
}

} // namespace springdrive::testing
