// Covers engine/session with the servo on its own thread: whatever the hand, the panels, the loader
// and the recorder do, that thread neither allocates nor locks, and makes no system calls except to
// read the clock and to sleep.
#include "base/real_time_thread.h"
#include "device/usb/driver/board_port.h"
#include "engine/control/tuning.h"
#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/session/session.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/real_time_watch.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <future>
#include <string>
#include <thread>

namespace springdrive::session {
namespace {

using testing::watched;

constexpr std::array kScenes{"sphere", "stepped_block", "organic", "compliance", "plate"};
constexpr auto kTimeout = std::chrono::seconds(30);

void expect_nothing_caught() {
    EXPECT_TRUE(watched().has_filter);
    EXPECT_EQ(watched().allocations, 0);
    EXPECT_EQ(watched().locks, 0);
    EXPECT_EQ(watched().system_call, -1) << "the number of the system call";
}

/// Runs until `is_so`, a timeout, or the servo is caught; the caller determines which.
template <typename Step> bool step_until(const std::function<bool()> &is_so, Step &&step) {
    const auto end = std::chrono::steady_clock::now() + kTimeout;
    while (!is_so()) {
        if (watched().system_call != -1 || std::chrono::steady_clock::now() > end) {
            return false;
        }
        step();
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
}

SessionOptions options(const std::string &scene) {
    SessionOptions chosen;
    chosen.scene = testing::assets() / "scenes" / (scene + ".gltf");
    chosen.device.file = testing::assets() / "devices/phantom_1_0.toml";
    return chosen;
}

/// A session whose servo is watched, and a hand to touch with.
class Touch {
public:
    explicit Touch(const SessionOptions &chosen) : session_(chosen) {
        session_.start(testing::watch_this_thread_for_good);
    }

    Session &session() { return session_; }
    [[nodiscard]] const servo::ServoSample &latest() const { return session_.latest(); }

    bool until(const std::function<bool()> &is_so) {
        return step_until(is_so, [this] { session_.advance(2e-3); });
    }
    void ticks(std::uint64_t number) {
        const std::uint64_t end = latest().tick + number;
        EXPECT_TRUE(until([&] { return latest().tick >= end; }));
    }

    /// Lifts the tip, resets a trip if there is one, and waits until the motors are driven.
    void stand_above() {
        const Vector3 above_m = path().at(0.0).position_m;
        session_.hand().move_to(above_m);
        EXPECT_TRUE(until([&] { return (latest().tip_m - above_m).norm() < 5e-3; }));
        if (latest().safety.state == servo::SafetyState::tripped) {
            session_.servo().let_go_on();
        }
        EXPECT_TRUE(until([&] { return latest().safety.state == servo::SafetyState::running; }));
    }
    void press() {
        session_.hand().move_to(path().at(2.0).position_m);
        EXPECT_TRUE(until([&] {
            return latest().contact.touching && latest().scene_id == session_.scenes().id();
        })) << session_.scenes().now().scene.file;
        ticks(100);
    }
    /// Recovers after an attempt to destabilise it.
    void recover() {
        if (latest().safety.state == servo::SafetyState::tripped) {
            stand_above();
            press();
        }
    }

    void switch_to(const std::string &scene) {
        const std::uint32_t next = session_.scenes().id() + 1;
        session_.request_scene(testing::assets() / "scenes" / (scene + ".gltf"));
        EXPECT_TRUE(until([&] { return latest().scene_id == next; })) << scene;
        ticks(50);
    }

private:
    [[nodiscard]] simulated::HandPath path() const {
        const LoadedScene &loaded = session_.scenes().now();
        return *rig::scripted_touch_scenario(
                    {session_.description(), {}},
                    rig::placed(loaded.surface, loaded.scene.lower_m, loaded.scene.upper_m))
                    .simulation.path;
    }

    Session session_;
};

void touch_every_scene(Touch &touch) {
    for (const char *scene : kScenes) {
        touch.switch_to(scene); // in contact with the previous one
        touch.stand_above();
        touch.press();
    }
}

void turn_every_knob(Touch &touch) {
    for (const control::MotionMap map :
         {control::MotionMap::inverse, control::MotionMap::transpose}) {
        for (const control::AlphaMode mode :
             {control::AlphaMode::on_the_fly, control::AlphaMode::global,
              control::AlphaMode::by_hand}) {
            control::Tuning tuning;
            tuning.map = map;
            tuning.alpha_mode = mode;
            touch.session().tuning().change(tuning, touch.session().plot_time_s());
            touch.ticks(60);
        }
    }
    for (const control::Parameter &parameter : control::kParameters) {
        for (const double value : {parameter.minimum, parameter.maximum}) {
            control::Tuning tuning;
            tuning.*parameter.value = value;
            touch.session().tuning().change(tuning, touch.session().plot_time_s());
            touch.ticks(100);
        }
        touch.session().tuning().change({}, touch.session().plot_time_s());
        touch.recover();
    }
}

void lower_and_raise_every_limit(Touch &touch) {
    for (const servo::SafetyLimit &limit : servo::kSafetyLimits) {
        servo::SafetyLimits lower = servo::unlowered();
        lower.*limit.value = 0.7 * servo::limits_of(touch.session().description()).*limit.value;
        touch.session().servo().lower_limits(lower);
        touch.ticks(40);
        touch.session().servo().lower_limits(servo::unlowered());
        touch.ticks(10);
    }
    touch.recover();
}

void trip(Touch &touch, const std::function<void()> &how, servo::TripCause cause) {
    how();
    EXPECT_TRUE(touch.until([&] { return touch.latest().safety.cause == cause; }));
    touch.session().servo().lower_limits(servo::unlowered());
    touch.stand_above();
    touch.press();
}

void trip_and_reset(Touch &touch) {
    Session &session = touch.session();
    trip(
        touch, [&] { session.servo().emergency_stop(); }, servo::TripCause::emergency_stop);
    servo::SafetyLimits weak = servo::unlowered();
    weak.tip_force_N = 0.05;
    trip(
        touch, [&] { session.servo().lower_limits(weak); }, servo::TripCause::tip_force);
}

/// What reaches the simulated device by its mailboxes; delays and paths are set while it is paused.
void change_the_plant(Touch &touch) {
    Session &session = touch.session();
    for (const simulated::PlantEffect &effect : simulated::kPlantEffects) {
        for (int times = 0; times < 2; ++times) {
            simulated::PlantEffects effects = session.simulation().effects;
            effects.*effect.on = !(effects.*effect.on);
            session.set_effects(effects);
            touch.ticks(20);
        }
    }
    for (const double stiffness_N_per_m : {30.0, 3000.0, 300.0}) {
        device::HandParameters hand = session.simulation().hand;
        hand.stiffness_N_per_m = stiffness_N_per_m;
        session.set_hand(hand);
        touch.ticks(50);
    }
    simulated::HandStimulus stimulus;
    stimulus.kind = simulated::StimulusKind::chirp;
    stimulus.amplitude_m = 0.001;
    session.hand().play(stimulus);
    touch.ticks(100);
    touch.recover();
}

class RealTimeSession : public ::testing::Test {
protected:
    void SetUp() override {
        if (!testing::can_filter_system_calls()) {
            GTEST_SKIP() << "this kernel does not support filtering system calls (seccomp)";
        }
    }
};

TEST_F(RealTimeSession, NoActionMakesTheServoAllocateLockOrCall) {
    const std::filesystem::path folder = testing::fresh_folder("real_time_session");
    const bool holds = testing::holds_in_a_child([&] {
        Touch touch(options("plate"));
        touch.stand_above();
        touch.session().start_recording(folder / "scenes.rec");
        touch.press();
        touch_every_scene(touch);
        turn_every_knob(touch);
        touch.session().recording().stop();
        touch.session().start_recording(folder / "safety.rec");
        change_the_plant(touch);
        lower_and_raise_every_limit(touch);
        trip_and_reset(touch);
        touch.session().recording().stop();
        EXPECT_EQ(touch.session().recording().status().error, "");
        EXPECT_GT(touch.session().recording().status().rows, 1000U);
        expect_nothing_caught();
        testing::end_this_child();
    });
    EXPECT_TRUE(holds);
}

TEST_F(RealTimeSession, NeitherDoesAHandOnAPathAtTheMaximumRate) {
    const std::filesystem::path folder = testing::fresh_folder("real_time_path");
    const bool holds = testing::holds_in_a_child([&] {
        SessionOptions chosen = options("organic");
        chosen.plays_script = true;
        chosen.servo_hz = 4000.0;
        chosen.delay_periods = 1;
        chosen.effects.structural_compliance = true;
        chosen.record = folder / "path.rec";
        Touch touch(chosen);
        EXPECT_TRUE(touch.until([&] { return touch.latest().contact.touching; }));
        touch.ticks(2000);
        touch.session().recording().stop();
        expect_nothing_caught();
        testing::end_this_child();
    });
    EXPECT_TRUE(holds);
}

/// With packets that are lost, repeated and damaged. Nothing may pause the servo: a watched thread
/// cannot end.
TEST_F(RealTimeSession, NeitherDoesAnEmulatedBoard) {
    const bool holds = testing::holds_in_a_child([&] {
        SessionOptions chosen = options("plate");
        chosen.device.kind = factory::DeviceKind::emulated;
        chosen.starts_at_zero = true;
        chosen.delay_periods = chosen.emulation.delay_periods; // so that d need not be adopted
        for (const char *fault : {"drop:in:0.01", "repeat:in:0.01", "corrupt:in:0.01"}) {
            chosen.emulation.faults.push_back(device::parse_fault(fault));
        }
        Touch touch(chosen);
        touch.stand_above();
        touch.press();
        touch.ticks(1000);
        expect_nothing_caught();
        testing::end_this_child();
    });
    EXPECT_TRUE(holds);
}

/// Each real-time thread of a session allocates, if it does, where no other thread does, nor did:
/// no lock of the heap that it takes is ever held by the loading of a scene.
TEST(RealTimeHeaps, NoRealTimeThreadAllocatesWhereAnotherThreadDoes) {
    const bool holds = testing::holds_in_a_child([] {
        testing::watch_heaps();
        EXPECT_TRUE(reserve_heaps());
        SessionOptions chosen = options("plate");
        chosen.device.kind = factory::DeviceKind::emulated;
        chosen.starts_at_zero = true;
        Session session(chosen); // threads that load a scene have ended already
        session.start();
        const auto until = [&](const std::function<bool()> &is_so) {
            return step_until(is_so, [&] { session.advance(2e-3); });
        };
        const auto allocate = [] {
            void *volatile memory = std::calloc(1, 64); // NOLINT: as libusb for a transfer
            std::free(memory);                          // NOLINT
        };
        watched().shared_allocations = 0; // before its first tick, the servo's thread may
        // As a board's port, which needs a board.
        std::atomic<bool> ends{false};
        std::future<void> port = run_on_own_heap([&] {
            static_cast<void>(request_priority(usb::kPortThreadPriority));
            while (!ends) {
                allocate();
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
        });
        for (const char *scene : {"organic", "sphere"}) {
            const std::uint32_t next = session.scenes().id() + 1;
            session.request_scene(testing::assets() / "scenes" / (std::string(scene) + ".gltf"));
            EXPECT_TRUE(until([&] { return session.scenes().id() == next; })) << scene;
        }
        std::atomic<int> ticks{0};
        session.begin_exclusive_use([&] {
            allocate();
            return ++ticks < 50;
        });
        EXPECT_TRUE(until([&] { return ticks >= 50; }));
        ends = true;
        port.wait();
        EXPECT_GE(watched().allocating_threads, 2);
        EXPECT_EQ(watched().shared_allocations, 0);
        session.stop();
        testing::end_this_child();
    });
    EXPECT_TRUE(holds);
}

TEST(RealTimeEmulation, NeitherAllocatesNorLocksWhateverFailsUpToThePulledCable) {
    factory::EmulationOptions options;
    for (const char *fault : {"drop:in:0.05", "delay:out:0.05:2", "repeat:in:0.05",
                              "reorder:in:0.05", "corrupt:in:0.05", "truncate:out:0.05",
                              "reversed-encoder:1@0.2-0.3", "restart@0.5", "unplug@0.7"}) {
        options.faults.push_back(device::parse_fault(fault));
    }
    factory::EmulatedDevice device(testing::phantom_1_0(), 1e-3, options, {});
    bool was_lost = false;
    const int before = watched().allocations + watched().locks;
    {
        const testing::CountingWatch watch;
        for (int tick = 0; tick < 1000; ++tick) {
            const device::Measurement measured = device.read();
            was_lost = was_lost || measured.health == device::DeviceHealth::lost;
            device::DeviceCommand command;
            command.number = measured.number;
            device.write(command);
        }
    }
    EXPECT_EQ(watched().allocations + watched().locks, before);
    EXPECT_TRUE(was_lost);
    EXPECT_GT(device.board().time_s(), 0.95); // passes without the cable, too
}

} // namespace
} // namespace springdrive::session
