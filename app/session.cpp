#include "app/session.h"

#include "app/load_lines.h"
#include "base/input_error.h"
#include "device/phantom/kinematics.h"
#include "engine/contact/preparation/mesh_remarks.h"
#include "engine/control/force_direction.h"
#include "engine/control/motion_control.h"
#include "engine/scenario/scripted_touch.h"
#include "engine/scene/gltf.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <iterator>
#include <numbers>
#include <thread>
#include <utility>

namespace springdrive {

namespace {

constexpr double kPlotted_s = 10.0;
constexpr double kGreatestPlotRate_hz = 1000.0;
/// What people can tell of a force's direction by hand (the paper, section V).
constexpr double kFelt_hz = 30.0;
constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;

/// The last point in reach on the way from the workspace's centre to `wanted_m`.
Vector3 nearest_in_reach(const DeviceDescription &device, const Vector3 &wanted_m) {
    if (joint_angles_rad(device.geometry, wanted_m)) {
        return wanted_m;
    }
    double in_reach = 0.0;
    double out_of_reach = 1.0;
    const Vector3 way_m = wanted_m - device.workspace.centre_m;
    for (int halving = 0; halving < 20; ++halving) {
        const double middle = 0.5 * (in_reach + out_of_reach);
        const bool reached =
            joint_angles_rad(device.geometry, device.workspace.centre_m + middle * way_m)
                .has_value();
        (reached ? in_reach : out_of_reach) = middle;
    }
    return device.workspace.centre_m + in_reach * way_m;
}

std::uint64_t plot_stride(double servo_hz) {
    return static_cast<std::uint64_t>(std::max(1.0, std::ceil(servo_hz / kGreatestPlotRate_hz)));
}

} // namespace

std::unique_ptr<LoadedScene> load_scene(const std::filesystem::path &file,
                                        const Workspace &workspace, LoadProgress &progress) {
    Scene scene = load_gltf(file, workspace, &progress);
    progress.begin(LoadProgress::Stage::preparing, false);
    HapticSurface surface(scene.surface, scene.shapes);
    std::ranges::move(remarks_on(surface.report(), scene.surface.materials),
                      std::back_inserter(scene.remarks));
    return std::make_unique<LoadedScene>(LoadedScene{std::move(scene), std::move(surface)});
}

Session::Session(const DemoOptions &options)
    : options_(options),
      history_(static_cast<std::size_t>(kPlotted_s * options.servo_hz /
                                        static_cast<double>(plot_stride(options.servo_hz)))),
      plot_stride_(plot_stride(options.servo_hz)) {
    const DeviceDescription description = read_device_file(options.device_file);
    inputs_.tuning = options.tuning;
    inputs_.global_alpha_rad2_per_m2 = global_alpha_bound(description);
    {
        const LoadLines lines(options.scene.filename().string(), *load_progress_, std::cerr);
        scene_ = load_scene(options.scene, description.workspace, *load_progress_);
    }

    const Vector3 &lower_m = scene_->scene.lower_m;
    const Vector3 &upper_m = scene_->scene.upper_m;
    SimulationOptions simulation;
    simulation.servo_period_s = servo_period_s(options.servo_hz);
    simulation.delay_samples = options.delay_samples;
    simulation.effects = options.effects;
    hand_target_m_ = start_above(description, lower_m, upper_m);
    if (!options.path.empty()) {
        simulation.path = HandPath::read_csv(options.path);
        hand_target_m_ = simulation.path->points().front().position_m;
    } else if (options.unattended()) {
        simulation.path =
            scripted_touch(description, scene_->surface, lower_m, upper_m, hand_target_m_);
    }
    hand_path_ = simulation.path;
    device_ = std::make_unique<SimulatedPhantom>(description, simulation, hand_target_m_);
    servo_ = std::make_unique<Servo>(*device_, options.servo_hz);

    inputs_.surface = &scene_->surface;
    inputs_.scene_id = 1;
    publish();
    if (!options.telemetry.empty()) {
        telemetry_.emplace(options.telemetry);
    }
}

std::vector<std::string> Session::start() {
    if (!options_.lockstep) {
        remarks_ = servo_->start();
    }
    return remarks_;
}

void Session::advance(double frame_s) {
    inputs_.heartbeat = std::max(1U, inputs_.heartbeat + 1U);
    publish();
    if (options_.lockstep) {
        lockstep_debt_ticks_ += frame_s * options_.servo_hz;
        const int due = static_cast<int>(std::floor(lockstep_debt_ticks_ + 1e-9));
        lockstep_debt_ticks_ -= due;
        servo_->advance(due);
    }
    take_in_samples();
    take_in_loaded_scene();
}

void Session::stop() {
    servo_->stop();
    take_in_samples();
    if (telemetry_) {
        telemetry_->close();
    }
}

PlotSample Session::plot_sample(const ServoSample &sample) {
    if (sample.contact.touching) {
        const double pole = std::exp(-2.0 * std::numbers::pi * kFelt_hz / options_.servo_hz);
        felt_force_N_ = pole * felt_force_N_ + (1.0 - pole) * sample.tip_force_N;
    } else {
        felt_force_N_.setZero();
    }
    const double felt = std::isnan(sample.rendered_error_rad)
                            ? sample.rendered_error_rad
                            : direction_error_rad(felt_force_N_, sample.contact.normal);
    const double other = sample.tuning.map == MotionMap::transpose ? sample.inverse_error_rad
                                                                   : sample.transpose_error_rad;
    return {sample.time_s, sample.rendered_error_rad * kDegreesPerRadian, felt * kDegreesPerRadian,
            other * kDegreesPerRadian, sample.tip_force_N.norm()};
}

void Session::take_in_samples() {
    servo_->drain([this](const ServoSample &sample) {
        latest_ = sample;
        statistics_.add(sample);
        const PlotSample plotted = plot_sample(sample);
        if (sample.tick % plot_stride_ == 0) {
            history_.add(plotted);
        }
        if (telemetry_) {
            telemetry_->write(sample);
        }
    });
    if (hand_path_) {
        hand_target_m_ = hand_path_->at(latest_.time_s).position_m;
    }
    // The servo works on the newest scene now, so it has let go of all before.
    if (latest_.scene_id == inputs_.scene_id) {
        release_retired();
    }
}

/// To give gigabytes back takes longer than a frame, so another thread does it.
void Session::release_retired() {
    if (!retired_.empty()) {
        std::thread([scenes = std::exchange(retired_, {})]() mutable { scenes.clear(); }).detach();
    }
}

void Session::tune(const Tuning &tuning) {
    inputs_.tuning = tuning;
    publish();
}

void Session::emergency_stop() {
    inputs_.emergency_stop = true;
    publish();
}

void Session::reset_safety() {
    inputs_.emergency_stop = false;
    ++inputs_.reset_count;
    publish();
}

void Session::move_hand_to(const Vector3 &target_m) {
    const Workspace &box = device().workspace;
    const Vector3 within_m = target_m.cwiseMax(box.centre_m - 0.5 * box.size_m)
                                 .cwiseMin(box.centre_m + 0.5 * box.size_m);
    hand_target_m_ = nearest_in_reach(device(), within_m);
    device_->set_hand_target(hand_target_m_);
}

void Session::request_scene(const std::filesystem::path &file) {
    if (is_loading()) {
        next_file_ = file; // the last one asked for wins
        return;
    }
    scene_error_.clear();
    load_progress_ = std::make_shared<LoadProgress>();
    std::packaged_task<std::unique_ptr<LoadedScene>()> load(
        [file, workspace = device().workspace, progress = load_progress_] {
            return load_scene(file, workspace, *progress);
        });
    loading_ = load.get_future();
    // Detached, so that whoever closes the window need not wait for a large file.
    std::thread(std::move(load)).detach();
}

void Session::take_in_loaded_scene() {
    if (!loading_.valid() ||
        loading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
        return;
    }
    try {
        show(loading_.get());
    } catch (const std::exception &error) {
        scene_error_ = error.what();
    }
    if (next_file_) {
        request_scene(*std::exchange(next_file_, std::nullopt));
    }
}

void Session::show(std::unique_ptr<LoadedScene> scene) {
    retired_.push_back(std::exchange(scene_, std::move(scene)));
    inputs_.surface = &scene_->surface;
    ++inputs_.scene_id;
    publish();
}

} // namespace springdrive
