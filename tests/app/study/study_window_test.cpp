// Covers app/commands/study/study_turns.cpp, app/study/experimenter/study_window.cpp and all
// below them: a participant and an experimenter at the two real windows, by mouse and keyboard,
// through a study in which everything happens that may: a stop, a trial that is repeated, a pause,
// a break, a device that is lost, a program that is killed in a trial, and a day that is ended and
// gone on with. The store must be what the same decisions give without windows, trial by trial.
//
// By frame time, so that a busy machine only takes longer: some minutes for each study. By default
// one of few trials is killed and gone on with; `tests/long study-windows` runs one in which all of
// that happens, and each included protocol with the fewest trials that its method can be told to
// take.
//
// And the times of app/study/participant/participant_window.cpp: keys are pressed at known times of
// CLOCK_MONOTONIC, 10 to 2000 ms after a presentation, and each response time in the store is held
// against them. The servo runs by its clock, in real time. The default tests press some keys;
// `tests/long response-times` 200.
#include "engine/study/observers/simulated_study_session.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/store/study_store.h"
#include "tests/app/study/headless_study.h"
#include "tests/app/study/study_program.h"
#include "tests/support/cases.h"
#include "tests/support/devices.h"
#include "tests/support/pressed_keys.h"
#include "tests/support/program.h"
#include "tests/support/shown_window.h"
#include "tests/support/virtual_display.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <regex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

