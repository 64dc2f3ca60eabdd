// Checks of the board's core that need no test framework, so that they run on the host and on the
// board's own processor. The last one compares all that a scripted trial puts out, to the last bit.
#pragma once

#include "device/usb/board/board.h"

namespace springdrive::testing {

/// A generator that is the same everywhere (xorshift, Marsaglia 2003).
class Dice {
public:
    std::uint32_t bits() {
        state_ ^= state_ << 13U;
        state_ ^= state_ >> 17U;
        state_ ^= state_ << 5U;
        return state_;
    }

private:
    std::uint32_t state_ = 2463534242U;
};

/// A board with windings, in `float` and without library functions, and a host in the same loop.
class CoreTrial {
public:
    /// The board's time rolls over 60 ms after the start.
    static constexpr std::uint32_t kStart_us = 0U - 60'000U;

    board::Board core{board::BoardSettings(), usb::Identity()};
    board::Samples samples;
    board::BridgeOrder order = board::BridgeOrder::opening();
    usb::Command command;
    bool host_sends = false;

    CoreTrial() {
        samples.time_us = kStart_us;
        samples.supply_V = 15.0F;
        samples.temperature_C[0] = 30.0F;
    }

    void run(int loops) {
        for (int i = 0; i < loops; ++i) {
            if (host_sends && loop_ % 40 == 0) {
                send();
            }
            order = core.tick(samples);
            note(order);
            settle_windings();
            samples.time_us += 25;
            ++loop_;
        }
    }

    usb::FrameStatus send() {
        ++command.number;
        const usb::Frame frame = usb::encode(command);
        return core.receive(frame.data(), frame.size(), samples.time_us);
    }

    void begin(bool resets_faults) {
        usb::Command first;
        first.number = ++command.number;
        first.begins_numbering = true;
        first.resets_faults = resets_faults;
        const usb::Frame frame = usb::encode(first);
        (void)core.receive(frame.data(), frame.size(), samples.time_us);
    }

    /// Until it drives, with independent or coupled channels.
    void drive(bool is_coupled) {
        run(1600);
        begin(false);
        host_sends = true;
        run(80);
        command.mode = usb::Mode::drive;
        command.e_W_V = {0.3F, -0.2F, 0.1F};
        command.cancelled_resistance_Ohm.diagonal = {1.68F, 1.5F, 1.4F};
        if (is_coupled) {
            command.cancelled_resistance_Ohm.off_diagonal = {0.1F, -0.2F, 0.15F};
            command.cancelled_inductance_H = {{-0.1e-3F, -0.2e-3F, 0.0F}, {1e-5F, 0.0F, -2e-5F}};
        }
        run(400);
    }

    [[nodiscard]] board::State state() const { return core.loop().state(); }
    /// Of every duty ratio and report.
    [[nodiscard]] std::uint32_t checksum() const { return checksum_; }
    [[nodiscard]] bool is_safe() const { return is_safe_; }

private:
    /// One PWM period of 25 µs: e^(−R h/L) is 0.7953 for 2.18 Ω and 0.238 mH. Rotors turn so
    /// slowly, 3.8 rad/s, that a back-EMF, which is not there, would leave the most of dR i.
    void settle_windings() {
        constexpr float kDecay = 0.7953F;
        for (std::size_t i = 0; i < 3; ++i) {
            const float settled_A = 15.0F * order.duty_ratio[i] / 2.18F;
            samples.current_A[i] = order.stage[i] == board::Stage::open
                                       ? 0.0F
                                       : settled_A + kDecay * (samples.current_A[i] - settled_A);
            samples.encoder[i] = static_cast<std::uint16_t>(
                samples.encoder[i] + (order.duty_ratio[i] > 0.01F && loop_ % 16 == 0 ? 1U : 0U));
        }
    }

    void note(const board::BridgeOrder &given) {
        for (const float duty_ratio : given.duty_ratio) {
            is_safe_ = is_safe_ && duty_ratio >= -0.95F && duty_ratio <= 0.95F;
            mix(std::bit_cast<std::uint32_t>(duty_ratio));
        }
        usb::Frame frame;
        if (core.take_report(frame)) {
            mix(usb::crc32(frame.data(), frame.size()));
        }
    }

    void mix(std::uint32_t value) { checksum_ = (checksum_ ^ value) * 16777619U; }

