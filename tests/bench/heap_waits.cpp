// How long a thread that serves a board waits for the heap beside scenes that are loaded, and
// whether loading them over and over adds up in memory: with one arena for all threads, and with an
// arena for each as the program has it (base/real_time_thread.h).
//
//   heap_waits [LOADS [TRIANGLES]]
#include "base/real_time_thread.h"
#include "engine/servo/real_time.h"
#include "engine/session/loaded_scene.h"
#include "tests/bench/stopwatch.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>
#include <numbers>
#include <string>
#include <thread>
#include <vector>

#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

namespace springdrive::bench {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

/// A ball of about so many triangles, as a glTF file.
void write_ball(const std::filesystem::path &file, int triangles) {
    const auto rings = static_cast<std::uint32_t>(std::lround(std::sqrt(triangles / 4.0)));
    const std::uint32_t columns = 2 * rings;
    std::vector<float> points;
    std::vector<std::uint32_t> corners;
    for (std::uint32_t ring = 0; ring <= rings; ++ring) {
        const double polar = std::numbers::pi * ring / rings;
        for (std::uint32_t column = 0; column < columns; ++column) {
            const double turn = 2.0 * std::numbers::pi * column / columns;
            for (const double value : {std::sin(polar) * std::cos(turn), std::cos(polar),
                                       std::sin(polar) * std::sin(turn)}) {
                points.push_back(static_cast<float>(0.04 * value));
            }
            if (ring < rings) {
                const std::uint32_t here = ring * columns + column;
                const std::uint32_t beside = ring * columns + (column + 1) % columns;
                for (const std::uint32_t corner :
                     {here, beside, here + columns, beside, beside + columns, here + columns}) {
                    corners.push_back(corner);
                }
            }
        }
    }
    const std::size_t point_bytes = points.size() * sizeof(float);
    const std::size_t corner_bytes = corners.size() * sizeof(std::uint32_t);
    const std::filesystem::path data = std::filesystem::path(file).replace_extension(".bin");
    std::ofstream binary(data, std::ios::binary);
    binary.write(reinterpret_cast<const char *>(points.data()),
                 static_cast<std::streamsize>(point_bytes));
    binary.write(reinterpret_cast<const char *>(corners.data()),
                 static_cast<std::streamsize>(corner_bytes));
    std::ofstream(file) << fmt::format(
        R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
"buffers":[{{"uri":"{}","byteLength":{}}}],
"bufferViews":[{{"buffer":0,"byteLength":{}}},{{"buffer":0,"byteOffset":{},"byteLength":{}}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3",
"min":[-0.04,-0.04,-0.04],"max":[0.04,0.04,0.04]}},
{{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}}]}})",
        data.filename().string(), point_bytes + corner_bytes, point_bytes, point_bytes,
        corner_bytes, points.size() / 3, corners.size());
}

