// A step of the assistant: what it asks for, what it saw, and whether one may go on. Steps know
// nothing of the window, which shows them all alike.
//
//   made ──► update, once a frame ──► end
//     ▲          │
//     └─ again ──┘
#pragma once

#include "base/vector.h"
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

struct StepReport {
    Verdict verdict = Verdict::open;
    std::string to_do;
    std::vector<Bar> bars;
    std::vector<std::string> seen;
    std::vector<Trouble> troubles;
    std::string unchecked;    ///< of a doubtful one: what is then not known
    std::string asks_doctor;  ///< a device as --device names it, of which the doctor knows more
    bool voids_later = false; ///< what later steps found out holds no more
    bool shows_pose = false;  ///< the zero pose

    /// Adds a line to `seen`.
    template <typename... Values> void see(fmt::format_string<Values...> text, Values &&...values) {
        seen.push_back(fmt::format(text, std::forward<Values>(values)...));
    }
};

/// Something that a person can choose, as a button.
struct Offer {
    std::string label;
    std::string explanation;
    std::function<void()> choose;
    bool is_enabled = true;
};

/// Made when it is entered, and anew when it is done again; the device is then released.
class Step {
public:
    /// @param session  outlives the step and its offers
    explicit Step(session::Session &session) : session_(&session) {}
    Step(const Step &) = delete;
    Step &operator=(const Step &) = delete;
    virtual ~Step() = default;

    /// Once a frame while it is the present one, the first time when it was made.
    virtual void update() {}
    /// It is left: what it has changed for itself is as before.
    virtual void end() {}

    [[nodiscard]] virtual StepReport report() const = 0;
    /// The step must outlive what is returned.
    [[nodiscard]] virtual std::vector<Offer> offers() { return {}; }

    /// The rotors' angles for the picture, where the servo does not measure them.
    [[nodiscard]] virtual std::optional<Vector3> theta_rad() const { return std::nullopt; }

protected:
    [[nodiscard]] session::Session &session() const { return *session_; }

private:
    session::Session *session_;
};

using MakeStep = std::function<std::unique_ptr<Step>(session::Session &)>;

/// Which device, its connection, and what it loses.
[[nodiscard]] std::unique_ptr<Step> make_link_step(session::Session &session);
/// What the board says of itself, and whether the device file fits.
[[nodiscard]] std::unique_ptr<Step> make_identity_step(session::Session &session);
/// Each joint by hand, with the picture following.
[[nodiscard]] std::unique_ptr<Step> make_motion_step(session::Session &session);
/// Zeroing in the zero pose.
[[nodiscard]] std::unique_ptr<Step> make_zero_step(session::Session &session);
/// commissioning::SelfTest.
[[nodiscard]] std::unique_ptr<Step> make_self_test_step(session::Session &session);
/// commissioning::CalibrationRun; each step that is made knows what the last one found out.
[[nodiscard]] MakeStep calibration_steps();
/// A soft touch within lowered limits.
[[nodiscard]] std::unique_ptr<Step> make_touch_step(session::Session &session);

} // namespace springdrive::app::assistant
