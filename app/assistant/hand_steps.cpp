// Steps by a person alone: which device, what it is, each joint by hand, zeroing, and a first
// touch.
#include "app/assistant/step.h"

#include "app/host/folders.h"
#include "app/panels/panels.h"
#include "base/degrees.h"
#include "base/text.h"
#include "device/core/haptic_device.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/tuning_file.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <system_error>

namespace springdrive::app::assistant {

namespace {

using factory::DeviceKind;

/// A step in which the simulated hand of an emulated device can do what a person is asked to.
class HandStep : public Step {
public:
    using Step::Step;

protected:
    /// Offers that the hand does it, if there is one, and is free.
    /// @param what  "its hand moves this joint, and back"
    /// @param act   may throw InputError
    void offer_hand(StepReport &report, const char *what, std::function<void()> act,
                    bool is_possible = true) {
        if (is_emulated()) {
            report.offers.push_back({"let the simulated hand do it",
                                     std::string("an emulated device: ") + what,
                                     [this, act = std::move(act)] { attempt(act); },
                                     is_possible && !session().hand().follows_path()});
        }
    }
};

/// A link is judged by so many ticks.
constexpr std::uint64_t kJudgedReports = 1500;
/// Of reports that were lost, late or damaged. The servo bears single ones; a hundred a second is
/// no good cable.
constexpr double kBearableShare = 1e-3;

/// Ticks without their report, and commands that did not arrive. A report that is lost is one that
/// a tick misses, too.
std::uint64_t faulty_of(const device::LinkStatus &link) {
    return std::max(link.lost, link.absent) + link.late + link.rejected + link.unsent;
}

class LinkStep final : public Step {
public:
    explicit LinkStep(session::Session &session) : Step(session) {
        if (const auto link = session.device().device().link()) {
            reports_before_ = link->reports;
            faulty_before_ = faulty_of(*link);
        }
    }

    void update() override {
        const auto link = session().device().device().link();
        if (link && link->reports < reports_before_) { // connected again
            reports_before_ = 0;
            faulty_before_ = 0;
        }
    }

    [[nodiscard]] StepReport report() override {
        StepReport report;
        if (session().device_choice().kind == DeviceKind::simulated) {
            report_choice(report);
        } else {
            report_link(report);
        }
        if (!error().empty()) {
            report.troubles.push_back({error(), "ask the doctor, then try again"});
        }
        return report;
    }

private:
    void use(const factory::PresentDevice &device) {
        session::DeviceChoice choice = session().device_choice();
        choice.kind = device.kind;
        choice.serial = device.serial;
        attempt([&] { session().exchange_device(choice); });
    }

    void report_choice(StepReport &report) {
        report.to_do =
            "The plain simulation needs no commissioning. Plug in the board, press Again, "
            "and choose it; or rehearse with an emulated one.";
        bool has_board = false;
        for (const factory::PresentDevice &device : present_) {
            if (device.kind != DeviceKind::simulated && !session().is_exchanging()) {
                report.offers.push_back(
                    {device.kind == DeviceKind::usb ? "use the board " + device.serial
                                                    : "use an emulated board, to rehearse",
                     device.problem, [this, device] { use(device); }, device.problem.empty()});
            }
            if (device.kind != DeviceKind::usb) {
                continue;
            }
            has_board = true;
            report.see("USB board {}", device.serial);
            if (!device.problem.empty()) {
                report.troubles.push_back({device.serial, device.problem});
            }
        }
        if (!has_board) {
            report.see("no USB board is connected");
        }
        report.asks_doctor = "usb";
    }

