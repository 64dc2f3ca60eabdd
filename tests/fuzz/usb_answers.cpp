// A whole board's answers to the driver, and what is done with the device meanwhile: by a clock
// that passes only while the driver waits. Nothing but an InputError of one line is thrown, nothing
// waits for long, and every packet that leaves is valid.
#include "base/input_error.h"
#include "device/usb/board/link.h"
#include "device/usb/driver/usb_device.h"
#include "tests/fuzz/usb_targets.h"

#include <cmath>

namespace springdrive::fuzz {

namespace {

using usb::FrameStatus;
using usb::Kind;

/// A board whose answers and packets the input decides.
class AnsweringPort final : public usb::BoardPort {
public:
    explicit AnsweringPort(FuzzInput &input) : input_(input) { report_.has_command = true; }

    bool send(const usb::Frame &frame) noexcept override {
        usb::Command command;
        has_sent_invalid_ = has_sent_invalid_ ||
                            usb::decode(frame.data(), frame.size(), command) != FrameStatus::ok ||
                            (has_sent_ && command.number != sent_ + 1U);
        sent_ = command.number;
        has_sent_ = true;
        return is_connected_ && (!is_odd_ || input_.byte() != 1);
    }

    bool receive(usb::Packet &packet, double deadline_s) noexcept override {
        if (!is_connected_) {
            return false;
        }
        if (!has_next_) {
            prepare();
        }
        if (!has_next_ || next_.arrived_s > std::max(deadline_s, now_s_)) {
            now_s_ = std::max(deadline_s, now_s_);
            return false;
        }
        now_s_ = std::max(now_s_, next_.arrived_s);
        packet = next_;
        has_next_ = false;
        return true;
    }

    [[nodiscard]] bool is_connected() const noexcept override { return is_connected_; }
    [[nodiscard]] double now_s() const noexcept override { return now_s_; }

    std::size_t control_in(Kind request, std::uint16_t /*value*/,
                           std::span<std::uint8_t> answer) override {
        const std::uint8_t form = input_.byte();
        now_s_ += 1e-4;
        if (!is_connected_ || form == 1) {
            throw InputError("the USB board: it does not answer");
        }
        if (form == 2) {
            return 0;
        }
        std::vector<std::uint8_t> payload(board::kMaxPayload);
        board::LoopStatus loop;
        loop.largest_cancelled_Ohm = {2.0F, 2.0F, 2.0F};
        payload.resize(
            board_.control_in(static_cast<std::uint8_t>(request), 0, payload.data(), loop));
        if (form >= 3) {
            damage(payload, request);
        }
        const std::size_t size = std::min(payload.size(), answer.size());
        std::copy_n(payload.begin(), size, answer.begin());
        return size;
    }

    bool control_out(Kind request, std::uint16_t /*value*/,
                     std::span<const std::uint8_t> payload) override {
        usb::ReportRate rate;
        usb::Zeroing zeroing;
        require(request == Kind::report_rate
                    ? decoded_and_encoded(payload, rate) == FrameStatus::ok
                    : request == Kind::zero &&
                          decoded_and_encoded(payload, zeroing) == FrameStatus::ok,
                "sends an invalid request");
        const std::uint8_t form = input_.byte();
        now_s_ += 1e-4;
        if (!is_connected_ || form == 1) {
            throw InputError("the USB board: it does not answer");
        }
        report_.zeroings =
            static_cast<std::uint8_t>((report_.zeroings + (request == Kind::zero ? 1U : 0U)) & 15U);
        return form != 2;
    }

    void close() noexcept override { is_connected_ = false; }

    void open(const std::string &serial) override {
        const std::uint8_t form = input_.byte();
        is_connected_ = false;
        if (form == 1) {
            throw InputError("no USB board is connected");
        }
        require(serial.size() <= usb::kSerialSize, "looks for a serial number that no board has");
        is_connected_ = true;
        has_next_ = false;
        good_reports_ = 0;
        is_odd_ = (form & 2U) != 0;
        if ((form & 4U) != 0) { // the board has restarted meanwhile
            report_ = usb::Report();
        }
    }

    [[nodiscard]] std::string_view speed() const override { return "high speed (480 Mbit/s)"; }

    [[nodiscard]] bool has_sent_invalid() const { return has_sent_invalid_; }
    void pass(double seconds) { now_s_ += seconds; }

private:
    /// The bytes from some place on are the input's; with the right checksum, as a rule.
    void damage(std::vector<std::uint8_t> &payload, Kind request) {
        const std::uint8_t form = input_.byte();
        if ((form & 1U) != 0) {
            payload.resize(input_.byte() % (board::kMaxPayload + 1U));
        }
        for (int i = 0; i < form / 32 && !payload.empty(); ++i) {
            const std::size_t place = input_.byte() % payload.size();
            const std::vector<std::uint8_t> patch = input_.bytes((form & 2U) != 0 ? 4 : 1);
            std::copy_n(patch.begin(), std::min(patch.size(), payload.size() - place),
                        payload.begin() + static_cast<std::ptrdiff_t>(place));
        }
        if ((form & 4U) == 0) {
            const std::uint8_t version = payload.empty() ? 0 : payload[0];
            seal(payload, request);
            if ((form & 8U) != 0 && !payload.empty()) {
                payload[0] = version;
            }
        }
    }

