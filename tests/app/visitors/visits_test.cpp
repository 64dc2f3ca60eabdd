// Covers app/visitors/visits.cpp: whole visits on the simulated device, in lockstep, with visitors
// and a window that are made up (see tests/app/window/kiosk_test.cpp for the real window); and
// what the task's protocol finds of visitors whose thresholds are known.
#include "app/visitors/visits.h"

#include "device/core/faults.h"
#include "engine/study/observers/simulated_study_session.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/session_plan.h"
#include "tests/app/study/headless_study.h"
#include "tests/app/study/made_up_people.h"
#include "tests/support/cases.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace springdrive::app::visitors {
namespace {

namespace fs = std::filesystem;

using study_screen::OwnCurve;
using study_screen::ParticipantPicture;
using study_screen::StudySessionFrame;
using study_screen::StudySessionState;
using study_screen::StudySessionStep;

study::Protocol shipped(const std::string &name) {
    return study::read_protocol_file(testing::assets() / "protocols" / (name + ".toml"));
}

bool is_start(const ParticipantPicture &picture) { return picture.heading == "Can you feel it?"; }

/// A frame, before anybody acts in it.
struct Moment {
    session::Session &session;
    const ParticipantPicture &picture;
    const StudySessionState &state;
    int starts;     ///< how often the start was come to
    bool &ends_all; ///< everything ends with this frame
};

int answers_in(const OwnCurve &curve) {
    int answers = 0;
    for (const OwnCurve::Dot &dot : curve.dots) {
        answers += dot.trials;
    }
    return answers;
}

/// What visitors do is decided frame by frame: the key that is pressed, or none.
class Visiting : public ::testing::Test {
protected:
    using Act = std::function<std::string(const Moment &)>;

    Visiting() {
        plan_.protocol = shipped("can_you_feel_it");
        plan_.setting = study::study_setting(plan_.protocol, folders_);
        plan_.folders = folders_;
        plan_.made_up = study::expected_observer(plan_.protocol);
        plan_.has_device = true;
        auto &method = std::get<study::QuestPlus>(plan_.protocol.method);
        method.min_trials = method.max_trials = 6; // a minute
    }

    /// Until `act` says that everything ends. @return visits that were begun
    int run(const Act &act) {
        session::SessionOptions options;
        options.scene = study::scene_file_of(plan_.protocol.conditions.front(), folders_);
        options.device.file = study::device_file_of(plan_.protocol, folders_);
        options.lockstep = true;
        if (!faults_.empty()) {
            options.device.kind = factory::DeviceKind::emulated;
            options.starts_at_zero = true;
            for (const char *fault : faults_) {
                options.emulation.faults.push_back(device::parse_fault(fault));
            }
        }
        session::Session session(options);
        session.start();
        Visits visits(plan_, session, [](const scene::Scene &, const scene::TouchSpot &) {});
        visits.start();
        int starts = 0;
        bool was_start = false;
        bool ends_all = false;
        for (int frame = 0; !visits.is_over(); ++frame) {
            session.advance(study_screen::kMadeUpFrame_s);
            const ParticipantPicture &picture = visits.picture();
            starts += is_start(picture) && !was_start ? 1 : 0;
            was_start = is_start(picture);
            StudySessionFrame input;
            const std::string key = act({session, picture, visits.state(), starts, ends_all});
            if (!key.empty()) {
                input.inputs.push_back(study_screen::MadeUpPort::key(key, session.servo().now_s()));
            }
            EXPECT_LE(frame, 60 * 900) << "stuck at: " << picture.heading; // a quarter of an hour
            input.orders.stops = ends_all || frame > 60 * 900;
            visits.resume(std::move(input));
        }
        return visits.begun();
    }

    /// A visitor whose answers are drawn from a known function.
    [[nodiscard]] std::string answer_to(const StudySessionState &state) const {
        study::SimulatedParticipant visitor;
        visitor.function = plan_.made_up;
        const study::SimulatedAnswer answer =
            study::simulated_answer(plan_.protocol, visitor, *state.trial, *state.trial->level);
        const auto *chosen = std::get_if<study::Chosen>(&answer.response);
        return chosen != nullptr && chosen->alternative == 2 ? "2" : "1";
    }