    void report_link(StepReport &report) const {
        report.to_do = "Wait while the connection is watched for some seconds.";
        report.asks_doctor = name_of(session().device_choice());
        const auto link = session().device().device().link();
        if (!link || session().latest().health == device::DeviceHealth::lost) {
            return; // said by the assistant
        }
        const std::uint64_t reports = link->reports - std::min(reports_before_, link->reports);
        const std::uint64_t faulty = faulty_of(*link) - std::min(faulty_before_, faulty_of(*link));
        report.see("{} device, serial number {}, {}", session().device().identity().kind,
                   session().device().identity().serial, link->speed);
        const double d = link->delay_s / session().servo().period_s();
        report.see(
            "{:.0f} reports a second; d {}, round trip {:.0f} µs", session().servo().rate_hz(),
            d > 0.0 ? fmt::format("{:.2f} periods", d) : "not measured", // of a board in a fault
            1e6 * link->round_trip_s);
        report.see("{} of {} reports not whole or not in time", faulty, reports);
        const double watched = static_cast<double>(reports) / static_cast<double>(kJudgedReports);
        report.bars.push_back(
            {"watched", std::min(1.0, watched), 0.0, 1.0, fmt::format("{} reports", reports)});
        if (reports < kJudgedReports) {
            return;
        }
        if (static_cast<double>(faulty) <= kBearableShare * static_cast<double>(reports)) {
            report.verdict = Verdict::good;
            report.to_do = "The connection is good. Press Next.";
            return;
        }
        report.verdict = Verdict::doubtful;
        report.troubles.push_back(
            {fmt::format("{:.2f} % of all reports did not arrive whole and in time",
                         100.0 * static_cast<double>(faulty) / static_cast<double>(reports)),
             "plug the board into the computer itself, without a hub, with a short cable; the "
             "doctor looks at speed, hub and autosuspend"});
        report.unchecked =
            "the connection is unreliable: the servo stops the device whenever reports "
            "stay away for too long";
    }

    std::vector<factory::PresentDevice> present_ = factory::devices_present();
    std::uint64_t reports_before_ = 0;
    std::uint64_t faulty_before_ = 0;
};

/// Of all that a board says of itself, what a person compares with the board in front of them.
constexpr std::array<std::string_view, 9> kShown{
    "board",         "serial number",       "firmware",
    "supply",        "counts per turn",     "largest voltage",
    "current limit", "largest cancelled R", "stop switch pressed"};

class IdentityStep final : public Step {
public:
    using Step::Step;

    /// The servo pauses once for it; no motor is driven.
    void update() override {
        device::Bench *const bench = session().device().device().bench();
        if (is_asked_ || bench == nullptr || servo::lets_pass(session().latest().safety.state) ||
            session().latest().health == device::DeviceHealth::lost) {
            return;
        }
        attempt([&] { session().servo().paused([&] { facts_ = bench->facts(); }); });
        is_asked_ = true;
    }

