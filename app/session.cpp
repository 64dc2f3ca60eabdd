#include "app/session.h"

#include "app/load_lines.h"
#include "base/input_error.h"
#include "device/phantom/kinematics.h"
#include "engine/control/force_direction.h"
#include "engine/control/motion_control.h"
#include "engine/scenario/scripted_touch.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <iterator>
#include <numbers>
#include <sstream>
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

/// Of a device file, so that a record holds what the session ran on, whatever becomes of the file.
std::string text_of(const std::filesystem::path &file) {
    static_cast<void>(read_device_file(file)); // refuses, with the reason, what is none
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

void check_late_limit(const DeviceDescription &device, double limit_s) {
    if (!(limit_s > 0.0 && limit_s <= device.limits.late_s)) {
        std::ostringstream message;
        message << "--late-limit-ms " << 1e3 * limit_s << ": must be above 0, up to "
                << 1e3 * device.limits.late_s << ", what the device file allows";
        throw InputError(message.str());
    }
}

/// Between rows of a record: which scene it is from here on.
std::string note_on_scene(std::uint32_t scene_id, const LoadedScene &scene) {
    return nlohmann::json{{"scene_id", scene_id},
                          {"scene",
                           {{"file", scene.scene.file.string()},
                            {"sha256", scene.sha256},
                            {"triangles", scene.scene.surface.triangles.size()}}}}
        .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::uint64_t plot_stride(double servo_hz) {
    return static_cast<std::uint64_t>(std::max(1.0, std::ceil(servo_hz / kGreatestPlotRate_hz)));
}

} // namespace

Session::Session(const SessionOptions &options)
    : options_(options), device_text_(text_of(options.device_file)),
      loader_(read_device_text(device_text_, options.device_file).workspace),
      history_(static_cast<std::size_t>(kPlotted_s * options.servo_hz /
                                        static_cast<double>(plot_stride(options.servo_hz)))),
      plot_stride_(plot_stride(options.servo_hz)) {
    const DeviceDescription description = read_device_text(device_text_, options.device_file);
    if (options.cpu) {
        check_cpu(*options.cpu);
        keep_off_cpu(*options.cpu); // window, recorder and loader; the servo's thread goes there
    }
    inputs_.tuning = options.tuning;
    inputs_.global_alpha_rad2_per_m2 = global_alpha_bound(description);
    if (options.late_limit_s) {
        check_late_limit(description, *options.late_limit_s);
        inputs_.limits.late_s = *options.late_limit_s;
    }
    {
        LoadProgress progress;
        const LoadLines lines(options.scene.filename().string(), progress, std::cerr);
        scene_ = load_scene(options.scene, description.workspace, progress);
    }

    const Vector3 &lower_m = scene_->scene.lower_m;
    const Vector3 &upper_m = scene_->scene.upper_m;
    simulation_.servo_period_s = servo_period_s(options.servo_hz);
    simulation_.delay_periods = options.delay_periods;
    simulation_.effects = options.effects;
    choose_first_model(description);
    hand_target_m_ = start_above(description, lower_m, upper_m);
    if (!options.path.empty()) {
        simulation_.path = HandPath::read_csv(options.path);
        hand_target_m_ = simulation_.path->points().front().position_m;
    } else if (options.plays_script) {
        simulation_.path =
            scripted_touch(description, scene_->surface, lower_m, upper_m, hand_target_m_);
    }
    device_ = std::make_unique<SimulatedPhantom>(description, simulation_, hand_target_m_);
    servo_ = std::make_unique<Servo>(*device_, options.servo_hz);
    recorder_ = std::make_unique<Recorder>(servo_->record_ring());

    inputs_.surface = &scene_->surface;
    inputs_.scene_id = 1;
    publish();
}

std::vector<std::string> Session::start(std::function<void()> on_servo_start) {
    if (!options_.record.empty()) {
        start_recording(options_.record);
    }
    if (!options_.lockstep) {
        remarks_ = servo_->start({options_.cpu, std::move(on_servo_start)});
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
        recorder_->pump();
    }
    take_in_samples();
    if (std::unique_ptr<LoadedScene> scene = loader_.take()) {
        show(std::move(scene));
    }
    if (std::optional<ModelChoice> choice = model_measurement_.take()) {
        model_choice_ = std::move(choice);
    }
}

void Session::stop() {
    servo_->stop();
    take_in_samples();
    stop_recording();
}

RecordHeader Session::header_of_record() const {
    RecordHeader header = record_header(options_.servo_hz);
    header.software = SPRINGDRIVE_VERSION;
    header.delay_periods = device_->delay_periods();
    header.device_name = device_->description().name;
    header.device_file = options_.device_file.string();
    header.device_toml = device_text_;
    header.tuning = inputs_.tuning;
    header.scene_file = scene_->scene.file.string();
    header.scene_sha256 = scene_->sha256;
    header.scene_triangles = scene_->scene.surface.triangles.size();
    header.global_alpha_rad2_per_m2 = inputs_.global_alpha_rad2_per_m2;
    return header;
}

void Session::start_recording(const std::filesystem::path &file) {
    recorder_->start(file, header_of_record(),
                     options_.lockstep ? Recorder::Mode::pumped : Recorder::Mode::own_thread);
    servo_->feed_recorder(true);
    record_file_ = file;
}

void Session::stop_recording() {
    servo_->feed_recorder(false);
    recorder_->stop();
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
    });
    if (simulation_.path) {
        hand_target_m_ = simulation_.path->at(latest_.time_s).position_m;
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

void Session::lower_limits(const SafetyLimits &limits) {
    inputs_.limits = limits;
    publish();
}

void Session::emergency_stop() {
    inputs_.emergency_stop = true;
    ++inputs_.stop_count;
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

void Session::show(std::unique_ptr<LoadedScene> scene) {
    retired_.push_back(std::exchange(scene_, std::move(scene)));
    model_measurement_.forget();
    take_model(retired_.back()->choice);
    inputs_.surface = &scene_->surface;
    ++inputs_.scene_id;
    publish();
    recorder_->note(note_on_scene(inputs_.scene_id, *scene_));
}

} // namespace springdrive