    std::uint32_t loop_ = 0;
    std::uint32_t checksum_ = 2166136261U;
    bool is_safe_ = true;
};

inline bool checksum_is_right() {
    constexpr std::array<std::uint8_t, 9> kDigits{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
    return usb::crc32(kDigits.data(), kDigits.size()) == 0xcbf43926U;
}

inline bool frames_survive_and_damage_is_rejected() {
    Dice dice;
    for (int trial = 0; trial < 20; ++trial) {
        usb::Command command;
        command.number = dice.bits();
        command.e_W_V = {static_cast<float>(dice.bits()), -1e-40F, 1.5F};
        command.cancelled_resistance_Ohm.off_diagonal[1] = -0.25F;
        const usb::Frame frame = usb::encode(command);
        usb::Command read;
        if (usb::decode(frame.data(), frame.size(), read) != usb::FrameStatus::ok ||
            read.number != command.number || read.e_W_V != command.e_W_V ||
            usb::encode(read) != frame) {
            return false;
        }
        for (std::size_t bit = 0; bit < 8 * frame.size(); ++bit) {
            usb::Frame damaged = frame;
            damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
            if (usb::decode(damaged.data(), damaged.size(), read) != usb::FrameStatus::wrong_crc) {
                return false;
            }
        }
    }
    return true;
}

inline bool encoder_follows() {
    Dice dice;
    board::Encoder encoder;
    std::int32_t truth = 0;
    (void)encoder.update(0, 64);
    for (int i = 0; i < 50'000; ++i) {
        truth += static_cast<std::int32_t>(dice.bits() % 97U) - 32; // drifts by 15 a step
        if (!encoder.update(static_cast<std::uint16_t>(truth), 64) || encoder.counts(1) != truth ||
            encoder.counts(-1) != -truth) {
            return false;
        }
    }
    return truth > 10 * 65536;
}

inline bool watchdog_brakes() {
    CoreTrial trial;
    trial.drive(false);
    const bool drove = trial.state() == board::State::driving;
    trial.host_sends = false;
    trial.run(241); // 6 ms
    return drove && trial.state() == board::State::fault_braking &&
           trial.core.loop().faults() == usb::Faults::kNoCommand && trial.is_safe();
}

inline bool faults_open_or_brake() {
    CoreTrial trial;
    trial.drive(true);
    trial.samples.current_A[1] = board::kNotMeasured;
    trial.run(1);
    const bool has_opened =
        trial.state() == board::State::fault_open && trial.order.stage[0] == board::Stage::open;
    trial.samples.current_A = {};
    trial.begin(true);
    trial.command.mode = usb::Mode::brake;
    trial.run(1600);
    return has_opened && trial.state() == board::State::braking && trial.is_safe();
}

inline bool nothing_unsafe_reaches_the_bridge() {
    Dice dice;
    CoreTrial trial;
    trial.drive(true);
    for (int i = 0; i < 3000; ++i) {
        if (i % 100 == 0) {
            trial.samples.current_A = {};
            trial.samples.supply_V = 15.0F;
            trial.command.mode = usb::Mode::brake;
            trial.begin(true);
            trial.run(1400);
            trial.command.mode = usb::Mode::drive;
        }
        const auto any = std::bit_cast<float>(dice.bits());
        if (i % 3 == 0) {
            trial.samples.current_A[dice.bits() % 3U] = any;
        } else if (i % 3 == 1) {
            trial.samples.supply_V = any;
        } else {
            trial.command.e_W_V[0] = any;
        }
        trial.run(3);
    }
    return trial.is_safe();
}

/// Of everything that `trial_is_the_same_everywhere` puts out, on the processors on which it ran.
inline constexpr std::uint32_t kTrialChecksum = 0xcbf77d1fU;

inline std::uint32_t trial_checksum() {
    CoreTrial trial;
    trial.drive(false);
    trial.command.e_W_V = {11.0F, -3.0F, 6.0F}; // to the limits
    trial.run(800);
    trial.command.e_W_V = {0.0F, 0.0F, 0.0F};
    trial.run(400);
    trial.drive(true);
    trial.host_sends = false;
    trial.run(400); // silence
    trial.begin(true);
    const std::uint32_t number = trial.command.number;
    trial.command = usb::Command();
    trial.command.number = number;
    trial.host_sends = true;
    trial.run(80);
    const auto order = usb::encode(usb::SelfTestOrder{0.5F, 8000});
    (void)trial.core.control_out(static_cast<std::uint8_t>(usb::Kind::self_test), order.data(),
                                 order.size());
    trial.run(24'000);
    std::array<std::uint8_t, board::kMaxPayload> payload{};
    const std::size_t size =
        trial.core.control_in(static_cast<std::uint8_t>(usb::Kind::self_test), 0, payload.data());
    return trial.checksum() ^ usb::crc32(payload.data(), size);
}

inline bool trial_is_the_same_everywhere() { return trial_checksum() == kTrialChecksum; }

struct CoreCheck {
    const char *name;
    bool (*holds)();
};

inline constexpr std::array<CoreCheck, 7> kCoreChecks{{
    {"checksum_is_right", checksum_is_right},
    {"frames_survive_and_damage_is_rejected", frames_survive_and_damage_is_rejected},
    {"encoder_follows", encoder_follows},
    {"watchdog_brakes", watchdog_brakes},
    {"faults_open_or_brake", faults_open_or_brake},
    {"nothing_unsafe_reaches_the_bridge", nothing_unsafe_reaches_the_bridge},
    {"trial_is_the_same_everywhere", trial_is_the_same_everywhere},
}};

} // namespace springdrive::testing
