// Covers app/plots/plot_trigger.cpp.
#include "app/plots/plot_trigger.h"

#include "engine/control/tuning.h"
#include "engine/servo/safety_status.h"
#include "tests/support/channel_stores.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app {
namespace {

using signals::TimeWindow;
using signals::TriggerEdge;
using testing::channel;
using testing::MadeUpStore;

constexpr double kTick = 1.5e-3; // a window begins or ends at a tick, or just beyond

/// A servo that runs, with plots that watch it: rows arrive frame by frame.
class WatchedServo {
public:
    void arm(const PlotTriggerSettings &settings) {
        trigger.arm(settings, view.span_s(), made.store());
    }
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
    [[nodiscard]] double now_s() const {
        return made.store().is_empty() ? -1.0 : made.store().time_s(made.store().end() - 1);
    }
    [[nodiscard]] TimeWindow window() const { return view.window(made.store()); }

    MadeUpStore made;
    PlotView view;
    PlotTrigger trigger;
};

PlotTriggerSettings triggered_by(TriggerSource source) {
    PlotTriggerSettings settings;
    settings.source = source;
    return settings;
}

PlotTriggerSettings triggered_by_force(TriggerEdge edge, double level_N) {
    PlotTriggerSettings settings = triggered_by(TriggerSource::level);
    settings.channel = channel("force_N");
    settings.edge = edge;
    settings.level_si = level_N;
    return settings;
}

void expect_event_at(const WatchedServo &servo, double event_s, double pre_share) {
    ASSERT_FALSE(servo.view.is_live()) << "no event is shown";
    const TimeWindow window = servo.window();
    EXPECT_NEAR(window.from_s, event_s - pre_share * servo.view.span_s(), kTick);
    EXPECT_NEAR(window.to_s, event_s + (1.0 - pre_share) * servo.view.span_s(), kTick);
    // The snapshot holds all of it that was there.
    const record::ChannelStore &store = servo.view.store(servo.made.store());
    EXPECT_GE(store.time_s(store.end() - 1), window.to_s - kTick);
}

TEST(PlotTrigger, StopsWithTheContactAtItsShareOfTheSpan) {
    for (const double pre_share : {0.0, 0.25, 0.5, 1.0}) {
        for (const double span_s : {0.1, 1.0, 3.0}) {
            WatchedServo servo;
            servo.view.set_span(span_s);
            servo.run_until(4.0);
            PlotTriggerSettings settings = triggered_by(TriggerSource::contact);
            settings.pre_share = pre_share;
            servo.arm(settings);
            servo.run_until(5.0);
            EXPECT_TRUE(servo.view.is_live());
            servo.made["touching"] = 1.0;
            servo.run_until(5.0 + (1.0 - pre_share) * span_s - 0.02);
            EXPECT_TRUE(servo.view.is_live() || pre_share == 1.0) << "before the end of the span";
            servo.run_until(5.5 + span_s);
            expect_event_at(servo, 5.001, pre_share);
            EXPECT_NEAR(servo.view.span_s(), span_s, 1e-9);
        }
    }
}

TEST(PlotTrigger, StaysAtItsOnlyEvent) {
    WatchedServo servo;
    servo.view.set_span(0.5);
    servo.run_until(1.0);
    servo.arm(triggered_by(TriggerSource::contact));
    servo.run_until(1.5);
    servo.made["touching"] = 1.0;
    servo.run_until(3.0);
    expect_event_at(servo, 1.501, 0.25);
    const TimeWindow shown = servo.window();
    for (int i = 0; i < 5; ++i) {
        servo.made["touching"] = 0.0;
        servo.run_until(servo.now_s() + 0.7);
        servo.made["touching"] = 1.0;
        servo.run_until(servo.now_s() + 0.7);
        EXPECT_EQ(servo.window().from_s, shown.from_s);
        EXPECT_EQ(servo.window().to_s, shown.to_s);
    }
}

TEST(PlotTrigger, CanBeArmedAgainAndAgain) {
    WatchedServo servo;
    servo.view.set_span(0.4);
    servo.run_until(1.0);
    for (int i = 0; i < 4; ++i) {
        servo.made["touching"] = 0.0;
        servo.run_until(servo.now_s() + 0.5);
        servo.view.go_live();
        servo.arm(triggered_by(TriggerSource::contact));
        EXPECT_STREQ(servo.trigger.state_text(), "waiting for the event");
        servo.run_until(servo.now_s() + 0.5);
        const double event_s = servo.now_s() + MadeUpStore::kTick_s;
        servo.made["touching"] = 1.0;
        servo.run_until(servo.now_s() + 0.1);
        EXPECT_STREQ(servo.trigger.state_text(), "collecting");
        servo.run_until(servo.now_s() + 0.6);
        expect_event_at(servo, event_s, 0.25);
    }
}

TEST(PlotTrigger, ShowsEachEventIfItRepeats) {
    WatchedServo servo;
    servo.view.set_span(0.4);
    servo.run_until(1.0);
    PlotTriggerSettings settings = triggered_by(TriggerSource::contact);
    settings.repeats = true;
    servo.arm(settings);
    for (int i = 0; i < 4; ++i) {
        servo.made["touching"] = 0.0;
        servo.run_until(servo.now_s() + 0.5);
        const double event_s = servo.now_s() + MadeUpStore::kTick_s;
        servo.made["touching"] = 1.0;
        servo.run_until(servo.now_s() + 0.8);
        expect_event_at(servo, event_s, 0.25);
    }
}

TEST(PlotTrigger, WhatLastsIsNoEvent) {
    WatchedServo servo;
    servo.view.set_span(0.4);
    servo.made["touching"] = 1.0;
    servo.made["trip_cause"] = 3.0;
    servo.made["force_N"] = 8.0;
    servo.made["K_P_V_per_rad"] = 6.0;
    servo.run_until(1.0);
    for (const PlotTriggerSettings &settings :
         {triggered_by(TriggerSource::contact), triggered_by(TriggerSource::trip),
          triggered_by(TriggerSource::gain_change), triggered_by_force(TriggerEdge::rising, 5.0),
          triggered_by_force(TriggerEdge::change, 5.0)}) {
        servo.arm(settings);
        servo.run_until(servo.now_s() + 1.0);
        EXPECT_TRUE(servo.view.is_live());
    }
}

TEST(PlotTrigger, ShowsNothingWhileItIsOff) {
    WatchedServo servo;
    servo.view.set_span(0.4);
    servo.run_until(1.0);
    servo.arm(triggered_by(TriggerSource::contact));
    servo.arm(triggered_by(TriggerSource::off));
    servo.made["touching"] = 1.0;
    servo.run_until(3.0);
    EXPECT_TRUE(servo.view.is_live());
    EXPECT_STREQ(servo.trigger.state_text(), "");
}

TEST(PlotTrigger, StopsAtEveryCauseOfATrip) {
    for (std::size_t cause = 1; cause < servo::kTripCauseNames.size(); ++cause) {
        WatchedServo servo;
        servo.view.set_span(0.4);
        servo.run_until(1.0);
        servo.arm(triggered_by(TriggerSource::trip));
        servo.run_until(1.5);
        servo.made["trip_cause"] = static_cast<double>(cause);
        servo.run_until(2.5);
        expect_event_at(servo, 1.501, 0.25);
    }
}

TEST(PlotTrigger, StopsAtAnyChangeOfTheTuning) {
    std::vector<std::string_view> names{"map", "alpha_mode"};
    for (const control::Parameter &parameter : control::kParameters) {
        names.push_back(parameter.name);
    }
    for (const std::string_view name : names) {
        WatchedServo servo;
        servo.view.set_span(0.4);
        servo.made[name] = 2.0;
        servo.run_until(1.0);
        servo.arm(triggered_by(TriggerSource::gain_change));
        servo.run_until(1.5);
        ASSERT_TRUE(servo.view.is_live()) << name;
        servo.made[name] = 1.5;
        servo.run_until(2.5);
        expect_event_at(servo, 1.501, 0.25);
    }
}

TEST(PlotTrigger, ATuningThatGlidesIsOneEventFromItsBegin) {
    WatchedServo servo;
    servo.view.set_span(0.4);
    servo.made["dR_Ohm"] = 0.5;
    servo.run_until(1.0);
    servo.arm(triggered_by(TriggerSource::gain_change));
    servo.run_until(1.5);
    for (int i = 1; i <= 50; ++i) {
        servo.made["dR_Ohm"] = 0.5 + 0.01 * i;
        servo.run_until(servo.now_s() + MadeUpStore::kTick_s);
    }
    servo.run_until(3.0);
    expect_event_at(servo, 1.501, 0.25);
}

TEST(PlotTrigger, PassesItsLevelInTheChosenDirectionOnly) {
    struct Case {
        TriggerEdge edge;
        double rises_at_s, falls_at_s, expected_s;
    };
    for (const Case &known : std::vector<Case>{{TriggerEdge::rising, 2.0, 3.0, 2.001},
                                               {TriggerEdge::falling, 2.0, 3.0, 3.001},
                                               {TriggerEdge::either, 2.0, 3.0, 2.001},
                                               {TriggerEdge::change, 2.0, 3.0, 1.501}}) {
        WatchedServo servo;
        servo.view.set_span(0.4);
        servo.run_until(1.0);
        servo.arm(triggered_by_force(known.edge, 5.0));
        servo.run_until(1.5);
        servo.made["force_N"] = 4.0;
        servo.run_until(known.rises_at_s);
        servo.made["force_N"] = 6.0;
        servo.run_until(known.falls_at_s);
        servo.made["force_N"] = 4.5;
        servo.run_until(4.0);
        expect_event_at(servo, known.expected_s, 0.25);
    }
}

TEST(PlotTrigger, SeesAnEventInTheVeryNextTick) {
    WatchedServo servo;
    servo.view.set_span(0.4);
    servo.run_until(1.0);
    servo.arm(triggered_by(TriggerSource::contact));
    servo.made["touching"] = 1.0;
    servo.run_until(2.0);
    expect_event_at(servo, 1.001, 0.25);
}

TEST(PlotTrigger, AnEventShortlyAfterTheFirstTickIsShown) {
    WatchedServo servo;
    servo.view.set_span(2.0);
    servo.run_until(0.1);
    servo.arm(triggered_by(TriggerSource::contact));
    servo.run_until(0.2);
    servo.made["touching"] = 1.0;
    servo.run_until(3.0);
    expect_event_at(servo, 0.201, 0.25); // begins before the first tick
}

TEST(PlotTrigger, ArmedBeforeTheFirstTickItWaits) {
    WatchedServo servo;
    servo.view.set_span(0.4);
    servo.arm(triggered_by(TriggerSource::contact));
    servo.trigger.advance(servo.made.store(), servo.view);
    servo.run_until(1.0);
    EXPECT_TRUE(servo.view.is_live());
    servo.made["touching"] = 1.0;
    servo.run_until(2.0);
    expect_event_at(servo, 1.001, 0.25);
}

TEST(PlotTrigger, AViewThatWasHeldMeanwhileIsNotMoved) {
    for (const bool repeats : {false, true}) {
        WatchedServo servo;
        servo.view.set_span(0.4);
        servo.run_until(1.0);
        PlotTriggerSettings settings = triggered_by(TriggerSource::contact);
        settings.repeats = repeats;
        servo.arm(settings);
        servo.run_until(1.5);
        servo.view.show(servo.made.store(), {1.2, 1.3}); // zoomed by hand
        servo.made["touching"] = 1.0;
        servo.run_until(3.0);
        EXPECT_NEAR(servo.window().from_s, 1.2, 1e-9) << repeats;
        EXPECT_NEAR(servo.window().to_s, 1.3, 1e-9) << repeats;
    }
}

TEST(PlotTrigger, AnEventThatIsLookedAtCloselyIsNotReplacedByTheNext) {
    WatchedServo servo;
    servo.view.set_span(0.4);
    servo.run_until(1.0);
    PlotTriggerSettings settings = triggered_by(TriggerSource::contact);
    settings.repeats = true;
    servo.arm(settings);
    servo.run_until(1.5);
    servo.made["touching"] = 1.0;
    servo.run_until(2.0);
    expect_event_at(servo, 1.501, 0.25);
    servo.view.show(servo.made.store(), {1.49, 1.52}); // zoomed by hand
    servo.made["touching"] = 0.0;
    servo.run_until(3.0);
    servo.made["touching"] = 1.0;
    servo.run_until(4.0);
    EXPECT_NEAR(servo.window().from_s, 1.49, 1e-9);
    EXPECT_NEAR(servo.window().to_s, 1.52, 1e-9);
}

} // namespace
} // namespace springdrive::app
