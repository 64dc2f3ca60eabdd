// A session, driven by a window, a command or a study: a device, its servo, a scene, and the
// recording. Device, servo rate and scene can each be changed while the rest continues.
//
//   Scenes ──► now() ──► ServoRun ──► Recording ──► touch.rec, touch-2.rec, ...
//     ▲                     │ ▲
//   SceneModels         OpenDevice ──► SimulatedWorld ◄── SimulatedHand
//
// The parts are independent of each other; what concerns several of them is here.
#pragma once

#include "base/new_file.h"
#include "device/core/device_description.h"
#include "device/factory/device_factory.h"
#include "device/simulated/hand.h"
#include "device/simulated/simulation_options.h"
#include "engine/control/tuning.h"
#include "engine/session/loaded_scene.h"
#include "engine/session/record.h"
#include "engine/session/servo_run.h"
#include "engine/session/telemetry_history.h"
#include "engine/session/tuning_history.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::session {

/// The choice of a device, and the file that describes it.
struct DeviceChoice {
    std::filesystem::path file;
    factory::DeviceKind kind = factory::DeviceKind::simulated;
    std::string serial; ///< empty: the only one of its kind
};

/// Of a session with or without a window.
struct SessionOptions {
    std::filesystem::path scene;
    std::string gltf_scene; ///< of that file, as of `load_gltf`
    DeviceChoice device;
    control::Tuning tuning;
    double servo_hz = 1000.0;
    bool starts_at_zero = false; ///< a device that must be zeroed is in its zero pose at the start
    double delay_periods = 0.0;  ///< of simulated devices; of others, it is measured
    simulated::PlantEffects effects;     ///< of simulated and emulated devices
    std::uint64_t device_seed = 0;       ///< see SimulationOptions
    factory::EmulationOptions emulation; ///< of emulated devices
    bool observes_resistance = true;     ///< R̂ follows the windings' resistances, see `Session`
    ModelOptions model;
    std::filesystem::path path; ///< of the hand; empty: see `plays_script`
    bool plays_script = false; ///< without a path: the scripted touch, not `SimulatedHand::move_to`
    /// Bound on the telemetry that is kept for plots and past records.
    std::size_t history_bytes = TelemetryHistory::kMaxBytes;
    bool lockstep = false;  ///< the servo is timed by `Session::advance`, not by a clock
    std::optional<int> cpu; ///< the processor of the servo's thread
    std::optional<double> late_limit_s; ///< of consecutive missed deadlines; lowers the device's
    std::filesystem::path record;       ///< empty: nothing is recorded until requested
    Existing existing_record = Existing::keep;
    /// Where the windings' temperatures are kept for the next start, see windings_file; empty:
    /// nowhere.
    std::filesystem::path windings_folder;
    std::string program_version; ///< for records, and for cached model choices
};

/// Warnings for the user, each one once.
class Warnings {
public:
    /// One line, with a remedy after a semicolon. Ignored if it was added before.
    void add(const std::string &text) {
        if (std::ranges::find(all_, text) == all_.end()) {
            all_.push_back(text);
        }
    }

    [[nodiscard]] const std::vector<std::string> &all() const { return all_; }

    /// The warnings not yet taken, for printing.
    [[nodiscard]] std::vector<std::string> take_new() {
        const auto first = all_.begin() + static_cast<std::ptrdiff_t>(taken_);
        taken_ = all_.size();
        return {first, all_.end()};
    }

private:
    std::vector<std::string> all_;
    std::size_t taken_ = 0;
};

/// The hand that holds a simulated or emulated device: its target, by a path or by request.
class SimulatedHand {
public:
    /// Attaches the hand to a device's tip, which is at the path's start, or else at `target_m`.
    /// @param hand  must outlive this object; null for a real hand, which cannot be moved
    void take_hold(simulated::HandControl *hand, const device::DeviceDescription &device,
                   const std::optional<simulated::HandPath> &path, const Vector3 &target_m);

    /// Sets the target, limited to workspace and reach; takes effect once the path has ended.
    void move_to(const Vector3 &target_m);

