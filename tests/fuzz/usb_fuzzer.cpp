// What libFuzzer calls with one input after the other: a target for the USB board's protocol
// (usb_targets.h), which SPRINGDRIVE_PARSER names; see tests/fuzz/run.
#include "tests/fuzz/usb_targets.h"

#include <cstdio>
#include <cstdlib>

namespace {

using springdrive::fuzz::kUsbTargets;
using springdrive::fuzz::UsbTarget;

[[nodiscard]] const UsbTarget &choose() {
    const char *const variable = std::getenv("SPRINGDRIVE_PARSER");
    const std::string_view name = variable == nullptr ? "" : variable;
    const auto *const found = std::ranges::find(kUsbTargets, name, &UsbTarget::name);
    if (found == kUsbTargets.end()) {
        std::fputs("SPRINGDRIVE_PARSER has to name a target for USB, see usb_targets.h\n", stderr);
        std::exit(2);
    }
    return *found;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    static const UsbTarget &chosen = choose();
    chosen.take({data, size});
    return 0;
}
