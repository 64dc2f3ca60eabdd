// Steps whose work is done on the thread of an exclusive use, once a person starts it: self-test
// and calibration. Window and exclusive use do not wait for each other:
//
//   window ── frames, wants_end ──► ExclusiveTalk ──► exclusive use: self-test, calibration
//   window ◄── view, outcome    ◄── ExclusiveTalk ◄──┘
#include "app/assistant/step.h"

#include "app/host/folders.h"
#include "base/degrees.h"
#include "base/hand_over.h"
#include "base/input_error.h"
#include "base/new_file.h"
#include "device/core/device_file.h"
#include "device/core/haptic_device.h"
#include "device/simulated/hand_tours.h"
#include "engine/commissioning/self_test.h"

#include <array>
#include <atomic>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <utility>

namespace springdrive::app::assistant {

namespace {

/// @tparam View     what is seen of it meanwhile, with the rotors' angles once they are measured
/// @tparam Outcome  what came of it
template <typename View, typename Outcome> struct ExclusiveTalk {
    // The window's:
    std::atomic<std::uint32_t> frames{1};
    std::atomic<bool> wants_end{false}; ///< of the motion, with what is known by then
    // The exclusive use's:
    LatestValue<View> view;
    std::optional<Outcome> outcome; ///< written last; none if it was ended before its end
};

template <typename View, typename Outcome> class ExclusiveStep : public Step {
public:
    using Step::Step;
    using Talk = ExclusiveTalk<View, Outcome>;

    void update() override {
        if (!talk_) {
            return;
        }
        talk_->frames.fetch_add(1, std::memory_order_relaxed);
        view_ = talk_->view.latest();
        if (session().is_in_exclusive_use()) {
            return;
        }
        set_error(session().exclusive_use_error());
        outcome_ = std::move(talk_->outcome);
        was_stopped_ = error().empty() && !outcome_;
        talk_.reset();
        conclude();
    }

    void end() override { stop(); }

protected:
    [[nodiscard]] bool is_running() const { return talk_ != nullptr; }
    [[nodiscard]] const View &view() const { return view_; }
    [[nodiscard]] const std::optional<Outcome> &outcome() const { return outcome_; }
    [[nodiscard]] bool was_stopped() const { return was_stopped_; } ///< by a person

    /// The exclusive use is over, whatever came of it.
    virtual void conclude() = 0;

    /// @param make_tick  of the talk: makes what `Session::begin_exclusive_use` takes; may throw
    /// InputError
    template <typename MakeTick> void start(const MakeTick &make_tick) {
        auto talk = std::make_shared<Talk>();
        outcome_.reset();
        was_stopped_ = false;
        view_ = {};
        attempt([&] {
            if (session().device().device().bench() == nullptr) {
                throw InputError("this device has no board");
            }
            session().begin_exclusive_use(make_tick(talk));
        });
        if (error().empty()) {
            talk_ = std::move(talk);
        }
    }

    void stop() {
        if (talk_) {
            session().end_exclusive_use();
            update();
        }
    }

    /// What there is to do while it runs, how to end it, and the rotors' angles.
    /// @param instruction  in lower case; empty: none
    void report_running(StepReport &report, std::string instruction, const char *otherwise,
                        const char *stop_means, bool has_theta) {
        report.to_do = otherwise;
        if (!instruction.empty()) {
            instruction[0] = static_cast<char>(std::toupper(instruction[0]));
            report.to_do = instruction + ".";
        }
        report.offers = {{"stop", stop_means, [this] { stop(); }}};
        if (has_theta) {
            report.theta_rad = view_.theta_rad;
        }
    }
    void offer_to_finish(StepReport &report, const char *label, const char *means) {
        report.offers.push_back({label, means, [this] { talk_->wants_end = true; }});
    }

private:
    std::shared_ptr<Talk> talk_; ///< while it runs
    View view_;
    std::optional<Outcome> outcome_;
    bool was_stopped_ = false;
};

using commissioning::SelfTest;
using commissioning::SelfTestReport;
using commissioning::SelfTestStage;

struct TestView {
    SelfTestStage stage = SelfTestStage::rest;
    std::string instruction;
    double share = 0.0;
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

class SelfTestStep final : public ExclusiveStep<TestView, SelfTestReport> {
public:
    using ExclusiveStep::ExclusiveStep;

