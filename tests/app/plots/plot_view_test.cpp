// Covers app/plots/plot_view.cpp.
#include "app/plots/plot_view.h"

#include "tests/support/channel_stores.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace springdrive::app {
namespace {

using signals::TimeWindow;
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
        sum += std::sin(static_cast<double>(row)) * store.value(testing::channel("force_N"), row);
    }
    return sum;
}

TEST(PlotView, ALiveOneEndsAtTheNewestTick) {
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
    const double sum = sum_of_view(view, made.store());
    EXPECT_NE(sum, 0.0);
    for (int until_s = 5; until_s <= 20; ++until_s) {
        add(until_s);
        EXPECT_FALSE(view.is_live());
        expect_same(view.window(made.store()), before);
        EXPECT_EQ(sum_of_view(view, made.store()), sum);
    }
    EXPECT_GT(made.store().time_s(made.store().begin()), before.to_s); // all of it is dropped
    view.go_live();
    EXPECT_NEAR(view.window(made.store()).to_s, 20.0, 1e-9);
    EXPECT_NE(sum_of_view(view, made.store()), sum);
}

TEST(PlotView, HoldingAgainChangesNothing) {
    MadeUpStore made;
    made.add_until(3.0);
    PlotView view;
    view.hold(made.store());
    const TimeWindow before = view.window(made.store());
    made.add_until(9.0);
    view.hold(made.store());
    expect_same(view.window(made.store()), before);
    EXPECT_EQ(view.store(made.store()).end(), 3001U);
}

TEST(PlotView, AHeldOneWithoutAnyTickStaysEmpty) {
    MadeUpStore made;
    PlotView view;
    view.hold(made.store());
    expect_same(view.window(made.store()), {-view.span_s(), 0.0});
    made.add_until(4.0);
    expect_same(view.window(made.store()), {-view.span_s(), 0.0});
    EXPECT_TRUE(view.store(made.store()).is_empty());
    view.go_live();
    EXPECT_NEAR(view.window(made.store()).to_s, 4.0, 1e-9);
}

TEST(PlotView, ShowsAWindowAndHoldsIt) {
    MadeUpStore made;
    made.add_until(10.0);
    PlotView view;
    view.show(made.store(), {2.0, 2.5});
    EXPECT_FALSE(view.is_live());
    EXPECT_DOUBLE_EQ(view.span_s(), 0.5);
    made.add_until(12.0);
    EXPECT_DOUBLE_EQ(view.window(made.store()).from_s, 2.0);
    EXPECT_DOUBLE_EQ(view.window(made.store()).to_s, 2.5);
    view.show(made.store(), {11.0, 12.0}); // after the snapshot, which stays what it is
    EXPECT_EQ(view.store(made.store()).end(), 10'001U);
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
                EXPECT_EQ(view.window(made.store()).from_s, last.from_s);
                EXPECT_EQ(view.window(made.store()).to_s, last.to_s);
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

TEST(PlotView, EndsWhereARecordStands) {
    MadeUpStore made;
    made.add_until(10.0);
    PlotView view;
    view.set_span(2.0);
    view.follow(4.5);
    EXPECT_DOUBLE_EQ(view.window(made.store()).to_s, 4.5);
    EXPECT_DOUBLE_EQ(view.window(made.store()).from_s, 2.5);
    view.hold(made.store());
    view.follow(6.0); // a held view does not move
    EXPECT_DOUBLE_EQ(view.window(made.store()).to_s, 4.5);
    view.go_live();
    EXPECT_DOUBLE_EQ(view.window(made.store()).to_s, 6.0);
    view.follow(std::nullopt);
    EXPECT_DOUBLE_EQ(view.window(made.store()).to_s, made.store().time_s(made.store().end() - 1));
}

} // namespace
} // namespace springdrive::app
