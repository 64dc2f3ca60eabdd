// The place of the calibration: another Step takes this one's, with nothing else changed.
#include "app/assistant/steps.h"

#include <fmt/format.h>

namespace springdrive::app::assistant {

namespace {

class NoCalibrationStep final : public Step {
public:
    void begin(session::Session & /*session*/) override {}
    void update(session::Session & /*session*/) override {}

    [[nodiscard]] StepReport report(const session::Session &session) const override {
        StepReport report;
        report.verdict = Verdict::skipped;
        report.to_do = "Nothing is to be done here yet: press Next.";
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

std::unique_ptr<Step> make_calibration_step() { return std::make_unique<NoCalibrationStep>(); }

} // namespace springdrive::app::assistant
