// Covers that a tick allocates nothing, locks nothing and makes no system call: servo_loop.cpp and
// all that it calls, engine/study/stimuli, and the thread of servo.cpp, which only computes, sleeps
// and reads the clock. Also real_time.cpp: what the system grants a thread, and the warnings if it
// refuses.
#include "base/assertions.h"
#include "base/input_error.h"
#include "device/core/haptic_device.h"
#include "device/simulated/simulated_phantom.h"
#include "device/simulated/simulation_options.h"
#include "engine/contact/mesh/triangle_soup.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/lab/rig/servo_rig.h"
#include "engine/servo/real_time.h"
#include "engine/servo/servo.h"
#include "engine/session/loaded_scene.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/stimulus_trial.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/stimuli/stimulus.h"
#include "engine/study/stimuli/warm_up.h"
#include "tests/support/devices.h"
#include "tests/support/real_time_watch.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <linux/capability.h>
#include <linux/futex.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace springdrive::servo {
namespace {

std::unique_ptr<session::LoadedScene> scene_named(const std::string &name,
                                                  const device::DeviceDescription &description) {
    scene::LoadProgress progress;
    return session::load_scene(testing::assets() / "scenes" / (name + ".gltf"),
                               description.workspace, progress);
}

/// A scene of the project, touched by the scripted hand.
class TouchedScene {
public:
    TouchedScene(const std::string &scene_name, control::MotionMap map,
                 control::AlphaMode alpha_mode)
        : scene_(scene_named(scene_name, description_)), closed_loop(scenario()) {
        closed_loop.inputs.tuning.map = map;
        closed_loop.inputs.tuning.alpha_mode = alpha_mode;
        closed_loop.inputs.global_alpha_rad2_per_m2 = 3000.0;
    }

    /// Ticks in contact among `ticks`; trips and resets on the way.
    int run(int ticks) {
        int touching = 0;
        for (int i = 0; i < ticks; ++i) {
            closed_loop.inputs.requested_stop = i >= ticks - 200 ? 1U : 0U;
            closed_loop.inputs.released_stop = i > ticks - 100 ? 1U : 0U;
            closed_loop.inputs.reset_count = closed_loop.inputs.released_stop;
            touching += closed_loop.tick().contact.touching ? 1 : 0;
        }
        return touching;
    }

