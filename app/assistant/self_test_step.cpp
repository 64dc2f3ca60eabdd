#include "app/assistant/self_test_step.h"

#include "app/assistant/steps.h"
#include "base/complaint.h"
#include "device/core/forwarding_device.h"
#include "device/simulated/stop_tour.h"
#include "engine/commissioning/self_test.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <mutex>
#include <utility>

namespace springdrive::app::assistant {

namespace {

using commissioning::Problem;
using commissioning::SelfTest;
using commissioning::SelfTestReport;
using commissioning::SelfTestStage;

/// For the picture, what is read on the way.
class WatchedDevice final : public device::ForwardingDevice {
public:
    using ForwardingDevice::ForwardingDevice;
    [[nodiscard]] device::Measurement read() noexcept override {
        measured_ = ForwardingDevice::read();
        return measured_;
    }
    [[nodiscard]] const device::Measurement &measured() const { return measured_; }

private:
    device::Measurement measured_;
};

/// A self-test on the thread of a loan. It is no servo's: it may wait for the window's frame.
class Run {
public:
    explicit Run(session::Session &session)
        : emulated_(session.device().emulated()), hand_(session.device().hand()),
          device_(session.device().device()), test_(device_) {}

    struct Snapshot {
        SelfTestStage stage = SelfTestStage::rest;
        std::string instruction;
        double share = 0.0;
        bool has_reached_all = false;
        Vector3 theta_rad{Vector3::Zero()};
    };

    /// One tick. @return whether there is more to do
    bool step() {
        const std::lock_guard lock(mutex_);
        move_hand();
        if (test_.stage() == SelfTestStage::motion &&
            (wants_end_ || (emulated_ == nullptr && test_.has_reached_all()))) {
            test_.finish_motion();
        }
        return test_.step();
    }

    [[nodiscard]] Snapshot snapshot() const {
        const std::lock_guard lock(mutex_);
        Snapshot now{
            test_.stage(), test_.instruction(), test_.share(), test_.has_reached_all(), {}};
        const auto &counts = device_.measured().counts;
        now.theta_rad =
            device_.description().rad_per_count() * Vector3(counts[0], counts[1], counts[2]);
        return now;
    }
    void finish_motion() {
        const std::lock_guard lock(mutex_);
        wants_end_ = true;
    }
    /// Once it is over.
    [[nodiscard]] SelfTestReport report() const { return test_.report(); }

private:
    /// The simulated hand does as the test asks.
    void move_hand() {
        if (emulated_ == nullptr || test_.stage() != SelfTestStage::motion) {
            return;
        }
        const double now_s = emulated_->board().time_s();
        if (!has_begun_) {
            has_begun_ = true;
            const simulated::HandPath path =
                simulated::stop_tour(device_.description(), hand_->hand_m());
            ends_s_ = now_s + path.end_s();
            hand_->follow(path);
        } else if (now_s > ends_s_) {
            wants_end_ = true;
        }
    }

    mutable std::mutex mutex_;
    factory::EmulatedDevice *emulated_;
    simulated::HandControl *hand_;
    WatchedDevice device_;
    SelfTest test_;
    bool has_begun_ = false;
    bool wants_end_ = false;
    double ends_s_ = 0.0; ///< the hand's path, by the board's time
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

class SelfTestStep final : public Step {
public:
    void begin(session::Session &session) override {
        stop(session);
        result_.reset();
        complaint_.clear();
        was_stopped_ = false;
    }

    void update(session::Session &session) override {
        if (!run_) {
            return;
        }
        now_ = run_->snapshot();
        if (session.is_lent()) {
            return;
        }
        complaint_ = session.loan_complaint();
        result_ = run_->report();
        was_stopped_ = complaint_.empty() && now_.stage != SelfTestStage::done;
        run_.reset();
        if (session.device().emulated() != nullptr) {
            session.hand().move_to(Vector3::Zero()); // where its path has ended
        }
    }

    void end(session::Session &session) override { stop(session); }

    [[nodiscard]] StepReport report(const session::Session &session) const override {
        if (run_) {
            return report_progress();
        }
        StepReport report;
        report.to_do =
            "Short pulses on each winding, then you move the device from stop to stop: "
            "hold the stylus loosely in the zero pose, and press \"start\". F12 ends it at "
            "any time.";
        if (!complaint_.empty()) {
            report.troubles.push_back({complaint_, "press Again"});
        } else if (was_stopped_) {
            report.troubles.push_back({"the self-test was stopped before its end", "press Again"});
        } else if (result_) {
            report_result(*result_, session.is_zeroed(), report);
        }
        return report;
    }

    [[nodiscard]] std::vector<Offer> offers(session::Session &session) override {
        if (run_) {
            std::vector<Offer> offers{{"stop", "ends the self-test now; the device brakes",
                                       [this, &session] { stop(session); }}};
            if (now_.stage == SelfTestStage::motion && session.device().emulated() == nullptr) {
                offers.push_back({"it was everywhere",
                                  "ends the motion; stops that were not reached are named",
                                  [this] { run_->finish_motion(); }});
            }
            return offers;
        }
        if (result_ || !complaint_.empty()) {
            return {};
        }
        return {{"start", "no motor is driven but for pulses of some milliseconds",
                 [this, &session] { start(session); }, !session.hand().follows_path()}};
    }