    [[nodiscard]] StepReport report() override {
        StepReport report;
        report.to_do = "Compare with the board and the machine in front of you.";
        for (const device::Fact &fact : facts_) {
            if (std::ranges::find(kShown, fact.name) != kShown.end()) {
                report.see("{}: {}", fact.name, one_line(fact.value));
            }
        }
        const device::DeviceDescription &device = session().description();
        report.see("device file: {}, {}", device.name,
                   session().device_choice().file.filename().string());
        report.see("in use, by the lower of both: {:.4g} V, {:.4g} A, {:.4g} Ω",
                   device.motor[0].supply_V, device.motor[0].peak_current_A,
                   device.amplifier.max_cancelled_Ohm);
        const device::BoardFaults faults{session().latest().board_faults};
        if (!error().empty()) {
            report.troubles.push_back({error(), "plug the board in again, then press Again"});
        } else if (is_asked_ && faults.any()) {
            report.troubles.push_back({"the board reports " + device::names_of(faults),
                                       remedy_of(faults) + "; then press Again"});
        }
        if (is_asked_) { // counts a turn were compared when it was opened
            report.verdict = report.troubles.empty() ? Verdict::good : Verdict::bad;
        }
        return report;
    }

private:
    std::vector<device::Fact> facts_;
    bool is_asked_ = false;
};

/// From where a joint was when it was asked for, before a person is asked what they saw.
constexpr double kMoved_rad = 12.0 * kRadiansPerDegree;
constexpr double kShown_deg = 60.0;
constexpr double kRehearsed_rad = 20.0 * kRadiansPerDegree;

struct Motion {
    const char *name;
    const char *to_do;
    const char *positive; ///< the tip's way in the picture by a positive angle
    const char *negative;
};

constexpr std::array<Motion, 3> kMotions{{
    {"base (joint 1)", "Turn the base: move the tip a hand's breadth to your right.",
     "to the right", "to the left"},
    {"upper arm (joint 2)", "Lift the upper arm: move the tip a hand's breadth up.", "up", "down"},
    {"forearm (joint 3)", "Swing the forearm: pull the tip a hand's breadth towards you.",
     "towards you", "away from you"},
}};

enum class Answer : std::uint8_t { none, same, reversed, other, dead };

/// @param other  the joint that moved in the picture instead, if one did
Trouble trouble_of(std::size_t joint, Answer answer, std::optional<std::size_t> other) {
    const std::size_t number = joint + 1;
    switch (answer) {
    case Answer::reversed:
        return {fmt::format("channel {} is mirrored: its picture moves the other way", number),
                fmt::format("exchange the channels A and B of encoder {0}, or set its sign in the "
                            "board's calibration. If the self-test then says that encoder {0} is "
                            "reversed, exchange the two leads of motor {0}, too",
                            number)};
    case Answer::other:
        return other ? Trouble{fmt::format("joint {} moves in the picture instead of joint {}",
                                           *other + 1, number),
                               fmt::format("exchange the plugs of encoders {} and {}", number,
                                           *other + 1)}
                     : Trouble{
                           fmt::format("another joint than joint {} moves in the picture", number),
                           "exchange the plugs of the two encoders"};
    case Answer::dead:
        return {fmt::format("joint {} does not move in the picture: encoder {} counts nothing",
                            number, number),
                fmt::format("look at the plug and the supply of encoder {}", number)};
    case Answer::none:
    case Answer::same:
        break;
    }
    return {};
}

/// The hand turns it by this angle, and back, from where it truly is: the servo's angles may be
/// wrong.
void move_joint(session::Session &session, std::size_t joint, double angle_rad) {
    const device::PhantomGeometry &geometry = session.description().geometry;
    Vector3 from_rad;
    session.servo().paused([&] {
        from_rad = device::joint_from_motor(
            geometry, session.device().emulated()->board().phantom().truth().theta_rad);
    });
    constexpr int kParts = 12;
    constexpr double kPart_s = 0.1;
    std::vector<simulated::HandPath::Point> points;
    for (int i = 0; i <= 2 * kParts; ++i) {
        const double share = 1.0 - std::abs(static_cast<double>(i - kParts)) / kParts;
        Vector3 q_rad = from_rad;
        q_rad[static_cast<Eigen::Index>(joint)] += share * angle_rad;
        points.push_back({i * kPart_s, device::tip_position_m(geometry, q_rad)});
    }
    session.follow_path(simulated::HandPath(std::move(points)));
}

class MotionStep final : public HandStep {
public:
    explicit MotionStep(session::Session &session) : HandStep(session) { start(); }

    void update() override {
        q_rad_ = joints_rad();
        for (Eigen::Index i = 0; i < 3; ++i) {
            const double moved_rad = q_rad_[i] - from_rad_[i];
            if (std::abs(moved_rad) > std::abs(farthest_rad_[i])) {
                farthest_rad_[i] = moved_rad;
            }
        }
    }