    /// The next packet, if there is to be one.
    void prepare() noexcept {
        if (good_reports_ > 0) {
            --good_reports_;
            put_report(1000);
            return;
        }
        if (!input_.has_more()) {
            return;
        }
        const std::uint8_t form = input_.byte();
        switch (form % 8) {
        case 0: // as they should be, for a while
            good_reports_ = form / 8;
            put_report(1000);
            break;
        case 1: // none
            break;
        case 2:
            is_connected_ = false;
            break;
        case 3:
            is_odd_ = !is_odd_;
            put_report(10U * input_.byte());
            break;
        case 4:
            put_odd_report();
            break;
        case 5:
            put_raw((form & 8U) != 0);
            break;
        case 6: // repeated
            has_next_ = true;
            next_.arrived_s = now_s_ + 1e-5 * input_.byte();
            break;
        default: // damaged
            put_report(1000);
            next_.data[input_.byte() % next_.data.size()] ^= static_cast<std::uint8_t>(1U << 4U);
            next_.size = (form & 8U) != 0 ? input_.byte() % (usb::kFrameSize + 1) : next_.size;
            break;
        }
    }

    void put_report(std::uint32_t after_us) noexcept {
        ++report_.number;
        report_.measured_at_us += after_us;
        report_.state = usb::BoardState::braking;
        if (has_sent_) {
            report_.has_command = true;
            report_.command_number = sent_;
            report_.command_arrived_at_us = report_.measured_at_us - 200;
            report_.applied_after_us = 30;
        }
        put(1e-6 * after_us);
    }

    void put_odd_report() noexcept {
        const std::uint8_t form = input_.byte();
        report_.number += (form & 1U) != 0 ? input_.u32() : 1U;
        report_.measured_at_us += (form & 2U) != 0 ? input_.u32() : 1000U;
        report_.has_command = (form & 4U) == 0;
        report_.state = static_cast<usb::BoardState>(input_.byte() % usb::kBoardStates);
        report_.command_number = (form & 8U) != 0 ? input_.u32() : sent_;
        report_.command_arrived_at_us = (form & 16U) != 0 ? input_.u32() : report_.measured_at_us;
        report_.applied_after_us = (form & 32U) != 0 ? input_.u16() : std::uint16_t{30};
        report_.zeroings =
            static_cast<std::uint8_t>((form & 64U) != 0 ? input_.byte() & 15U : report_.zeroings);
        report_.last_rejection =
            static_cast<FrameStatus>((form & 128U) != 0 ? input_.byte() % usb::kFrameStatuses : 0U);
        for (float &current_A : report_.current_A) {
            current_A = (form & 128U) != 0 ? input_.any_float() : 0.0F;
        }
        put(1e-5 * input_.byte());
    }

    void put_raw(bool is_sealed) noexcept {
        const std::vector<std::uint8_t> bytes = input_.bytes(next_.data.size());
        std::ranges::copy(bytes, next_.data.begin());
        next_.size = bytes.size();
        if (is_sealed) {
            next_.size = next_.data.size();
            seal(next_.data, Kind::report);
        }
        has_next_ = true;
        next_.arrived_s = now_s_ + 1e-5 * input_.byte();
    }

    void put(double after_s) noexcept {
        next_.data = usb::encode(report_);
        next_.size = next_.data.size();
        next_.arrived_s = now_s_ + after_s;
        has_next_ = true;
    }

    static usb::Identity identity() {
        usb::Identity board;
        board.serial = {'S', '1'};
        board.name = {'b', 'o', 'a', 'r', 'd'};
        return board;
    }

    FuzzInput &input_;
    board::Link board_{board::BoardSettings(), identity()};
    bool is_connected_ = false;
    double now_s_ = 100.0;
    usb::Report report_;
    usb::Packet next_;
    bool has_next_ = false;
    std::uint32_t good_reports_ = 0; ///< that follow
    bool is_odd_ = false;            ///< packets cannot always be queued
    std::uint32_t sent_ = 0;         ///< the number of the last command
    bool has_sent_ = false;
    bool has_sent_invalid_ = false;
};

/// As much of the PHANTOM's as the driver looks at.
device::DeviceDescription description_of_phantom() {
    device::DeviceDescription description;
    description.encoder_counts_per_turn = 4096;
    description.amplifier.max_cancelled_Ohm = 2.0;
    for (device::MotorParameters &motor : description.motor) {
        motor.supply_V = 12.0;
        motor.peak_current_A = 5.5;
    }
    return description;
}

class DeviceTrial {
public:
    explicit DeviceTrial(std::span<const std::uint8_t> input) : input_(input) {}