/// The part of this process that is in RAM [MiB].
double resident_MiB() {
    std::ifstream file("/proc/self/statm");
    double total = 0.0;
    double resident = 0.0;
    file >> total >> resident;
    return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

struct Waits {
    std::vector<double> heap_us; ///< of a tick's allocations
    std::vector<double> tick_us; ///< from when a tick is due until its allocations are done
};

/// As the thread of a board's port at 1 kHz: libusb allocates and frees for each of its transfers,
/// one in and one out, of which four and two are under way.
Waits serve(const std::atomic<bool> &ends) {
    constexpr std::size_t kTransfer_bytes = 56; // usbdevfs_urb
    static_cast<void>(request_priority(81));    // kPortThreadPriority
    Waits waits;
    waits.heap_us.reserve(2'000'000);
    waits.tick_us.reserve(2'000'000);
    std::array<void *, 6> transfers{};
    std::size_t next = 0;
    for (Clock::time_point due = Clock::now(); !ends; due = std::max(due + 1ms, Clock::now())) {
        std::this_thread::sleep_until(due);
        waits.heap_us.push_back(1e-3 * time_ns([&] {
                                    for (int i = 0; i < 2; ++i) {
                                        void *&one = transfers[next++ % transfers.size()]; // NOLINT
                                        std::free(one);                                    // NOLINT
                                        one = std::calloc(1, kTransfer_bytes);             // NOLINT
                                    }
                                }));
        waits.tick_us.push_back(
            std::chrono::duration<double, std::micro>(Clock::now() - due).count());
    }
    for (void *one : transfers) {
        std::free(one); // NOLINT
    }
    return waits;
}

struct Figures {
    std::array<double, 4> heap_us{}; ///< median, 99 %, 99.9 %, maximum
    std::array<double, 4> tick_us{};
    std::array<double, 4> resident{}; ///< after the first, a fifth, half and all of the loads [MiB]
    double ticks = 0.0;
};

std::array<double, 4> quantiles(const std::vector<double> &values) {
    return {quantile(values, 0.5), quantile(values, 0.99), quantile(values, 0.999),
            quantile(values, 1.0)};
}

/// Loads the scene again and again as a session does, while it shows the one before.
Figures measure(const std::filesystem::path &file, int loads) {
    Figures figures;
    std::atomic<bool> ends{false};
    Waits waits;
    std::future<void> port = run_on_own_heap([&] { waits = serve(ends); });
    {
        session::Scenes scenes(device::Workspace{Vector3::Zero(), Vector3::Constant(0.2)},
                               std::make_unique<session::LoadedScene>());
        for (int load = 1; load <= loads; ++load) {
            scenes.request(file);
            bool is_loaded = false;
            while (!is_loaded && scenes.is_loading()) {
                std::this_thread::sleep_for(5ms);
                is_loaded = scenes.take_loaded() != nullptr;
            }
            if (!is_loaded) {
                throw std::runtime_error(scenes.error());
            }
            scenes.note_in_use(scenes.id()); // releases the one before
            const std::array<int, 4> at{1, loads / 5, loads / 2, loads};
            for (std::size_t i = 0; i < at.size(); ++i) {
                if (load == at[i]) {                      // NOLINT
                    std::this_thread::sleep_for(300ms);   // until the one before is released
                    figures.resident[i] = resident_MiB(); // NOLINT
                }
            }
        }
    }
    ends = true;
    port.wait();
    figures.heap_us = quantiles(waits.heap_us);
    figures.tick_us = quantiles(waits.tick_us);
    figures.ticks = static_cast<double>(waits.heap_us.size());
    return figures;
}

/// In a process of its own, as a heap is set up once.
Figures measured(bool with_one_arena, const std::filesystem::path &file, int loads) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) {
        throw std::runtime_error("no pipe");
    }
    const pid_t child = fork();
    if (child == 0) {
        if (with_one_arena) {
            mallopt(M_ARENA_MAX, 1);
            mallopt(M_MMAP_THRESHOLD, 256 * 1024);
        } else if (!reserve_heaps()) {
            _exit(1);
        }
        static_cast<void>(servo::request_locked_memory());
        const Figures figures = measure(file, loads);
        _exit(write(ends[1], &figures, sizeof figures) == sizeof figures ? 0 : 1);
    }
    close(ends[1]);
    Figures figures;
    const bool is_whole = read(ends[0], &figures, sizeof figures) == sizeof figures;
    close(ends[0]);
    waitpid(child, nullptr, 0);
    if (!is_whole) {
        throw std::runtime_error("a measurement did not end");
    }
    return figures;
}

void print(const char *name, const std::array<double, 4> &one, const std::array<double, 4> &own) {
    for (const auto &[arenas, values] : {std::pair{"one arena", one}, {"its own", own}}) {
        fmt::print("{:<26} {:<10} {:9.1f} {:9.1f} {:9.1f} {:9.1f}\n", name, arenas, values[0],
                   values[1], values[2], values[3]);
    }
    fmt::print("{:<26} {:<10} {:9.2f} {:9.2f} {:9.2f} {:9.2f}\n", name, "ratio", one[0] / own[0],
               one[1] / own[1], one[2] / own[2], one[3] / own[3]);
}

int run(int loads, int triangles) {
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / fmt::format("heap_waits-{}", getpid());
    std::filesystem::create_directory(folder);
    const std::filesystem::path file = folder / "ball.gltf";
    write_ball(file, triangles);
    const Figures one = measured(true, file, loads);
    const Figures own = measured(false, file, loads);
    std::filesystem::remove_all(folder);
    fmt::print("{} loads of {} triangles, {:.0f} and {:.0f} ticks of 1 ms\n", loads, triangles,
               one.ticks, own.ticks);
    fmt::print("{:<26} {:<10} {:>9} {:>9} {:>9} {:>9}\n", "", "", "median", "99 %", "99.9 %",
               "maximum");
    print("allocations of a tick, us", one.heap_us, own.heap_us);
    print("due until allocated, us", one.tick_us, own.tick_us);
    fmt::print("{:<26} {:<10} {:>9} {:>9} {:>9} {:>9}\n", "", "", "1", "a fifth", "half", "all");
    print("resident after loads, MiB", one.resident, own.resident);
    return 0;
}

} // namespace
} // namespace springdrive::bench

int main(int argc, char **argv) {
    const int loads = argc > 1 ? std::atoi(argv[1]) : 50; // NOLINT
    return springdrive::bench::run(std::max(loads, 5),
                                   argc > 2 ? std::atoi(argv[2]) : 1'600'000); // NOLINT
}
