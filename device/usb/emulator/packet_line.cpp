#include "device/usb/emulator/packet_line.h"

#include "base/split_mix.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace springdrive::emulator {

using device::Fault;
using device::FaultKind;

/// Uniform but for 2^-50 of it, and the same on every machine: the standard's distributions are
/// not.
std::uint64_t PacketLine::below(std::uint64_t bound) { return (random_() >> 11U) % bound; }

/// Draws whatever the outcome, so that one fault does not change when another one strikes.
bool PacketLine::strikes(const Fault &fault) {
    const double drawn = split_mix::unit_share(random_());
    const bool does = fault.kind == FaultKind::stall ||
                      (fault.packet != 0 ? fault.packet == packets_ : drawn < fault.share);
    counts_[static_cast<std::size_t>(fault.kind)] += does ? 1U : 0U;
    return does;
}

void PacketLine::flip_bits(Packet &packet) {
    if (packet.size == 0) {
        return;
    }
    // Distinct bits, so that none is flipped back.
    const std::uint64_t bits = 8 * packet.size;
    const std::uint64_t count = 1 + below(3);
    const std::uint64_t first = below(bits);
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t bit = (first + i * (1 + bits / 5)) % bits;
        packet.bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    }
}

void PacketLine::insert(const Packet &packet) {
    const auto place = std::ranges::upper_bound(queue_, packet.due_loop, {}, &Packet::due_loop);
    queue_.insert(place, packet);
}

void PacketLine::put(Packet packet, std::span<const Fault> faults, double period_loops) {
    ++packets_;
    bool is_lost = false;
    bool is_held = false;
    std::size_t copies = 1;
    double delay_periods = 0.0;
    for (const Fault &fault : faults) {
        if (!device::is_of_packets(fault.kind) || fault.direction != direction_ ||
            !strikes(fault)) {
            continue;
        }
        switch (fault.kind) {
        case FaultKind::delay:
            delay_periods += fault.periods;
            break;
        case FaultKind::reorder:
            is_held = true;
            break;
        case FaultKind::corrupt:
            flip_bits(packet);
            break;
        case FaultKind::repeat:
            ++copies;
            break;
        case FaultKind::truncate:
            if (packet.size > 1) {
                packet.size = 1 + below(packet.size - 1);
            }
            break;
        default: // drop, stall
            is_lost = true;
            break;
        }
    }
    if (is_lost) {
        return;
    }
    if (delay_periods > 0.0) {
        packet.due_loop += static_cast<std::uint64_t>(std::llround(delay_periods * period_loops));
    } else {
        packet.due_loop = std::max(packet.due_loop, last_due_loop_);
        last_due_loop_ = packet.due_loop;
    }
    if (is_held && !held_) {
        held_ = packet;
        return;
    }
    for (std::size_t i = 0; i < copies; ++i) {
        insert(packet);
    }
    if (held_) {
        held_->due_loop = std::max(held_->due_loop, packet.due_loop);
        insert(*std::exchange(held_, std::nullopt));
    }
}

std::optional<Packet> PacketLine::take(std::uint64_t now_loop) {
    if (queue_.empty() || queue_.front().due_loop > now_loop) {
        return std::nullopt;
    }
    const Packet packet = queue_.front();
    queue_.erase(queue_.begin());
    return packet;
}

void PacketLine::clear() {
    queue_.clear();
    held_.reset();
    last_due_loop_ = 0;
}

} // namespace springdrive::emulator
