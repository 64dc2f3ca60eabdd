// Covers app/plots/plot_view.cpp.
#include "app/plots/plot_view.h"

#include "engine/control/tuning.h"
#include "engine/servo/safety_status.h"
#include "tests/support/plots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app {
namespace {

using signals::TimeWindow;
using signals::TriggerEdge;
using testing::channel;
using testing::MadeUpStore;

void expect_same(const TimeWindow &a, const TimeWindow &b) {
    EXPECT_EQ(a.from_s, b.from_s);
    EXPECT_EQ(a.to_s, b.to_s);
}

/// Everything that a held view shows, as a number that changes with any of it.
double sum_of_view(const PlotView &view, const record::ChannelStore &live) {
    const record::ChannelStore &store = view.store(live);
    const TimeWindow window = view.window(live);
    double sum = 0.0;
    for (std::uint64_t row = store.row_at(window.from_s);
         row < store.end() && store.time_s(row) <= window.to_s; ++row) {
        sum += std::sin(static_cast<double>(row)) * store.value(channel("force_N"), row);
    }
    return sum;
}

TEST(PlotView, ALiveOneEndsAtTheNewestTickOrWhereARecordStands) {
    MadeUpStore made;
    PlotView view;
    EXPECT_TRUE(view.is_live());
    expect_same(view.window(made.store()), {-view.span_s(), 0.0}); // before the first tick
    for (const double newest_s : {0.0, 1.0, 7.5}) {
        made.add_until(newest_s);
        EXPECT_NEAR(view.window(made.store()).to_s, newest_s, 1e-9);
        EXPECT_NEAR(view.window(made.store()).from_s, newest_s - view.span_s(), 1e-9);
        EXPECT_EQ(&view.store(made.store()), &made.store());
    }
    view.follow(4.5);
    expect_same(view.window(made.store()), {4.5 - view.span_s(), 4.5});
    view.hold(made.store());
    view.follow(6.0); // a held view does not move
    EXPECT_DOUBLE_EQ(view.window(made.store()).to_s, 4.5);
    view.go_live();
    EXPECT_DOUBLE_EQ(view.window(made.store()).to_s, 6.0);
    view.follow(std::nullopt);
    EXPECT_DOUBLE_EQ(view.window(made.store()).to_s, made.store().time_s(made.store().end() - 1));
}

TEST(PlotView, AHeldOneDoesNotMoveWhileRowsAreAddedAndDropped) {
    // Memory for some five seconds only.
    MadeUpStore made(std::size_t{4} << 20);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> force(0.0, 10.0);
    const auto add = [&](double until_s) {
        while (made.store().is_empty() || made.store().time_s(made.store().end() - 1) < until_s) {
            for (double &value : made.values()) {
                value = force(random);
            }
            made.add();
        }
    };
    add(4.0);
    PlotView view;
    view.set_span(2.0);
    view.hold(made.store());
    const TimeWindow before = view.window(made.store());
    const std::uint64_t end = view.store(made.store()).end();
    const double sum = sum_of_view(view, made.store());
    EXPECT_NE(sum, 0.0);
    for (const double until_s : {5.0, 8.0, 14.0}) {
        add(until_s);
        view.hold(made.store()); // again: changes nothing
        EXPECT_FALSE(view.is_live());
        expect_same(view.window(made.store()), before);
        EXPECT_EQ(view.store(made.store()).end(), end);
        EXPECT_EQ(sum_of_view(view, made.store()), sum);
    }
    EXPECT_GT(made.store().time_s(made.store().begin()), before.to_s); // all of it is dropped
    view.go_live();
    EXPECT_NEAR(view.window(made.store()).to_s, 14.0, 1e-9);
    EXPECT_NE(sum_of_view(view, made.store()), sum);
}

TEST(PlotView, AHeldOneWithoutAnyTickStaysEmpty) {
    MadeUpStore made;
    PlotView view;
    view.hold(made.store());
    made.add_until(4.0);
    expect_same(view.window(made.store()), {-view.span_s(), 0.0});
    EXPECT_TRUE(view.store(made.store()).is_empty());
    view.go_live();
    EXPECT_NEAR(view.window(made.store()).to_s, 4.0, 1e-9);
}

TEST(PlotView, AnotherSpanKeepsTheEnd) {
    MadeUpStore made;
    made.add_until(10.0);
    PlotView view;
    for (const bool is_held : {false, true}) {
        if (is_held) {
            view.hold(made.store());
        }
        for (const double span_s : {0.01, 30.0, 2.0}) {
            view.set_span(span_s);
            EXPECT_NEAR(view.window(made.store()).to_s, 10.0, 1e-9);
            EXPECT_NEAR(view.window(made.store()).from_s, 10.0 - span_s, 1e-9);
        }
    }
    view.set_span(1e9);
    EXPECT_EQ(view.span_s(), PlotView::kMaxSpan_s);
    view.set_span(0.0);
    EXPECT_EQ(view.span_s(), PlotView::kMinSpan_s);
}

TEST(PlotView, AtTheLimitsOfZoomTheViewStaysWhereItIs) {
    MadeUpStore made;
    made.add_until(10.0);
    for (const double factor : {0.8, 1.25}) {
        for (const double share : {0.0, 0.3, 1.0}) {
            PlotView view;
            view.show(made.store(), {4.0, 6.0});
            EXPECT_FALSE(view.is_live());
            const double mouse_s = 4.0 + 2.0 * share;
            for (int notch = 0; notch < 200; ++notch) {
                const TimeWindow now = view.window(made.store());
                const double length_s = now.to_s - now.from_s;
                // As by the wheel.
                view.show(made.store(), {mouse_s - share * factor * length_s,
                                         mouse_s + (1.0 - share) * factor * length_s});
                const TimeWindow then = view.window(made.store());
                ASSERT_NEAR(then.from_s + share * (then.to_s - then.from_s), mouse_s,
                            1e-6 * (then.to_s - then.from_s) + 1e-9)
                    << "notch " << notch << " by " << factor << " at " << share;
            }
            EXPECT_EQ(view.span_s(), factor < 1.0 ? PlotView::kMinSpan_s : PlotView::kMaxSpan_s);
            // At the limit to the last bit, wherever the mouse is.
            const TimeWindow last = view.window(made.store());
            for (const double place : {0.1, 0.37, 0.9}) {
                const double at_s = last.from_s + place * (last.to_s - last.from_s);
                view.show(made.store(), {at_s - factor * (at_s - last.from_s),
                                         at_s + factor * (last.to_s - at_s)});
                expect_same(view.window(made.store()), last);
            }
        }
    }
}

TEST(PlotView, CursorsBeginWithinTheViewAndStayAtTheirTimes) {
    MadeUpStore made;
    made.add_until(10.0);
    PlotView view;
    view.set_span(3.0);
    view.place_cursors(made.store());
    EXPECT_NEAR(view.cursor_s[0], 8.0, 1e-9);
    EXPECT_NEAR(view.cursor_s[1], 9.0, 1e-9);
    made.add_until(11.0);
    view.set_span(1.0);
    EXPECT_NEAR(view.cursor_s[0], 8.0, 1e-9);
}

TEST(PlotView, FollowsAgainWithTheSpanFromBeforeItWasZoomed) {
    MadeUpStore made;
    made.add_until(10.0);
    PlotView view;
    view.set_span(2.0);
    view.show(made.store(), {4.0, 4.1});
    view.show(made.store(), {4.02, 4.03});
    EXPECT_NEAR(view.span_s(), 0.01, 1e-12);
    view.go_live();
    EXPECT_EQ(view.span_s(), 2.0);
    view.show(made.store(), {4.0, 4.1});
    view.set_span(0.5); // chosen while it was zoomed
    view.go_live();
    EXPECT_EQ(view.span_s(), 0.5);
    view.show_event(made.store(), {1.0, 4.0});
    EXPECT_DOUBLE_EQ(view.span_s(), 3.0);
    view.go_live();
    EXPECT_EQ(view.span_s(), 0.5);
}

// --- trigger ---

constexpr double kTick = 1.5e-3; // a window begins or ends at a tick, or just beyond

PlotTriggerSettings triggered_by(TriggerSource source, bool repeats = false) {
    PlotTriggerSettings settings;
    settings.source = source;
    settings.repeats = repeats;
    return settings;
}

PlotTriggerSettings triggered_by_force(TriggerEdge edge, double level_N) {
    PlotTriggerSettings settings = triggered_by(TriggerSource::level);
    settings.channel = channel("force_N");
    settings.edge = edge;
    settings.level_si = level_N;
    return settings;
}

/// A servo that runs, with plots that watch it: rows arrive frame by frame.
class PlotTriggerTest : public ::testing::Test {
protected:
    PlotTriggerTest() { view.set_span(0.4); }

