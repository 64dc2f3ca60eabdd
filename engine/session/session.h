// What a window, a command or a study drives: a device, the servo on it, a scene, and what is kept
// of it all. Device, servo rate and scene are exchanged one by one while the others go on.
//
//   Scenes ──► now() ──► ServoRun ──► Recording ──► touch.rec, touch-2.rec, ...
//     ▲                     │ ▲
//   SceneModels         OpenDevice ──► SimulatedWorld ◄── GuidedHand
//
// The parts know nothing of each other; what concerns several of them is here.
#pragma once

#include "device/factory/device_factory.h"
#include "engine/session/guided_hand.h"
#include "engine/session/recording.h"
#include "engine/session/remarks.h"
#include "engine/session/scene_models.h"
#include "engine/session/scenes.h"
#include "engine/session/servo_run.h"
#include "engine/session/session_options.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace springdrive::session {

/// Everything is called from one thread; servo and recorder have their own.
class Session {
public:
    /// Loads everything and starts nothing.
    /// @param progress  told how far the scene is, if somebody wants to know
    /// @throw InputError for what cannot be used
    explicit Session(const SessionOptions &options, scene::LoadProgress *progress = nullptr);
    ~Session();
    Session(const Session &) = delete;
    Session &operator=(const Session &) = delete;

    /// Starts the servo's thread, unless in lockstep, and the record that was asked for. What the
    /// system refused is remarked. @param on_thread  see ServoThread
    /// @throw InputError for a record that cannot be made.
    void start(const std::function<void()> &on_thread = {});

    /// Moves on by one frame: gives the servo a sign of life, in lockstep ticks it, takes in its
    /// samples, a scene that finished loading, and a device that can be exchanged.
    void advance(double frame_s);

    /// Stops the servo; the safe state is sent last. Takes in the last samples, ends the record.
    void stop();

    /// Loads in the background. Where models are chosen automatically, the scene gets its own
    /// before it is shown, which may take as long as measuring does.
    void request_scene(const std::filesystem::path &file);

    /// As if started with --model auto: the scene is loaded again, with its model.
    void choose_models();

    /// Finds in the background which model the scene would get with the gains in force.
    /// @param fresh  even if it is remembered from before
    void measure_model(bool fresh = false);

    /// Records every tick from now on. @throw InputError for a file that cannot be made.
    void start_recording(const std::filesystem::path &file);

    /// Another rate from the next tick on; the record goes on in the same file.
    /// @throw InputError for one that servo or device cannot keep; the old one stays then
    void set_servo_rate(double servo_hz);

    /// Opens the other device at once. Then lets the force of the present one fade, closes it, and
    /// begins on the other as at a start: it waits for rest in free space. Takes a second or so of
    /// `advance`; until then all goes on. A record goes on in a further file.
    /// @throw InputError where the other one cannot be opened, or an assertion failed in a tick:
    ///        then nothing changes
    void exchange_device(const DeviceChoice &choice);
    [[nodiscard]] bool is_exchanging() const { return next_device_ != nullptr; }

    /// Takes hold again of a device that was lost. What tripped stays tripped until a reset.
    /// @param theta_rad  where its rotors stand; without, where they were last known to be
    /// @throw InputError where it cannot be found
    void reconnect_device(const std::optional<Vector3> &theta_rad = std::nullopt);

    [[nodiscard]] ServoRun &servo() { return *servo_; }
    [[nodiscard]] const ServoRun &servo() const { return *servo_; }
    [[nodiscard]] const servo::ServoSample &latest() const { return servo_->latest(); }
    [[nodiscard]] const Scenes &scenes() const { return *scenes_; }
    [[nodiscard]] SceneModels &models() { return *models_; }
    [[nodiscard]] const SceneModels &models() const { return *models_; }
    [[nodiscard]] Recording &recording() { return *recording_; }
    [[nodiscard]] const Recording &recording() const { return *recording_; }
    [[nodiscard]] GuidedHand &hand() { return hand_; }
    [[nodiscard]] const GuidedHand &hand() const { return hand_; }
    [[nodiscard]] factory::OpenDevice &device() { return *device_; }
    [[nodiscard]] const factory::OpenDevice &device() const { return *device_; }
    [[nodiscard]] const device::DeviceDescription &description() const {
        return device_->device().description();
    }
    /// What a simulated device is told to simulate, and the hand's path.
    [[nodiscard]] const simulated::SimulationOptions &simulation() const { return simulation_; }
    [[nodiscard]] Remarks &remarks() { return remarks_; }
    [[nodiscard]] const Remarks &remarks() const { return remarks_; }

private:
    struct Prepared; ///< a device, opened and with all that it takes to begin on it

    [[nodiscard]] Prepared prepare(const DeviceChoice &choice, const std::string &text,
                                   control::Tuning &tuning) const;
    void show(const LoadedScene &before);
    void choose_again();
    void go_on_with_exchange();
    void prepare_again();
    void begin_on(Prepared next);
    void note_standstill();
    void note_failed_assertion();
    [[nodiscard]] ModelGround ground(const std::string &device_text,
                                     const device::DeviceDescription &device,
                                     double servo_hz) const;
    [[nodiscard]] record::RecordHeader header_of_record() const;

    SessionOptions options_;
    std::unique_ptr<Scenes> scenes_; ///< whose surfaces the servo touches
    std::unique_ptr<SceneModels> models_;
    simulated::SimulationOptions simulation_;
    std::unique_ptr<factory::OpenDevice> device_;
    std::unique_ptr<ServoRun> servo_;
    std::unique_ptr<Recording> recording_;
    std::unique_ptr<Prepared> next_device_;
    GuidedHand hand_;
    bool has_started_ = false;
    bool told_of_standstill_ = false;
    bool told_of_failure_ = false; ///< of an assertion
    std::function<void()> on_thread_;
    Remarks remarks_;
};

} // namespace springdrive::session
