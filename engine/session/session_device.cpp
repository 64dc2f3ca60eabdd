// The part of `Session` that opens, exchanges, zeroes, connects again and has devices used
// exclusively.
#include "base/assertions.h"
#include "base/input_error.h"
#include "base/real_time_thread.h"
#include "base/text.h"
#include "device/core/device_file.h"
#include "device/core/haptic_device.h"
#include "device/core/motor/winding_heat.h"
#include "engine/control/motion_control.h"
#include "engine/scene/scripted_touch.h"
#include "engine/servo/real_time.h"
#include "engine/session/session_parts.h"
#include "engine/session/windings_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <fstream>
#include <future>
#include <iterator>
#include <thread>
#include <utility>

namespace springdrive::session {

namespace {

/// After a zeroing or an exclusive use, for the velocity filter to settle: to it, the device
/// jumped.
constexpr double kSettling_s = 0.1;

/// Between two looks at a link: whether a lost device is there again, or d has changed.
constexpr double kLook_s = 0.5;

/// A measured d differs by so much from the one in use before the latter is replaced.
constexpr double kDelayTolerance_periods = 0.05;

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
    require_no_exclusive_use();
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
    servo_->set_global_alpha(control::global_alpha_bound(description));
    start_anew(next.text, description, speed, "for the new device");
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

/// After `ServoRun::renew`: a record continues in a new file.
void Session::start_anew(const std::string &text, const device::DeviceDescription &description,
                         double speed, const char *why) {
    observe_as_requested();
    models_->set_ground(ground(text, description, servo_->rate_hz()));
    next_look_s_ = 0.0; // of the servo before, whose time was another
    released_until_s_ = 0.0;
    begin_past();
    const std::filesystem::path part_before = recording_->file();
    try {
        const std::filesystem::path part = recording_->begin_part(header_of_record());
        if (!part.empty()) {
            recording_->note(dump({{"continues", part_before.string()}}));
            warnings_.add("the record continues in " + part.string() + ", " + why);
        }
    } catch (const InputError &error) {
        warnings_.add(error.what());
    }
    release_until_zeroed();
    if (has_started_) {
        start_servo();
        servo_->set_speed(speed);
    }
}

void Session::use_calibration(const device::Calibration &calibration) {
    require_free();
    require_not_stopped(); // which a new servo would forget
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
    start_anew(text, calibrated, speed, "with the new calibration");
}

bool Session::is_zeroed() const { return device_->state() == factory::DeviceState::zeroed; }

void Session::release_until_zeroed() {
    knows_zero_ = is_zeroed();
    const bool is_settling = latest().time_s < released_until_s_;
    servo_->release(is_exchanging() || is_kept_released_ || exclusive_use_ || !knows_zero_ ||
                    is_settling);
}

void Session::keep_released(bool requested) {
    is_kept_released_ = requested;
    release_until_zeroed();
}

void Session::zero_device(const Vector3 &theta_rad) {
    require_no_exclusive_use();
    servo_->paused([&] {
        device_->zero(theta_rad);
        note(dump({{"device", "zeroed"},
                   {"theta_rad", {theta_rad[0], theta_rad[1], theta_rad[2]}},
                   {"after_tick", latest().tick}}));
        released_until_s_ = latest().time_s + kSettling_s;
    });
    release_until_zeroed();
}

void Session::reconnect_device(const std::optional<Vector3> &theta_rad) {
    require_no_exclusive_use();
    servo_->paused([&] {
        const Vector3 theta = theta_rad.value_or(latest().theta_rad);
        device_->reconnect();
        if (theta_rad || (device_->has_world() && knows_zero_)) {
            device_->zero(theta);
        }
        servo_->resume_watch({}); // its clock may be another
        note(dump({{"device", "reconnected"}, {"after_tick", latest().tick}}));
    });
    release_until_zeroed();
}

/// The tick that contradicts a zero voids it. Of a lost device `watch_link` says so.
void Session::watch_zero() {
    if (!knows_zero_ || is_zeroed() || latest().health == device::DeviceHealth::lost ||
        latest().safety.state != servo::SafetyState::tripped) {
        return;
    }
    note(dump({{"device", "zero void"}, {"after_tick", latest().tick}}));
    warnings_.add(
        servo::description(latest().safety) +
        ": its zero is void, and no motor is driven until it is zeroed again; reset the "
        "stop, hold the device in its zero pose, and zero it, in the window in tab Plant");
    release_until_zeroed();
}

/// A device that was unplugged is connected again once it is there; its trip stays.
void Session::watch_link() {
    if (released_until_s_ > 0.0 && latest().time_s >= released_until_s_ && !exclusive_use_) {
        released_until_s_ = 0.0;
        release_until_zeroed();
    }
    if (device_->has_world() || !has_started_ || is_exchanging() || exclusive_use_ ||
        servo_->has_failed()) {
        return;
    }
    if (latest().time_s < next_look_s_) {
        return;
    }
    next_look_s_ = latest().time_s + kLook_s;
    if (latest().health == device::DeviceHealth::ok) {
        adopt_delay();
        return;
    }
    const std::string error = error_text_of([this] { reconnect_device(); });
    if (!error.empty()) {
        warnings_.add(error);
        return;
    }
    const std::string again =
        ++reconnections_ == 1
            ? "the device is connected again"
            : fmt::format("the device is connected again, {} times by now", reconnections_);
    warnings_.add(again +
                  (is_zeroed() ? "; reset the stop to go on" : ", but lost its counts; zero it"));
}

/// While no motor is driven: the servo pauses for it.
void Session::adopt_delay() {
    const double measured = device_->device().delay_periods();
    if (servo::lets_pass(latest().safety.state) || servo_->is_in_lockstep() ||
        std::abs(measured - models_->ground().delay_periods) <= kDelayTolerance_periods) {
        return;
    }
    servo_->paused([&] {
        const std::uint64_t from_tick = servo_->set_rate(servo_->rate_hz()); // the loop's delay
        note(dump({{"delay_periods", measured}, {"from_tick", from_tick}}));
    });
    measure_anew();
}

/// Calls `tick` once a period until it has no more to do.
class Session::ExclusiveUse {
public:
    ExclusiveUse(std::function<bool()> tick, double period_s)
        : tick_(std::move(tick)), period_s_(period_s) {}
    ~ExclusiveUse() { end(); }
    ExclusiveUse(const ExclusiveUse &) = delete;
    ExclusiveUse &operator=(const ExclusiveUse &) = delete;

