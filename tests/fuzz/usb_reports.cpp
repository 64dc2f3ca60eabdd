// Packets for the driver's stream of reports, and its meter of the delay: numbers and times do not
// go back, everything is counted once, and nothing old passes for new.
#include "base/input_error.h"
#include "device/core/faults.h"
#include "device/usb/driver/report_stream.h"
#include "tests/fuzz/usb_targets.h"

#include <cmath>

namespace springdrive::fuzz {

namespace {

using device::Arrival;
using usb::FrameStatus;
using usb::Kind;

class StreamTrial {
public:
    explicit StreamTrial(std::span<const std::uint8_t> input) : input_(input) {}

    void run() {
        while (input_.has_more()) {
            operate();
        }
        settle();
    }

private:
    void operate() {
        switch (input_.byte() % 8) {
        case 0:
        case 1:
            take_report();
            break;
        case 2:
            take_raw();
            break;
        case 3: // the same packet again
            take(packet_);
            break;
        case 4:
            settle();
            break;
        case 5:
            send();
            break;
        case 6:
            now_s_ += 1e-4 * input_.u16();
            break;
        default:
            stream_.begin();
            is_new_ = false;
            is_repeated_ = false;
            is_corrupt_ = false;
            counted_ = 0;
            break;
        }
    }

    /// A valid report, as a rule the next one.
    void take_report() {
        const std::uint8_t form = input_.byte();
        usb::Report &report = report_;
        report.number += (form & 1U) == 0 ? 1U : step();
        report.measured_at_us += (form & 2U) == 0 ? 1000U : step();
        report.has_command = (form & 4U) != 0;
        report.command_number = sent_ - (form >> 5U);
        report.command_arrived_at_us = report.measured_at_us - ((form & 8U) == 0 ? 300U : step());
        report.applied_after_us = (form & 16U) == 0 ? std::uint16_t{50} : input_.u16();
        const usb::Frame frame = usb::encode(report);
        usb::Packet packet;
        packet.data = frame;
        packet.size = frame.size();
        take(packet);
    }

    std::uint32_t step() {
        const std::int8_t small = input_.signed_byte();
        return small == -128 ? input_.u32() : static_cast<std::uint32_t>(small);
    }

    void take_raw() {
        const std::uint8_t form = input_.byte();
        usb::Packet packet;
        const std::vector<std::uint8_t> bytes = input_.bytes(packet.data.size());
        std::ranges::copy(bytes, packet.data.begin());
        packet.size = (form & 1U) != 0 ? bytes.size() : packet.data.size();
        if ((form & 2U) != 0) {
            seal(packet.data, Kind::report);
        }
        take(packet);
    }

    void take(usb::Packet packet) {
        packet_ = packet;
        packet_.arrived_s = now_s_;
        usb::Report report;
        const bool is_valid = decoded_and_encoded(std::span(packet_.data).first(packet_.size),
                                                  report) == FrameStatus::ok;
        const bool had_report = stream_.has_report();
        const std::uint64_t number = stream_.number();
        const double measured_s = stream_.measured_s();
        const bool is_new = stream_.take(packet_);
        require(is_valid || !is_new, "takes an invalid packet");
        if (is_new) {
            require(!had_report || stream_.number() > number, "the newest number goes back");
            require(!had_report || stream_.measured_s() >= measured_s,
                    "the time of the newest report goes back");
            first_number_ = had_report ? first_number_ : stream_.number();
            require(static_cast<std::uint32_t>(stream_.number()) == report.number,
                    "another number than the report's");
            measure(report);
        } else {
            require(stream_.number() == number && stream_.measured_s() == measured_s,
                    "a packet that is not taken has an effect");
        }
        note(is_valid, is_new);
    }