namespace springdrive::testing {

/// A session in its two real windows, with somebody at the participant's keyboard and mouse and
/// somebody at the experimenter's: on a virtual display, by events of the X server.
class StudyDesk {
public:
    /// Starts `springdrive study` with these arguments, puts the windows side by side, and gives
    /// the participant's the keyboard, as a window manager would.
    StudyDesk(std::vector<std::string> arguments, const std::filesystem::path &folder)
        : display_(kExperimenter_px + kParticipant_px, kHeight_px),
          program_(display_, with_windows(std::move(arguments)), folder), keys_(display_.name()) {
        const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
        while (!keys_.move_window("springdrive", kExperimenter_px, 0)) {
            if (std::chrono::steady_clock::now() > give_up || !program_.is_running()) {
                throw std::runtime_error("there is no window for the participant: " +
                                         program_.error());
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        static_cast<void>(look());
        keys_.focus("springdrive");
    }

    [[nodiscard]] Report look() {
        program_.send_line("report");
        const std::optional<std::string> line = program_.read_line(std::chrono::seconds(60));
        if (!line) {
            throw std::runtime_error("the windows do not report: " + program_.error());
        }
        return Report(nlohmann::json::parse(*line));
    }

    /// The participant's keyboard: the key is pressed and released at once.
    void press(const std::string &key) { keys_.tap(key); }
    /// The participant's mouse: on the plate with this number, from 0.
    void click_card(const Report &report, std::size_t card) {
        std::size_t number = 0;
        for (const nlohmann::json &item : report.all().at("items")) {
            if (item.at("id") == "participant/choice" && number++ == card) {
                keys_.click(kExperimenter_px + middle_px(item, "x", "width"),
                            middle_px(item, "y", "height"));
                return;
            }
        }
        throw std::runtime_error("there is no plate " + std::to_string(card) + ": " +
                                 report.texts());
    }
    /// The experimenter's mouse; the keyboard stays the participant's.
    void click(const std::string &id) {
        click_last(id);
        static_cast<void>(look());
    }
    /// The same, with a button after which the windows are gone.
    void click_last(const std::string &id) { // ImGui looks at the mouse once a frame
        const Report report = look();
        const nlohmann::json &item = report.item(id);
        keys_.move_to(middle_px(item, "x", "width"), middle_px(item, "y", "height"));
        static_cast<void>(look());
        keys_.button(1, true);
        static_cast<void>(look());
        keys_.button(1, false);
    }
    /// The participant's mouse, beside all plates; X11's buttons.
    void click_participant(int button) { keys_.click(kExperimenter_px + 4, 4, button); }

    /// Of all windows that are seen at present.
    [[nodiscard]] std::set<std::string> window_titles() const { return keys_.window_titles(); }

    [[nodiscard]] RunningProgram &program() { return program_; }

private:
    static constexpr int kExperimenter_px = 640; ///< of that window; the other is to its right
    static constexpr int kParticipant_px = 320;
    static constexpr int kHeight_px = 400;

    static std::vector<std::string> with_windows(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "study");
        arguments.insert(arguments.end(),
                         {"--participant-window", "--participant-width",
                          std::to_string(kParticipant_px), "--participant-height", "180", "--width",
                          std::to_string(kExperimenter_px), "--height", std::to_string(kHeight_px),
                          "--scale", "0.8", "--report"});
        return arguments;
    }

    static int middle_px(const nlohmann::json &item, const char *from, const char *size) {
        return static_cast<int>(
            std::lround(item.at(from).get<double>() + 0.5 * item.at(size).get<double>()));
    }

    VirtualDisplay display_;
    RunningProgram program_;
    PressedKeys keys_;
};

} // namespace springdrive::testing

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;
using study::PlannedTrial;
using study::SessionEnding;
using study::Trial;
using study::TrialPlace;
using testing::Report;
using testing::StudyDesk;

constexpr std::chrono::minutes kMax{15}; ///< of a day: it is stuck after that
constexpr double kHandLeaves_s = 2.0;    ///< at most, before the question

/// What the participant does when asked in that trial: which key, or none at all.
struct Decision {
    std::size_t key = 0;
    bool answers = true;
};
Decision decision_at(const TrialPlace &place, std::size_t keys) {
    const study::RandomKey drawn = study::child(study::key_of(7, place.block),
                                                100 * static_cast<std::uint64_t>(place.position) +
                                                    static_cast<std::uint64_t>(place.attempt));
    return {study::below(study::child(drawn, 0), keys),
            study::uniform(study::child(drawn, 1)) > 0.12};
}

/// What else happens, and in which trial; each once.
struct Events {
    TrialPlace kill{1, 2, 1}; ///< the program is killed in the midst of it
    std::optional<TrialPlace> pause{};
    std::optional<TrialPlace> stop{};   ///< the participant presses the space bar in a presentation
    std::optional<TrialPlace> repeat{}; ///< the experimenter wants it again
    std::optional<TrialPlace> day_end{}; ///< the experimenter ends the session in the midst of it
    std::optional<TrialPlace> rest{};    ///< the experimenter wants a break after it
    bool is_unplugged = false;           ///< the cable is pulled for some seconds
};

/// After the kill the trial is repeated, and the next day begins with a break.
constexpr Events kAllEvents{{1, 4, 1},
                            TrialPlace{1, 1, 1},
                            TrialPlace{1, 3, 1},
                            TrialPlace{1, 4, 1},
                            TrialPlace{1, 5, 1},
                            TrialPlace{1, 5, 1},
                            true};

std::optional<TrialPlace> place_in(const std::string &text) {
    std::smatch found;
    static const std::regex pattern(R"(block (\d+), position (\d+), attempt (\d+))");
    if (!std::regex_search(text, found, pattern)) {
        return std::nullopt;
    }
    return TrialPlace{std::stoi(found[1]), std::stoi(found[2]), std::stoi(found[3])};
}

std::string x11_name(const std::string &key) {
    static const std::map<std::string, std::string> kNames{
        {"left", "Left"}, {"right", "Right"}, {"up", "Up"}, {"down", "Down"}, {"enter", "Return"}};
    const auto found = kNames.find(key);
    return found == kNames.end() ? key : found->second;
}

/// Both people, through as many days as it takes.
class Day {
public:
    Day(const study::Protocol &protocol, const fs::path &folder, const Events &events)
        : protocol_(protocol), folder_(folder), events_(events) {}

    /// Until the program has ended, of itself or by force.
    void run(std::vector<std::string> arguments, const std::vector<std::string> &more = {}) {
        arguments.insert(arguments.end(), {"--device", "emulated", "--lockstep", "--without-noise",
                                           "--without-records"});
        arguments.insert(arguments.end(), more.begin(), more.end());
        StudyDesk editor(arguments, folder_);
        const auto give_up = std::chrono::steady_clock::now() + kMax;
        while (act(editor)) {
            if (std::chrono::steady_clock::now() > give_up || ::testing::Test::HasFailure()) {
                FAIL() << "stuck: " << editor.look().texts();
            }
        }
    }

    /// What the participant was seen to do, by the words of the experimenter's window.
    [[nodiscard]] const std::set<std::string> &steps() const { return steps_; }
    /// That windows had at any look.
    [[nodiscard]] const std::set<std::string> &titles() const { return titles_; }

private:
    [[nodiscard]] bool is_due(const std::optional<TrialPlace> &when) {
        return place_ && place_ == when && done_.insert(&when).second;
    }

