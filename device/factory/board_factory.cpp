#include "device/factory/board_factory.h"

#include "device/factory/in_process_port.h"
#include "device/usb/driver/libusb_port.h"
#include "device/usb/driver/usb_device.h"

#include <utility>

namespace springdrive::factory {

OpenBoard open_board(const BoardRequest &request) {
    OpenBoard board;
    std::unique_ptr<usb::BoardPort> port;
    if (request.kind != DeviceKind::usb) {
        board.emulated =
            std::make_unique<emulator::EmulatedBoard>(request.truth, request.emulation);
        port = std::make_unique<InProcessPort>(*board.emulated);
    } else {
        port = usb::make_libusb_port();
    }
    device::DeviceDescription description = request.description;
    if (request.ignores_calibration) {
        description.calibration.reset();
    }
    auto device = std::make_unique<usb::UsbDevice>(std::move(port), description, request.serial,
                                                   request.period_s, usb::Pacing::reports,
                                                   request.watchdog_periods);
    if (!request.ignores_calibration) {
        use_calibration(*device);
    }
    board.device = std::move(device);
    return board;
}

} // namespace springdrive::factory