    void note(bool is_valid, bool is_new) {
        // After a restart of the board, its reports are not counted.
        counted_ += is_valid && stream_.has_restarted() ? 0U : 1U;
        const usb::StreamCounts &counts = stream_.counts();
        require(counts.reports + counts.repeated + counts.stale + counts.corrupt == counted_,
                "packets that are not counted once");
        require(!stream_.has_report() ||
                    stream_.number() - first_number_ + 1U == counts.reports + counts.lost,
                "numbers that are neither received nor lost");
        is_new_ = is_new_ || is_new;
        is_corrupt_ = is_corrupt_ || !is_valid;
        is_repeated_ = is_repeated_ || (is_valid && !is_new && !stream_.has_restarted());
    }

    void measure(const usb::Report &report) {
        if (const auto round_trip_s = meter_.take(report, packet_.arrived_s)) {
            require(std::isfinite(*round_trip_s) && *round_trip_s > 0.0,
                    "a round trip that takes no time");
            phase_.take(*round_trip_s);
        }
        for (const usb::RecentTimes *times : {&meter_.delay(), &meter_.round_trip()}) {
            require(std::isfinite(times->mean_s()) && times->mean_s() <= times->largest_s() + 1e-6,
                    "a mean beyond the largest");
        }
        require(phase_.report_after_us(0.0, 1e-3) <= 1000, "a phase beyond the period");
    }

    void settle() {
        const Arrival arrival = stream_.settle(now_s_, 1e-3, (input_.byte() & 1U) != 0);
        require(device::is_new(arrival) == is_new_, "old, but passes for new");
        require(is_new_ || arrival == (is_corrupt_    ? Arrival::corrupt
                                       : is_repeated_ ? Arrival::repeated
                                                      : Arrival::absent),
                "arrived otherwise");
        is_new_ = false;
        is_corrupt_ = false;
        is_repeated_ = false;
    }

    void send() {
        const std::uint32_t measured_at_us = report_.measured_at_us - step();
        const bool is_first = (input_.byte() & 1U) != 0;
        meter_.sent(++sent_, measured_at_us, is_first, now_s_);
        require(meter_.has_sent(sent_), "forgets a command");
    }

    FuzzInput input_;
    usb::ReportStream stream_;
    usb::DelayMeter meter_;
    usb::ReportPhase phase_;
    double now_s_ = 1.0;
    usb::Report report_;
    usb::Packet packet_;
    std::uint32_t sent_ = 0;

    std::uint64_t first_number_ = 0;
    std::uint64_t counted_ = 0; ///< packets since the connection
    bool is_new_ = false;       ///< since `settle`
    bool is_repeated_ = false;
    bool is_corrupt_ = false;
};

} // namespace

void take_usb_reports(std::span<const std::uint8_t> input) { StreamTrial(input).run(); }

/// A fault of the emulated board as text: is read with every value in its range, or refused in one
/// line.
void take_usb_fault(std::span<const std::uint8_t> input) {
    std::string text(input.begin(), input.end());
    if (!input.empty() && input[0] < device::kNamedFaults) { // names that need not be guessed
        text.replace(0, 1, device::kFaultNames[input[0]].name);
    }
    try {
        const device::Fault fault = device::parse_fault(text);
        require(text.starts_with(device::name_of(fault.kind)), "another fault than named");
        require(std::isfinite(fault.begin_s) && fault.begin_s >= 0.0 && fault.end_s > fault.begin_s,
                "times out of order");
        require(fault.share >= 0.0 && fault.share <= 1.0, "a share out of range");
        require(fault.periods >= 0.0 && fault.periods <= 1000.0, "periods out of range");
        require(fault.channel < 3 && fault.other_channel < 3, "a channel that does not exist");
        require(fault.kind != device::FaultKind::brown_out ||
                    (fault.size[0] >= 0.0 && fault.size[0] <= 100.0),
                "a voltage out of range");
        require(fault.kind != device::FaultKind::hot_stage ||
                    (fault.size[0] >= -50.0 && fault.size[0] <= 300.0),
                "a temperature out of range");
    } catch (const InputError &error) {
        require_one_line(error.what());
    }
}

} // namespace springdrive::fuzz
