// Sessions in lockstep on the project's scenes, for tests of exchanges.
#pragma once

#include "engine/record/record_file.h"
#include "engine/scene/scripted_touch.h"
#include "engine/session/session.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace springdrive::testing {

inline constexpr double kFrame_s = 1.0 / 60.0;

inline session::SessionOptions scripted(const std::string &scene = "plate") {
    session::SessionOptions options;
    options.scene = assets() / "scenes" / (scene + ".gltf");
    options.device.file = assets() / "devices/phantom_1_0.toml";
    options.lockstep = true;
    options.plays_script = true;
    options.program_version = "of a test";
    return options;
}

/// The same on an emulated board, with a hand that is moved by request.
inline session::SessionOptions emulated(bool starts_at_zero = true,
                                        const std::vector<const char *> &faults = {}) {
    session::SessionOptions options = scripted();
    options.plays_script = false;
    options.device.kind = factory::DeviceKind::emulated;
    options.starts_at_zero = starts_at_zero;
    for (const char *const fault : faults) {
        options.emulation.faults.push_back(device::parse_fault(fault));
    }
    return options;
}

inline session::DeviceChoice premium() {
    session::DeviceChoice choice;
    choice.file = assets() / "devices/phantom_premium_1_5.toml";
    return choice;
}

inline void run(session::Session &session, double seconds) {
    for (int frame = 0; frame < static_cast<int>(std::round(seconds / kFrame_s)); ++frame) {
        session.advance(kFrame_s);
    }
}

/// Runs in frames of a few ticks. False if it takes too long, not counting the time for loading in
/// the background.
inline bool run_until(session::Session &session, const std::function<bool()> &is_so,
                      double at_most_s) {
    constexpr double kShort_s = 0.004;
    double passed_s = 0.0;
    while (!is_so() && passed_s < at_most_s) {
        session.advance(kShort_s);
        const bool waits = session.scenes().is_loading();
        passed_s += waits ? 0.0 : kShort_s;
        if (waits || !session.servo().is_in_lockstep()) {
            std::this_thread::sleep_for(std::chrono::duration<double>(kShort_s));
        }
    }
    return is_so();
}

inline bool run_until_state(session::Session &session, servo::SafetyState state, double at_most_s) {
    return run_until(
        session, [&] { return session.latest().safety.state == state; }, at_most_s);
}

inline bool run_until_exchanged(session::Session &session, double at_most_s = 5.0) {
    return run_until(
        session, [&] { return !session.is_exchanging(); }, at_most_s);
}

inline bool run_into_contact(session::Session &session) {
    return run_until(
        session,
        [&] {
            const servo::ServoSample &now = session.latest();
            return now.contact.touching && now.safety.state == servo::SafetyState::running &&
                   now.command.e_W_V.norm() > 0.15 && !session.is_exchanging() &&
                   now.scene_id == session.scenes().id();
        },
        20.0);
}

/// The same with a moved hand: it lifts the tip above the shown scene, waits until the motors are
/// driven, and presses.
inline bool press(session::Session &session) {
    const session::LoadedScene &scene = session.scenes().now();
    simulated::HandPath touch(scene::scripted_touch(session.description(), scene.surface,
                                                    scene.scene.lower_m, scene.scene.upper_m));
    const Vector3 above_m = touch.points().front().position_m;
    session.hand().move_to(above_m);
    const auto stands = [&] {
        return (session.latest().tip_m - above_m).norm() < 5e-3 &&
               session.latest().safety.state == servo::SafetyState::running;
    };
    if (!run_until(session, stands, 20.0)) {
        return false;
    }
    session.hand().move_to(touch.at(2.0).position_m);
    return run_into_contact(session);
}

/// Runs until background loading is complete and the scene is in use.
inline bool run_until_loaded(session::Session &session) {
    while (session.scenes().is_loading()) {
        session.advance(0.001);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return run_until(
        session, [&] { return session.latest().scene_id == session.scenes().id(); }, 1.0);
}

/// How many of the sixty frames after the first 2.7 s of the scripted touch end in contact.
inline int frames_in_contact(session::Session &session) {
    session.start();
    run(session, 2.7);
    int touching = 0;
    for (int frame = 0; frame < 60; ++frame) {
        session.advance(kFrame_s);
        const servo::ServoSample &now = session.latest();
        touching += now.contact.touching ? 1 : 0;
        // The tip stays where a finger could have pushed it: near its proxy.
        EXPECT_LT((now.tip_m - now.contact.x0_m).norm(), 0.01);
    }
    EXPECT_EQ(session.latest().safety.state, servo::SafetyState::running)
        << servo::description(session.latest().safety);
    return touching;
}

/// The notes of a record, one after another.
inline std::string notes_in(const std::filesystem::path &file) {
    std::string notes;
    record::RecordReader(file).for_each([](const servo::ServoSample &) {},
                                        [&](std::string_view note) { notes += note; });
    return notes;
}

} // namespace springdrive::testing
