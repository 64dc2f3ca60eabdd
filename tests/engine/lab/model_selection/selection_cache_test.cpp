// Covers engine/lab/model_selection/selection_cache.cpp and selection_json.cpp.
#include "engine/lab/model_selection/selection_cache.h"

#include "base/input_error.h"
#include "engine/lab/model_selection/selection_json.h"
#include "tests/engine/lab/model_selection/model_settings.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <limits>

namespace springdrive::model_selection {
namespace {

ModelSelection some_selection() {
    ModelSelection choice;
    choice.tolerance = {0.125, 0.5, 77.0};
    const auto axis = [](const std::string &name, const std::string &cheap,
                         const std::string &full) {
        const double infinity = std::numeric_limits<double>::infinity();
        return ModelAxis{name,
                         {{cheap, {1.5, 2.0, 3.0}, {infinity, infinity}},
                          {full, {10.0 / 3.0, 4.0, 5.0}, {0.1, 0.2}}},
                         1,
                         {{0, {infinity, infinity}}}};
    };
    choice.axes = {axis("plant", "coupling", "full"), axis("steps", "1", "32"),
                   axis("joints", "2", "3"), axis("surface", "simplified_8", "given"),
                   axis("controller", "inverse", "transpose_on_the_fly")};
    choice.error = {0.01, 0.02};
    choice.cost_ns = 1234.5;
    choice.fullest_cost_ns = 5432.1;
    choice.warnings = {"a remark"};
    return choice;
}

std::filesystem::path only_file_in(const std::filesystem::path &folder) {
    return std::filesystem::directory_iterator(folder)->path();
}

const std::string kKey(64, 'a');

TEST(SelectionJson, ReadsBackWhatItWrote) {
    const nlohmann::ordered_json json = json_of(some_selection());
    EXPECT_EQ(json_of(model_selection_of(json)), json);
    EXPECT_EQ(json_of(model_selection_of(nlohmann::ordered_json::parse(json.dump()))), json);
    EXPECT_EQ(json["axes"][0]["candidates"][0]["verdict"], "runs away");
    EXPECT_TRUE(json["axes"][0]["candidates"][0]["error"]["force_N"].is_null());
    const Model model = model_of(model_selection_of(json));
    EXPECT_EQ(model.steps, 32);
    EXPECT_FALSE(model.planar);
}

TEST(SelectionJson, RefusesWhatItWouldNotHaveWritten) {
    const nlohmann::ordered_json good = json_of(some_selection());
    const auto expect_refused = [&](const std::string &pointer,
                                    const nlohmann::ordered_json &value) {
        nlohmann::ordered_json bad = good;
        bad[nlohmann::ordered_json::json_pointer(pointer)] = value;
        EXPECT_THROW(static_cast<void>(model_selection_of(bad)), InputError) << pointer;
    };
    expect_refused("/axes/0/chosen", "none");
    expect_refused("/axes/0/candidates/1/name", "unheard_of");
    expect_refused("/axes/1/candidates", 7);
    expect_refused("/axes", nlohmann::ordered_json::array());
    expect_refused("/cost_ns", "much");
    expect_refused("/error", nullptr);
    nlohmann::ordered_json unknown = good;
    unknown["axes"][0]["candidates"][1]["name"] = unknown["axes"][0]["chosen"] = "unheard_of";
    EXPECT_THROW(static_cast<void>(model_selection_of(unknown)), InputError);
    EXPECT_THROW(static_cast<void>(model_selection_of("text")), InputError);
}

TEST(SelectionCache, ReturnsAChoiceUnderItsKeyOnly) {
    const std::filesystem::path folder = testing::fresh_folder("model_choice_1");
    const std::filesystem::path place = folder / "deep" / "er";
    EXPECT_FALSE(read_model_selection(place, kKey));
    ASSERT_TRUE(write_model_selection(place, kKey, some_selection()));
    const std::optional<ModelSelection> read = read_model_selection(place, kKey);
    ASSERT_TRUE(read);
    EXPECT_EQ(json_of(*read), json_of(some_selection()));
    EXPECT_FALSE(read_model_selection(place, std::string(64, 'b')));
    // The file's name holds the key's first part only; the whole of it is inside.
    EXPECT_FALSE(read_model_selection(place, std::string(16, 'a') + std::string(48, 'b')));
    ASSERT_TRUE(write_model_selection(place, kKey, some_selection())); // replaces the existing file
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(place), {}), 1);
}