    /// Starts a test signal beside the target; needs a simulated hand.
    void play(simulated::HandStimulus stimulus);
    [[nodiscard]] bool is_simulated() const { return hand_ != nullptr; }

    /// Notes that the device's hand follows this path, which began at this servo time.
    void follow(const simulated::HandPath &path, double began_s);

    /// Sets the target to that of the path at this servo time, up to the path's end: from then on
    /// the hand holds still until it is moved.
    void advance(double time_s);

    [[nodiscard]] const Vector3 &target_m() const { return target_m_; }
    [[nodiscard]] bool follows_path() const { return path_.has_value(); }

private:
    simulated::HandControl *hand_ = nullptr;
    device::PhantomGeometry geometry_;
    device::Workspace workspace_;
    std::optional<simulated::HandPath> path_;
    double path_began_s_ = 0.0;
    Vector3 target_m_{Vector3::Zero()};
    std::uint32_t stimuli_ = 0; ///< played so far
};

/// For use by one thread; servo and recorder have their own.
class Session {
public:
    /// Loads everything without starting anything.
    /// @param progress  reports the progress of loading the scene; may be null
    /// @throw InputError for unusable options or files
    explicit Session(const SessionOptions &options, scene::LoadProgress *progress = nullptr);
    ~Session();
    Session(const Session &) = delete;
    Session &operator=(const Session &) = delete;

    /// Starts the servo's thread, unless in lockstep, and the recording, if requested. Adds a
    /// warning for what the system refused. @param on_thread  see ServoThread
    /// @throw InputError if the record cannot be created.
    void start(const std::function<void()> &on_thread = {});

    /// Advances by one frame: sends the servo's heartbeat, runs its ticks in lockstep, fetches
    /// samples and a loaded scene, and continues an exchange of the device.
    void advance(double frame_s);

    /// Stops the servo; the safe state is sent last. Fetches the last samples, ends the record.
    void stop();

    /// Loads a scene in the background. If models are chosen automatically, the scene's model is
    /// chosen before it is shown, which may take as long as a measurement.
    void request_scene(const std::filesystem::path &file);

    /// Switches to --model auto: loads the scene again, with its model.
    void choose_models();

    /// Finds in the background which model the scene would get with the active gains.
    /// @param fresh  measures even if a choice is cached
    void measure_model(bool fresh = false);

    /// Records every tick from now on. @throw InputError if the file cannot be created.
    void start_recording(const std::filesystem::path &file, FilePolicy policy = Existing::keep);

    /// What recordings would hold of the ticks that are still in memory: one for each device on
    /// which they ran, the present one last.
    [[nodiscard]] std::vector<Record> past() const;

    /// Whether R̂ follows the windings' resistances. They are observed by currents that inductances
    /// smooth: a simulation without inductance (--model auto may choose one) is not observed.
    void observe_resistance(bool on);
    [[nodiscard]] bool wants_resistance_observed() const { return options_.observes_resistance; }

    /// Changes the rate from the next tick on; the record continues in the same file.
    /// @throw InputError for a rate that servo or device do not support; it is then unchanged
    void set_servo_rate(double servo_hz);

    // Of a simulated device, from now on; noted in the record. The hand and its paths also of an
    // emulated one.

    /// @param delay_periods  d, see SimulationOptions
    /// @throw InputError if it is out of range, or the device is none; nothing is then changed
    void set_delay(double delay_periods);
    /// @throw InputError for effects that the simulated dynamics exclude, or if the device is none;
    ///        or the model chooses them (--model auto); nothing is then changed. Effects that
    ///        change what the device reports of itself, its tolerances, take an exchange of the
    ///        device.
    void set_effects(const simulated::PlantEffects &effects);
    /// @throw InputError if the hand is a real one, or its parameters are out of range
    void set_hand(const device::HandParameters &hand);
    /// The hand moves to the path's start, evenly, and then follows it.
    /// @throw InputError if the hand is a real one, or cannot reach all of it
    void follow_path(const simulated::HandPath &path);
    /// The hand stops where it is on its path.
    void leave_path();
    /// The same with the scripted touch of the shown scene.
    void follow_script();