    /// What somebody presses who does all that is asked for.
    [[nodiscard]] std::string willing(const Moment &now) const {
        if (is_start(now.picture)) {
            return "enter";
        }
        switch (now.state.step) {
        case StudySessionStep::instructions:
        case StudySessionStep::practice_begins:
        case StudySessionStep::practice_ends:
            return "enter";
        case StudySessionStep::response:
            return answer_to(now.state);
        default:
            return {};
        }
    }

    study::ProtocolFolders folders_{testing::assets() / "protocols", testing::assets()};
    VisitsPlan plan_;
    std::vector<const char *> faults_; ///< of an emulated board; none: a simulated device
};

/// Names and sizes of all files below.
std::vector<std::pair<fs::path, std::uintmax_t>> listing(const fs::path &folder) {
    std::vector<std::pair<fs::path, std::uintmax_t>> files;
    for (const fs::directory_entry &entry : fs::recursive_directory_iterator(folder)) {
        files.emplace_back(entry.path(), entry.is_regular_file() ? entry.file_size() : 0);
    }
    std::ranges::sort(files);
    return files;
}

/// Also after a stop by hand, when the visitor wants to go on.
TEST_F(Visiting, EndsWithTheVisitorsOwnCurveAndLeavesNoFile) {
    const fs::path folder = testing::fresh_folder("visits");
    const fs::path before = fs::current_path();
    fs::copy(folders_.own, folder, fs::copy_options::recursive);
    plan_.folders.own = folder; // beside the protocol, or where the program runs
    fs::current_path(folder);
    const auto then = listing(folder);
    bool was_stopped = false;
    int frames_stopped = 0;
    int answers = 0;
    run([&](const Moment &now) -> std::string {
        if (now.state.step == StudySessionStep::interval && now.state.trials.size() == 2 &&
            !std::exchange(was_stopped, true)) {
            EXPECT_EQ(listing(folder), then) << "in the midst of a visit";
            now.session.servo().emergency_stop();
        }
        if (now.state.step == StudySessionStep::device_stopped) {
            return ++frames_stopped == 300 ? "enter" : ""; // longer than it resets itself
        }
        if (now.picture.curve && now.picture.choices.size() == 1) {
            EXPECT_EQ(now.picture.heading.find("You feel a force that is turned by "), 0U)
                << now.picture.heading;
            EXPECT_NE(now.picture.text.find("Nothing of this is kept"), std::string::npos);
            answers = answers_in(*now.picture.curve);
            EXPECT_FALSE(now.picture.curve->course.empty());
            now.ends_all = true;
        }
        return willing(now);
    });
    EXPECT_GE(frames_stopped, 300);
    EXPECT_EQ(answers, 6); // practice does not count
    fs::current_path(before);
    EXPECT_EQ(listing(folder), then);
}

/// The first leaves after two trials, the second one by Escape.
TEST_F(Visiting, IsOverWhenTheVisitorGoesAndBeginsAfreshForTheNext) {
    double last_act_s = 0.0;
    double gone_s = 0.0;
    int asked = 0; ///< whether somebody is still there: frames
    struct First {
        int position;
        std::uint64_t seed;
        double progress;
    };
    std::vector<First> first_trials; ///< a visitor each
    const int begun = run([&](const Moment &now) -> std::string {
        const double now_s = now.session.servo().now_s();
        if (now.starts == 2 && gone_s == 0.0) {
            gone_s = now_s;
        }
        asked += now.picture.heading == "Still there?" ? 1 : 0;
        now.ends_all = now.starts == 3;
        if (now.state.step == StudySessionStep::interval && !now.ends_all &&
            first_trials.size() < static_cast<std::size_t>(now.starts)) {
            first_trials.push_back(
                {now.state.trial->place.position, now.state.trial->seed, now.state.progress});
            return now.starts == 2 ? "escape" : "";
        }
        if (now.starts == 1 && now.state.trials.size() >= 2) {
            return {};
        }
        const std::string key = willing(now);
        last_act_s = now.starts == 1 && !key.empty() ? now_s : last_act_s;
        return key;
    });
    EXPECT_EQ(begun, 2);
    EXPECT_NEAR(gone_s - last_act_s, kGoneAfter_s, 0.1); // six frames
    EXPECT_NEAR(asked, 60.0 * (kGoneAfter_s - kAskedAfter_s), 6.0);
    ASSERT_EQ(first_trials.size(), 2U);
    for (const First &first : first_trials) {
        EXPECT_EQ(first.position, 1);
        EXPECT_EQ(first.progress, 0.0);
    }
    EXPECT_NE(first_trials[0].seed, first_trials[1].seed) << "the same trials again";
}

/// Or a stopped device would go on for somebody who only said so.
TEST_F(Visiting, WhoAnswersStillThereStaysAndDoesNothingElse) {
    bool was_asked = false;
    int read_on = 0; ///< frames of the instructions after that
    const int begun = run([&](const Moment &now) -> std::string {
        if (now.picture.heading == "Still there?") {
            EXPECT_EQ(now.picture.choices.size(), 1U);
            was_asked = true;
            return "enter"; // which would leave the instructions, too
        }
        if (!is_start(now.picture) && now.state.step == StudySessionStep::instructions) {
            read_on += was_asked ? 1 : 0;
            return read_on > 60 * 12 ? "enter" : ""; // it would be over after ten seconds
        }
        now.ends_all = now.state.step == StudySessionStep::interval || now.starts == 2;
        return willing(now);
    });
    EXPECT_TRUE(was_asked);
    EXPECT_GT(read_on, 60 * 12);
    EXPECT_EQ(begun, 1);
}

/// The next visitor finds a stopped device that only somebody's wish lets go on. The monitor knows
/// no more than what stopped it first.
TEST_F(Visiting, AStopByHandOutlastsTheVisit) {
    for (const auto &[faults, is_pressed] :
         {std::pair<std::vector<const char *>, bool>{{"stop@4-4.5"}, false},
          {{"brown-out:9@4-4.1", "stop@5-5.5"}, false},
          {{"brown-out:9@4-4.1"}, true}}) {
        SCOPED_TRACE(faults.back());
        faults_ = faults;
        int frames_stopped = 0; ///< of both visits
        bool ran_again = false;
        run([&, presses = is_pressed](const Moment &now) -> std::string {
            if (now.state.step == StudySessionStep::device_stopped) {
                if (now.starts == 1) {
                    ++frames_stopped;
                    if (frames_stopped == 60 && presses) {
                        now.session.servo().emergency_stop();
                    }
                    return frames_stopped == 120 ? "escape" : ""; // before it resets itself
                }
                frames_stopped = std::max(frames_stopped, 120);
                EXPECT_NE(now.session.latest().safety.state, servo::SafetyState::running);
                return ++frames_stopped == 120 + 300 ? "enter" : ""; // five seconds
            }
            ran_again = now.starts == 2 && now.state.step == StudySessionStep::interval;
            now.ends_all = ran_again;
            return willing(now);
        });
        EXPECT_GE(frames_stopped, 120 + 300);
        EXPECT_TRUE(ran_again);
    }
}

/// Their keys are no answers, and stop the device whatever is on the screen.
TEST_F(Visiting, WhoStopsTheDeviceIsStillThere) {
    bool was_asked = false;
    int frames_stopped = 0;
    const int begun = run([&](const Moment &now) -> std::string {
        if (now.picture.heading == "Still there?" && !std::exchange(was_asked, true)) {
            now.session.servo().emergency_stop();
            return {};
        }
        frames_stopped += was_asked && now.picture.heading != "Still there?" ? 1 : 0;
        now.ends_all = now.starts == 2 || frames_stopped == 60 * 12;
        return is_start(now.picture) ? "enter" : "";
    });
    EXPECT_TRUE(was_asked);
    EXPECT_EQ(frames_stopped, 60 * 12) << "it would be over after ten seconds";
    EXPECT_EQ(begun, 1);
}

/// The first time the device is stopped, for longer than until a person would be gone: a visitor
/// who is made up is nobody who could let it go on, and is not asked. The second time the fast
/// motion is left by Escape, without a curve.
TEST_F(Visiting, ShowsAMadeUpVisitorAndReckonsTheRest) {
    plan_.has_device = false;
    constexpr int kStopped = 60 * 45; ///< frames
    static_assert(kStopped > 60 * kGoneAfter_s);
    bool was_stopped = false;
    int frames_stopped = 0;
    int asked = 0; ///< whether somebody is still there: frames
    int shown = 0;
    std::vector<int> growing; ///< answers in the curve
    std::string heading;
    std::string text;
    run([&](const Moment &now) -> std::string {
        const bool has_result = now.picture.curve && !now.picture.choices.empty();
        asked += now.picture.heading == "Still there?" ? 1 : 0;
        now.ends_all = now.starts == 3;
        if (is_start(now.picture)) {
            return "1";
        }
        if (now.starts == 2) {
            EXPECT_FALSE(has_result);
            return now.picture.curve ? "escape" : "";
        }
        if (now.state.step == StudySessionStep::interval && !std::exchange(was_stopped, true)) {
            now.session.servo().emergency_stop();
        }
        if (now.state.step == StudySessionStep::device_stopped) {
            return ++frames_stopped == kStopped ? "enter" : "";
        }
        shown = std::max(shown, static_cast<int>(now.state.trials.size()));
        if (!now.picture.curve) {
            return {};
        }
        if (const int answers = answers_in(*now.picture.curve);
            growing.empty() || growing.back() != answers) {
            growing.push_back(answers);
        }
        heading = now.picture.heading;
        text = now.picture.text;
        return has_result ? "enter" : "";
    });
    EXPECT_GE(frames_stopped, kStopped);
    EXPECT_EQ(asked, 0);
    EXPECT_EQ(shown, static_cast<int>(kShownTrials));
    ASSERT_FALSE(growing.empty());
    EXPECT_EQ(growing.back(), 6);
    EXPECT_TRUE(std::ranges::is_sorted(growing));
    // By one answer at a time.
    EXPECT_EQ(growing.size(), static_cast<std::size_t>(6 - growing.front() + 1));
    EXPECT_GE(growing.size(), 4U);
    EXPECT_EQ(heading.find("The made-up visitor feels a force that is turned by "), 0U) << heading;
    EXPECT_NE(text.find("In truth it was 25 degrees."), std::string::npos) << text;
}

/// A show goes on by itself: nobody presses anything.
TEST_F(Visiting, AShowGoesFromVisitorToVisitor) {
    plan_.has_device = false;
    plan_.is_show = true;
    EXPECT_EQ(run([](const Moment &now) {
                  now.ends_all = now.starts == 2;
                  return std::string();
              }),
              1);
}

/// A whole visit without the hand.
study::StudyContents visit_of(const study::Protocol &protocol,
                              const study::SimulatedParticipant &visitor, int number) {
    const auto present = [&](const study::PlannedTrial &planned) {
        study::Trial result(planned);
        result.response =
            study::simulated_answer(protocol, visitor, planned, *planned.level).response;
        return result;
    };
    return testing::conducted(protocol, present, number);
}

/// Visitors drawn from what the method thinks possible: then a 95 % interval holds 95 of 100, of
/// which 100 draws keep within 89 to 99 with a probability of 0.99 (binomial). The default tests
/// draw 12, of which fewer than 9 have a probability of 0.002; `tests/long visits` all.
TEST(CurveOfAnswers, IntervalHoldsTheThresholdIn95Of100Visits) {
    const study::Protocol protocol = shipped("can_you_feel_it");
    const int visits = testing::cases(12, 100);
    int held = 0;
    std::vector<double> factors; ///< of the intervals, from end to end
    const study::RandomKey key = study::key_of(7, 1);
    for (int i = 0; i < visits; ++i) {
        const auto draw = [&](std::uint64_t which) {
            return study::uniform(
                study::child(study::child(key, static_cast<std::uint64_t>(i)), which));
        };
        study::SimulatedParticipant visitor;
        visitor.function.threshold = 2.0 * std::pow(30.0, draw(0)); // 2 to 60 degrees
        visitor.function.slope = 0.7 * std::pow(10.0, draw(1));     // 0.7 to 7
        visitor.function.lapse = 0.06 * draw(2);
        visitor.seed = static_cast<std::uint64_t>(i) + 1;
        const auto result = result_of_visit(protocol, visit_of(protocol, visitor, i + 1));
        ASSERT_TRUE(result && result->fitted);
        EXPECT_EQ(result->trials, 34);
        const OwnCurve curve = curve_of(protocol, result);
        const double threshold = visitor.function.threshold;
        held += threshold >= curve.threshold->low && threshold <= curve.threshold->high ? 1 : 0;
        factors.push_back(curve.threshold->high / curve.threshold->low);
    }
    EXPECT_GE(held, testing::cases(9, 89));
    EXPECT_LE(held, testing::cases(12, 99));
    const auto median = factors.begin() + visits / 2;
    std::ranges::nth_element(factors, median);
    // Not because it says nothing: what is thought possible is a factor of 30.
    EXPECT_LT(*median, 8.0);
    std::printf("counts: %d of %d intervals hold the threshold; from end to end a factor of %.2f "
                "in the median\n",
                held, visits, *median);
}

TEST(CurveOfAnswers, HasADotForEachLevelWithAllAnswers) {
    const study::Protocol protocol = shipped("can_you_feel_it");
    study::SimulatedParticipant visitor;
    visitor.function = {{}, 15.0, 2.0, 0.5, 0.02};
    const study::StudyContents visit = visit_of(protocol, visitor, 1);
    const OwnCurve curve = curve_of(protocol, result_of_visit(protocol, visit));
    for (const OwnCurve::Dot &dot : curve.dots) {
        int trials = 0;
        int right = 0;
        for (const study::Trial &trial : visit.trials) { // counted anew
            const bool is_meant = !trial.is_practice && trial.level == dot.level;
            trials += is_meant ? 1 : 0;
            right += is_meant && trial.is_correct.value_or(false) ? 1 : 0;
        }
        EXPECT_EQ(dot.trials, trials);
        EXPECT_DOUBLE_EQ(dot.right_share, static_cast<double>(right) / trials);
    }
    EXPECT_TRUE(std::ranges::is_sorted(curve.course, {}, &OwnCurve::Point::level));
    EXPECT_EQ(curve.lowest_level, 2.0);
    EXPECT_EQ(curve.highest_level, 60.0);
}

TEST(CurveOfAnswers, SaysTheThresholdInPlainWords) {
    OwnCurve curve = curve_of(shipped("can_you_feel_it"), std::nullopt);
    EXPECT_EQ(threshold_words(curve), "");
    curve.threshold = {14.2, 9.4, 21.6};
    EXPECT_EQ(threshold_words(curve), "14 degrees (9 to 22)");
    curve.threshold = {48.0, 31.0, 59.0}; // up to the end: it may be anything beyond
    EXPECT_EQ(threshold_words(curve), "more than 31 degrees");
    curve.threshold = {2.6, 2.05, 4.4};
    EXPECT_EQ(threshold_words(curve), "less than 4 degrees");
    curve.threshold = {20.0, 2.3, 56.0}; // just off both ends
    EXPECT_EQ(threshold_words(curve), "20 degrees (2 to 56)");
}

TEST(CurveOfAnswers, TakesTheVisitorsProtocolAndRefusesOthers) {
    EXPECT_EQ(validate_for_visitors(shipped("can_you_feel_it")), "");
    for (const char *name : {"direction", "stiffness", "blow", "hardness", "mass"}) {
        EXPECT_NE(validate_for_visitors(shipped(name)), "") << name;
    }
    study::Protocol protocol = shipped("can_you_feel_it");
    protocol.variable.parameter = "eta";
    EXPECT_NE(validate_for_visitors(protocol).find("turn_deg"), std::string::npos);
    protocol = shipped("can_you_feel_it");
    protocol.noise = study::MaskingNoise{-30.0};
    EXPECT_NE(validate_for_visitors(protocol).find("[noise]"), std::string::npos);
    protocol = shipped("can_you_feel_it");
    protocol.questionnaire = shipped("direction").questionnaire;
    EXPECT_NE(validate_for_visitors(protocol).find("[[questions]]"), std::string::npos);
}

} // namespace
} // namespace springdrive::app::visitors