    void arm(const PlotTriggerSettings &settings) {
        trigger.arm(settings, view.span_s(), made.store());
    }
    void arm_at(double time_s, const PlotTriggerSettings &settings) {
        run_until(time_s);
        arm(settings);
    }
    /// From the next tick on.
    void set(std::string_view name, double value) { made[name] = value; }
    void run_until(double time_s) {
        constexpr int kTicksPerFrame = 17;
        while (now_s() < time_s - 0.5 * MadeUpStore::kTick_s) {
            for (int i = 0; i < kTicksPerFrame && now_s() < time_s - 0.5 * MadeUpStore::kTick_s;
                 ++i) {
                made.add();
            }
            trigger.advance(made.store(), view);
        }
    }
    void run_for(double duration_s) { run_until(now_s() + duration_s); }
    [[nodiscard]] double now_s() const {
        return made.store().is_empty() ? -1.0 : made.store().time_s(made.store().end() - 1);
    }
    void expect_event_at(double event_s, double pre_share = 0.25) {
        ASSERT_FALSE(view.is_live()) << "no event is shown";
        const TimeWindow window = view.window(made.store());
        EXPECT_NEAR(window.from_s, event_s - pre_share * view.span_s(), kTick);
        EXPECT_NEAR(window.to_s, event_s + (1.0 - pre_share) * view.span_s(), kTick);
        // The snapshot holds all of it that was there.
        const record::ChannelStore &store = view.store(made.store());
        EXPECT_GE(store.time_s(store.end() - 1), window.to_s - kTick);
    }