    [[nodiscard]] StepReport report() override {
        StepReport report;
        for (std::size_t i = 0; i < kMotions.size(); ++i) {
            const double moved_deg = in_degrees(q_rad_ - from_rad_, i);
            report.bars.push_back({kMotions[i].name, moved_deg, -kShown_deg, kShown_deg,
                                   fmt::format("{:+.0f}°", std::round(moved_deg) + 0.0)}); // no −0
        }
        for (std::size_t i = 0; i < joint_; ++i) {
            report.see("{}: the picture moves as the device", kMotions[i].name);
        }
        if (joint_ == kMotions.size()) {
            report.verdict = Verdict::good;
            report.to_do = "All joints move as their picture.";
            return report;
        }
        if (answer_ != Answer::none) {
            report.verdict = Verdict::bad;
            report.to_do = "Repair what is named below, then press Again.";
            report.troubles.push_back(trouble_of(joint_, answer_, moved_instead()));
            return report;
        }
        const Motion &motion = kMotions[joint_];
        report.to_do = std::string("The device only brakes. ") + motion.to_do;
        if (has_moved()) {
            const double farthest_deg = in_degrees(farthest_rad_, joint_);
            report.see("{}: the picture moved {} by {:.0f}°. Did the device?", motion.name,
                       farthest_deg > 0.0 ? motion.positive : motion.negative,
                       std::abs(farthest_deg));
        } else if (const std::optional<std::size_t> other = moved_instead()) {
            report.see("the picture moved another joint, the {}, by {:.0f}°. Did the device?",
                       kMotions[*other].name, std::abs(in_degrees(farthest_rad_, *other)));
        }
        if (!error().empty()) {
            report.troubles.push_back({error(), "move it yourself"});
        }
        report.offers = {
            {"yes, the same way", "the picture moved as the device did", [this] { confirm(); },
             has_moved()},
            {"no, the other way", "the picture moved in the opposite direction",
             [this] { answer_ = Answer::reversed; }, has_moved()},
            {"no, another joint", "the picture moved another joint than the device",
             [this] { answer_ = Answer::other; }},
            {"nothing moves", "the device moved, but not the picture",
             [this] { answer_ = Answer::dead; }},
        };
        offer_hand(report, "its hand moves this joint, and back",
                   [this] { move_joint(session(), joint_, kRehearsed_rad); });
        return report;
    }

private:
    [[nodiscard]] Vector3 joints_rad() const {
        return device::joint_from_motor(session().description().geometry,
                                        session().latest().theta_rad);
    }
    static double in_degrees(const Vector3 &q_rad, std::size_t joint) {
        return q_rad[static_cast<Eigen::Index>(joint)] / kRadiansPerDegree;
    }
    [[nodiscard]] bool has_moved() const {
        return std::abs(farthest_rad_[static_cast<Eigen::Index>(joint_)]) >= kMoved_rad;
    }

    /// Another joint that moved while this one did not.
    [[nodiscard]] std::optional<std::size_t> moved_instead() const {
        for (std::size_t i = 0; i < kMotions.size() && !has_moved(); ++i) {
            if (i != joint_ &&
                std::abs(farthest_rad_[static_cast<Eigen::Index>(i)]) >= kMoved_rad) {
                return i;
            }
        }
        return std::nullopt;
    }

    void start() {
        q_rad_ = from_rad_ = joints_rad();
        farthest_rad_ = Vector3::Zero();
        set_error("");
    }
    void confirm() {
        ++joint_;
        start();
    }

    std::size_t joint_ = 0; ///< that is asked for; 3: none any more
    Answer answer_ = Answer::none;
    Vector3 q_rad_{Vector3::Zero()};
    Vector3 from_rad_{Vector3::Zero()};
    Vector3 farthest_rad_{Vector3::Zero()};
};

constexpr double kStill_s = 0.5;
/// 0.1 mm at the tip of a PHANTOM 1.0: less than a hand trembles.
constexpr int kStillStep_counts = 8;

class ZeroStep final : public HandStep {
public:
    explicit ZeroStep(session::Session &session)
        : HandStep(session), was_zeroed_(session.is_zeroed()) {
        note_motion();
    }

    void update() override {
        for (std::size_t i = 0; i < 3; ++i) {
            if (std::abs(session().latest().counts[i] - counts_[i]) > kStillStep_counts) {
                note_motion();
                break;
            }
        }
        still_s_ = session().latest().time_s - since_s_;
        was_zeroed_ = was_zeroed_ && session().is_zeroed();
        is_zeroed_here_ = is_zeroed_here_ && session().is_zeroed();
    }

