#include "tests/engine/study/store/sample_study.h"

#include "base/input_error.h"
#include "engine/study/store/rows.h"

#include <fmt/core.h>

#include <array>
#include <bit>
#include <limits>

namespace springdrive::testing {

namespace {

using study::Trial;

/// Draws values of trials.
class TrialDraws : public Draws {
public:
    using Draws::Draws;

    double number() {
        using Limits = std::numeric_limits<double>;
        constexpr std::array kHard{-0.0,
                                   0.0,
                                   5.0,
                                   -1e18,
                                   0.1,
                                   Limits::denorm_min(),
                                   Limits::max(),
                                   Limits::min(),
                                   -Limits::infinity(),
                                   4611686018427387904.0};
        if (below(4) == 0) {
            return kHard[bits() % kHard.size()];
        }
        const double drawn = std::bit_cast<double>(bits());
        return drawn == drawn ? drawn : 1.0 / 3.0;
    }
    std::optional<double> perhaps_number() {
        return coin() ? std::optional(number()) : std::nullopt;
    }

    std::string text() {
        constexpr std::array kTexts{"", "η = 0.5", "two\nlines, \"quoted\"\t,", "stiff",
                                    "'); DROP"};
        return kTexts[bits() % kTexts.size()];
    }
    std::vector<study::Setting> settings(int count) {
        std::vector<study::Setting> settings;
        for (int i = 0; i < count; ++i) {
            settings.push_back({fmt::format("parameter_{}", i), {}});
            if (coin()) {
                settings.back().value = number();
            } else {
                settings.back().value = text();
            }
        }
        return settings;
    }
};

study::Presentation presentation(TrialDraws &draws) {
    study::Presentation shown{draws.perhaps_number(), draws.perhaps_number(), {}};
    // Sometimes more than a page of the database.
    const int count = draws.below(8) == 0 ? 150 : draws.below(5);
    for (int i = 0; i < count; ++i) {
        shown.values.push_back(
            {fmt::format("value_{}_N_per_m", i), draws.perhaps_number(), draws.perhaps_number()});
    }
    return shown;
}

study::Response response(TrialDraws &draws) {
    switch (draws.below(4)) {
    case 0:
        return study::Chosen{1 + draws.below(2)};
    case 1:
        return study::YesNo{draws.coin()};
    case 2:
        return study::Adjusted{draws.number()};
    default:
        return study::NoResponse{};
    }
}

std::string code_of(int participant) { return fmt::format("P{:02}", participant); }

bool is_repetition(int number) { return number % 10 == 0; }

study::TrialPlace place_of(int number) {
    const int position = is_repetition(number) ? number - 1 : number;
    return {1 + position / 100, position, is_repetition(number) ? 2 : 1};
}

} // namespace

study::NewStudy sample_new_study() {
    return {"direction of a force", "[study]\ntitle = \"direction of a force\"\n", "0.1.0"};
}

study::Session sample_session(int participant) {
    study::Session session;
    session.participant = code_of(participant);
    session.started = kStart + std::chrono::hours(participant);
    session.device = static_cast<study::DeviceKind>(participant % 3);
    session.device_name = "PHANTOM 1.0";
    session.device_serial = "0417";
    session.software = "0.1.0";
    session.host = "a machine (2 cores)";
    session.facts = {{"servo_hz", 1000.0}, {"kernel", std::string("6.1 rt")}};
    return session;
}

std::filesystem::path sample_study(const std::filesystem::path &folder, int participants) {
    const std::filesystem::path file = folder / "direction.study";
    study::create_study(file, sample_new_study(), kStart);
    study::StudyStore store(file);
    for (int i = 1; i <= participants; ++i) {
        store.add({code_of(i), i, kStart + std::chrono::hours(i)});
        const study::SessionId session = store.begin(sample_session(i));
        store.end(session, study::SessionEnding::completed, kStart + std::chrono::hours(i + 1));
    }
    return file;
}

Trial sample_trial(std::uint64_t seed, int participant, int number) {
    TrialDraws draws(
        split_mix::value(split_mix::value(seed, static_cast<std::uint64_t>(participant)),
                         static_cast<std::uint64_t>(number)));
    Trial trial;
    trial.participant = code_of(participant);
    trial.place = place_of(number);
    trial.session = participant;
    trial.condition = draws.text();
    trial.track = draws.text();
    trial.is_practice = draws.coin();
    trial.is_catch = draws.coin();
    trial.seed = draws.bits();
    trial.level_name = "direction_deg";
    trial.level = draws.perhaps_number();
    trial.target = draws.coin() ? std::optional(draws.below(3)) : std::nullopt;
    for (int i = draws.below(3); i > 0; --i) {
        trial.presentations.push_back(presentation(draws));
    }
    trial.response = response(draws);
    trial.is_correct = draws.coin() ? std::optional(draws.coin()) : std::nullopt;
    trial.response_time_s = draws.perhaps_number();
    trial.at = kStart + std::chrono::milliseconds(draws.below(1'000'000'000));
    trial.software = "0.1.0";
    trial.tuning = draws.settings(draws.below(9));
    trial.windings_degC = {draws.perhaps_number(), draws.number(), draws.number()};
    if (draws.below(5) == 0) {
        trial.safety_events.push_back({draws.perhaps_number(), "force 9.1 N above 8.5 N"});
    }
    trial.missed_deadlines = draws.bits() >> 1U;
    if (draws.coin()) {
        trial.record = {std::filesystem::path("direction.records") / trial.participant /
                            fmt::format("{}.rec", number),
                        std::string(64, 'a')};
    }
    if (draws.below(4) == 0) {
        trial.marks = {"direction 2.1 degrees off", "late"};
        trial.is_presented_again = draws.coin();
    }
    if (is_repetition(number)) {
        trial.repetition_of = place_of(number - 1);
    }
    return trial;
}

std::vector<Trial> sample_trials(std::uint64_t seed, int participant, int count) {
    std::vector<Trial> trials;
    for (int number = 1; number <= count; ++number) {
        trials.push_back(sample_trial(seed, participant, number));
        if (is_repetition(number)) {
            trials[trials.size() - 2].repeated_by = trials.back().place;
        }
    }
    return trials;
}

bool are_identical(const std::vector<Trial> &a, const std::vector<Trial> &b) {
    return std::ranges::equal(a, b, [](const Trial &x, const Trial &y) {
        // == takes -0 for 0, and nothing else that differs; a digest is one of the bits.
        return x == y && study::digest_of(0, x) == study::digest_of(0, y);
    });
}

std::string said_on_reading(const std::filesystem::path &file) {
    return error_text_of([&] { static_cast<void>(study::read_study(file)); });
}

std::string said_on_opening(const std::filesystem::path &file) {
    return error_text_of([&] { study::StudyStore store(file); });
}

} // namespace springdrive::testing