    /// One look at the windows, and what both people do then. @return false after the end
    bool act(StudyDesk &editor) {
        const Report report = editor.look();
        const std::string step = report.item("participant/step").at("text");
        place_ = place_in(report.item("participant/trial").at("text"));
        steps_.insert(step);
        titles_.merge(editor.window_titles());
        if (step != "is asked") {
            asked_.reset();
        } else {
            is_stopped_by_hand_ = false; // it went on
        }
        if (step == "feels") {
            return feel(editor, report);
        }
        if (step == "is asked") {
            answer(editor);
        } else if (step == "answers the questionnaire") {
            fill_in(editor, report);
        } else if (step == "waits: paused") {
            editor.click("pause");
        } else if (step == "waits for the device, which was stopped" && is_stopped_by_hand_) {
            editor.click("Let the device go on");
        } else if (step == "is told that it counts from now on") {
            press_answer(editor, 1); // no more practice
        } else if (step == "is through") {
            press_answer(editor, 0);
            EXPECT_EQ(editor.program().end(0).exit_status, 0) << editor.program().error();
            return false;
        } else if (step == "reads the instructions" || step == "has a break" ||
                   step.starts_with("is told that")) {
            press_answer(editor, 0);
        }
        return true;
    }

    bool feel(StudyDesk &editor, const Report &report) {
        if (report.item("participant/phase").at("text") != "the stimulus is presented") {
            return true;
        }
        if (place_ == events_.kill && !std::exchange(is_killed_, true)) {
            kill(editor.program().process(), SIGKILL);
            static_cast<void>(editor.program().end(0));
            return false;
        }
        if (is_due(events_.day_end)) {
            editor.click("Stop the session");
            editor.click_last("Yes");
            EXPECT_EQ(editor.program().end(0).exit_status, 0) << editor.program().error();
            return false;
        }
        if (is_due(events_.stop)) {
            editor.press("space");
            is_stopped_by_hand_ = true;
        } else if (is_due(events_.repeat)) {
            editor.click("Repeat this trial");
        } else if (is_due(events_.pause)) {
            editor.click("pause");
        } else if (is_due(events_.rest)) {
            editor.click("Break");
        }
        return true;
    }

    void press_answer(StudyDesk &editor, std::size_t key) {
        if (protocol_.responses.device == study::ResponseDevice::mouse) {
            editor.click_participant(protocol_.responses.keys[key] == "right" ? 3 : 1);
        } else {
            editor.press(x11_name(protocol_.responses.keys[key]));
        }
    }

    /// Once each time that it is asked.
    void answer(StudyDesk &editor) {
        const Decision decision = decision_at(*place_, protocol_.responses.keys.size());
        if (decision.answers && asked_ != place_) {
            press_answer(editor, decision.key);
        }
        asked_ = place_;
    }

    /// Choices by the mouse, scales by the keys, texts by both.
    void fill_in(StudyDesk &editor, const Report &report) {
        const std::string text = report.item("participant/text").at("text");
        if (text == filled_in_) {
            return; // the answer is on its way
        }
        filled_in_ = text;
        const auto item =
            std::ranges::find(protocol_.questionnaire, text, &study::QuestionnaireItem::text);
        ASSERT_NE(item, protocol_.questionnaire.end()) << text;
        switch (item->kind) {
        case study::QuestionnaireKind::choice:
            editor.click_card(report, 1);
            break;
        case study::QuestionnaireKind::scale:
            editor.press("3");
            break;
        default:
            for (const char *key : {"b", "y", "space", "e", "a", "r"}) {
                editor.press(key);
            }
            static_cast<void>(editor.look());
            editor.click_card(editor.look(), 0); // "next"
        }
    }

