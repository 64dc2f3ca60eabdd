// Covers engine/session/session.cpp and session_device.cpp: scene, servo rate and device exchanged
// in contact, in every order, while a record runs. The record is checked by
// tests/support/exchange_judge.h.
#include "tests/engine/session/session_fixture.h"
#include "tests/support/exchange_judge.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace springdrive::session {
namespace {

using testing::press;
using testing::run_until;

enum class Exchange : std::uint8_t { scene, rate, device };
constexpr std::array kExchanges{Exchange::scene, Exchange::rate, Exchange::device};

/// All orders of three, with repetitions: 27.
std::vector<std::array<Exchange, 3>> every_order() {
    std::vector<std::array<Exchange, 3>> orders;
    for (const Exchange first : kExchanges) {
        for (const Exchange second : kExchanges) {
            for (const Exchange third : kExchanges) {
                orders.push_back({first, second, third});
            }
        }
    }
    return orders;
}

std::string name_of(const std::array<Exchange, 3> &order) {
    std::string name;
    for (const Exchange exchange : order) {
        name += exchange == Exchange::scene  ? "scene "
                : exchange == Exchange::rate ? "rate "
                                             : "device ";
    }
    return name;
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
Sum judged(const Session &session, const std::string &name) {
    Sum sum;
    for (const std::filesystem::path &part : session.recording().parts()) {
        const testing::JudgedRecord found = testing::judge_record(part);
        EXPECT_EQ(found.first_fault, "") << name << ", " << part;
        EXPECT_TRUE(found.replays) << name << ", " << part;
        sum.add(found);
    }
    EXPECT_EQ(session.recording().status().error, "") << name;
    EXPECT_EQ(session.recording().status().lost, 0U) << name;
    EXPECT_EQ(session.recording().status().rows, sum.worst.rows) << name;
    return sum;
}

/// @param apart  whether it waits for each one, in contact, or requests all at once
Sum exchange_in_contact(SessionOptions options, const std::array<Exchange, 3> &order, bool apart,
                        const std::filesystem::path &folder) {
    const std::string name = name_of(order) + (apart ? "apart" : "at once");
    options.plays_script = false;
    options.record = folder / "touch.rec";
    Session session(options);
    Requested requested(session);
    session.start();
    for (const Exchange exchange : order) {
        if (apart || requested.is_done()) {
            EXPECT_TRUE(press(session)) << name;
        }
        requested.ask(exchange);
        if (apart) {
            EXPECT_TRUE(run_until(
                session, [&] { return requested.is_done(); }, 20.0))
                << name;
        }
    }
    EXPECT_TRUE(run_until(
        session, [&] { return requested.is_done(); }, 20.0))
        << name;
    EXPECT_TRUE(press(session)) << name; // everything is in use, and in contact
    session.stop();
    EXPECT_EQ(session.scenes().error(), "") << name;
    const Sum sum = judged(session, name);
    if (apart) {
        EXPECT_EQ(sum.parts, 1 + requested.devices) << name;
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

void exchange_in_every_order(bool apart) {
    Sum all;
    for (const std::array<Exchange, 3> &order : every_order()) {
        const Sum sum = exchange_in_contact(testing::scripted(), order, apart,
                                            testing::fresh_folder("exchange"));
        all.parts += sum.parts - 1;
        all.add(sum.worst);
    }
    note(all);
    EXPECT_GT(all.worst.felt, 10'000U); // not vacuous
    EXPECT_GE(all.worst.scenes, 9U);
    EXPECT_GE(all.worst.rates, 9U);
    EXPECT_GT(all.worst.max_transfer_offset_V, 0.2);
}

TEST(Exchange, InContactOneByOneInEveryOrderCausesNoSteps) { exchange_in_every_order(true); }

TEST(Exchange, InContactSimultaneouslyInEveryOrderCausesNoSteps) { exchange_in_every_order(false); }

TEST(Exchange, OnTheRealThreadTheSameHolds) {
    SessionOptions options = testing::scripted();
    options.lockstep = false;
    const Sum sum =
        exchange_in_contact(options, {Exchange::rate, Exchange::scene, Exchange::device}, true,
                            testing::fresh_folder("exchange_clock"));
    note(sum);
    EXPECT_GT(sum.worst.felt, 100U);
    EXPECT_EQ(sum.parts, 2U);
}

} // namespace
} // namespace springdrive::session
