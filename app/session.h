// One run of the demo without its window: device, servo, scene, tuning, and what came back.
#pragma once

#include "app/history.h"
#include "app/model_choices.h"
#include "app/scene_loader.h"
#include "app/session_options.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/servo/record/recorder.h"
#include "engine/servo/servo.h"
#include "engine/servo/servo_statistics.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace springdrive {

/// Everything is called from the window's thread; servo and recorder have their own.
class Session {
public:
    /// Loads everything and starts nothing. @throw InputError for what cannot be used.
    explicit Session(const SessionOptions &options);

    /// Starts the servo's thread, unless in lockstep, and the record that was asked for. Returns
    /// what the system refused to the servo. @param on_servo_start  see ServoThread
    /// @throw InputError for a record that cannot be made.
    std::vector<std::string> start(std::function<void()> on_servo_start = {});

    /// Moves on by one frame: gives the servo a sign of life, in lockstep ticks it, takes in its
    /// samples, and a scene that finished loading.
    void advance(double frame_s);

    /// Stops the servo; the safe state is sent last. Takes in the last samples, ends the record.
    void stop();

    // What the hand and the eye ask for; in force from the next tick.
    void tune(const Tuning &tuning);
    void lower_limits(const SafetyLimits &limits);
    void emergency_stop();
    void reset_safety();
    void move_hand_to(const Vector3 &target_m);

    /// Loads in the background; on failure the old scene stays and `scene_error` tells why. Where
    /// models are chosen automatically, the scene gets its own before it is shown, which may take
    /// as long as measuring does.
    void request_scene(const std::filesystem::path &file);

    /// Measures in the background which model the scene would get with the gains in force, for
    /// `model_choice` to tell.
    /// @param fresh  even if it is remembered from before
    void measure_model(bool fresh = false);
    void give_up_measuring() { model_measurement_.forget(); }

    /// As if started with --model auto: the scene is loaded again, with its model.
    void choose_models();
    [[nodiscard]] const ModelMeasurement &model_measurement() const { return model_measurement_; }

    /// What the scene would get, once somebody measured it; see `runs_choice`.
    [[nodiscard]] const std::optional<ModelChoice> &model_choice() const { return model_choice_; }

    /// Whether plant, surface and law are those of `model_choice`, but for what was set by option
    /// or by hand, and for a base joint that was not held before (see `is_planar`).
    [[nodiscard]] bool runs_choice() const { return scene_->choice.has_value(); }

    /// Whether the device moves in a plane only. One that begins with three joints keeps them.
    [[nodiscard]] bool is_planar() const { return simulation_.planar; }

    /// Records every tick from now on. @throw InputError for a file that cannot be made.
    void start_recording(const std::filesystem::path &file);
    void stop_recording();

    [[nodiscard]] const Tuning &tuning() const { return inputs_.tuning; }
    [[nodiscard]] const SafetyLimits &lowered_limits() const { return inputs_.limits; }
    [[nodiscard]] const LoadedScene &scene() const { return *scene_; }
    [[nodiscard]] std::uint32_t scene_id() const { return inputs_.scene_id; }
    [[nodiscard]] bool is_loading() const { return loader_.is_loading(); }
    [[nodiscard]] std::string loading_progress() const { return loader_.progress(); }
    [[nodiscard]] const std::string &scene_error() const { return loader_.error(); }
    [[nodiscard]] const DeviceDescription &device() const { return device_->description(); }
    [[nodiscard]] const Vector3 &hand_target_m() const { return hand_target_m_; }
    [[nodiscard]] bool hand_follows_path() const { return simulation_.path.has_value(); }
    [[nodiscard]] double servo_hz() const { return options_.servo_hz; }
    [[nodiscard]] double delay_periods() const { return device_->delay_periods(); }
    [[nodiscard]] const ServoStatistics &statistics() const { return statistics_; }
    [[nodiscard]] std::uint64_t lost_samples() const { return servo_->lost_samples(); }
    [[nodiscard]] const std::vector<std::string> &remarks() const { return remarks_; }
    [[nodiscard]] const ServoSample &latest() const { return latest_; }
    [[nodiscard]] const History &history() const { return history_; }
    [[nodiscard]] bool is_recording() const { return recorder_->is_recording(); }
    [[nodiscard]] RecorderStatus record_status() const { return recorder_->status(); }
    /// The record that runs, or else the last one; empty when there was none.
    [[nodiscard]] const std::filesystem::path &record_file() const { return record_file_; }

private:
    void publish() { servo_->publish(inputs_); }
    void show(std::unique_ptr<LoadedScene> scene);
    [[nodiscard]] SessionOptions options_now() const;
    [[nodiscard]] SceneLoader::Finish give_model() const;
    void choose_first_model(const DeviceDescription &description);
    void take_model(const std::optional<ModelChoice> &before);
    void release_retired();
    void take_in_samples();
    [[nodiscard]] PlotSample plot_sample(const ServoSample &sample);
    [[nodiscard]] RecordHeader header_of_record() const;

    SessionOptions options_;
    std::string device_text_; ///< of the device file, as it was read
    SceneLoader loader_;
    std::unique_ptr<LoadedScene> scene_;
    std::vector<std::unique_ptr<LoadedScene>> retired_; ///< until the servo has let go of them

    std::unique_ptr<SimulatedPhantom> device_;
    std::unique_ptr<Servo> servo_;
    std::unique_ptr<Recorder> recorder_; ///< on the servo's ring, so it goes first
    std::filesystem::path record_file_;
    ServoInputs inputs_;
    std::optional<ModelChoice> model_choice_; ///< of the scene that is shown
    ModelMeasurement model_measurement_;
    SimulationOptions simulation_; ///< what the device is told to simulate, and the hand's path
    Vector3 hand_target_m_{Vector3::Zero()};
    double lockstep_debt_ticks_ = 0.0;
    std::vector<std::string> remarks_;

    ServoSample latest_;
    ServoStatistics statistics_;
    Vector3 felt_force_N_{Vector3::Zero()}; ///< rendered force below 30 Hz while touching
    History history_;
    std::uint64_t plot_stride_ = 1;
};

} // namespace springdrive