    study::Protocol protocol_;
    fs::path folder_;
    Events events_;
    std::set<const std::optional<TrialPlace> *> done_;
    std::set<std::string> steps_;
    std::set<std::string> titles_;
    std::optional<TrialPlace> place_; ///< of the present trial
    std::optional<TrialPlace> asked_;
    std::string filled_in_; ///< the question that was answered last
    bool is_stopped_by_hand_ = false;
    bool is_killed_ = false;
};

/// The same decisions without windows, and in one go; what is delivered is simulated on a device
/// without a board.
std::vector<Trial> without_windows(const fs::path &protocol_file, const Events &events) {
    const study::Protocol protocol = study::read_protocol_file(protocol_file);
    study::SimulatedStudySession study_session(
        protocol, study::study_setting(protocol, {protocol_file.parent_path(), testing::assets()}),
        {{}, 0.6, 0.25, 0.0, 1}, study::FeltStimuli::measured_once);
    const auto present = [&](const PlannedTrial &planned) {
        std::optional<study::Trial> result = study_session.present(planned);
        const Decision decision = decision_at(planned.place, protocol.responses.keys.size());
        result->response = study::NoResponse{};
        result->response_time_s.reset();
        if (planned.place == events.stop) {
            result->presentations.resize(1);
            result->safety_events.push_back({0.0, "the emergency stop"});
        } else if (decision.answers) {
            const bool is_yes_no = protocol.task.kind == study::TaskKind::yes_no;
            result->response =
                is_yes_no ? study::Response(study::YesNo{decision.key == 1})
                          : study::Response(study::Chosen{static_cast<int>(decision.key) + 1});
        }
        if (planned.place == events.repeat) {
            result->marks.emplace_back("repeated at the experimenter's wish");
        }
        return result;
    };
    return testing::conducted(protocol, present).trials;
}

/// Of what is delivered where something is intended, the largest difference from the same on a
/// device without a board, as a share of it.
double expect_same(const Trial &seen, const Trial &requested) {
    testing::expect_same_decision(seen, requested);
    EXPECT_EQ(seen.safety_events.size(), requested.safety_events.size());
    EXPECT_EQ(seen.presentations.size(), requested.presentations.size());
    if (!requested.safety_events.empty() ||
        seen.presentations.size() != requested.presentations.size()) {
        return 0.0; // broken off when somebody pressed a key
    }
    double worst = 0.0;
    for (std::size_t i = 0; i < seen.presentations.size(); ++i) {
        const std::vector<study::StimulusValue> &a = seen.presentations[i].values;
        const std::vector<study::StimulusValue> &b = requested.presentations[i].values;
        EXPECT_EQ(a.size(), b.size());
        for (std::size_t j = 0; j < std::min(a.size(), b.size()); ++j) {
            EXPECT_EQ(a[j].name, b[j].name);
            EXPECT_EQ(a[j].intended, b[j].intended);
            EXPECT_EQ(a[j].delivered.has_value(), b[j].delivered.has_value());
            if (a[j].intended.value_or(0.0) != 0.0 && a[j].delivered && b[j].delivered) {
                worst = std::max(worst, std::abs(*a[j].delivered / *b[j].delivered - 1.0));
            }
        }
    }
    return worst;
}

/// A study from the first day to the last, in a folder of its own.
void run_through(const std::string &name, const std::string &text, const Events &events) {
    SCOPED_TRACE(name);
    const fs::path folder = testing::fresh_folder("study_window_" + name);
    const fs::path protocol_file = folder / "short.toml";
    // With V_b, a board that is not calibrated is softer than asked for, and its trials are marked.
    const fs::path device_file = testing::write_phantom_without_brushes(folder);
    std::ofstream(protocol_file) << testing::with(
        text,
        {{"\ndevice = \"phantom_1_0\"", "\ndevice = \"" + device_file.filename().string() + "\""}});
    const study::Protocol protocol = study::read_protocol_file(protocol_file);
    Day day(protocol, folder, events);
    const std::string file = (folder / "short.study").string();
    std::vector<SessionEnding> endings{SessionEnding::interrupted};
    day.run({"run", protocol_file.string(), "--participant", "P01"},
            events.is_unplugged ? std::vector<std::string>{"--fault", "unplug@9-12"}
                                : std::vector<std::string>{});
    ASSERT_FALSE(::testing::Test::HasFailure());
    if (events.day_end) {
        day.run({"resume", file});
        ASSERT_FALSE(::testing::Test::HasFailure());
        endings.push_back(SessionEnding::stopped);
    }
    day.run({"run", file, "--participant", "P01"});
    ASSERT_FALSE(::testing::Test::HasFailure());
    endings.push_back(SessionEnding::completed);

    const study::StudyContents contents = study::read_study(file);
    const std::vector<Trial> requested = without_windows(protocol_file, events);
    ASSERT_EQ(contents.trials.size(), requested.size());
    double worst = 0.0;
    for (std::size_t i = 0; i < requested.size(); ++i) {
        SCOPED_TRACE(text_of(requested[i].place));
        worst = std::max(worst, expect_same(contents.trials[i], requested[i]));
        const std::optional<double> time_s = contents.trials[i].response_time_s;
        EXPECT_EQ(time_s.has_value(),
                  !std::holds_alternative<study::NoResponse>(requested[i].response));
        EXPECT_GE(time_s.value_or(0.0), 0.0);
        EXPECT_LE(time_s.value_or(0.0), protocol.timing.response_s + kHandLeaves_s);
    }
    ASSERT_EQ(contents.sessions.size(), endings.size());
    for (std::size_t i = 0; i < endings.size(); ++i) {
        EXPECT_EQ(contents.sessions[i].ending, endings[i]);
    }
    EXPECT_EQ(contents.answers.size(), protocol.questionnaire.size());
    EXPECT_EQ(day.titles(), (std::set<std::string>{"springdrive", "springdrive: experimenter"}))
        << "a title tells of the study";
    const std::vector<std::pair<bool, const char *>> expected_steps{
        {events.pause.has_value(), "waits: paused"},
        {events.rest.has_value(), "has a break"},
        {events.stop.has_value(), "waits for the device, which was stopped"},
        {events.is_unplugged, "waits for the device, which is not connected or not zeroed"}};
    for (const auto &[is_expected, step] : expected_steps) {
        EXPECT_TRUE(!is_expected || day.steps().contains(step)) << step;
    }
    std::printf("counts: %s: %zu trials in the windows as without; worst difference of what was "
                "delivered %.2f %%\n",
                name.c_str(), requested.size(), 100.0 * worst);
}

/// Short of all that only takes time.
std::string hurried(std::string text) {
    const testing::Replacements shorter{
        {"\nbreak_s = [\\d.]+", "\nbreak_s = 1"},
        {"\nbetween_blocks_s = [\\d.]+", "\nbetween_blocks_s = 1"},
        {"\nfrom_C = [\\d.]+", "\nfrom_C = 24"},
        {"\nair_C = [\\d.]+", ""},
        {"\n\\[windings\\]", "\n[windings]\nair_C = 25"},
        {"\nresponse_s = [\\d.]+", ""},
        {"\nbetween_trials_s = [\\d.]+", ""},
        {"\nrest_s = [\\d.]+", ""},
        {"\n\\[timing\\]", "\n[timing]\nrest_s = 0.2\nbetween_trials_s = 0.1\nresponse_s = 1.5"},
    };
    return testing::with(std::move(text), shorter);
}

/// That of stiffness with its light press only, and short ones.
std::string shortest_study() {
    std::string text = hurried(testing::shortened("stiffness"));
    const testing::Replacements shorter{
        {"\npresentation_s = [\\d.]+", "\npresentation_s = 0.4"},
        {"\npause_s = [\\d.]+", "\npause_s = 0.1"},
        {"\napproach_s = [\\d.]+", "\napproach_s = 0.8"},
        {"\nmost_trials = \\d+", "\nmost_trials = 2"},
        {"\n\\[\\[block\\]\\]\nname = \"firm\"\nconditions = \\[\"firm press\"\\]", ""},
        {"\n\\[\\[condition\\]\\]\nname = \"firm press\"\npress_N = 1.5", ""},
    };
    return testing::with(std::move(text), shorter);
}

TEST(StudyWindows, GoOnAfterAKillAsTheSameDecisionsDoWithoutThem) {
    run_through("killed", shortest_study(), {});
}

class StudyWindowsOf : public ::testing::TestWithParam<const char *> {};

TEST_P(StudyWindowsOf, AnIncludedProtocolStoreWhatTheSameDecisionsGiveWithoutThem) {
    if (testing::cases(0, 1) == 0) {
        GTEST_SKIP() << "tests/long study-windows";
    }
    const std::string name = GetParam();
    const bool is_by_mouse = name == "by_mouse";
    std::string text = hurried(testing::shortened(is_by_mouse ? "stiffness" : name));
    if (is_by_mouse) {
        text += "\n[responses]\ndevice = \"mouse\"\nkeys = [\"left\", \"right\"]\n";
    }
    run_through(name, text, kAllEvents);
}

INSTANTIATE_TEST_SUITE_P(Protocols, StudyWindowsOf,
                         ::testing::Values("direction", "stiffness", "blow", "hardness", "mass",
                                           "by_mouse"),
                         [](const auto &one) { return std::string(one.param); });

using Clock = std::chrono::steady_clock;

constexpr int kConditions = 4; ///< of the protocol
constexpr double kPresentation_s = 0.3;
constexpr double kLatest_s = 2.0;
/// A presentation is seen some frames after it began, so that the first keys are meant to be
/// pressed before its end: some come just after it, those that do not are pressed again.
constexpr double kSoonest_s = -0.15;
/// Between two readings of two clocks: the thread may be held up there.
constexpr double kReading_s = 1e-3;

double now_s() { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); }