    [[nodiscard]] bool has_begun() const { return has_begun_; }
    [[nodiscard]] bool is_over() const { return is_over_.load(std::memory_order_acquire); }
    /// Once it is over, or has ended.
    [[nodiscard]] const std::string &error() const { return error_; }

    void begin(bool on_a_thread, std::optional<int> cpu) {
        has_begun_ = true;
        if (on_a_thread) {
            running_ = run_on_own_heap([this, cpu] {
                static_cast<void>(servo::make_this_thread_real_time(cpu)); // said by the servo
                run();
            });
        }
    }

    /// Without a thread.
    void advance(double frame_s) {
        pending_ticks_ += frame_s / period_s_;
        for (; pending_ticks_ >= 1.0 && !is_over(); pending_ticks_ -= 1.0) {
            tick();
        }
    }

    void end() {
        is_ended_.store(true, std::memory_order_release);
        if (running_.valid()) {
            running_.wait();
        }
    }

private:
    void run() {
        using Clock = std::chrono::steady_clock;
        const auto period =
            std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(period_s_));
        Clock::time_point due = Clock::now();
        while (!is_ended_.load(std::memory_order_acquire) && !is_over()) {
            tick();
            due = std::max(due + period, Clock::now()); // what was missed is not made up for
            std::this_thread::sleep_until(due);
        }
    }

    void tick() {
        try {
            if (tick_()) {
                return;
            }
        } catch (const std::exception &error) {
            error_ = error.what();
        }
        is_over_.store(true, std::memory_order_release);
    }

    std::function<bool()> tick_;
    double period_s_;
    double pending_ticks_ = 0.0;
    bool has_begun_ = false;
    std::string error_;
    std::atomic<bool> is_over_{false};
    std::atomic<bool> is_ended_{false};
    std::future<void> running_;
};

void Session::require_no_exclusive_use() const {
    if (exclusive_use_) {
        throw InputError("the device is in use by its self-test or calibration; wait until that is "
                         "over, or stop it");
    }
}

void Session::require_free() const {
    require_no_exclusive_use();
    if (is_exchanging()) {
        throw InputError("the device is being exchanged; wait until that is done");
    }
}

void Session::require_not_stopped() const {
    if (latest().safety.state == servo::SafetyState::tripped) {
        throw InputError("the device is stopped: " + servo::description(latest().safety) +
                         "; reset it first");
    }
}

void Session::begin_exclusive_use(std::function<bool()> tick) {
    require_free();
    if (latest().health == device::DeviceHealth::lost) {
        throw InputError("the device is lost; plug it in again");
    }
    require_not_stopped();
    exclusive_use_error_.clear();
    exclusive_use_ = std::make_shared<ExclusiveUse>(std::move(tick), servo_->period_s());
    release_until_zeroed();
}

void Session::go_on_with_exclusive_use(double frame_s) {
    if (!exclusive_use_) {
        return;
    }
    if (servo_->is_held_stopped() || exclusive_use_->is_over() ||
        latest().safety.state == servo::SafetyState::tripped) {
        end_exclusive_use();
    } else if (exclusive_use_->has_begun()) {
        if (servo_->is_in_lockstep()) {
            exclusive_use_->advance(frame_s);
        }
    } else if (servo_->halt_if_released()) {
        note(dump({{"device", "lent"}, {"after_tick", latest().tick}}));
        exclusive_use_->begin(!servo_->is_in_lockstep(), options_.cpu);
    }
}

void Session::emergency_stop() {
    servo_->emergency_stop();
    end_exclusive_use();
}

/// Ends pulses of a self-test, which go on while its host brakes, by opening the windings.
void Session::end_pulses() {
    constexpr int kMaxTries = 50; // of which some may be lost
    device::HapticDevice &device = device_->device();
    device::Bench *const bench = device.bench();
    const auto answer_by = [&](device::CommandMode mode) {
        device::DeviceCommand command;
        command.mode = mode;
        command.number = device.read().number;
        device.write(command);
    };
    try {
        for (int i = 0; bench != nullptr && i < kMaxTries &&
                        bench->pulses().state == device::PulseState::running;
             ++i) {
            answer_by(device::CommandMode::open);
        }
    } catch (const InputError &) { // which hears nothing, and ends them by itself
    }
    answer_by(device::CommandMode::brake);
}

void Session::end_exclusive_use() {
    if (!exclusive_use_) {
        return;
    }
    exclusive_use_->end();
    const bool has_begun = exclusive_use_->has_begun();
    exclusive_use_error_ = exclusive_use_->error();
    exclusive_use_.reset();
    if (has_begun) {
        end_pulses();
        note(dump({{"device", "back"}, {"after_tick", latest().tick}}));
        released_until_s_ = latest().time_s + kSettling_s;
        release_until_zeroed();
        servo_->resume_watch(device::hottest_motors(description().motor)); // by unseen currents
        servo_->go_on();
    } else {
        release_until_zeroed();
    }
}

} // namespace springdrive::session
