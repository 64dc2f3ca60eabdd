// A board with a simulated PHANTOM behind it, as a USB peripheral: the firmware's core, its plant,
// a link that can fail, and time.
//
//   put ──► faults ──► Board ◄──► EmulatedPlant          one loop of the amplifiers after the other
//   take ◄── faults ◄──┘
//
// Time passes by one of two clocks:
//
// - Frame clock: with packets only, so that a run does not depend on the host's timing, and d is
//   imposed. After `attach` one report is permitted, and one more with each packet. `take` runs the
//   loop to the next report. A packet that was put after a report was taken is applied d periods
//   after that report was measured, to within a loop. So a host should answer each report by one
//   packet, and leave the reports' phase as it is: then reports are equidistant.
//   A host that has been silent for kSilence_s of wall time no longer stops time: it then passes by
//   the wall clock, so that the watchdog acts, and one report is permitted each kSilence_s. Each of
//   these stands for that of a later packet: it is one ahead of the host's answers.
// - Wall clock: `pass` runs the loops that are due, packets arrive when they are put, and `take`
//   gives the newest report, once. What the machine is too slow for is lost: `late_s`.
//
// Detached, time passes by the wall clock in both.
#pragma once

#include "device/core/faults.h"
#include "device/usb/emulator/emulated_plant.h"
#include "device/usb/emulator/peripheral.h"
#include "device/usb/protocol.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <string_view>
#include <vector>

namespace springdrive::emulator {

/// Without memory of its own, as a servo's thread may put and take packets.
struct Packet {
    static constexpr std::size_t kMax = 2 * usb::kFrameSize; ///< one too large is cut to this

    std::array<std::uint8_t, kMax> bytes{};
    std::size_t size = 0;
    std::uint64_t due_loop = 0;      ///< it arrives once this loop has run
    std::uint64_t measured_loop = 0; ///< of a report

    Packet() = default;
    Packet(std::span<const std::uint8_t> data, std::uint64_t due, std::uint64_t measured)
        : size(std::min(data.size(), kMax)), due_loop(due), measured_loop(measured) {
        std::copy_n(data.begin(), size, bytes.begin());
    }

    [[nodiscard]] std::span<const std::uint8_t> data() const {
        return std::span(bytes).first(size);
    }
};

/// How often each fault happened to a packet.
using FaultCounts = std::array<std::uint64_t, device::kNamedFaults>;

/// One direction of an emulated link: packets in the order in which they arrive, and what faults
/// make of them.
///
/// The same packets and faults give the same result for the same seed. Allocates only for more
/// packets under way than kUsual.
class PacketLine {
public:
    static constexpr std::size_t kUsual = 64;

    PacketLine(device::Direction direction, std::uint64_t seed)
        : direction_(direction), random_(seed) {
        queue_.reserve(kUsual);
    }

    /// @param faults  that act now, of any kind and direction
    /// @param period_loops  T, for delays
    void put(Packet packet, std::span<const device::Fault> faults, double period_loops);

    /// The next packet that has arrived by now.
    [[nodiscard]] std::optional<Packet> take(std::uint64_t now_loop);

    /// Loses what is under way.
    void clear();

    /// How many packets were put.
    [[nodiscard]] std::uint64_t packets() const { return packets_; }
    [[nodiscard]] const FaultCounts &faults() const { return counts_; }

private:
    [[nodiscard]] bool strikes(const device::Fault &fault);
    void flip_bits(Packet &packet);
    void insert(const Packet &packet);
    [[nodiscard]] std::uint64_t below(std::uint64_t bound);

