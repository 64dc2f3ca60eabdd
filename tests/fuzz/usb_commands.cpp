// Packets, requests, samples and time for a board's core: whatever they are, duty ratios stay in
// their limits, and nothing drives without a command that was accepted a short time ago.
#include "device/usb/board/board.h"
#include "tests/fuzz/usb_targets.h"

#include <cmath>

namespace springdrive::fuzz {

namespace {

using board::Stage;
using usb::BoardState;
using usb::FrameStatus;
using usb::Kind;

/// In one input: a board's start, and most of a self-test.
constexpr int kMaxTicks = 16'000;

board::BoardSettings settings_by(std::uint8_t choices) {
    board::BoardSettings settings;
    settings.couples_channels = (choices & 1U) != 0;
    settings.measures_supply = (choices & 2U) != 0;
    settings.has_stop_switch = (choices & 4U) != 0;
    settings.loop_rate_hz = (choices & 8U) != 0 ? 40'000 : 20'000;
    return settings;
}

class BoardTrial {
public:
    explicit BoardTrial(std::span<const std::uint8_t> input)
        : input_(input), choices_(input_.byte()), settings_(settings_by(choices_)),
          board_(settings_, usb::Identity()),
          // Soon the board's 32 bits begin again at 0.
          time_us_((choices_ & 16U) != 0 ? 0xffff'0000U : 0U) {
        samples_.supply_V = 15.0F;
        samples_.temperature_C[0] = 30.0F;
    }

    void run() {
        if ((choices_ & 32U) != 0) {
            run(1200); // the current sensors' offsets are measured
        }
        while (input_.has_more()) {
            operate();
        }
        check_counters();
    }

private:
    void operate() {
        switch (input_.byte() % 16) {
        case 0:
            run(input_.byte() + 1);
            break;
        case 1:
            run(40 * (input_.byte() + 1));
            break;
        case 2:
            run_with_host(40 * (input_.byte() + 1));
            break;
        case 3:
            receive_command();
            break;
        case 4:
            receive_raw();
            break;
        case 5: // the same packet again
            receive(packet_);
            break;
        case 6:
            order_known();
            break;
        case 7:
            order_raw();
            break;
        case 8:
            ask();
            break;
        case 9:
            board_.disconnect();
            has_numbering_ = false;
            break;
        case 10:
            board_.set_speed((input_.byte() & 1U) != 0);
            break;
        case 11:
            take_report();
            break;
        case 12:
            set_sample();
            break;
        case 13: // time that no loop saw, unlike the last command: up to 18 minutes
            run(1);
            skipped_us_ = input_.u32() / 4U;
            run(1);
            break;
        case 14:
            store();
            break;
        default:
            samples_ = sound_samples();
            break;
        }
    }

    // Packets.

    void receive(std::vector<std::uint8_t> bytes) {
        packet_ = std::move(bytes);
        usb::Command command;
        const FrameStatus decoded = decoded_and_encoded(packet_, command);
        const std::uint64_t arrived_at_us = time_us_ + 12;
        const FrameStatus status = board_.receive(packet_.data(), packet_.size(),
                                                  static_cast<std::uint32_t>(arrived_at_us));
        ++packets_;
        if (decoded != FrameStatus::ok) {
            require(status == decoded, "not rejected for what is wrong with it");
        } else {
            check_number(command, status);
        }
        if (status != FrameStatus::ok) {
            return;
        }
        ++accepted_packets_;
        require(settings_.couples_channels || command.mode != usb::Mode::drive ||
                    (command.cancelled_resistance_Ohm.is_diagonal() &&
                     command.cancelled_inductance_H.is_diagonal()),
                "couples channels that are independent");
        for (const float e_W_V : command.e_W_V) {
            require(command.mode != usb::Mode::drive ||
                        board::magnitude(e_W_V) <= settings_.largest_voltage_V,
                    "accepted above the largest voltage");
        }
        accepted_ = command;
        accepted_at_us_ = arrived_at_us;
        has_numbering_ = true;
    }

    void check_number(const usb::Command &command, FrameStatus status) const {
        const std::int32_t newer = usb::difference(command.number, accepted_.number);
        const FrameStatus expected = command.begins_numbering ? FrameStatus::ok
                                     : !has_numbering_        ? FrameStatus::stale
                                     : newer > 0              ? FrameStatus::ok
                                     : newer == 0             ? FrameStatus::repeated
                                                              : FrameStatus::stale;
        const bool is_of_limits =
            status == FrameStatus::beyond_limits || status == FrameStatus::coupled;
        require(expected == status || (expected == FrameStatus::ok && is_of_limits &&
                                       command.mode == usb::Mode::drive),
                "a number taken for another");
    }

