// Covers engine/servo/servo_loop.cpp and all that it calls: a tick allocates nothing, locks
// nothing and makes no system call. A program of its own, since it takes malloc's place.
#include "app/session.h"
#include "engine/contact/proxy.h"
#include "engine/scenario/scripted_touch.h"
#include "engine/servo/servo_loop.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <dlfcn.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace {

thread_local bool watched = false;
std::atomic<int> allocations{0};
std::atomic<int> locks{0};

void count(std::atomic<int> &counter) {
    if (watched) {
        ++counter;
    }
}

} // namespace

// glibc's own allocator behind names that we take. The sanitizers take them themselves.
extern "C" {
void *__libc_malloc(std::size_t size);                      // NOLINT
void *__libc_calloc(std::size_t count, std::size_t size);   // NOLINT
void *__libc_realloc(void *memory, std::size_t size);       // NOLINT
void *__libc_memalign(std::size_t align, std::size_t size); // NOLINT
void __libc_free(void *memory);                             // NOLINT

void *malloc(std::size_t size) {
    count(allocations);
    return __libc_malloc(size);
}
void *calloc(std::size_t number, std::size_t size) {
    count(allocations);
    return __libc_calloc(number, size);
}
void *realloc(void *memory, std::size_t size) {
    count(allocations);
    return __libc_realloc(memory, size);
}
void *aligned_alloc(std::size_t align, std::size_t size) {
    count(allocations);
    return __libc_memalign(align, size);
}
void free(void *memory) {
    count(allocations);
    __libc_free(memory);
}

int pthread_mutex_lock(pthread_mutex_t *mutex) {
    using Lock = int (*)(pthread_mutex_t *);
    static const auto real = reinterpret_cast<Lock>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
    count(locks);
    return real(mutex);
}
}

namespace springdrive {
namespace {

std::unique_ptr<LoadedScene> scene_named(const std::string &name,
                                         const DeviceDescription &description) {
    LoadProgress progress;
    return load_scene(testing::assets() / "scenes" / (name + ".gltf"), description.workspace,
                      progress);
}

/// Every scene of the project, touched by the scripted hand, with every map and source of α.
struct Rig {
    Rig(const std::string &scene_name, MotionMap map, AlphaMode alpha_mode)
        : description(testing::phantom_1_0()), scene(scene_named(scene_name, description)),
          device(description, options(), start()), loop(device, 1e-3) {
        inputs.surface = &scene->surface;
        inputs.tuning.map = map;
        inputs.tuning.alpha_mode = alpha_mode;
        inputs.global_alpha_rad2_per_m2 = 3000.0;
    }

    [[nodiscard]] Vector3 start() const {
        return start_above(description, scene->scene.lower_m, scene->scene.upper_m);
    }
    [[nodiscard]] SimulationOptions options() const {
        SimulationOptions simulation;
        simulation.path = scripted_touch(description, scene->surface, scene->scene.lower_m,
                                         scene->scene.upper_m, start());
        return simulation;
    }

    /// Ticks in contact among `ticks`; trips and resets on the way.
    int run(int ticks) {
        int touching = 0;
        for (int i = 0; i < ticks; ++i) {
            inputs.emergency_stop = i == ticks - 200;
            inputs.reset_count = i > ticks - 100 ? 1U : 0U;
            const ServoSample sample = loop.update(loop.exchange(), sealed(inputs));
            touching += sample.contact.touching ? 1 : 0;
        }
        return touching;
    }

    DeviceDescription description;
    std::unique_ptr<LoadedScene> scene;
    SimulatedPhantom device;
    ServoLoop loop;
    ServoInputs inputs;
};

constexpr int kTicks = 3300;

template <typename Check> void for_every_rig(Check &&check) {
    for (const char *scene : {"plate", "sphere", "stepped_block", "organic", "compliance"}) {
        for (const MotionMap map : {MotionMap::inverse, MotionMap::transpose}) {
            for (const AlphaMode mode :
                 {AlphaMode::on_the_fly, AlphaMode::global, AlphaMode::by_hand}) {
                Rig rig(scene, map, mode);
                check(rig, scene);
            }
        }
    }
}

TEST(RealTime, TheWatchIsAwake) {
    watched = true;
    std::free(std::malloc(1)); // NOLINT
    pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
    pthread_mutex_lock(&mutex);
    pthread_mutex_unlock(&mutex);
    watched = false;
    EXPECT_EQ(allocations.exchange(0), 2);
    EXPECT_EQ(locks.exchange(0), 1);
}

TEST(RealTime, ATickAllocatesAndLocksNothing) {
    for_every_rig([](Rig &rig, const char *scene) {
        watched = true;
        const int touching = rig.run(kTicks);
        watched = false;
        EXPECT_EQ(allocations.exchange(0), 0) << scene;
        EXPECT_EQ(locks.exchange(0), 0) << scene;
        EXPECT_GT(touching, 500) << scene;
    });
}

TEST(RealTime, AProxyOnShapesAndWithFrictionAllocatesAndLocksNothing) {
    using Size = AnalyticShape::Size;
    for (const Size &size :
         {Size(Plate{0.03, 0.03}), Size(Sphere{0.02}), Size(Box{Vector3::Constant(0.02)}),
          Size(Cylinder{0.02, 0.01}), Size(Capsule{0.02, 0.01})}) {
        TriangleSoup soup;
        soup.materials = {{"rough", 0.0, 0.4, 0.3}};
        const HapticSurface surface(soup, {AnalyticShape(size, Eigen::Isometry3d::Identity(), 0)});
        Proxy proxy(0.5e-3);
        proxy.reset({0.0, 0.05, 0.0});
        int touching = 0;
        watched = true;
        for (int i = 0; i < kTicks; ++i) {
            const double t = 0.01 * i;
            const Vector3 tip(0.015 * std::sin(t), 0.01 + 0.04 * std::cos(3.0 * t),
                              0.015 * std::cos(0.7 * t));
            touching += proxy.update(surface, tip).touching ? 1 : 0;
        }
        watched = false;
        EXPECT_EQ(allocations.exchange(0), 0);
        EXPECT_EQ(locks.exchange(0), 0);
        EXPECT_GT(touching, 100);
    }
}

/// In a child where any system call but read, write and exit means death.
int exit_status_without_system_calls(Rig &rig, bool call_one) {
    const pid_t child = fork();
    if (child == 0) {
        if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0) {
            _exit(77);
        }
        rig.run(kTicks);
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
    Rig witness("plate", MotionMap::transpose, AlphaMode::on_the_fly);
    const int killed = exit_status_without_system_calls(witness, true);
    if (killed == 77) {
        GTEST_SKIP() << "this kernel has no seccomp";
    }
    ASSERT_EQ(killed, -SIGKILL); // the watch is awake
    for_every_rig([](Rig &rig, const char *scene) {
        EXPECT_EQ(exit_status_without_system_calls(rig, false), 0) << scene;
    });
}

} // namespace
} // namespace springdrive