    [[nodiscard]] StepReport report() override {
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
            return report;
        }
        if (outcome()) {
            report_result(*outcome(), report);
            return report;
        }
        if (was_stopped()) {
            report.troubles.push_back({"the self-test was stopped before its end", "press Again"});
        }
        report.offers = {{"start", "no motor is driven but for pulses of some milliseconds",
                          [this] { start([this](const auto &talk) { return tick_of(talk); }); },
                          !session().hand().follows_path()}};
        return report;
    }

private:
    void conclude() override {
        if (is_emulated()) {
            session().hand().move_to(Vector3::Zero()); // where its path has ended
        }
    }

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
            talk->view.publish(
                {test->stage(), test->instruction(), test->share(), test->theta_rad()});
            if (!goes_on) {
                talk->outcome = test->report();
            }
            return goes_on;
        };
    }

    void report_progress(StepReport &report) {
        report_running(report, view().instruction, "Wait.",
                       "ends the self-test now; the device brakes",
                       view().stage != SelfTestStage::rest);
        if (view().stage == SelfTestStage::motion && !is_emulated()) {
            offer_to_finish(report, "it was everywhere",
                            "ends the motion; stops that were not reached are named");
        }
        report.bars.push_back(
            {"progress", view().share, 0.0, 1.0,
             fmt::format("{}, {:.0f} %", stage_name(view().stage), 100.0 * view().share)});
        report.see("{}", view().stage == SelfTestStage::motion
                             ? "the device brakes: it resists like a damper"
                             : "pulses of 0.5 to 1.8 V for 8 ms on one winding after the other");
    }