/// Some are lost: pressed before the question, or the tip was late at the touch. Then the trial has
/// no answer, and may come again.
int trials_for(int presses) { return presses + presses / 2; }

/// Trials of a single short presentation, one for each press.
std::string pressed_protocol(int presses) {
    std::string text = testing::shortened("blow");
    text = testing::with(
        std::move(text),
        {
            {"\nfrom_C = [\\d.]+", "\nfrom_C = 24"},
            {"\npresentation_s = [\\d.]+", fmt::format("\npresentation_s = {}", kPresentation_s)},
            {"\n\\[marking\\][^$]*?\n\n", // nothing but an answer that is missing
             "\n[marking]\nstiffness_percent = 100\ndirection_deg = 90\nforce_percent = 100\n\n"},
            {"\nmost_trials = 3", "\nmost_trials = 2"}, // the practice's
            {"\napproach_s = [\\d.]+",
             "\napproach_s = 1.0\nrest_s = 0.1\nbetween_trials_s = 0.8\nresponse_s = 4.0"},
            {"\nresponse_s = 5.0", ""},
            {"\nevery_trials = \\d+", "\nevery_trials = 0"},
            {"\nbetween_blocks_s = [\\d.]+", "\nbetween_blocks_s = 1"},
            {"\nlongest_session_min = [\\d.]+", "\nlongest_session_min = 200"},
            {"\n\\[\\[questions\\]\\][^$]*", "\n"},
        });
    const std::size_t method = text.find("kind = \"quest_plus\"");
    for (const std::string key : {"fewest_trials = ", "most_trials = "}) { // the first are its own
        const std::size_t at = text.find(key, method);
        text.replace(at, text.find('\n', at) - at,
                     fmt::format("{}{}", key, trials_for(presses) / kConditions));
    }
    return text;
}

