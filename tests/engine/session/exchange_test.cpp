// Covers engine/session/session.cpp and session_device.cpp: scene, servo rate and device exchanged
// in contact, in every order, while a record runs. The record is checked by
// tests/support/exchange_judge.h.
#include "tests/engine/session/session_fixture.h"
#include "tests/support/exchange_judge.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace springdrive::session {
namespace {

using testing::press;
using testing::run_until;

enum class Exchange : std::uint8_t { scene, rate, device };
constexpr std::array kExchanges{Exchange::scene, Exchange::rate, Exchange::device};

/// In which each order of three, with repetitions, comes once: a de Bruijn sequence.
std::vector<Exchange> in_every_order() {
    std::vector<Exchange> exchanges;
    for (const char number : std::string("00010020110120210221112122200")) {
        exchanges.push_back(kExchanges.at(static_cast<std::size_t>(number - '0')));
    }
    return exchanges;
}

/// A session with cyclic requests for the next scene, rate or device.
class Requested {
public:
    explicit Requested(Session &session) : session_(session) {}

    void ask(Exchange exchange) {
        constexpr std::array kScenes{"sphere", "organic", "plate"};
        constexpr std::array kRates_hz{2000.0, 1250.0, 1000.0};
        const std::size_t turn = turn_++;
        switch (exchange) {
        case Exchange::scene:
            session_.request_scene(testing::assets() / "scenes" /
                                   (std::string(kScenes[turn % 3]) + ".gltf"));
            break;
        case Exchange::rate:
            session_.set_servo_rate(kRates_hz[turn % 3]);
            break;
        case Exchange::device:
            session_.exchange_device(turn % 2 == 0 ? testing::premium()
                                                   : testing::scripted().device);
            ++devices;
            break;
        }
    }

    [[nodiscard]] bool is_done() const {
        return !session_.is_exchanging() && !session_.scenes().is_loading();
    }

    std::size_t devices = 0;

private:
    Session &session_;
    std::size_t turn_ = 0;
};

/// All files of a record together.
struct Sum {
    testing::JudgedRecord worst;
    std::size_t parts = 0;

    void add(const testing::JudgedRecord &part) {
        ++parts;
        worst.rows += part.rows;
        worst.felt += part.felt;
        worst.scenes += part.scenes;
        worst.rates += part.rates;
        worst.max_share = std::max(worst.max_share, part.max_share);
        worst.max_step_V = std::max(worst.max_step_V, part.max_step_V);
        worst.max_transfer_offset_V =
            std::max(worst.max_transfer_offset_V, part.max_transfer_offset_V);
    }
};

/// Checks every part of a session's record.
Sum judged(const Session &session) {
    Sum sum;
    for (const std::filesystem::path &part : session.recording().parts()) {
        const testing::JudgedRecord found = testing::judge_record(part);
        EXPECT_EQ(found.first_fault, "") << part;
        EXPECT_TRUE(found.replays) << part;
        sum.add(found);
    }
    EXPECT_EQ(session.recording().status().error, "");
    EXPECT_EQ(session.recording().status().lost, 0U);
    EXPECT_EQ(session.recording().status().rows, sum.worst.rows);
    return sum;
}

/// @param together  so many are requested at once, in contact, before it waits for them
Sum exchange_in_contact(SessionOptions options, std::span<const Exchange> exchanges,
                        std::size_t together) {
    const std::filesystem::path folder = testing::fresh_folder("exchange");
    options.plays_script = false;
    options.record = folder / "touch.rec";
    Session session(options);
    Requested requested(session);
    session.start();
    std::string so_far;
    for (std::size_t i = 0; i < exchanges.size(); ++i) {
        so_far += std::to_string(static_cast<int>(exchanges[i]));
        SCOPED_TRACE(so_far);
        if (requested.is_done()) {
            EXPECT_TRUE(press(session));
        }
        requested.ask(exchanges[i]);
        if ((i + 1) % together == 0) {
            EXPECT_TRUE(run_until(
                session, [&] { return requested.is_done(); }, 20.0));
        }
    }
    EXPECT_TRUE(press(session)); // everything is in use, and in contact
    session.stop();
    EXPECT_EQ(session.scenes().error(), "");
    const Sum sum = judged(session);
    if (together == 1) {
        EXPECT_EQ(sum.parts, 1 + requested.devices);
    }
    std::filesystem::remove_all(folder);
    return sum;
}

void note(const Sum &all) {
    ::testing::Test::RecordProperty("rows", std::to_string(all.worst.rows));
    ::testing::Test::RecordProperty("felt", std::to_string(all.worst.felt));
    ::testing::Test::RecordProperty("scenes", std::to_string(all.worst.scenes));
    ::testing::Test::RecordProperty("rates", std::to_string(all.worst.rates));
    ::testing::Test::RecordProperty("parts", std::to_string(all.parts));
    ::testing::Test::RecordProperty("step_V", std::to_string(all.worst.max_step_V));
    ::testing::Test::RecordProperty("share", std::to_string(all.worst.max_share));
    ::testing::Test::RecordProperty("carried_V", std::to_string(all.worst.max_transfer_offset_V));
}

/// In three sessions, so that their records stay short.
void exchange_in_every_order(std::span<const Exchange> exchanges, std::size_t in_a_session,
                             std::size_t together) {
    Sum all;
    for (std::size_t first = 0; first < 27 * together; first += 9 * together) {
        all.add(exchange_in_contact(testing::scripted(), exchanges.subspan(first, in_a_session),
                                    together)
                    .worst);
    }
    note(all);
    EXPECT_GT(all.worst.felt, 5'000U); // not vacuous
    EXPECT_GE(all.worst.scenes, 9U);
    EXPECT_GE(all.worst.rates, 9U);
    EXPECT_GT(all.worst.max_transfer_offset_V, 0.2);
}

TEST(Exchange, InContactOneByOneInEveryOrderCausesNoSteps) {
    exchange_in_every_order(in_every_order(), 9 + 2, 1);
}

TEST(Exchange, InContactSimultaneouslyInEveryOrderCausesNoSteps) {
    const std::vector<Exchange> sequence = in_every_order();
    std::vector<Exchange> threes;
    for (std::size_t first = 0; first + 3 <= sequence.size(); ++first) {
        threes.insert(threes.end(), &sequence[first], &sequence[first] + 3);
    }
    exchange_in_every_order(threes, 9 * 3, 3);
}

TEST(Exchange, OnTheRealThreadTheSameHolds) {
    SessionOptions options = testing::scripted();
    options.lockstep = false;
    const std::array order{Exchange::rate, Exchange::scene, Exchange::device};
    const Sum sum = exchange_in_contact(options, order, 1);
    note(sum);
    EXPECT_GT(sum.worst.felt, 100U);
    EXPECT_EQ(sum.parts, 2U);
}

} // namespace
} // namespace springdrive::session
