// Covers engine/session/tuning_history.cpp.
#include "engine/session/tuning_history.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <random>
#include <string>
#include <vector>

namespace springdrive::session {
namespace {

constexpr std::uint32_t kSlider = 7;
constexpr std::uint32_t kOtherSlider = 8;

control::Tuning stiff(double K_P_V_per_rad) { return {.K_P_V_per_rad = K_P_V_per_rad}; }

TEST(TuningHistory, ADragIsOneStep) {
    TuningHistory history(stiff(6.0));
    for (int frame = 1; frame <= 20; ++frame) {
        history.change(stiff(6.0 + 0.1 * frame), 0.5 * frame, kSlider);
        EXPECT_TRUE(history.can_undo());
        EXPECT_EQ(history.now(), stiff(6.0 + 0.1 * frame));
    }
    EXPECT_TRUE(history.steps().empty());
    history.let_go();
    history.let_go();
    ASSERT_EQ(history.steps().size(), 1U);
    EXPECT_EQ(history.steps()[0].what, "K_P 6 → 8 V/rad");
    EXPECT_EQ(history.steps()[0].began_s, 0.5);
    EXPECT_EQ(history.steps()[0].time_s, 10.0);
    EXPECT_EQ(history.undo(11.0), stiff(6.0));
    EXPECT_EQ(history.redo(12.0), stiff(8.0));
}

/// A list of the steps may be clicked to go to one of them.
TEST(TuningHistory, TakesATuningFromAStepThatItForgets) {
    TuningHistory history(stiff(6.0));
    history.change(stiff(7.0), 1.0);
    history.undo(2.0);
    history.change(stiff(8.0), 3.0, kSlider);
    history.replace(history.steps()[0].after.now(), 4.0, "step 1");
    EXPECT_EQ(history.now(), stiff(7.0));
    history.undo(5.0);
    history.undo(5.0);
    history.change(stiff(9.0), 6.0, kSlider);
    history.change(history.steps()[1].after.now(), 7.0, kOtherSlider);
    EXPECT_EQ(history.now(), stiff(7.0));
}

TEST(TuningHistory, JournalHasAllThatBecameActive) {
    TuningHistory history(stiff(6.0), -1.0);
    history.change(stiff(7.0), 1.0, kSlider);
    history.change(stiff(8.0), 2.0, kSlider);
    history.replace(stiff(3.0), 3.0, "preset soft");
    history.replace(stiff(3.0), 3.5, "the same again");
    history.undo(4.0);
    history.redo(5.0);
    history.toggle(6.0);
    history.store(7.0);
    history.change(stiff(7.0), 8.0, kSlider);
    history.change(stiff(6.0), 9.0, kSlider);
    history.let_go();
    struct Line {
        double began_s;
        double time_s;
        const char *what;
        double K_P_V_per_rad;
    };
    const std::array<Line, 8> expected{{
        {-1.0, -1.0, "start", 6.0},
        {1.0, 2.0, "K_P 6 → 8 V/rad", 8.0},
        {3.0, 3.0, "preset soft", 3.0},
        {4.0, 4.0, "undo: preset soft", 8.0},
        {5.0, 5.0, "redo: preset soft", 3.0},
        {6.0, 6.0, "A → B", 6.0},
        {7.0, 7.0, "B stored in A", 6.0},
        {8.0, 9.0, "moved and moved back", 6.0},
    }};
    ASSERT_EQ(history.journal().size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const TuningEvent &event = history.journal()[i];
        EXPECT_EQ(event.began_s, expected[i].began_s) << i;
        EXPECT_EQ(event.time_s, expected[i].time_s) << i;
        EXPECT_EQ(event.what, expected[i].what);
        EXPECT_EQ(event.tuning, stiff(expected[i].K_P_V_per_rad)) << i;
    }
}

TEST(TuningHistory, TheJournalForgetsTheOldestBeyondItsSize) {
    TuningHistory history(stiff(0.0));
    constexpr int kMore = 5;
    for (int i = 1; i < static_cast<int>(TuningHistory::kMaxEvents) + kMore; ++i) {
        history.toggle(i);
    }
    EXPECT_EQ(history.journal().size(), TuningHistory::kMaxEvents);
    EXPECT_EQ(history.journal().front().time_s, kMore);
}

/// Keeps every state that was reached, instead of steps.
class EveryState {
public:
    struct State {
        std::array<control::Tuning, 2> tuning;
        std::size_t active = 0;

        friend bool operator==(const State &, const State &) = default;
    };

    explicit EveryState(const control::Tuning &first) : now_{{first, first}, 0}, kept_{now_} {}

    void change(const control::Tuning &to, std::uint32_t source) {
        if (to == now_.tuning.at(now_.active)) {
            return;
        }
        if (source == 0 || source != held_) {
            keep();
        }
        now_.tuning.at(now_.active) = to;
        held_ = source;
        if (source == 0) {
            keep();
        }
    }
    template <typename Change> void at_once(const Change &change) {
        keep();
        change(now_);
        keep();
    }
    void go(std::ptrdiff_t steps) {
        keep();
        const auto last = static_cast<std::ptrdiff_t>(kept_.size()) - 1;
        at_ = std::clamp<std::ptrdiff_t>(at_ + steps, 0, last);
        now_ = here();
    }
    void keep() {
        held_ = 0;
        if (now_ == here()) {
            return;
        }
        kept_.erase(kept_.begin() + at_ + 1, kept_.end());
        kept_.push_back(now_);
        if (kept_.size() > TuningHistory::kMaxSteps + 1) {
            kept_.erase(kept_.begin());
        }
        at_ = static_cast<std::ptrdiff_t>(kept_.size()) - 1;
    }

