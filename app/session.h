// One run of the demo without its window: device, servo, scene, tuning, and what came back.
#pragma once

#include "app/demo_options.h"
#include "app/history.h"
#include "app/telemetry_file.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/contact/haptic_surface.h"
#include "engine/scene/load_progress.h"
#include "engine/scene/scene.h"
#include "engine/servo/servo.h"
#include "engine/servo/servo_statistics.h"

#include <cstdint>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace springdrive {

/// A scene ready for eye and hand.
struct LoadedScene {
    Scene scene;
    HapticSurface surface;
};

/// Loads a glTF file and prepares its surface. Any thread.
/// @throw InputError as `load_gltf` does.
[[nodiscard]] std::unique_ptr<LoadedScene>
load_scene(const std::filesystem::path &file, const Workspace &workspace, LoadProgress &progress);

/// Everything is called from the window's thread; the servo has its own.
class Session {
public:
    /// Loads everything and starts nothing. @throw InputError for what cannot be used.
    explicit Session(const DemoOptions &options);

    /// Starts the servo's thread, unless in lockstep. Returns what the system refused to it.
    std::vector<std::string> start();

    /// Moves on by one frame: in lockstep ticks the servo, then takes in its samples, and a scene
    /// that finished loading. @throw InputError where the telemetry file cannot be written.
    void advance(double frame_s);

    /// Stops the servo; the safe state is sent last. Takes in the last samples.
    void stop();

    // What the hand and the eye ask for; in force from the next tick.
    void tune(const Tuning &tuning);
    void emergency_stop();
    void reset_safety();
    void move_hand_to(const Vector3 &target_m);

    /// Loads in the background; on failure the old scene stays and `scene_error` tells why.
    void request_scene(const std::filesystem::path &file);

    [[nodiscard]] const Tuning &tuning() const { return inputs_.tuning; }
    [[nodiscard]] const LoadedScene &scene() const { return *scene_; }
    [[nodiscard]] std::uint32_t scene_id() const { return inputs_.scene_id; }
    [[nodiscard]] bool is_loading() const { return loading_.valid(); }
    [[nodiscard]] std::string loading_progress() const { return load_progress_->text(); }
    [[nodiscard]] const std::string &scene_error() const { return scene_error_; }
    [[nodiscard]] const DeviceDescription &device() const { return device_->description(); }
    [[nodiscard]] const Vector3 &hand_target_m() const { return hand_target_m_; }
    [[nodiscard]] bool hand_follows_path() const { return hand_path_.has_value(); }
    [[nodiscard]] double servo_hz() const { return options_.servo_hz; }
    [[nodiscard]] int delay_samples() const { return device_->delay_samples(); }
    [[nodiscard]] const ServoStatistics &statistics() const { return statistics_; }
    [[nodiscard]] std::uint64_t lost_samples() const { return servo_->lost_samples(); }
    [[nodiscard]] const std::vector<std::string> &remarks() const { return remarks_; }
    [[nodiscard]] const ServoSample &latest() const { return latest_; }
    [[nodiscard]] const History &history() const { return history_; }
    [[nodiscard]] std::uint64_t telemetry_rows() const {
        return telemetry_ ? telemetry_->rows() : 0;
    }

private:
    void publish() { servo_->publish(inputs_); }
    void show(std::unique_ptr<LoadedScene> scene);
    void release_retired();
    void take_in_loaded_scene();
    void take_in_samples();
    [[nodiscard]] PlotSample plot_sample(const ServoSample &sample);

    DemoOptions options_;
    std::unique_ptr<LoadedScene> scene_;
    std::vector<std::unique_ptr<LoadedScene>> retired_; ///< until the servo has let go of them
    std::future<std::unique_ptr<LoadedScene>> loading_;
    std::shared_ptr<LoadProgress> load_progress_ = std::make_shared<LoadProgress>();
    std::optional<std::filesystem::path> next_file_; ///< asked for while another was loading
    std::string scene_error_;

    std::unique_ptr<SimulatedPhantom> device_;
    std::unique_ptr<Servo> servo_;
    ServoInputs inputs_;
    Vector3 hand_target_m_{Vector3::Zero()};
    std::optional<HandPath> hand_path_; ///< the one that the device follows, to show where it is
    double lockstep_debt_ticks_ = 0.0;
    std::vector<std::string> remarks_;

    ServoSample latest_;
    ServoStatistics statistics_;
    Vector3 felt_force_N_{Vector3::Zero()}; ///< rendered force below 30 Hz while touching
    History history_;
    std::uint64_t plot_stride_ = 1;
    std::optional<TelemetryFile> telemetry_;
};

} // namespace springdrive
