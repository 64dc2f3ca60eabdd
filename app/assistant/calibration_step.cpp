// Says whether the device is calibrated. The calibration itself is a command's.
#include "app/assistant/steps.h"
#include "device/core/calibration.h"

#include <fmt/format.h>

namespace springdrive::app::assistant {

namespace {

class CalibrationStep final : public Step {
public:
    void begin(session::Session & /*session*/) override {}
    void update(session::Session & /*session*/) override {}

    [[nodiscard]] StepReport report(const session::Session &session) const override {
        StepReport report;
        if (const auto &calibration = session.description().calibration) {
            report.verdict = Verdict::good;
            report.to_do = "The device is calibrated. Press Next.";
            report.seen.push_back("calibrated " + device::text_of_utc(calibration->made_at_s));
            const auto &motor = calibration->motor;
            report.seen.push_back(fmt::format("R: {:.4g}, {:.4g}, {:.4g} Ω",
                                              motor[0].resistance_Ohm, motor[1].resistance_Ohm,
                                              motor[2].resistance_Ohm));
            return report;
        }
        report.verdict = Verdict::skipped;
        report.to_do = "A first touch needs no calibration: press Next. Later, with this program "
                       "closed, springdrive device calibrate --to-board measures the windings.";
        report.seen.emplace_back("skipped: not calibrated");
        const auto &motor = session.description().motor;
        report.seen.push_back(fmt::format("R from the device file: {:.3g}, {:.3g}, {:.3g} Ω",
                                          motor[0].resistance_Ohm, motor[1].resistance_Ohm,
                                          motor[2].resistance_Ohm));
        report.seen.emplace_back("while you touch, the observer of R follows what it really is");
        return report;
    }
};

} // namespace

std::unique_ptr<Step> make_calibration_step() { return std::make_unique<CalibrationStep>(); }

} // namespace springdrive::app::assistant
