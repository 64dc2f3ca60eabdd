// The assistant at a device's first connection: a sequence of steps, of which each device goes
// through all once. It can be left, and is resumed at the first step that is not done.
//
//   closed ──open──► step 1 ──next──► step 2 … step 7 ──next──► closed, all done
//      ▲               │ ▲──back───────│
//      └────leave──────┘
//
// While it is open, the device is released and only brakes, but for the first touch. It stays so
// after it was left at a finding with which the device must not be driven. How far each device has
// come is kept in a TOML file for each:
//
//   done = ["link"]
//   failed = ["identity"]
#pragma once

#include "app/assistant/step.h"

#include <array>
#include <bitset>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app::assistant {

using StepSet = std::bitset<kSteps>;

struct Progress {
    StepSet done;
    StepSet failed; ///< at which the device must not be driven
    bool operator==(const Progress &other) const = default;
};

/// $XDG_STATE_HOME/springdrive/assistant, or ~/.local/state/springdrive/assistant; empty where
/// neither is known.
[[nodiscard]] std::filesystem::path progress_folder();

/// A file name for a device of this kind and serial number, whatever letters that has.
[[nodiscard]] std::string progress_name(const std::string &kind, const std::string &serial);

/// Nothing is done if there is no such file.
/// @throw InputError with file, line and what is wrong with it
[[nodiscard]] Progress read_progress(const std::filesystem::path &file);

/// Makes the folder, too. @throw InputError if it cannot be written
void write_progress(const std::filesystem::path &file, const Progress &progress);

enum class StepState : std::uint8_t { open, present, done, failed };

class Assistant {
public:
    using Steps = std::array<MakeStep, kSteps>;

    /// @param folder  of progress files; empty: nothing is kept
    explicit Assistant(std::filesystem::path folder);
    /// With other steps, for tests.
    Assistant(std::filesystem::path folder, Steps steps);

    /// Once a frame. Opens for a device that is not the plain simulation, when it is seen for the
    /// first time and has not come through all steps yet.
    void update(session::Session &session);
    /// Whether it opens by itself.
    bool opens_itself = true;

    /// At the first step that is not done, or at the first one.
    void open(session::Session &session);
    [[nodiscard]] bool is_open() const { return step_ != nullptr; }

    // What a person asks for, while it is open:

    void next(session::Session &session); ///< if `can_go_on`
    void back(session::Session &session);
    /// The present step from its beginning. Resets a stop.
    void again(session::Session &session);
    /// To a step that is done, or the first that is not.
    void go_to(session::Session &session, StepName step);
    void leave(session::Session &session);
    /// Of a doubtful step: marks it as done.
    void continue_all_the_same(session::Session &session);

    [[nodiscard]] StepName present() const { return present_; }
    [[nodiscard]] StepState state(StepName step) const;
    /// Also of the present one.
    [[nodiscard]] bool has_failed(StepName step) const {
        return progress_.failed.test(index_of(step));
    }
    [[nodiscard]] bool can_go_to(StepName step) const;
    [[nodiscard]] bool is_complete() const { return progress_.done.all(); }

    // Of the present step, while it is open:

    [[nodiscard]] bool can_go_on(const session::Session &session) const;
    /// With what stops the device.
    [[nodiscard]] StepReport report(const session::Session &session) const;

    /// See StepReport; none while it is closed.
    [[nodiscard]] std::optional<Vector3> theta_rad() const;

    /// Why the progress could not be read or kept; else empty.
    [[nodiscard]] const std::string &error() const { return error_; }
    /// With which the device is held braking after the assistant was left; else empty.
    [[nodiscard]] const std::string &holds_back() const { return holds_back_; }

private:
    void watch_device(session::Session &session);
    void watch_zero(const session::Session &session);
    void enter(session::Session &session, StepName to);
    void note_verdict();
    void set_done(StepName step);
    void void_from(std::size_t step);
    void keep(const Progress &before);
    void hold_back_or_not(session::Session &session);
    [[nodiscard]] StepName first_not_done() const;
    [[nodiscard]] std::filesystem::path file() const;

    std::filesystem::path folder_;
    Steps steps_;
    std::unique_ptr<Step> step_; ///< the present one; null while it is closed
    StepName present_ = StepName::link;
    Progress progress_;
    std::string device_; ///< whose progress it is; empty: the plain simulation
    bool is_device_new_ = false;
    std::string error_;
    std::string holds_back_;
};

} // namespace springdrive::app::assistant

namespace springdrive::app {

class DoctorPopup;
struct Rectangle;

/// The assistant in the window: its steps on the left, the present one on the right.
void draw_assistant_panel(session::Session &session, assistant::Assistant &assistant,
                          DoctorPopup &doctor, const Rectangle &place);

/// A button that opens it, and why it holds the device.
void offer_assistant(session::Session &session, assistant::Assistant &assistant);

} // namespace springdrive::app