    [[nodiscard]] rig::Scenario scenario() const {
        return rig::scripted_touch_scenario(
            {description_, {}},
            rig::placed(scene_->surface, scene_->scene.lower_m, scene_->scene.upper_m));
    }

private:
    device::DeviceDescription description_ = testing::phantom_1_0();
    std::unique_ptr<session::LoadedScene> scene_;

public:
    rig::ServoRig closed_loop;
};

constexpr int kTicks = 3000; // of which 1200 before the hand starts to move

template <typename Check> void for_every_scene(Check &&check) {
    for (const char *scene : {"plate", "sphere", "stepped_block", "organic", "compliance"}) {
        for (const control::MotionMap map :
             {control::MotionMap::inverse, control::MotionMap::transpose}) {
            for (const control::AlphaMode mode :
                 {control::AlphaMode::on_the_fly, control::AlphaMode::global,
                  control::AlphaMode::by_hand, control::AlphaMode::at_touch}) {
                TouchedScene touched(scene, map, mode);
                check(touched, scene);
            }
        }
    }
}

/// Expects that `work` neither allocates nor locks.
template <typename Work> void expect_quiet(Work &&work) {
    testing::watched().allocations = 0;
    testing::watched().locks = 0;
    {
        const testing::CountingWatch watch;
        work();
    }
    EXPECT_EQ(testing::watched().allocations, 0);
    EXPECT_EQ(testing::watched().locks, 0);
}

TEST(RealTime, ATickAllocatesAndLocksNothing) {
    for_every_scene([](TouchedScene &touched, const char *scene) {
        SCOPED_TRACE(scene);
        int touching = 0;
        expect_quiet([&] { touching = touched.run(kTicks); });
        EXPECT_GT(touching, 500);
    });
}

/// A turned press in a friction cup, from rest in free space until the hand has left.
TEST(RealTime, APresentedStimulusAllocatesAndLocksNothing) {
    const std::filesystem::path protocols = testing::assets() / "protocols";
    const study::Protocol protocol = study::read_protocol_file(protocols / "direction.toml");
    const study::StudySetting setting =
        study::study_setting(protocol, {protocols, testing::assets()});
    study::Presented presented = study::all_presented(protocol).front();
    presented.parameters.turn_deg = 30.0;
    const study::Stimulus stimulus = study::stimulus_of(protocol, setting, presented);
    const study::HandTrajectory trajectory =
        study::hand_trajectory(setting, presented, stimulus, {});
    simulated::SimulationOptions options;
    options.path.emplace(trajectory.points);
    simulated::SimulatedPhantom phantom(setting.device, options,
                                        trajectory.points.front().position_m);
    servo::Servo servo(phantom, 1.0 / options.servo_period_s);
    study::LiveStimulus live(setting.device, stimulus, options.servo_period_s);
    servo::ServoInputs inputs;
    inputs.tuning = presented.free_space;
    inputs.surface = setting.conditions[presented.condition].surface.get();
    inputs.schedule = &live;
    servo.publish(inputs);
    const auto ticks = std::lround(trajectory.points.back().time_s / options.servo_period_s);
    expect_quiet([&] { servo.advance(static_cast<int>(ticks)); });
    EXPECT_EQ(live.phase(), study::StimulusPhase::done) << description(live.failure());
    EXPECT_NEAR(live.delivered().measures.turn_deg.value(), 30.0, 1.0); // the protocol's band
}

TEST(RealTime, AWarmUpAllocatesAndLocksNothing) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const simulated::SimulationOptions options;
    rig::ServoRig rig(device, options, {0.0, 0.03, 0.0});
    rig.run(1.5);
    study::WarmUp warm_up(device, {25.0, 25.2, 60.0}, options.servo_period_s);
    expect_quiet([&] {
        for (long tick = 0; tick < 120'000 && !warm_up.is_over(); ++tick) {
            warm_up.update(rig.tick(), rig.inputs);
        }
    });
    EXPECT_EQ(warm_up.phase(), study::WarmUpPhase::done) << description(warm_up.failure());
}

TEST(RealTime, ATickThatSwitchesThePlantAllocatesAndLocksNothing) {
    TouchedScene touched("plate", control::MotionMap::transpose, control::AlphaMode::on_the_fly);
    for (const simulated::PlantModel &model : simulated::kPlantModels) {
        simulated::SimulationOptions options = touched.scenario().simulation;
        options.dynamics = model.dynamics;
        options.effects = model.effects;
        touched.closed_loop.phantom().simulate_as(options);
        expect_quiet([&] { touched.run(300); });
    }
}

TEST(RealTime, AProxyOnShapesAndWithFrictionAllocatesAndLocksNothing) {
    using Size = contact::AnalyticShape::Size;
    for (const Size &size :
         {Size(contact::Plate{0.03, 0.03}), Size(contact::Sphere{0.02}),
          Size(contact::Box{Vector3::Constant(0.02)}), Size(contact::Cylinder{0.02, 0.01}),
          Size(contact::Capsule{0.02, 0.01})}) {
        contact::TriangleSoup soup;
        soup.materials = {{"rough", 0.0, 0.4, 0.3}};
        const contact::HapticSurface surface(
            soup, {contact::AnalyticShape(size, Eigen::Isometry3d::Identity(), 0)});
        contact::Proxy proxy(0.5e-3);
        proxy.reset({0.0, 0.05, 0.0});
        int touching = 0;
        expect_quiet([&] {
            for (int i = 0; i < kTicks; ++i) {
                const double t = 0.01 * i;
                const Vector3 tip(0.015 * std::sin(t), 0.01 + 0.04 * std::cos(3.0 * t),
                                  0.015 * std::cos(0.7 * t));
                touching += proxy.update(surface, tip).touching ? 1 : 0;
            }
        });
        EXPECT_GT(touching, 100);
    }
}

