#include "app/assistant/rehearsal.h"
#include "app/assistant/step.h"
#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"

#include <cmath>

namespace springdrive::app::assistant {

namespace {

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

class MotionStep final : public Step {
public:
    explicit MotionStep(session::Session &session) : Step(session) { start(); }

    void update() override {
        q_rad_ = joints_rad();
        for (Eigen::Index i = 0; i < 3; ++i) {
            const double moved_rad = q_rad_[i] - from_rad_[i];
            if (std::abs(moved_rad) > std::abs(farthest_rad_[i])) {
                farthest_rad_[i] = moved_rad;
            }
        }
    }

    [[nodiscard]] StepReport report() const override {
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
            report.to_do = "Mend what is named below, then press Again.";
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
        if (!error_.empty()) {
            report.troubles.push_back({error_, "move it yourself"});
        }
        return report;
    }

    [[nodiscard]] std::vector<Offer> offers() override {
        if (joint_ == kMotions.size() || answer_ != Answer::none) {
            return {};
        }
        std::vector<Offer> offers{
            {"yes, the same way", "the picture moved as the device did", [this] { confirm(); },
             has_moved()},
            {"no, the other way", "the picture moved in the opposite direction",
             [this] { answer_ = Answer::reversed; }, has_moved()},
            {"no, another joint", "the picture moved another joint than the device",
             [this] { answer_ = Answer::other; }},
            {"nothing moves", "the device moved, but not the picture",
             [this] { answer_ = Answer::dead; }},
        };
        offer_hand(
            session(), "its hand moves this joint, and back",
            [this] { move_joint(session(), joint_, kRehearsed_rad); }, error_, offers);
        return offers;
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
        error_.clear();
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
    std::string error_;
};

} // namespace

std::unique_ptr<Step> make_motion_step(session::Session &session) {
    return std::make_unique<MotionStep>(session);
}

} // namespace springdrive::app::assistant
