// A USB device that this computer plays itself: a peripheral behind a device controller of Linux,
// by configfs and FunctionFS. The controller may be the virtual one of the module dummy_hcd, which
// the same kernel sees as its host, or a real one, as single-board computers have.
//
// What Linux decides, not the peripheral:
//  - The data of a control request to the device are acknowledged once they have been read, before
//    the peripheral can judge them. Only `GadgetOptions::takes_out` can still have it stalled.
//  - One packet for the host is already with the controller (with dummy_hcd, two), and remains,
//    however long the host takes to collect it.
#pragma once

#include "device/usb/emulator/peripheral.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace springdrive::emulator {

struct GadgetOptions {
    std::string serial = "0"; ///< by which a host tells devices apart
    std::string product = "springdrive emulator";
    std::string controller;           ///< a name in /sys/class/udc; empty: the first
    std::string name = "springdrive"; ///< in configfs; one running gadget has it
    bool is_high_speed = true;        ///< false: full speed even if the controller allows more

    /// Asked before the data of a control request are read, on the thread of control requests and
    /// as the only user of the peripheral; false: it is stalled. Empty: all are read.
    std::function<bool(std::uint8_t request, std::uint16_t value, std::size_t size)> takes_out;
};

/// From the constructor to the destructor, two threads use the peripheral, never both at once:
/// `run`'s caller for packets and time, and one of the gadget's own for the host's requests and for
/// plugging. What the peripheral throws on the latter is thrown by `run`.
class Gadget {
public:
    /// Creates the device, unplugged, after removing what a killed run left under the same name.
    /// @throw InputError if not root; without configfs, FunctionFS or a device controller; if the
    ///     name is in use
    Gadget(Peripheral &peripheral, const GadgetOptions &options);
    Gadget(const Gadget &) = delete;
    Gadget &operator=(const Gadget &) = delete;
    /// Unplugs the device and removes it.
    ~Gadget();

    // From any thread but within a call of the peripheral; also while another one is inside `run`.

    /// The host then sees the device. @throw InputError if another gadget has the controller
    void plug_in();
    /// May be called twice. The peripheral is detached when it returns.
    void unplug();

    /// Ends when `until`, which is asked after whatever happened, and at least every 5 ms, says so.
    void run(const std::function<bool()> &until);
    /// Has `until` asked at once. Also from a signal's handler.
    void wake() noexcept;

    /// In /sys/class/udc.
    [[nodiscard]] std::string_view controller() const;
    /// Control requests that the peripheral refused, but whose data Linux had acknowledged.
    [[nodiscard]] std::uint64_t refused_too_late() const;

private:
    class Implementation;
    std::unique_ptr<Implementation> implementation_;
};

} // namespace springdrive::emulator