    [[nodiscard]] StepReport report() override {
        StepReport report;
        report.shows_pose = true;
        report.voids_later = is_zeroed_here_; // the self-test checks the zero
        report.to_do = "Hold the device in its zero pose: the upper arm level and straight towards "
                       "you, the forearm hanging, square to it. Hold it still, then press \"zero "
                       "here\". Three degrees are near enough for a touch.";
        if (!is_zeroed_here_) { // which made all counts jump
            report.see("{}",
                       is_still() ? "the device is held still" : "the device moves: hold it still");
        }
        if (is_zeroed_here_) {
            report.see("zeroed; the tip is {:.1f} mm from the origin of the picture",
                       1e3 * session().latest().tip_m.norm());
        } else if (was_zeroed_) {
            report.see("it is zeroed already; the self-test checks how well");
        }
        if (!error().empty()) {
            report.troubles.push_back({error(), "hold it still, and try again"});
        }
        report.offers = {
            {"zero here", "all angles are zero from now on", [this] { zero(); }, is_still()}};
        offer_hand(report, "its hand holds the zero pose", [this] { hold_zero_pose(session()); });
        report.verdict = is_zeroed_here_ || was_zeroed_ ? Verdict::good : Verdict::open;
        return report;
    }

private:
    [[nodiscard]] bool is_still() const { return still_s_ >= kStill_s; }
    void note_motion() {
        counts_ = session().latest().counts;
        since_s_ = session().latest().time_s;
        still_s_ = 0.0;
    }
    void zero() {
        attempt([&] { session().zero_device(Vector3::Zero()); });
        is_zeroed_here_ = error().empty();
    }

    std::array<std::int32_t, 3> counts_{};
    double since_s_ = 0.0;
    double still_s_ = 0.0;
    bool was_zeroed_ = false;
    bool is_zeroed_here_ = false;
};

using simulated::HandPath;

/// Of the tip, while a person touches for the first time.
constexpr double kGentleForce_N = 1.0;
/// What counts as a touch.
constexpr double kFelt_N = 0.15;
constexpr double kFelt_s = 0.5;
// Of the simulated hand:
constexpr double kAbove_m = 0.02; ///< the scene, before and after a press
constexpr double kDepth_m = 0.004;

class TouchStep final : public HandStep {
public:
    explicit TouchStep(session::Session &session)
        : HandStep(session), last_s_(session.latest().time_s) {
        attempt([&] {
            const control::Tuning soft =
                control::read_tuning_file(asset_folder() / "tunings" / "soft.toml");
            const std::filesystem::path plate = asset_folder() / "scenes" / "plate.gltf";
            std::error_code ignored;
            if (!std::filesystem::equivalent(plate, session.scenes().now().scene.file, ignored)) {
                session.request_scene(plate);
            }
            before_ = Before{session.tuning().now(), session.servo().inputs().limits};
            servo::SafetyLimits gentle = before_->limits;
            gentle.tip_force_N = std::min(gentle.tip_force_N, kGentleForce_N);
            session.tuning().replace(soft, session.plot_time_s(), "for the first touch");
            session.servo().lower_limits(gentle);
        });
        session.keep_released(!error().empty());
    }

    void update() override {
        const servo::ServoSample &now = session().latest();
        if (presses_next_ && now.safety.state == servo::SafetyState::running &&
            !session().hand().follows_path()) {
            presses_next_ = false; // before, it would press on a device that only brakes
            attempt([&] { press_and_lift(); });
        }
        const double passed_s = std::max(0.0, now.time_s - last_s_);
        last_s_ = now.time_s;
        if (now.safety.state != servo::SafetyState::running || session().scenes().is_loading()) {
            return;
        }
        const double force_N = now.contact.touching ? now.tip_force_N.norm() : 0.0;
        peak_N_ = std::max(peak_N_, force_N);
        felt_s_ += force_N >= kFelt_N ? passed_s : 0.0;
    }