    void report_result(const SelfTestReport &result, StepReport &report) const {
        for (std::size_t i = 0; !result.pulses.empty() && i < 3; ++i) {
            const commissioning::WindingFigures &motor = result.windings.motor[i];
            if (!motor.is_measured()) {
                report.see("motor {}: R and L were not measured", i + 1);
                continue;
            }
            report.see("motor {}: R {:.3f} Ω, V_b {:.0f} mV, L {:.3f} mH{}", i + 1,
                       motor.resistance_Ohm, 1e3 * motor.brush_V, 1e3 * motor.inductance_H,
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
                "The device must not be driven like this. Repair what is named below, then "
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

using commissioning::CalibrationRun;
using commissioning::CalibrationStage;

constexpr std::array<const char *, 3> kMotors{"motor 1 (base)", "motor 2 (upper arm)",
                                              "motor 3 (forearm)"};

/// Between two views: twice a frame.
constexpr int kTicksBetweenViews = 8;

/// At the end, for the board to clear the silence that it has latched while it was asked to store.
constexpr int kSettling_ticks = 100;

/// A device whose time waits is not run on for longer without the window, as by a servo; a share of
/// what would stop any other.
constexpr double kWaitingShare = 0.5;

/// Whether the device file has one of its own, which comes before a board's.
bool has_own_calibration(const std::filesystem::path &device_file) {
    bool has_one = false;
    static_cast<void>(error_text_of([&] { // one that cannot be read any more has none to come first
        has_one = device::read_device_file(device_file).calibration.has_value();
    }));
    return has_one;
}

struct CalibrationView {
    CalibrationStage stage = CalibrationStage::rest;
    double share = 0.0; ///< of the stage
    std::size_t min_known = 0;
    double motion_left_s = 0.0;
    std::array<commissioning::MotorProgress, 3> motor;
    Vector3 theta_rad{Vector3::Zero()};
};

struct CalibrationOutcome {
    commissioning::CalibrationReport report;
    std::optional<device::Calibration> kept; ///< by the board, as it will be read from there
    std::string storing_error;               ///< why the board does not keep it
};

using CalibrationTalk = ExclusiveTalk<CalibrationView, CalibrationOutcome>;

/// As it would be without a calibration: what was known before is no part of the result.
class Uncalibrated final : public device::ForwardingDevice {
public:
    explicit Uncalibrated(device::HapticDevice &device)
        : ForwardingDevice(device), description_(device.description()) {
        description_.calibration.reset();
    }
    [[nodiscard]] const device::DeviceDescription &description() const override {
        return description_;
    }

private:
    device::DeviceDescription description_;
};

/// Destroyed before its end, it brakes, and the board keeps what it had.
class ExclusiveCalibration {
public:
    /// @param device  used by `step` alone
    /// @throw InputError for a device of which nothing can be learned
    ExclusiveCalibration(factory::OpenDevice &device, std::shared_ptr<CalibrationTalk> talk)
        : talk_(std::move(talk)), device_(device.device()) {
        run_.emplace(
            device_, commissioning::CalibrationOptions{},
            simulated::calibration_tour_of(device.emulated() != nullptr ? device.hand() : nullptr,
                                           device_.description()));
    }

    /// One tick, CalibrationRun::kRate_hz times a second. @return whether there is more to do
    bool step() {
        if (!run_) {
            return settle();
        }
        if (waits_for_window()) {
            return true;
        }
        run_->note_window(frames_);
        if (talk_->wants_end) {
            run_->finish();
        }
        const bool goes_on = run_->step();
        if (!goes_on || ticks_++ % kTicksBetweenViews == 0) {
            talk_->view.publish({run_->stage(), run_->share(), run_->min_known(),
                                 run_->motion_left_s(), run_->progress(),
                                 run_->sample().theta_rad});
        }
        if (!goes_on) {
            end_run();
        }
        return true;
    }

private:
    [[nodiscard]] bool waits_for_window() {
        const std::uint32_t frames = talk_->frames.load(std::memory_order_relaxed);
        ticks_without_frame_ = frames == frames_ ? ticks_without_frame_ + 1 : 0;
        frames_ = frames;
        return device_.clock() == device::DeviceClock::servo &&
               ticks_without_frame_ > kWaitingShare * CalibrationRun::kRate_hz *
                                          device_.description().limits.window_silence_s;
    }

    /// The board keeps it, if it is one that can be kept.
    void end_run() {
        outcome_.report = run_->report();
        run_.reset(); // brakes
        if (outcome_.report.is_complete) {
            device::Bench &bench = *device_.bench();
            outcome_.storing_error = error_text_of([&] {
                bench.store(outcome_.report.calibration);
                outcome_.kept = bench.stored_calibration();
            });
        }
    }

    bool settle() {
        const device::Measurement measured = device_.read();
        device::DeviceCommand command = device::DeviceCommand::braking();
        command.number = measured.number;
        // Any other fault is left to the session's servo, which trips by it.
        command.resets_faults =
            reset_.may_follow(measured) && measured.faults.bits == device::BoardFaults::kNoCommand;
        device_.write(command);
        if (++settling_ticks_ < kSettling_ticks) {
            return true;
        }
        talk_->outcome = std::move(outcome_);
        return false;
    }

    std::shared_ptr<CalibrationTalk> talk_;
    Uncalibrated device_;
    std::optional<CalibrationRun> run_;
    CalibrationOutcome outcome_;
    int ticks_ = 0;
    int settling_ticks_ = 0;
    device::BoardReset reset_{false}; ///< in these
    std::uint32_t frames_ = 0;        ///< seen last
    int ticks_without_frame_ = 0;
};

/// What is still to be done, or to be known, when the step is entered again.
struct Memory {
    std::optional<device::Calibration> to_use;
    std::int64_t unkept_made_at_s = -1; ///< of the one that the next start does not use
};

class CalibrationStep final : public ExclusiveStep<CalibrationView, CalibrationOutcome> {
public:
    CalibrationStep(session::Session &session, std::shared_ptr<Memory> memory)
        : ExclusiveStep(session), memory_(std::move(memory)),
          file_comes_first_(has_own_calibration(session.device_choice().file)) {}

    void update() override {
        ExclusiveStep::update();
        use_if_possible();
    }

    [[nodiscard]] StepReport report() override {
        StepReport report;
        if (is_running()) {
            report_progress(report);
            return report;
        }
        const bool is_calibrated = session().description().calibration.has_value();
        report.offers = {{is_calibrated || outcome() || was_stopped() ? "calibrate again" : "start",
                          "the motors start once the tip is held still, and resist gently",
                          [this] { begin(); },
                          session().is_zeroed() && !session().hand().follows_path()}};
        if (outcome() && outcome()->report.is_complete) {
            report.offers.push_back({"save as a file",
                                     "a device file with the calibration, for --device-file",
                                     [this] { save(); }, saved_.empty()});
        } else if (!is_calibrated && !is_skipped_) {
            report.offers.push_back(
                {"skip", "the device file's values are used", [this] { is_skipped_ = true; }});
        }
        if (const std::string problem = error() + later_error_; !problem.empty()) {
            report.to_do = "The device is not calibrated. It can be touched all the same.";
            report.verdict = Verdict::doubtful;
            report.unchecked = kUnchecked;
            report.troubles.push_back({problem, "press Again"});
        } else if (outcome()) {
            report_outcome(report);
        } else {
            report_before(report);
        }
        return report;
    }

private:
    static constexpr const char *kUnchecked =
        "R and k_T of each motor are known to the device file's tolerance only; dR is held up for "
        "it until a touch has told them";

    void begin() {
        later_error_.clear();
        save_error_.clear();
        saved_.clear();
        is_skipped_ = false;
        start([this](const std::shared_ptr<Talk> &talk) {
            const auto exclusive_use =
                std::make_shared<ExclusiveCalibration>(session().device(), talk);
            const double rate_hz = session().servo().rate_hz();
            if (rate_hz != CalibrationRun::kRate_hz) {
                session().set_servo_rate(CalibrationRun::kRate_hz);
                rate_before_hz_ = rate_hz;
            }
            // It alone owns the run, which so has braked before the servo goes on.
            return [exclusive_use] { return exclusive_use->step(); };
        });
        if (!is_running()) {
            return_to_rate();
        }
    }

    void conclude() override {
        return_to_rate();
        if (outcome() && outcome()->report.is_complete) {
            const device::Calibration &used =
                outcome()->kept ? *outcome()->kept : outcome()->report.calibration;
            memory_->to_use = used;
            memory_->unkept_made_at_s = outcome()->kept && !file_comes_first_ ? -1 : used.made_at_s;
        }
        use_if_possible();
        if (is_emulated()) {
            static_cast<void>(
                error_text_of([&] { hold_zero_pose(session()); })); // else its tour ends by itself
        }
    }

    void use_if_possible() {
        const servo::ServoSample &now = session().latest();
        if (memory_->to_use && now.safety.state != servo::SafetyState::tripped &&
            now.health != device::DeviceHealth::lost && !session().is_exchanging()) {
            later_error_ = error_text_of([&] { session().use_calibration(*memory_->to_use); });
            memory_->to_use.reset();
        }
    }

    void return_to_rate() {
        if (const std::optional<double> before = std::exchange(rate_before_hz_, std::nullopt)) {
            later_error_ += error_text_of([&] { session().set_servo_rate(*before); });
        }
    }

    void save() {
        const std::filesystem::path file =
            std::filesystem::absolute(in_output_dir(dated_name("calibrated") + ".toml"))
                .lexically_normal();
        std::ifstream stream(session().device_choice().file, std::ios::binary);
        const std::string text{std::istreambuf_iterator<char>(stream), {}};
        save_error_ = error_text_of([&] {
            const std::string calibrated =
                device::with_calibration(text, outcome()->report.calibration);
            static_cast<void>(device::read_device_text(calibrated, file)); // as it will be read
            write_file(
                file, [&](std::ostream &out) { out << calibrated; }, Existing::keep);
        });
        saved_ = save_error_.empty() ? file.string() : "";
        if (!saved_.empty()) {
            memory_->unkept_made_at_s = -1;
        }
    }

    void report_progress(StepReport &report) {
        report_running(report, CalibrationRun::instruction(view().stage, view().min_known),
                       "Wait: the board keeps it.",
                       "ends it now; the device brakes, nothing is kept",
                       view().stage != CalibrationStage::rest);
        if (view().stage != CalibrationStage::motion) {
            report.bars.push_back(
                {view().stage == CalibrationStage::release ? "motors released" : "motors started",
                 view().share, 0.0, 1.0, fmt::format("{:.0f} %", 100.0 * view().share)});
            report.see("the motors resist gently, by about half a newton at the tip; they never "
                       "push");
            return;
        }
        offer_to_finish(report, "that is enough",
                        "ends the motion with what was found out by then");
        for (std::size_t j = 0; j < 3; ++j) {
            const commissioning::MotorProgress &motor = view().motor[j];
            report.bars.push_back(
                {kMotors[j], motor.share, 0.0, 1.0,
                 fmt::format("{:.0f} %, R {:.3f} ± {:.3f} Ω, {:.0f}°", 100.0 * motor.share,
                             motor.resistance_Ohm, 1.96 * motor.deviation_Ohm,
                             motor.moved_rad / kRadiansPerDegree)});
        }
        report.bars.push_back({"time left", view().motion_left_s, 0.0,
                               commissioning::CalibrationOptions{}.longest_motion_s,
                               fmt::format("at most {:.0f} s", view().motion_left_s)});
        report.see("full bars end it. The angle says how far the joint was moved");
        if (session().device_choice().kind == factory::DeviceKind::emulated) {
            report.see("an emulated device: its hand moves the tip about");
        }
    }

    void report_before(StepReport &report) const {
        const device::DeviceDescription &device = session().description();
        if (const auto &calibration = device.calibration) {
            report.verdict = Verdict::good;
            report.to_do = "The device is calibrated. Press Next; or calibrate it again, as after "
                           "a motor or the board was exchanged.";
            const bool is_kept = calibration->made_at_s != memory_->unkept_made_at_s;
            report.see("calibrated {}{}", device::text_of_utc(calibration->made_at_s),
                       !is_kept            ? ", in use until the program ends"
                       : file_comes_first_ ? ", kept in the device file"
                                           : ", kept by the board");
            describe(*calibration, device, report);
            report.see("zeroing anew leaves it as it is: of the ripple's place, which a zero by "
                       "eye does not tell, it makes no use");
        } else {
            report.verdict = is_skipped_ ? Verdict::skipped : Verdict::open;
            report.to_do =
                is_skipped_
                    ? "Skipped. Press Next: a first touch needs no calibration."
                    : "It measures each motor's R and k_T while you move the tip about, some 20 s. "
                      "Hold the stylus loosely and still in the middle of its workspace, and press "
                      "\"start\". F12 ends it at any time.";
            report.see("{}R from the device file: {:.3g}, {:.3g}, {:.3g} Ω, to within {:.0f} %",
                       is_skipped_ ? "skipped: not calibrated; " : "not calibrated; ",
                       device.motor[0].resistance_Ohm, device.motor[1].resistance_Ohm,
                       device.motor[2].resistance_Ohm,
                       100.0 * device.motor[0].resistance_tolerance);
            report.see("without one, the observer of R learns while you touch");
        }
        if (was_stopped()) {
            report.see("it was stopped before its end; nothing was kept");
        }
    }

    void report_outcome(StepReport &report) const {
        const commissioning::CalibrationReport &result = outcome()->report;
        if (!result.is_complete) {
            judge(result, report);
            report.to_do =
                report.verdict == Verdict::bad
                    ? "The device must not be driven like this. Repair what is named below."
                    : "Not calibrated. It can be touched all the same; better, do it again.";
            report.unchecked = kUnchecked;
            report.see("{:.0f} s of motion", result.motion_s);
            return;
        }
        describe(result.calibration, session().description(), report);
        describe_dR(result, report);
        report.verdict = memory_->to_use ? Verdict::open : Verdict::good;
        report.to_do = memory_->to_use
                           ? "The device is calibrated; that is used once it is no longer stopped."
                           : "The device is calibrated, and in use like that. Press Next.";
        report_keeping(report);
    }

    /// Where the calibration is after the end of the program.
    void report_keeping(StepReport &report) const {
        const std::string &refused = outcome()->storing_error;
        if (refused.empty()) {
            report.see("kept by the board, which every start asks for it");
        }
        if (!save_error_.empty()) {
            report.troubles.push_back({save_error_, "make room, and save it again"});
        }
        if (!saved_.empty()) {
            report.see("saved: start with --device-file {}", saved_);
            return;
        }
        if (!refused.empty() || file_comes_first_) {
            report.troubles.push_back(
                {!refused.empty()
                     ? refused
                     : session().device_choice().file.filename().string() +
                           " has a calibration of its own, which comes before the board's at each "
                           "start",
                 "press \"save as a file\", and start with that file from now on"});
        }
        if (!report.troubles.empty()) {
            report.verdict = Verdict::doubtful;
            report.to_do = "The device is calibrated, but only until the program ends.";
            report.unchecked = "the next start is without this calibration";
        }
    }

    std::shared_ptr<Memory> memory_;
    std::optional<double> rate_before_hz_; ///< of the servo
    std::string later_error_;              ///< of what came after the exclusive use
    std::string save_error_;
    std::string saved_; ///< as this file
    bool is_skipped_ = false;
    bool file_comes_first_;
};

} // namespace

MakeStep self_test_step() { return make_step<SelfTestStep>; }

MakeStep calibration_step() {
    return [memory = std::make_shared<Memory>()](session::Session &session) {
        return std::make_unique<CalibrationStep>(session, memory);
    };
}

} // namespace springdrive::app::assistant