struct Press {
    double before_s = 0.0; ///< by the steady clock: it was between both
    double after_s = 0.0;
    double ahead_s = 0.0;         ///< of the servo's clock
    double longest_frame_s = 0.0; ///< of those about it
};

/// Presses a key after each presentation, one later than the other.
std::vector<Press> press_in(StudyDesk &editor, int presses) {
    std::vector<Press> pressed;
    std::string answered; ///< the trial
    int next = 0;
    const auto give_up = Clock::now() + std::chrono::minutes(40);
    while (Clock::now() < give_up) {
        const Report report = editor.look();
        const double seen_s = now_s();
        const std::string step = report.item("participant/step").at("text");
        const std::string trial = report.item("participant/trial").at("text");
        const auto value = [](const Report &from, const char *id) {
            return from.item(id).at("value").get<double>();
        };
        const auto press_at = [&](double at_s) {
            std::this_thread::sleep_for(std::chrono::duration<double>(at_s - now_s()));
            Press press;
            press.before_s = now_s();
            editor.press(next % 2 == 0 ? "Left" : "Right");
            press.after_s = now_s();
            const Report then = editor.look();
            press.ahead_s = value(then, "participant/servo_ahead_s");
            press.longest_frame_s = value(then, "participant/longest_frame_s");
            pressed.push_back(press);
        };
        if (step == "is through") {
            editor.press("Left");
            EXPECT_EQ(editor.program().end(0).exit_status, 0) << editor.program().error();
            return pressed;
        }
        if (step == "is told that it counts from now on") {
            editor.press("Left"); // the second key of the protocol: no more practice
        } else if (step == "reads the instructions" || step == "has a break" ||
                   step.starts_with("is told that")) {
            editor.press("Right");
        } else if (step == "feels" && trial != answered &&
                   report.item("participant/phase").at("text") == "the stimulus is presented") {
            answered = trial;
            const double share = static_cast<double>(next % presses) / std::max(1, presses - 1);
            ++next;
            press_at(seen_s + kPresentation_s + std::lerp(kSoonest_s, kLatest_s, share));
        } else if (step == "is asked" && trial == answered) { // that was too early
            press_at(now_s() + 0.1);
        }
    }
    ADD_FAILURE() << "stuck: " << editor.look().texts();
    return pressed;
}

