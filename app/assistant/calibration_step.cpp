// The calibration, by a person who moves the tip by hand.
#include "app/assistant/calibration_loan.h"
#include "app/assistant/calibration_words.h"
#include "app/assistant/rehearsal.h"
#include "app/assistant/steps.h"
#include "app/host/own_folder.h"
#include "base/complaint.h"
#include "base/degrees.h"
#include "base/file_names.h"
#include "base/new_file.h"
#include "device/core/calibration_file.h"
#include "device/core/device_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <memory>
#include <ostream>
#include <utility>

namespace springdrive::app::assistant {

namespace {

using commissioning::CalibrationRun;
using commissioning::CalibrationStage;

constexpr std::array<const char *, 3> kMotors{"motor 1 (base)", "motor 2 (upper arm)",
                                              "motor 3 (forearm)"};

/// Whether the device file has one of its own, which comes before a board's.
bool has_own_calibration(const std::filesystem::path &device_file) {
    bool has_one = false;
    static_cast<void>(complaint_of([&] { // one that cannot be read any more has none to come first
        has_one = device::read_device_file(device_file).calibration.has_value();
    }));
    return has_one;
}

class CalibrationStep final : public Step {
public:
    void begin(session::Session &session) override {
        stop(session);
        outcome_.reset();
        complaint_.clear();
        save_complaint_.clear();
        saved_.clear();
        was_stopped_ = false;
        is_skipped_ = false;
        file_comes_first_ = has_own_calibration(session.device_choice().file);
    }

    void update(session::Session &session) override {
        if (talk_) {
            talk_->note_frame();
            view_ = talk_->view();
            if (session.is_lent()) {
                return;
            }
            conclude(session);
        }
        use_if_possible(session);
        if (std::exchange(hand_returns_, false) && session.device().emulated() != nullptr) {
            static_cast<void>(complaint_of([&] { hold_zero_pose(session); })); // or it rests here
        }
    }

    void end(session::Session &session) override { stop(session); }

    [[nodiscard]] StepReport report(const session::Session &session) const override {
        StepReport report;
        if (talk_) {
            report_progress(session, report);
        } else if (!complaint_.empty()) {
            report.to_do = "The device is not calibrated. It can be touched all the same.";
            report.verdict = Verdict::doubtful;
            report.unchecked = kUnchecked;
            report.troubles.push_back({complaint_, "press Again"});
        } else if (outcome_) {
            report_outcome(session, report);
        } else {
            report_before(session, report);
        }
        return report;
    }

    [[nodiscard]] std::vector<Offer> offers(session::Session &session) override {
        if (talk_) {
            std::vector<Offer> offers{{"stop", "ends it now; the device brakes, nothing is kept",
                                       [this, &session] { stop(session); }}};
            if (view_.stage == CalibrationStage::motion) {
                offers.push_back({"that is enough",
                                  "ends the motion with what was found out by then",
                                  [this] { talk_->finish(); }});
            }
            return offers;
        }
        const bool is_calibrated = session.description().calibration.has_value();
        std::vector<Offer> offers;
        offers.push_back({is_calibrated || outcome_ || was_stopped_ ? "calibrate again" : "start",
                          "the motors start once the tip is held still, and resist gently",
                          [this, &session] { start(session); },
                          session.is_zeroed() && !session.hand().follows_path()});
        if (outcome_ && outcome_->report.is_complete) {
            offers.push_back({"save as a file",
                              "a device file with the calibration, for --device-file",
                              [this, &session] { save(session); }, saved_.empty()});
        } else if (!is_calibrated && !is_skipped_) {
            offers.push_back(
                {"skip", "the device file's values are used", [this] { is_skipped_ = true; }});
        }
        return offers;
    }

    [[nodiscard]] std::optional<Vector3> theta_rad() const override {
        return talk_ && view_.stage != CalibrationStage::rest ? std::optional(view_.theta_rad)
                                                              : std::nullopt;
    }

private:
    static constexpr const char *kUnchecked =
        "R and k_T of each motor are known to the device file's tolerance only; dR is held up for "
        "it until a touch has told them";

    void start(session::Session &session) {
        begin(session);
        if (session.device().device().bench() == nullptr) {
            complaint_ = "this device has no board to calibrate";
            return;
        }
        const double rate_hz = session.servo().rate_hz();
        auto talk = std::make_shared<CalibrationTalk>();
        complaint_ = complaint_of([&] {
            auto loan = std::make_shared<CalibrationLoan>(session, talk);
            if (rate_hz != CalibrationRun::kRate_hz) {
                session.set_servo_rate(CalibrationRun::kRate_hz);
                rate_before_hz_ = rate_hz;
            }
            // It alone owns the run, which so has braked before the servo goes on.
            session.lend_device([loan = std::move(loan)] { return loan->step(); });
        });
        if (complaint_.empty()) {
            talk_ = std::move(talk);
            view_ = {};
        } else {
            return_to_rate(session);
        }
    }