    void run() {
        const std::uint8_t form = input_.byte();
        auto owned = std::make_unique<AnsweringPort>(input_);
        port_ = owned.get();
        period_s_ = (form & 2U) != 0 ? period_s() : 1e-3;
        const double begin_s = port_->now_s();
        try {
            usb::UsbDevice device(std::move(owned), description_of_phantom(),
                                  (form & 4U) != 0 ? "S1" : "", period_s_,
                                  (form & 1U) != 0 ? usb::Pacing::reports : usb::Pacing::clock);
            device_ = &device;
            require_time(begin_s, connecting_s());
            check_description();
            while (input_.has_more()) {
                operate();
            }
            require(!port_->has_sent_invalid(), "sends an invalid command");
        } catch (const InputError &error) {
            require_one_line(error.what());
        }
    }

private:
    void operate() {
        const std::uint8_t form = input_.byte();
        const double begin_s = port_->now_s();
        try {
            switch (form % 8) {
            case 0:
            case 1:
                for (int i = 0; i <= form / 8; ++i) { // ticks of the servo
                    read();
                    write(0);
                }
                return;
            case 2:
                write(input_.byte());
                return;
            case 3:
                device_->zero(Vector3::Constant(0.01 * input_.signed_byte()));
                require(device_->is_zeroed(), "is not zeroed, but says so");
                break;
            case 4:
                has_number_ = false;
                device_->reconnect();
                check_description();
                break;
            case 5:
                device_->close();
                require_time(begin_s, 4.0 * period_s_);
                break;
            case 6:
                set_period();
                break;
            default:
                look();
                port_->pass(1e-4 * input_.byte());
                return;
            }
        } catch (const InputError &error) {
            require_one_line(error.what());
        }
        require_time(begin_s, connecting_s());
    }

    void read() {
        const double begin_s = port_->now_s();
        const device::Measurement measured = device_->read();
        require_time(begin_s, 0.06 + period_s_);
        require(measured.health == device::DeviceHealth::lost || port_->is_connected(),
                "is well without a connection");
        require(!has_number_ || measured.number >= number_, "the newest number goes back");
        require(!has_number_ || measured.time_s >= time_s_, "device time goes back");
        require(!has_number_ || measured.number > number_ || !device::is_new(measured.arrival),
                "old, but passes for new");
        number_ = measured.number;
        time_s_ = measured.time_s;
        has_number_ = true;
        constexpr int kKnown = usb::Faults::kKnown | device::BoardFaults::kPressed;
        require((measured.faults.bits & ~kKnown) == 0, "an unknown fault");
    }

    void write(std::uint8_t form) {
        device::DeviceCommand command;
        command.mode = static_cast<device::CommandMode>(form % 3);
        command.resets_faults = (form & 4U) != 0;
        command.number = (form & 8U) != 0 ? input_.u32() : number_;
        if ((form & 16U) != 0) {
            for (int i = 0; i < 3; ++i) {
                command.e_W_V[i] = 0.2 * input_.signed_byte();
                command.cancelled_resistance_Ohm[i] = 0.03 * input_.signed_byte();
            }
        }
        device_->write(command);
    }

    /// Also those that only some boards have.
    double period_s() { return 1e-6 * (125.0 + 10.0 * input_.u16() / 13.0); }

    void set_period() {
        const double requested_s = period_s();
        device_->set_period(requested_s);
        period_s_ = requested_s;
    }

    void look() const {
        const auto link = device_->link();
        require(link.has_value(), "no link");
        require_one_line(link->speed);
        require_one_line(link->board_state);
        require(link->last_problem.find('\n') == std::string::npos, "a problem of several lines");
        require(std::isfinite(device_->delay_periods()) && device_->delay_periods() > 0.0,
                "a delay that is none");
        const device::DeviceIdentity identity = device_->identity();
        require_one_line(identity.firmware);
        require(identity.serial.empty() || identity.serial.size() <= usb::kSerialSize,
                "no serial number");
    }

    /// The servo's limits have to remain usable.
    void check_description() const {
        const device::DeviceDescription &description = device_->description();
        require(description.amplifier.max_cancelled_Ohm >= 0.0, "a negative bound of R̂");
        for (const device::MotorParameters &motor : description.motor) {
            require(motor.supply_V > 0.0 && motor.peak_current_A > 0.0, "a limit that is none");
        }
    }

    /// With the first commands, each of which may wait for its report.
    [[nodiscard]] double connecting_s() const { return 2.5 + 40.0 * 3.0 * period_s_; }

    void require_time(double begin_s, double max_s) const {
        require(port_->now_s() - begin_s <= max_s, "waits for too long");
    }

    FuzzInput input_;
    AnsweringPort *port_ = nullptr;
    usb::UsbDevice *device_ = nullptr;
    double period_s_ = 1e-3;
    bool has_number_ = false; ///< a measurement of this connection
    std::uint64_t number_ = 0;
    double time_s_ = 0.0;
};

} // namespace

void take_usb_answers(std::span<const std::uint8_t> input) { DeviceTrial(input).run(); }

} // namespace springdrive::fuzz