    device::Direction direction_;
    std::mt19937_64 random_;
    std::uint64_t packets_ = 0;
    std::uint64_t last_due_loop_ = 0; ///< of packets without a delay, which cannot overtake
    std::vector<Packet> queue_;       ///< by due_loop; equal ones in the order they were put
    std::optional<Packet> held_;      ///< until the next one has passed
    FaultCounts counts_{};
};

enum class BoardClock : std::uint8_t { frame, wall };

/// @param serial  printable ASCII, at most usb::kSerialSize characters
/// @throw InputError for another one
[[nodiscard]] usb::Identity emulated_identity(std::string_view serial);

struct EmulatedBoardOptions {
    board::BoardSettings settings;
    usb::Identity identity = emulated_identity("emulated");
    /// Effects, hand and its path; servo period and delay are the board's.
    simulated::SimulationOptions simulation;
    std::optional<Vector3> start_tip_m; ///< without: the centre of the workspace
    BoardClock clock = BoardClock::frame;
    double delay_periods = 0.3; ///< d by the frame clock, in periods of reports
    std::vector<device::Fault> faults;
    std::uint64_t seed = 1; ///< of faults that strike at random
    /// Board time at power-up: near 2^32, it soon begins again at 0.
    std::uint32_t start_us = 0;
};

class EmulatedBoard final : public Peripheral {
public:
    static constexpr double kMaxDelay_periods = 8.0;
    static constexpr double kSilence_s = 0.1;
    /// In one call of `pass`; the machine has been too slow for the rest.
    static constexpr double kMaxStep_s = 0.01;
    /// With a lower supply, the board itself is off.
    static constexpr double kMinLogicSupply_V = 6.0;

    /// Powers up: runs until the current sensors' offsets are measured.
    /// @throw InputError for options that are out of range
    EmulatedBoard(const device::DeviceDescription &description,
                  const EmulatedBoardOptions &options);

    void put(std::span<const std::uint8_t> packet) override;
    std::size_t take(usb::Frame &packet) override;
    bool control_out(std::uint8_t request, std::uint16_t value,
                     std::span<const std::uint8_t> payload) override;
    std::size_t control_in(std::uint8_t request, std::uint16_t value,
                           std::span<std::uint8_t> payload) override;
    void attach(bool is_high_speed) override;
    void detach() override;
    double pass(double elapsed_s) override;

    void set_fault(const device::Fault &fault);
    /// What is damaged is whole again; what the board has latched remains.
    void clear_faults();
    /// Whether whoever holds the device shall have it unplugged now: by a fault, or as the board
    /// is off.
    [[nodiscard]] bool unplug_requested() const { return is_unplug_requested_ || !is_powered_; }

    /// d that the frame clock imposes at least, in present periods: a packet that is put after a
    /// report is seen by the next loop, and applied half a loop later.
    [[nodiscard]] double min_delay_periods() const;
    /// Of reports, as requested last [s].
    [[nodiscard]] double period_s() const { return 1e-6 * static_cast<double>(period_us_); }

    /// Time since the construction, in whole loops.
    [[nodiscard]] double time_s() const {
        return static_cast<double>(plant_.loops()) / options_.settings.loop_rate_hz;
    }
    /// By which the board's time has fallen behind the wall clock.
    [[nodiscard]] double late_s() const { return late_s_; }
    [[nodiscard]] std::uint32_t restarts() const { return restarts_; }
    [[nodiscard]] const PacketLine &line(device::Direction direction) const {
        return direction == device::Direction::in ? in_ : out_;
    }
    [[nodiscard]] const board::Board &board() const { return *board_; }
    [[nodiscard]] const EmulatedPlant &plant() const { return plant_; }
    /// Its hand, and its truth.
    [[nodiscard]] simulated::SimulatedPhantom &phantom() { return plant_.phantom(); }

private:
    [[nodiscard]] std::uint64_t arrival_loop() const;
    [[nodiscard]] double period_loops() const;
    void power_up();
    void run_loop();
    void run_owed();
    void run_to_report();
    bool collect_report();
    void update_faults();
    void set_power(bool is_powered);

    EmulatedBoardOptions options_;
    EmulatedPlant plant_;
    std::optional<board::Board> board_;
    PacketLine in_;
    PacketLine out_;

    bool is_attached_ = false;
    bool is_high_speed_ = true;
    std::uint32_t period_us_ = 1000;
    std::uint64_t permitted_ = 0;  ///< reports, by the frame clock
    bool offers_report_ = false;   ///< to a silent host
    std::uint64_t ahead_ = 0;      ///< reports that it was offered so, each for a later packet
    std::uint64_t taken_loop_ = 0; ///< when the report that was taken last was measured
    double silence_s_ = 0.0;       ///< since the last packet
    double owed_s_ = 0.0;          ///< of the wall clock, less than a loop after `pass`
    double late_s_ = 0.0;

    bool is_unplug_requested_ = false;
    bool is_powered_ = true;
    std::uint32_t restarts_ = 0;
};

} // namespace springdrive::emulator