    void stop(session::Session &session) {
        if (talk_) {
            session.take_device_back();
            update(session);
        }
    }

    /// It is over.
    void conclude(session::Session &session) {
        complaint_ = session.loan_complaint();
        outcome_ = talk_->outcome();
        was_stopped_ = complaint_.empty() && !outcome_;
        talk_.reset();
        hand_returns_ = true;
        return_to_rate(session);
        if (outcome_ && outcome_->report.is_complete) {
            to_use_ = outcome_->kept.value_or(outcome_->report.calibration);
            unkept_made_at_s_ = outcome_->kept && !file_comes_first_ ? -1 : to_use_->made_at_s;
        }
    }

    void use_if_possible(session::Session &session) {
        const servo::ServoSample &now = session.latest();
        if (to_use_ && now.safety.state != servo::SafetyState::tripped &&
            now.health != device::DeviceHealth::lost && !session.is_exchanging()) {
            complaint_ = complaint_of([&] { session.use_calibration(*to_use_); });
            to_use_.reset();
        }
    }

    void return_to_rate(session::Session &session) {
        if (const std::optional<double> before = std::exchange(rate_before_hz_, std::nullopt)) {
            complaint_ += complaint_of([&] { session.set_servo_rate(*before); });
        }
    }

    void save(session::Session &session) {
        const std::filesystem::path file =
            std::filesystem::absolute(in_own_folder(dated_name("calibrated") + ".toml"))
                .lexically_normal();
        std::ifstream stream(session.device_choice().file, std::ios::binary);
        const std::string text{std::istreambuf_iterator<char>(stream), {}};
        save_complaint_ = complaint_of([&] {
            const std::string calibrated =
                device::with_calibration(text, outcome_->report.calibration);
            static_cast<void>(device::read_device_text(calibrated, file)); // as it will be read
            write_file(
                file, [&](std::ostream &out) { out << calibrated; }, Existing::keep);
        });
        saved_ = save_complaint_.empty() ? file.string() : "";
        unkept_made_at_s_ = saved_.empty() ? unkept_made_at_s_ : -1;
    }

    void report_progress(const session::Session &session, StepReport &report) const {
        std::string to_do = CalibrationRun::instruction(view_.stage, view_.least_known);
        report.to_do = to_do.empty() ? "Wait: the board keeps it." : to_do + ".";
        report.to_do[0] = static_cast<char>(std::toupper(report.to_do[0]));
        const bool moves = view_.stage == CalibrationStage::motion;
        if (!moves) {
            report.bars.push_back(
                {view_.stage == CalibrationStage::release ? "motors released" : "motors started",
                 view_.share, 0.0, 1.0, fmt::format("{:.0f} %", 100.0 * view_.share)});
            report.seen.emplace_back("the motors resist gently, by about half a newton at the tip; "
                                     "they never push");
            return;
        }
        for (std::size_t j = 0; j < 3; ++j) {
            const commissioning::MotorProgress &motor = view_.motor[j];
            report.bars.push_back(
                {kMotors[j], motor.share, 0.0, 1.0,
                 fmt::format("{:.0f} %, R {:.3f} ± {:.3f} Ω, {:.0f}°", 100.0 * motor.share,
                             motor.resistance_Ohm, 1.96 * motor.deviation_Ohm,
                             motor.moved_rad / kRadiansPerDegree)});
        }
        report.bars.push_back({"time left", view_.motion_left_s, 0.0, longest_motion_s_,
                               fmt::format("at most {:.0f} s", view_.motion_left_s)});
        report.seen.emplace_back("full bars end it. The angle says how far the joint was moved");
        if (session.device_choice().kind == factory::DeviceKind::emulated) {
            report.seen.emplace_back("an emulated device: its hand moves the tip about");
        }
    }