    /// Few bytes for a command that may well be accepted.
    void receive_command() {
        const std::uint8_t form = input_.byte();
        usb::Command command;
        command.mode = static_cast<usb::Mode>(form & 3U); // or none that exists
        command.begins_numbering = (form & 4U) != 0;
        command.resets_faults = (form & 8U) != 0;
        command.number = accepted_.number + ((form & 16U) != 0 ? input_.u32() : 1U);
        command.watchdog_us = static_cast<std::uint16_t>(500U + 200U * input_.byte());
        const std::uint8_t after = input_.byte();
        command.report_after_us =
            after == 0xff ? usb::kKeepPhase : static_cast<std::uint16_t>(8U * after);
        for (float &e_W_V : command.e_W_V) {
            e_W_V = 0.1F * static_cast<float>(input_.signed_byte());
        }
        if ((form & 32U) != 0) {
            take_matrix(command.cancelled_resistance_Ohm, 0.03F);
        }
        if ((form & 64U) != 0) {
            take_matrix(command.cancelled_inductance_H, 5e-6F);
        }
        const usb::Frame frame = usb::encode(command);
        receive({frame.begin(), frame.end()});
    }

    void take_matrix(usb::SymmetricMatrix &matrix, float unit) {
        for (std::size_t i = 0; i < usb::kChannels; ++i) {
            matrix.diagonal[i] = unit * static_cast<float>(input_.signed_byte());
            matrix.off_diagonal[i] = unit * static_cast<float>(input_.signed_byte());
        }
    }

    void receive_raw() {
        const std::uint8_t form = input_.byte();
        std::vector<std::uint8_t> bytes =
            input_.bytes((form & 1U) != 0 ? input_.byte() : usb::kFrameSize);
        if ((form & 2U) != 0) {
            bytes.resize(usb::kFrameSize);
        }
        if ((form & 4U) != 0) {
            seal(bytes, Kind::command);
        }
        receive(std::move(bytes));
    }

    // Control requests.

    void order_known() {
        switch (input_.byte() % 4) {
        case 0: {
            usb::Zeroing zeroing;
            for (std::int32_t &counts : zeroing.counts) {
                counts = static_cast<std::int32_t>(input_.u32());
            }
            order(Kind::zero, usb::encode(zeroing));
            break;
        }
        case 1:
            order(Kind::report_rate, usb::encode(usb::ReportRate{input_.u16()}));
            break;
        case 2:
            order(Kind::calibration, usb::encode(calibration_block()));
            break;
        default:
            order(Kind::self_test,
                  usb::encode(usb::SelfTestOrder{0.01F * static_cast<float>(input_.byte()),
                                                 100U * input_.byte()}));
            break;
        }
    }

    usb::CalibrationBlock calibration_block() {
        const std::uint8_t index = input_.byte();
        usb::BoardCalibration calibration;
        if (index == 0) {
            for (std::size_t i = 0; i < usb::kChannels; ++i) {
                calibration.current_gain[i] += 0.002F * static_cast<float>(input_.signed_byte());
                calibration.largest_cancelled_Ohm[i] = 0.02F * static_cast<float>(input_.byte());
                calibration.encoder_sign[i] = (input_.byte() & 1U) != 0 ? -1 : 1;
            }
        }
        usb::CalibrationBlock block = usb::block_of(calibration);
        block.index = index;
        return block;
    }

    void order_raw() {
        const auto kind = static_cast<Kind>(input_.byte());
        const bool is_sealed = (input_.byte() & 1U) != 0;
        std::vector<std::uint8_t> bytes = input_.bytes(input_.byte());
        if (is_sealed) {
            seal(bytes, kind);
        }
        order(kind, bytes);
    }

    void order(Kind kind, std::span<const std::uint8_t> bytes) {
        const std::vector<std::uint8_t> payload(bytes.begin(), bytes.end());
        const bool is_accepted =
            board_.control_out(static_cast<std::uint8_t>(kind), payload.data(), payload.size());
        require(!is_accepted || is_known(kind, payload), "accepted, but no such request");
    }

    static bool is_known(Kind kind, const std::vector<std::uint8_t> &payload) {
        switch (kind) {
        case Kind::zero:
            return decodes<usb::Zeroing>(payload);
        case Kind::report_rate:
            return decodes<usb::ReportRate>(payload);
        case Kind::calibration:
            return decodes<usb::CalibrationBlock>(payload);
        case Kind::self_test:
            return decodes<usb::SelfTestOrder>(payload);
        default:
            return false;
        }
    }