    void end() override {
        session().keep_released(true);
        if (before_) {
            session().tuning().replace(before_->tuning, session().plot_time_s(),
                                       "after the first touch");
            session().servo().lower_limits(before_->limits);
        }
    }

    [[nodiscard]] StepReport report() override {
        const servo::ServoSample &now = session().latest();
        StepReport report;
        report.to_do = to_do();
        const bool touches =
            now.contact.touching && now.safety.state == servo::SafetyState::running;
        const double force_N = touches ? now.tip_force_N.norm() : 0.0;
        report.bars.push_back(
            {"force", force_N, 0.0, kGentleForce_N, fmt::format("{:.2f} N", force_N)});
        report.see("depth {:.1f} mm, felt for {:.1f} of {:.1f} s, at most {:.2f} N",
                   touches ? 1e3 * (now.contact.x0_m - now.tip_m).norm() : 0.0,
                   std::min(felt_s_, kFelt_s), kFelt_s, peak_N_);
        report.see("tuning soft, force limited to {:.0f} N; both return to what they were "
                   "afterwards",
                   kGentleForce_N);
        if (!error().empty()) {
            report.troubles.push_back({error(), "reinstall springdrive, then press Again"});
            report.verdict = Verdict::bad;
        } else if (felt_s_ >= kFelt_s) {
            report.verdict = Verdict::good;
        }
        const auto act = [this] {
            presses_next_ = true;
            const Vector3 there_m = above_the_middle(kAbove_m);
            session().follow_path(HandPath({{0.0, there_m}, {0.5, there_m}}));
        };
        offer_hand(report, "its hand presses and lifts", act,
                   !presses_next_ && !session().scenes().is_loading());
        return report;
    }

private:
    struct Before {
        control::Tuning tuning;
        servo::SafetyLimits limits;
    };

    [[nodiscard]] Vector3 above_the_middle(double above_m) const {
        const scene::Scene &scene = session().scenes().now().scene;
        const Vector3 middle_m = 0.5 * (scene.lower_m + scene.upper_m);
        return {middle_m.x(), scene.upper_m.y() + above_m, middle_m.z()};
    }
    void press_and_lift() {
        const Vector3 above_m = above_the_middle(kAbove_m);
        const Vector3 within_m = above_the_middle(-kDepth_m);
        session().follow_path(
            HandPath({{0.0, above_m}, {1.0, within_m}, {2.5, within_m}, {3.5, above_m}}));
    }

    [[nodiscard]] std::string to_do() const {
        if (felt_s_ >= kFelt_s) {
            return "That was it: the plate gave way softly and pushed back. Press Finish.";
        }
        if (session().scenes().is_loading()) {
            return "The plate is being loaded.";
        }
        switch (session().latest().safety.state) {
        case servo::SafetyState::waiting:
            return session().latest().contact.touching
                       ? "Lift the tip off the plate, and hold it still: the motors start then."
                       : "Hold the tip still above the plate: the motors start then.";
        case servo::SafetyState::starting:
            return "The motors start.";
        default:
            return "Move down onto the plate and press gently. It should feel like a soft cushion, "
                   "without a buzz, and push straight up. If it pulls or grows by itself: F12.";
        }
    }

    std::optional<Before> before_;
    bool presses_next_ = false; ///< the simulated hand, once the motors run
    double felt_s_ = 0.0;
    double peak_N_ = 0.0;
    double last_s_ = 0.0;
};

} // namespace

MakeStep link_step() { return make_step<LinkStep>; }
MakeStep identity_step() { return make_step<IdentityStep>; }
MakeStep motion_step() { return make_step<MotionStep>; }
MakeStep zero_step() { return make_step<ZeroStep>; }
MakeStep touch_step() { return make_step<TouchStep>; }

} // namespace springdrive::app::assistant