    void report_before(const session::Session &session, StepReport &report) const {
        if (const auto &calibration = session.description().calibration) {
            report.verdict = Verdict::good;
            report.to_do = "The device is calibrated. Press Next; or calibrate it again, as after "
                           "a motor or the board was exchanged.";
            const bool is_kept = calibration->made_at_s != unkept_made_at_s_;
            report.seen.push_back("calibrated " + device::text_of_utc(calibration->made_at_s) +
                                  (!is_kept            ? ", in use until the program ends"
                                   : file_comes_first_ ? ", kept in the device file"
                                                       : ", kept by the board"));
            std::ranges::copy(words_of(*calibration, session.description()),
                              std::back_inserter(report.seen));
            report.seen.emplace_back(
                "zeroing anew leaves it as it is: of the ripple's place, which "
                "a zero by eye does not tell, it makes no use");
        } else if (is_skipped_) {
            report.verdict = Verdict::skipped;
            report.to_do = "Skipped. Press Next: a first touch needs no calibration.";
        } else {
            report.to_do =
                "It measures each motor's R and k_T while you move the tip about, some 20 s. Hold "
                "the stylus loosely and still in the middle of its workspace, and press "
                "\"start\". F12 ends it at any time.";
        }
        if (!session.description().calibration) {
            const auto &motor = session.description().motor;
            report.seen.push_back(fmt::format(
                "{}R from the device file: {:.3g}, {:.3g}, {:.3g} Ω, to within {:.0f} %",
                is_skipped_ ? "skipped: not calibrated; " : "not calibrated; ",
                motor[0].resistance_Ohm, motor[1].resistance_Ohm, motor[2].resistance_Ohm,
                100.0 * motor[0].resistance_tolerance));
            report.seen.emplace_back("without one, the observer of R learns while you touch");
        }
        if (was_stopped_) {
            report.seen.emplace_back("it was stopped before its end; nothing was kept");
        }
    }

    void report_outcome(const session::Session &session, StepReport &report) const {
        const commissioning::CalibrationReport &result = outcome_->report;
        if (!result.is_complete) {
            report.verdict = verdict_on(result.kind);
            report.to_do =
                report.verdict == Verdict::bad
                    ? "The device must not be driven like this. Mend what is named below."
                    : "Not calibrated. It can be touched all the same; better, do it "
                      "again.";
            report.unchecked = kUnchecked;
            report.troubles.push_back(trouble_of(result));
            report.seen.push_back(fmt::format("{:.0f} s of motion", result.motion_s));
            return;
        }
        std::ranges::copy(words_of(result.calibration, session.description()),
                          std::back_inserter(report.seen));
        report.seen.push_back(words_on_dR(result));
        report.verdict = Verdict::good;
        report.to_do = "The device is calibrated, and in use like that. Press Next.";
        if (to_use_) {
            report.verdict = Verdict::open;
            report.to_do = "The device is calibrated; that is used once it is no longer stopped.";
        }
        report_keeping(session, report);
    }

    /// Where the calibration is after the end of the program.
    void report_keeping(const session::Session &session, StepReport &report) const {
        const std::string &refused = outcome_->storing_complaint;
        if (refused.empty()) {
            report.seen.emplace_back("kept by the board, which every start asks for it");
        }
        if (!save_complaint_.empty()) {
            report.troubles.push_back({save_complaint_, "make room, and save it again"});
        }
        if (!saved_.empty()) {
            report.seen.push_back("saved: start with --device-file " + saved_);
            return;
        }
        if (!refused.empty()) {
            report.troubles.push_back(
                {refused, "press \"save as a file\", and start with that file from now on"});
        } else if (file_comes_first_) {
            report.troubles.push_back(
                {session.device_choice().file.filename().string() +
                     " has a calibration of its own, which comes before the board's at each start",
                 "press \"save as a file\", and start with that file from now on"});
        }
        if (!report.troubles.empty()) {
            report.verdict = Verdict::doubtful;
            report.to_do = "The device is calibrated, but only until the program ends.";
            report.unchecked = "the next start is without this calibration";
        }
    }

    std::shared_ptr<CalibrationTalk> talk_; ///< while it runs
    CalibrationView view_;
    std::optional<CalibrationOutcome> outcome_;
    std::optional<device::Calibration> to_use_;
    std::optional<double> rate_before_hz_; ///< of the servo
    double longest_motion_s_ = commissioning::CalibrationOptions{}.longest_motion_s;
    std::int64_t unkept_made_at_s_ = -1; ///< of the one that the next start does not use
    std::string complaint_;
    std::string save_complaint_;
    std::string saved_;         ///< as this file
    bool hand_returns_ = false; ///< of an emulated device
    bool was_stopped_ = false;
    bool is_skipped_ = false;
    bool file_comes_first_ = false;
};

} // namespace

std::unique_ptr<Step> make_calibration_step() { return std::make_unique<CalibrationStep>(); }

} // namespace springdrive::app::assistant