    /// Opens the new device immediately. Then ramps down the force of the current one, closes it,
    /// and starts on the new one as usual, waiting for rest in free space. This takes about a
    /// second of `advance`, during which everything continues. A record continues in a new file.
    /// @throw InputError if the new device cannot be opened, or an assertion failed in a tick;
    ///        nothing is then changed
    void exchange_device(const DeviceChoice &choice);
    [[nodiscard]] bool is_exchanging() const { return next_device_ != nullptr; }

    /// Connects again to a device that was lost. A trip stays until it is reset. A device that is
    /// no simulation, and lost its counts, must be zeroed; one on USB that is lost is connected
    /// again by `advance` as soon as it is there.
    /// @param theta_rad  the rotors' angles; by default those last known of a simulated device
    /// @throw InputError if it cannot be found
    void reconnect_device(const std::optional<Vector3> &theta_rad = std::nullopt);

    /// Makes a board's calibration part of its description, and starts on it as if it had been
    /// opened with it: what was observed of the windings before is forgotten. A record continues in
    /// a new file. The device must be released, as after an exclusive use.
    /// @throw InputError while a motor is driven, or the device is stopped, exchanged or in
    ///        exclusive use; if the calibration is another device's, or impossible; nothing is then
    ///        changed
    void use_calibration(const device::Calibration &calibration);

    // The device for somebody else, such as its self-test or calibration:

    /// Has the device released; once no motor is driven, the servo pauses, and `tick` alone uses
    /// the device, once a period, on a thread of its own (in lockstep: within `advance`). It ends
    /// when `tick` says that there is no more to do or throws, by `end_exclusive_use`, or by an
    /// emergency stop; then the servo goes on, waiting for rest in free space.
    /// @param tick  returns whether there is more to do
    /// @throw InputError while the device is stopped, exchanged, lost or in exclusive use already
    void begin_exclusive_use(std::function<bool()> tick);
    /// Stops the motors until a person lets them go on, and ends an exclusive use.
    void emergency_stop();

    /// Ends the exclusive use now; may be called without one.
    void end_exclusive_use();
    /// From the request on, until the servo goes on.
    [[nodiscard]] bool is_in_exclusive_use() const { return exclusive_use_ != nullptr; }
    /// Why `tick` threw, of the last exclusive use; else empty.
    [[nodiscard]] const std::string &exclusive_use_error() const { return exclusive_use_error_; }

    /// While asked for, the device only brakes, whatever else would start it.
    void keep_released(bool requested);
    [[nodiscard]] bool is_kept_released() const { return is_kept_released_; }

    /// Until the device is zeroed, no motor is driven; and again from the tick on in which an
    /// encoder failed or jumped, joints were beyond their stops, or the board had restarted.
    [[nodiscard]] bool is_zeroed() const;
    /// Declares the rotors' angles now. @throw InputError if the device does not accept them
    void zero_device(const Vector3 &theta_rad);

    /// The tuning, which has no other owner: what becomes active there, the servo gets.
    [[nodiscard]] TuningHistory &tuning() { return *tuning_; }
    [[nodiscard]] const TuningHistory &tuning() const { return *tuning_; }
    /// Of the latest sample, by the time of plots, which goes on with another device.
    [[nodiscard]] double plot_time_s() const;

    [[nodiscard]] ServoRun &servo() { return *servo_; }
    [[nodiscard]] const ServoRun &servo() const { return *servo_; }
    [[nodiscard]] const servo::ServoSample &latest() const { return servo_->latest(); }
    [[nodiscard]] const Scenes &scenes() const { return *scenes_; }
    [[nodiscard]] SceneModels &models() { return *models_; }
    [[nodiscard]] const SceneModels &models() const { return *models_; }
    [[nodiscard]] Recording &recording() { return *recording_; }
    [[nodiscard]] const Recording &recording() const { return *recording_; }
    [[nodiscard]] SimulatedHand &hand() { return hand_; }
    [[nodiscard]] const SimulatedHand &hand() const { return hand_; }
    [[nodiscard]] factory::OpenDevice &device() { return *device_; }
    [[nodiscard]] const factory::OpenDevice &device() const { return *device_; }
    [[nodiscard]] const device::DeviceDescription &description() const {
        return device_->device().description();
    }
    [[nodiscard]] const DeviceChoice &device_choice() const { return options_.device; }
    /// The options of the simulated device, including the hand's path from the start.
    [[nodiscard]] const simulated::SimulationOptions &simulation() const { return simulation_; }
    [[nodiscard]] const std::string &program_version() const { return options_.program_version; }
    [[nodiscard]] Warnings &warnings() { return warnings_; }
    [[nodiscard]] const Warnings &warnings() const { return warnings_; }

private:
    struct Prepared;    ///< an opened device with all that is needed to start on it
    class ExclusiveUse; ///< of the device