    [[nodiscard]] const State &now() const { return now_; }
    [[nodiscard]] const std::vector<State> &kept() const { return kept_; }
    [[nodiscard]] bool can_undo() const { return at_ > 0 || now_ != here(); }
    [[nodiscard]] bool can_redo() const {
        return at_ + 1 < static_cast<std::ptrdiff_t>(kept_.size()) && now_ == here();
    }

private:
    [[nodiscard]] const State &here() const { return kept_.at(static_cast<std::size_t>(at_)); }

    State now_;
    std::vector<State> kept_;
    std::ptrdiff_t at_ = 0;
    std::uint32_t held_ = 0; ///< the control that is held
};

EveryState::State state_of(const TuningSlots &slots) {
    const std::size_t active = slots.active() == TuningSlot::a ? 0 : 1;
    return active == 0 ? EveryState::State{{slots.now(), slots.other()}, active}
                       : EveryState::State{{slots.other(), slots.now()}, active};
}

/// A history and its model, under the same random calls.
class Twins {
public:
    explicit Twins(std::uint64_t seed) : random_(seed) {}

    /// @param forward  of 100 calls, how many are changes
    void call_any(unsigned forward) {
        time_s_ += 0.01;
        const control::Tuning to = stiff(static_cast<double>(below(4)));
        if (below(100) < forward) {
            const std::uint32_t source = below(3);
            history.change(to, time_s_, source);
            model.change(to, source);
            return;
        }
        switch (below(6)) {
        case 0:
            history.let_go();
            model.keep();
            break;
        case 1:
            history.replace(to, time_s_, "named");
            model.at_once([&](auto &state) { state.tuning.at(state.active) = to; });
            break;
        case 2:
            history.toggle(time_s_);
            model.at_once([](auto &state) { state.active = 1 - state.active; });
            break;
        case 3:
            history.store(time_s_);
            model.at_once([](auto &state) { state.tuning.fill(state.tuning.at(state.active)); });
            break;
        case 4:
            history.undo(time_s_);
            model.go(-1);
            break;
        default:
            history.redo(time_s_);
            model.go(1);
        }
    }

    void expect_equal() const {
        ASSERT_EQ(state_of(history.slots()), model.now());
        ASSERT_EQ(history.can_undo(), model.can_undo());
        ASSERT_EQ(history.can_redo(), model.can_redo());
        ASSERT_EQ(history.steps().size() + 1, model.kept().size());
    }

    void expect_equal_steps() const {
        for (std::size_t i = 0; i < history.steps().size(); ++i) {
            const TuningStep &step = history.steps()[i];
            ASSERT_EQ(state_of(step.before), model.kept()[i]);
            ASSERT_EQ(state_of(step.after), model.kept()[i + 1]);
            ASSERT_LE(step.began_s, step.time_s);
            ASSERT_NE(step.what, "");
        }
    }

    TuningHistory history{stiff(0.0)};
    EveryState model{stiff(0.0)};

private:
    std::uint32_t below(std::uint32_t end) {
        return std::uniform_int_distribution<std::uint32_t>(0, end - 1)(random_);
    }

    std::mt19937_64 random_;
    double time_s_ = 0.0;
};

TEST(TuningHistory, GoesWhereKeepingEveryStateGoes) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        SCOPED_TRACE(seed);
        Twins twins(seed);
        for (int call = 0; call < 300; ++call) {
            twins.call_any(40);
            ASSERT_NO_FATAL_FAILURE(twins.expect_equal());
            ASSERT_NO_FATAL_FAILURE(twins.expect_equal_steps());
        }
        twins.history.let_go();
        ASSERT_EQ(twins.history.journal().back().tuning, twins.history.now());
    }
}

TEST(TuningHistory, GoesThereAlsoBeyondItsSize) {
    Twins twins(1);
    std::size_t longest = 0;
    for (int call = 0; call < 40'000; ++call) {
        twins.call_any(90);
        ASSERT_NO_FATAL_FAILURE(twins.expect_equal());
        longest = std::max(longest, twins.history.steps().size());
    }
    EXPECT_EQ(longest, TuningHistory::kMaxSteps);
    ASSERT_NO_FATAL_FAILURE(twins.expect_equal_steps());
}

/// Of the journal alone, the tuning at any time outside a drag.
TEST(TuningHistory, JournalAndPublisherTellWhichTuningIsActive) {
    control::Tuning published = stiff(0.0);
    TuningHistory history(published, 0.0,
                          [&](const control::Tuning &active) { published = active; });
    std::mt19937_64 random(3);
    std::vector<control::Tuning> active_at_ms;
    for (int now_ms = 0; now_ms < 5000; ++now_ms) {
        const double time_s = 1e-3 * now_ms;
        if (random() % 2 == 0) {
            history.change(stiff(static_cast<double>(random() % 4)), time_s,
                           static_cast<std::uint32_t>(random() % 3));
        } else if (random() % 2 == 0) {
            history.undo(time_s);
        } else {
            history.redo(time_s);
        }
        active_at_ms.push_back(history.now());
        ASSERT_EQ(published, history.now());
    }
    history.let_go();
    std::size_t known = 0;
    for (int at_ms = 0; at_ms < 5000; ++at_ms) {
        const double time_s = 1e-3 * at_ms;
        const auto &journal = history.journal();
        const auto next = std::ranges::find_if(
            journal, [&](const TuningEvent &event) { return event.time_s > time_s; });
        if (next == journal.end() || next->began_s > time_s) {
            ASSERT_EQ(std::prev(next)->tuning, active_at_ms.at(static_cast<std::size_t>(at_ms)));
            ++known;
        }
    }
    EXPECT_GT(known, 2000U);
}

} // namespace
} // namespace springdrive::session
