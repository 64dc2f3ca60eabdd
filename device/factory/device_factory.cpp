#include "device/factory/device_factory.h"

#include "base/input_error.h"
#include "device/core/device_file.h"
#include "device/simulated/simulated_phantom.h"
#include "device/usb/driver/board_port.h"
#include "device/usb/driver/board_survey.h"
#include "device/usb/driver/usb_device.h"

#include <algorithm>
#include <utility>

namespace springdrive::factory {

namespace {

OpenDevice open_simulated(const DeviceRequest &request) {
    const std::string own_serial = simulated::simulated_identity().serial;
    const std::string serial = simulated::simulated_identity(request.simulation.device_seed).serial;
    if (!request.serial.empty() && request.serial != own_serial && request.serial != serial) {
        throw InputError("there is no simulated device with the serial number '" + request.serial +
                         "'; the only one is '" + own_serial + "'");
    }
    device::require_calibration_of(request.description, serial);
    simulated::SimulationOptions options = request.simulation;
    options.servo_period_s = request.period_s;
    auto phantom = std::make_unique<simulated::SimulatedPhantom>(request.description, options,
                                                                 request.start_tip_m);
    simulated::SimulatedWorld *const world = phantom.get();
    return {std::move(phantom), world};
}

OpenDevice open_usb(const DeviceRequest &request) {
    auto device = std::make_unique<usb::UsbDevice>(
        usb::make_libusb_port(), request.description, request.serial, request.period_s,
        request.has_clock ? usb::Pacing::clock : usb::Pacing::reports);
    use_calibration(*device);
    return OpenDevice(std::move(device));
}

OpenDevice open_emulated(const DeviceRequest &request) {
    const std::string serial = emulated_serial(request.simulation.device_seed);
    if (!request.serial.empty() && request.serial != kEmulatedSerial && request.serial != serial) {
        throw InputError("there is no emulated device with the serial number '" + request.serial +
                         "'; the only one is '" + kEmulatedSerial + "'");
    }
    device::require_calibration_of(request.description, serial);
    return OpenDevice(std::make_unique<EmulatedDevice>(request.description, request.period_s,
                                                       request.emulation, request.simulation));
}

} // namespace

void use_calibration(usb::UsbDevice &device) {
    const std::string serial = device.identity().serial;
    device::require_calibration_of(device.description(), serial);
    if (device.description().calibration) {
        return;
    }
    const std::optional<device::Calibration> stored = device.bench()->stored_calibration();
    if (!stored) {
        return;
    }
    if (const std::string wrong = device::validate(*stored, device.description()); !wrong.empty()) {
        throw InputError("the USB board " + serial + ": of its stored calibration, " + wrong +
                         "; use the device file of this machine, or calibrate it again: "
                         "springdrive device calibrate --to-board");
    }
    device.take_calibration(*stored);
}

std::optional<DeviceKind> device_kind_named(std::string_view name) {
    const auto *const found = std::ranges::find(kDeviceKindNames, name);
    if (found == kDeviceKindNames.end()) {
        return std::nullopt;
    }
    return static_cast<DeviceKind>(found - kDeviceKindNames.begin());
}

OpenDevice::OpenDevice(std::unique_ptr<device::HapticDevice> device,
                       simulated::SimulatedWorld *world)
    : device_(std::move(device)), world_(world), hand_(world) {}

OpenDevice::OpenDevice(std::unique_ptr<EmulatedDevice> device)
    : world_(nullptr), hand_(&device->hand()), emulated_(device.get()) {
    device_ = std::move(device);
}

OpenDevice::OpenDevice(std::unique_ptr<usb::UsbDevice> device)
    : world_(nullptr), hand_(nullptr), usb_(device.get()) {
    device_ = std::move(device);
}

OpenDevice::~OpenDevice() { close(); }

OpenDevice &OpenDevice::operator=(OpenDevice &&other) noexcept {
    close();
    device_ = std::move(other.device_);
    world_ = other.world_;
    hand_ = other.hand_;
    emulated_ = other.emulated_;
    usb_ = other.usb_;
    is_closed_ = other.is_closed_;
    return *this;
}

DeviceState OpenDevice::state() const {
    return is_closed_             ? DeviceState::closed
           : device_->is_zeroed() ? DeviceState::zeroed
                                  : DeviceState::open;
}

void OpenDevice::take_calibration(const device::Calibration &calibration) {
    device::DeviceDescription calibrated = device_->description();
    calibrated.calibration = calibration;
    device::require_calibration_of(calibrated, identity().serial);
    if (const std::string wrong = device::validate(calibration, calibrated); !wrong.empty()) {
        throw InputError("of the calibration, " + wrong + "; calibrate the device again");
    }
    if (emulated_ != nullptr) {
        emulated_->take_calibration(calibration);
    } else if (usb_ != nullptr) {
        usb_->take_calibration(calibration);
    } else {
        throw InputError(calibrated.name + " has no board: its calibration is that of its device "
                                           "file");
    }
}

void OpenDevice::zero(const Vector3 &theta_rad) {
    if (is_closed_) {
        throw InputError(device_->description().name +
                         " is closed and cannot be zeroed; connect it again");
    }
    device_->zero(theta_rad);
}

void OpenDevice::close() noexcept {
    if (device_ && !is_closed_) {
        device_->close();
        is_closed_ = true;
    }
}

void OpenDevice::reconnect() {
    close();
    device_->reconnect();
    is_closed_ = false;
}

OpenDevice open_device(const DeviceRequest &request) {
    switch (request.kind) {
    case DeviceKind::simulated:
        return open_simulated(request);
    case DeviceKind::emulated:
        return open_emulated(request);
    case DeviceKind::usb:
        break;
    }
    return open_usb(request);
}

std::vector<PresentDevice> devices_present() {
    std::vector<PresentDevice> present{
        {DeviceKind::simulated, simulated::simulated_identity().serial, ""},
        {DeviceKind::emulated, kEmulatedSerial, ""}};
    for (usb::FoundBoard &board : usb::boards_present()) {
        present.push_back({DeviceKind::usb, std::move(board.serial), std::move(board.problem)});
    }
    return present;
}

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