    template <class Value> static bool decodes(std::span<const std::uint8_t> payload) {
        Value value;
        return decoded_and_encoded(payload, value) == FrameStatus::ok;
    }

    void ask() {
        const std::uint8_t request = input_.byte();
        const std::uint16_t value = input_.u16();
        std::vector<std::uint8_t> answer(board::kMaxPayload);
        const std::size_t size = board_.control_in(request, value, answer.data());
        require(size <= answer.size(), "an answer that is too large");
        const auto payload = std::span(answer).first(size);
        switch (static_cast<Kind>(request)) {
        case Kind::identity:
            require(decodes<usb::Identity>(payload), "no identity");
            break;
        case Kind::capabilities:
            require(decodes<usb::Capabilities>(payload), "no capabilities");
            break;
        case Kind::counters:
            require(decodes<usb::Counters>(payload), "no counters");
            break;
        case Kind::self_test:
            require(decodes<usb::SelfTestResult>(payload), "no result of a test");
            break;
        case Kind::calibration:
            require(value < board::kCalibrationBlocks ? decodes<usb::CalibrationBlock>(payload)
                                                      : size == 0,
                    "no calibration block");
            break;
        default:
            require(size == 0, "an answer to no request");
            break;
        }
    }

    void store() {
        usb::CalibrationBlock block;
        if ((input_.byte() & 1U) != 0) {
            board_.load(calibration_block());
        }
        if (board_.take_block_to_store(block)) {
            require(block.index < board::kCalibrationBlocks, "stores a block that does not exist");
            require(board_.loop().state() != BoardState::driving, "stores while it drives");
            board_.end_store(block.index, true);
        }
    }

    void check_counters() const {
        std::vector<std::uint8_t> answer(board::kMaxPayload);
        const std::size_t size =
            board_.control_in(static_cast<std::uint8_t>(Kind::counters), 0, answer.data());
        usb::Counters counters;
        require(usb::decode(answer.data(), size, counters) == FrameStatus::ok, "no counters");
        std::uint32_t sum = 0;
        for (const std::uint32_t frames : counters.frames) {
            sum += frames;
        }
        require(sum == packets_ && counters.frames[0] == accepted_packets_,
                "packets that were not counted");
    }

    // Reports.

    void take_report() {
        usb::Frame frame{};
        if (!board_.take_report(frame)) {
            return;
        }
        usb::Report report;
        require(decoded_and_encoded(std::span<const std::uint8_t>(frame), report) ==
                    FrameStatus::ok,
                "an invalid report");
        require(usb::difference(report.number, report_number_) > 0, "an old report");
        require(report.rejected_frames == static_cast<std::uint16_t>(packets_ - accepted_packets_),
                "rejected frames that were not counted");
        report_number_ = report.number;
    }

    // Samples and time.

    [[nodiscard]] board::Samples sound_samples() const {
        board::Samples samples;
        samples.encoder = samples_.encoder;
        samples.supply_V = 15.0F;
        samples.temperature_C[0] = 30.0F;
        return samples;
    }

    /// Far beyond what a converter says, but no overflow when squared and summed.
    static float current_A(float any_A) {
        constexpr float kWildest_A = 100.0F;
        return usb::is_finite(any_A) ? std::clamp(any_A, -kWildest_A, kWildest_A) : any_A;
    }

    void set_sample() {
        const std::uint8_t which = input_.byte();
        const std::size_t channel = which / 16U % usb::kChannels;
        switch (which % 8) {
        case 0:
            samples_.current_A[channel] = current_A(input_.any_float());
            break;
        case 1:
            samples_.current_A[channel] = 0.1F * static_cast<float>(input_.signed_byte());
            break;
        case 2:
            samples_.supply_V = input_.any_float();
            break;
        case 3:
            samples_.supply_V = 0.1F * static_cast<float>(input_.byte());
            break;
        case 4:
            samples_.temperature_C[channel] = input_.any_float();
            break;
        case 5:
            samples_.encoder[channel] = input_.u16();
            break;
        case 6:
            has_windings_ = !has_windings_;
            break;
        default:
            samples_.is_enabled = (which & 16U) == 0;
            samples_.is_stopped = (which & 32U) != 0;
            samples_.stage_failed = (which & 64U) != 0;
            break;
        }
    }

