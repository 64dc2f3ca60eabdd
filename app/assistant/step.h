// A step of the assistant: what it asks for, what it saw, and whether one may go on. Steps know
// nothing of the window, which shows them all alike.
//
//   begin ──► update, once a frame ──► end
//     ▲          │
//     └─ again ──┘
#pragma once

#include "base/vector.h"
#include "engine/session/session.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
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
};

/// Something that a person can choose, as a button.
struct Offer {
    std::string label;
    std::string explanation;
    std::function<void()> choose;
    bool is_enabled = true;
};

class Step {
public:
    Step() = default;
    Step(const Step &) = delete;
    Step &operator=(const Step &) = delete;
    virtual ~Step() = default;

    /// It is entered, or done again. The device is released.
    virtual void begin(session::Session &session) = 0;
    /// Once a frame while it is the present one.
    virtual void update(session::Session &session) = 0;
    /// It is left: what it has changed for itself is as before.
    virtual void end(session::Session & /*session*/) {}

    [[nodiscard]] virtual StepReport report(const session::Session &session) const = 0;
    /// @param session  and the step must outlive what is returned
    [[nodiscard]] virtual std::vector<Offer> offers(session::Session & /*session*/) { return {}; }

    /// The rotors' angles for the picture, where the servo does not measure them.
    [[nodiscard]] virtual std::optional<Vector3> theta_rad() const { return std::nullopt; }
};

} // namespace springdrive::app::assistant
