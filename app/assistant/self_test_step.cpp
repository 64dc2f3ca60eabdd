#include "app/assistant/findings.h"
#include "app/assistant/loan_step.h"
#include "device/simulated/stop_tour.h"
#include "engine/commissioning/self_test.h"

namespace springdrive::app::assistant {

namespace {

using commissioning::SelfTest;
using commissioning::SelfTestReport;
using commissioning::SelfTestStage;

struct TestView {
    SelfTestStage stage = SelfTestStage::rest;
    std::string instruction;
    double share = 0.0;
    bool has_theta = false;
    Vector3 theta_rad{Vector3::Zero()};
};

const char *stage_name(SelfTestStage stage) {
    switch (stage) {
    case SelfTestStage::rest:
        return "at rest";
    case SelfTestStage::pulses:
        return "pulses";
    case SelfTestStage::motion:
        return "motion by hand";
    case SelfTestStage::done:
        break;
    }
    return "done";
}

class SelfTestStep final : public LoanStep<TestView, SelfTestReport> {
public:
    using LoanStep::LoanStep;

    void update() override {
        const bool was_running = is_running();
        LoanStep::update();
        if (was_running && !is_running() && session().device().emulated() != nullptr) {
            session().hand().move_to(Vector3::Zero()); // where its path has ended
        }
    }

    [[nodiscard]] StepReport report() const override {
        StepReport report;
        if (is_running()) {
            report_progress(report);
            return report;
        }
        report.to_do =
            "Short pulses on each winding, then you move the device from stop to stop: "
            "hold the stylus loosely in the zero pose, and press \"start\". F12 ends it at "
            "any time.";
        if (!error().empty()) {
            report.troubles.push_back({error(), "press Again"});
        } else if (was_stopped()) {
            report.troubles.push_back({"the self-test was stopped before its end", "press Again"});
        } else if (outcome()) {
            report_result(*outcome(), report);
        }
        return report;
    }

    [[nodiscard]] std::vector<Offer> offers() override {
        if (is_running()) {
            return offers_to_end(
                "ends the self-test now; the device brakes",
                view().stage == SelfTestStage::motion && session().device().emulated() == nullptr,
                "it was everywhere", "ends the motion; stops that were not reached are named");
        }
        if (outcome() || !error().empty()) {
            return {};
        }
        return {{"start", "no motor is driven but for pulses of some milliseconds",
                 [this] { start([this](const auto &talk) { return tick_of(talk); }); },
                 !session().hand().follows_path()}};
    }

private:
    /// It is no servo's: texts may be made on the way.
    [[nodiscard]] std::function<bool()> tick_of(const std::shared_ptr<Talk> &talk) const {
        factory::OpenDevice &device = session().device();
        const bool is_by_person = device.emulated() == nullptr;
        const auto test = std::make_shared<SelfTest>(
            device.device(), commissioning::SelfTestOptions{},
            simulated::stop_tour_of(is_by_person ? nullptr : device.hand(),
                                    device.device().description()));
        return [talk, test, is_by_person] {
            if (talk->wants_end || (is_by_person && test->has_reached_all())) {
                test->finish_motion();
            }
            const bool goes_on = test->step();
            talk->view.publish({test->stage(), test->instruction(), test->share(),
                                test->stage() != SelfTestStage::rest, test->theta_rad()});
            if (!goes_on) {
                talk->outcome = test->report();
            }
            return goes_on;
        };
    }

    void report_progress(StepReport &report) const {
        report.to_do = as_to_do(view().instruction, "Wait.");
        report.bars.push_back(
            {"progress", view().share, 0.0, 1.0,
             fmt::format("{}, {:.0f} %", stage_name(view().stage), 100.0 * view().share)});
        report.see("{}", view().stage == SelfTestStage::motion
                             ? "the device brakes: it resists like a damper"
                             : "pulses of 0.8 V for 8 ms on one winding after the other");
    }

    void report_result(const SelfTestReport &result, StepReport &report) const {
        for (std::size_t i = 0; !result.pulses.empty() && i < 3; ++i) {
            const commissioning::WindingFigures &motor = result.windings.motor[i];
            if (!motor.is_measured()) {
                report.see("motor {}: R and L were not measured", i + 1);
                continue;
            }
            report.see("motor {}: R {:.3f} Ω, L {:.3f} mH{}", i + 1, motor.resistance_Ohm,
                       1e3 * motor.inductance_H,
                       result.has_motion
                           ? fmt::format(", counts {:.1f} %",
                                         100.0 * result.motion.motor[i].counts_per_turned)
                           : "");
        }
        bool is_safe = result.is_complete && session().is_zeroed();
        for (const commissioning::Finding &finding : result.findings) {
            const std::string unchecked = unchecked_by(finding.problem);
            is_safe = is_safe && !unchecked.empty();
            report.troubles.push_back({finding.what, finding.remedy});
            report.unchecked += (report.unchecked.empty() ? "" : "; ") + unchecked;
        }
        if (!is_safe) {
            report.verdict = Verdict::bad;
            report.to_do =
                "The device must not be driven like this. Mend what is named below, then "
                "press Again.";
        } else if (!result.findings.empty()) {
            report.verdict = Verdict::doubtful;
            report.to_do = "Look at what is named below. A soft touch is possible all the same.";
        } else {
            report.verdict = Verdict::good;
            report.to_do = "Nothing was found. Press Next.";
        }
    }
};

} // namespace

std::unique_ptr<Step> make_self_test_step(session::Session &session) {
    return std::make_unique<SelfTestStep>(session);
}

} // namespace springdrive::app::assistant