/// Runs in a child that is killed by any system call but read, write and exit.
int exit_status_without_system_calls(TouchedScene &touched, bool call_one) {
    const pid_t child = fork();
    if (child == 0) {
        if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0) {
            _exit(77);
        }
        touched.run(kTicks);
        if (call_one) {
            syscall(SYS_getpid);
        }
        syscall(SYS_exit, 0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

TEST(RealTime, ATickMakesNoSystemCall) {
    TouchedScene one_call("plate", control::MotionMap::transpose, control::AlphaMode::on_the_fly);
    const int killed = exit_status_without_system_calls(one_call, true);
    if (killed == 77) {
        GTEST_SKIP() << "this kernel has no seccomp";
    }
    ASSERT_EQ(killed, -SIGKILL); // the filter works
    for_every_scene([](TouchedScene &touched, const char *scene) {
        EXPECT_EQ(exit_status_without_system_calls(touched, false), 0) << scene;
    });
}

using testing::watched;

constexpr int kNone = -1;
constexpr auto kTimeout = std::chrono::seconds(30);

/// Ends this child when the servo has done enough or was caught, after a final `check`.
template <typename IsEnough, typename Check>
[[noreturn]] void run_watched(Servo &servo, const contact::HapticSurface *surface,
                              IsEnough &&is_enough, Check &&check) {
    ServoInputs inputs;
    inputs.surface = surface;
    servo.publish(inputs);
    servo.feed_recorder(true);
    servo.start({{}, testing::watch_this_thread_for_good});
    const auto end = std::chrono::steady_clock::now() + kTimeout;
    bool enough = false;
    while (!enough && watched().system_call == kNone && std::chrono::steady_clock::now() < end) {
        servo.drain([&](const ServoSample &sample) { enough = enough || is_enough(sample); });
        servo.record_ring().drain([](const ServoSample & /*sample*/) {});
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    EXPECT_TRUE(watched().has_filter);
    check(enough);
    testing::end_this_child();
}

void expect_nothing_seen() {
    EXPECT_EQ(watched().allocations, 0);
    EXPECT_EQ(watched().locks, 0);
    EXPECT_EQ(watched().system_call, kNone);
}

class RealTimeServo : public ::testing::Test {
protected:
    void SetUp() override {
        if (!testing::can_filter_system_calls()) {
            GTEST_SKIP() << "this kernel does not support filtering system calls (seccomp)";
        }
    }
};

TEST_F(RealTimeServo, NeitherAllocatesNorLocksNorCallsWithAMillionTriangles) {
    const contact::HapticSurface surface(*rig::test_surface_named("sphere:1310720"));
    const bool holds = testing::holds_in_a_child([&] {
        const Vector3 upper_m = Vector3::Constant(rig::kTestSphereRadius_m);
        const rig::Scenario scenario = rig::scripted_touch_scenario(
            {testing::phantom_1_0(), {}}, rig::placed(surface, -upper_m, upper_m));
        simulated::SimulatedPhantom device(scenario.device, scenario.simulation, scenario.start_m);
        Servo servo(device, 1000.0);
        int touching = 0;
        run_watched(
            servo, &surface,
            [&](const ServoSample &sample) {
                touching += sample.contact.touching ? 1 : 0;
                return touching > 500;
            },
            [](bool enough) {
                EXPECT_TRUE(enough);
                expect_nothing_seen();
            });
    });
    EXPECT_TRUE(holds);
}

/// A device whose driver performs an action on the servo's thread in its twentieth tick.
class Driver final : public device::ForwardingDevice {
public:
    explicit Driver(std::function<void()> action)
        : device::ForwardingDevice(std::make_unique<simulated::SimulatedPhantom>(
              testing::phantom_1_0(), simulated::SimulationOptions{},
              testing::phantom_1_0().workspace.centre_m)),
          action_(std::move(action)) {}

    [[nodiscard]] device::Measurement read() noexcept override {
        if (++ticks_ == 20) {
            action_();
        }
        return device::ForwardingDevice::read();
    }

private:
    std::function<void()> action_;
    int ticks_ = 0;
};

struct DriverAction {
    const char *name;
    std::function<void()> act;
    long system_call = kNone; ///< that it makes
};

/// Runs a servo whose driver performs `action`, and checks what the watch has seen.
template <typename Check> bool holds_for(const DriverAction &action, Check &&check) {
    return testing::holds_in_a_child([&] {
        Driver driver(action.act);
        Servo servo(driver, 1000.0);
        run_watched(
            servo, nullptr, [](const ServoSample &sample) { return sample.tick > 40; },
            [&](bool enough) {
                EXPECT_TRUE(enough || watched().system_call != kNone);
                check();
            });
    });
}

TEST_F(RealTimeServo, NeitherAllocatesNorLocksNorCallsAfterAFailedAssertion) {
    const bool holds = testing::holds_in_a_child([] {
        Driver driver([] { SPRINGDRIVE_ASSERT(watched().locks < 0); });
        Servo servo(driver, 1000.0);
        run_watched(
            servo, nullptr,
            [](const ServoSample &sample) {
                return sample.tick > 40 && sample.safety.cause == TripCause::assertion;
            },
            [](bool enough) {
                EXPECT_TRUE(enough);
                expect_nothing_seen();
            });
    });
    EXPECT_TRUE(holds);
}

// Each call that the watch replaces or filters, or nothing above would be seen, whatever the servo
// did.

TEST_F(RealTimeServo, TheWatchDetectsAllocations) {
    static std::atomic<void *> kept = nullptr; // otherwise the compiler may omit the allocation
    static std::atomic<void *> none = nullptr;
    static auto *old = new std::vector<char>(100);
    const std::array actions{
        DriverAction{"malloc", [] { kept = std::malloc(1); }},                    // NOLINT
        DriverAction{"calloc", [] { kept = std::calloc(1, 1); }},                 // NOLINT
        DriverAction{"realloc", [] { kept = std::realloc(none, 1); }},            // NOLINT
        DriverAction{"aligned_alloc", [] { kept = std::aligned_alloc(64, 64); }}, // NOLINT
        DriverAction{"new", [] { kept = new char; }},                             // NOLINT
        DriverAction{"free", [] { std::free(none); }},                            // NOLINT
        DriverAction{"a vector that grows", [] { old->resize(1000); }},
        DriverAction{"a vector that goes", [] { delete old; }}, // NOLINT
    };
    for (const DriverAction &action : actions) {
        const bool seen = holds_for(action, [] { EXPECT_GT(watched().allocations, 0); });
        EXPECT_TRUE(seen) << action.name;
    }
}

TEST_F(RealTimeServo, TheWatchDetectsLocks) {
    static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
    static pthread_rwlock_t lock = PTHREAD_RWLOCK_INITIALIZER;
    static std::mutex standard;
    const std::array actions{
        DriverAction{"a mutex", [] { pthread_mutex_lock(&mutex); }},
        DriverAction{"a mutex tried", [] { static_cast<void>(pthread_mutex_trylock(&mutex)); }},
        DriverAction{"a lock to read", [] { pthread_rwlock_rdlock(&lock); }},
        DriverAction{"a lock to write", [] { pthread_rwlock_wrlock(&lock); }},
        DriverAction{"C++'s own", [] { const std::lock_guard guard(standard); }},
    };
    for (const DriverAction &action : actions) {
        const bool seen = holds_for(action, [] { EXPECT_EQ(watched().locks, 1); });
        EXPECT_TRUE(seen) << action.name;
    }
}

TEST_F(RealTimeServo, TheWatchDetectsSystemCalls) {
    static int word = 0;
    const std::array actions{
        DriverAction{"write", [] { static_cast<void>(write(STDOUT_FILENO, "!", 1) == 1); },
                     SYS_write},
        DriverAction{"wake", [] { syscall(SYS_futex, &word, FUTEX_WAKE, 1); }, SYS_futex},
        DriverAction{"yield", [] { sched_yield(); }, SYS_sched_yield},
        DriverAction{"open", [] { static_cast<void>(open("/dev/null", O_RDONLY)); }, SYS_openat},
        DriverAction{"control", [] { ioctl(0, FIONREAD, &word); }, SYS_ioctl},
        DriverAction{"map",
                     [] {
                         static_cast<void>(
                             mmap(nullptr, 1, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
                     },
                     SYS_mmap},
        DriverAction{"unmap", [] { munmap(nullptr, 1); }, SYS_munmap},
        DriverAction{"break", [] { syscall(SYS_brk, nullptr); }, SYS_brk},
        DriverAction{"advise", [] { madvise(nullptr, 1, MADV_NORMAL); }, SYS_madvise},
        DriverAction{"ask", [] { getppid(); }, SYS_getppid},
    };
    for (const DriverAction &action : actions) {
        const bool seen =
            holds_for(action, [&] { EXPECT_EQ(watched().system_call, action.system_call); });
        EXPECT_TRUE(seen) << action.name;
    }
}

std::vector<int> allowed_processors() {
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    sched_getaffinity(0, sizeof allowed, &allowed);
    std::vector<int> processors;
    for (int i = 0; i < CPU_SETSIZE; ++i) {
        if (CPU_ISSET(static_cast<std::size_t>(i), &allowed)) {
            processors.push_back(i);
        }
    }
    return processors;
}

/// Drops privileges to an ordinary user with the limits of a fresh installation.
bool give_up_rights() {
    const rlimit none{0, 0};
    const rlimit little{65'536, 65'536};
    __user_cap_header_struct head{_LINUX_CAPABILITY_VERSION_3, 0};
    __user_cap_data_struct nothing[2]{}; // NOLINT(modernize-avoid-c-arrays)
    return setrlimit(RLIMIT_RTPRIO, &none) == 0 && setrlimit(RLIMIT_MEMLOCK, &little) == 0 &&
           syscall(SYS_capset, &head, nothing) == 0;
}

/// The text that `says` returns in a child process.
std::string said_elsewhere(const std::function<std::string()> &says) {
    int ends[2]{}; // NOLINT(modernize-avoid-c-arrays)
    EXPECT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    if (child == 0) {
        const std::string said = says();
        _exit(write(ends[1], said.data(), said.size()) < 0 ? 1 : 0);
    }
    close(ends[1]);
    std::string said;
    char letter = 0;
    while (read(ends[0], &letter, 1) == 1) {
        said += letter;
    }
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
    return said;
}

TEST(Rights, EachRefusalIsReportedWithItsRemedy) {
    const std::string said = said_elsewhere([] {
        std::string all;
        if (!give_up_rights()) {
            return std::string("rights stay");
        }
        for (const std::string &warning : make_this_thread_real_time(std::nullopt)) {
            all += warning + "\n";
        }
        return all;
    });
    const std::string priority = "no real-time priority, ticks may come late (Operation not "
                                 "permitted); springdrive doctor has the line that permits it\n";
    const std::string memory =
        "memory may be paged out, ticks may come late; springdrive doctor has "
        "the line that permits it\n";
    EXPECT_EQ(said.substr(0, priority.size()), priority);
    EXPECT_NE(said.find(memory), std::string::npos) << said;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 2) << said;
}

TEST(Rights, AThreadStaysOnTheGivenProcessor) {
    for (const int cpu : allowed_processors()) {
        EXPECT_NO_THROW(check_cpu(cpu));
        const std::string said = said_elsewhere([cpu] {
            static_cast<void>(make_this_thread_real_time(cpu));
            std::string processors;
            for (const int allowed : allowed_processors()) {
                processors += std::to_string(allowed) + " ";
            }
            return processors;
        });
        EXPECT_EQ(said, std::to_string(cpu) + " ");
    }
}

TEST(Rights, AMissingProcessorIsRejectedByNumber) {
    for (const int cpu : {-1, 1023, 1024, 1'000'000}) {
        const std::string said = error_text_of([cpu] { check_cpu(cpu); });
        EXPECT_EQ(said.find("--cpu " + std::to_string(cpu) + ": this process may run on "), 0U)
            << said;
    }
    const std::string said = said_elsewhere([] {
        std::string all;
        for (const std::string &warning : make_this_thread_real_time(1023)) {
            all += warning + "\n";
        }
        return all;
    });
    EXPECT_NE(said.find("processor 1023 was refused"), std::string::npos) << said;
}

} // namespace
} // namespace springdrive::servo