    /// With a host that goes on sending its last command.
    void run_with_host(int ticks) {
        constexpr int kTicksOfHost = 40;
        for (int i = 0; i < ticks && ticks_ < kMaxTicks; ++i) {
            if (i % kTicksOfHost == 0) {
                usb::Command command = accepted_;
                ++command.number;
                command.begins_numbering = false;
                command.resets_faults = false;
                const usb::Frame frame = usb::encode(command);
                receive({frame.begin(), frame.end()});
            }
            run(1);
        }
    }

    void run(int ticks) {
        for (int i = 0; i < ticks && ticks_ < kMaxTicks; ++i, ++ticks_) {
            time_us_ += 1'000'000U / settings_.loop_rate_hz + skipped_us_;
            skipped_us_ = 0;
            samples_.time_us = static_cast<std::uint32_t>(time_us_);
            const board::BridgeOrder order = board_.tick(samples_);
            check(order);
            if (has_windings_) {
                settle_windings(order);
            }
        }
    }

    /// Windings and rotors, roughly.
    void settle_windings(const board::BridgeOrder &order) {
        for (std::size_t i = 0; i < usb::kChannels; ++i) {
            const float settled_A = 15.0F * order.duty_ratio[i] / 2.18F;
            samples_.current_A[i] = order.stage[i] == Stage::open
                                        ? 0.0F
                                        : settled_A + 0.8F * (samples_.current_A[i] - settled_A);
            samples_.encoder[i] = static_cast<std::uint16_t>(
                samples_.encoder[i] + (order.duty_ratio[i] > 0.01F ? 1U : 0U));
        }
    }

    void check(const board::BridgeOrder &order) {
        bool is_any_driven = false;
        bool are_all_open = true;
        for (std::size_t i = 0; i < usb::kChannels; ++i) {
            // Not for NaN.
            require(board::magnitude(order.duty_ratio[i]) <= settings_.largest_duty_ratio,
                    "a duty ratio beyond its limit");
            const bool is_driven = order.stage[i] == Stage::drive;
            require(is_driven || order.duty_ratio[i] == 0.0F, "a duty ratio that is not driven");
            is_any_driven = is_any_driven || is_driven;
            are_all_open = are_all_open && order.stage[i] == Stage::open;
        }
        const bool is_reliable = usb::is_finite(samples_.current_A) && !samples_.stage_failed;
        require(is_reliable || are_all_open, "an amplifier that fails is not opened");
        if (is_any_driven) {
            check_driving(order);
        }
    }

    void check_driving(const board::BridgeOrder &order) const {
        const BoardState state = board_.loop().state();
        require(state == BoardState::driving || state == BoardState::testing,
                "drives in another state");
        require(board_.loop().faults() == 0, "drives with a fault");
        require(samples_.is_enabled && !(settings_.has_stop_switch && samples_.is_stopped),
                "drives though stopped");
        require(has_numbering_, "drives after a disconnection");
        require(time_us_ <= accepted_at_us_ + accepted_.watchdog_us,
                "drives without a recent command");
        require(state == BoardState::testing || accepted_.mode == usb::Mode::drive,
                "drives on a command to brake or open");
        const float supply_V =
            settings_.measures_supply ? samples_.supply_V : settings_.nominal_supply_V;
        const float largest_V = state == BoardState::testing ? settings_.self_test.largest_voltage_V
                                                             : settings_.largest_voltage_V;
        for (const float duty_ratio : order.duty_ratio) {
            // A supply that is measured wrongly is known some loops later.
            require(!(supply_V > 0.0F) ||
                        board::magnitude(duty_ratio * supply_V) <= largest_V * 1.00001F,
                    "a voltage beyond its limit");
        }
    }

    FuzzInput input_;
    std::uint8_t choices_;
    board::BoardSettings settings_;
    board::Board board_;
    board::Samples samples_;
    bool has_windings_ = false;
    std::uint64_t time_us_;
    std::uint32_t skipped_us_ = 0;
    int ticks_ = 0;

    std::vector<std::uint8_t> packet_;
    std::uint32_t packets_ = 0;
    std::uint32_t accepted_packets_ = 0;
    usb::Command accepted_; ///< the last one
    std::uint64_t accepted_at_us_ = 0;
    bool has_numbering_ = false; ///< a command was accepted since the connection
    std::uint32_t report_number_ = 0;
};

} // namespace

void take_usb_commands(std::span<const std::uint8_t> input) { BoardTrial(input).run(); }

} // namespace springdrive::fuzz