    [[nodiscard]] std::optional<Vector3> theta_rad() const override {
        return run_ && now_.stage != SelfTestStage::rest ? std::optional(now_.theta_rad)
                                                         : std::nullopt;
    }

private:
    void start(session::Session &session) {
        if (session.device().device().bench() == nullptr) {
            complaint_ = "this device has no board to test";
            return;
        }
        auto run = std::make_shared<Run>(session);
        complaint_ = complaint_of([&] { session.lend_device([run] { return run->step(); }); });
        if (complaint_.empty()) {
            run_ = run;
            now_ = {};
        }
    }

    void stop(session::Session &session) {
        if (run_) {
            session.take_device_back();
            update(session);
        }
    }

    [[nodiscard]] StepReport report_progress() const {
        StepReport report;
        report.to_do = now_.instruction.empty() ? "Wait." : now_.instruction + ".";
        report.to_do[0] = static_cast<char>(std::toupper(report.to_do[0]));
        report.bars.push_back(
            {"progress", now_.share, 0.0, 1.0,
             fmt::format("{}, {:.0f} %", stage_name(now_.stage), 100.0 * now_.share)});
        report.seen.emplace_back(now_.stage == SelfTestStage::motion
                                     ? "the device brakes: it resists like a damper"
                                     : "pulses of 0.8 V for 8 ms on one winding after the other");
        return report;
    }

    static void report_result(const SelfTestReport &result, bool is_zeroed, StepReport &report) {
        for (std::size_t i = 0; !result.pulses.empty() && i < 3; ++i) {
            const commissioning::WindingFigures &motor = result.windings.motor[i];
            if (!motor.is_measured()) {
                report.seen.push_back(fmt::format("motor {}: R and L were not measured", i + 1));
                continue;
            }
            report.seen.push_back(fmt::format(
                "motor {}: R {:.3f} Ω, L {:.3f} mH{}", i + 1, motor.resistance_Ohm,
                1e3 * motor.inductance_H,
                result.has_motion ? fmt::format(", counts {:.1f} %",
                                                100.0 * result.motion.motor[i].counts_per_turned)
                                  : ""));
        }
        for (const commissioning::Finding &finding : result.findings) {
            report.troubles.push_back({finding.what, finding.remedy});
        }
        const bool is_bad =
            !result.is_complete || !is_zeroed ||
            std::ranges::any_of(result.findings, [](const commissioning::Finding &finding) {
                return is_unsafe(finding.problem);
            });
        if (is_bad) {
            report.verdict = Verdict::bad;
            report.to_do =
                "The device must not be driven like this. Mend what is named below, then "
                "press Again.";
        } else if (!result.findings.empty()) {
            report.verdict = Verdict::doubtful;
            report.to_do = "Look at what is named below. A soft touch is possible all the same.";
            for (const commissioning::Finding &finding : result.findings) {
                report.unchecked +=
                    (report.unchecked.empty() ? "" : "; ") + unchecked_by(finding.problem);
            }
        } else {
            report.verdict = Verdict::good;
            report.to_do = "Nothing was found. Press Next.";
        }
    }

    std::shared_ptr<Run> run_;
    Run::Snapshot now_;
    std::optional<SelfTestReport> result_;
    std::string complaint_;
    bool was_stopped_ = false;
};

} // namespace

bool is_unsafe(Problem problem) {
    switch (problem) {
    case Problem::stops_not_reached:
    case Problem::wrong_inductance:
    case Problem::wrong_sensor_gain: // with a soft tuning's dR of 0.8 Ω, up to 50 % leave R̂ below R
        return false;
    case Problem::board_fault:
    case Problem::wrong_voltage:
    case Problem::open_winding:
    case Problem::reversed_sensor:
    case Problem::crossed_sensors:
    case Problem::wrong_resistance:
    case Problem::seized_joint:
    case Problem::dead_encoder:
    case Problem::reversed_encoder:
    case Problem::crossed_encoders:
    case Problem::wrong_counts:
    case Problem::wrong_zero:
    case Problem::test_aborted:
        break;
    }
    return true;
}

std::string unchecked_by(Problem problem) {
    switch (problem) {
    case Problem::stops_not_reached:
        return "counts and zero were not checked by that stop";
    case Problem::wrong_inductance:
        return "L of the device file is not this motor's, so stability margins do not apply";
    case Problem::wrong_sensor_gain:
        return "dR and the shown force of that channel are wrong by its sensor's gain";
    default:
        return "";
    }
}

std::unique_ptr<Step> make_self_test_step() { return std::make_unique<SelfTestStep>(); }

} // namespace springdrive::app::assistant