TEST(SelectionCache, IgnoresADamagedFile) {
    const std::filesystem::path folder = testing::fresh_folder("model_choice_2");
    ASSERT_TRUE(write_model_selection(folder, kKey, some_selection()));
    const std::filesystem::path file = only_file_in(folder);
    std::ifstream stream(file);
    const std::string whole{std::istreambuf_iterator<char>(stream), {}};
    for (std::size_t length = 0; length + 2 < whole.size(); length += 37) {
        std::ofstream(file) << whole.substr(0, length);
        EXPECT_FALSE(read_model_selection(folder, kKey)) << length;
    }
    for (const char *text : {"null", "[]", "{}", "7", "\"x\"", R"({"key": 1})", "\xff\xfe"}) {
        std::ofstream(file) << text;
        EXPECT_FALSE(read_model_selection(folder, kKey)) << text;
    }
    EXPECT_TRUE(write_model_selection(folder, kKey, some_selection()));
    EXPECT_TRUE(read_model_selection(folder, kKey));
}

TEST(SelectionCache, WorksWithoutAFolder) {
    const std::filesystem::path folder = testing::fresh_folder("model_choice_3");
    const std::filesystem::path file = folder / "file";
    std::ofstream(file) << "in the way";
    EXPECT_FALSE(write_model_selection(file, kKey, some_selection()));
    EXPECT_FALSE(read_model_selection(file, kKey));
    EXPECT_FALSE(write_model_selection({}, kKey, some_selection()));
    EXPECT_FALSE(read_model_selection({}, kKey));
}

TEST(SelectionCache, KeyChangesWithAllThatAChoiceDependsOn) {
    const scene::Scene scene = testing::own_scene("compliance");
    const ModelQuestion question{&scene, testing::phantom_1_0(), {}, 1e-3, 0};
    const std::string key = model_selection_key(question, "device", "1");
    EXPECT_EQ(key.size(), 64U);
    EXPECT_EQ(model_selection_key(question, "device", "1"), key);
    EXPECT_NE(model_selection_key(question, "devicf", "1"), key);
    EXPECT_NE(model_selection_key(question, "device", "2"), key);
    const auto expect_other_scene = [&](const std::function<void(scene::Scene &)> &change) {
        scene::Scene other = scene;
        change(other);
        ModelQuestion changed = question;
        changed.scene = &other;
        EXPECT_NE(model_selection_key(changed, "device", "1"), key);
    };
    expect_other_scene([](scene::Scene &s) { s.tolerance.force_N *= 2.0; });
    expect_other_scene([](scene::Scene &s) { s.tolerance.direction_rad *= 2.0; });
    expect_other_scene([](scene::Scene &s) { s.tolerance.bandwidth_hz *= 2.0; });
    expect_other_scene([](scene::Scene &s) { s.planar = true; });
    expect_other_scene([](scene::Scene &s) { s.surface.vertices_m.back().z() += 1e-9; });
    expect_other_scene(
        [](scene::Scene &s) { std::swap(s.surface.triangles[0], s.surface.triangles[1]); });
    expect_other_scene([](scene::Scene &s) { s.surface.materials[0].eta = 0.1; });
    expect_other_scene([](scene::Scene &s) { s.surface.materials[0].static_friction = 0.1; });
    expect_other_scene([](scene::Scene &s) { s.flat_surface = s.surface; });
    expect_other_scene([](scene::Scene &s) {
        s.shapes.emplace_back(contact::Sphere{0.01}, Eigen::Isometry3d::Identity(),
                              std::uint16_t{0});
    });
    const auto expect_other = [&](const std::function<void(ModelQuestion &)> &change) {
        ModelQuestion changed = question;
        change(changed);
        EXPECT_NE(model_selection_key(changed, "device", "1"), key);
    };
    expect_other([](ModelQuestion &q) { q.tuning.dR_Ohm = 0.6; });
    expect_other([](ModelQuestion &q) { q.period_s = 0.5e-3; });
    expect_other([](ModelQuestion &q) { q.delay_periods = 1; });
    expect_other([](ModelQuestion &q) { q.delay_periods = 0.5; });
}

TEST(SelectionCache, IsInTheSystemsCacheFolder) {
    setenv("XDG_CACHE_HOME", "/some/where", 1);
    EXPECT_EQ(model_cache_folder(), "/some/where/springdrive");
    setenv("XDG_CACHE_HOME", "relative", 1); // not allowed by the specification, so it is ignored
    setenv("HOME", "/home/somebody", 1);
    EXPECT_EQ(model_cache_folder(), "/home/somebody/.cache/springdrive");
    unsetenv("XDG_CACHE_HOME");
    unsetenv("HOME");
    EXPECT_EQ(model_cache_folder(), "");
}

} // namespace
} // namespace springdrive::model_selection
