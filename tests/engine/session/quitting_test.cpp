// Covers engine/session: a session ends quickly and cleanly in any state. The sanitizers detect
// leaks.
#include "tests/engine/session/session_fixture.h"

#include "engine/lab/model_selection/selection_cache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

namespace springdrive::session {
namespace {

using Clock = std::chrono::steady_clock;

/// Writes a .glb of a wavy square of `cells` cells per side, with two triangles each.
std::filesystem::path write_square(const std::filesystem::path &file, std::uint32_t cells) {
    std::vector<float> positions;
    std::vector<std::uint32_t> indices;
    const std::uint32_t row = cells + 1;
    for (std::uint32_t i = 0; i < row; ++i) {
        for (std::uint32_t j = 0; j < row; ++j) {
            const float x = static_cast<float>(i) / static_cast<float>(cells);
            const float z = static_cast<float>(j) / static_cast<float>(cells);
            positions.insert(positions.end(), {x, 0.05F * std::sin(20.0F * x) * z, z});
            if (i < cells && j < cells) {
                const std::uint32_t a = i * row + j;
                indices.insert(indices.end(), {a, a + 1, a + row, a + 1, a + row + 1, a + row});
            }
        }
    }
    const std::size_t position_bytes = 4 * positions.size();
    const std::size_t index_bytes = 4 * indices.size();
    const auto text = [](std::size_t number) { return std::to_string(number); };
    std::string json =
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"accessors":[)"
        R"({"bufferView":0,"componentType":5126,"count":)" +
        text(positions.size() / 3) +
        R"(,"type":"VEC3","min":[0,-0.05,0],"max":[1,0.05,1]},{"bufferView":1,)"
        R"("componentType":5125,"count":)" +
        text(indices.size()) + R"(,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":)" +
        text(position_bytes) + R"(},{"buffer":0,"byteOffset":)" + text(position_bytes) +
        R"(,"byteLength":)" + text(index_bytes) + R"(}],"buffers":[{"byteLength":)" +
        text(position_bytes + index_bytes) + "}]}";
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::ofstream out(file, std::ios::binary);
    const auto put = [&out](std::size_t number) {
        const auto narrow = static_cast<std::uint32_t>(number);
        out.write(reinterpret_cast<const char *>(&narrow), 4);
    };
    const std::size_t binary = position_bytes + index_bytes;
    out << "glTF";
    put(2);
    put(12 + 8 + json.size() + 8 + binary);
    put(json.size());
    out << "JSON" << json;
    put(binary);
    out.write("BIN\0", 4);
    out.write(reinterpret_cast<const char *>(positions.data()),
              static_cast<std::streamsize>(position_bytes));
    out.write(reinterpret_cast<const char *>(indices.data()),
              static_cast<std::streamsize>(index_bytes));
    return file;
}

class Quitting : public ::testing::Test {
protected:
    Quitting() : folder(testing::fresh_folder("quitting")) {}
    ~Quitting() override { std::filesystem::remove_all(folder); }

    std::filesystem::path folder;
};

/// Half a million triangles take some seconds. This is how long the end of a session may wait for a
/// thread to check for cancellation, with a large margin for a busy computer.
constexpr double kSoon_s = 3.0;

TEST_F(Quitting, WhileASceneLoadsEndsQuicklyInEveryStage) {
    const std::filesystem::path large = write_square(folder / "large.glb", 500);
    double longest_s = 0.0;
    for (const char *stage : {"reading", "gathering", "placing", "preparing"}) {
        Clock::time_point start;
        {
            Session session(testing::scripted());
            session.start();
            session.request_scene(large);
            while (session.scenes().is_loading() &&
                   session.scenes().progress().find(stage) == std::string::npos) {
                session.advance(0.001);
            }
            start = Clock::now();
        }
        longest_s =
            std::max(longest_s, std::chrono::duration<double>(Clock::now() - start).count());
    }
    RecordProperty("longest_s", std::to_string(longest_s));
    EXPECT_LT(longest_s, kSoon_s);
}

TEST_F(Quitting, AnotherSceneDoesNotWaitForTheLargeOne) {
    const std::filesystem::path large = write_square(folder / "large.glb", 500);
    Session session(testing::scripted());
    session.start();
    session.request_scene(large);
    session.advance(0.001);
    session.request_scene(testing::assets() / "scenes/sphere.gltf");
    ASSERT_TRUE(testing::run_until_loaded(session));
    EXPECT_EQ(session.scenes().now().scene.file.filename(), "sphere.gltf");
    EXPECT_EQ(session.scenes().error(), "");
}

/// Performs an action on the session, selected by a number.
void poke(Session &session, unsigned which, const std::filesystem::path &folder) {
    switch (which % 8) {
    case 0:
        session.request_scene(testing::assets() / "scenes/sphere.gltf");
        break;
    case 1:
        session.set_servo_rate(which % 16 < 8 ? 2000.0 : 1000.0);
        break;
    case 2:
        session.exchange_device(testing::premium());
        break;
    case 3:
        session.measure_model(true);
        break;
    case 4:
        if (!session.recording().is_running()) {
            static int number = 0;
            session.start_recording(folder / (std::to_string(++number) + ".rec"));
        }
        break;
    case 5:
        session.reconnect_device();
        break;
    case 6:
        session.servo().emergency_stop();
        break;
    default:
        session.stop();
        break;
    }
}

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
constexpr int kRounds = 8; // some 4 s each
#else
constexpr int kRounds = 40;
#endif

TEST_F(Quitting, AtAnyMomentEndsCleanly) {
    setenv("XDG_CACHE_HOME", folder.c_str(), 1);
    std::mt19937 random(11);
    double longest_s = 0.0;
    for (int round = 0; round < kRounds; ++round) {
        SessionOptions options = testing::scripted(round % 2 == 0 ? "plate" : "organic");
        options.lockstep = round % 3 != 0;
        options.model.chooser = model_selection::cached_chooser();
        Clock::time_point start;
        std::string done;
        {
            Session session(options);
            if (round % 5 != 0) {
                session.start();
            }
            for (std::uint_fast32_t i = random() % 6; i > 0; --i) {
                const auto which = static_cast<unsigned>(random()) % 160;
                poke(session, which, folder);
                done += " " + std::to_string(which % 8);
                testing::run(session, 0.1 * static_cast<double>(random() % 4));
            }
            start = Clock::now();
        }
        const double took_s = std::chrono::duration<double>(Clock::now() - start).count();
        EXPECT_LT(took_s, kSoon_s) << "after" << done;
        longest_s = std::max(longest_s, took_s);
    }
    unsetenv("XDG_CACHE_HOME");
    RecordProperty("longest_s", std::to_string(longest_s));
}

} // namespace
} // namespace springdrive::session
