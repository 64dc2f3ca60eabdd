// Covers engine/lab/model_selection/choose.cpp.
#include "engine/lab/model_selection/choose.h"

#include <gtest/gtest.h>

#include <cmath>
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

} // namespace
} // namespace springdrive::model_selection