    MadeUpStore made;
    PlotView view;
    PlotTrigger trigger;
};

TEST_F(PlotTriggerTest, StopsWithTheContactAtItsShareOfTheSpan) {
    for (const double pre_share : {0.0, 0.25, 1.0}) {
        for (const double span_s : {0.1, 1.0}) {
            view.go_live();
            view.set_span(span_s);
            set("touching", 0.0);
            run_for(span_s + 0.5);
            PlotTriggerSettings settings = triggered_by(TriggerSource::contact);
            settings.pre_share = pre_share;
            arm(settings);
            EXPECT_STREQ(trigger.state_text(), "waiting for the event");
            run_for(0.5);
            EXPECT_TRUE(view.is_live());
            const double event_s = now_s() + MadeUpStore::kTick_s;
            set("touching", 1.0);
            run_for((1.0 - pre_share) * span_s - 0.02);
            EXPECT_TRUE(view.is_live() || pre_share == 1.0) << "before the end of the span";
            EXPECT_STREQ(trigger.state_text(),
                         pre_share < 1.0 ? "collecting" : "waiting for the event");
            run_for(0.5 + span_s);
            expect_event_at(event_s, pre_share);
            EXPECT_NEAR(view.span_s(), span_s, 1e-9);
        }
    }
}

TEST_F(PlotTriggerTest, StaysAtItsOnlyEventUnlessItRepeats) {
    for (const bool repeats : {false, true}) {
        view.go_live();
        set("touching", 0.0);
        run_for(1.0);
        arm(triggered_by(TriggerSource::contact, repeats));
        run_for(0.5);
        const double first_s = now_s() + MadeUpStore::kTick_s;
        for (int i = 0; i < 3; ++i) {
            set("touching", 0.0);
            run_for(i == 0 ? 0.0 : 0.5);
            const double event_s = now_s() + MadeUpStore::kTick_s;
            set("touching", 1.0);
            run_for(0.8);
            expect_event_at(repeats ? event_s : first_s);
        }
    }
}

TEST_F(PlotTriggerTest, WhatLastsIsNoEventNorIsAnythingWhileItIsOff) {
    set("touching", 1.0);
    set("trip_cause", 3.0);
    set("force_N", 8.0);
    set("K_P_V_per_rad", 6.0);
    run_until(1.0);
    for (const PlotTriggerSettings &settings :
         {triggered_by(TriggerSource::contact), triggered_by(TriggerSource::trip),
          triggered_by(TriggerSource::gain_change), triggered_by_force(TriggerEdge::rising, 5.0),
          triggered_by_force(TriggerEdge::change, 5.0)}) {
        arm(settings);
        run_for(1.0);
        EXPECT_TRUE(view.is_live());
    }
    arm(triggered_by(TriggerSource::off));
    set("force_N", 1.0);
    run_for(1.0);
    EXPECT_TRUE(view.is_live());
    EXPECT_STREQ(trigger.state_text(), "");
}

TEST_F(PlotTriggerTest, StopsAtEveryCauseOfATripAndAnyChangeOfTheTuning) {
    const auto expect_stop = [&](TriggerSource source, std::string_view name, double before,
                                 double after) {
        SCOPED_TRACE(std::string(name) + " " + std::to_string(after));
        view.go_live();
        set(name, before);
        run_for(0.5);
        arm(triggered_by(source));
        run_for(0.3);
        ASSERT_TRUE(view.is_live());
        const double event_s = now_s() + MadeUpStore::kTick_s;
        set(name, after);
        run_for(0.5);
        expect_event_at(event_s);
    };
    for (std::size_t cause = 1; cause < servo::kTripCauseNames.size(); ++cause) {
        expect_stop(TriggerSource::trip, "trip_cause", 0.0, static_cast<double>(cause));
    }
    std::vector<std::string_view> names{"map", "alpha_mode"};
    for (const control::Parameter &parameter : control::kParameters) {
        names.push_back(parameter.name);
    }
    for (const std::string_view name : names) {
        expect_stop(TriggerSource::gain_change, name, 2.0, 1.5);
    }
}

TEST_F(PlotTriggerTest, ATuningThatGlidesIsOneEventFromItsBegin) {
    set("dR_Ohm", 0.5);
    arm_at(1.0, triggered_by(TriggerSource::gain_change));
    run_until(1.5);
    for (int i = 1; i <= 50; ++i) {
        set("dR_Ohm", 0.5 + 0.01 * i);
        run_for(MadeUpStore::kTick_s);
    }
    run_until(3.0);
    expect_event_at(1.501);
}

TEST_F(PlotTriggerTest, PassesItsLevelInTheChosenDirectionOnly) {
    for (const auto &[edge, expected_s] :
         std::vector<std::pair<TriggerEdge, double>>{{TriggerEdge::rising, 1.0},
                                                     {TriggerEdge::falling, 2.0},
                                                     {TriggerEdge::either, 1.0},
                                                     {TriggerEdge::change, 0.5}}) {
        view.go_live();
        set("force_N", 0.0);
        run_for(0.5);
        const double begin_s = now_s();
        arm(triggered_by_force(edge, 5.0));
        for (const auto &[time_s, force_N] :
             std::vector<std::pair<double, double>>{{0.5, 4.0}, {1.0, 6.0}, {2.0, 4.5}}) {
            run_until(begin_s + time_s);
            set("force_N", force_N);
        }
        run_for(1.0);
        expect_event_at(begin_s + expected_s + MadeUpStore::kTick_s);
    }
}

TEST_F(PlotTriggerTest, SeesAnEventInTheVeryNextTickAndShortlyAfterTheFirst) {
    view.set_span(2.0);
    arm(triggered_by(TriggerSource::contact)); // before there is any tick
    trigger.advance(made.store(), view);
    run_until(0.2);
    EXPECT_TRUE(view.is_live());
    set("touching", 1.0);
    run_until(3.0);
    expect_event_at(0.201); // begins before the first tick
    view.go_live();
    set("touching", 0.0);
    arm_at(6.0, triggered_by(TriggerSource::contact));
    set("touching", 1.0);
    run_until(9.0);
    expect_event_at(6.001);
}

TEST_F(PlotTriggerTest, AViewThatIsHeldByHandIsNotMoved) {
    const auto expect_shown = [&](double from_s, double to_s) {
        EXPECT_NEAR(view.window(made.store()).from_s, from_s, 1e-9);
        EXPECT_NEAR(view.window(made.store()).to_s, to_s, 1e-9);
    };
    for (const bool repeats : {false, true}) { // zoomed before the event
        view.go_live();
        set("touching", 0.0);
        run_for(1.0);
        arm(triggered_by(TriggerSource::contact, repeats));
        run_for(0.5);
        view.show(made.store(), {1.2, 1.3});
        set("touching", 1.0);
        run_for(1.5);
        expect_shown(1.2, 1.3);
    }
    view.go_live(); // an event that is looked at closely is not replaced by the next
    set("touching", 0.0);
    run_for(1.0);
    arm(triggered_by(TriggerSource::contact, true));
    const double event_s = now_s();
    set("touching", 1.0);
    run_for(0.5);
    expect_event_at(event_s + MadeUpStore::kTick_s);
    view.show(made.store(), {event_s - 0.01, event_s + 0.02});
    for (const double touching : {0.0, 1.0}) {
        set("touching", touching);
        run_for(1.0);
    }
    expect_shown(event_s - 0.01, event_s + 0.02);
}

} // namespace
} // namespace springdrive::app
