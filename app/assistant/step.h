// A step of the assistant: what it asks for, what it saw, and whether one may go on. Steps know
// nothing of the window, which shows them all alike.
//
//   made ──► update, once a frame ──► end
//     ▲          │
//     └─ again ──┘
#pragma once

#include "base/input_error.h"
#include "base/vector.h"
#include "engine/commissioning/calibration_run.h"
#include "engine/servo/safety_status.h"
#include "engine/session/session.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace springdrive::app::assistant {

enum class StepName : std::uint8_t {
    link,
    identity,
    motion,
    zeroing,
    self_test,
    calibration,
    touch,
};
inline constexpr std::size_t kSteps = 7;

struct StepTitle {
    std::string_view name; ///< in files
    const char *title = "";
};

/// Indexed by StepName.
inline constexpr std::array<StepTitle, kSteps> kStepTitles{{
    {"link", "Connection"},
    {"identity", "Identity"},
    {"motion", "Free motion"},
    {"zeroing", "Zeroing"},
    {"self_test", "Self-test"},
    {"calibration", "Calibration"},
    {"touch", "First touch"},
}};

[[nodiscard]] constexpr std::size_t index_of(StepName step) {
    return static_cast<std::size_t>(step);
}

enum class Verdict : std::uint8_t {
    open, ///< there is more to do or to see
    good,
    skipped,  ///< nothing was done, which is said
    doubtful, ///< may be passed all the same
    bad,      ///< must not be passed
};

struct Trouble {
    std::string what;   ///< with the figures that show it
    std::string remedy; ///< what to do
};

/// A value with its range, as a bar.
struct Bar {
    std::string label;
    double value = 0.0;
    double minimum = 0.0;
    double maximum = 1.0;
    std::string text;
};

/// Something that a person can choose, as a button.
struct Offer {
    std::string label;
    std::string explanation;
    std::function<void()> choose; ///< as long as the step lives
    bool is_enabled = true;
};

struct StepReport {
    Verdict verdict = Verdict::open;
    std::string to_do;
    std::vector<Bar> bars;
    std::vector<std::string> seen;
    std::vector<Trouble> troubles;
    std::vector<Offer> offers;
    std::string unchecked;    ///< of a doubtful one: what is then not known
    std::string asks_doctor;  ///< a device as --device names it, of which the doctor knows more
    bool voids_later = false; ///< what later steps found out holds no more
    bool shows_pose = false;  ///< the zero pose
    /// The rotors' angles for the picture, where the servo does not measure them.
    std::optional<Vector3> theta_rad;

    /// Adds a line to `seen`.
    template <typename... Values> void see(fmt::format_string<Values...> text, Values &&...values) {
        seen.push_back(fmt::format(text, std::forward<Values>(values)...));
    }
};

/// Made when it is entered, and anew when it is done again; the device is then released.
class Step {
public:
    /// @param session  outlives the step
    explicit Step(session::Session &session) : session_(&session) {}
    Step(const Step &) = delete;
    Step &operator=(const Step &) = delete;
    virtual ~Step() = default;

    /// Once a frame while it is the present one, the first time when it was made.
    virtual void update() {}
    /// It is left: what it has changed for itself is as before.
    virtual void end() {}
    [[nodiscard]] virtual StepReport report() = 0;

protected:
    [[nodiscard]] session::Session &session() const { return *session_; }
    [[nodiscard]] bool is_emulated() const { return session_->device().emulated() != nullptr; }

    /// Why the last attempt failed; else empty.
    [[nodiscard]] const std::string &error() const { return error_; }
    /// @param act  may throw InputError
    template <typename Act> void attempt(Act &&act) { error_ = error_text_of(act); }
    void set_error(std::string error) { error_ = std::move(error); }

private:
    session::Session *session_;
    std::string error_;
};

using MakeStep = std::function<std::unique_ptr<Step>(session::Session &)>;

/// Of type `Made`.
template <typename Made> std::unique_ptr<Step> make_step(session::Session &session) {
    return std::make_unique<Made>(session);
}

/// Holds an emulated device in its zero pose. @throw InputError as Session::follow_path does
inline void hold_zero_pose(session::Session &session) {
    session.follow_path(simulated::HandPath({{0.0, Vector3::Zero()}}));
}

/// Which device, its connection, and what it loses.
[[nodiscard]] MakeStep link_step();
/// What the board says of itself, and whether the device file fits.
[[nodiscard]] MakeStep identity_step();
/// Each joint by hand, with the picture following.
[[nodiscard]] MakeStep motion_step();
/// Zeroing in the zero pose.
[[nodiscard]] MakeStep zero_step();
/// commissioning::SelfTest.
[[nodiscard]] MakeStep self_test_step();
/// commissioning::CalibrationRun; each step that is made knows what the last one found out.
[[nodiscard]] MakeStep calibration_step();
/// A soft touch within lowered limits.
[[nodiscard]] MakeStep touch_step();

// What stops a device, and what its self-test and calibration found: in words, with what to do
// about it and what it means for a first touch.

/// Of the gravest of them.
[[nodiscard]] std::string remedy_of(device::BoardFaults faults);

/// What has to be done before the stop is reset.
[[nodiscard]] std::string remedy_of(const servo::SafetyStatus &stop);

/// What is not known of a device that is driven all the same, however softly. Empty if it must not
/// be: the force could have another direction, another sign, or another size than the servo takes
/// it to have.
[[nodiscard]] std::string unchecked_by(commissioning::Problem problem);

/// Adds a line for each motor, and what the numbers do not say.
/// @param device  with the numbers of its file
void describe(const device::Calibration &calibration, const device::DeviceDescription &device,
              StepReport &report);

/// Adds what R̂ may be by it, of the motor that is worst.
void describe_dR(const commissioning::CalibrationReport &found, StepReport &report);

/// Of a calibration that came to nothing, the verdict and the trouble. What self-test and
/// calibration do not agree on must not be passed; what was only not found out may be.
void judge(const commissioning::CalibrationReport &found, StepReport &report);

} // namespace springdrive::app::assistant
