#include "app/exhibit/kiosk.h"

#include "app/view/view_state.h"
#include "base/input_error.h"
#include "engine/session/telemetry_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <unistd.h>
#include <utility>

namespace springdrive::app::exhibit {

namespace {

constexpr double kTouched_m = 5e-3; ///< a tip that moved so far was moved by somebody
constexpr double kReadOut_s = 0.2;  ///< digits that change more often cannot be read
constexpr double kFinal_s = 10.0;   ///< from a final stop of a simulated device to a new start
constexpr unsigned kHung_s = 20;    ///< without a frame, while the computer is awake

/// It goes on while the computer sleeps.
double boot_time_s() {
    std::timespec now{};
    clock_gettime(CLOCK_BOOTTIME, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

bool is_lost(const session::Session &session) {
    return session.latest().health == device::DeviceHealth::lost;
}

bool is_stopped(const session::Session &session) {
    return session.latest().safety.state == servo::SafetyState::tripped;
}

std::string start_text(const session::Session &session) {
    const servo::SafetyLimits limits =
        servo::lowered(servo::limits_of(session.description()), session.servo().inputs().limits);
    return fmt::format(
        "start: springdrive {}, {}, {}; at most {:g} N, {:g} V, {:g} m/s",
        session.program_version(), session.description().name,
        factory::kDeviceKindNames[static_cast<std::size_t>(session.device_choice().kind)],
        limits.tip_force_N, limits.voltage_V, limits.tip_speed_m_per_s);
}

} // namespace

Kiosk::Kiosk(session::Session &session, std::filesystem::path log)
    : script_(session), log_(std::move(log)) {
    session.servo().lower_limits(servo::lowered(session.servo().inputs().limits, kiosk_limits()));
    log_.record(start_text(session));
}

void Kiosk::obey(const KeyPress &key) {
    const bool is_chord = key.with_ctrl && key.with_alt;
    if (is_chord && key.name == "q") {
        ending_ = KioskEnding::asked;
    }
    keys_.push_back(key);
}

void Kiosk::update(const KioskParts &parts, const Rectangle &view, const Window::LargeText &text) {
    // Unless the next frame comes in time, SIGALRM ends the process, whatever it waits for; its
    // service starts it again.
    alarm(kHung_s);
    session::Session &session = parts.stage.session;
    now_ = script_.now(session, boot_time_s());
    renew_read_out(parts);
    const KioskAnswer answer = draw_kiosk(shown(parts), parts.view.camera(), view, text);
    if (answer.stop) {
        session.emergency_stop();
    }
    if (answer.go_on) {
        session.servo().let_go_on();
        recovery_.begin_anew();
        log_.record("a person lets it go on");
    }
    note_visitor(parts, answer);
    for (const std::string &event : watch_.update(session, figures_)) {
        log_.record(event);
    }
    if (parts.frame_s < Course::kGap_s) {
        figures_.longest_frame_s = std::max(figures_.longest_frame_s, parts.frame_s);
    }
    if (const std::string &error = session.scenes().error(); error != error_) {
        error_ = error;
        log_.record(error);
    }
    recover(parts);
    carry_out(course_.update(now_), parts);
    if (const std::string error = script_.take_error(); !error.empty()) {
        log_.record(error);
    }
}

/// What the visitor did since the last frame.
void Kiosk::note_visitor(const KioskParts &parts, const KioskAnswer &answer) {
    const ImGuiIO &io = ImGui::GetIO();
    const bool presses = std::ranges::any_of(io.MouseDown, [](bool is_down) { return is_down; }) ||
                         std::ranges::any_of(io.MouseClicked, [](bool is_new) { return is_new; });
    bool switches = answer.other_map;
    bool types = false;
    for (const KeyPress &key : keys_) {
        types = types || !(key.with_ctrl && key.with_alt); // which are the staff's
        switches = switches || (key.name == "m" && !key.with_ctrl && !key.is_repeated);
        if (key.with_ctrl && key.with_alt && key.name == "z") {
            zero(parts.stage.session);
        }
    }
    now_.is_touched = presses || io.MouseWheel != 0.0F || types || answer.stop ||
                      tip_was_moved(parts.stage.session);
    keys_.clear();
    // A press that began the visit does not yet take the hand.
    now_.takes_hand = answer.my_turn || (course_.stage() == Stage::showing && io.MouseClicked[0] &&
                                         parts.view.holds_hand());
    now_.next_scene = answer.next_scene;
    now_.next_visitor = answer.next_visitor;
    if (switches && course_.stage() == Stage::your_turn) {
        parts.stage.editor.toggle_map();
    }
}

/// Of a real device, whose motors do not move it by themselves.
bool Kiosk::tip_was_moved(const session::Session &session) {
    if (session.hand().is_simulated() || is_lost(session) || !session.is_zeroed()) {
        rest_m_.reset();
        return false;
    }
    const Vector3 &tip_m = session.latest().tip_m;
    const bool has_moved = rest_m_ && (tip_m - *rest_m_).norm() > kTouched_m;
    if (!rest_m_ || has_moved) {
        rest_m_ = tip_m;
    }
    return has_moved;
}

void Kiosk::recover(const KioskParts &parts) {
    session::Session &session = parts.stage.session;
    RecoveryState now = recovery_of(session);
    now.time_s = now_.time_s;
    // The scripted hand finds its own way.
    now.is_inside = parts.is_inside && !now.is_touching && !course_.is_performing();
    now.hand_is_held = parts.view.holds_hand();
    switch (recovery_.update(now)) {
    case Remedy::none:
        break;
    case Remedy::reset:
        session.servo().reset_safety();
        break;
    case Remedy::retract_hand:
        // A path that the scripted hand was on is left by the course, and then soon at its end.
        if (session.hand().is_simulated() && !session.hand().follows_path() &&
            !parts.stage.lift.is_on()) {
            parts.stage.lift.start();
        }
        break;
    }
    if (session.servo().speed() < 1.0) {
        session.servo().set_speed(1.0);
    }
    if (is_stopped(session) && servo::is_final(now.cause) && !now.can_reach_a_hand &&
        !now.is_stop_held) {
        final_since_s_ = final_since_s_.value_or(now.time_s);
        if (now.time_s - *final_since_s_ >= kFinal_s) {
            ending_ = KioskEnding::start_again;
        }
    }
}

void Kiosk::zero(session::Session &session) {
    if (session.is_zeroed()) {
        return;
    }
    const std::string error = error_text_of([&] { session.zero_device(Vector3::Zero()); });
    log_.record(error.empty() ? "zeroed by hand" : error);
}

void Kiosk::carry_out(const CourseOrders &orders, const KioskParts &parts) {
    if (orders.gap_s > 0.0) {
        log_.record(fmt::format("no frame for {:.0f} s: the computer slept", orders.gap_s));
    }
    if (orders.visit_begins) {
        figures_.visitors = course_.visitors();
        log_.record(fmt::format("visitor {} begins", course_.visitors()));
    } else if (orders.resets) {
        log_.record("nobody is there");
    }
    if (orders.resets) {
        parts.stage.lift.stop();
        parts.view.look_from(Viewpoint::home);
    }
    if (orders.scene && course_.stage() != Stage::attract) {
        ++figures_.scenes;
        log_.record("scene " + std::string(kTour[*orders.scene].scene));
    }
    script_.carry_out(orders, course_, parts.stage, now_.time_s);
}

void Kiosk::renew_read_out(const KioskParts &parts) {
    const servo::ServoSample &now = parts.stage.session.latest();
    const record::ChannelStore &store = parts.stage.session.servo().history().store();
    constexpr double kFelt_N = 0.15; // a smaller force has no direction to speak of
    if (!now.contact.touching || now.safety.state != servo::SafetyState::running ||
        !(now.tip_force_N.norm() > kFelt_N) || store.is_empty()) {
        read_out_.reset();
        return;
    }
    const bool is_due = !read_out_ || now_.time_s >= next_read_out_s_;
    KioskReadOut fresh = read_out_.value_or(KioskReadOut{});
    fresh.arrow_from_m = now.contact.x0_m;
    fresh.arrow_m = fresh.arrow_from_m + kArrow.m_per_N * now.tip_force_N;
    if (is_due) {
        next_read_out_s_ = now_.time_s + kReadOut_s;
        fresh.force_N = now.tip_force_N.norm();
        const bool transposes = now.tuning.map == control::MotionMap::transpose;
        static const std::size_t kTransposed =
            session::channel_named("transpose_measured_rad").value();
        static const std::size_t kInverted = session::channel_named("inverse_measured_rad").value();
        const double angle_rad = store.value(transposes ? kTransposed : kInverted, store.end() - 1);
        fresh.angle_rad = std::isfinite(angle_rad) ? std::optional(angle_rad) : std::nullopt;
    }
    read_out_ = fresh;
}

KioskShown Kiosk::shown(const KioskParts &parts) const {
    const session::Session &session = parts.stage.session;
    const scene::Scene &scene = session.scenes().now().scene;
    KioskShown all{course_, recovery_};
    all.has_script = session.hand().is_simulated();
    if (script_.has_scene(session)) { // not yet while it is loaded
        all.title = scene.lesson.title;
        all.sentence = sentence_of(kTour[course_.scene()], scene);
    }
    all.stop = is_stopped(session) ? servo::description(session.latest().safety) : std::string();
    all.map = parts.stage.session.tuning().now().map;
    all.read_out = read_out_;
    return all;
}

void Kiosk::finish(const std::string &why) {
    if (!std::exchange(is_finished_, true)) {
        log_.record("end, " + why + ": " + summary_of(figures_));
    }
}

} // namespace springdrive::app::exhibit
