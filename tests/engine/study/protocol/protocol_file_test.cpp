// Covers engine/study/protocol/protocol_file.cpp and protocol.cpp:
// what is read, and what is refused, with key, value and range.
#include "engine/study/protocol/protocol.h"

#include "base/input_error.h"
#include "engine/servo/safety_limits.h"
#include "engine/study/methods/random_key.h"
#include "engine/study/protocol/protocol_check.h"
#include "tests/engine/study/protocol/plain_protocol.h"
#include "tests/support/files.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::study {
namespace {

using testing::kPlainProtocol;
using testing::protocol_of;
using testing::with;

TEST(ProtocolFile, ReadsWhatIsThereAndElseTheDefaults) {
    const Protocol protocol = protocol_of(kPlainProtocol);
    EXPECT_EQ(protocol.title, "plain");
    EXPECT_EQ(protocol.stimulus, StimulusForm::press);
    EXPECT_EQ(protocol.seed, 7);
    EXPECT_EQ(protocol.texts.question, "Which?");
    EXPECT_EQ(protocol.texts.end, Texts{}.end);
    ASSERT_EQ(protocol.conditions.size(), 2U);
    EXPECT_EQ(protocol.conditions[1].name, "b");
    EXPECT_EQ(protocol.conditions[0].press_N, 1.0) << "of [common]";
    EXPECT_EQ(protocol.conditions[1].press_N, 0.8) << "its own";
    EXPECT_EQ(protocol.conditions[1].tuning.K_P_V_per_rad, 6.0);
    ASSERT_TRUE(protocol.conditions[0].spot);
    EXPECT_EQ(protocol.conditions[0].spot->point_m, Vector3(0.0, -0.005, -0.015));
    EXPECT_EQ(protocol.variable.parameter, "eta");
    EXPECT_EQ(protocol.variable.level, LevelMeaning::added);
    const auto *method = std::get_if<ConstantStimuli>(&protocol.method);
    ASSERT_NE(method, nullptr);
    EXPECT_EQ(method->levels, (std::vector{0.1, 0.2, 0.3}));
    EXPECT_EQ(method->blocks, 10);
    EXPECT_EQ(protocol.practice.min_trials, 2);
    EXPECT_EQ(protocol.catch_trials.one_in, 10);
    ASSERT_EQ(protocol.blocks.size(), 2U);
    EXPECT_EQ(protocol.blocks[1].conditions, std::vector<std::size_t>{1});
    EXPECT_EQ(protocol.timing.approach_s, 1.0);
    EXPECT_EQ(protocol.timing.pause_s, TrialTiming{}.pause_s);
    ASSERT_TRUE(protocol.expected);
    EXPECT_EQ(protocol.expected->threshold, 0.2);
    ASSERT_TRUE(protocol.noise);
    EXPECT_EQ(protocol.noise->level_dBFS, -40.0);
    EXPECT_EQ(protocol.questionnaire,
              (std::vector<QuestionnaireItem>{{.name = "hand",
                                               .when = QuestionnaireTime::before,
                                               .text = "Which hand?",
                                               .kind = QuestionnaireKind::choice,
                                               .choices = {"right", "left"}},
                                              {.name = "tiring",
                                               .when = QuestionnaireTime::after,
                                               .text = "How tiring?",
                                               .kind = QuestionnaireKind::scale,
                                               .lowest = 1,
                                               .highest = 5,
                                               .lowest_label = "not",
                                               .highest_label = "very"},
                                              {.name = "remarks",
                                               .when = QuestionnaireTime::after,
                                               .text = "Anything else?",
                                               .kind = QuestionnaireKind::text}}));
    EXPECT_EQ(validate(protocol), "");
}

TEST(ProtocolFile, HasNeitherNoiseNorQuestionsUnlessAsked) {
    const std::string without = kPlainProtocol.substr(0, kPlainProtocol.find("[noise]"));
    EXPECT_FALSE(protocol_of(without).noise);
    EXPECT_TRUE(protocol_of(without).questionnaire.empty());
    EXPECT_EQ(protocol_of(without + "[noise]\n").noise, MaskingNoise{}) << "the default level";
}

TEST(ProtocolFile, NumbersAtTheEndsOfTheirRangesAreRead) {
    for (const char *const level : {"-80.0", "-6.0"}) {
        EXPECT_EQ(protocol_of(with(kPlainProtocol, "-40.0", level)).noise->level_dBFS,
                  std::stod(level));
    }
    for (const auto &[lowest, highest] :
         {std::pair(-1000, -999), std::pair(0, 100), std::pair(900, 1000)}) {
        const Protocol protocol = protocol_of(
            with(with(kPlainProtocol, "lowest = 1", "lowest = " + std::to_string(lowest)),
                 "highest = 5", "highest = " + std::to_string(highest)));
        EXPECT_EQ(protocol.questionnaire[1].lowest, lowest);
        EXPECT_EQ(protocol.questionnaire[1].highest, highest);
    }
}

TEST(ProtocolFile, NormalsOfAnyLengthBecomeUnitVectors) {
    const Protocol protocol =
        protocol_of(with(kPlainProtocol, "normal = [0.0, 1.0, 0.0]", "normal = [0.0, 3.0, 4.0]"));
    EXPECT_TRUE(protocol.conditions[0].spot->normal.isApprox(Vector3(0.0, 0.6, 0.8), 1e-15));
}

TEST(ProtocolFile, WithoutBlocksAllConditionsAreInOne) {
    std::string text = kPlainProtocol;
    const std::size_t from = text.find("[[block]]");
    text.erase(from, text.find("[responses]") - from);
    const Protocol protocol = protocol_of(text);
    ASSERT_EQ(protocol.blocks.size(), 1U);
    EXPECT_EQ(protocol.blocks[0].conditions, (std::vector<std::size_t>{0, 1}));
}

TEST(ProtocolFile, ReadsEveryMethod) {
    const std::string plain =
        "kind = \"constant_stimuli\"\nlevels = [0.1, 0.2, 0.3]\nrepetitions = "
        "1\nblocks = 10";
    const Protocol staircases = protocol_of(
        with(kPlainProtocol, plain,
             "kind = \"staircases\"\nscale = \"logarithmic\"\nstart_levels = [0.4, "
             "0.3]\nminimum_level = 0.01\nmaximum_level = 0.5\ncorrect_for_down = 3\nsteps = "
             "[{from_reversal = 0, size = 2.0}, {from_reversal = 2, size = 1.3}]"));
    const auto &up_down = std::get<Staircases>(staircases.method);
    EXPECT_EQ(up_down.start_levels, (std::vector{0.4, 0.3}));
    EXPECT_EQ(up_down.correct_for_down, 3);
    EXPECT_EQ(up_down.steps, (std::vector<StepSize>{{0, 2.0}, {2, 1.3}}));

    const Protocol quest = protocol_of(
        with(kPlainProtocol, plain,
             "kind = \"quest_plus\"\nlevels = [0.1, 0.3]\nthreshold = {minimum = 0.05, maximum = "
             "0.5, points = 21}\nslope = {minimum = 1, maximum = 5, points = 5}"));
    const auto &plus = std::get<QuestPlus>(quest.method);
    EXPECT_EQ(plus.threshold.points, 21);
    EXPECT_EQ(plus.threshold.prior.scale, Scale::logarithmic) << "that of the method";
    EXPECT_EQ(plus.guess.prior, known(0.5)) << "of two intervals";
    EXPECT_EQ(plus.lapse.prior, known(0.02));

    const Protocol adjusted = protocol_of(
        with(with(with(with(kPlainProtocol, plain,
                            "kind = \"adjustment\"\nminimum_level = 0.0\nmaximum_level = "
                            "0.5\nminimum_start = 0.1\nmaximum_start = 0.4\nsettings = 5"),
                       "forced_choice_by_interval", "adjustment"),
                  "keys = [\"1\", \"2\"]", "keys = [\"down\", \"up\", \"enter\"]"),
             "one_in = 10", "one_in = 0"));
    EXPECT_EQ(std::get<Adjustment>(adjusted.method).settings, 5);
}

std::string repeated(int times, const std::string &text) {
    std::string all;
    while (times-- > 0) {
        all += text;
    }
    return all;
}

/// A fault, and what the line about it must say. That each key has its range, and is required, is
/// for ProtocolManual: of these there is one of each kind.
struct Malformed {
    std::string from;
    std::string to;
    std::vector<std::string> said;
};

const std::vector<Malformed> &malformed() {
    static const std::string levels = "levels = [0.1, 0.2, 0.3]";
    static const std::string question = "question = \"Which?\"";
    static const std::string choices = "[\"right\", \"left\"]";
    static const std::string keys = "keys = [\"1\", \"2\"]";
    static const std::string noise = "level_dBFS = -40.0";
    static const std::vector<Malformed> all{
        // What is no TOML.
        {"title = \"plain\"", "title = \"plain", {"p.toml:1: is not valid TOML"}},
        {"seed = 7", "seed = 7\nseed = 8", {"p.toml:4: is not valid TOML"}},
        // Unknown keys, each with the nearest one.
        {"seed = 7", "sead = 7", {"p.toml:3: sead is not known", "the nearest is seed"}},
        {"[windings]", "[winding]", {"winding is not known", "the nearest is windings"}},
        {"K_P_V_per_rad", "K_P_V_per_Rad", {"common.K_P_V_per_Rad", "nearest is K_P_V_per_rad"}},
        {"press_N = 0.8", "force_N = 0.8", {"condition[2].force_N is not known", "press_N"}},
        {"blocks = 10", "block = 10", {"method.block is not known", "the nearest is blocks"}},
        {"[noise]", "[[question]]\nname = \"a\"\n[noise]", {"question is not known", "questions"}},
        {"highest = 5", "highest = 5\nsteps = 5", {"questions[2].steps is not known"}},
        // Missing ones.
        {"title = \"plain\"\n", "", {"title is missing", "must be a text"}},
        {"standard = 0.4\n", "", {"variable.standard is missing", "a number"}},
        {"standard = 0.4", "standard = 0.4\nstandard_condition = \"\"", {"standard_condition"}},
        {"kind = \"constant_stimuli\"", "", {"method.kind is missing", "quest_plus"}},
        {"name = \"a\"", "", {"condition[1].name is missing"}},
        {"point_m = [0.0, -0.005, -0.015]\n", "", {"common.point_m is missing"}},
        {"name = \"hand\"\n", "", {"p.toml:74: questions[1].name is missing"}},
        {"choices = [\"right\", \"left\"]\n", "", {"questions[1].choices is missing", "1 to 20"}},
        {"lowest = 1\n", "", {"questions[2].lowest is missing", "-1000 to 1000"}},
        // Wrong types.
        {"seed = 7", "seed = \"seven\"", {"seed", "seven", "0 to 2.14748e+09"}},
        {"seed = 7", "seed = 7.5", {"seed is 7.5", "whole number"}},
        {"title = \"plain\"", "title = 3", {"title is 3", "must be a text"}},
        {"repeats = true", "repeats = 1", {"marking.repeats is 1", "true or false"}},
        {levels, "levels = 0.1", {"method.levels is 0.1", "in brackets"}},
        {levels, "levels = [0.1, \"x\"]", {"method.levels has", "x"}},
        {levels, "levels = []", {"method.levels is", "1 to 1000 numbers"}},
        {"conditions = [\"a\"]", "conditions = [1]", {"block[1].conditions", "texts"}},
        {"point_m = [0.0, -0.005, -0.015]", "point_m = [0.0, 1.0]", {"common.point_m", "three"}},
        {"[texts]\nquestion = \"Which?\"\n", "texts = 3\n", {"texts is", "[texts]"}},
        // Out of range.
        {"threshold = 0.2", "threshold = 1e-300", {"expected.threshold is 1e-300", "1e-06"}},
        {"threshold = 0.2", "threshold = inf", {"expected.threshold is inf", "1e+06"}},
        {"participants = 4", "participants = 0", {"participants is 0", "1 to 10000"}},
        {"dR_Ohm = 0.5\nl", "dR_Ohm = 0.0\nl", {"free_space.dR_Ohm is 0", "0.02 to 2.18"}},
        {"K_P_V_per_rad = 6.0", "K_P_V_per_rad = nan", {"common.K_P_V_per_rad", "0 to 500"}},
        {"press_N = 0.8", "press_N = 80.0", {"condition[2].press_N is 80", "0.1 to 8"}},
        {"standard = 0.4", "standard = 1.4", {"variable.standard is 1.4", "0 to 1"}},
        {"repetitions = 1", "repetitions = 0", {"method.repetitions is 0", "1 to 1000"}},
        {noise, "level_dBFS = -5.9", {"noise.level_dBFS is -5.9", "-80 to -6"}},
        {noise, "level_dBFS = -80.1", {"noise.level_dBFS is -80.1", "-80 to -6"}},
        {"lowest = 1", "lowest = -1001", {"questions[2].lowest is -1001", "-1000 to 1000"}},
        {"[[questions]]", repeated(99, "[[questions]]\n"), {"questions appears 101 times"}},
        // Questions.
        {"name = \"hand\"", "name = \"Hand\"", {"questions[1].name is 'Hand'", "1 to 40 of a-z"}},
        {"name = \"hand\"", "name = \"1st\"", {"questions[1].name is '1st'", "with a letter"}},
        {"name = \"hand\"", "name = \"\"", {"questions[1].name is ''", "1 to 40 of a-z"}},
        {"\"hand\"", "\"participant_id\"", {"questions[1].name is \"participant_id\"", "another"}},
        {"name = \"tiring\"", "name = \"hand\"", {"questions[2].name is \"hand\"", "its own"}},
        {"text = \"Which hand?\"", "text = \" \"", {"questions[1].text has 1 bytes", "be read"}},
        {choices, "[\"right\"]", {"questions[1].choices has 1;", "2 to 20"}},
        {choices, "[\"a\"" + repeated(20, ", \"b\"") + "]", {"choices is", "1 to 20 texts"}},
        {choices, "[\"a\", \"a\"]", {"choices has 'a' twice", "be there once"}},
        {choices, "[\"a\", \" \"]", {"choices has ' '", "one line"}},
        {choices, "[\"a\", \"b \"]", {"choices has 'b '", "ends with a blank"}},
        {choices, "[\"a\", \"b\\nc\"]", {"choices has 'b c'", "one line"}},
        {"highest = 5", "highest = 1", {"questions[2].highest is 1;", "1 to 100 above lowest, 1"}},
        {"highest = 5", "highest = 102", {"questions[2].highest is 102;", "1 to 100 above lowest"}},
        {"lowest_label = \"not\"", "lowest_label = \"\"", {"lowest_label is ''", "one line"}},
        {"label = \"very\"",
         "label = \"a\\tb\"",
         {"questions[2].highest_label is 'a b'", "one line"}},
        {"kind = \"text\"",
         "kind = \"text\"\nchoices = [\"a\", \"b\"]",
         {"questions[3].choices is there though kind is \"text\"", "left out", "\"choice\""}},
        {choices,
         choices + "\nhighest = 3",
         {"questions[1].highest is there though kind is \"choice\"", "\"scale\""}},
        // Placeholders of texts.
        {question, "break_left = \"s left\"", {"texts.break_left has {} 0 times"}},
        {question, "progress = \"{} of {}\"", {"texts.progress has {} 2 times"}},
        {question, "question = \"{}?\"", {"texts.question has '{}'", "no text in"}},
        // Names that stand for nothing.
        {"stimulus = \"press\"", "stimulus = \"poke\"", {"stimulus is \"poke\"", "press, blow"}},
        {"parameter = \"eta\"", "parameter = \"etta\"", {"variable.parameter is \"etta\"", "eta"}},
        {"conditions = [\"b\"]", "conditions = [\"c\"]", {"block[2].conditions has \"c\"", "a, b"}},
        {"standard = 0.4", "standard = 0.4\nstandard_condition = \"z\"", {"is \"z\"", "a, b"}},
        // What contradicts itself.
        {"name = \"b\"", "name = \"a\"", {"condition[2].name is \"a\"", "its own"}},
        {"name = \"b\"", "name = \"b \"", {"condition[2].name is \"b \"", "ends with a blank"}},
        {"name = \"b\"", "name = \"\\u00a0b\"", {"condition[2].name is", "begins with a blank"}},
        {"name = \"b\"", "name = \"b\\nc\"", {"condition[2].name is \"b c\"", "control character"}},
        {"name = \"two\"", "name = \"two\\u3000\"", {"block[2].name is", "ends with a blank"}},
        {"name = \"two\"", "name = \"one\"", {"block[2].name is \"one\"", "its own"}},
        {"conditions = [\"b\"]", "conditions = [\"b\", \"b\"]", {"block \"two\"", "once"}},
        {levels, "levels = [0.2, 0.1]", {"method.levels has 0.1 after 0.2"}},
        {levels, "levels = [0.1, 0.7]", {"level 0.7", "eta is 1.1", "0 to 1"}},
        {"normal = [0.0, 1.0, 0.0]", "normal = [0.0, 0.0, 0.0]", {"common.normal has no length"}},
        {"seed = 7", "free_space_is_stimulus = true", {"free_space is given", "left out"}},
        {"stimulus = \"press\"", "stimulus = \"stroke\"", {"free_space_is_stimulus is false"}},
        {"\"eta\"", "\"pulse_hz\"", {"variable.standard is 0.4", "1 to 250"}},
        {keys, "keys = [\"1\", \"space\"]", {"responses.keys has \"space\"", "stops"}},
        {keys, "keys = [\"1\", \"1\"]", {"responses.keys has \"1\"", "its own"}},
        {keys, "keys = [\"F\", \"f\"]", {"responses.keys has \"F\"", "its own"}},
        {keys, "keys = [\"1\"]", {"responses.keys has 1", "2"}},
        {"to_C = 60.0", "to_C = 20.0", {"windings.to_C is 20", "above windings.from_C, 27"}},
        {"fewest_trials = 2", "fewest_trials = 9", {"practice.fewest_trials is 9", "0 to 4"}},
        {"one_in = 10", "one_in = 1", {"catch_trials.one_in is 1", "2 to 1000"}},
        {"choice_by_interval", "choice_by_place", {"variable.parameter is eta", "turn_deg"}},
        {"forced_choice_by_interval", "adjustment", {"method.", "adjustment"}},
    };
    return all;
}

TEST(ProtocolFile, RefusesEveryMalformedOneInOneLine) {
    for (const Malformed &one : malformed()) {
        const std::string text = with(kPlainProtocol, one.from, one.to);
        const std::string line = error_text_of([&text] { static_cast<void>(protocol_of(text)); });
        EXPECT_EQ(line.substr(0, 7), "p.toml:") << one.to << ": " << line;
        EXPECT_EQ(std::ranges::count(line, '\n'), 0) << line;
        for (const std::string &part : one.said) {
            EXPECT_NE(line.find(part), std::string::npos)
                << one.to << "\n  said: " << line << "\n  without: " << part;
        }
    }
}

/// A text is read or refused with one line.
void read_or_refuse(const std::string &text) {
    try {
        static_cast<void>(protocol_of(text));
    } catch (const InputError &error) {
        const std::string line = error.what();
        EXPECT_EQ(std::ranges::count(line, '\n'), 0) << line;
        EXPECT_FALSE(line.empty());
    }
}

TEST(ProtocolFile, CutAnywhereItIsReadOrRefused) {
    for (std::size_t length = 0; length < kPlainProtocol.size(); ++length) {
        read_or_refuse(kPlainProtocol.substr(0, length));
    }
}

TEST(ProtocolFile, WithBytesChangedItIsReadOrRefused) {
    constexpr int kTexts = 3000;
    for (int i = 0; i < kTexts; ++i) {
        const RandomKey key = child(RandomKey{22}, static_cast<std::uint64_t>(i));
        std::string text = kPlainProtocol;
        const std::size_t changes = 1 + below(child(key, 0), 4);
        for (std::size_t j = 1; j <= changes; ++j) {
            const RandomKey change = child(key, j);
            const std::size_t at = below(child(change, 0), text.size());
            const auto letter = static_cast<char>(below(child(change, 1), 256));
            switch (below(child(change, 2), 3)) {
            case 0:
                text[at] = letter;
                break;
            case 1:
                text.erase(at, 1 + below(child(change, 3), 20));
                break;
            default:
                text.insert(at, text, below(child(change, 3), text.size()), 30);
            }
        }
        read_or_refuse(text);
    }
}

const std::set<std::string> kShipped{"blow", "can_you_feel_it", "direction", "hardness",
                                     "mass", "stiffness"};

class ShippedProtocol : public ::testing::TestWithParam<std::string> {};

TEST_P(ShippedProtocol, HasNoErrorsAndTakesUnderAnHour) {
    const std::filesystem::path file = testing::assets() / "protocols" / (GetParam() + ".toml");
    const Protocol protocol = read_protocol_file(file);
    const CheckedProtocol checked =
        check_protocol(protocol, {file.parent_path(), testing::assets()});
    for (const ProtocolFinding &finding : checked.findings) {
        EXPECT_EQ(finding.severity, Severity::note) << text_of(finding);
    }
    EXPECT_LE(checked.length.max_s, 3600.0);
    EXPECT_FALSE(checked.trials.empty());
    EXPECT_NE(testing::contents_of(file).find("docs/study_protocol.md"), std::string::npos);
    if (GetParam() == "can_you_feel_it") {           // of visitors: nobody is asked for anything
        EXPECT_GE(checked.length.min_s, 3.0 * 60.0); // or it would say too little
        EXPECT_LE(checked.length.max_s, 5.0 * 60.0); // with the instructions
        EXPECT_TRUE(protocol.questionnaire.empty());
        EXPECT_EQ(protocol.conditions.size(), 1U);
        EXPECT_EQ(protocol.variable.parameter, "turn_deg");
    }
}

INSTANTIATE_TEST_SUITE_P(, ShippedProtocol, ::testing::ValuesIn(kShipped),
                         [](const auto &protocol) { return protocol.param; });

TEST(ShippedProtocols, AreTheOnesThatAreTested) {
    std::set<std::string> names;
    for (const auto &entry : std::filesystem::directory_iterator(testing::assets() / "protocols")) {
        names.insert(entry.path().stem().string());
    }
    EXPECT_EQ(names, kShipped);
}

/// docs/study_protocol.md has the tables of the list in the code.
TEST(ProtocolManual, HasEveryKeyOfTheList) {
    const std::string page =
        testing::contents_of(testing::assets().parent_path() / "docs/study_protocol.md");
    std::ostringstream tables;
    write_protocol_keys(tables);
    EXPECT_NE(page.find(tables.str()), std::string::npos) << "the page should have these tables:\n"
                                                          << tables.str();
}

/// The keys that the reader knows beside a line, as it tells them of one that it does not know.
std::set<std::string> known_beside(const std::string &beside) {
    const std::string text = testing::with(testing::kPlainProtocol, beside, beside + "zzz = 1\n");
    const std::string line =
        error_text_of([&text] { static_cast<void>(testing::protocol_of(text)); });
    const std::string before = "the known keys are ";
    const std::size_t at = line.find(before);
    EXPECT_NE(at, std::string::npos) << line;
    std::istringstream list(
        line.substr(at == std::string::npos ? line.size() : at + before.size()));
    std::set<std::string> keys;
    for (std::string key; std::getline(list, key, ',');) {
        keys.insert(key.substr(key.find_first_not_of(' ')));
    }
    return keys;
}

/// And the list in the code is what the reader reads: in every table the same keys.
TEST(ProtocolManual, ItsListIsWhatTheReaderKnows) {
    std::map<std::string, std::set<std::string>> listed;
    std::stringstream manual;
    write_protocol_keys(manual);
    std::string heading;
    for (std::string line; std::getline(manual, line);) {
        const std::size_t from = line.find('`');
        const std::string name = from == std::string::npos
                                     ? ""
                                     : line.substr(from + 1, line.find('`', from + 1) - from - 1);
        if (line.ends_with(':')) {
            heading = name.substr(0, name.find_last_not_of(']') + 1);
            heading.erase(0, heading.find_first_not_of('['));
        } else if (line.starts_with("| `")) {
            listed[heading].insert(name);
        }
    }
    for (const char *table : {"texts", "free_space", "common", "variable", "task", "practice",
                              "catch_trials", "responses", "timing", "breaks", "marking",
                              "windings", "stopping", "noise", "expected"}) {
        const std::string line = std::string("[") + table + "]\n";
        EXPECT_EQ(known_beside(line), listed[table]) << table;
    }
    EXPECT_EQ(known_beside("name = \"one\"\n"), listed["block"]);
    EXPECT_EQ(known_beside("name = \"tiring\"\n"), listed["questions"]);
    std::set<std::string> of_condition = listed["common"];
    of_condition.merge(listed["condition"]);
    EXPECT_EQ(known_beside("name = \"a\"\n"), of_condition);
    // Before all tables, where the tables themselves are keys too.
    const std::set<std::string> root = known_beside("seed = 7\n");
    for (const std::string &key : listed[""]) {
        EXPECT_TRUE(root.contains(key)) << key;
    }
    for (const std::string &key : root) {
        EXPECT_TRUE(listed[""].contains(key) || listed.contains(key) || key == "method") << key;
    }
}

std::filesystem::path top() { return testing::assets().parent_path(); }

std::string page() { return testing::contents_of(top() / "docs/study_privacy.md"); }

TEST(PrivacyPage, HasTheLimitsOfTheDevices) {
    const std::string text = page();
    const servo::SafetyLimits first = servo::limits_of(testing::phantom_1_0());
    const servo::SafetyLimits second = servo::limits_of(testing::phantom_premium_1_5());
    for (const servo::SafetyLimit &limit : servo::kSafetyLimits) {
        const std::string row = fmt::format("| {} [{}] | {:.4g} | {:.4g} |", limit.what, limit.unit,
                                            first.*limit.value * limit.shown_per_si,
                                            second.*limit.value * limit.shown_per_si);
        EXPECT_NE(text.find(row), std::string::npos) << row;
    }
}

/// "Suite.Name" of all tests.
std::set<std::string> all_tests() {
    std::set<std::string> names;
    const std::regex test(R"(TEST(?:_F|_P)?\((\w+),\s*(\w+)\))");
    for (const auto &entry : std::filesystem::recursive_directory_iterator(top() / "tests")) {
        if (entry.path().extension() != ".cpp") {
            continue;
        }
        const std::string source = testing::contents_of(entry.path());
        for (std::sregex_iterator at(source.begin(), source.end(), test), end; at != end; ++at) {
            names.insert((*at)[1].str() + "." + (*at)[2].str());
        }
    }
    return names;
}

TEST(PrivacyPage, NamesTestsThatExist) {
    const std::string text = page();
    const std::set<std::string> tests = all_tests();
    const std::regex named(R"(`([A-Z]\w+\.[A-Z]\w+)`)");
    int count = 0;
    for (std::sregex_iterator at(text.begin(), text.end(), named), end; at != end; ++at) {
        EXPECT_TRUE(tests.contains((*at)[1].str())) << (*at)[1].str();
        ++count;
    }
    EXPECT_GT(count, 15);
    EXPECT_FALSE(tests.contains("PrivacyPage.NamesATestThatDoesNot"));
}

} // namespace
} // namespace springdrive::study
