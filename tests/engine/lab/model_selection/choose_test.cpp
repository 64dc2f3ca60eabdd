// Covers engine/lab/model_selection/{choose,selection_cache,selection_json}.cpp.
#include "base/input_error.h"
#include "engine/lab/model_selection/choose.h"
#include "engine/lab/model_selection/selection_cache.h"
#include "tests/engine/lab/model_selection/model_settings.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <optional>
#include <random>

namespace springdrive::model_selection {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const scene::ModelTolerance kTolerance{0.1, 0.1, 100.0};

Candidate candidate(const std::string &name, double cost_ns, double force_N,
                    double direction_rad = 0.0) {
    return {name, {cost_ns, cost_ns, cost_ns}, {force_N, direction_rad}};
}

/// As if errors of several axes added up.
ModelError summed(const std::vector<ModelAxis> &axes, const Picks &picks) {
    ModelError sum;
    for (std::size_t i = 0; i < axes.size(); ++i) {
        sum.force_N += axes[i].candidates[picks[i]].error.force_N;
        sum.direction_rad += axes[i].candidates[picks[i]].error.direction_rad;
    }
    return sum;
}

double cost_of(const ModelAxis &axis, std::size_t index) {
    return axis.candidates[index].cost.min_ns;
}

std::optional<std::size_t> costliest_below(const ModelAxis &axis, double cost_ns) {
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < axis.candidates.size(); ++i) {
        if (cost_of(axis, i) < cost_ns && (!found || cost_of(axis, i) > cost_of(axis, *found))) {
            found = i;
        }
    }
    return found;
}

ChosenModel choose(const std::vector<ModelAxis> &axes) {
    return choose_model(axes, kTolerance, [&](const Picks &picks) { return summed(axes, picks); });
}

std::string chosen_of(const ModelAxis &axis) { return axis.candidates[axis.chosen].name; }

TEST(Choose, TakesOnOneAxisTheCheapestThatMeets) {
    struct Case {
        std::vector<Candidate> candidates;
        std::size_t chosen;
        std::optional<std::size_t> missed; ///< the next cheaper, which was tried
    };
    const std::vector<Case> cases{
        {{candidate("bad", 1, 0.5), candidate("good", 2, 0.05), candidate("dear", 3, 0.01),
          candidate("full", 4, 0.0)},
         1,
         0},
        // Both errors count, and the limit itself is met.
        {{candidate("askew", 1, 0.0, 0.11), candidate("just", 2, 0.1, 0.1),
          candidate("full", 4, 0.0)},
         1,
         0},
        // Of the same cost the nearest to the fullest.
        {{candidate("rough", 100, 0.08), candidate("fine", 104, 0.02), candidate("bad", 101, 0.9),
          candidate("full", 200, 0.0)},
         1,
         std::nullopt},
        // The fullest where nothing else meets.
        {{candidate("bad", 1, 0.5), candidate("wild", 2, kInfinity),
          candidate("odd", 3, std::nan("")), candidate("full", 4, 0.0)},
         3,
         2},
        {{candidate("dear", 9, 0.05), candidate("full", 4, 0.0)}, 1, std::nullopt}};
    for (const Case &each : cases) {
        SCOPED_TRACE(each.candidates.front().name);
        const ChosenModel model = choose({{"axis", each.candidates, 0, {}}});
        const ModelAxis &axis = model.axes[0];
        EXPECT_EQ(axis.chosen, each.chosen);
        EXPECT_EQ(model.error.force_N, each.candidates[each.chosen].error.force_N);
        ASSERT_EQ(axis.cheaper.size(), each.missed ? 1U : 0U);
        if (each.missed) {
            EXPECT_EQ(axis.cheaper[0].candidate, *each.missed);
            EXPECT_TRUE(!meets(axis.cheaper[0].error, kTolerance));
        }
    }
}

TEST(Choose, StepsUpWhereTheTwoTogetherMiss) {
    const ModelAxis coarse{
        "coarse",
        {candidate("c1", 1, 0.09), candidate("c2", 2, 0.03), candidate("full", 9, 0.0)},
        0,
        {}};
    const ModelAxis fine{"fine", {candidate("f1", 1, 0.05), candidate("full", 9, 0.0)}, 0, {}};
    const ChosenModel model = choose({coarse, fine});
    EXPECT_EQ(chosen_of(model.axes[0]), "c2"); // it had the larger error
    EXPECT_EQ(chosen_of(model.axes[1]), "f1");
    EXPECT_NEAR(model.error.force_N, 0.08, 1e-15);
    ASSERT_EQ(model.axes[0].cheaper.size(), 1U);
    EXPECT_NEAR(model.axes[0].cheaper[0].error.force_N, 0.14, 1e-15);
}

TEST(Choose, StepsDownWhereErrorsCancel) {
    const std::vector<ModelAxis> axes{
        {"a", {candidate("soft", 1, 0.12), candidate("full", 9, 0.0)}, 0, {}},
        {"b", {candidate("stiff", 1, 0.05), candidate("full", 9, 0.0)}, 0, {}}};
    const ChosenModel model = choose_model(axes, kTolerance, [&](const Picks &picks) {
        const double a = axes[0].candidates[picks[0]].error.force_N;
        const double b = axes[1].candidates[picks[1]].error.force_N;
        return ModelError{std::abs(a - b), 0.0};
    });
    EXPECT_EQ(chosen_of(model.axes[0]), "soft"); // misses on its own
    EXPECT_NEAR(model.error.force_N, 0.07, 1e-15);
}

TEST(Choose, AlwaysMeetsAndNoNextCheaperDoes) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> cost(1.0, 100.0);
    std::uniform_real_distribution<double> error(0.0, 0.3);
    std::uniform_int_distribution<std::size_t> size(1, 6);
    for (int trial = 0; trial < 500; ++trial) {
        std::vector<ModelAxis> axes(4);
        for (ModelAxis &axis : axes) {
            axis.candidates.resize(size(random));
            for (Candidate &one : axis.candidates) {
                one = candidate("", cost(random), error(random), error(random));
            }
            axis.candidates.back().error = {};
        }
        const ChosenModel model = choose(axes);
        Picks picks;
        for (const ModelAxis &axis : model.axes) {
            picks.push_back(axis.chosen);
        }
        EXPECT_TRUE(meets(summed(axes, picks), kTolerance));
        EXPECT_EQ(model.error.force_N, summed(axes, picks).force_N);
        for (std::size_t i = 0; i < axes.size(); ++i) {
            const std::optional<std::size_t> cheaper =
                costliest_below(axes[i], (1.0 - kSameCost) * cost_of(axes[i], picks[i]));
            ASSERT_EQ(model.axes[i].cheaper.empty(), !cheaper);
            if (cheaper) {
                EXPECT_EQ(model.axes[i].cheaper.front().candidate, *cheaper);
                Picks instead = picks;
                instead[i] = *cheaper;
                EXPECT_FALSE(meets(summed(axes, instead), kTolerance));
            }
        }
    }
}

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