TEST(StudyWindow, ALostDisplayEndsTheSessionAsFailed) {
    const fs::path folder = testing::fresh_folder("study_display");
    std::ofstream(folder / "s.toml") << testing::shortened("stiffness");
    auto display = std::make_unique<testing::VirtualDisplay>(1280, 720);
    testing::RunningProgram program(*display,
                                    {"study", "run", "s.toml", "--device", "emulated",
                                     "--participant-window", "--without-noise", "--report"},
                                    folder);
    for (int i = 0; i < 3; ++i) { // frames, of which the first begins the session
        program.send_line("report");
        ASSERT_TRUE(program.read_line(std::chrono::seconds(60))) << program.error();
    }
    EXPECT_FALSE(study::read_study(folder / "s.study").sessions.at(0).ending);
    display.reset();
    const testing::Ending ending = program.end(0);
    constexpr int kLostDisplay = 4; // as of the demo
    EXPECT_EQ(ending.exit_status, kLostDisplay);
    EXPECT_NE(ending.error.find("springdrive: the display is lost"), std::string::npos)
        << ending.error;
    EXPECT_EQ(study::read_study(folder / "s.study").sessions.at(0).ending, SessionEnding::failed);
}

TEST(ResponseTimes, AreThoseOfThePressesToWithinAFrame) {
    const int presses = testing::cases(6, 200);
    const std::filesystem::path folder = testing::fresh_folder("response_times");
    std::ofstream(folder / "presses.toml") << pressed_protocol(presses);
    StudyDesk editor({"run", folder / "presses.toml", "--without-noise", "--without-records"},
                     folder);
    const std::vector<Press> pressed = press_in(editor, presses);

    std::vector<double> errors_ms;
    double shortest_s = kLatest_s;
    double longest_s = 0.0;
    double longest_frame_s = 0.0;
    for (const study::Trial &trial : study::read_study(folder / "presses.study").trials) {
        if (!trial.response_time_s) {
            continue;
        }
        const double stored_s =
            trial.presentations.back().end_s.value() + *trial.response_time_s; // servo's clock
        const auto distance_s = [&](const Press &press) {
            return std::abs(stored_s - press.ahead_s - press.before_s);
        };
        const auto press = std::ranges::min_element(pressed, {}, distance_s);
        ASSERT_NE(press, pressed.end());
        const double error_s = stored_s - press->ahead_s - press->before_s;
        EXPECT_GT(error_s, -kReading_s) << text_of(trial.place);
        EXPECT_LT(error_s, press->after_s - press->before_s + press->longest_frame_s + kReading_s)
            << text_of(trial.place);
        errors_ms.push_back(1e3 * error_s);
        shortest_s = std::min(shortest_s, *trial.response_time_s);
        longest_s = std::max(longest_s, *trial.response_time_s);
        longest_frame_s = std::max(longest_frame_s, press->longest_frame_s);
    }
    ASSERT_GE(errors_ms.size(), static_cast<std::size_t>(presses));
    if (presses >= 200) { // of a few, on a machine that is busy, none may come as soon as planned
        EXPECT_LT(shortest_s, 0.02);
        EXPECT_GT(longest_s, 1.9);
    }
    const auto count = static_cast<double>(errors_ms.size());
    double mean_ms = 0.0;
    for (const double error_ms : errors_ms) {
        mean_ms += error_ms / count;
    }
    double variance = 0.0;
    for (const double error_ms : errors_ms) {
        variance += (error_ms - mean_ms) * (error_ms - mean_ms) / (count - 1.0);
    }
    std::ranges::sort(errors_ms);
    std::printf("worst: %zu presses, %.0f to %.0f ms after the presentation: stored %.2f ms late "
                "in the mean, standard deviation %.2f ms, median %.2f ms, 95 %% within %.2f ms, "
                "worst %.2f ms; longest frame %.1f ms\n",
                errors_ms.size(), 1e3 * shortest_s, 1e3 * longest_s, mean_ms, std::sqrt(variance),
                errors_ms[errors_ms.size() / 2], errors_ms[errors_ms.size() * 95 / 100],
                errors_ms.back(), 1e3 * longest_frame_s);
}

} // namespace
} // namespace springdrive::app
