// A fault of the emulated board as text: is read with every value in its range, or refused in one
// line.
#include "base/input_error.h"
#include "device/core/faults.h"
#include "tests/fuzz/usb_targets.h"

#include <cmath>

namespace springdrive::fuzz {

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
