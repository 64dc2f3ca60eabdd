// The part of `Session` that opens and exchanges devices.
#include "base/assertions.h"
#include "base/input_error.h"
#include "base/quoting.h"
#include "device/core/calibration_file.h"
#include "device/core/device_file.h"
#include "engine/control/motion_control.h"
#include "engine/scene/scripted_touch.h"
#include "engine/session/session_parts.h"
#include "engine/session/windings_file.h"

#include <nlohmann/json.hpp>

#include <fstream>
#include <iterator>
#include <utility>

namespace springdrive::session {

namespace {

std::array<device::MotorTemperature, 3> hottest_motors(const servo::ServoSample &sample) {
    std::array<device::MotorTemperature, 3> hottest;
    for (std::size_t j = 0; j < hottest.size(); ++j) {
        hottest[j] = {sample.winding[j].max_C, sample.winding[j].max_housing_C};
    }
    return hottest;
}

} // namespace

std::string dump(const nlohmann::json &json) { return json_text(json, -1); }

std::string text_of_device(const std::filesystem::path &file) {
    static_cast<void>(device::read_device_file(file)); // throws if it is not a valid device file
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::string note_on_scene(std::uint32_t scene_id, const LoadedScene &scene) {
    return dump({{"scene_id", scene_id},
                 {"scene",
                  {{"file", scene.scene.file.string()},
                   {"sha256", scene.sha256},
                   {"triangles", scene.scene.surface.triangles.size()}}}});
}

ModelGround Session::ground(const std::string &device_text, const device::DeviceDescription &device,
                            double servo_hz) const {
    return {device,
            {device_text, options_.program_version},
            servo::servo_period_s(servo_hz),
            device_ ? device_->device().delay_periods() : options_.delay_periods};
}

/// Opens a device for the shown scene: the tip starts above it, or at the start of the hand's path.
/// @param tuning  of the servo; a model may change it
Session::Prepared Session::prepare(const DeviceChoice &choice, const std::string &text,
                                   control::Tuning &tuning) const {
    const LoadedScene &scene = scenes_->now();
    const Vector3 &lower_m = scene.scene.lower_m;
    const Vector3 &upper_m = scene.scene.upper_m;
    factory::DeviceRequest request;
    request.kind = choice.kind;
    request.serial = choice.serial;
    request.description = device::read_device_text(text, choice.file);
    request.has_clock = !options_.lockstep;
    request.period_s = servo_ ? servo_->period_s() : servo::servo_period_s(options_.servo_hz);
    simulated::SimulationOptions &simulation = request.simulation;
    simulation.servo_period_s = request.period_s;
    simulation.delay_periods = options_.delay_periods;
    simulation.effects = options_.effects;
    simulation.device_seed = options_.device_seed;
    simulation.hand = simulation_.hand;
    const std::optional<model_selection::ModelSelection> before =
        servo_ ? scene.choice : std::nullopt;
    models_->apply_to(scene, before, true, simulation, tuning);
    request.start_tip_m = scene::start_above(request.description, lower_m, upper_m);
    if (choice.kind == factory::DeviceKind::emulated) {
        request.emulation = options_.emulation;
        simulation.effects = options_.effects;
        request.start_tip_m = Vector3::Zero();
    } else if (!options_.path.empty()) {
        simulation.path = simulated::HandPath::read_csv(options_.path);
        request.start_tip_m = simulation.path->points().front().position_m;
    } else if (options_.plays_script) {
        simulation.path = simulated::HandPath(
            scene::scripted_touch(request.description, scene.surface, lower_m, upper_m));
    }
    factory::OpenDevice device = factory::open_device(request);
    std::string whole_text = text;
    if (const std::optional<device::Calibration> &used = device.device().description().calibration;
        used && !request.description.calibration) { // the board's: a record needs it, too
        whole_text = device::with_calibration(text, *used);
        request.description = device::read_device_text(whole_text, choice.file);
        device.take_calibration(*request.description.calibration); // to the last bit as recorded
    }
    return {choice, std::move(whole_text), std::move(request), std::move(device)};
}

void Session::exchange_device(const DeviceChoice &choice) {
    const device::DeviceIdentity present = device_->identity();
    const bool is_open_here = choice.kind == factory::DeviceKind::usb && present.kind == "USB" &&
                              device_->state() != factory::DeviceState::closed &&
                              present.serial == choice.serial;
    if (is_open_here) {
        throw InputError("the USB board " + choice.serial + " is the device in use already");
    }
    if (servo_->has_failed()) { // a new servo would drive the motors again
        throw InputError("changing the device requires a restart of the program: " +
                         servo::description(latest().safety));
    }
    require_not_lent();
    control::Tuning tuning = tuning_->now();
    next_device_ = std::make_unique<Prepared>(prepare(choice, text_of_device(choice.file), tuning));
    servo_->release(true);
}

void Session::prepare_again() {
    const DeviceChoice choice = next_device_->choice;
    next_device_.reset(); // close first: it may be the same device
    try {
        exchange_device(choice);
    } catch (const InputError &error) {
        release_until_zeroed();
        warnings_.add(error.what());
    }
}

void Session::note_failed_assertion() {
    if (reported_failure_ || !servo_->has_failed()) {
        return;
    }
    reported_failure_ = true;
    next_device_.reset(); // see `exchange_device`
    const servo::SafetyStatus &safety = latest().safety;
    note(dump({{"assertion_failed", safety.failure.condition},
               {"file", safety.failure.file},
               {"line", safety.failure.line}}));
}

void Session::go_on_with_exchange() {
    if (next_device_ && servo_->stop_if_released()) {
        const std::unique_ptr<Prepared> next = std::move(next_device_);
        begin_on(std::move(*next));
    }
}

/// @pre the servo has stopped on the old device
void Session::begin_on(Prepared next) {
    SPRINGDRIVE_ASSERT(servo_->servo().is_at_rest());
    const std::filesystem::path part_before = recording_->file();
    recording_->end_part(dump({{"device", "exchanged"}, {"for", next.request.description.name}}));
    keep_windings();
    device_->close();
    const double speed = servo_->speed();
    servo_->renew(next.device.device());
    *device_ = std::move(next.device);
    start_watching_windings();
    options_.device = next.choice;
    simulation_ = next.request.simulation;
    const device::DeviceDescription &description = next.request.description;
    hand_.take_hold(device_->hand(), description, simulation_.path, next.request.start_tip_m);
    scenes_->set_workspace(description.workspace);
    observe_as_wanted();
    servo_->set_global_alpha(control::global_alpha_bound(description));
    models_->set_ground(ground(next.text, description, servo_->rate_hz()));
    begin_part(part_before, "for the new device");
    release_until_zeroed();
    if (has_started_) {
        start_servo();
        servo_->set_speed(speed);
    }
    choose_again();
}

/// Only of a device in a real hand the windings can be hot from before.
void Session::start_watching_windings() {
    const bool is_real = device_->hand() == nullptr;
    servo_->resume_watch(is_real
                             ? take_windings(options_.windings_folder, device_->identity().serial,
                                             description().motor, storing_time())
                             : std::array<device::MotorTemperature, 3>{});
}

/// Not of a device that was lost: what it did since then nobody saw.
void Session::keep_windings() const {
    if (has_started_ && device_->hand() == nullptr && latest().health == device::DeviceHealth::ok) {
        store_windings(options_.windings_folder, device_->identity().serial,
                       hottest_motors(latest()), storing_time());
    }
}

/// A record continues after `ServoRun::renew`.
void Session::begin_part(const std::filesystem::path &part_before, const char *why) {
    next_look_s_ = 0.0; // of the servo before, whose time was another
    released_until_s_ = 0.0;
    begin_past();
    try {
        const std::filesystem::path part = recording_->begin_part(header_of_record());
        if (!part.empty()) {
            recording_->note(dump({{"continues", part_before.string()}}));
            warnings_.add("the record continues in " + part.string() + ", " + why);
        }
    } catch (const InputError &error) {
        warnings_.add(error.what());
    }
}

void Session::use_calibration(const device::Calibration &calibration) {
    require_not_lent();
    if (is_exchanging()) {
        throw InputError("the device is being exchanged; wait until that is done");
    }
    if (latest().safety.state == servo::SafetyState::tripped) { // which a new servo would forget
        throw InputError("the device is stopped: " + servo::description(latest().safety) +
                         "; reset it first");
    }
    if (device_->device().bench() == nullptr) {
        throw InputError(description().name +
                         " has no board: its calibration is that of its device file");
    }
    const ModelGround &before = models_->ground();
    const std::string text = device::with_calibration(before.memory.device_text, calibration);
    const device::DeviceDescription calibrated =
        device::read_device_text(text, options_.device.file); // a record's, to the last bit
    const device::Calibration &known = *calibrated.calibration;
    device::require_calibration_of(calibrated, device_->identity().serial);
    if (!servo_->stop_if_released()) {
        throw InputError("a motor is driven; the calibration is used once the device is released");
    }
    const std::filesystem::path part_before = recording_->file();
    recording_->end_part(
        dump({{"device", "calibrated"}, {"at", device::text_of_utc(known.made_at_s)}}));
    const double speed = servo_->speed();
    device_->take_calibration(known);
    if (hand_.follows_path()) { // by the old servo's time
        leave_path();
    }
    const std::array<device::MotorTemperature, 3> hottest = hottest_motors(latest());
    servo_->renew(device_->device());
    servo_->resume_watch(hottest);
    hand_.take_hold(device_->hand(), calibrated, std::nullopt, hand_.target_m());
    observe_as_wanted();
    models_->set_ground(ground(text, calibrated, servo_->rate_hz()));
    begin_part(part_before, "with the new calibration");
    release_until_zeroed();
    if (has_started_) {
        start_servo();
        servo_->set_speed(speed);
    }
}

} // namespace springdrive::session