    [[nodiscard]] Prepared prepare(const DeviceChoice &choice, const std::string &text,
                                   control::Tuning &tuning) const;
    void show(const LoadedScene &before);
    [[nodiscard]] simulated::SimulatedWorld &world();
    [[nodiscard]] simulated::HandControl &hand_control();
    void move_emulated();
    void require_no_exclusive_use() const;
    void require_free() const; ///< neither in exclusive use nor exchanged
    void require_not_stopped() const;
    void end_pulses();
    void go_on_with_exclusive_use(double frame_s);
    void simulate_as(const simulated::SimulationOptions &simulation);
    void start_again_with(const simulated::PlantEffects &effects);
    void begin_path(const simulated::HandPath &path, const char *what);
    void observe_as_requested();
    void choose_again();
    void measure_anew();
    void renew_exchange();
    void go_on_with_exchange();
    void prepare_again();
    void begin_on(Prepared next);
    void start_anew(const std::string &text, const device::DeviceDescription &description,
                    double speed, const char *why);
    void note_stall();
    void note_failed_assertion();
    void start_servo();
    void release_until_zeroed();
    void start_watching_windings();
    void keep_windings() const;
    void watch_zero();
    void watch_link();
    void adopt_delay();
    [[nodiscard]] ModelGround ground(const std::string &device_text,
                                     const device::DeviceDescription &device,
                                     double servo_hz) const;
    [[nodiscard]] record::RecordHeader header_of_record() const;
    void note(std::string json);
    void begin_past();
    [[nodiscard]] RunDevice device_of_run() const;
    void forget_old_past();

    SessionOptions options_;
    std::unique_ptr<Scenes> scenes_; ///< declared before `servo_`, which uses their surfaces
    std::unique_ptr<SceneModels> models_;
    simulated::SimulationOptions simulation_;
    std::unique_ptr<factory::OpenDevice> device_;
    std::unique_ptr<ServoRun> servo_;
    std::unique_ptr<TuningHistory> tuning_;
    std::unique_ptr<Recording> recording_;
    std::unique_ptr<Prepared> next_device_;
    std::deque<Record> past_; ///< of each device with ticks in memory, without their store
    SimulatedHand hand_;
    bool has_started_ = false;
    bool reported_stall_ = false;
    bool reported_failure_ = false; ///< of a failed assertion
    bool is_kept_released_ = false;
    bool knows_zero_ = false;       ///< of the device, when it was released or not last
    double released_until_s_ = 0.0; ///< after a zeroing, by the servo's time; 0: no more
    double next_look_s_ = 0.0;      ///< at the link, by the servo's time
    int reconnections_ = 0;         ///< by `advance`
    std::function<void()> on_thread_;
    Warnings warnings_;
    std::string exclusive_use_error_;
    std::shared_ptr<ExclusiveUse> exclusive_use_; ///< ends first; its type is not known here
};

// Report on a completed run: the servo's timing, whether it was stopped, what was recorded.

/// A few lines of text.
void write_session_report(std::ostream &out, const Session &session);

/// The same figures as JSON: durations in seconds, units in all names.
void write_session_json(std::ostream &out, const Session &session);

/// Whether the safety monitor has stopped the device; if so, writes the cause to `errors`.
[[nodiscard]] bool was_stopped(const Session &session, std::ostream &errors);

/// Whether the record, if there was one, holds every tick; if not, writes the reason to
/// `errors`.
[[nodiscard]] bool record_is_whole(const Session &session, std::ostream &errors);

} // namespace springdrive::session
