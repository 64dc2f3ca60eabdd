// One direction of an emulated link: packets in the order in which they arrive, and what faults
// make of them.
#pragma once

#include "device/core/faults.h"
#include "device/usb/protocol.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <random>
#include <span>
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

} // namespace springdrive::emulator
